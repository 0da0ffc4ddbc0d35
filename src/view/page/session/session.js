//! The followed stream: one stream in one view, with its tracks, its dots and its last frames.
//!
//! In: what the user chose; messages of the daemon.
//! Out: mirror, annotations (tracks and dots), history; a call of `changed` whenever one of them changes.
//! Invariants: while the page is paused or hidden, nothing is subscribed to, so nothing piles up. Afterwards the
//! session resumes from the frame it holds, by diffs where the daemon still has them.
//! Must not know: graphics, the page's elements.

import { Connection } from "./connection.js";
import { History } from "./history.js";
import { Contradiction, Mirror } from "./mirror.js";
import { Tracks, emptyTracks } from "./tracks.js";

/** How many dots are requested: the most persistent ones. */
const DOTS = 1500;
/** Milliseconds between two requests for the list of streams. */
const LIST_INTERVAL = 2000;
/** Least milliseconds between two changes of the view, which a slider can cause much faster. */
const VIEW_INTERVAL = 120;
/** A page that lags by more than this, in milliseconds, starts again from the newest frame. */
const MAX_LAG = 2500;
const WANT_TRACKS = 0x020d;

/** Columns of a dot: its edge's ends, birth, death, centre and radius. */
const DOT = 7;

/** Birth and death of each dot. Nothing else of dots is drawn, and this is kept for every frame of the history. */
function labelsOf(dots) {
  const labels = new Float64Array((2 * dots.length) / DOT);
  for (let i = 0; i < labels.length; i += 2) {
    labels[i] = dots[(i / 2) * DOT + 2];
    labels[i + 1] = dots[(i / 2) * DOT + 3];
  }
  return labels;
}

