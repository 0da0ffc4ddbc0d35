//! The page: connects session, renderer and panels, and draws when something has changed.
//!
//! In: the address, the user.
//! Out: the page; `window.hopes.state()` for tests.
//! Invariants: at most one drawing per screen frame, and none where nothing has changed. Drawing takes at most half of
//! the time, and less while the page is behind, so that the rest is left for following. A hidden page follows nothing.
//! Must not know: bytes, the graphics card.

import { Camera } from "./drawing/camera.js";
import { assignColors, forgetColors, readPalette } from "./drawing/colors.js";
import { TracksByLabel, isPicked, pickCycle } from "./drawing/picking.js";
import { createRenderer } from "./drawing/renderer.js";
import { Controls, choiceFrom } from "./panels/controls.js";
import { Diagram } from "./panels/diagram.js";
import { Ruler } from "./panels/ruler.js";
import { spaceName } from "./panels/spaces.js";
import { Rate, showCycle, showStatus } from "./panels/status.js";
import { Timeline } from "./panels/timeline.js";
import { Projection } from "./projection/projection.js";
import { Session } from "./session/session.js";

/** How near to an edge a pointer must be, in pixels. A finger is less precise than a mouse. */
const PICK_RADIUS = { mouse: 9, touch: 18 };

/** A page that lags by so many milliseconds pauses for so many times as long as a drawing took. */
const FAR_BEHIND = 300;
const PAUSES_BEHIND = 4;
/** Content that is so many times as wide as high gets the whole width, and keeps it down to the lesser ratio. */
const WIDE = 2.8;
const LEAST_WIDE = 2;

const el = (id) => document.getElementById(id);

class Page {
  constructor() {
    readPalette();
    // Relative to the page, which a proxy may show below a path of its own; `http` becomes `ws`, `https` `wss`.
    const socket = new URL("ws", location.href).href.replace(/^http/, "ws");
    this.session = new Session(socket, choiceFrom(location.hash), (what) => this.onChange(what));
    this.tracksByLabel = new TracksByLabel();
    this.projection = new Projection();
    this.camera = new Camera(el("plane"), () => this.requestDraw(), this.projection);
    this.renderer = createRenderer(el("plane"), this.camera, this.tracksByLabel);
    this.diagram = new Diagram(el("diagram"), this.tracksByLabel);
    this.timeline = new Timeline(el("lives"));
    this.ruler = new Ruler(this.camera);
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
    /** What was drawn last: as it was projected, and in numbers for tests. */
    this.projected = null;
    this.picture = null;
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
    new ResizeObserver(() => this.camera.refit()).observe(el("plane"));
    new ResizeObserver(() => this.requestDraw()).observe(el("views"));
    this.listenForPicks(el("plane"), (event) => this.pickInPlane(event));
    this.listenForPicks(el("diagram"), (event) => this.diagram.pickAt(event.offsetX, event.offsetY));
    this.listenForPicks(el("lives"), (event) => this.timeline.pickAt(event.offsetX, event.offsetY));
    this.listenForPlaces(el("plane"), (place) => this.ruler.point(place));
    this.listenForPlaces(el("diagram"), (place) => {
      el("diagram-place").textContent = place ? this.diagram.describe(place.x, place.y) : "";
    });
  }

  /** Tells where the pointer is in a canvas; null outside of it. */
  listenForPlaces(canvas, show) {
    canvas.addEventListener("pointermove", ({ offsetX, offsetY }) => show({ x: offsetX, y: offsetY }));
    canvas.addEventListener("pointerleave", () => show(null));
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
    if (!this.projected) return null;
    const { mirror, annotations } = this.projected;
    const [x, y] = this.camera.pointAt(event.offsetX, event.offsetY);
    const radius = (PICK_RADIUS[event.pointerType] ?? PICK_RADIUS.mouse) / this.camera.scale;
    return pickCycle(mirror, annotations, this.tracksByLabel, x, y, radius);
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
      this.projection.reset();
      this.fit();
      this.pin(null);
      this.drawn = this.projected = null;
      forgetColors();
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
    const pauses = this.session.connection.lag > FAR_BEHIND ? PAUSES_BEHIND : 1;
    this.nextDrawAt = end + pauses * (end - start);
  }

  retry() {
    requestAnimationFrame(() => this.drawIfTime());
  }

  /** Draws a picture: plane and panels at once, so that all of them show one frame. */
  draw() {
    const { mirror, simplified, annotations, tracks, history } = this.session;
    const { frame } = mirror;
    if (frame && frame !== this.drawn) this.drawings.add();
    this.drawn = frame;
    this.tracksByLabel.update(annotations.alive);
    assignColors(annotations.alive);
    this.projected = this.projection.project({ mirror, simplified, annotations });
    this.renderer.draw(this.projected, this.pick);
    this.diagram.draw(frame, annotations, this.pick);
    this.timeline.draw(tracks.lifetimes, history.newest, frame ? frame.number : 0, this.pick);
    this.shapePlane();
    this.ruler.show(mirror);
    this.controls.setLargest(this.diagram.largest || 1);
    this.showStatus();
    showCycle(this.pick, annotations.byId);
    this.notePicture();
  }

  /** Gives the plane the whole width if its content is a wide strip, of which little would be seen in a square. */
  shapePlane() {
    const { box } = this.renderer.bounds;
    if (!box) return;
    const ratio = (box[2] - box[0]) / (box[3] - box[1] || 1e-300);
    const { dataset } = document.body;
    const isWide = ratio > (dataset.shape === "wide" ? LEAST_WIDE : WIDE);
    if (isWide !== (dataset.shape === "wide")) dataset.shape = isWide ? "wide" : "compact";
  }

  /** Notes what was drawn, for tests: it must be of one frame, and nothing of it may be missing. */
  notePicture() {
    const { mirror, annotations } = this.session;
    const { frame } = mirror;
    this.picture = frame && {
      frame: frame.number,
      dots: annotations.dots.frame,
      tracks: annotations.tracksFrame,
      simplified: annotations.simplified,
      diagram: this.diagram.frame,
      cycles: frame.cycles,
      critical: mirror.critical.count,
      space: spaceName(mirror),
      box: this.renderer.bounds.box,
      marked: this.diagram.shown,
      holes: this.renderer.holes,
      walks: annotations.alive.filter(({ id }) => annotations.cycles.get(id)?.length).length,
    };
  }

  /** Shows the status, which needs no drawing. */
  showStatus() {
    this.controls.show();
    showStatus(this.session, this.followed.value, this.drawings.value);
  }

  /** The state for tests. */
  state() {
    const { visibleFrame } = this.renderer;
    const { connection, mirror, simplified, annotations, choice, paused, history, resyncs } = this.session;
    return {
      connected: connection.state === "connected",
      stream: choice.stream,
      frame: mirror.frame?.number ?? null,
      seen: visibleFrame?.number ?? null,
      picture: this.picture,
      points: mirror.frame ? Number(mirror.frame.points) : 0,
      edges: mirror.edges.count,
      critical: mirror.critical.count,
      tracks: annotations.alive.length,
      fps: this.followed.value,
      drawn: this.drawings.value,
      lag: connection.lag,
      view: mirror.frame && { cut: mirror.frame.view.cut, simplify: simplified.frame?.view.simplify ?? "No" },
      paused,
      back: history.before,
      resyncs,
      vertices: mirror.vertices.count,
      simplified: annotations.simplified === null ? null : simplified.vertices.count,
      frames: this.session.framesReceived,
    };
  }
}

const page = new Page();
window.hopes = { state: () => page.state() };
page.start();
