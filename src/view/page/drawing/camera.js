//! The camera of the plane: centre and scale, moved by pointers, wheel and keys.
//!
//! In: a canvas and its events; bounds of the content; whether it can be turned.
//! Out: centre and scale; turns, which are not the camera's own.
//! Invariants: until the user moves it, the camera keeps the content in view. The point under a pointer stays under it.
//! Must not know: what is drawn.

const ZOOM_STEP = 1.25;
/** The `buttons` of an event while the left one alone is down. */
const LEFT_BUTTON = 1;
/** How much larger the view is than the content. */
const MARGIN = 1.1;

export class Camera {
  /**
   * @param {HTMLCanvasElement} canvas @param {() => void} moved
   * @param {{canTurn: boolean, turn: (right: number, down: number) => void, turnBack: () => void}} content what turns
   */
  constructor(canvas, moved, content) {
    this.canvas = canvas;
    this.moved = moved;
    this.content = content;
    this.x = 0;
    this.y = 0;
    /** CSS pixels a unit. */
    this.scale = 1;
    /** Whether the camera follows the content, and whether it does so exactly the next time. */
    this.isFitting = this.isExact = true;
    /** Pointers that are down, by id. @type {Map<number, {x: number, y: number}>} */
    this.down = new Map();
    /** How far the pointers have moved since the first went down. */
    this.travel = 0;
    this.listen();
  }

  /** The point of the plane at a position of the canvas. */
  pointAt(left, top) {
    const { clientWidth, clientHeight } = this.canvas;
    return [this.x + (left - clientWidth / 2) / this.scale, this.y - (top - clientHeight / 2) / this.scale];
  }

  /** Follows the content from now on. */
  fit() {
    this.isFitting = true;
    this.refit();
  }

  /** Fits the content exactly, if it is followed: the canvas may have another size. */
  refit() {
    this.isExact = true;
    this.moved();
  }

  /** Follows the bounds of the content: [left, bottom, right, top]. Small changes leave the view as it is. */
  follow(bounds) {
    if (!this.isFitting) return;
    const [left, bottom, right, top] = bounds;
    const { clientWidth, clientHeight } = this.canvas;
    const fitting = Math.min(clientWidth / (right - left || 1), clientHeight / (top - bottom || 1)) / MARGIN;
    const [x, y] = [(left + right) / 2, (bottom + top) / 2];
    const drift = Math.max(Math.abs(x - this.x), Math.abs(y - this.y)) * this.scale;
    const ratio = fitting / this.scale;
    const isFine = ratio > 0.97 && ratio < 1.25 && drift < 0.04 * Math.min(clientWidth, clientHeight);
    if ((isFine && !this.isExact) || !Number.isFinite(fitting) || fitting <= 0) return;
    [this.x, this.y, this.scale, this.isExact] = [x, y, fitting, false];
  }

  pan(right, down) {
    this.x -= right / this.scale;
    this.y += down / this.scale;
    this.movedByUser();
  }

  /** Zooms around a position of the canvas. */
  zoom(factor, left = this.canvas.clientWidth / 2, top = this.canvas.clientHeight / 2) {
    const [x, y] = this.pointAt(left, top);
    const scale = this.scale * factor;
    if (!(scale > 1e-290 && scale < 1e290)) return;
    this.scale = scale;
    const [nowX, nowY] = this.pointAt(left, top);
    this.x += x - nowX;
    this.y += y - nowY;
    this.movedByUser();
  }

  movedByUser() {
    this.isFitting = false;
    this.moved();
  }

  listen() {
    const { canvas } = this;
    canvas.addEventListener("pointerdown", (event) => {
      if (this.down.size === 0) this.travel = 0;
      canvas.setPointerCapture(event.pointerId);
      this.down.set(event.pointerId, { x: event.offsetX, y: event.offsetY });
    });
    canvas.addEventListener("pointermove", (event) => this.drag(event));
    for (const name of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(name, (event) => this.down.delete(event.pointerId));
    }
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    canvas.addEventListener("dblclick", () => {
      this.content.turnBack();
      this.fit();
    });
    canvas.addEventListener("contextmenu", (event) => {
      // The right button moves what the left one turns.
      if (this.content.canTurn) event.preventDefault();
    });
    canvas.addEventListener("keydown", (event) => this.key(event));
  }

  /** Turns the content, if it can be turned and the user does not ask to move it; else moves it. */
  turnOrPan(right, down, isMove) {
    if (isMove || !this.content.canTurn) return this.pan(right, down);
    this.content.turn(right, down);
    this.moved();
  }

  /** One pointer turns or pans, two pointers zoom. */
  drag(event) {
    const before = this.down.get(event.pointerId);
    if (!before) return;
    const now = { x: event.offsetX, y: event.offsetY };
    const other = [...this.down].find(([id]) => id !== event.pointerId)?.[1];
    this.down.set(event.pointerId, now);
    this.travel += Math.hypot(now.x - before.x, now.y - before.y);
    if (this.travel < 3) return;
    const isMove = event.shiftKey || (event.pointerType === "mouse" && event.buttons !== LEFT_BUTTON);
    if (!other) return this.turnOrPan(now.x - before.x, now.y - before.y, isMove);
    const spread =
      Math.hypot(now.x - other.x, now.y - other.y) / (Math.hypot(before.x - other.x, before.y - other.y) || 1);
    this.zoom(Math.min(2, Math.max(0.5, spread)), other.x, other.y);
  }

  wheel(event) {
    event.preventDefault();
    const pixels = event.deltaY * (event.deltaMode === 1 ? 16 : event.deltaMode === 2 ? 400 : 1);
    this.zoom(Math.exp(-Math.max(-400, Math.min(400, pixels)) * 0.0018), event.offsetX, event.offsetY);
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const step = 0.08 * Math.min(this.canvas.clientWidth, this.canvas.clientHeight);
    const move = (right, down) => this.turnOrPan(right, down, event.shiftKey);
    const actions = {
      ArrowLeft: () => move(step, 0),
      ArrowRight: () => move(-step, 0),
      ArrowUp: () => move(0, step),
      ArrowDown: () => move(0, -step),
      "+": () => this.zoom(ZOOM_STEP),
      "=": () => this.zoom(ZOOM_STEP),
      "-": () => this.zoom(1 / ZOOM_STEP),
    };
    if (!actions[event.key]) return;
    actions[event.key]();
    event.preventDefault();
  }
}
