//! The persistence diagram: a dot for each cycle, crowds as shades, the selected gaps shaded, the picked cycle
//! highlighted.
//!
//! In: a frame and its dots, the picked cycle.
//! Out: pixels; the dot and the number of dots under a pointer.
//! Invariants: both axes have one scale, so that the diagonal rises by 45 degrees. Dots that never die are on a line at
//! the top. The dots drawn as cycles of the view
//! are those that the annotations mark. All numbers are the daemon's, except for the far sides of gaps, which are
//! computed here.
//! Must not know: the plane, messages.

import { clearedContext, ticks } from "../drawing/canvas.js";
import { colorOf, palette, sampleColor, withAlpha } from "../drawing/colors.js";
import { isPicked } from "../drawing/picking.js";
import { Crowds } from "./crowds.js";
import { formatCount, formatNumber } from "./numbers.js";

const LEFT = 44;
const BOTTOM = 32;
const TOP = 10;
const RIGHT = 14;
/** How far below the top the line of dots that never die is, in pixels; how near to it a pointer must be. */
const LINE = 9;
const LINE_REACH = 7;
/** How much larger the axes are than the largest scale, without and with that line. */
const HEADROOM = 1.06;
const LINE_HEADROOM = 1.16;
/** How near to a dot a pointer must be, in pixels. */
const PICK_RADIUS = 14;
/** Up to so many cycles of the view all have a large dot. */
const MAX_LARGE = 200;
/** The legend has room right of the diagonal if the sides have so many pixels. */
const LEGEND_SIDE = 190;

export class Diagram {
  /** @param {HTMLCanvasElement} canvas @param {import("../drawing/picking.js").TracksByLabel} tracksByLabel */
  constructor(canvas, tracksByLabel) {
    this.canvas = canvas;
    this.tracksByLabel = tracksByLabel;
    this.crowds = new Crowds();
    /** The largest scale on the axes, and whether some dots never die. */
    this.largest = 0;
    this.hasImmortals = false;
    /** Birth and death of each dot in turn, the most persistent first. */
    this.dots = new Float64Array(0);
    /** How many dots are drawn as cycles of the view. */
    this.shown = 0;
    /** The frame of the drawn dots. */
    this.frame = null;
    this.side = 0;
  }

  /** Draws the diagram of a frame. @param {import("../session/history.js").Annotations} annotations */
  draw(frame, { dots }, pick) {
    const cleared = clearedContext(this.canvas);
    if (!cleared) return;
    this.dots = dots.labels;
    this.frame = dots.frame;
    Object.assign(this, cleared);
    this.side = Math.max(0, Math.min(this.width - LEFT - RIGHT, this.height - TOP - BOTTOM));
    this.left = LEFT + (this.width - LEFT - RIGHT - this.side) / 2;
    this.bottom = TOP + this.side;
    this.scaleAxes();
    const { context } = this;
    context.save();
    context.beginPath();
    context.rect(this.left, TOP, this.side, this.side);
    context.clip();
    if (frame) this.shade(frame, dots.total);
    if (this.hasImmortals) this.drawLine();
    this.drawDots(frame, dots.isShown, pick);
    context.restore();
    this.drawAxes();
    if (this.side >= LEGEND_SIDE) this.drawLegend();
  }

  /** Lets the axes follow the dots, with hysteresis. */
  scaleAxes() {
    const { highest, hasImmortals } = extentOf(this.dots);
    this.hasImmortals = hasImmortals;
    const largest = (hasImmortals ? LINE_HEADROOM : HEADROOM) * highest;
    if (largest > this.largest || largest < 0.7 * this.largest) this.largest = largest || 1;
  }

  x(birth) {
    return this.left + (birth / this.largest) * this.side;
  }

  y(death) {
    if (death === Infinity) return TOP + LINE;
    return this.bottom - (death / this.largest) * this.side;
  }

  shade(frame, total) {
    const cut = frame.view.cut;
    if (cut.Derived) {
      const { diagonal, vertical } = gapsOf(frame, this.dots, total);
      if (diagonal) this.shadeDiagonal(diagonal);
      if (vertical) this.shadeVertical(vertical, frame.ds);
    } else if (cut.Reduced !== undefined) {
      this.shadeScale(cut.Reduced);
    }
  }

