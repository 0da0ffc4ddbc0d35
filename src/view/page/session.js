//! What the page follows: one stream in one view, with its tracks and its last frames.
//!
//! In: what the user chose, messages. Out: mirror, tracks, dots, history, and word when any of them has changed.
//! Invariants: while paused or hidden nothing is subscribed to, so nothing can pile up; afterwards it goes on from
//! the frame that is held, by diffs where the daemon still has them. Must not know: graphics, the page's elements.

import { Connection } from "./connection.js";
import { History } from "./history.js";
import { Contradiction, Mirror } from "./mirror.js";
import { Tracks, nobody } from "./tracks.js";

/** So many of the most persistent dots are asked for. */
const DOTS = 1500;
const LIST_EVERY = 2000;
/** A view that changes while a slider moves is sent at most so often. */
const VIEW_EVERY = 120;
/** Who is further behind than this, in milliseconds, starts again from the newest frame. */
const TOO_FAR = 2500;
const WANT_TRACKS = 0x020d;

/** Columns of a dot: its edge's ends, birth, death, centre and radius. */
const DOT = 7;

/** Birth and death of dots, all that is shown of them: this is kept for every frame that one can go back to. */
function labelsOf(dots) {
  const labels = new Float64Array((2 * dots.length) / DOT);
  for (let i = 0; i < labels.length; i += 2) {
    labels[i] = dots[(i / 2) * DOT + 2];
    labels[i + 1] = dots[(i / 2) * DOT + 3];
  }
  return labels;
}

const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);

export class Session {
  /** @param {string} url @param {{stream: string | null, view: any}} choice @param {(what: string) => void} changed */
  constructor(url, choice, changed) {
    this.choice = choice;
    this.changed = changed;
    this.mirror = new Mirror();
    this.tracks = new Tracks();
    this.history = new History();
    this.streams = [];
    this.paused = false;
    this.hidden = false;
    this.forget();
    this.lastChannel = 0;
    this.listChannel = 0;
    this.resyncs = 0;
    this.framesSeen = 0;
    this.connection = new Connection(url, {
      up: () => this.up(),
      state: () => this.lost(),
      message: (channel, name, body) => this.take(channel, name, body),
      listens: (channel) => channel === this.channel || channel === this.listChannel,
    });
  }

  start() {
    this.connection.start();
    setInterval(() => this.tick(), 500);
  }

  /** What is drawn beside the skeleton. */
  get beside() {
    return this.shown;
  }

  /** Nothing is known of any stream. */
  forget() {
    this.channel = 0;
    this.opened = null;
    /** The view of the mirror, once a snapshot in it has come. */
    this.heldView = null;
    /** Why there are no tracks, if there are none. */
    this.trackless = "";
    this.notice = "";
    this.dots = { total: 0, labels: new Float64Array(0) };
    this.shown = { ...nobody(), dots: this.dots };
  }

  /** Follows another stream. */
  chooseStream(name) {
    if (name === this.choice.stream) return;
    this.unsubscribe();
    this.choice.stream = name;
    this.forget();
    for (const elements of [this.mirror.vertices, this.mirror.edges, this.mirror.critical]) elements.clear();
    this.mirror.frame = null;
    this.tracks.clear();
    this.history.clear();
    this.paused = false;
    this.subscribe();
    this.changed("stream");
  }

  /** Looks at the stream in another view. */
  chooseView(view) {
    this.choice.view = view;
    if (this.viewTimer) return;
    this.sendView();
    this.viewTimer = setTimeout(() => {
      this.viewTimer = null;
      this.sendView();
    }, VIEW_EVERY);
  }

  sendView() {
    if (!this.channel || same(this.sentView, this.choice.view)) return;
    this.sentView = this.choice.view;
    this.connection.send(this.channel, "ChangeView", { view: this.sentView, dots: { Top: DOTS } });
  }

  /** Stops, or goes on from the newest frame. */
  pause(paused) {
    if (paused === this.paused) return;
    this.paused = paused;
    if (!paused) this.step(Infinity);
    this.rest();
    this.changed("status");
  }

  /** The page is hidden, or seen again. */
  hide(hidden) {
    this.hidden = hidden;
    this.rest();
  }

  /** Subscribes or unsubscribes, as it should be now. */
  rest() {
    if (this.paused || this.hidden) this.unsubscribe();
    else if (!this.channel) this.subscribe();
  }

  /** Shows a frame so many later. */
  step(by) {
    const beside = this.history.go(this.mirror, by);
    this.shown = beside ?? { ...nobody(), dots: this.dots };
    this.changed("frame");
  }

