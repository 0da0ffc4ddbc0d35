//! The plane with a graphics card: points, tree edges, critical edges and filled holes, drawn by WebGL2.
//!
//! In: a picture (mirrors and annotations of one frame), a camera, the picked cycle.
//! Out: pixels.
//! Invariants: only blocks that changed are uploaded. Uploaded coordinates are relative to an origin near the points,
//! so that the 24 bits of a float suffice. A lost context is rebuilt.
//! Must not know: sockets, messages.

import { Bounds } from "./bounds.js";
import { colorOf, palette } from "./colors.js";
import { forChangedRanges, writeEdgeIndices } from "./indices.js";
import { DepthOrder } from "./layers.js";
import { Strips } from "./strips.js";
import { fillOpacity, filledHoles, pointSize, treeOpacity } from "./styles.js";
import { Buffer, programs } from "./webgl.js";

/** The coordinates of free slots: outside of every view. */
const OUTSIDE = 1e30;

export class WebglRenderer {
  /**
   * @param {HTMLCanvasElement} canvas @param {WebGL2RenderingContext} gl
   * @param {import("./camera.js").Camera} camera @param {import("./picking.js").TracksByLabel} tracksByLabel
   */
  constructor(canvas, gl, camera, tracksByLabel) {
    this.canvas = canvas;
    this.camera = camera;
    this.tracksByLabel = tracksByLabel;
    this.origin = { x: 0, y: 0, unit: 1 };
    this.bounds = new Bounds();
    this.depthOrder = new DepthOrder();
    this.gl = gl;
    /** The newest frame whose drawing is finished, and drawings that may not be finished, the oldest first. */
    this.finished = null;
    this.pending = [];
    /** How many holes are filled. */
    this.holes = 0;
    this.build();
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => this.build());
  }

  build() {
    const { gl } = this;
    this.programs = programs(gl);
    this.positions = new Buffer(gl, gl.ARRAY_BUFFER, Float32Array);
    this.edgeIndices = new Buffer(gl, gl.ELEMENT_ARRAY_BUFFER, Uint32Array);
    this.fans = new Buffer(gl, gl.ELEMENT_ARRAY_BUFFER, Uint32Array);
    /** Points and edges by depth. */
    this.sorted = new Buffer(gl, gl.ELEMENT_ARRAY_BUFFER, Uint32Array);
    this.strips = new Strips(gl, this.tracksByLabel);
    this.positionsArray = this.vertexArray(() => {
      this.positions.bind();
      gl.enableVertexAttribArray(0);
      gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
    });
    this.emptyArray = gl.createVertexArray();
    this.isStale = true;
    this.pending = [];
  }

  vertexArray(describe) {
    const array = this.gl.createVertexArray();
    this.gl.bindVertexArray(array);
    describe();
    this.gl.bindVertexArray(null);
    return array;
  }

  /** Draws a picture. @param {import("./renderer.js").Picture} picture */
  draw(picture, pick) {
    const { gl } = this;
    const { mirror, annotations } = picture;
    if (gl.isContextLost()) return;
    this.updateOrigin(mirror);
    this.upload(mirror);
    this.begin();
    gl.bindVertexArray(this.positionsArray);
    this.useFlat();
    this.drawHoles(mirror, annotations, pick);
    if (mirror.vertices.depths) this.drawLayers(mirror, treeOpacity(annotations));
    else {
      this.drawEdges(mirror, treeOpacity(annotations));
      this.drawPoints(mirror);
    }
    this.drawStrips(picture, pick);
    gl.bindVertexArray(null);
    this.pending.push({ frame: mirror.frame, fence: gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0) });
    gl.flush();
  }

  /** Whether the graphics card is behind: it has not finished the drawing before the last. */
  get isBusy() {
    this.collectFinished();
    return this.pending.length > 1;
  }

  /** The newest frame on the screen, or null. */
  get visibleFrame() {
    this.collectFinished();
    return this.finished;
  }

  /** Notes which drawings are finished. */
  collectFinished() {
    const { gl, pending } = this;
    while (pending.length > 0 && gl.getSyncParameter(pending[0].fence, gl.SYNC_STATUS) !== gl.UNSIGNALED) {
      const { frame, fence } = pending.shift();
      gl.deleteSync(fence);
      this.finished = frame;
    }
  }

  /** Lets camera and origin follow the points. */
  updateOrigin({ vertices }) {
    const box = this.bounds.update(vertices);
    if (!box) return;
    this.camera.follow(box);
    const [left, bottom, right, top] = box;
    const unit = Math.max(right - left, top - bottom) || 1;
    const [x, y] = [(left + right) / 2, (bottom + top) / 2];
    const far = Math.max(Math.abs(x - this.origin.x), Math.abs(y - this.origin.y)) / unit;
    if (far < 4 && unit > this.origin.unit / 16 && unit < this.origin.unit * 16) return;
    this.origin = { x, y, unit };
    this.isStale = true;
  }

  /** Uploads what changed. */
  upload({ vertices, edges }) {
    const { gl, positions, edgeIndices, origin } = this;
    gl.bindVertexArray(null);
    if (positions.reserve((2 * vertices.hashes.length) / 2) || this.isStale) vertices.changed.fill(1);
    positions.bind();
    forChangedRanges(vertices, (from, to) => {
      for (let slot = from; slot < to; slot++) {
        const isFree = vertices.rows[3 * slot] < 0;
        positions.array[2 * slot] = isFree ? OUTSIDE : (vertices.rows[3 * slot + 1] - origin.x) / origin.unit;
        positions.array[2 * slot + 1] = isFree ? OUTSIDE : (vertices.rows[3 * slot + 2] - origin.y) / origin.unit;
      }
      positions.write(2 * from, 2 * to);
    });
    if (edgeIndices.reserve((2 * edges.hashes.length) / 2) || this.isStale) edges.changed.fill(1);
    edgeIndices.bind();
    forChangedRanges(edges, (from, to) => {
      for (let slot = from; slot < to; slot++) writeEdgeIndices(vertices, edges, slot, edgeIndices.array);
      edgeIndices.write(2 * from, 2 * to);
    });
    this.isStale = false;
  }

  begin() {
    const { gl, canvas } = this;
    const ratio = Math.min(devicePixelRatio || 1, 2);
    const [width, height] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    this.ratio = ratio;
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.disable(gl.DEPTH_TEST);
  }

  /** The transform from positions to the screen: two factors, then two offsets. */
  view() {
    const { camera, origin, canvas } = this;
    const [x, y] = [(2 * camera.scale) / (canvas.clientWidth || 1), (2 * camera.scale) / (canvas.clientHeight || 1)];
    return [origin.unit * x, origin.unit * y, (origin.x - camera.x) * x, (origin.y - camera.y) * y];
  }

  /** Uses the program for points, lines and triangles of one colour. */
  useFlat() {
    const { gl } = this;
    gl.useProgram(this.programs.flat.program);
    gl.uniform4fv(this.programs.flat.view, this.view());
    gl.uniform1i(this.programs.flat.isRound, 0);
  }

  setColor(color, alpha) {
    this.gl.uniform4f(this.programs.flat.color, ...color.rgb, alpha);
  }

  drawEdges({ edges }, opacity) {
    this.edgeIndices.bind();
    this.setColor(palette.edge, opacity);
    this.gl.drawElements(this.gl.LINES, 2 * edges.end, this.gl.UNSIGNED_INT, 0);
  }

  /** Draws points, as large as their spacing allows. */
  drawPoints({ vertices }) {
    this.setPoints(vertices, 1);
    this.gl.drawArrays(this.gl.POINTS, 0, vertices.end);
  }

  /** Sets size and colour of points. */
  setPoints({ count }, opacity) {
    const { gl } = this;
    const spacing = this.bounds.spacing(count) * this.camera.scale;
    gl.uniform1f(this.programs.flat.size, this.ratio * pointSize(spacing));
    gl.uniform1i(this.programs.flat.isRound, 1);
    // Where points overlap, their number makes the shade.
    this.setColor(palette.point, opacity * (spacing < 4 ? 0.55 : 0.9));
  }

  /** Draws edges and points by depth, the farthest first. */
  drawLayers(mirror, opacity) {
    const { gl, sorted, depthOrder, edgeIndices } = this;
    depthOrder.sort(mirror, edgeIndices.array);
    const { points, edges } = depthOrder;
    sorted.reserve(points.count + 2 * edges.count);
    sorted.array.set(points.order.subarray(0, points.count));
    for (let i = 0, at = points.count; i < edges.count; i++) {
      sorted.array[at++] = edgeIndices.array[2 * edges.order[i]];
      sorted.array[at++] = edgeIndices.array[2 * edges.order[i] + 1];
    }
    sorted.bind();
    sorted.write(0, points.count + 2 * edges.count);
    depthOrder.forEach(([firstEdge, lastEdge], [firstPoint, lastPoint], fade) => {
      gl.uniform1i(this.programs.flat.isRound, 0);
      this.setColor(palette.edge, opacity * fade);
      const start = 4 * (points.count + 2 * firstEdge);
      gl.drawElements(gl.LINES, 2 * (lastEdge - firstEdge), gl.UNSIGNED_INT, start);
      this.setPoints(mirror.vertices, fade);
      gl.drawElements(gl.POINTS, lastPoint - firstPoint, gl.UNSIGNED_INT, 4 * firstPoint);
    });
  }

  /** Fills each hole with the stencil: inside is where an odd number of the triangles of its fans overlap. */
  drawHoles(mirror, annotations, pick) {
    const { gl } = this;
    const ranges = this.uploadFans(mirror.vertices, filledHoles(annotations), annotations.cycles);
    this.holes = ranges.length;
    gl.enable(gl.STENCIL_TEST);
    for (const { track, from, count } of ranges) {
      gl.colorMask(false, false, false, false);
      gl.stencilFunc(gl.ALWAYS, 0, 1);
      gl.stencilOp(gl.KEEP, gl.KEEP, gl.INVERT);
      gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 4 * from);
      gl.colorMask(true, true, true, true);
      gl.stencilFunc(gl.NOTEQUAL, 0, 1);
      gl.stencilOp(gl.ZERO, gl.ZERO, gl.ZERO);
      this.setColor(colorOf(track.id), fillOpacity(track, pick));
      gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 4 * from);
    }
    gl.disable(gl.STENCIL_TEST);
  }

  /** Uploads the triangle fans of all holes. Returns the range of each. */
  uploadFans(vertices, holes, cycles) {
    const length = holes.reduce(
      (sum, { id }) => sum + cycles.get(id).reduce((all, walk) => all + 3 * walk.length, 0),
      0,
    );
    this.fans.reserve(length);
    let at = 0;
    const ranges = holes.map((track) => {
      const from = at;
      for (const walk of cycles.get(track.id)) at = writeFan(vertices, walk, this.fans.array, at);
      return { track, from, count: at - from };
    });
    this.fans.bind();
    this.fans.write(0, at);
    return ranges.filter(({ count }) => count > 0);
  }

  /** Draws outlines of holes, and critical edges above them. */
  drawStrips(picture, pick) {
    const { gl } = this;
    const count = this.strips.build(picture, pick, {
      ...this.origin,
      positions: this.positions.array,
      ratio: this.ratio,
    });
    if (count === 0) return;
    gl.useProgram(this.programs.strip.program);
    gl.uniform4fv(this.programs.strip.view, this.view());
    gl.uniform2f(this.programs.strip.pixels, this.canvas.width / 2, this.canvas.height / 2);
    gl.uniform1i(this.programs.strip.strips, 0);
    gl.bindVertexArray(this.emptyArray);
    gl.drawArrays(gl.TRIANGLES, 0, 6 * count);
  }
}

/** Writes the triangle fan of a walk. Returns where it ends. A walk with an unknown vertex is left out. */
function writeFan(vertices, walk, into, start) {
  let at = start;
  const first = vertices.find(walk[0] ?? -1);
  let previous = first;
  for (let i = 1; i < walk.length; i++) {
    const slot = vertices.find(walk[i]);
    if (slot < 0 || first < 0) return start;
    into[at++] = first;
    into[at++] = previous;
    into[at++] = slot;
    previous = slot;
  }
  return at;
}
