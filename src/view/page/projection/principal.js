//! The three principal axes of a cloud in R^d, kept near those of the frame before.
//!
//! In: vectors of a sample of the cloud, centred.
//! Out: three orthonormal axes.
//! Invariants: work is bounded, whatever the dimension is. The first axes are the three principal components, the
//! largest loading of each positive. Later ones span what the iteration has reached from those before, and are turned
//! onto them (Procrustes), so that a picture does not jump where components are about equally strong. Only where
//! another direction has become far stronger do they change at once.
//! Must not know: metrics, streams, what is drawn.

import { dot, eigenvectors, nearestOrthogonal, orthonormalize } from "./linear.js";

/** Directions that are followed: the three axes, and the strongest ones across them, which may become axes. */
const FOLLOWED = 6;
/** Up to this dimension the covariance matrix is computed; above it, products with the sample are cheaper. */
const MAX_MATRIX = 40;
/** Multiplications that the first axes and later ones may take, and steps of the iteration. */
const FIRST = { work: 16e6, steps: 60 };
const LATER = { work: 2e6, steps: 2 };
/** A direction becomes an axis if the variance along it is so many times that along an axis. */
const STRONGER = 1.5;
/** Variances below this share of the largest one are rounding. */
const NEGLIGIBLE = 1e-9;
/** Loadings that differ by less than this share are equal, and the first of them gives the sign. */
const EQUAL = 1e-6;

/** How far axes turn in a frame at the most, in radians, as long as the cloud has the same strong directions. */
const MOST_TURN = 0.06;
/** How far axes go towards those of a sample that is a small part of its cloud, and so another one in each frame. */
const OF_SAMPLE = 0.08;

/**
 * Vectors of a cloud, centred: `count` rows of `width` numbers; whether they are all of them.
 * @typedef {{rows: Float64Array, count: number, isWhole: boolean}} Sample
 */

export class PrincipalAxes {
  constructor(width) {
    this.width = width;
    this.count = Math.min(FOLLOWED, width);
    /** The followed directions as rows, the axes first; null before there are any. @type {Float64Array | null} */
    this.directions = null;
    /** Three rows. @type {Float64Array | null} */
    this.axes = null;
    /** Whether a direction has become an axis, so that the axes are others. */
    this.isOther = false;
  }

  /** Follows the cloud. Returns the axes. @param {Sample} sample */
  update(sample) {
    const { axes: before, width } = this;
    const { multiply, work } = operatorOf(sample, width);
    const limits = before ? LATER : FIRST;
    const steps = Math.floor(limits.work / work(this.count));
    this.directions ??= startingRows(this.count, width);
    this.isOther = false;
    for (let i = 0; i < Math.max(1, Math.min(limits.steps, steps)); i++) this.step(multiply, before !== null);
    if (!before) this.sort(multiply);
    const found = this.directions.slice(0, 3 * width);
    if (before) this.axes = this.nearTo(before, found, sample.isWhole);
    else this.axes = withSigns(found, width);
    this.directions.set(this.axes);
    return this.axes;
  }

  /** Axes turned onto those before, and no farther from them than one frame allows. */
  nearTo(before, found, isWhole) {
    const { width } = this;
    const axes = alignedTo(before, found, width);
    // A direction that is strong in one sample may be weak in the next.
    const most = this.isOther && isWhole ? 1 : MOST_TURN / turnBetween(before, axes);
    const share = Math.min(most, isWhole ? 1 : OF_SAMPLE);
    return share < 1 ? between(before, axes, share, width) : axes;
  }

  /** A step of the orthogonal iteration. */
  step(multiply, mayReplace) {
    const { directions, count, width } = this;
    const images = multiply(directions, count);
    const variances = Array.from({ length: count }, (_, i) => dot(directions, images, i, i, width));
    const largest = Math.max(...variances);
    const least = Math.min(...variances.slice(0, 3));
    if (mayReplace && variances.slice(3).some((one) => one > STRONGER * least && one > NEGLIGIBLE * largest)) {
      this.isOther = true;
      return this.sort(multiply);
    }
    for (let i = 0; i < count; i++) {
      // Where the cloud has no extent its image would be rounding, and any direction is as good as the one before.
      if (variances[i] > NEGLIGIBLE * largest) {
        directions.set(images.subarray(i * width, (i + 1) * width), i * width);
      }
    }
    orthonormalize(directions, count, width);
  }

  /** Turns the directions to the principal components among them, the strongest first. */
  sort(multiply) {
    const { directions, count, width } = this;
    const images = multiply(directions, count);
    const products = new Float64Array(count * count);
    for (let i = 0; i < count; i++) {
      for (let j = 0; j <= i; j++) {
        products[i * count + j] = products[j * count + i] = dot(directions, images, i, j, width);
      }
    }
    this.directions = combined(eigenvectors(products, count), directions, count, width);
    orthonormalize(this.directions, count, width);
  }
}

