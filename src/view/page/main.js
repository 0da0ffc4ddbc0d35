//! The page: connects session, renderer and panels, and draws when something has changed.
//!
//! In: the address, the user.
//! Out: the page; `window.hopes.state()` for tests.
//! Invariants: at most one drawing per screen frame, and none where nothing has changed. Drawing takes at most half of
//! the time, so that the rest is left for following. A hidden page follows nothing.
//! Must not know: bytes, the graphics card.

import { Camera } from "./drawing/camera.js";
import { readPalette } from "./drawing/colors.js";
import { TracksByLabel, isPicked, pickCycle } from "./drawing/picking.js";
import { createRenderer } from "./drawing/renderer.js";
import { Controls, choiceFrom } from "./panels/controls.js";
import { Diagram } from "./panels/diagram.js";
import { Rate, showCycle, showStatus } from "./panels/status.js";
import { Timeline } from "./panels/timeline.js";
import { Session } from "./session/session.js";

/** Milliseconds between two drawings of the panels at the least, while frames come. */
const PANEL_INTERVAL = 70;
/** How near to an edge a pointer must be, in pixels. A finger is less precise than a mouse. */
const PICK_RADIUS = { mouse: 9, touch: 18 };

const el = (id) => document.getElementById(id);

class Page {
  constructor() {
    readPalette();
    // Relative to the page, which a proxy may show below a path of its own; `http` becomes `ws`, `https` `wss`.
    const socket = new URL("ws", location.href).href.replace(/^http/, "ws");
    this.session = new Session(socket, choiceFrom(location.hash), (what) => this.onChange(what));
    this.tracksByLabel = new TracksByLabel();
    this.camera = new Camera(el("plane"), () => this.requestDraw());
    this.renderer = createRenderer(el("plane"), this.camera, this.tracksByLabel);
    this.diagram = new Diagram(el("diagram"), this.tracksByLabel);
    this.timeline = new Timeline(el("lives"));
    this.controls = new Controls(this.session, {
      fit: () => this.fit(),
      pickNext: (by) => this.pinNext(by),
      unpick: () => this.pin(null),
    });
    /** The cycle under the pointer, and the cycle that stays picked when the pointer leaves. */
    this.hovered = null;
    this.pinned = null;
    this.followed = new Rate();
    this.drawings = new Rate();
    this.counted = 0;
    this.drawn = null;
    this.nextDrawAt = 0;
    this.panelsDrawnAt = 0;
    this.listen();
  }

  start() {
    this.session.setHidden(document.hidden);
    this.session.start();
    this.requestDraw();
  }

  get pick() {
    return this.hovered ?? this.pinned;
  }

