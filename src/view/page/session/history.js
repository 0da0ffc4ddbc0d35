//! The last frames, to step back to: the change between each two, and the annotations of each.
//!
//! In: changes with their inverses; annotations.
//! Out: the mirror, moved to another frame.
//! Invariants: bytes and frames are bounded; the oldest frames are dropped first. A snapshot, from which no change
//! leads back, empties the history.
//! Must not know: sockets, graphics.

import { bytesOf } from "./mirror.js";

const MAX_BYTES = 48 << 20;
const MAX_FRAMES = 900;
/** Bytes that a living track takes, about. */
const TRACK_BYTES = 240;

/** @typedef {import("./mirror.js").Change} Change */
/**
 * What is drawn besides the skeleton: the tracks of a frame and its dots.
 * @typedef {import("./tracks.js").TrackState & {dots: {total: number, labels: Float64Array}}} Annotations
 */
/**
 * A frame of the history; `forward` leads to it from the frame before, `backward` leads from it to that frame.
 * @typedef {{frame: any, forward: Change | null, backward: Change | null,
 *   annotations: Annotations | null, bytes: number, annotationBytes: number}} Step
 */

export class History {
  constructor() {
    this.clear();
  }

  clear() {
    /** @type {Step[]} */
    this.steps = [];
    this.bytes = 0;
    /** The index of the shown frame among the steps. */
    this.at = -1;
  }

  /** How many frames before the shown one are held. */
  get before() {
    return Math.max(this.at, 0);
  }

  /** How many frames after the shown one are held. */
  get after() {
    return this.steps.length - 1 - this.at;
  }

  /** Begins with the frame of a snapshot. */
  restart(frame) {
    this.clear();
    this.append({ frame, forward: null, backward: null, annotations: null, bytes: 0, annotationBytes: 0 });
  }

  /** Appends the frame of a diff, which is the shown one from now on. */
  push(frame, forward, backward) {
    const bytes = bytesOf(forward) + bytesOf(backward);
    this.append({ frame, forward, backward, annotations: null, bytes, annotationBytes: 0 });
  }

  append(step) {
    this.steps.push(step);
    this.bytes += step.bytes;
    let surplus = 0;
    while (surplus < this.steps.length - 1 && (this.bytes > MAX_BYTES || this.steps.length - surplus > MAX_FRAMES)) {
      this.bytes -= this.steps[surplus++].bytes;
    }
    if (surplus > 0) this.steps.splice(0, surplus);
    this.at = this.steps.length - 1;
  }

  /** Keeps the annotations of the newest frame. @param {Annotations} annotations */
  annotate(annotations) {
    const newest = this.steps[this.steps.length - 1];
    if (!newest) return;
    const bytes = annotationBytes(annotations, this.steps[this.steps.length - 2]?.annotations);
    newest.bytes += bytes - newest.annotationBytes;
    this.bytes += bytes - newest.annotationBytes;
    [newest.annotations, newest.annotationBytes] = [annotations, bytes];
  }

  /** Moves the mirror by so many frames, or as far as there are any. Returns the annotations of the frame reached. */
  moveBy(mirror, by) {
    if (this.steps.length === 0) return null;
    const target = Math.max(0, Math.min(this.steps.length - 1, this.at + by));
    while (this.at > target) {
      const { backward } = this.steps[this.at];
      this.at -= 1;
      mirror.moveTo(backward, this.steps[this.at].frame);
    }
    while (this.at < target) {
      this.at += 1;
      const { forward, frame } = this.steps[this.at];
      mirror.moveTo(forward, frame);
    }
    return this.steps[this.at]?.annotations ?? null;
  }
}

/** The bytes of annotations that the frame before does not share: tracks, new cycles, new dots. */
function annotationBytes({ alive, cycles, dots }, before) {
  let bytes = TRACK_BYTES * (alive.length + 1);
  if (dots !== before?.dots) bytes += dots.labels.byteLength;
  if (cycles === before?.cycles) return bytes;
  for (const [id, walks] of cycles) {
    if (walks !== before?.cycles.get(id)) for (const walk of walks) bytes += walk.byteLength;
  }
  return bytes;
}
