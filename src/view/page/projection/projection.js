//! The projection of a stream in a space onto the screen: a picture of it as one of the plane, with depths.
//!
//! In: a picture whose mirrors may be in a space; how the cloud is turned.
//! Out: the same picture, whose vertices are positions in the plane of the screen.
//! Invariants: the projection is orthographic, so lengths across the line of sight are true. Up to three coordinates
//! are shown as they are; of more, the principal components. Vectors that are compared by angles are shown at length 1.
//! A picture of the plane is left as it is.
//! Must not know: the graphics card, events.

import { Orientation } from "./orientation.js";
import { Places, unitFactor } from "./places.js";
import { PrincipalAxes, turnBetween } from "./principal.js";
import { ProjectedVertices } from "./vertices.js";

/** Numbers of the sample that principal axes are computed of. */
const SAMPLE_NUMBERS = 1 << 18;
/** Axes that have turned by less than this, in radians, stay where computing all places anew would take long. */
const LEAST_TURN = 0.03;
/** So many numbers of vertices take long. */
const MANY_NUMBERS = 1 << 20;

/** Differences below this share of the largest number are rounding. */
const ROUNDING = 1e-13;

/** @typedef {import("../drawing/renderer.js").Picture} Picture */

export class Projection {
  constructor() {
    this.orientation = new Orientation();
    this.places = [new Places(), new Places()];
    this.projected = [new ProjectedVertices(), new ProjectedVertices()];
    /** Counts the maps, so that none is taken for another one. */
    this.maps = 0;
    this.reset();
  }

  /** Begins again: with new axes, turned as in the beginning. */
  reset() {
    /** Metric and dimension of what is projected. */
    this.space = "";
    this.turnBack();
  }

  /** Turns back to the beginning, with axes that are the principal components of what is there by now. */
  turnBack() {
    this.principal = null;
    this.seen = null;
    this.mean = null;
    /** @type {import("./places.js").Map3} */
    this.map = { axes: null, offset: new Float64Array(3), isAngular: false, version: (this.maps += 1) };
    this.orientation.reset(this.dimension === 3);
  }

  /** Whether there is a third coordinate, so that the picture can be turned. */
  get canTurn() {
    return this.dimension > 2;
  }

  /** Turns the cloud around its centre, as a drag by so many pixels asks for. */
  turn(right, down) {
    this.orientation.turn(right, down, this.places[0].center);
  }

  /** Projects a picture. @param {Picture} picture @returns {Picture} */
  project({ mirror, simplified, annotations }) {
    this.dimension = mirror.metric === null ? 2 : mirror.dimension;
    const space = `${mirror.metric} ${mirror.dimension}`;
    if (space !== this.space) {
      this.space = space;
      this.turnBack();
    }
    if (mirror.metric === null) return { mirror, simplified, annotations };
    this.updateMap(mirror);
    return { mirror: this.projectMirror(mirror, 0), simplified: this.projectMirror(simplified, 1), annotations };
  }

  projectMirror(mirror, which) {
    const [places, vertices] = [this.places[which], this.projected[which]];
    // A simplified skeleton that is not there has no dimension of its own.
    const isThere = mirror.vertices.count > 0;
    if (isThere) places.update(mirror.vertices, this.map);
    vertices.update(mirror.vertices, isThere ? places : new Places(), this.orientation, this.dimension);
    return { ...mirror, vertices };
  }

  /** Lets the map follow the vertices. */
  updateMap({ vertices, metric, dimension }) {
    if (this.seen === vertices.version) return;
    this.seen = vertices.version;
    this.map.isAngular = metric === "Angular";
    if (dimension <= 3 || vertices.count === 0) return;
    const sample = sampleOf(vertices, this.map.isAngular);
    if (!Number.isFinite(sample.reach)) return;
    this.principal ??= new PrincipalAxes(dimension);
    const axes = this.principal.update(sample);
    const isSmall = vertices.count * dimension < MANY_NUMBERS;
    if (this.map.axes && !isSmall && turnBetween(this.map.axes, axes) < LEAST_TURN) return;
    this.changeAxes(axes, sample.mean);
  }

  /** Takes over other axes. The mean of the cloud stays where it is. */
  changeAxes(axes, mean) {
    const { axes: before, offset } = this.map;
    const moved = Float64Array.from(offset, (value, i) => {
      const from = i * mean.length;
      return value + (before ? along(before, from, mean) : 0) - along(axes, from, mean);
    });
    this.map = { ...this.map, axes, offset: moved, version: (this.maps += 1) };
  }
}

const along = (axes, from, vector) => vector.reduce((sum, value, at) => sum + axes[from + at] * value, 0);

/**
 * A sample of vertices as vectors, centred, whose largest number is 1. Where not all are in it, the hash of a vertex
 * decides, so one that stays in the cloud stays in the sample.
 */
export function sampleOf(vertices, isAngular) {
  const { rows, hashes, width, end, count } = vertices;
  const dimension = width - 1;
  const most = Math.max(1, Math.min(count, Math.floor(SAMPLE_NUMBERS / dimension)));
  const limit = (2 ** 32 * most) / count;
  const sample = new Float64Array(most * dimension);
  let taken = 0;
  for (let slot = 0; slot < end && taken < most; slot++) {
    if (rows[width * slot] < 0 || hashes[2 * slot] >= limit) continue;
    const from = width * slot + 1;
    const factor = isAngular ? unitFactor(rows, from, dimension) : 1;
    for (let at = 0; at < dimension; at++) sample[taken * dimension + at] = rows[from + at] * factor;
    taken += 1;
  }
  return { ...centred(sample, taken, dimension), isWhole: taken === count };
}

function centred(rows, count, dimension) {
  const mean = new Float64Array(dimension);
  const forEach = (change) => {
    for (let from = 0; from < count * dimension; from += dimension) {
      for (let at = 0; at < dimension; at++) change(from + at, at);
    }
  };
  forEach((at, column) => (mean[column] += rows[at] / count));
  let [reach, largest] = [0, 0];
  forEach((at, column) => {
    largest = Math.max(largest, Math.abs(rows[at]));
    rows[at] -= mean[column];
    reach = Math.max(reach, Math.abs(rows[at]));
  });
  // What differs from the mean by its rounding only has no extent.
  const factor = reach > ROUNDING * largest ? 1 / reach : 0;
  forEach((at) => (rows[at] *= factor));
  return { rows, count, mean, reach };
}
