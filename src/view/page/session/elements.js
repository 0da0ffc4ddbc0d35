//! A slot map of rows that change: vertices, edges or critical edges, found by their ids.
//!
//! In: rows.
//! Out: slots, which a row keeps from its addition to its removal; flags of the blocks of slots that changed.
//! Invariants: no allocation for a row. A free slot begins with -1. `sum` is the sum of the hashes of all rows modulo
//! 2^64, as [high, low].
//! Must not know: what rows mean, graphics.

import { hash, hashRow } from "./checksum.js";

/** Binary logarithm of the slots in a block, which are flagged as changed together. */
export const BLOCK_BITS = 10;

export class Elements {
  /** @param {number} kind the tag of such rows in hashes */
  constructor(kind, ids, width) {
    this.kind = kind;
    this.ids = ids;
    this.width = width;
    /** The number of rows. */
    this.count = 0;
    /** All rows are in slots below this one. */
    this.end = 0;
    this.sum = new Uint32Array(2);
    this.rows = new Float64Array(0);
    this.hashes = new Uint32Array(0);
    this.free = new Int32Array(0);
    this.freed = 0;
    /** 1 for each block of slots that changed since the renderer reset it to 0. */
    this.changed = new Uint8Array(0);
    /** Counts all changes. */
    this.version = 0;
    /** Hash table with open addressing: slots + 1, or 0 for an empty bucket. */
    this.table = new Int32Array(16);
  }

  /** Removes all rows, and reserves so many slots. */
  clear(slots = 0) {
    this.count = this.end = this.freed = 0;
    this.sum.fill(0);
    this.table.fill(0);
    this.changed.fill(1);
    this.version += 1;
    this.reserve(slots);
  }

  /** Reserves so many slots. */
  reserve(slots) {
    const capacity = this.hashes.length / 2;
    if (slots > capacity) this.grow(Math.max(slots, 2 * capacity, 1 << BLOCK_BITS));
    let size = this.table.length;
    while (size < 2 * slots) size *= 2;
    if (size > this.table.length) this.rehash(size);
  }

  grow(capacity) {
    const copied = (type, old, length) => {
      const grown = new type(length);
      grown.set(old);
      return grown;
    };
    this.rows = copied(Float64Array, this.rows, capacity * this.width);
    this.hashes = copied(Uint32Array, this.hashes, capacity * 2);
    this.free = copied(Int32Array, this.free, capacity);
    this.changed = new Uint8Array((capacity >> BLOCK_BITS) + 1).fill(1);
  }

  rehash(size) {
    this.table = new Int32Array(size);
    for (let slot = 0; slot < this.end; slot++) {
      if (this.rows[slot * this.width] >= 0) this.table[this.bucketOf(this.first(slot), this.second(slot))] = slot + 1;
    }
  }

  first(slot) {
    return this.rows[slot * this.width];
  }

  second(slot) {
    return this.ids > 1 ? this.rows[slot * this.width + 1] : 0;
  }

  /** The bucket of a row, or the empty one where it would be put. */
  bucketOf(a, b) {
    const mask = this.table.length - 1;
    let at = hashIds(a, b) & mask;
    for (; this.table[at] > 0; at = (at + 1) & mask) {
      const slot = this.table[at] - 1;
      if (this.first(slot) === a && this.second(slot) === b) break;
    }
    return at;
  }

  /** The slot of a row, or -1. */
  find(a, b = 0) {
    return this.table[this.bucketOf(a, b)] - 1;
  }

  /** Adds a row of a list. Returns its slot, or -1 if its ids are there already. @param {Float64Array} list */
  add(list, at) {
    this.reserve(this.count + 1);
    const bucket = this.bucketOf(list[at], this.ids > 1 ? list[at + 1] : 0);
    if (this.table[bucket] > 0) return -1;
    const slot = this.freed > 0 ? this.free[--this.freed] : this.end++;
    this.table[bucket] = slot + 1;
    this.count += 1;
    this.write(slot, list, at);
    return slot;
  }

  /** Replaces the row in a slot by a row of a list with the same ids. */
  replace(slot, list, at) {
    this.subtract(slot);
    this.write(slot, list, at);
  }

  /** Removes the row with these ids. Returns its slot, or -1. Its numbers stay readable until a row is added. */
  remove(a, b = 0) {
    const bucket = this.bucketOf(a, b);
    const slot = this.table[bucket] - 1;
    if (slot < 0) return -1;
    this.subtract(slot);
    this.emptyBucket(bucket);
    this.rows[slot * this.width] = -1;
    this.free[this.freed++] = slot;
    this.count -= 1;
    this.markChanged(slot);
    return slot;
  }

  write(slot, list, at) {
    const { width, rows } = this;
    for (let i = 0, to = slot * width; i < width; i++) rows[to + i] = list[at + i];
    hashRow(this.kind, rows, slot * width, this.ids, width);
    this.hashes[2 * slot] = hash[0];
    this.hashes[2 * slot + 1] = hash[1];
    const low = this.sum[1] + this.hashes[2 * slot + 1];
    this.sum[0] += this.hashes[2 * slot] + (low > 0xffffffff ? 1 : 0);
    this.sum[1] = low;
    this.markChanged(slot);
  }

  subtract(slot) {
    const low = this.sum[1] - this.hashes[2 * slot + 1];
    this.sum[0] -= this.hashes[2 * slot] + (low < 0 ? 1 : 0);
    this.sum[1] = low;
  }

  markChanged(slot) {
    this.changed[slot >> BLOCK_BITS] = 1;
    this.version += 1;
  }

  /** Empties a bucket, and shifts displaced entries back, so that no tombstone is needed. */
  emptyBucket(bucket) {
    const { table } = this;
    const mask = table.length - 1;
    let hole = bucket;
    for (let at = (hole + 1) & mask; table[at] > 0; at = (at + 1) & mask) {
      const slot = table[at] - 1;
      const wanted = hashIds(this.first(slot), this.second(slot)) & mask;
      if (((at - wanted) & mask) < ((at - hole) & mask)) continue;
      table[hole] = table[at];
      hole = at;
    }
    table[hole] = 0;
  }
}

/** Hashes two ids. */
function hashIds(a, b) {
  let mixed = Math.imul(a | 0, 0x9e3779b1) ^ Math.imul(((a / 0x100000000) | 0) + 1, 0x7feb352d);
  mixed = Math.imul(mixed ^ (mixed >>> 15) ^ (b | 0), 0x85ebca6b);
  return mixed ^ (mixed >>> 13);
}
