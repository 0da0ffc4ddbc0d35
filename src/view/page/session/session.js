//! The followed stream: one stream in one view, with its tracks, its dots and its last pictures.
//!
//! In: what the user chose; messages of the daemon.
//! Out: mirrors (of the view, and of its simplified form), annotations (tracks and dots), history; a call of `changed`
//! whenever one of them changes.
//! Invariants: mirrors and annotations are always of one frame. A simplified view is followed beside the view itself,
//! whose points it lacks. While the page is paused or hidden, nothing is subscribed to, so nothing piles up; but a
//! change of the view while paused is followed up to one picture. Afterwards the session resumes from the frame it
//! holds, by diffs where the daemon still has them.
//! Must not know: graphics, the page's elements.

import { Assembly, isSameCut } from "./assembly.js";
import { Connection } from "./connection.js";
import { holesOf, labelsOf, marksOf, noDots } from "./dots.js";
import { History } from "./history.js";
import { Contradiction, Mirror } from "./mirror.js";
import { inFormOfPlane } from "./spaces.js";
import { Tracks, emptyTracks } from "./tracks.js";

/** How many dots are requested: the most persistent ones. */
const DOTS = 1500;
/** Milliseconds between two requests for the list of streams. */
const LIST_INTERVAL = 2000;
/** Least milliseconds between two changes of the view, which a slider can cause much faster. */
const VIEW_INTERVAL = 120;
/** A page that lags by more than this, in milliseconds, starts again from the newest frame. */
const MAX_LAG = 2500;
/** Milliseconds that a picture waits for its simplified form, which the daemon may merge into other frames. */
const SIMPLIFIED_PATIENCE = 600;
const WANT_TRACKS = 0x020d;
/** The first version of the protocol that has streams in a space. */
const SPACES_SINCE = 4;

const isSame = (a, b) => JSON.stringify(a) === JSON.stringify(b);
const noAnnotations = () => ({ ...emptyTracks(), tracksFrame: null, simplified: null, dots: noDots() });

export class Session {
  /** @param {string} url @param {{stream: string | null, view: any}} choice @param {(what: string) => void} changed */
  constructor(url, choice, changed) {
    this.choice = choice;
    this.changed = changed;
    this.mirror = new Mirror();
    /** The simplified form of the view; empty unless it is chosen. */
    this.simplified = new Mirror();
    this.tracks = new Tracks();
    this.history = new History();
    this.assembly = new Assembly();
    this.streams = [];
    /** The streams in a space, by number. @type {Map<number, {metric: string, dimension: number | null}>} */
    this.spaces = new Map();
    this.paused = false;
    this.hidden = false;
    this.reset();
    this.lastChannel = 0;
    this.listChannel = this.spacesChannel = 0;
    this.resyncs = 0;
    this.framesReceived = 0;
    this.connection = new Connection(url, {
      connected: () => this.onConnected(),
      stateChanged: () => this.onConnectionState(),
      message: (channel, name, body) => this.handleMessage(channel, name, body),
      isSubscribed: (channel) =>
        [this.channel, this.simplifiedChannel, this.listChannel, this.spacesChannel].includes(channel),
    });
  }

  start() {
    this.connection.connect();
    setInterval(() => this.tick(), 500);
  }

  /** Drops all that is known of a stream. */
  reset() {
    this.channel = this.simplifiedChannel = 0;
    this.opened = null;
    /** Why there are no tracks; empty if there are. */
    this.noTracksReason = "";
    this.notice = "";
    /** When the stream was chosen. */
    this.chosenAt = performance.now();
    this.clear();
  }

  /** Drops all pictures. */
  clear() {
    this.mirror.clear();
    this.simplified.clear();
    this.tracks.clear();
    this.history.clear();
    this.assembly.clear();
    /** The rows of the newest dots. */
    this.dotRows = new Float64Array(0);
    this.dots = noDots();
    this.takenAt = performance.now();
    /** Those of the shown frame. @type {import("./history.js").Annotations} */
    this.annotations = noAnnotations();
    /** Whether a picture is awaited although the page is paused. */
    this.isLooking = this.paused;
  }

