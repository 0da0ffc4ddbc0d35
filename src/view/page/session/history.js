//! The last pictures, to step back to: the changes between each two, and the annotations of each.
//!
//! In: changes with their inverses; annotations.
//! Out: the mirrors, moved to another frame.
//! Invariants: every step is a complete picture. Bytes and steps are bounded; the oldest are dropped first. A snapshot,
//! from which no change leads back, empties the history.
//! Must not know: sockets, graphics.

import { bytesOf } from "./mirror.js";

const MAX_BYTES = 48 << 20;
const MAX_FRAMES = 900;
/** Bytes that a living track takes, about, and those of a coordinate of its centre and velocity. */
const TRACK_BYTES = 208;
const COORDINATE_BYTES = 16;

/**
 * A change of a mirror, from a frame to another one.
 * @typedef {{mirror: import("./mirror.js").Mirror, forward: import("./mirror.js").Change,
 *   backward: import("./mirror.js").Change, from: any, to: any}} Move
 */
/**
 * What is drawn besides the skeleton: tracks (of the frame `tracksFrame`), dots (of the frame `dots.frame`; `isShown`
 * has 1 for each that is in the view; `holes` has label, centre and radius of some that are), and the number of the
 * simplified skeleton's frame, or null.
 * @typedef {import("./tracks.js").TrackState & {tracksFrame: number | null, simplified: number | null, dots: {
 *   frame: number | null, total: number, labels: Float64Array, isShown: Uint8Array, holes: Float64Array}}} Annotations
 */
/** @typedef {{moves: Move[], annotations: Annotations, bytes: number}} Step */

export class History {
  constructor() {
    this.clear();
  }

  clear() {
    /** @type {Step[]} */
    this.steps = [];
    this.bytes = 0;
    /** The index of the shown picture among the steps. */
    this.at = -1;
    this.newest = 0;
  }

  /** How many pictures before the shown one are held. */
  get before() {
    return Math.max(this.at, 0);
  }

  /** How many pictures after the shown one are held. */
  get after() {
    return this.steps.length - 1 - this.at;
  }

  /** Begins with a picture. @param {Annotations} annotations */
  restart(frame, annotations) {
    this.clear();
    this.push(frame, [], annotations);
  }

  /** Appends a picture, which is the shown one from now on. @param {Move[]} moves @param {Annotations} annotations */
  push(frame, moves, annotations) {
    const before = this.steps[this.steps.length - 1]?.annotations;
    const ofMoves = moves.reduce((sum, { forward, backward }) => sum + bytesOf(forward) + bytesOf(backward), 0);
    const bytes = ofMoves + annotationBytes(annotations, before);
    this.steps.push({ moves, annotations, bytes });
    this.bytes += bytes;
    this.newest = frame.number;
    let surplus = 0;
    while (surplus < this.steps.length - 1 && (this.bytes > MAX_BYTES || this.steps.length - surplus > MAX_FRAMES)) {
      this.bytes -= this.steps[surplus++].bytes;
    }
    if (surplus > 0) this.steps.splice(0, surplus);
    this.at = this.steps.length - 1;
  }

  /** Replaces the annotations of the newest picture, which shows the same frame. @param {Annotations} annotations */
  replace(annotations) {
    if (this.steps.length > 0) this.steps[this.steps.length - 1].annotations = annotations;
  }

  /** Moves the mirrors by so many pictures, or as far as there are any. Returns the annotations of the one reached. */
  moveBy(by) {
    if (this.steps.length === 0) return null;
    const target = Math.max(0, Math.min(this.steps.length - 1, this.at + by));
    while (this.at > target) {
      for (const { mirror, backward, from } of this.steps[this.at].moves.toReversed()) mirror.moveTo(backward, from);
      this.at -= 1;
    }
    while (this.at < target) {
      this.at += 1;
      for (const { mirror, forward, to } of this.steps[this.at].moves) mirror.moveTo(forward, to);
    }
    return this.steps[this.at].annotations;
  }
}

/** The bytes of annotations that the picture before does not share: tracks, new cycles, new dots. */
function annotationBytes({ alive, cycles, dots }, before) {
  const ofCenters = alive.reduce((sum, { center }) => sum + COORDINATE_BYTES * center.length, 0);
  let bytes = TRACK_BYTES * (alive.length + 1) + ofCenters + dots.isShown.byteLength + dots.holes.byteLength;
  if (dots.labels !== before?.dots.labels) bytes += dots.labels.byteLength;
  if (cycles === before?.cycles) return bytes;
  for (const [id, walks] of cycles) {
    if (walks !== before?.cycles.get(id)) for (const walk of walks) bytes += walk.byteLength;
  }
  return bytes;
}
