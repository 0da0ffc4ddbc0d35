//! The page: puts session, pictures and controls together, and draws when something has changed.
//!
//! In: the address, the user. Out: the page, and `window.hopes.state()` for tests. Invariants: at most one drawing a
//! screen frame and none where nothing has changed; drawing never takes more than half of the time, so that there is
//! always some for following; a hidden page follows nothing. Must not know: bytes, the graphics card.

import { Camera } from "./camera.js";
import { readPalette } from "./colors.js";
import { Controls, choiceFrom } from "./controls.js";
import { Labels, cycleAt, isMeant } from "./cycles.js";
import { Diagram } from "./diagram.js";
import { Lives } from "./lives.js";
import { painterOf } from "./painter.js";
import { Session } from "./session.js";
import { Rate, showCycle, showStatus } from "./status.js";

/** The small pictures and the words are drawn anew at most so often, in milliseconds, while frames come. */
const SLOWLY = 70;
/** How near to an edge counts as on it, in pixels; a finger is broader than a mouse. */
const REACH = { mouse: 9, touch: 18 };

const el = (id) => document.getElementById(id);

class Page {
  constructor() {
    readPalette();
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.session = new Session(`${scheme}://${location.host}/ws`, choiceFrom(location.hash), (what) =>
      this.changed(what),
    );
    this.labels = new Labels();
    this.camera = new Camera(el("plane"), () => this.mark());
    this.plane = painterOf(el("plane"), this.camera, this.labels);
    this.diagram = new Diagram(el("diagram"), this.labels);
    this.lives = new Lives(el("lives"));
    this.controls = new Controls(this.session, {
      fit: () => this.fit(),
      next: (by) => this.pinNext(by),
      drop: () => this.pin(null),
    });
    /** What the pointer is on, and what stays meant when it goes. */
    this.hovered = null;
    this.pinned = null;
    this.frames = new Rate();
    this.drawings = new Rate();
    this.counted = 0;
    this.drawn = null;
    this.restsUntil = 0;
    this.slowlyAt = 0;
    this.listen();
  }

  start() {
    this.session.hide(document.hidden);
    this.session.start();
    this.mark();
  }

  get meant() {
    return this.hovered ?? this.pinned;
  }

