//! The plane without a graphics card: the same picture, drawn by the processor.
//!
//! In: a picture (mirrors and annotations of one frame), a camera, the picked cycle.
//! Out: pixels.
//! Invariants: numerous elements are drawn into a raster without antialiasing; cycles are drawn with antialiasing. A
//! drawn walk has no more corners than pixels.
//! Must not know: sockets, messages.

import { fadeBetween } from "../projection/vertices.js";
import { Bounds } from "./bounds.js";
import { colorOf, palette } from "./colors.js";
import { forChangedRanges, writeEdgeIndices } from "./indices.js";
import { DepthOrder } from "./layers.js";
import { Raster, packColor } from "./raster.js";
import {
  SIMPLIFIED_WIDTH,
  fillOpacity,
  filledHoles,
  forCriticalEdges,
  outlinesOf,
  pointSize,
  treeOpacity,
} from "./styles.js";

/** The coordinates of free slots: outside of every view. */
const OUTSIDE = -1e9;
const POINT_OPACITY = 0.9;

export class SoftwareRenderer {
  /**
   * @param {HTMLCanvasElement} canvas @param {import("./camera.js").Camera} camera
   * @param {import("./picking.js").TracksByLabel} tracksByLabel
   */
  constructor(canvas, camera, tracksByLabel) {
    this.canvas = canvas;
    this.camera = camera;
    this.tracksByLabel = tracksByLabel;
    this.bounds = new Bounds();
    this.depthOrder = new DepthOrder();
    /** The frame on the screen, or null. */
    this.visibleFrame = null;
    /** How many holes are filled. */
    this.holes = 0;
    this.raster = new Raster();
    /** The canvas through which the raster is blended into the picture. */
    this.layer = document.createElement("canvas");
    /** The position of each vertex in pixels. */
    this.positions = new Float64Array(0);
    /** The slots of each edge's ends. */
    this.edgeIndices = new Int32Array(0);
    // The option keeps the pixels, which the processor draws, in main memory.
    [this.context, this.layerContext] = [canvas, this.layer].map((one) =>
      one.getContext("2d", { willReadFrequently: true }),
    );
  }

  /** Draws a picture. @param {import("./renderer.js").Picture} picture */
  draw({ mirror, simplified, annotations }, pick) {
    const box = this.bounds.update(mirror.vertices);
    if (box) this.camera.follow(box);
    this.begin();
    this.project(mirror.vertices);
    this.updateEdgeIndices(mirror);
    this.fillHoles(mirror, annotations, pick);
    this.drawTree(mirror, treeOpacity(annotations));
    const thick = this.drawThinCritical(mirror, pick);
    this.drawRaster();
    this.drawOutlines(mirror, annotations, pick);
    for (const edge of thick) this.drawThickLine(edge);
    if (annotations.simplified !== null) this.drawSimplified(simplified);
    this.visibleFrame = mirror.frame;
  }

  /** Drawing is synchronous. */
  get isBusy() {
    return false;
  }

  begin() {
    const { canvas, context } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    context.clearRect(0, 0, width, height);
    context.lineJoin = "round";
    if (!this.raster.reset(width, height)) return;
    [this.layer.width, this.layer.height] = [width, height];
    const pixels = new Uint8ClampedArray(this.raster.words.buffer);
    this.image = pixels.length > 0 ? new ImageData(pixels, width, height) : null;
  }

  /** Blends the raster into the picture. */
  drawRaster() {
    if (!this.image) return;
    this.layerContext.putImageData(this.image, 0, 0);
    this.context.drawImage(this.layer, 0, 0);
  }

  /** Computes the positions of vertices. */
  project({ rows, end, hashes }) {
    if (this.positions.length < hashes.length) this.positions = new Float64Array(hashes.length);
    const { positions, camera, canvas } = this;
    const { scale } = camera;
    const [left, top] = [canvas.clientWidth / 2 - camera.x * scale, canvas.clientHeight / 2 + camera.y * scale];
    for (let slot = 0; slot < end; slot++) {
      const isFree = rows[3 * slot] < 0;
      positions[2 * slot] = isFree ? OUTSIDE : left + rows[3 * slot + 1] * scale;
      positions[2 * slot + 1] = isFree ? OUTSIDE : top - rows[3 * slot + 2] * scale;
    }
  }

  /** Updates the slots of edges that changed. */
  updateEdgeIndices({ vertices, edges }) {
    if (this.edgeIndices.length < edges.hashes.length) {
      this.edgeIndices = new Int32Array(edges.hashes.length);
      edges.changed.fill(1);
    }
    forChangedRanges(edges, (from, end) => {
      for (let slot = from; slot < end; slot++) writeEdgeIndices(vertices, edges, slot, this.edgeIndices);
    });
  }

  /** Draws tree edges and points, by depth where there is one. */
  drawTree(mirror, opacity) {
    const { vertices, edges } = mirror;
    this.raster.setDotSize(pointSize(this.bounds.spacing(vertices.count) * this.camera.scale));
    if (vertices.depths) return this.drawLayers(mirror, opacity);
    const edge = packColor(palette.edge.rgb, opacity);
    for (let slot = 0; slot < edges.end; slot++) this.drawEdge(slot, edge);
    const point = packColor(palette.point.rgb, POINT_OPACITY);
    for (let slot = 0; slot < vertices.end; slot++) this.drawPoint(slot, point);
  }