const isSame = (a, b) => JSON.stringify(a) === JSON.stringify(b);

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
    this.reset();
    this.lastChannel = 0;
    this.listChannel = 0;
    this.resyncs = 0;
    this.framesReceived = 0;
    this.connection = new Connection(url, {
      connected: () => this.onConnected(),
      stateChanged: () => this.onConnectionState(),
      message: (channel, name, body) => this.handleMessage(channel, name, body),
      isSubscribed: (channel) => channel === this.channel || channel === this.listChannel,
    });
  }

  start() {
    this.connection.connect();
    setInterval(() => this.tick(), 500);
  }

  /** Drops all that is known of a stream. */
  reset() {
    this.channel = 0;
    this.opened = null;
    /** The view of the mirror, once a snapshot in it has come. */
    this.heldView = null;
    /** Why there are no tracks; empty if there are. */
    this.noTracksReason = "";
    this.notice = "";
    this.dots = { total: 0, labels: new Float64Array(0) };
    /** Those of the shown frame. @type {import("./history.js").Annotations} */
    this.annotations = { ...emptyTracks(), dots: this.dots };
  }

  /** Follows another stream. */
  chooseStream(name) {
    if (name === this.choice.stream) return;
    this.unsubscribe();
    this.choice.stream = name;
    this.reset();
    for (const elements of [this.mirror.vertices, this.mirror.edges, this.mirror.critical]) elements.clear();
    this.mirror.frame = null;
    this.tracks.clear();
    this.history.clear();
    this.paused = false;
    this.subscribe();
    this.changed("stream");
  }

  /** Follows the stream in another view. */
  chooseView(view) {
    this.choice.view = view;
    if (this.viewTimer) return;
    this.sendView();
    this.viewTimer = setTimeout(() => {
      this.viewTimer = null;
      this.sendView();
    }, VIEW_INTERVAL);
  }

  sendView() {
    if (!this.channel || isSame(this.sentView, this.choice.view)) return;
    this.sentView = this.choice.view;
    this.connection.send(this.channel, "ChangeView", { view: this.sentView, dots: { Top: DOTS } });
  }

  /** Pauses, or resumes from the newest frame. */
  setPaused(paused) {
    if (paused === this.paused) return;
    this.paused = paused;
    if (!paused) this.step(Infinity);
    this.updateSubscription();
    this.changed("status");
  }

  /** Notes whether the page is hidden. */
  setHidden(hidden) {
    this.hidden = hidden;
    this.updateSubscription();
  }

  /** Subscribes or unsubscribes, as pause and visibility ask for. */
  updateSubscription() {
    if (this.paused || this.hidden) this.unsubscribe();
    else if (!this.channel) this.subscribe();
  }

  /** Shows the frame that is `by` frames after the shown one. */
  step(by) {
    const annotations = this.history.moveBy(this.mirror, by);
    this.annotations = annotations ?? { ...emptyTracks(), dots: this.dots };
    this.changed("frame");
  }

  onConnected() {
    this.requestList();
    this.subscribe();
  }

  onConnectionState() {
    if (this.connection.state === "gone") this.channel = 0;
    this.changed("status");
  }

  requestList() {
    this.listedAt = performance.now();
    this.listChannel = this.lastChannel += 1;
    this.connection.send(this.listChannel, "ListStreams", { pattern: "*" });
  }

  /** Refreshes the list of streams, and resynchronizes where the page lags too far behind. */
  tick() {
    if (this.connection.state === "connected" && !this.hidden) {
      if (performance.now() - this.listedAt > LIST_INTERVAL) this.requestList();
      const isSettled = performance.now() - this.subscribedAt > 2 * MAX_LAG;
      if (this.channel && isSettled && this.connection.lag > MAX_LAG) this.resync();
    }
    this.changed("status");
  }

  /** Starts again from a snapshot of the newest frame. */
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
    this.subscribedAt = performance.now();
    this.sentView = view;
    this.connection.send(this.channel, "Subscribe", {
      pattern: stream,
      view,
      dots: { Top: DOTS },
      resume: this.resumeFrom(),
    });
    this.noTracksReason = this.connection.version < 2 ? "this daemon is too old for tracks" : "";
    this.requestTracks();
  }

  /** The held frame, if diffs may lead on from it; else null. */
  resumeFrom() {
    const { frame } = this.mirror;
    if (!frame || !this.opened || !isSame(this.heldView, this.choice.view)) return null;
    return { epoch: this.opened.epoch, frame: frame.number };
  }

  unsubscribe() {
    if (!this.channel) return;
    this.connection.send(this.channel, "Unsubscribe");
    // Messages of the channel that are still on their way are skipped unread from here on.
    this.channel = 0;
  }

  requestTracks() {
    if (this.noTracksReason) return;
    this.tracks.restart();
    this.connection.send(this.channel, "WantTracks", { tracks: "Cycles" });
  }

  /** Handles a message of a stream. A contradiction leads to a resync and to nothing worse. */
  handleMessage(channel, name, body) {
    try {
      if (name === "Streams" && channel === this.listChannel) this.onStreams(body.streams);
      else if (channel === this.channel) this[`on${name}`]?.(body);
    } catch (error) {
      if (!(error instanceof Contradiction)) throw error;
      this.notice = `Started again: ${error.message}.`;
      this.resync();
    }
  }

  onStreams(streams) {
    this.streams = streams;
    if (this.choice.stream === null && streams.length > 0) {
      const [first] = [...streams].sort((a, b) => b.producers - a.producers || a.stream - b.stream);
      this.choice.stream = first.name;
      this.subscribe();
    }
    this.changed("streams");
  }

  onError({ answers, text }) {
    if (answers === WANT_TRACKS) this.noTracksReason = text;
    else this.notice = text;
    this.changed("status");
  }

  onStreamOpened(opened) {
    const isAnother = this.opened?.epoch !== opened.epoch;
    this.opened = opened;
    this.notice = "";
    if (!isAnother) return;
    this.tracks.clear();
    this.heldView = null;
    this.changed("stream");
  }

  onStreamClosed({ reason }) {
    this.notice = `The stream has ended: ${reason}.`;
    this.changed("status");
  }

  onSnapshot(snapshot) {
    this.mirror.applySnapshot(snapshot);
    this.heldView = snapshot.frame.view;
    this.history.restart(snapshot.frame);
    if (snapshot.cause === "Lagged") this.resyncs += 1;
    this.onFrame();
  }

  onDiff(diff) {
    const inverse = this.mirror.applyDiff(diff);
    this.history.push(diff.frame, diff, inverse);
    this.onFrame();
  }

  onDots({ total, dots }) {
    this.dots = { total, labels: labelsOf(dots) };
    this.annotate();
  }

  onTracks(tracks) {
    if (this.tracks.apply(tracks)) this.annotate();
    else this.requestTracks();
  }

  onFrame() {
    this.framesReceived += 1;
    this.annotate();
  }

  /** Annotates the newest frame. Its tracks and dots come after it; until then those of the frame before are shown. */
  annotate() {
    this.annotations = { ...this.tracks.current, dots: this.dots };
    this.history.annotate(this.annotations);
    this.changed("frame");
  }
}