  listen() {
    const dark = matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", () => {
      readPalette();
      this.mark();
    });
    document.addEventListener("visibilitychange", () => {
      this.session.hide(document.hidden);
      this.mark();
    });
    new ResizeObserver(() => this.mark()).observe(el("views"));
    this.watch(el("plane"), (event) => this.cycleUnder(event));
    this.watch(el("diagram"), (event) => this.diagram.at(event.offsetX, event.offsetY));
    this.watch(el("lives"), (event) => this.lives.at(event.offsetX, event.offsetY));
  }

  /** Lets a picture's pointer mean a cycle, and a click keep it meant. */
  watch(canvas, cycleUnder) {
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons === 0 || event.pointerType !== "mouse") this.hover(cycleUnder(event));
    });
    canvas.addEventListener("pointerleave", () => this.hover(null));
    canvas.addEventListener("click", (event) => {
      if (canvas === el("plane") && this.camera.travel > 4) return;
      this.pin(cycleUnder(event));
    });
  }

  cycleUnder(event) {
    const [x, y] = this.camera.placeAt(event.offsetX, event.offsetY);
    const reach = (REACH[event.pointerType] ?? REACH.mouse) / this.camera.scale;
    return cycleAt(this.session.mirror, this.session.beside, this.labels, x, y, reach);
  }

  hover(hit) {
    this.hovered = hit;
    this.mark();
  }

  pin(hit) {
    this.pinned = hit;
    if (!hit) this.hovered = null;
    this.mark();
  }

  /** Means the next living track, the most persistent first. */
  pinNext(by) {
    const alive = [...this.session.beside.alive].sort((a, b) => b.death - b.birth - (a.death - a.birth) || a.id - b.id);
    if (alive.length === 0) return;
    const at = alive.findIndex((track) => isMeant(this.pinned, track.id));
    const { id, birth, death } =
      alive[at < 0 ? (by > 0 ? 0 : alive.length - 1) : (at + by + alive.length) % alive.length];
    this.pin({ track: id, birth, death });
  }

  fit() {
    this.plane.bounds.clear();
    this.camera.fit();
  }

  changed(what) {
    if (what === "stream") {
      this.fit();
      this.pin(null);
      this.drawn = null;
    }
    if (what === "streams" || what === "stream") this.controls.showStreams();
    if (what === "status") return this.showStatus();
    if (what === "frame") this.countFrames();
    this.mark();
  }

  /** Frames that were followed, whether or not there was time to draw each. */
  countFrames() {
    const { framesSeen } = this.session;
    for (; this.counted < framesSeen; this.counted++) this.frames.add();
  }

  /** Something has changed: draws before the next screen frame for which there is time. */
  mark() {
    if (this.waiting || document.hidden) return;
    this.waiting = true;
    requestAnimationFrame(() => this.drawInTime());
  }

  /** Draws, unless the drawings before took so long that following comes first, or are not even done. */
  drawInTime() {
    const start = performance.now();
    if (start < this.restsUntil) return void setTimeout(() => this.again(), this.restsUntil - start);
    if (this.plane.isBusy) return this.again();
    this.waiting = false;
    this.draw();
    const end = performance.now();
    this.restsUntil = 2 * end - start;
  }

  again() {
    requestAnimationFrame(() => this.drawInTime());
  }

  draw() {
    const { mirror, beside } = this.session;
    if (mirror.frame && mirror.frame !== this.drawn) this.drawings.add();
    this.drawn = mirror.frame;
    this.labels.take(beside.alive);
    this.plane.draw(mirror, beside, this.meant);
    const now = performance.now();
    const isUrgent = this.meant !== this.meantThen;
    if (!isUrgent && now - this.slowlyAt < SLOWLY) return this.later(SLOWLY - (now - this.slowlyAt));
    [this.slowlyAt, this.meantThen] = [now, this.meant];
    this.drawBeside();
  }

  /** Draws the small pictures, and says how things stand. */
  drawBeside() {
    const { mirror, beside, tracks, history } = this.session;
    const { frame } = mirror;
    this.diagram.draw(frame, beside.dots, this.meant);
    const newest = history.steps[history.steps.length - 1]?.frame.number ?? 0;
    this.lives.draw(tracks.lifelines, Number(newest), frame ? Number(frame.number) : 0, this.meant);
    this.controls.takeLargest(this.diagram.largest || 1);
    this.showStatus();
    showCycle(this.meant, beside.byId);
  }

  /** Says how things stand; no picture changes by that. */
  showStatus() {
    this.controls.show();
    showStatus(this.session, this.frames.value, this.drawings.value);
  }

  /** Draws again after a while, so that the last frame of all is shown in every picture. */
  later(pause) {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.mark(), pause);
  }

  /** What tests may know. */
  state() {
    const { seen } = this.plane;
    const { connection, mirror, beside, choice, paused, history, resyncs } = this.session;
    return {
      connected: connection.state === "connected",
      stream: choice.stream,
      frame: mirror.frame ? Number(mirror.frame.number) : null,
      seen: seen ? Number(seen.number) : null,
      points: mirror.frame ? Number(mirror.frame.points) : 0,
      edges: mirror.edges.count,
      critical: mirror.critical.count,
      tracks: beside.alive.length,
      fps: this.frames.value,
      drawn: this.drawings.value,
      lag: connection.lag,
      view: mirror.frame?.view ?? null,
      paused,
      back: history.before,
      resyncs,
      vertices: mirror.vertices.count,
      frames: this.session.framesSeen,
    };
  }
}

const page = new Page();
/** For tests. */
window.hopes = { state: () => page.state() };
page.start();
