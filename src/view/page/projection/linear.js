//! The linear algebra of projections: orthonormal rows, eigenvectors of small symmetric matrices, nearest rotations.
//!
//! In: matrices as flat arrays, row by row.
//! Out: matrices; some are changed in place.
//! Invariants: the same input gives the same bits. Rank that is missing is filled with coordinate axes.
//! Must not know: points, what is drawn.

/** A row whose part across the rows before is below this share of it lies among them. */
const NEGLIGIBLE = 1e-10;
const MAX_SWEEPS = 30;
const MAX_STEPS = 40;

/** The inner product of two rows. */
export function dot(a, b, i, j, width) {
  const [first, second] = [i * width, j * width];
  let sum = 0;
  for (let at = 0; at < width; at++) sum += a[first + at] * b[second + at];
  return sum;
}

/** Makes rows orthonormal, each across those before it (Gram and Schmidt, twice). */
export function orthonormalize(rows, count, width) {
  for (let i = 0; i < count; i++) {
    if (makeUnit(rows, i, width) && clear(rows, i, width)) continue;
    // Of the coordinate axes the one that is farthest from the rows before is never among them.
    const axis = freestAxis(rows, i, width);
    for (let at = 0; at < width; at++) rows[i * width + at] = at === axis ? 1 : 0;
    clear(rows, i, width);
  }
}

/** Takes out of a unit row what lies along the rows before. False if nothing is left. */
function clear(rows, i, width) {
  for (let round = 0; round < 2; round++) {
    for (let j = 0; j < i; j++) {
      const along = dot(rows, rows, i, j, width);
      for (let at = 0; at < width; at++) rows[i * width + at] -= along * rows[j * width + at];
    }
    if (!makeUnit(rows, i, width, NEGLIGIBLE)) return false;
  }
  return true;
}

/** Scales a row to length 1. False if it is no longer than `least`, or not finite. */
function makeUnit(rows, i, width, least = 0) {
  const length = Math.sqrt(dot(rows, rows, i, i, width));
  if (!(length > least && length < Infinity)) return false;
  for (let at = 0; at < width; at++) rows[i * width + at] /= length;
  return true;
}

function freestAxis(rows, count, width) {
  let [best, least] = [0, Infinity];
  for (let axis = 0; axis < width; axis++) {
    let taken = 0;
    for (let i = 0; i < count; i++) taken += rows[i * width + axis] ** 2;
    if (taken < least) [best, least] = [axis, taken];
  }
  return best;
}

/**
 * The eigenvectors of a symmetric matrix (Jacobi), as rows, those of the largest values first.
 * @param {Float64Array} matrix is changed
 */
export function eigenvectors(matrix, size) {
  const vectors = new Float64Array(size * size);
  for (let i = 0; i < size; i++) vectors[i * (size + 1)] = 1;
  const pairs = [];
  for (let p = 0; p < size; p++) for (let q = p + 1; q < size; q++) pairs.push([p, q]);
  for (let sweep = 0; sweep < MAX_SWEEPS; sweep++) {
    if (pairs.every(([p, q]) => matrix[p * size + q] === 0)) break;
    for (const [p, q] of pairs) eliminate(matrix, vectors, size, p, q);
  }
  const order = Array.from({ length: size }, (_, i) => i);
  order.sort((a, b) => matrix[b * (size + 1)] - matrix[a * (size + 1)]);
  const sorted = new Float64Array(size * size);
  order.forEach((from, to) => sorted.set(vectors.subarray(from * size, (from + 1) * size), to * size));
  return sorted;
}

/** Makes the entry of a row and a column 0 by a rotation. */
function eliminate(matrix, vectors, size, p, q) {
  const [pp, qq, pq] = [matrix[p * size + p], matrix[q * size + q], matrix[p * size + q]];
  if (Math.abs(pq) <= 1e-16 * Math.sqrt(Math.abs(pp * qq))) {
    matrix[p * size + q] = matrix[q * size + p] = 0;
    return;
  }
  const ratio = (qq - pp) / (2 * pq);
  const tangent = (ratio >= 0 ? 1 : -1) / (Math.abs(ratio) + Math.sqrt(ratio * ratio + 1));
  const cosine = 1 / Math.sqrt(tangent * tangent + 1);
  const sine = tangent * cosine;
  for (let i = 0; i < size; i++) turn(matrix, i * size + p, i * size + q, cosine, sine);
  for (let i = 0; i < size; i++) turn(matrix, p * size + i, q * size + i, cosine, sine);
  for (let i = 0; i < size; i++) turn(vectors, p * size + i, q * size + i, cosine, sine);
}

/** Turns two entries by an angle. */
function turn(values, at, other, cosine, sine) {
  const [a, b] = [values[at], values[other]];
  values[at] = cosine * a - sine * b;
  values[other] = sine * a + cosine * b;
}

/** The orthogonal matrix nearest to one of 3 by 3: its polar factor, by Newton's steps. */
export function nearestOrthogonal(matrix) {
  let current = Float64Array.from(matrix);
  for (let step = 0; step < MAX_STEPS; step++) {
    const cofactors = cofactorsOf(current);
    const determinant = dot(current, cofactors, 0, 0, 3);
    if (!(Math.abs(determinant) > NEGLIGIBLE)) {
      orthonormalize(current, 3, 3);
      return current;
    }
    // The transposed inverse is the matrix of cofactors divided by the determinant.
    const next = current.map((value, i) => (value + cofactors[i] / determinant) / 2);
    const change = next.reduce((most, value, i) => Math.max(most, Math.abs(value - current[i])), 0);
    current = next;
    if (change < 1e-14) break;
  }
  return current;
}

function cofactorsOf(m) {
  const at = (row, column) => m[(row % 3) * 3 + (column % 3)];
  return m.map((_, i) => {
    const [row, column] = [Math.floor(i / 3), i % 3];
    return at(row + 1, column + 1) * at(row + 2, column + 2) - at(row + 1, column + 2) * at(row + 2, column + 1);
  });
}