  /** Follows another stream. */
  chooseStream(name) {
    if (name === this.choice.stream) return;
    this.unsubscribe();
    this.choice.stream = name;
    this.paused = false;
    this.reset();
    this.subscribe();
    this.changed("stream");
  }

  /** Follows the stream in another view. A paused session shows the newest frame in it, and stays paused. */
  chooseView(view) {
    this.choice.view = view;
    if (!this.wantsSimplified) this.dropSimplified();
    this.isLooking = this.paused && !this.hasChosenView;
    if (this.viewTimer) return;
    this.sendView();
    this.viewTimer = setTimeout(() => {
      this.viewTimer = null;
      this.sendView();
    }, VIEW_INTERVAL);
  }

  sendView() {
    if (!this.channel) return this.updateSubscription();
    const { cut } = this.choice.view;
    if (isSame(this.sentView, this.choice.view)) return;
    if (!isSameCut(this.sentView.cut, cut)) {
      this.connection.send(this.channel, "ChangeView", { view: { cut, simplify: "No" }, dots: { Top: DOTS } });
    }
    this.sentView = this.choice.view;
    if (!this.wantsSimplified) return;
    if (!this.simplifiedChannel) this.subscribeToSimplified();
    else this.connection.send(this.simplifiedChannel, "ChangeView", { view: this.choice.view, dots: "No" });
  }

  /** Whether the shown picture is in the chosen view. */
  get hasChosenView() {
    const hasCut = this.mirror.frame !== null && isSameCut(this.mirror.frame.view.cut, this.choice.view.cut);
    return hasCut && (!this.wantsSimplified || this.annotations.simplified !== null);
  }

  get wantsSimplified() {
    return this.choice.view.simplify !== "No";
  }

  /** Follows the simplified view no longer, and shows it no longer. */
  dropSimplified() {
    this.unsubscribeFrom("simplifiedChannel");
    this.assembly.clearSimplified();
    if (!this.simplified.frame) return;
    this.simplified.clear();
    this.annotations = { ...this.annotations, simplified: null };
    // The steps before lead through simplified views.
    this.history.restart(this.mirror.frame, this.annotations);
    this.changed("frame");
  }

  /** Pauses, or resumes from the newest frame. */
  setPaused(paused) {
    if (paused === this.paused) return;
    this.paused = paused;
    // Without a picture the first one is awaited.
    this.isLooking = paused && !this.mirror.frame;
    if (!paused) this.step(Infinity);
    this.updateSubscription();
    this.changed("status");
  }

  /** Notes whether the page is hidden. */
  setHidden(hidden) {
    this.hidden = hidden;
    this.updateSubscription();
  }

  get isFollowing() {
    return !this.hidden && (!this.paused || this.isLooking);
  }

  /** Subscribes or unsubscribes, as pause and visibility ask for. */
  updateSubscription() {
    if (!this.isFollowing) this.unsubscribe();
    else if (!this.channel) this.subscribe();
  }

  /** Shows the picture that is `by` pictures after the shown one. */
  step(by) {
    this.annotations = this.history.moveBy(by) ?? this.annotations;
    this.changed("frame");
  }

  onConnected() {
    this.requestList();
    this.subscribe();
  }

  onConnectionState() {
    if (this.connection.state === "gone") {
      this.channel = this.simplifiedChannel = 0;
      this.assembly.clear();
    }
    this.changed("status");
  }

  requestList() {
    this.listedAt = performance.now();
    this.listChannel = this.lastChannel += 1;
    this.connection.send(this.listChannel, "ListStreams", { pattern: "*" });
    if (this.connection.version < SPACES_SINCE) return;
    this.spacesChannel = this.lastChannel += 1;
    this.connection.send(this.spacesChannel, "ListSpaces");
  }

  /** Refreshes the list of streams, and resynchronizes where the page lags too far behind. */
  tick() {
    if (this.connection.state === "connected" && !this.hidden) {
      if (performance.now() - this.listedAt > LIST_INTERVAL) this.requestList();
      const isSettled = performance.now() - this.subscribedAt > 2 * MAX_LAG;
      if (this.channel && isSettled && this.connection.lag > MAX_LAG) this.resync();
      this.guard(() => this.takePicture());
    }
    this.changed("status");
  }

  /** Starts again from a snapshot of the newest frame. */
  resync() {
    this.resyncs += 1;
    this.unsubscribe();
    this.subscribe(false);
  }

