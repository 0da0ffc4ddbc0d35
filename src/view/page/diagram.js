//! The persistence diagram: a dot for each cycle, the chosen gaps shaded, linked with the plane by what is meant.
//!
//! In: dots, a frame, what is meant. Out: pixels, and which dot is under a pointer. Invariants: what the view shows
//! is what the shades leave over; nothing is computed that the daemon has not said, but for the far sides of gaps.
//! Must not know: the plane, messages.

import { contextOf, short, ticks } from "./canvas.js";
import { colorOf, faded, palette } from "./colors.js";
import { isMeant } from "./cycles.js";

const LEFT = 40;
const BOTTOM = 30;
const TOP = 10;
const RIGHT = 10;
const REACH = 14;
/** So many cycles in the view are all worth a large dot. */
const FEW = 200;

export class Diagram {
  /** @param {HTMLCanvasElement} canvas @param {import("./cycles.js").Labels} labels */
  constructor(canvas, labels) {
    this.canvas = canvas;
    this.labels = labels;
    /** The largest scale shown. */
    this.largest = 0;
    /** Birth and death of each dot in turn, the most persistent first. */
    this.dots = new Float64Array(0);
  }

  /** Draws the diagram of a frame. */
  draw(frame, { total, labels: dots }, hit) {
    const context = contextOf(this.canvas);
    if (!context) return;
    this.dots = dots;
    Object.assign(this, context);
    this.scale(dots);
    const { to } = this;
    to.save();
    to.beginPath();
    to.rect(LEFT, TOP, this.width - LEFT - RIGHT, this.height - TOP - BOTTOM);
    to.clip();
    if (frame) this.shade(frame, dots, total);
    this.drawDots(frame, hit);
    to.restore();
    this.drawAxes();
  }

  /** Lets the axes follow the dots, not at every breath of theirs. */
  scale(dots) {
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

  /** A strip along the diagonal: persistences from one to another. */
  shadeDiagonal([low, high]) {
    const far = this.largest;
    this.fill(faded(palette.diagonal, 0.22), [
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

  /** A strip upright, above the diagonal gap: births from one to another. */
  shadeVertical([low, high], ds) {
    const right = Math.min(high, this.largest);
    const top = Math.max(this.largest, right + ds);
    this.fill(faded(palette.vertical, 0.17), [
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

  /** The scale of a reduced view: cycles above it live on. */
  shadeScale(alpha) {
    this.fill(faded(palette.vertical, 0.14), [
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

  path(places) {
    const { to } = this;
    to.beginPath();
    for (const [birth, death] of places) to.lineTo(this.x(birth), this.y(death));
  }

  fill(style, places) {
    this.path(places);
    this.to.fillStyle = style;
    this.to.fill();
  }

  line(style, places) {
    this.path(places);
    this.to.strokeStyle = style;
    this.to.stroke();
  }

  /** Small dots first, so that those that count lie on top. */
  drawDots(frame, hit) {
    const { to } = this;
    const isFew = frame !== null && frame.cycles <= FEW;
    for (let at = this.dots.length - 2; at >= 0; at -= 2) {
      const [birth, death] = [this.dots[at], this.dots[at + 1]];
      const track = this.labels.find(birth, death);
      const shown = isShown(frame, birth, death);
      const meant = isMeant(hit, track?.id ?? null, birth, death);
      to.fillStyle = track ? colorOf(track.id).css : shown ? palette.critical.css : faded(palette.muted, 0.55);
      const radius = meant ? 7 : track || (shown && isFew) ? 4 : shown ? 2.4 : 1.6;
      to.beginPath();
      to.arc(this.x(birth), this.y(death), radius, 0, 7);
      to.fill();
      if (!meant) continue;
      to.strokeStyle = palette.ink.css;
      to.stroke();
    }
  }

  drawAxes() {
    const { to, width, height } = this;
    this.line(palette.muted.css, [
      [0, this.largest],
      [0, 0],
      [this.largest, 0],
    ]);
    this.line(faded(palette.muted, 0.6), [
      [0, 0],
      [this.largest, this.largest],
    ]);
    to.fillStyle = palette.muted.css;
    to.textAlign = "center";
    for (const tick of ticks(this.largest, Math.max(2, width / 90))) {
      if (this.x(tick) < width - 24) to.fillText(short(tick), this.x(tick), height - BOTTOM + 13);
    }
    to.fillText("birth", (LEFT + width - RIGHT) / 2, height - 4);
    to.textAlign = "right";
    for (const tick of ticks(this.largest, Math.max(2, height / 60)).slice(1))
      to.fillText(short(tick), LEFT - 5, this.y(tick) + 4);
    to.save();
    to.translate(10, (TOP + height - BOTTOM) / 2);
    to.rotate(-Math.PI / 2);
    to.textAlign = "center";
    to.fillText("death", 0, 0);
    to.restore();
  }

  /** The cycle of the dot nearest to a point. */
  at(left, top) {
    if (!this.width) return null;
    let [best, nearest] = [-1, REACH * REACH];
    for (let at = 0; at < this.dots.length; at += 2) {
      const distance = (this.x(this.dots[at]) - left) ** 2 + (this.y(this.dots[at + 1]) - top) ** 2;
      if (distance < nearest) [best, nearest] = [at, distance];
    }
    return best < 0 ? null : this.labels.hit(this.dots[best], this.dots[best + 1]);
  }
}

/** Whether the view shows a cycle. */
function isShown(frame, birth, death) {
  if (!frame) return false;
  const { Derived, Reduced } = frame.view.cut;
  if (Derived) return frame.ds !== null && death - birth >= frame.ds && birth <= (frame.vs ?? Infinity);
  return Reduced === undefined || (death > Reduced && birth <= Reduced);
}

/**
 * The chosen gaps of a derived view: below `ds` and right of `vs`. Their far sides are the next persistence, and the next
 * birth of a dot above `ds`; where only the most persistent dots are known, the diagonal gap ends at the least of them.
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
