//! The persistence diagram: a dot for each cycle, the selected gaps shaded, the picked cycle highlighted.
//!
//! In: dots, a frame, the picked cycle.
//! Out: pixels; the dot under a pointer.
//! Invariants: the cycles of the view are those outside of the shades. All numbers are the daemon's, except for the far
//! sides of gaps, which are computed here.
//! Must not know: the plane, messages.

import { clearedContext, ticks } from "../drawing/canvas.js";
import { colorOf, palette, withAlpha } from "../drawing/colors.js";
import { isPicked } from "../drawing/picking.js";
import { formatNumber } from "./numbers.js";

const LEFT = 40;
const BOTTOM = 30;
const TOP = 10;
const RIGHT = 10;
/** How near to a dot a pointer must be, in pixels. */
const PICK_RADIUS = 14;
/** Up to so many cycles of the view all have a large dot. */
const MAX_LARGE = 200;

export class Diagram {
  /** @param {HTMLCanvasElement} canvas @param {import("../drawing/picking.js").TracksByLabel} tracksByLabel */
  constructor(canvas, tracksByLabel) {
    this.canvas = canvas;
    this.tracksByLabel = tracksByLabel;
    /** The largest scale on the axes. */
    this.largest = 0;
    /** Birth and death of each dot in turn, the most persistent first. */
    this.dots = new Float64Array(0);
  }

  /** Draws the diagram of a frame. */
  draw(frame, { total, labels: dots }, pick) {
    const cleared = clearedContext(this.canvas);
    if (!cleared) return;
    this.dots = dots;
    Object.assign(this, cleared);
    this.scaleAxes(dots);
    const { context } = this;
    context.save();
    context.beginPath();
    context.rect(LEFT, TOP, this.width - LEFT - RIGHT, this.height - TOP - BOTTOM);
    context.clip();
    if (frame) this.shade(frame, dots, total);
    this.drawDots(frame, pick);
    context.restore();
    this.drawAxes();
  }

  /** Lets the axes follow the dots, with hysteresis. */
  scaleAxes(dots) {
    let largest = 0;
    for (let at = 1; at < dots.length; at += 2) largest = Math.max(largest, 1.06 * dots[at]);
    if (largest > this.largest || largest < 0.7 * this.largest) this.largest = largest || 1;
  }

  x(birth) {
    return LEFT + (birth / this.largest) * (this.width - LEFT - RIGHT);
  }

  y(death) {
    return this.height - BOTTOM - (death / this.largest) * (this.height - TOP - BOTTOM);
  }

  shade(frame, dots, total) {
    const cut = frame.view.cut;
    if (cut.Derived) {
      const { diagonal, vertical } = gapsOf(frame, dots, total);
      if (diagonal) this.shadeDiagonal(diagonal);
      if (vertical) this.shadeVertical(vertical, frame.ds);
    } else if (cut.Reduced !== undefined) {
      this.shadeScale(cut.Reduced);
    }
  }

  /** Shades a strip along the diagonal: a range of persistences. */
  shadeDiagonal([low, high]) {
    const far = this.largest;
    this.fill(withAlpha(palette.diagonal, 0.22), [
      [0, low],
      [far, far + low],
      [far, far + high],
      [0, high],
    ]);
    this.line(palette.diagonal.css, [
      [0, high],
      [far, far + high],
    ]);
  }

  /** Shades an upright strip above the diagonal gap: a range of births. */
  shadeVertical([low, high], ds) {
    const right = Math.min(high, this.largest);
    const top = Math.max(this.largest, right + ds);
    this.fill(withAlpha(palette.vertical, 0.17), [
      [low, low + ds],
      [right, right + ds],
      [right, top],
      [low, top],
    ]);
    this.line(palette.vertical.css, [
      [low, low + ds],
      [low, top],
    ]);
  }

  /** Shades the cycles of a reduced view: born up to its scale, and dying above it. */
  shadeScale(alpha) {
    this.fill(withAlpha(palette.vertical, 0.14), [
      [0, alpha],
      [alpha, alpha],
      [alpha, this.largest],
      [0, this.largest],
    ]);
    this.line(palette.vertical.css, [
      [0, alpha],
      [alpha, alpha],
      [alpha, this.largest],
    ]);
  }

