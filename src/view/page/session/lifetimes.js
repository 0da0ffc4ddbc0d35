//! Lifetimes of tracks: when each began and ended, and how, as long as it can be shown.
//!
//! In: events of tracks.
//! Out: lifetimes, each in one lane from beginning to end.
//! Invariants: the number of lifetimes is bounded, and those that ended long ago are dropped. A lane holds one lifetime
//! at a time.
//! Must not know: drawing, bytes of messages.

/** Lifetimes that ended more than so many frames ago are dropped. */
export const SPAN = 1800;
const MAX_LIFETIMES = 4000;
/** How many changes of the selection are kept of one lifetime. */
const MAX_CHANGES = 64;
/** Frames between two lifetimes in one lane at the least. */
const LANE_GAP = 12;

/**
 * `selectionChanges` are the frames at which the track leaves and enters the selection, in turn. `to` is null while it
 * lives. It began "before" if its beginning was not seen, and ended "unseen" if its end was not.
 * @typedef {{id: number, lane: number, from: number, to: number | null, began: "born" | "split" | "before",
 *   parent: number | null, ended: "died" | "merged" | "unseen" | null, into: number | null,
 *   selectionChanges: number[]}} Lifetime
 */

export class Lifetimes {
  constructor() {
    this.clear();
  }

  clear() {
    /** By the track's id, in the order in which they began. @type {Map<number, Lifetime>} */
    this.byId = new Map();
    /** The last frame of the newest lifetime of each lane; Infinity while it lives. @type {number[]} */
    this.lanes = [];
  }

  /** Applies an event. */
  apply({ frame, happening, track }) {
    const [kind, field] = typeof happening === "string" ? [happening, null] : Object.entries(happening)[0];
    if (kind === "Born") this.begin(track, frame, "born", null);
    else if (kind === "Split") this.begin(track, frame, "split", field);
    const lifetime = this.byId.get(track.id);
    if (!lifetime) return;
    if (kind === "Died") this.end(lifetime, frame, "died", null);
    else if (kind === "Merged") this.end(lifetime, frame, "merged", field);
    else if (kind === "Unselected" || kind === "Reselected") select(lifetime, frame, kind === "Reselected");
  }

  /** Starts again from all living tracks. A lifetime that is not among them ended between the two frames. */
  restart(frame, alive) {
    const ids = new Set(alive.map((track) => track.id));
    for (const lifetime of this.byId.values()) {
      if (lifetime.to === null && !ids.has(lifetime.id)) this.end(lifetime, frame, "unseen", null);
    }
    for (const track of alive) {
      if (!this.byId.has(track.id)) this.begin(track, frame, "before", null);
      select(this.byId.get(track.id), frame, track.selected);
    }
  }

  begin(track, frame, began, parent) {
    const from = Math.max(1, frame - track.age + 1);
    const lane = this.freeLane(from, this.byId.get(parent)?.lane ?? 0);
    this.lanes[lane] = Infinity;
    this.byId.set(track.id, {
      id: track.id,
      lane,
      from,
      to: null,
      began,
      parent,
      ended: null,
      into: null,
      selectionChanges: track.selected ? [] : [from],
    });
  }

  end(lifetime, frame, ended, into) {
    lifetime.to = frame;
    lifetime.ended = ended;
    lifetime.into = into;
    this.lanes[lifetime.lane] = frame;
  }

  /** The free lane nearest to another one. */
  freeLane(from, near) {
    let best = this.lanes.length;
    this.lanes.forEach((end, lane) => {
      if (end + LANE_GAP < from && Math.abs(lane - near) < Math.abs(best - near)) best = lane;
    });
    return best;
  }

  /** Drops lifetimes that ended long before a frame. */
  prune(frame) {
    for (const [id, { to }] of this.byId) {
      const isOld = to !== null && to < frame - SPAN;
      if (isOld || (to !== null && this.byId.size > MAX_LIFETIMES)) this.byId.delete(id);
    }
    while (this.lanes.length > 0 && this.lanes[this.lanes.length - 1] < frame - SPAN) this.lanes.pop();
  }
}

/** Notes that a track enters or leaves the selection. @param {Lifetime} lifetime */
function select({ selectionChanges }, frame, selected) {
  const isUnselected = selectionChanges.length % 2 === 1;
  if (isUnselected === !selected) return;
  selectionChanges.push(frame);
  if (selectionChanges.length > MAX_CHANGES) selectionChanges.splice(0, 2);
}