  listen() {
    const dark = matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", () => {
      readPalette();
      this.requestDraw();
    });
    document.addEventListener("visibilitychange", () => {
      this.session.setHidden(document.hidden);
      this.requestDraw();
    });
    new ResizeObserver(() => this.requestDraw()).observe(el("views"));
    this.listenForPicks(el("plane"), (event) => this.pickInPlane(event));
    this.listenForPicks(el("diagram"), (event) => this.diagram.pickAt(event.offsetX, event.offsetY));
    this.listenForPicks(el("lives"), (event) => this.timeline.pickAt(event.offsetX, event.offsetY));
  }

  /** Picks the cycle under the pointer of a canvas; a click pins it. */
  listenForPicks(canvas, pickAt) {
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons === 0 || event.pointerType !== "mouse") this.hover(pickAt(event));
    });
    canvas.addEventListener("pointerleave", () => this.hover(null));
    canvas.addEventListener("click", (event) => {
      if (canvas === el("plane") && this.camera.travel > 4) return;
      this.pin(pickAt(event));
    });
  }

  pickInPlane(event) {
    const [x, y] = this.camera.pointAt(event.offsetX, event.offsetY);
    const radius = (PICK_RADIUS[event.pointerType] ?? PICK_RADIUS.mouse) / this.camera.scale;
    return pickCycle(this.session.mirror, this.session.annotations, this.tracksByLabel, x, y, radius);
  }

  hover(pick) {
    this.hovered = pick;
    this.requestDraw();
  }

  pin(pick) {
    this.pinned = pick;
    if (!pick) this.hovered = null;
    this.requestDraw();
  }

  /** Pins the next living track in the order of persistence. */
  pinNext(by) {
    const alive = [...this.session.annotations.alive];
    alive.sort((a, b) => b.death - b.birth - (a.death - a.birth) || a.id - b.id);
    if (alive.length === 0) return;
    const at = alive.findIndex((track) => isPicked(this.pinned, track.id));
    const first = by > 0 ? 0 : alive.length - 1;
    const { id, birth, death } = alive[at < 0 ? first : (at + by + alive.length) % alive.length];
    this.pin({ track: id, birth, death });
  }

  fit() {
    this.renderer.bounds.clear();
    this.camera.fit();
  }

  onChange(what) {
    if (what === "stream") {
      this.fit();
      this.pin(null);
      this.drawn = null;
    }
    if (what === "streams" || what === "stream") this.controls.showStreams();
    if (what === "status") return this.showStatus();
    if (what === "frame") this.countFrames();
    this.requestDraw();
  }

  /** Counts frames that were received, also those that were not drawn. */
  countFrames() {
    const { framesReceived } = this.session;
    for (; this.counted < framesReceived; this.counted++) this.followed.add();
  }

  /** Draws before the next screen frame for which there is time. */
  requestDraw() {
    if (this.isRequested || document.hidden) return;
    this.isRequested = true;
    requestAnimationFrame(() => this.drawIfTime());
  }

  /** Draws, or tries again later while the last drawing is pending or has not been followed by as long a pause. */
  drawIfTime() {
    const start = performance.now();
    if (start < this.nextDrawAt) return void setTimeout(() => this.retry(), this.nextDrawAt - start);
    if (this.renderer.isBusy) return this.retry();
    this.isRequested = false;
    this.draw();
    const end = performance.now();
    this.nextDrawAt = 2 * end - start;
  }

  retry() {
    requestAnimationFrame(() => this.drawIfTime());
  }

  draw() {
    const { mirror, annotations } = this.session;
    if (mirror.frame && mirror.frame !== this.drawn) this.drawings.add();
    this.drawn = mirror.frame;
    this.tracksByLabel.update(annotations.alive);
    this.renderer.draw(mirror, annotations, this.pick);
    const now = performance.now();
    const isUrgent = this.pick !== this.panelsPick;
    const left = PANEL_INTERVAL - (now - this.panelsDrawnAt);
    if (!isUrgent && left > 0) return this.drawAfter(left);
    [this.panelsDrawnAt, this.panelsPick] = [now, this.pick];
    this.drawPanels();
  }

  /** Draws the panels, and shows the status. */
  drawPanels() {
    const { mirror, annotations, tracks, history } = this.session;
    const { frame } = mirror;
    this.diagram.draw(frame, annotations.dots, this.pick);
    const newest = history.steps[history.steps.length - 1]?.frame.number ?? 0;
    this.timeline.draw(tracks.lifetimes, Number(newest), frame ? Number(frame.number) : 0, this.pick);
    this.controls.setLargest(this.diagram.largest || 1);
    this.showStatus();
    showCycle(this.pick, annotations.byId);
  }

  /** Shows the status, which needs no drawing. */
  showStatus() {
    this.controls.show();
    showStatus(this.session, this.followed.value, this.drawings.value);
  }

  /** Draws again after a pause, so that every panel shows the last frame in the end. */
  drawAfter(pause) {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.requestDraw(), pause);
  }

  /** The state for tests. */
  state() {
    const { visibleFrame } = this.renderer;
    const { connection, mirror, annotations, choice, paused, history, resyncs } = this.session;
    return {
      connected: connection.state === "connected",
      stream: choice.stream,
      frame: mirror.frame ? Number(mirror.frame.number) : null,
      seen: visibleFrame ? Number(visibleFrame.number) : null,
      points: mirror.frame ? Number(mirror.frame.points) : 0,
      edges: mirror.edges.count,
      critical: mirror.critical.count,
      tracks: annotations.alive.length,
      fps: this.followed.value,
      drawn: this.drawings.value,
      lag: connection.lag,
      view: mirror.frame?.view ?? null,
      paused,
      back: history.before,
      resyncs,
      vertices: mirror.vertices.count,
      frames: this.session.framesReceived,
    };
  }
}

const page = new Page();
window.hopes = { state: () => page.state() };
page.start();
