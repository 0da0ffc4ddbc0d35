//! A copy of one view of one stream: what snapshots and diffs lead to, each proved by its checksum.
//!
//! In: `Snapshot`, `Diff`. Out: rows of vertices, edges and critical edges; for each diff the one that takes it back.
//! Invariants: a vertex that stays keeps its slot, also where it moves. After a `Contradiction` nothing of it is of
//! use until the next snapshot. Must not know: tracks, graphics, sockets.

import { Elements } from "./elements.js";

/** What came does not go with what is held. */
export class Contradiction extends Error {}

/**
 * What a diff does, as rows.
 * @typedef {{vertices_added: Float64Array, vertices_removed: Float64Array, edges_added: Float64Array,
 *   edges_removed: Float64Array, critical_set: Float64Array, critical_removed: Float64Array}} Change
 */

export class Mirror {
  constructor() {
    this.vertices = new Elements(1, 1, 3);
    this.edges = new Elements(2, 2, 2);
    this.critical = new Elements(3, 2, 4);
    /** The frame that is held, or null. */
    this.frame = null;
  }

  /** Replaces everything. */
  takeSnapshot(snapshot) {
    this.frame = null;
    for (const [elements, list] of [
      [this.vertices, snapshot.vertices],
      [this.edges, snapshot.edges],
      [this.critical, snapshot.critical],
    ]) {
      elements.clear(list.length / elements.width);
      addAll(elements, list);
    }
    this.prove(snapshot);
  }

  /** Follows a diff. @returns {Change} what takes it back */
  takeDiff(diff) {
    if (this.frame?.number !== diff.from) {
      throw new Contradiction(`a diff from frame ${diff.from} came, and frame ${this.frame?.number ?? "none"} is held`);
    }
    this.frame = null;
    const back = this.change(diff);
    this.prove(diff);
    return back;
  }

  /** Goes to another frame by a change that is known to lead there. @param {Change} change */
  jump(change, frame) {
    this.change(change);
    this.frame = frame;
  }

  /** @param {Change} change @returns {Change} */
  change(change) {
    const vertices_removed = ids(change.vertices_added, 3);
    const vertices_added = this.moveVertices(change.vertices_removed, change.vertices_added);
    removeAll(this.edges, change.edges_removed);
    addAll(this.edges, change.edges_added);
    const back = this.changeCritical(change.critical_removed, change.critical_set);
    const [edges_added, edges_removed] = [change.edges_removed, change.edges_added];
    return { vertices_added, vertices_removed, edges_added, edges_removed, ...back };
  }

  /**
   * Removes and adds vertices. Both lists are sorted, so those in both are found in passing. Gives the rows removed.
   */
  moveVertices(removed, added) {
    const { vertices } = this;
    const gone = new Float64Array(removed.length * 3);
    for (let i = 0, at = 0; i < removed.length; i++) {
      while (at < added.length && added[at] < removed[i]) at += 3;
      const slot = found(vertices, removed[i]);
      gone.set(vertices.rows.subarray(3 * slot, 3 * slot + 3), 3 * i);
      if (added[at] === removed[i]) vertices.replace(slot, added, at);
      else vertices.remove(removed[i]);
    }
    for (let at = 0, i = 0; at < added.length; at += 3) {
      while (i < removed.length && removed[i] < added[at]) i += 1;
      if (removed[i] !== added[at]) isNew(vertices.add(added, at), added, at);
    }
    return gone;
  }

  changeCritical(removed, set) {
    const { critical } = this;
    const old = [];
    const fresh = [];
    const keep = (slot) => old.push(...critical.rows.subarray(4 * slot, 4 * slot + 4));
    for (let at = 0; at < removed.length; at += 2) {
      keep(found(critical, removed[at], removed[at + 1]));
      critical.remove(removed[at], removed[at + 1]);
    }
    for (let at = 0; at < set.length; at += 4) {
      const slot = critical.find(set[at], set[at + 1]);
      if (slot < 0) {
        critical.add(set, at);
        fresh.push(set[at], set[at + 1]);
      } else {
        keep(slot);
        critical.replace(slot, set, at);
      }
    }
    return { critical_set: Float64Array.from(old), critical_removed: Float64Array.from(fresh) };
  }

  /** Compares checksum and counts, and takes the frame as held. */
  prove({ frame, checksum }) {
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

/** The bytes that a change takes. @param {Change} change */
export const bytesOf = (change) => Object.values(change).reduce((sum, list) => sum + (list?.byteLength ?? 0), 0);

/** A vertex's slot, which must be there. */
function found(elements, a, b = 0) {
  const slot = elements.find(a, b);
  if (slot < 0)
    throw new Contradiction(`${elements.ids > 1 ? `edge ${a}-${b}` : `vertex ${a}`} is to go and is not there`);
  return slot;
}

function isNew(slot, list, at) {
  if (slot < 0) throw new Contradiction(`what begins with ${list[at]} is to come and is there already`);
}

function addAll(elements, list) {
  elements.reserve(elements.count + list.length / elements.width);
  for (let at = 0; at < list.length; at += elements.width) isNew(elements.add(list, at), list, at);
}

function removeAll(elements, list) {
  for (let at = 0; at < list.length; at += 2) {
    found(elements, list[at], list[at + 1]);
    elements.remove(list[at], list[at + 1]);
  }
}

/** The first column of rows. */
function ids(list, width) {
  const column = new Float64Array(list.length / width);
  for (let i = 0; i < column.length; i++) column[i] = list[i * width];
  return column;
}