  /** Draws edges and points by depth, the farthest first. */
  drawLayers(mirror, opacity) {
    const { depthOrder } = this;
    depthOrder.sort(mirror, this.edgeIndices);
    depthOrder.forEach(([firstEdge, lastEdge], [firstPoint, lastPoint], fade) => {
      const edge = packColor(palette.edge.rgb, opacity * fade);
      for (let i = firstEdge; i < lastEdge; i++) this.drawEdge(depthOrder.edges.order[i], edge);
      const point = packColor(palette.point.rgb, POINT_OPACITY * fade);
      for (let i = firstPoint; i < lastPoint; i++) this.drawPoint(depthOrder.points.order[i], point);
    });
  }

  drawEdge(slot, word) {
    const [from, to] = [this.edgeIndices[2 * slot], this.edgeIndices[2 * slot + 1]];
    if (from !== to) this.drawThinLine(from, to, word);
  }

  drawPoint(slot, word) {
    this.raster.dot(this.positions[2 * slot], this.positions[2 * slot + 1], word);
  }

  /** Draws the thin critical edges. Returns the thick ones. */
  drawThinCritical({ vertices, critical }, pick) {
    const thick = [];
    forCriticalEdges(critical, this.tracksByLabel, pick, (a, b, color, alpha, width) => {
      const [from, to] = [vertices.find(a), vertices.find(b)];
      if (from < 0 || to < 0) return;
      const opacity = alpha * fadeBetween(vertices, from, to);
      if (width > 1) thick.push({ from, to, color, opacity, width });
      else this.drawThinLine(from, to, packColor(color.rgb, opacity));
    });
    return thick;
  }

  drawThinLine(from, to, word) {
    const { positions } = this;
    this.raster.line(positions[2 * from], positions[2 * from + 1], positions[2 * to], positions[2 * to + 1], word);
  }

  /** Draws a line between two vertices. */
  drawThickLine({ from, to, color, opacity, width }) {
    const { context, positions } = this;
    context.beginPath();
    context.moveTo(positions[2 * from], positions[2 * from + 1]);
    context.lineTo(positions[2 * to], positions[2 * to + 1]);
    this.stroke(color, opacity, width);
  }

  stroke(color, alpha, width) {
    const { context } = this;
    context.globalAlpha = alpha;
    context.strokeStyle = color.css;
    context.lineWidth = 2 * width;
    context.stroke();
    context.globalAlpha = 1;
  }

  /** Fills what is inside an odd number of a hole's walks. */
  fillHoles(mirror, annotations, pick) {
    const { context } = this;
    this.holes = 0;
    for (const track of filledHoles(annotations)) {
      context.beginPath();
      const traced = annotations.cycles.get(track.id).filter((walk) => this.trace(mirror.vertices, walk));
      if (traced.length > 0) this.holes += 1;
      context.globalAlpha = fillOpacity(track, pick);
      context.fillStyle = colorOf(track.id).css;
      context.fill("evenodd");
    }
    context.globalAlpha = 1;
  }

  drawOutlines({ vertices }, annotations, pick) {
    const { context } = this;
    for (const { circle, walk, color, alpha, width } of outlinesOf(annotations, this.tracksByLabel, pick)) {
      if (walk && vertices.depths) {
        this.drawLoop(vertices, walk, color, alpha, width);
        continue;
      }
      context.beginPath();
      if (walk) this.trace(vertices, walk);
      else context.arc(...this.place(circle.x, circle.y), circle.radius * this.camera.scale, 0, 7);
      this.stroke(color, alpha, width);
    }
  }

  /** Draws a walk whose lines are paler the farther away they are. */
  drawLoop(vertices, walk, color, alpha, width) {
    for (let i = 0; i < walk.length; i++) {
      const [from, to] = [vertices.find(walk[i]), vertices.find(walk[(i + 1) % walk.length])];
      if (from < 0 || to < 0) continue;
      this.drawThickLine({ from, to, color, opacity: alpha * fadeBetween(vertices, from, to), width });
    }
  }

  /** The pixel of a place of the plane. */
  place(x, y) {
    const { camera, canvas } = this;
    const [left, top] = [canvas.clientWidth / 2, canvas.clientHeight / 2];
    return [left + (x - camera.x) * camera.scale, top - (y - camera.y) * camera.scale];
  }

  /** Draws the simplified skeleton, whose vertices are its own. */
  drawSimplified({ vertices, edges }) {
    const { context } = this;
    context.beginPath();
    for (let at = 0; at < 2 * edges.end; at += 2) {
      if (edges.rows[at] < 0) continue;
      const ends = [edges.rows[at], edges.rows[at + 1]].map((id) => 3 * vertices.find(id));
      const [from, to] = ends.map((row) => this.place(vertices.rows[row + 1], vertices.rows[row + 2]));
      context.moveTo(...from);
      context.lineTo(...to);
    }
    this.stroke(palette.ink, 1, SIMPLIFIED_WIDTH);
  }

  /** Adds a walk to the path, without corners closer than a pixel. False if one is unknown: the walk is left out. */
  trace(vertices, walk) {
    const { positions, context } = this;
    const path = [];
    let [left, top] = [Infinity, Infinity];
    for (const id of walk) {
      const at = 2 * vertices.find(id);
      if (at < 0) return false;
      const [x, y] = [positions[at], positions[at + 1]];
      if (Math.abs(x - left) + Math.abs(y - top) < 1) continue;
      path.push(x, y);
      [left, top] = [x, y];
    }
    for (let i = 0; i < path.length; i += 2) {
      if (i === 0) context.moveTo(path[0], path[1]);
      else context.lineTo(path[i], path[i + 1]);
    }
    if (path.length > 0) context.closePath();
    return true;
  }
}