  /** Subscribes, from the held frame if diffs may lead on from it. */
  subscribe(mayResume = true) {
    const { stream, view } = this.choice;
    if (stream === null || !this.isFollowing || this.connection.state !== "connected") return;
    // A paused page may show an older frame than it holds.
    if (this.history.after > 0) this.step(Infinity);
    this.channel = this.lastChannel += 1;
    this.subscribedAt = this.takenAt = performance.now();
    this.sentView = view;
    this.connection.send(this.channel, "Subscribe", {
      pattern: stream,
      view: { cut: view.cut, simplify: "No" },
      dots: { Top: DOTS },
      resume: mayResume ? this.resumeFrom(this.mirror, { cut: view.cut, simplify: "No" }) : null,
    });
    this.noTracksReason = this.connection.version < 2 ? "this daemon is too old for tracks" : "";
    this.requestTracks();
    if (this.wantsSimplified) this.subscribeToSimplified(mayResume);
  }

  subscribeToSimplified(mayResume = true) {
    const { stream, view } = this.choice;
    this.simplifiedChannel = this.lastChannel += 1;
    const resume = mayResume ? this.resumeFrom(this.simplified, view) : null;
    this.connection.send(this.simplifiedChannel, "Subscribe", { pattern: stream, view, dots: "No", resume });
  }

  /** The frame that a mirror holds, if diffs may lead on from it; else null. @param {Mirror} mirror */
  resumeFrom({ frame }, view) {
    if (!frame || !this.opened || !isSame(frame.view, view)) return null;
    return { epoch: this.opened.epoch, frame: frame.number };
  }

  unsubscribe() {
    this.unsubscribeFrom("channel");
    this.unsubscribeFrom("simplifiedChannel");
    this.assembly.clear();
  }

  /** Ends a subscription. Its messages that are still on their way are skipped unread from here on. */
  unsubscribeFrom(channel) {
    if (this[channel]) this.connection.send(this[channel], "Unsubscribe");
    this[channel] = 0;
  }

  requestTracks() {
    if (this.noTracksReason) return;
    this.tracks.restart();
    this.assembly.clearTracks();
    this.connection.send(this.channel, "WantTracks", { tracks: "Cycles" });
  }

  handleMessage(channel, name, body) {
    if (name === "Streams" && channel === this.listChannel) this.onStreams(body.streams);
    else if (name === "Spaces" && channel === this.spacesChannel) this.onSpaces(body.streams);
    else if (channel === this.channel) this.guard(() => this.handleStream(name, body));
    else if (channel === this.simplifiedChannel) this.guard(() => this.onSimplified(...inFormOfPlane(name, body)));
  }

  handleStream(sent, sentBody) {
    const [name, body] = inFormOfPlane(sent, sentBody);
    this[`on${name}`]?.(body);
  }

  /** Handles what a stream sends. A contradiction leads to a resync and to nothing worse. */
  guard(handle) {
    try {
      handle();
    } catch (error) {
      if (!(error instanceof Contradiction)) throw error;
      this.notice = `Started again: ${error.message}.`;
      this.clear();
      this.resync();
      this.changed("frame");
    }
  }

  onStreams(streams) {
    this.streams = streams;
    if (this.choice.stream === null && streams.length > 0) {
      const [first] = [...streams].sort((a, b) => b.producers - a.producers || a.stream - b.stream);
      this.choice.stream = first.name;
      this.chosenAt = performance.now();
      this.subscribe();
    }
    this.changed("streams");
  }

  /** Notes which streams are in a space. */
  onSpaces(spaces) {
    this.spaces = new Map(spaces.map((space) => [space.stream, space]));
    this.changed("streams");
  }

  onError({ answers, text }) {
    if (answers === WANT_TRACKS) {
      this.noTracksReason = text;
      this.takePicture();
    } else this.notice = text;
    this.changed("status");
  }

  onStreamOpened(opened) {
    const isAnother = this.opened?.epoch !== opened.epoch;
    this.opened = opened;
    this.notice = "";
    if (!isAnother) return;
    this.clear();
    this.changed("stream");
  }

