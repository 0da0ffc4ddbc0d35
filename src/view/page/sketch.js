//! The plane where there is no graphics card: the same picture, drawn by the processor.
//!
//! In: a mirror and what lives beside it, a camera, what is meant. Out: pixels. Invariants: what there are many of is
//! drawn pixel by pixel, what stands out is drawn smooth; a walk takes no more corners than pixels. Must not know:
//! sockets, messages.

import { Bounds } from "./bounds.js";
import { colorOf, palette } from "./colors.js";
import { fillingOf, forCritical, holesOf, outlinesOf, pointSize } from "./looks.js";
import { Raster, wordOf } from "./raster.js";
import { forRuns, linkOf } from "./slots.js";

/** Out of every view, for slots that are free. */
const AWAY = -1e9;

export class Sketch {
  /**
   * @param {HTMLCanvasElement} canvas @param {import("./camera.js").Camera} camera
   * @param {import("./cycles.js").Labels} labels
   */
  constructor(canvas, camera, labels) {
    this.canvas = canvas;
    this.camera = camera;
    this.labels = labels;
    this.bounds = new Bounds();
    /** The frame that can be seen, or null. */
    this.seen = null;
    this.raster = new Raster();
    /** Where the raster goes before it is laid over what lies below. */
    this.sheet = document.createElement("canvas");
    /** Where each vertex is, in pixels. */
    this.places = new Float64Array(0);
    /** The vertices that each edge joins. */
    this.links = new Int32Array(0);
    // Pixels that the processor draws had better stay with it.
    [this.to, this.onSheet] = [canvas, this.sheet].map((one) => one.getContext("2d", { willReadFrequently: true }));
  }

  /** Draws a frame. @param {import("./mirror.js").Mirror} mirror */
  draw(mirror, beside, hit) {
    const box = this.bounds.take(mirror.vertices);
    if (box) this.camera.take(box);
    this.begin();
    this.project(mirror.vertices);
    this.link(mirror);
    this.fillHoles(mirror, beside, hit);
    this.drawMany(mirror);
    const thick = this.drawThin(mirror, hit);
    this.layRaster();
    this.drawOutlines(mirror, beside, hit);
    for (const edge of thick) this.drawThick(edge);
    this.seen = mirror.frame;
  }

  /** What is drawn is drawn at once. */
  get isBusy() {
    return false;
  }

  begin() {
    const { canvas, to } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    to.clearRect(0, 0, width, height);
    to.lineJoin = "round";
    if (!this.raster.begin(width, height)) return;
    [this.sheet.width, this.sheet.height] = [width, height];
    const pixels = new Uint8ClampedArray(this.raster.words.buffer);
    this.image = pixels.length > 0 ? new ImageData(pixels, width, height) : null;
  }

  layRaster() {
    if (!this.image) return;
    this.onSheet.putImageData(this.image, 0, 0);
    this.to.drawImage(this.sheet, 0, 0);
  }

  /** Finds where vertices are. */
  project({ rows, end, hashes }) {
    if (this.places.length < hashes.length) this.places = new Float64Array(hashes.length);
    const { places, camera, canvas } = this;
    const { scale } = camera;
    const [left, top] = [canvas.clientWidth / 2 - camera.x * scale, canvas.clientHeight / 2 + camera.y * scale];
    for (let slot = 0; slot < end; slot++) {
      const isFree = rows[3 * slot] < 0;
      places[2 * slot] = isFree ? AWAY : left + rows[3 * slot + 1] * scale;
      places[2 * slot + 1] = isFree ? AWAY : top - rows[3 * slot + 2] * scale;
    }
  }

  /** Finds which vertices are joined. */
  link({ vertices, edges }) {
    if (this.links.length < edges.hashes.length) {
      this.links = new Int32Array(edges.hashes.length);
      edges.changed.fill(1);
    }
    forRuns(edges, (from, to) => {
      for (let slot = from; slot < to; slot++) linkOf(vertices, edges, slot, this.links);
    });
  }

  /** Tree edges and points. */
  drawMany({ vertices, edges }) {
    const { raster, places, links } = this;
    const edge = wordOf(palette.edge.rgb, 0.85);
    for (let at = 0; at < 2 * edges.end; at += 2) {
      const [from, to] = [2 * links[at], 2 * links[at + 1]];
      if (from !== to) raster.line(places[from], places[from + 1], places[to], places[to + 1], edge);
    }
    const room = this.bounds.room(vertices.count) * this.camera.scale;
    raster.size(pointSize(room));
    const point = wordOf(palette.point.rgb, 0.9);
    for (let at = 0; at < 2 * vertices.end; at += 2) raster.dot(places[at], places[at + 1], point);
  }

  /** Critical edges of which there are many. Gives the others. */
  drawThin({ vertices, critical }, hit) {
    const { raster, places } = this;
    const thick = [];
    forCritical(critical, this.labels, hit, (a, b, color, alpha, width) => {
      const [from, to] = [2 * vertices.find(a), 2 * vertices.find(b)];
      if (from < 0 || to < 0) return;
      if (width > 1) thick.push({ from, to, color, width });
      else raster.line(places[from], places[from + 1], places[to], places[to + 1], wordOf(color.rgb, alpha));
    });
    return thick;
  }

  drawThick({ from, to: end, color, width }) {
    const { to, places } = this;
    to.beginPath();
    to.moveTo(places[from], places[from + 1]);
    to.lineTo(places[end], places[end + 1]);
    this.stroke(color, 1, width);
  }

  stroke(color, alpha, width) {
    const { to } = this;
    to.globalAlpha = alpha;
    to.strokeStyle = color.css;
    to.lineWidth = 2 * width;
    to.stroke();
    to.globalAlpha = 1;
  }

  /** What is inside an odd number of a hole's walks. */
  fillHoles(mirror, beside, hit) {
    const { to } = this;
    for (const track of holesOf(mirror, beside)) {
      to.beginPath();
      for (const walk of beside.cycles.get(track.id)) this.trace(mirror.vertices, walk);
      to.globalAlpha = fillingOf(track, hit);
      to.fillStyle = colorOf(track.id).css;
      to.fill("evenodd");
    }
    to.globalAlpha = 1;
  }

  drawOutlines(mirror, beside, hit) {
    const { to } = this;
    for (const { track, walk, color, alpha, width } of outlinesOf(mirror, beside, hit)) {
      to.beginPath();
      if (walk) this.trace(mirror.vertices, walk);
      else this.circle(track);
      this.stroke(color, alpha, width);
    }
  }

  circle({ center: [x, y], radius }) {
    const { camera, canvas, to } = this;
    const [left, top] = [canvas.clientWidth / 2, canvas.clientHeight / 2];
    to.arc(left + (x - camera.x) * camera.scale, top - (y - camera.y) * camera.scale, radius * camera.scale, 0, 7);
  }

  /** Adds a walk to the path, without corners that nobody could see. A vertex that is not there leaves it out. */
  trace(vertices, walk) {
    const { places, to } = this;
    const path = [];
    let [left, top] = [Infinity, Infinity];
    for (const id of walk) {
      const at = 2 * vertices.find(id);
      if (at < 0) return;
      const [x, y] = [places[at], places[at + 1]];
      if (Math.abs(x - left) + Math.abs(y - top) < 1) continue;
      path.push(x, y);
      [left, top] = [x, y];
    }
    for (let i = 0; i < path.length; i += 2) {
      if (i === 0) to.moveTo(path[0], path[1]);
      else to.lineTo(path[i], path[i + 1]);
    }
    if (path.length > 0) to.closePath();
  }
}
