//! Where the points are, looked at now and then, and how large they are drawn there.
//!
//! In: vertices. Out: a box. Invariants: a look at all points is not taken more often than it is worth. Must not know:
//! cameras, what is drawn.

const EVERY = 200;

/** [left, bottom, right, top]. @typedef {[number, number, number, number]} Box */

export class Bounds {
  constructor() {
    this.clear();
  }

  /** Looks anew at the next chance. */
  clear() {
    /** @type {Box | null} */
    this.box = null;
  }

  /** The box around the points, as it was a moment ago; null while there are none. */
  take(vertices) {
    const now = performance.now();
    if (vertices.count === 0 || (this.box && (vertices.version === this.version || now - this.at < EVERY))) {
      return this.box;
    }
    [this.at, this.version] = [now, vertices.version];
    this.box = boxAround(vertices);
    return this.box;
  }

  /** Room that each of so many points has, as a length. */
  room(count) {
    const [left, bottom, right, top] = this.box ?? [0, 0, 1, 1];
    return Math.sqrt(((right - left) * (top - bottom)) / Math.max(1, count));
  }
}

/** @param {import("./elements.js").Elements} vertices @returns {Box} */
function boxAround({ rows, end }) {
  let [left, bottom, right, top] = [Infinity, Infinity, -Infinity, -Infinity];
  for (let at = 0; at < 3 * end; at += 3) {
    if (rows[at] < 0) continue;
    const [x, y] = [rows[at + 1], rows[at + 2]];
    if (x < left) left = x;
    if (x > right) right = x;
    if (y < bottom) bottom = y;
    if (y > top) top = y;
  }
  return [left, bottom, right, top];
}
