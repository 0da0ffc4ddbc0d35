//! The places of vertices: each vector of R^d as three coordinates, computed once as long as nothing changes.
//!
//! In: the vertices of a mirror; a map, which is of axes and an offset.
//! Out: three coordinates by slot; their centre and radius.
//! Invariants: a place is computed again only if its vertex is another one or the map has changed, so that a few
//! changes of a cloud in a high dimension cost little.
//! Must not know: how axes are found, cameras.

/**
 * How vectors become places: `axes` are three rows, or null for the coordinates themselves.
 * @typedef {{axes: Float64Array | null, offset: Float64Array, isAngular: boolean, version: number}} Map3
 */

export class Places {
  constructor() {
    this.values = new Float64Array(0);
    this.hashes = new Uint32Array(0);
    this.clear();
  }

  /** Computes all places anew the next time. */
  clear() {
    this.version = -1;
    this.center = [0, 0, 0];
    this.radius = 0;
  }

  /** Computes the places of vertices. @param {import("../session/elements.js").Elements} vertices @param {Map3} map */
  update(vertices, map) {
    const capacity = vertices.hashes.length / 2;
    if (this.values.length < 3 * capacity) {
      [this.values, this.hashes] = [new Float64Array(3 * capacity), new Uint32Array(2 * capacity)];
      this.version = -1;
    }
    const { hashes } = this;
    const isOther = this.version !== map.version;
    for (let slot = 0; slot < vertices.end; slot++) {
      if (vertices.rows[vertices.width * slot] < 0) continue;
      const [high, low] = [vertices.hashes[2 * slot], vertices.hashes[2 * slot + 1]];
      if (!isOther && hashes[2 * slot] === high && hashes[2 * slot + 1] === low) continue;
      [hashes[2 * slot], hashes[2 * slot + 1]] = [high, low];
      this.compute(vertices, slot, map);
    }
    this.version = map.version;
    this.measure(vertices);
  }

  compute({ rows, width }, slot, { axes, offset, isAngular }) {
    const [from, dimension] = [width * slot + 1, width - 1];
    const factor = isAngular ? unitFactor(rows, from, dimension) : 1;
    const sums = axes
      ? byAxes(axes, rows, from, dimension)
      : [0, 1, 2].map((i) => (i < dimension ? rows[from + i] : 0));
    for (let i = 0; i < 3; i++) this.values[3 * slot + i] = sums[i] * factor + offset[i];
  }

  /** Finds the centre of all places, and the radius of a ball around it that holds them. */
  measure({ rows, width, end }) {
    const { values } = this;
    const [low, high] = [
      [Infinity, Infinity, Infinity],
      [-Infinity, -Infinity, -Infinity],
    ];
    forEach(rows, width, end, (slot) => {
      for (let i = 0; i < 3; i++) {
        low[i] = Math.min(low[i], values[3 * slot + i]);
        high[i] = Math.max(high[i], values[3 * slot + i]);
      }
    });
    this.center = low.map((least, i) => (least <= high[i] ? least / 2 + high[i] / 2 : 0));
    this.radius = 0;
    forEach(rows, width, end, (slot) => {
      const [x, y, z] = this.center;
      const distance = Math.hypot(values[3 * slot] - x, values[3 * slot + 1] - y, values[3 * slot + 2] - z);
      this.radius = Math.max(this.radius, distance);
    });
  }
}

function forEach(rows, width, end, handle) {
  for (let slot = 0; slot < end; slot++) if (rows[width * slot] >= 0) handle(slot);
}

/** The products of a vector with three axes. The vector, which may be long, is read once. */
function byAxes(axes, rows, from, dimension) {
  let [x, y, z] = [0, 0, 0];
  for (let at = 0; at < dimension; at++) {
    const value = rows[from + at];
    x += axes[at] * value;
    y += axes[dimension + at] * value;
    z += axes[2 * dimension + at] * value;
  }
  return [x, y, z];
}

/** What a vector is multiplied by to have length 1; 0 for the vector 0. */
export function unitFactor(rows, from, dimension) {
  let largest = 0;
  for (let at = from; at < from + dimension; at++) largest = Math.max(largest, Math.abs(rows[at]));
  let sum = 0;
  // Squares of the vector itself might be infinite, or 0.
  for (let at = from; at < from + dimension; at++) sum += (rows[at] / largest) ** 2;
  return largest > 0 ? 1 / (largest * Math.sqrt(sum)) : 0;
}