/** Rows whose factors are a matrix: `count` of them. */
function combined(factors, rows, count, width) {
  const sums = new Float64Array(count * width);
  const size = rows.length / width;
  for (let i = 0; i < count; i++) {
    for (let j = 0; j < size; j++) {
      const factor = factors[i * size + j];
      for (let at = 0; at < width; at++) sums[i * width + at] += factor * rows[j * width + at];
    }
  }
  return sums;
}

/** Orthonormal rows that are the same in every run, and along no coordinate axis. */
function startingRows(count, width) {
  let state = 1;
  const rows = new Float64Array(count * width).map(() => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32 - 0.5;
  });
  orthonormalize(rows, count, width);
  return rows;
}

/** The axes turned and reflected onto others, as near as they come. */
function alignedTo(before, axes, width) {
  const products = new Float64Array(9);
  for (let i = 0; i < 9; i++) products[i] = dot(before, axes, Math.floor(i / 3), i % 3, width);
  const aligned = combined(nearestOrthogonal(products), axes, 3, width);
  orthonormalize(aligned, 3, width);
  return aligned;
}

/** The largest angle between two axes of the same number, where it is small. */
export function turnBetween(before, axes) {
  const width = axes.length / 3;
  const distance = (i) => {
    let sum = 0;
    for (let at = i * width; at < (i + 1) * width; at++) sum += (axes[at] - before[at]) ** 2;
    return Math.sqrt(sum);
  };
  return Math.max(distance(0), distance(1), distance(2));
}

/** Axes on the way from some to others. */
function between(before, axes, share, width) {
  const mixed = axes.map((value, at) => before[at] + share * (value - before[at]));
  orthonormalize(mixed, 3, width);
  return mixed;
}

/** The axes, the largest loading of each positive; of equal ones, the first. */
function withSigns(axes, width) {
  for (let from = 0; from < axes.length; from += width) {
    const axis = axes.subarray(from, from + width);
    const largest = axis.reduce((most, loading) => Math.max(most, Math.abs(loading)), 0);
    const deciding = axis.find((loading) => Math.abs(loading) >= (1 - EQUAL) * largest);
    if (deciding < 0) for (let at = 0; at < width; at++) axis[at] = -axis[at];
  }
  return axes;
}

/**
 * The covariance as an operator: `multiply` gives the images of rows, and `work` the number of multiplications for so
 * many of them.
 * @param {Sample} sample
 */
function operatorOf(sample, width) {
  const workOf = (rowsOfOperator) => (count) => Math.max(1, count * width * rowsOfOperator);
  if (width > MAX_MATRIX) {
    return { multiply: (rows, count) => bySample(sample, rows, count, width), work: workOf(2 * sample.count) };
  }
  const matrix = covarianceOf(sample, width);
  return { multiply: (rows, count) => byMatrix(matrix, rows, count, width), work: workOf(width) };
}

function covarianceOf({ rows, count }, width) {
  const matrix = new Float64Array(width * width);
  for (let k = 0; k < count; k++) {
    for (let i = 0; i < width; i++) {
      const factor = rows[k * width + i];
      for (let j = 0; j <= i; j++) matrix[i * width + j] += factor * rows[k * width + j];
    }
  }
  for (let i = 0; i < width; i++) for (let j = 0; j < i; j++) matrix[j * width + i] = matrix[i * width + j];
  return matrix;
}

function byMatrix(matrix, rows, count, width) {
  const images = new Float64Array(count * width);
  for (let i = 0; i < count; i++) {
    for (let j = 0; j < width; j++) images[i * width + j] = dot(rows, matrix, i, j, width);
  }
  return images;
}

/** The images of rows, six of them: three at a time, so that each number of the sample is read once for three. */
function bySample({ rows: vectors, count: size }, rows, count, width) {
  const images = new Float64Array(count * width);
  for (let i = 0; i < count; i += 3) {
    const [a, b, c] = [i * width, (i + 1) * width, (i + 2) * width];
    for (let from = 0; from < size * width; from += width) addImages(vectors, rows, images, from, a, b, c, width);
  }
  return images;
}

/** Adds a vector, times its products with three rows, to their images. */
function addImages(vectors, rows, images, from, a, b, c, width) {
  let [x, y, z] = [0, 0, 0];
  for (let at = 0; at < width; at++) {
    const value = vectors[from + at];
    x += value * rows[a + at];
    y += value * rows[b + at];
    z += value * rows[c + at];
  }
  for (let at = 0; at < width; at++) {
    const value = vectors[from + at];
    images[a + at] += x * value;
    images[b + at] += y * value;
    images[c + at] += z * value;
  }
}