  path(points) {
    const { context } = this;
    context.beginPath();
    for (const [birth, death] of points) context.lineTo(this.x(birth), this.y(death));
  }

  fill(style, points) {
    this.path(points);
    this.context.fillStyle = style;
    this.context.fill();
  }

  line(style, points) {
    this.path(points);
    this.context.strokeStyle = style;
    this.context.stroke();
  }

  /** Draws dots, the most persistent last, so that they are on top. */
  drawDots(frame, pick) {
    const { context } = this;
    const isLarge = frame !== null && frame.cycles <= MAX_LARGE;
    for (let at = this.dots.length - 2; at >= 0; at -= 2) {
      const [birth, death] = [this.dots[at], this.dots[at + 1]];
      const track = this.tracksByLabel.find(birth, death);
      const shown = isShown(frame, birth, death);
      const picked = isPicked(pick, track?.id ?? null, birth, death);
      context.fillStyle = track ? colorOf(track.id).css : shown ? palette.critical.css : withAlpha(palette.muted, 0.55);
      const radius = picked ? 7 : track || (shown && isLarge) ? 4 : shown ? 2.4 : 1.6;
      context.beginPath();
      context.arc(this.x(birth), this.y(death), radius, 0, 7);
      context.fill();
      if (!picked) continue;
      context.strokeStyle = palette.ink.css;
      context.stroke();
    }
  }

  drawAxes() {
    const { context, width, height } = this;
    this.line(palette.muted.css, [
      [0, this.largest],
      [0, 0],
      [this.largest, 0],
    ]);
    this.line(withAlpha(palette.muted, 0.6), [
      [0, 0],
      [this.largest, this.largest],
    ]);
    context.fillStyle = palette.muted.css;
    context.textAlign = "center";
    for (const tick of ticks(this.largest, Math.max(2, width / 90))) {
      if (this.x(tick) < width - 24) context.fillText(formatNumber(tick), this.x(tick), height - BOTTOM + 13);
    }
    context.fillText("birth", (LEFT + width - RIGHT) / 2, height - 4);
    context.textAlign = "right";
    for (const tick of ticks(this.largest, Math.max(2, height / 60)).slice(1))
      context.fillText(formatNumber(tick), LEFT - 5, this.y(tick) + 4);
    context.save();
    context.translate(10, (TOP + height - BOTTOM) / 2);
    context.rotate(-Math.PI / 2);
    context.textAlign = "center";
    context.fillText("death", 0, 0);
    context.restore();
  }

  /** The cycle of the dot nearest to a position of the canvas. */
  pickAt(left, top) {
    if (!this.width) return null;
    let [best, nearest] = [-1, PICK_RADIUS * PICK_RADIUS];
    for (let at = 0; at < this.dots.length; at += 2) {
      const distance = (this.x(this.dots[at]) - left) ** 2 + (this.y(this.dots[at + 1]) - top) ** 2;
      if (distance < nearest) [best, nearest] = [at, distance];
    }
    return best < 0 ? null : this.tracksByLabel.pick(this.dots[best], this.dots[best + 1]);
  }
}

/** Whether a cycle is part of the view. */
function isShown(frame, birth, death) {
  if (!frame) return false;
  const { Derived, Reduced } = frame.view.cut;
  if (Derived) return frame.ds !== null && death - birth >= frame.ds && birth <= (frame.vs ?? Infinity);
  return Reduced === undefined || (death > Reduced && birth <= Reduced);
}

/**
 * The selected gaps of a derived view: below `ds` and right of `vs`. Their far sides are the next smaller persistence,
 * and the next birth of a dot above `ds`. Where only the most persistent dots are known, the diagonal gap ends at the
 * least persistent of them.
 */
export function gapsOf({ ds, vs }, dots, total) {
  if (ds === null) return { diagonal: null, vertical: null };
  const last = dots.length - 2;
  let low = last >= 0 && dots.length / 2 < total ? dots[last + 1] - dots[last] : 0;
  let next = Infinity;
  for (let at = 0; at < dots.length; at += 2) {
    const [birth, death] = [dots[at], dots[at + 1]];
    const isAbove = death - birth >= ds;
    if (!isAbove) low = Math.max(low, death - birth);
    else if (vs !== null && birth > vs) next = Math.min(next, birth);
  }
  return { diagonal: [Math.min(low, ds), ds], vertical: vs === null ? null : [vs, next] };
}
