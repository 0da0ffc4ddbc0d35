//! Living tracks and their cycles, as `Tracks` messages lead from one frame to the next.
//!
//! In: `Tracks` messages, which were requested with `Cycles`.
//! Out: the living tracks, their cycles by id, the lifetimes of tracks.
//! Invariants: lists and maps are replaced and never changed, so a reference to those of a frame stays valid.
//! Must not know: skeletons, drawing, sockets.

import { Lifetimes } from "./lifetimes.js";

/** @typedef {import("./protocol.js").Track} Track */
/**
 * The tracks that live in one frame.
 * @typedef {{alive: Track[], byId: Map<number, Track>, cycles: Map<number, Float64Array[]>}} TrackState
 */

/** @returns {TrackState} */
export const emptyTracks = () => ({ alive: [], byId: new Map(), cycles: new Map() });

export class Tracks {
  constructor() {
    this.lifetimes = new Lifetimes();
    this.clear();
  }

  /** Drops everything: in another stream or another epoch the ids have no meaning. */
  clear() {
    this.lifetimes.clear();
    this.current = emptyTracks();
    this.restart();
  }

  /** Ignores every message until one starts from 0. */
  restart() {
    /** The frame of `current`, or null while it is not in sync. */
    this.frame = null;
  }

  /** Applies a message. False if it contradicts the current state, so that tracks must be requested again. */
  apply(message) {
    if (message.from === 0) {
      this.lifetimes.restart(message.frame, message.alive ?? []);
    } else if (this.frame === null) {
      return true;
    } else if (!this.applyEvents(message)) {
      this.restart();
      return false;
    }
    this.current = stateAfter(message, this.current.cycles);
    this.frame = message.frame;
    this.lifetimes.prune(message.frame);
    return true;
  }

  /** Applies the events of a message. False if they do not lead from the tracks alive before to those alive now. */
  applyEvents(message) {
    if (message.from !== this.frame) return false;
    const ids = new Set(this.current.byId.keys());
    for (const event of message.events) {
      const { id } = event.track;
      const kind = typeof event.happening === "string" ? event.happening : Object.keys(event.happening)[0];
      const begins = kind === "Born" || kind === "Split";
      if (ids.has(id) === begins) return false;
      if (begins) ids.add(id);
      if (kind === "Died" || kind === "Merged") ids.delete(id);
      this.lifetimes.apply(event);
    }
    return message.alive?.length === ids.size && message.alive.every((track) => ids.has(track.id));
  }
}

/** The state after a message, which has only the cycles that changed. @returns {TrackState} */
function stateAfter({ from, alive, cycles: changed }, before) {
  const byId = new Map((alive ?? []).map((track) => [track.id, track]));
  if (from !== 0 && changed.length === 0 && [...before.keys()].every((id) => byId.has(id))) {
    return { alive, byId, cycles: before };
  }
  const cycles = new Map();
  if (from !== 0) for (const [id, walks] of before) if (byId.has(id)) cycles.set(id, walks);
  for (const { id, walks } of changed) cycles.set(id, walks);
  return { alive: alive ?? [], byId, cycles };
}
