//! Crowds of dots: where many would cover each other, their number makes the shade.
//!
//! In: positions in pixels.
//! Out: shaded cells; the number of dots of a cell.
//! Invariants: a cell is a crowd if more than a few dots are in it; every one of them is counted.
//! Must not know: what dots stand for.

import { withAlpha } from "../drawing/colors.js";

/** Pixels of a cell's side. */
const CELL = 8;
/** Up to so many dots of a cell are drawn one by one. */
const FEW = 3;

const keyOf = (x, y) => Math.floor(y / CELL) * 65536 + Math.floor(x / CELL);

export class Crowds {
  constructor() {
    this.clear();
  }

  clear() {
    /** Dots by cell. @type {Map<number, number>} */
    this.counts = new Map();
    /** The numbers of dots in the emptiest and in the fullest crowd; 0 if there is none. */
    this.least = this.most = 0;
  }

  /** Adds a dot, if it may be drawn as a part of a crowd. */
  add(x, y, isCommon) {
    if (!isCommon) return;
    const key = keyOf(x, y);
    this.counts.set(key, (this.counts.get(key) ?? 0) + 1);
  }

  isCrowded(x, y) {
    return (this.counts.get(keyOf(x, y)) ?? 0) > FEW;
  }

  /** The number of dots of the crowd at a position; 0 if there is none. */
  countAt(x, y) {
    const count = this.counts.get(keyOf(x, y)) ?? 0;
    return count > FEW ? count : 0;
  }

  /** Draws all crowds. */
  draw(context, color) {
    const crowds = [...this.counts].filter(([, count]) => count > FEW);
    this.most = crowds.reduce((most, [, count]) => Math.max(most, count), 0);
    this.least = crowds.reduce((least, [, count]) => Math.min(least, count), this.most);
    for (const [key, count] of crowds) {
      context.fillStyle = withAlpha(color, this.shade(count));
      context.fillRect((key % 65536) * CELL, Math.floor(key / 65536) * CELL, CELL, CELL);
    }
  }

  /** The opacity for a number of dots: it grows with the logarithm. */
  shade(count) {
    const range = Math.log(this.most / (FEW + 1));
    return 0.3 + (range > 0 ? (0.65 * Math.log(count / (FEW + 1))) / range : 0.35);
  }

  /** Draws a sample of the shades, for a legend. */
  sample(context, color, x, y) {
    [this.least, (this.least + this.most) / 2, this.most].forEach((count, i) => {
      context.fillStyle = withAlpha(color, this.shade(count));
      context.fillRect(x - 9 + 5 * i, y - 4, 5, CELL);
    });
  }
}