  up() {
    this.list();
    this.subscribe();
  }

  lost() {
    if (this.connection.state === "gone") this.channel = 0;
    this.changed("status");
  }

  list() {
    this.listed = performance.now();
    this.listChannel = this.lastChannel += 1;
    this.connection.send(this.listChannel, "ListStreams", { pattern: "*" });
  }

  /** What is looked after from time to time. */
  tick() {
    if (this.connection.state === "connected" && !this.hidden) {
      if (performance.now() - this.listed > LIST_EVERY) this.list();
      const rested = performance.now() - this.subscribed > 2 * TOO_FAR;
      if (this.channel && rested && this.connection.lag > TOO_FAR) this.resync();
    }
    this.changed("status");
  }

  /** Starts again from the newest frame. */
  resync() {
    this.resyncs += 1;
    this.unsubscribe();
    this.heldView = null;
    this.subscribe();
  }

  subscribe() {
    const { stream, view } = this.choice;
    if (stream === null || this.paused || this.hidden || this.connection.state !== "connected") return;
    this.channel = this.lastChannel += 1;
    this.subscribed = performance.now();
    this.sentView = view;
    this.connection.send(this.channel, "Subscribe", {
      pattern: stream,
      view,
      dots: { Top: DOTS },
      resume: this.resumeFrom(),
    });
    this.trackless = this.connection.version < 2 ? "this daemon is too old for tracks" : "";
    this.wantTracks();
  }

  /** What is held, if diffs may lead on from it. */
  resumeFrom() {
    const { frame } = this.mirror;
    if (!frame || !this.opened || !same(this.heldView, this.choice.view)) return null;
    return { epoch: this.opened.epoch, frame: frame.number };
  }

  unsubscribe() {
    if (!this.channel) return;
    this.connection.send(this.channel, "Unsubscribe");
    // From here on the channel is not listened to: what is still on its way is passed over unread.
    this.channel = 0;
  }

  wantTracks() {
    if (this.trackless) return;
    this.tracks.restart();
    this.connection.send(this.channel, "WantTracks", { tracks: "Cycles" });
  }

  /** Deals with a message of a stream. A contradiction is a reason to start again, and no more. */
  take(channel, name, body) {
    try {
      if (name === "Streams" && channel === this.listChannel) this.takeStreams(body.streams);
      else if (channel === this.channel) this[`take${name}`]?.(body);
    } catch (error) {
      if (!(error instanceof Contradiction)) throw error;
      this.notice = `Started again: ${error.message}.`;
      this.resync();
    }
  }

  takeStreams(streams) {
    this.streams = streams;
    if (this.choice.stream === null && streams.length > 0) {
      const [first] = [...streams].sort((a, b) => b.producers - a.producers || a.stream - b.stream);
      this.choice.stream = first.name;
      this.subscribe();
    }
    this.changed("streams");
  }

  takeError({ answers, text }) {
    if (answers === WANT_TRACKS) this.trackless = text;
    else this.notice = text;
    this.changed("status");
  }

  takeStreamOpened(opened) {
    const isAnother = this.opened?.epoch !== opened.epoch;
    this.opened = opened;
    this.notice = "";
    if (!isAnother) return;
    this.tracks.clear();
    this.heldView = null;
    this.changed("stream");
  }

  takeStreamClosed({ reason }) {
    this.notice = `The stream has ended: ${reason}.`;
    this.changed("status");
  }

  takeSnapshot(snapshot) {
    this.mirror.takeSnapshot(snapshot);
    this.heldView = snapshot.frame.view;
    this.history.restart(snapshot.frame);
    if (snapshot.cause === "Lagged") this.resyncs += 1;
    this.seeFrame();
  }

  takeDiff(diff) {
    const back = this.mirror.takeDiff(diff);
    this.history.push(diff.frame, diff, back);
    this.seeFrame();
  }

  takeDots({ total, dots }) {
    this.dots = { total, labels: labelsOf(dots) };
    this.annotate();
  }

  takeTracks(tracks) {
    if (this.tracks.take(tracks)) this.annotate();
    else this.wantTracks();
  }

  seeFrame() {
    this.framesSeen += 1;
    this.annotate();
  }

  /** Tracks and dots of the newest frame have come. They come after it, so until then those before stand beside it. */
  annotate() {
    this.shown = { ...this.tracks.living, dots: this.dots };
    this.history.annotate(this.shown);
    this.changed("frame");
  }
}
