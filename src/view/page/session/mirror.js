//! A mirror of one view of one stream: the state after each snapshot and each diff, verified by its checksum.
//!
//! In: `Snapshot` and `Diff` messages; those of a space in the form that `spaces.js` gives them.
//! Out: rows of vertices, edges and critical edges; the inverse of each diff.
//! Invariants: a vertex has two coordinates in the plane and `dimension` in a space. One that stays keeps its slot,
//! even if it moves. After a `Contradiction` the state is invalid until the next snapshot.
//! Must not know: tracks, graphics, sockets.

import { Elements } from "./elements.js";

/** A message contradicts the held state. */
export class Contradiction extends Error {}

/**
 * The changes of a diff, as rows.
 * @typedef {{vertices_added: Float64Array, vertices_removed: Float64Array, edges_added: Float64Array,
 *   edges_removed: Float64Array, critical_set: Float64Array, critical_removed: Float64Array}} Change
 */

export class Mirror {
  constructor() {
    this.setSpace(null, 2);
    this.edges = new Elements(2, 2, 2);
    this.critical = new Elements(3, 2, 4);
    /** The frame that is held, or null. */
    this.frame = null;
  }

  /** Drops everything. */
  clear() {
    for (const elements of [this.vertices, this.edges, this.critical]) elements.clear();
    this.frame = null;
  }

  /** Sets metric and dimension. The metric of the plane is null; the dimension is 0 while no point has come. */
  setSpace(metric, dimension) {
    if (this.dimension !== dimension) this.vertices = new Elements(1, 1, 1 + dimension);
    this.metric = metric;
    this.dimension = dimension;
  }

  /** Replaces everything. */
  applySnapshot(snapshot) {
    this.frame = null;
    this.setSpace(snapshot.metric ?? null, snapshot.dimension ?? 2);
    for (const [elements, list] of [
      [this.vertices, snapshot.vertices],
      [this.edges, snapshot.edges],
      [this.critical, snapshot.critical],
    ]) {
      elements.clear(list.length / elements.width);
      addAll(elements, list);
    }
    this.verify(snapshot);
  }

  /** Applies a diff. @returns {Change} its inverse */
  applyDiff(diff) {
    if (this.frame?.number !== diff.from) {
      throw new Contradiction(`a diff from frame ${diff.from} came, and frame ${this.frame?.number ?? "none"} is held`);
    }
    this.frame = null;
    this.settleDimension(diff.dimension ?? 2);
    const inverse = this.apply(diff);
    this.verify(diff);
    return inverse;
  }

  /** The first point of a stream in a space fixes its dimension, which is 0 before that. */
  settleDimension(dimension) {
    if (this.dimension === 0) this.setSpace(this.metric, dimension);
    if (this.dimension === dimension) return;
    throw new Contradiction(`a diff has vertices of ${dimension} coordinates, and ${this.dimension} are held of each`);
  }

  /** Moves to another frame by a change that was verified before. @param {Change} change */
  moveTo(change, frame) {
    this.apply(change);
    this.frame = frame;
  }

  /** Applies a change. @param {Change} change @returns {Change} its inverse */
  apply(change) {
    const vertices_removed = ids(change.vertices_added, this.vertices.width);
    const vertices_added = this.moveVertices(change.vertices_removed, change.vertices_added);
    removeAll(this.edges, change.edges_removed);
    addAll(this.edges, change.edges_added);
    const critical = this.applyCritical(change.critical_removed, change.critical_set);
    const [edges_added, edges_removed] = [change.edges_removed, change.edges_added];
    return { vertices_added, vertices_removed, edges_added, edges_removed, ...critical };
  }

  /**
   * Removes and adds vertices. Both lists are sorted, so one merge finds the vertices that are in both and keep their
   * slots. Returns the removed rows.
   */
  moveVertices(removed, added) {
    const { vertices } = this;
    const { width } = vertices;
    const removedRows = new Float64Array(removed.length * width);
    for (let i = 0, at = 0; i < removed.length; i++) {
      while (at < added.length && added[at] < removed[i]) at += width;
      const slot = slotOf(vertices, removed[i]);
      removedRows.set(vertices.rows.subarray(width * slot, width * (slot + 1)), width * i);
      if (added[at] === removed[i]) vertices.replace(slot, added, at);
      else vertices.remove(removed[i]);
    }
    for (let at = 0, i = 0; at < added.length; at += width) {
      while (i < removed.length && removed[i] < added[at]) i += 1;
      if (removed[i] !== added[at]) assertAdded(vertices.add(added, at), added, at);
    }
    return removedRows;
  }

  /** Removes and sets critical edges. Returns the inverse. */
  applyCritical(removed, set) {
    const { critical } = this;
    const old = [];
    const added = [];
    const keep = (slot) => old.push(...critical.rows.subarray(4 * slot, 4 * slot + 4));
    for (let at = 0; at < removed.length; at += 2) {
      keep(slotOf(critical, removed[at], removed[at + 1]));
      critical.remove(removed[at], removed[at + 1]);
    }
    for (let at = 0; at < set.length; at += 4) {
      const slot = critical.find(set[at], set[at + 1]);
      if (slot < 0) {
        critical.add(set, at);
        added.push(set[at], set[at + 1]);
      } else {
        keep(slot);
        critical.replace(slot, set, at);
      }
    }
    return { critical_set: Float64Array.from(old), critical_removed: Float64Array.from(added) };
  }

  /** Compares the checksum, and accepts the frame. */
  verify({ frame, checksum }) {
    let sum = 0n;
    for (const { sum: part } of [this.vertices, this.edges, this.critical]) {
      sum += (BigInt(part[0]) << 32n) + BigInt(part[1]);
    }
    if (BigInt.asUintN(64, sum) !== BigInt(checksum)) {
      throw new Contradiction(`the checksum of frame ${frame.number} is not that of what is held`);
    }
    this.frame = frame;
  }
}

/** The bytes of a change. @param {Change} change */
export const bytesOf = (change) => Object.values(change).reduce((sum, list) => sum + (list?.byteLength ?? 0), 0);

/** The slot of a row that must be there. */
function slotOf(elements, a, b = 0) {
  const slot = elements.find(a, b);
  if (slot < 0)
    throw new Contradiction(`${elements.ids > 1 ? `edge ${a}-${b}` : `vertex ${a}`} is removed but is not held`);
  return slot;
}

/** Refuses a row that was there already, which `slot` tells. */
function assertAdded(slot, list, at) {
  if (slot < 0) throw new Contradiction(`the row of ${list[at]} is added but is already held`);
}

function addAll(elements, list) {
  elements.reserve(elements.count + list.length / elements.width);
  for (let at = 0; at < list.length; at += elements.width) assertAdded(elements.add(list, at), list, at);
}

function removeAll(elements, list) {
  for (let at = 0; at < list.length; at += 2) {
    slotOf(elements, list[at], list[at + 1]);
    elements.remove(list[at], list[at + 1]);
  }
}

/** The first column of rows. */
function ids(list, width) {
  const column = new Float64Array(list.length / width);
  for (let i = 0; i < column.length; i++) column[i] = list[i * width];
  return column;
}
