//! The lives of tracks as bars over frames: births, splits, mergers and deaths.
//!
//! In: lives, the frame shown, what is meant. Out: pixels, and whose bar is under a pointer. Invariants: a life stays
//! in its lane; time runs to the right, and the frame shown is a line. Must not know: how lives are told of, the
//! plane.

import { contextOf, whole } from "./canvas.js";
import { colorOf, faded, palette } from "./colors.js";

const TOP = 6;
const BOTTOM = 20;
const SIDE = 10;
/** Frames shown for each pixel of width. */
const FRAMES_A_PIXEL = 0.5;
/** So many frames at the least. */
const FEWEST = 60;

export class Lives {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.bars = [];
  }

  /** Draws the lives up to the newest frame. @param {import("./lifelines.js").Lifelines} lifelines */
  draw({ lives }, newest, frameShown, hit) {
    const context = contextOf(this.canvas);
    this.bars = [];
    if (!context) return;
    Object.assign(this, context);
    this.newest = newest;
    // What is young fills the width, until there is more of it than fits.
    const oldest = [...lives.values()].reduce((first, life) => Math.min(first, life.from), newest);
    this.span = Math.min(Math.max(FEWEST, newest - oldest), Math.max(FEWEST, Math.round(this.width * FRAMES_A_PIXEL)));
    const seen = [...lives.values()].filter((life) => (life.to ?? newest) >= newest - this.span);
    this.lay(seen);
    for (const life of seen) this.drawLife(life, hit);
    for (const life of seen) this.drawLinks(life, lives);
    this.drawAxis(frameShown);
  }

  /** Lanes that are empty in the span take no room. */
  lay(seen) {
    const used = [...new Set(seen.map((life) => life.lane))].sort((a, b) => a - b);
    this.rank = new Map(used.map((lane, rank) => [lane, rank]));
    this.pitch = Math.min(16, (this.height - TOP - BOTTOM) / Math.max(1, used.length));
  }

  x(frame) {
    return this.width - SIDE - ((this.newest - frame) / this.span) * (this.width - 2 * SIDE);
  }

  y(lane) {
    return TOP + ((this.rank.get(lane) ?? 0) + 0.5) * this.pitch;
  }

  drawLife(life, hit) {
    const { to } = this;
    const isHit = hit?.track === life.id;
    const thick = Math.max(1, Math.min(9, this.pitch * 0.62));
    const [y, end] = [this.y(life.lane), life.to ?? this.newest];
    const [left, right] = [Math.max(SIDE, this.x(life.from)), this.x(end)];
    this.bars.push({ left, right: right + 1, y, life });
    const { css } = colorOf(life.id);
    to.fillStyle = css;
    this.forSpells(life, end, (from, until, pale) => {
      to.globalAlpha = pale ? 0.3 : 1;
      const [a, b] = [Math.max(SIDE, this.x(from)), this.x(until)];
      if (b > a) to.fillRect(a, y - thick / 2, b - a, thick);
    });
    to.globalAlpha = 1;
    if (isHit) {
      to.strokeStyle = palette.ink.css;
      to.strokeRect(left - 1.5, y - thick / 2 - 1.5, right - left + 3, thick + 3);
    }
    if (this.pitch < 4) return;
    if (life.began === "born" && this.x(life.from) >= SIDE) this.dot(this.x(life.from), y, thick * 0.62, css);
    if (life.ended === "died") this.cross(right, y, Math.max(2, thick * 0.5));
  }

  /** Calls for each part of a life between changes of its selection. */
  forSpells(life, end, draw) {
    let [from, pale] = [life.from, false];
    for (const frame of life.pale) {
      if (frame > from) draw(from, frame, pale);
      [from, pale] = [frame, !pale];
    }
    draw(from, end, pale);
  }

  /** Links to the life that one split off, and to the one that it went into. */
  drawLinks(life, lives) {
    const parent = life.began === "split" && lives.get(life.parent);
    if (parent) this.link(life.from, parent, life, life.id);
    const into = life.ended === "merged" && lives.get(life.into);
    if (into) this.link(life.to, life, into, life.id);
  }

  link(frame, from, to, id) {
    const x = this.x(frame);
    if (x < SIDE || !this.rank.has(from.lane) || !this.rank.has(to.lane)) return;
    const { to: context } = this;
    context.strokeStyle = colorOf(id).css;
    context.beginPath();
    context.moveTo(x, this.y(from.lane));
    context.lineTo(x, this.y(to.lane));
    context.stroke();
    this.dot(x, this.y(to.lane), 2, palette.ink.css);
  }

  dot(x, y, radius, style) {
    this.to.fillStyle = style;
    this.to.beginPath();
    this.to.arc(x, y, radius, 0, 7);
    this.to.fill();
  }

  cross(x, y, size) {
    const { to } = this;
    to.strokeStyle = palette.muted.css;
    to.beginPath();
    to.moveTo(x, y - size);
    to.lineTo(x, y + size);
    to.stroke();
  }

  drawAxis(frameShown) {
    const { to, height, width } = this;
    to.fillStyle = palette.muted.css;
    to.textAlign = "left";
    to.fillText(`frame ${whole(Math.max(0, this.newest - this.span))}`, SIDE, height - 6);
    to.textAlign = "right";
    to.fillText(whole(this.newest), width - SIDE, height - 6);
    if (frameShown === this.newest || frameShown < this.newest - this.span) return;
    to.strokeStyle = faded(palette.ink, 0.7);
    to.beginPath();
    to.moveTo(this.x(frameShown), 2);
    to.lineTo(this.x(frameShown), height - BOTTOM + 4);
    to.stroke();
  }

  /** The track of the bar at a point. */
  at(left, top) {
    const reach = Math.max(3, this.pitch / 2);
    const bar = this.bars.find(
      (one) => left >= one.left - 2 && left <= one.right + 2 && Math.abs(top - one.y) <= reach,
    );
    return bar ? { track: bar.life.id, birth: NaN, death: NaN } : null;
  }
}
