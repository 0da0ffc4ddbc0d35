//! The timeline of tracks: lifetimes as bars over frames, with births, splits, mergers and deaths.
//!
//! In: lifetimes, the shown frame, the picked cycle.
//! Out: pixels; the track whose bar is under a pointer.
//! Invariants: a lifetime stays in its lane. Time runs to the right, and a line marks the shown frame.
//! Must not know: where lifetimes come from, the plane.

import { clearedContext } from "../drawing/canvas.js";
import { colorOf, palette, withAlpha } from "../drawing/colors.js";
import { formatCount } from "./numbers.js";

const TOP = 6;
const BOTTOM = 20;
const SIDE = 10;
/** Frames per pixel of width. */
const FRAMES_PER_PIXEL = 0.5;
/** Frames shown at the least. */
const MIN_SPAN = 60;
/** The least length of a bar: a life of one frame is seen too. */
const LEAST = 4;

export class Timeline {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.bars = [];
  }

  /** Draws lifetimes up to the newest frame. @param {import("../session/lifetimes.js").Lifetimes} lifetimes */
  draw({ byId }, newest, shownFrame, pick) {
    const cleared = clearedContext(this.canvas);
    this.bars = [];
    if (!cleared) return;
    Object.assign(this, cleared);
    this.newest = newest;
    // A young stream fills the width, until it has more frames than fit.
    const lifetimes = [...byId.values()];
    const oldest = lifetimes.reduce((first, { from }) => Math.min(first, from), newest);
    const capacity = Math.round(this.width * FRAMES_PER_PIXEL);
    this.span = Math.min(Math.max(MIN_SPAN, newest - oldest), Math.max(MIN_SPAN, capacity));
    const visible = lifetimes.filter(({ to }) => (to ?? newest) >= newest - this.span);
    this.assignRows(visible);
    for (const lifetime of visible) this.drawLifetime(lifetime, pick);
    for (const lifetime of visible) this.drawLinks(lifetime, byId);
    if (lifetimes.length > 0) this.drawAxis(shownFrame);
  }

  /** Assigns a row to each lane that is not empty. */
  assignRows(visible) {
    const lanes = [...new Set(visible.map(({ lane }) => lane))].sort((a, b) => a - b);
    this.rows = new Map(lanes.map((lane, row) => [lane, row]));
    this.rowHeight = Math.min(16, (this.height - TOP - BOTTOM) / Math.max(1, lanes.length));
  }

  x(frame) {
    return this.width - SIDE - ((this.newest - frame) / this.span) * (this.width - 2 * SIDE);
  }

  y(lane) {
    return TOP + ((this.rows.get(lane) ?? 0) + 0.5) * this.rowHeight;
  }

  drawLifetime(lifetime, pick) {
    const { context } = this;
    const height = Math.max(1, Math.min(9, this.rowHeight * 0.62));
    const [y, end] = [this.y(lifetime.lane), lifetime.to ?? this.newest];
    const right = this.x(end);
    const left = Math.max(SIDE, Math.min(this.x(lifetime.from), right - LEAST));
    this.bars.push({ left, right: right + 1, y, id: lifetime.id });
    const { css } = colorOf(lifetime.id);
    context.fillStyle = css;
    this.forSegments(lifetime, end, (from, to, isSelected) => {
      context.globalAlpha = isSelected ? 1 : 0.3;
      const [a, b] = [from === lifetime.from ? left : Math.max(SIDE, this.x(from)), this.x(to)];
      if (b > a) context.fillRect(a, y - height / 2, b - a, height);
    });
    context.globalAlpha = 1;
    if (pick?.track === lifetime.id) {
      context.strokeStyle = palette.ink.css;
      context.strokeRect(left - 1.5, y - height / 2 - 1.5, right - left + 3, height + 3);
    }
    if (this.rowHeight < 4) return;
    if (lifetime.began === "born" && this.x(lifetime.from) >= SIDE) {
      this.drawDot(this.x(lifetime.from), y, height * 0.62, css);
    }
    if (lifetime.ended === "died") this.drawEnd(right, y, Math.max(2, height * 0.5));
  }

  /** Calls `draw` for each segment of a lifetime between two changes of its selection. */
  forSegments(lifetime, end, draw) {
    let [from, isSelected] = [lifetime.from, true];
    for (const frame of lifetime.selectionChanges) {
      if (frame > from) draw(from, frame, isSelected);
      [from, isSelected] = [frame, !isSelected];
    }
    draw(from, end, isSelected);
  }

  /** Draws the links to the track that this one split off from, and to the one that it merged into. */
  drawLinks(lifetime, byId) {
    const parent = lifetime.began === "split" && byId.get(lifetime.parent);
    if (parent) this.drawLink(lifetime.from, parent, lifetime, lifetime.id);
    const into = lifetime.ended === "merged" && byId.get(lifetime.into);
    if (into) this.drawLink(lifetime.to, lifetime, into, lifetime.id);
  }

  drawLink(frame, from, to, id) {
    const x = this.x(frame);
    if (x < SIDE || !this.rows.has(from.lane) || !this.rows.has(to.lane)) return;
    const { context } = this;
    context.strokeStyle = colorOf(id).css;
    context.beginPath();
    context.moveTo(x, this.y(from.lane));
    context.lineTo(x, this.y(to.lane));
    context.stroke();
    this.drawDot(x, this.y(to.lane), 2, palette.ink.css);
  }

  drawDot(x, y, radius, style) {
    this.context.fillStyle = style;
    this.context.beginPath();
    this.context.arc(x, y, radius, 0, 7);
    this.context.fill();
  }

  drawEnd(x, y, size) {
    const { context } = this;
    context.strokeStyle = palette.muted.css;
    context.beginPath();
    context.moveTo(x, y - size);
    context.lineTo(x, y + size);
    context.stroke();
  }

  drawAxis(shownFrame) {
    const { context, height, width } = this;
    context.fillStyle = palette.muted.css;
    context.textAlign = "left";
    context.fillText(`frame ${formatCount(Math.max(0, this.newest - this.span))}`, SIDE, height - 6);
    context.textAlign = "right";
    context.fillText(formatCount(this.newest), width - SIDE, height - 6);
    if (shownFrame === this.newest || shownFrame < this.newest - this.span) return;
    context.strokeStyle = withAlpha(palette.ink, 0.7);
    context.beginPath();
    context.moveTo(this.x(shownFrame), 2);
    context.lineTo(this.x(shownFrame), height - BOTTOM + 4);
    context.stroke();
  }

  /** The track whose bar is at a position of the canvas. @returns {import("../drawing/picking.js").Pick | null} */
  pickAt(left, top) {
    const radius = Math.max(3, this.rowHeight / 2);
    const bar = this.bars.find(
      (one) => left >= one.left - 2 && left <= one.right + 2 && Math.abs(top - one.y) <= radius,
    );
    return bar ? { track: bar.id, birth: NaN, death: NaN } : null;
  }
}
