//! The plane: points, tree edges, critical edges and filled holes, drawn by WebGL2.
//!
//! In: a mirror and what lives beside it, a camera, what is meant. Out: pixels. Invariants: only blocks that have
//! changed are written to the graphics card; coordinates there are taken from an origin nearby, so that their 24 bits
//! suffice; a lost context is built anew. Must not know: sockets, messages.

import { Bounds } from "./bounds.js";
import { colorOf, palette } from "./colors.js";
import { Buffer, programs } from "./gl.js";
import { fillingOf, holesOf, pointSize } from "./looks.js";
import { forRuns, linkOf } from "./slots.js";
import { Strips } from "./strips.js";

/** Out of every view, for slots that are free. */
const AWAY = 1e30;

export class Plane {
  /**
   * @param {HTMLCanvasElement} canvas @param {WebGL2RenderingContext} gl
   * @param {import("./camera.js").Camera} camera @param {import("./cycles.js").Labels} labels
   */
  constructor(canvas, gl, camera, labels) {
    this.canvas = canvas;
    this.camera = camera;
    this.labels = labels;
    this.origin = { x: 0, y: 0, unit: 1 };
    this.bounds = new Bounds();
    this.gl = gl;
    /** The newest frame that is drawn for sure, and drawings that may not be done yet, the oldest first. */
    this.last = null;
    this.begun = [];
    this.build();
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => this.build());
  }

  build() {
    const { gl } = this;
    this.programs = programs(gl);
    this.places = new Buffer(gl, gl.ARRAY_BUFFER, Float32Array);
    this.links = new Buffer(gl, gl.ELEMENT_ARRAY_BUFFER, Uint32Array);
    this.fans = new Buffer(gl, gl.ELEMENT_ARRAY_BUFFER, Uint32Array);
    this.strips = new Strips(gl, this.labels);
    this.flatArray = this.arrayOf(() => {
      this.places.bind();
      gl.enableVertexAttribArray(0);
      gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
    });
    this.noArray = gl.createVertexArray();
    this.stale = true;
    this.begun = [];
  }

  arrayOf(describe) {
    const array = this.gl.createVertexArray();
    this.gl.bindVertexArray(array);
    describe();
    this.gl.bindVertexArray(null);
    return array;
  }

  /** Draws a frame. @param {import("./mirror.js").Mirror} mirror */
  draw(mirror, beside, hit) {
    const { gl } = this;
    if (gl.isContextLost()) return;
    this.look(mirror);
    this.upload(mirror);
    this.begin();
    gl.bindVertexArray(this.flatArray);
    this.useFlat();
    this.drawHoles(mirror, beside, hit);
    this.drawEdges(mirror);
    this.drawPoints(mirror);
    this.drawStrips(mirror, beside, hit);
    gl.bindVertexArray(null);
    this.begun.push({ frame: mirror.frame, fence: gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0) });
    gl.flush();
  }

  /** Whether the graphics card has enough to do: it has not even done the drawing before the last. */
  get isBusy() {
    this.settle();
    return this.begun.length > 1;
  }

  /** The frame that can be seen by now, or null. */
  get seen() {
    this.settle();
    return this.last;
  }

  /** Notes which drawings are done. */
  settle() {
    const { gl, begun } = this;
    while (begun.length > 0 && gl.getSyncParameter(begun[0].fence, gl.SYNC_STATUS) !== gl.UNSIGNALED) {
      const { frame, fence } = begun.shift();
      gl.deleteSync(fence);
      this.last = frame;
    }
  }

  /** Looks where the points are, and lets camera and origin follow. */
  look({ vertices }) {
    const box = this.bounds.take(vertices);
    if (!box) return;
    this.camera.take(box);
    const [left, bottom, right, top] = box;
    const unit = Math.max(right - left, top - bottom) || 1;
    const [x, y] = [(left + right) / 2, (bottom + top) / 2];
    const far = Math.max(Math.abs(x - this.origin.x), Math.abs(y - this.origin.y)) / unit;
    if (far < 4 && unit > this.origin.unit / 16 && unit < this.origin.unit * 16) return;
    this.origin = { x, y, unit };
    this.stale = true;
  }

  /** Writes what has changed. */
  upload({ vertices, edges }) {
    const { gl, places, links, origin } = this;
    gl.bindVertexArray(null);
    if (places.reserve((2 * vertices.hashes.length) / 2) || this.stale) vertices.changed.fill(1);
    places.bind();
    forRuns(vertices, (from, to) => {
      for (let slot = from; slot < to; slot++) {
        const isFree = vertices.rows[3 * slot] < 0;
        places.array[2 * slot] = isFree ? AWAY : (vertices.rows[3 * slot + 1] - origin.x) / origin.unit;
        places.array[2 * slot + 1] = isFree ? AWAY : (vertices.rows[3 * slot + 2] - origin.y) / origin.unit;
      }
      places.write(2 * from, 2 * to);
    });
    if (links.reserve((2 * edges.hashes.length) / 2) || this.stale) edges.changed.fill(1);
    links.bind();
    forRuns(edges, (from, to) => {
      for (let slot = from; slot < to; slot++) linkOf(vertices, edges, slot, links.array);
      links.write(2 * from, 2 * to);
    });
    this.stale = false;
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

  /** From places of the graphics card to its screen: factors, then what is added. */
  view() {
    const { camera, origin, canvas } = this;
    const [x, y] = [(2 * camera.scale) / (canvas.clientWidth || 1), (2 * camera.scale) / (canvas.clientHeight || 1)];
    return [origin.unit * x, origin.unit * y, (origin.x - camera.x) * x, (origin.y - camera.y) * y];
  }

  useFlat() {
    const { gl } = this;
    gl.useProgram(this.programs.flat.program);
    gl.uniform4fv(this.programs.flat.view, this.view());
    gl.uniform1i(this.programs.flat.isRound, 0);
  }

  color(color, alpha) {
    this.gl.uniform4f(this.programs.flat.color, ...color.rgb, alpha);
  }

  drawEdges({ edges }) {
    this.links.bind();
    this.color(palette.edge, 0.85);
    this.gl.drawElements(this.gl.LINES, 2 * edges.end, this.gl.UNSIGNED_INT, 0);
  }

  /** Points as large as there is room for. */
  drawPoints({ vertices }) {
    const { gl } = this;
    const room = this.bounds.room(vertices.count) * this.camera.scale;
    gl.uniform1f(this.programs.flat.size, this.ratio * pointSize(room));
    gl.uniform1i(this.programs.flat.isRound, 1);
    // Where points lie on each other, the crowd makes the shade.
    this.color(palette.point, room < 4 ? 0.55 : 0.9);
    gl.drawArrays(gl.POINTS, 0, vertices.end);
  }

  /** Fills each hole where an odd number of triangles from one corner of its walks lie: what is inside them. */
  drawHoles(mirror, beside, hit) {
    const { gl } = this;
    const ranges = this.layFans(mirror.vertices, holesOf(mirror, beside), beside.cycles);
    gl.enable(gl.STENCIL_TEST);
    for (const { track, from, count } of ranges) {
      gl.colorMask(false, false, false, false);
      gl.stencilFunc(gl.ALWAYS, 0, 1);
      gl.stencilOp(gl.KEEP, gl.KEEP, gl.INVERT);
      gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 4 * from);
      gl.colorMask(true, true, true, true);
      gl.stencilFunc(gl.NOTEQUAL, 0, 1);
      gl.stencilOp(gl.ZERO, gl.ZERO, gl.ZERO);
      this.color(colorOf(track.id), fillingOf(track, hit));
      gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 4 * from);
    }
    gl.disable(gl.STENCIL_TEST);
  }

  /** Lays out the triangles of all holes. */
  layFans(vertices, holes, cycles) {
    const length = holes.reduce(
      (sum, { id }) => sum + cycles.get(id).reduce((all, walk) => all + 3 * walk.length, 0),
      0,
    );
    this.fans.reserve(length);
    let at = 0;
    const ranges = holes.map((track) => {
      const from = at;
      for (const walk of cycles.get(track.id)) at = layFan(vertices, walk, this.fans.array, at);
      return { track, from, count: at - from };
    });
    this.fans.bind();
    this.fans.write(0, at);
    return ranges.filter(({ count }) => count > 0);
  }

  /** Strips in relief: walks around holes thin, critical edges above them thick. */
  drawStrips(mirror, beside, hit) {
    const { gl } = this;
    const count = this.strips.lay(mirror, beside, hit, {
      ...this.origin,
      places: this.places.array,
      ratio: this.ratio,
    });
    if (count === 0) return;
    gl.useProgram(this.programs.strip.program);
    gl.uniform4fv(this.programs.strip.view, this.view());
    gl.uniform2f(this.programs.strip.pixels, this.canvas.width / 2, this.canvas.height / 2);
    gl.uniform1i(this.programs.strip.strips, 0);
    gl.bindVertexArray(this.noArray);
    gl.drawArrays(gl.TRIANGLES, 0, 6 * count);
  }
}

/** Triangles from the first vertex of a walk to each of its edges. A vertex that is not there leaves the walk out. */
function layFan(vertices, walk, into, start) {
  let at = start;
  const first = vertices.find(walk[0] ?? -1);
  let before = first;
  for (let i = 1; i < walk.length; i++) {
    const slot = vertices.find(walk[i]);
    if (slot < 0 || first < 0) return start;
    into[at++] = first;
    into[at++] = before;
    into[at++] = slot;
    before = slot;
  }
  return at;
}