  /** Shades a strip along the diagonal: a range of persistences. */
  shadeDiagonal([low, high]) {
    const far = this.largest;
    this.fill(withAlpha(palette.diagonal, 0.16), [
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
    this.fill(withAlpha(palette.vertical, 0.14), [
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
    this.fill(withAlpha(palette.vertical, 0.12), [
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

  /** Draws crowds of dots, then single dots, the most persistent last, so that they are on top. */
  drawDots(frame, isShown, pick) {
    const { context, dots } = this;
    this.crowds.clear();
    for (let i = 0; i < isShown.length; i++) {
      const isCommon = !isShown[i] && !this.tracksByLabel.find(dots[2 * i], dots[2 * i + 1]);
      this.crowds.add(this.x(dots[2 * i]), this.y(dots[2 * i + 1]), isCommon);
    }
    this.crowds.draw(context, palette.muted);
    const isLarge = frame !== null && frame.cycles <= MAX_LARGE;
    this.shown = 0;
    for (let i = isShown.length - 1; i >= 0; i--) {
      const [birth, death] = [dots[2 * i], dots[2 * i + 1]];
      const track = this.tracksByLabel.find(birth, death);
      const picked = isPicked(pick, track?.id ?? null, birth, death);
      this.shown += isShown[i];
      if (!isShown[i] && !track && !picked && this.crowds.isCrowded(this.x(birth), this.y(death))) continue;
      context.fillStyle = track ? colorOf(track.id).css : isShown[i] ? palette.critical.css : palette.muted.css;
      const radius = picked ? 7 : track || (isShown[i] && isLarge) ? 4.2 : isShown[i] ? 2.4 : 1.6;
      if (track && !isShown[i]) this.hollow(this.x(birth), this.y(death), radius, colorOf(track.id).css);
      else this.disc(this.x(birth), this.y(death), radius);
      if (picked) this.ring(this.x(birth), this.y(death), radius);
    }
  }

  disc(x, y, radius, style = this.context.fillStyle) {
    const { context } = this;
    context.fillStyle = style;
    context.beginPath();
    context.arc(x, y, radius, 0, 7);
    context.fill();
  }

  /** Draws a disc with a hole: a track that is not in the view. */
  hollow(x, y, radius, style) {
    this.disc(x, y, radius, style);
    this.disc(x, y, radius - 1.6, palette.panel.css);
  }

  ring(x, y, radius) {
    const { context } = this;
    context.strokeStyle = palette.ink.css;
    context.beginPath();
    context.arc(x, y, radius, 0, 7);
    context.stroke();
  }

  drawAxes() {
    const { context, side, left, bottom } = this;
    this.line(palette.muted.css, [
      [0, this.largest],
      [0, 0],
      [this.largest, 0],
    ]);
    this.line(withAlpha(palette.muted, 0.8), [
      [0, 0],
      [this.largest, this.largest],
    ]);
    context.fillStyle = palette.muted.css;
    for (const tick of ticks(this.largest, Math.max(2, side / 80))) {
      context.textAlign = "center";
      if (this.x(tick) < left + side - 8 || tick === 0) context.fillText(formatNumber(tick), this.x(tick), bottom + 14);
      context.textAlign = "right";
      const isFree = !this.hasImmortals || this.y(tick) > TOP + 2 * LINE;
      if (tick > 0 && isFree) context.fillText(formatNumber(tick), left - 6, this.y(tick) + 4);
    }
    context.textAlign = "right";
    if (this.hasImmortals) context.fillText("∞", left - 6, this.y(Infinity) + 4);
    context.textAlign = "center";
    context.fillText("birth", left + side / 2, bottom + 28);
    context.save();
    context.translate(left - LEFT + 10, bottom - side / 2);
    context.rotate(-Math.PI / 2);
    context.fillText("death", 0, 0);
    context.restore();
  }

  /** Draws the line of the dots that never die. */
  drawLine() {
    this.line(withAlpha(palette.muted, 0.8), [
      [0, Infinity],
      [this.largest, Infinity],
    ]);
  }

  /** Draws what the marks mean, right of the diagonal, where no dot can be. */
  drawLegend() {
    const { context } = this;
    const entries = [
      ["cycle of the view", (x, y) => this.disc(x, y, 4.2, palette.critical.css)],
      ["track", (x, y) => this.disc(x, y, 4.2, sampleColor().css)],
      ["track, not in the view", (x, y) => this.hollow(x, y, 4.2, sampleColor().css)],
      ["other cycle", (x, y) => this.disc(x, y, 1.6, palette.muted.css)],
    ];
    const { least, most } = this.crowds;
    if (most > 0) {
      const counts = least === most ? formatCount(most) : `${formatCount(least)} to ${formatCount(most)}`;
      entries.push([`${counts} of them`, (x, y) => this.crowds.sample(context, palette.muted, x, y)]);
    }
    const widest = Math.max(...entries.map(([text]) => context.measureText(text).width));
    const x = this.left + this.side - widest - 12;
    context.textAlign = "left";
    entries.forEach(([text, draw], i) => {
      const y = this.bottom - 12 - 15 * (entries.length - 1 - i);
      draw(x - 10, y);
      context.fillStyle = palette.muted.css;
      context.fillText(text, x, y + 4);
    });
  }

  /** The cycle of the dot nearest to a position of the canvas. */
  pickAt(left, top) {
    if (this.side === 0) return null;
    let [best, nearest] = [-1, PICK_RADIUS * PICK_RADIUS];
    for (let at = 0; at < this.dots.length; at += 2) {
      const distance = (this.x(this.dots[at]) - left) ** 2 + (this.y(this.dots[at + 1]) - top) ** 2;
      if (distance < nearest) [best, nearest] = [at, distance];
    }
    return best < 0 ? null : this.tracksByLabel.pick(this.dots[best], this.dots[best + 1]);
  }

  /** What a position of the canvas shows, in words: the number of dots of a crowd, or else birth and death. */
  describe(left, top) {
    const isIn = left >= this.left && left <= this.left + this.side && top <= this.bottom && top >= TOP;
    if (this.side === 0 || !isIn) return "";
    const crowd = this.crowds.countAt(left, top);
    if (crowd > 0) return `${formatCount(crowd)} dots here`;
    const [birth, death] = [left - this.left, this.bottom - top].map((pixels) => (pixels * this.largest) / this.side);
    if (this.hasImmortals && Math.abs(top - this.y(Infinity)) <= LINE_REACH)
      return `birth ${formatNumber(birth)}, death ∞`;
    return death < birth ? "" : `birth ${formatNumber(birth)}, death ${formatNumber(death)}`;
  }
}

/** The largest scale of dots that is not infinite, and whether some never die. */
export function extentOf(dots) {
  let [highest, hasImmortals] = [0, false];
  for (let at = 0; at < dots.length; at += 2) {
    const isImmortal = dots[at + 1] === Infinity;
    hasImmortals ||= isImmortal;
    highest = Math.max(highest, isImmortal ? dots[at] : dots[at + 1]);
  }
  return { highest, hasImmortals };
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
