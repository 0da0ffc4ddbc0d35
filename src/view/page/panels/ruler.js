//! What the plane measures: a scale bar of a round length, and the coordinates under the pointer.
//!
//! In: the camera; positions of the pointer; the space of the stream.
//! Out: texts, and the length of the bar.
//! Invariants: the bar is 1, 2 or 5 times a power of ten long, and at most a quarter as long as the plane is wide.
//! Coordinates have as many decimals as pixels can tell apart.
//! Must not know: what is drawn.

import { formatNumber } from "./numbers.js";
import { axesOf, unitOf } from "./spaces.js";

/** The longest bar, in pixels and as a share of the plane's width. */
const LONGEST = 160;
const SHARE = 0.25;

const el = (id) => document.getElementById(id);

/** The largest round number that is not above a limit. */
export function roundLength(limit) {
  if (!(limit > 0) || !Number.isFinite(limit)) return 0;
  const power = 10 ** Math.floor(Math.log10(limit));
  return power * (limit >= 5 * power ? 5 : limit >= 2 * power ? 2 : 1);
}

/** A coordinate, where a unit has so many pixels. */
export function formatPlace(value, scale) {
  const decimals = Math.ceil(Math.log10(scale));
  if (!Number.isFinite(decimals) || decimals > 12 || Math.abs(value) >= 1e9) return formatNumber(value);
  const text = value.toFixed(Math.max(0, decimals));
  return Number(text) === 0 ? text.replace("-", "") : text;
}

export class Ruler {
  /** @param {import("../drawing/camera.js").Camera} camera */
  constructor(camera) {
    this.camera = camera;
    this.axes = ["x", "y"];
    this.unit = "";
    /** The position of the pointer in the plane's canvas, or null. */
    this.pointer = null;
  }

  /** Notes where the pointer is. @param {{x: number, y: number} | null} pointer */
  point(pointer) {
    this.pointer = pointer;
    this.showPlace();
  }

  /** Shows bar and coordinates in a stream's space. @param {import("../session/mirror.js").Mirror} mirror */
  show(mirror) {
    const { scale, canvas } = this.camera;
    [this.axes, this.unit] = [axesOf(mirror), unitOf(mirror)];
    const length = this.unit === null ? 0 : roundLength(Math.min(LONGEST, SHARE * canvas.clientWidth) / scale);
    el("scale").hidden = length === 0;
    el("scale-bar").style.width = `${(length * scale).toFixed(1)}px`;
    el("scale-length").textContent = `${formatNumber(length)}${this.unit}`;
    this.showPlace();
  }

  showPlace() {
    el("place").textContent = this.pointer ? this.placeText() : "";
  }

  placeText() {
    const point = this.camera.pointAt(this.pointer.x, this.pointer.y);
    return this.axes.map((name, i) => `${name} ${formatPlace(point[i], this.camera.scale)}`).join(", ");
  }
}
