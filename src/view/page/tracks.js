//! Living tracks and their cycles, as `Tracks` messages lead from one frame to the next.
//!
//! In: `Tracks` (asked for with `Cycles`). Out: who lives, their cycles by id, and their lives. Invariants: lists and
//! maps are replaced, never changed, so whoever keeps those of a frame keeps that frame. Must not know: skeletons,
//! drawing, sockets.

import { Lifelines } from "./lifelines.js";

/** @typedef {import("./protocol.js").Track} Track */
/**
 * What lives in one frame.
 * @typedef {{alive: Track[], byId: Map<number, Track>, cycles: Map<number, Float64Array[]>}} Living
 */

/** @returns {Living} */
export const nobody = () => ({ alive: [], byId: new Map(), cycles: new Map() });

export class Tracks {
  constructor() {
    this.lifelines = new Lifelines();
    this.clear();
  }

  /** Another stream, or another epoch: ids mean nothing any more. */
  clear() {
    this.lifelines.clear();
    this.living = nobody();
    this.restart();
  }

  /** Passes over everything until a message starts from 0. */
  restart() {
    /** The frame known, or null. */
    this.frame = null;
  }

  /** Follows a message. False if it does not go with what is known, so that tracks must be asked for again. */
  take(message) {
    if (message.from === 0) {
      this.lifelines.restart(message.frame, message.alive ?? []);
    } else if (this.frame === null) {
      return true;
    } else if (!this.follow(message)) {
      this.restart();
      return false;
    }
    this.living = livingAfter(message, this.living.cycles);
    this.frame = message.frame;
    this.lifelines.forget(message.frame);
    return true;
  }

  /** Follows events, and tells whether they lead from who was alive to who is. */
  follow(message) {
    if (message.from !== this.frame) return false;
    const ids = new Set(this.living.byId.keys());
    for (const event of message.events) {
      const { id } = event.track;
      const kind = typeof event.happening === "string" ? event.happening : Object.keys(event.happening)[0];
      const begins = kind === "Born" || kind === "Split";
      if (ids.has(id) === begins) return false;
      if (begins) ids.add(id);
      if (kind === "Died" || kind === "Merged") ids.delete(id);
      this.lifelines.take(event);
    }
    return message.alive?.length === ids.size && message.alive.every((track) => ids.has(track.id));
  }
}

/** @returns {Living} */
function livingAfter({ from, alive, cycles: told }, before) {
  const byId = new Map((alive ?? []).map((track) => [track.id, track]));
  if (from !== 0 && told.length === 0 && [...before.keys()].every((id) => byId.has(id))) {
    return { alive, byId, cycles: before };
  }
  const cycles = new Map();
  if (from !== 0) for (const [id, walks] of before) if (byId.has(id)) cycles.set(id, walks);
  for (const { id, walks } of told) cycles.set(id, walks);
  return { alive: alive ?? [], byId, cycles };
}
