//! The lives of tracks: when each began and ended and how, while it may still be seen.
//!
//! In: events of tracks. Out: lives, each in a lane of its own as long as it lasts. Invariants: at most so many lives
//! are held, and none that ended so many frames ago; a lane has one life at a time. Must not know: drawing, messages'
//! bytes.

/** Lives that ended longer ago than this many frames are forgotten. */
export const SPAN = 1800;
const MOST = 4000;
/** Changes of selection kept of one life. */
const MOST_CHANGES = 64;
/** Frames that a lane stays empty between two lives. */
const REST = 12;

/**
 * `pale` are frames at which it leaves and enters the selection, in turn. `to` is null while it lives.
 * @typedef {{id: number, lane: number, from: number, to: number | null, began: "born" | "split" | "before",
 *   parent: number | null, ended: "died" | "merged" | "unseen" | null, into: number | null, pale: number[]}} Life
 */

export class Lifelines {
  constructor() {
    this.clear();
  }

  clear() {
    /** In the order in which they were told of. @type {Map<number, Life>} */
    this.lives = new Map();
    /** The last frame of the life that each lane holds or held; Infinity while it lives. @type {number[]} */
    this.lanes = [];
  }

  /** Takes what happened to a track. */
  take({ frame, happening, track }) {
    const [kind, field] = typeof happening === "string" ? [happening, null] : Object.entries(happening)[0];
    if (kind === "Born") this.begin(track, frame, "born", null);
    else if (kind === "Split") this.begin(track, frame, "split", field);
    const life = this.lives.get(track.id);
    if (!life) return;
    if (kind === "Died") this.end(life, frame, "died", null);
    else if (kind === "Merged") this.end(life, frame, "merged", field);
    else if (kind === "Unselected" || kind === "Reselected") select(life, frame, kind === "Reselected");
  }

  /** Starts from all living tracks: what is not among them has ended while nobody looked. */
  restart(frame, alive) {
    const ids = new Set(alive.map((track) => track.id));
    for (const life of this.lives.values()) {
      if (life.to === null && !ids.has(life.id)) this.end(life, frame, "unseen", null);
    }
    for (const track of alive) {
      if (!this.lives.has(track.id)) this.begin(track, frame, "before", null);
      select(this.lives.get(track.id), frame, track.selected);
    }
  }

  begin(track, frame, began, parent) {
    const from = Math.max(1, frame - track.age + 1);
    const lane = this.freeLane(from, this.lives.get(parent)?.lane ?? 0);
    this.lanes[lane] = Infinity;
    this.lives.set(track.id, {
      id: track.id,
      lane,
      from,
      to: null,
      began,
      parent,
      ended: null,
      into: null,
      pale: track.selected ? [] : [from],
    });
  }

  end(life, frame, ended, into) {
    life.to = frame;
    life.ended = ended;
    life.into = into;
    this.lanes[life.lane] = frame;
  }

  /** The free lane nearest to another one. */
  freeLane(from, near) {
    let best = this.lanes.length;
    this.lanes.forEach((end, lane) => {
      if (end + REST < from && Math.abs(lane - near) < Math.abs(best - near)) best = lane;
    });
    return best;
  }

  /** Forgets what ended long ago. */
  forget(frame) {
    for (const [id, life] of this.lives) {
      const old = life.to !== null && life.to < frame - SPAN;
      if (old || (life.to !== null && this.lives.size > MOST)) this.lives.delete(id);
    }
    while (this.lanes.length > 0 && this.lanes[this.lanes.length - 1] < frame - SPAN) this.lanes.pop();
  }
}

/** Notes that a life enters or leaves the selection. @param {Life} life */
function select(life, frame, selected) {
  const isPale = life.pale.length % 2 === 1;
  if (isPale === !selected) return;
  life.pale.push(frame);
  if (life.pale.length > MOST_CHANGES) life.pale.splice(0, 2);
}
