//! The bounding box of the points, updated now and then.
//!
//! In: vertices; those of a projection have a box of their own, which stays the same when they are turned.
//! Out: a box; the mean spacing of points in it.
//! Invariants: all points are scanned at most once per interval, and only after a change.
//! Must not know: cameras, what is drawn.

/** Milliseconds between two scans at the least. */
const INTERVAL = 200;

/** [left, bottom, right, top]. @typedef {[number, number, number, number]} Box */

export class Bounds {
  constructor() {
    this.clear();
  }

  /** Scans again at the next update. */
  clear() {
    /** @type {Box | null} */
    this.box = null;
  }

  /** The box around the points, at most one interval old; null while there are none. */
  update(vertices) {
    if (vertices.count > 0 && vertices.box) return (this.box = vertices.box);
    const now = performance.now();
    if (vertices.count === 0 || (this.box && (vertices.version === this.version || now - this.updatedAt < INTERVAL))) {
      return this.box;
    }
    [this.updatedAt, this.version] = [now, vertices.version];
    this.box = boxAround(vertices);
    return this.box;
  }

  /** The mean spacing of so many points in the box. */
  spacing(count) {
    const [left, bottom, right, top] = this.box ?? [0, 0, 1, 1];
    return Math.sqrt(((right - left) * (top - bottom)) / Math.max(1, count));
  }
}

/** @param {import("../session/elements.js").Elements} vertices @returns {Box} */
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
