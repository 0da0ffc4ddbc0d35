//! The last frames, to step back to: how to get from each to its neighbours, and what was drawn beside it.
//!
//! In: changes with those that take them back. Out: the mirror, moved. Invariants: at most so many bytes and frames
//! are held, the oldest go first; a snapshot, which nothing leads back from, begins anew. Must not know: sockets,
//! graphics.

import { bytesOf } from "./mirror.js";

const LARGEST = 48 << 20;
const MOST = 900;
/** What a living track takes, about. */
const TRACK_BYTES = 240;

/**
 * A frame that one can go to.
 * @typedef {{frame: any, forth: import("./mirror.js").Change | null, back: import("./mirror.js").Change | null,
 *   beside: any, bytes: number, bytesBeside: number}} Step
 */

export class History {
  constructor() {
    this.clear();
  }

  clear() {
    /** @type {Step[]} */
    this.steps = [];
    this.bytes = 0;
    /** The place of the frame shown among the steps. */
    this.at = -1;
  }

  /** How many frames before the one shown are held. */
  get before() {
    return Math.max(this.at, 0);
  }

  /** How many frames after the one shown are held. */
  get after() {
    return this.steps.length - 1 - this.at;
  }

  /** A snapshot has come. */
  restart(frame) {
    this.clear();
    this.append({ frame, forth: null, back: null, beside: null, bytes: 0, bytesBeside: 0 });
  }

  /** A diff has come. The frame shown is the newest. */
  push(frame, forth, back) {
    this.append({ frame, forth, back, beside: null, bytes: bytesOf(forth) + bytesOf(back), bytesBeside: 0 });
  }

  append(step) {
    this.steps.push(step);
    this.bytes += step.bytes;
    let surplus = 0;
    while (surplus < this.steps.length - 1 && (this.bytes > LARGEST || this.steps.length - surplus > MOST)) {
      this.bytes -= this.steps[surplus++].bytes;
    }
    if (surplus > 0) this.steps.splice(0, surplus);
    this.at = this.steps.length - 1;
  }

  /** Keeps what is drawn beside the newest frame: its living tracks and their cycles, its dots. */
  annotate(beside) {
    const newest = this.steps[this.steps.length - 1];
    if (!newest) return;
    const bytes = bytesBeside(beside, this.steps[this.steps.length - 2]?.beside);
    newest.bytes += bytes - newest.bytesBeside;
    this.bytes += bytes - newest.bytesBeside;
    [newest.beside, newest.bytesBeside] = [beside, bytes];
  }

  /** Moves the mirror by so many frames, or as far as there are any. Gives what was drawn beside the frame. */
  go(mirror, by) {
    if (this.steps.length === 0) return null;
    const target = Math.max(0, Math.min(this.steps.length - 1, this.at + by));
    while (this.at > target) {
      const { back } = this.steps[this.at];
      this.at -= 1;
      mirror.jump(back, this.steps[this.at].frame);
    }
    while (this.at < target) {
      this.at += 1;
      const { forth, frame } = this.steps[this.at];
      mirror.jump(forth, frame);
    }
    return this.steps[this.at]?.beside ?? null;
  }
}

/** What is held for a frame beside what is shared with the one before: tracks, walks that are new, dots. */
function bytesBeside({ alive, cycles, dots }, before) {
  let bytes = TRACK_BYTES * (alive.length + 1);
  if (dots !== before?.dots) bytes += dots.labels.byteLength;
  if (cycles === before?.cycles) return bytes;
  for (const [id, walks] of cycles) {
    if (walks !== before?.cycles.get(id)) for (const walk of walks) bytes += walk.byteLength;
  }
  return bytes;
}