  onStreamClosed({ reason }) {
    this.notice = `The stream has ended: ${reason}.`;
    this.changed("status");
  }

  onSnapshot(snapshot) {
    if (snapshot.cause === "Lagged") this.resyncs += 1;
    this.onFrame("Snapshot", snapshot);
  }

  onDiff(diff) {
    this.onFrame("Diff", diff);
  }

  onFrame(name, body) {
    this.framesReceived += 1;
    this.assembly.addFrame(name, body);
    this.takePicture();
  }

  onDots({ frame, total, dots, labels = labelsOf(dots) }) {
    this.assembly.addDots(frame, { total, rows: dots, labels });
    this.takePicture();
  }

  /** With the number of the newest frame here it says that this frame has the dots of the one before. */
  onHeartbeat({ frame }) {
    const isNewest = frame === (this.assembly.newest ?? this.mirror.frame?.number);
    if (!isNewest || frame === this.annotations.dots.frame) return;
    this.assembly.addDots(frame, null);
    this.takePicture();
  }

  onTracks(tracks) {
    this.assembly.addTracks(tracks);
    this.takePicture();
  }

  onSimplified(name, body) {
    if (name === "Snapshot" || name === "Diff") this.assembly.addSimplified(name, body);
    else if (name === "Error") this.notice = `There is no simplified view: ${body.text}`;
    else return;
    if (name === "Error") this.simplifiedChannel = 0;
    this.takePicture();
  }

  /** Takes over the newest complete picture, if there is one. */
  takePicture() {
    const { mirror, simplified, annotations, assembly } = this;
    const held = {
      frame: mirror.frame,
      dots: annotations.dots.frame,
      tracks: annotations.tracksFrame,
      simplified: simplified.frame,
    };
    const tracks = this.noTracksReason === "";
    const isPatient = performance.now() - this.takenAt < SIMPLIFIED_PATIENCE;
    let picture = assembly.take(held, { tracks, simplified: this.wantsSimplified && this.simplifiedChannel !== 0 });
    // A simplified view that comes in other frames than the view itself is left out rather than mixed with them.
    if (!picture && !isPatient) picture = assembly.take(held, { tracks, simplified: false });
    if (picture) this.applyPicture(picture);
    else if (assembly.isOverfull) throw new Contradiction("parts of frames are missing");
  }

  /** Applies all messages of a picture at once. @param {import("./assembly.js").Picture} picture */
  applyPicture({ number, frames, simplified, dots, tracks }) {
    if (!tracks.every((message) => this.tracks.apply(message))) return this.requestTracks();
    const moves = [...applyTo(this.mirror, frames), ...applyTo(this.simplified, simplified)];
    const isRestart = [...frames, ...simplified].some(({ name }) => name === "Snapshot");
    if (dots) {
      this.dotRows = dots.rows;
      this.dots = { ...this.dots, total: dots.total, labels: dots.labels };
    }
    const isShown = marksOf(this.dots.labels, this.mirror.critical);
    const isSimplified = this.wantsSimplified && this.simplified.frame?.number === number;
    this.annotations = {
      ...this.tracks.current,
      tracksFrame: this.noTracksReason ? null : number,
      simplified: isSimplified ? number : null,
      dots: { ...this.dots, frame: number, isShown, holes: holesOf(this.dotRows, isShown) },
    };
    if (isRestart) this.history.restart(this.mirror.frame, this.annotations);
    else if (moves.length > 0) this.history.push(this.mirror.frame, moves, this.annotations);
    else this.history.replace(this.annotations);
    this.takenAt = performance.now();
    this.endLook();
    this.changed("frame");
  }

  /** Follows nothing more once a paused page has the picture that it waited for. */
  endLook() {
    if (!this.isLooking || !this.hasChosenView) return;
    this.isLooking = false;
    this.updateSubscription();
  }
}

/** Applies frames to a mirror. Returns its moves since the last snapshot. @param {Mirror} mirror */
function applyTo(mirror, frames) {
  let moves = [];
  for (const { name, body } of frames) {
    const from = mirror.frame;
    if (name === "Snapshot") {
      mirror.applySnapshot(body);
      moves = [];
    } else moves.push({ mirror, forward: body, backward: mirror.applyDiff(body), from, to: mirror.frame });
  }
  return moves;
}
