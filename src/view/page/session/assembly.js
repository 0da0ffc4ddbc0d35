//! Complete pictures: the messages of a frame are held back until all that belongs to it is there.
//!
//! In: messages of a subscription (frames, dots, tracks) and of one to the simplified view (frames).
//! Out: the newest frame of which all is there, with the messages that lead to it.
//! Invariants: a picture is of one frame: skeleton, dots and tracks, and the simplified skeleton if it is wanted. What
//! is held back is bounded.
//! Must not know: sockets, mirrors, drawing.

/** Frames that are held back at the most. More are a sign that something will never come. */
const MAX_PENDING = 256;

/**
 * The number of a frame that a consumer holds, and what of it is there.
 * @typedef {{frame: any, dots: number | null, tracks: number | null, simplified: any}} Held
 * @typedef {{name: "Snapshot" | "Diff", body: any}} FrameMessage
 * @typedef {{number: number, frames: FrameMessage[], simplified: FrameMessage[], dots: any, tracks: any[]}} Picture
 */

export class Assembly {
  constructor() {
    this.clear();
  }

  /** Drops everything. */
  clear() {
    /** @type {FrameMessage[]} */
    this.frames = [];
    this.clearSimplified();
    /** Dots by their frame; null for those that are as before. @type {{frame: number, dots: any}[]} */
    this.dots = [];
    this.tracks = [];
  }

  /** Drops the frames of the simplified view. */
  clearSimplified() {
    /** @type {FrameMessage[]} */
    this.simplified = [];
  }

  /** Adds a frame. A snapshot replaces all before it. */
  addFrame(name, body) {
    this.frames = name === "Snapshot" ? [{ name, body }] : [...this.frames, { name, body }];
  }

  /** The same, of the simplified view. */
  addSimplified(name, body) {
    this.simplified = name === "Snapshot" ? [{ name, body }] : [...this.simplified, { name, body }];
  }

  /** Adds the dots of a frame, or null if those before are those of that frame too. */
  addDots(frame, dots) {
    this.dots.push({ frame, dots });
  }

  addTracks(tracks) {
    this.tracks.push(tracks);
  }

  /** Drops tracks that contradict each other. */
  clearTracks() {
    this.tracks = [];
  }

  /** The number of the newest frame that is held back, or null. */
  get newest() {
    return this.frames[this.frames.length - 1]?.body.frame.number ?? null;
  }

  /** Whether more is held back than can be explained by a slow connection. */
  get isOverfull() {
    const { frames, simplified, dots, tracks } = this;
    return [frames, simplified, dots, tracks].some((list) => list.length > MAX_PENDING);
  }

  /**
   * Takes the messages up to the newest frame of which all is there; null if there is none.
   * @param {Held} held @param {{tracks: boolean, simplified: boolean}} wanted
   * @returns {Picture | null}
   */
  take(held, wanted) {
    for (let at = this.frames.length - 1; at >= -1; at--) {
      const frame = at < 0 ? held.frame : this.frames[at].body.frame;
      if (!frame || !this.hasDots(frame.number, held)) continue;
      if (wanted.tracks && !this.hasTracks(frame.number, held)) continue;
      const simplified = wanted.simplified ? this.findSimplified(frame, held) : -1;
      if (wanted.simplified && simplified === null) continue;
      return this.cut(frame.number, at + 1, simplified + 1);
    }
    return null;
  }

  hasDots(number, held) {
    return held.dots === number || this.dots.some(({ frame }) => frame === number);
  }

  hasTracks(number, held) {
    return held.tracks === number || this.tracks.some(({ frame }) => frame === number);
  }

  /** Where the simplified view has a frame in the same cut: an index, -1 if it is held, null if it is not there. */
  findSimplified(frame, held) {
    const isOfFrame = (one) => one?.number === frame.number && isSameCut(one.view.cut, frame.view.cut);
    const at = this.simplified.findLastIndex(({ body }) => isOfFrame(body.frame));
    return at >= 0 ? at : isOfFrame(held.simplified) ? -1 : null;
  }

  /** Takes so many frames and all else up to a frame; null if that is nothing. @returns {Picture | null} */
  cut(number, frameCount, simplifiedCount) {
    const isOld = ({ frame }) => frame <= number;
    const picture = {
      number,
      frames: this.frames.splice(0, frameCount),
      simplified: this.simplified.splice(0, simplifiedCount),
      dots: this.dots.findLast(({ frame, dots }) => frame <= number && dots !== null)?.dots ?? null,
      tracks: this.tracks.filter(isOld),
    };
    const count = picture.frames.length + picture.simplified.length + picture.tracks.length;
    const hasNew = count > 0 || this.dots.some(isOld);
    this.dots = this.dots.filter((one) => !isOld(one));
    this.tracks = this.tracks.filter((one) => !isOld(one));
    return hasNew ? picture : null;
  }
}

/** Whether two views are cut alike. */
export const isSameCut = (a, b) => JSON.stringify(a) === JSON.stringify(b);
