//! A set of rows that come and go: vertices, edges or critical edges, found by their ids.
//!
//! In: rows. Out: slots, that stay a row's own as long as it lives, and blocks of slots that have changed.
//! Invariants: no allocation for a row; slots that are free begin with -1; `sum` is the sum of the hashes of all
//! rows, modulo 2^64, as [high, low]. Must not know: what the rows mean, graphics.

import { hash, hashRow } from "./checksum.js";

/** So many slots (a power of 2) are marked as changed together. */
export const BLOCK_BITS = 10;

export class Elements {
  /** @param {number} kind the mark of such rows in hashes */
  constructor(kind, ids, width) {
    this.kind = kind;
    this.ids = ids;
    this.width = width;
    /** How many rows there are. */
    this.count = 0;
    /** All rows lie in slots below this one. */
    this.end = 0;
    this.sum = new Uint32Array(2);
    this.rows = new Float64Array(0);
    this.hashes = new Uint32Array(0);
    this.free = new Int32Array(0);
    this.freed = 0;
    /** 1 for each block of slots that has changed since whoever draws it has set it to 0. */
    this.changed = new Uint8Array(0);
    /** Counts all changes. */
    this.version = 0;
    /** Slots + 1 by hash, 0 where there is none. */
    this.table = new Int32Array(16);
  }

  /** Drops all rows, and makes room for so many. */
  clear(room = 0) {
    this.count = this.end = this.freed = 0;
    this.sum.fill(0);
    this.table.fill(0);
    this.changed.fill(1);
    this.version += 1;
    this.reserve(room);
  }

  /** Makes room for so many slots. */
  reserve(slots) {
    const room = this.hashes.length / 2;
    if (slots > room) this.grow(Math.max(slots, 2 * room, 1 << BLOCK_BITS));
    let size = this.table.length;
    while (size < 2 * slots) size *= 2;
    if (size > this.table.length) this.rehash(size);
  }

  grow(room) {
    const moved = (type, old, length) => {
      const grown = new type(length);
      grown.set(old);
      return grown;
    };
    this.rows = moved(Float64Array, this.rows, room * this.width);
    this.hashes = moved(Uint32Array, this.hashes, room * 2);
    this.free = moved(Int32Array, this.free, room);
    this.changed = new Uint8Array((room >> BLOCK_BITS) + 1).fill(1);
  }

  rehash(size) {
    this.table = new Int32Array(size);
    for (let slot = 0; slot < this.end; slot++) {
      if (this.rows[slot * this.width] >= 0) this.table[this.place(this.first(slot), this.second(slot))] = slot + 1;
    }
  }

  first(slot) {
    return this.rows[slot * this.width];
  }

  second(slot) {
    return this.ids > 1 ? this.rows[slot * this.width + 1] : 0;
  }

  /** Where in the table a row is, or would be. */
  place(a, b) {
    const mask = this.table.length - 1;
    let at = home(a, b) & mask;
    for (; this.table[at] > 0; at = (at + 1) & mask) {
      const slot = this.table[at] - 1;
      if (this.first(slot) === a && this.second(slot) === b) break;
    }
    return at;
  }

  /** The slot of a row, or -1. */
  find(a, b = 0) {
    return this.table[this.place(a, b)] - 1;
  }

  /** Adds a row of a list. Gives its slot, or -1 if there is one with these ids. @param {Float64Array} list */
  add(list, at) {
    this.reserve(this.count + 1);
    const place = this.place(list[at], this.ids > 1 ? list[at + 1] : 0);
    if (this.table[place] > 0) return -1;
    const slot = this.freed > 0 ? this.free[--this.freed] : this.end++;
    this.table[place] = slot + 1;
    this.count += 1;
    this.write(slot, list, at);
    return slot;
  }

  /** Puts a row of a list in the place of the one with its ids, which is in this slot. */
  replace(slot, list, at) {
    this.subtract(slot);
    this.write(slot, list, at);
  }

  /** Removes the row with these ids. Gives the slot it was in, or -1. Its numbers stand there until a row is added. */
  remove(a, b = 0) {
    const place = this.place(a, b);
    const slot = this.table[place] - 1;
    if (slot < 0) return -1;
    this.subtract(slot);
    this.close(place);
    this.rows[slot * this.width] = -1;
    this.free[this.freed++] = slot;
    this.count -= 1;
    this.touch(slot);
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
    this.touch(slot);
  }

  subtract(slot) {
    const low = this.sum[1] - this.hashes[2 * slot + 1];
    this.sum[0] -= this.hashes[2 * slot] + (low < 0 ? 1 : 0);
    this.sum[1] = low;
  }

  touch(slot) {
    this.changed[slot >> BLOCK_BITS] = 1;
    this.version += 1;
  }

  /** Empties a place of the table, and moves up what was pushed on by it, so that no mark has to stay behind. */
  close(place) {
    const { table } = this;
    const mask = table.length - 1;
    let hole = place;
    for (let at = (hole + 1) & mask; table[at] > 0; at = (at + 1) & mask) {
      const slot = table[at] - 1;
      const wanted = home(this.first(slot), this.second(slot)) & mask;
      if (((at - wanted) & mask) < ((at - hole) & mask)) continue;
      table[hole] = table[at];
      hole = at;
    }
    table[hole] = 0;
  }
}

/** Mixes two ids. */
function home(a, b) {
  let mixed = Math.imul(a | 0, 0x9e3779b1) ^ Math.imul(((a / 0x100000000) | 0) + 1, 0x7feb352d);
  mixed = Math.imul(mixed ^ (mixed >>> 15) ^ (b | 0), 0x85ebca6b);
  return mixed ^ (mixed >>> 13);
}
