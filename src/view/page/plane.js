//! The plane: points, tree edges, critical edges and filled holes, drawn by WebGL2.
//!
//! In: a mirror and what lives beside it, a camera, what is meant. Out: pixels. Invariants: only blocks that have
//! changed are written to the graphics card; coordinates there are taken from an origin nearby, so that their 24 bits
//! suffice; a lost context is built anew. Must not know: sockets, messages.

import { colorOf, palette } from "./colors.js";
import { isMeant } from "./cycles.js";
import { BLOCK_BITS } from "./elements.js";
import { Buffer, programs } from "./gl.js";
import { Strips } from "./strips.js";

const BLOCK = 1 << BLOCK_BITS;
/** Out of every view, for slots that are free. */
const AWAY = 1e30;
/** Holes that are filled, at most; each takes two calls. */
const MOST_HOLES = 1500;
const BOUNDS_EVERY = 200;

export class Plane {
  /** @param {HTMLCanvasElement} canvas @param {import("./camera.js").Camera} camera */
  constructor(canvas, camera, labels) {
    this.canvas = canvas;
    this.camera = camera;
    this.labels = labels;
    this.origin = { x: 0, y: 0, unit: 1 };
    this.bounds = null;
    this.boundsAt = 0;
    this.gl = contextOf(canvas);
    if (!this.gl) return;
    this.isSlow = !this.gl.getContextAttributes().antialias;
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
    if (!gl || gl.isContextLost()) return;
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
  }

  /** Looks where the points are, now and then, and lets camera and origin follow. */
  look({ vertices }) {
    const now = performance.now();
    if (this.bounds && (vertices.version === this.boundsOf || now - this.boundsAt < BOUNDS_EVERY)) {
      return this.camera.take(this.bounds);
    }
    if (vertices.count === 0) return;
    [this.boundsAt, this.boundsOf] = [now, vertices.version];
    this.bounds = boundsOf(vertices);
    this.camera.take(this.bounds);
    const [left, bottom, right, top] = this.bounds;
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
    const ratio = this.isSlow ? 1 : Math.min(devicePixelRatio || 1, 2);
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
    const [left, bottom, right, top] = this.bounds ?? [0, 0, 1, 1];
    const room = Math.sqrt(((right - left) * (top - bottom)) / Math.max(1, vertices.count)) * this.camera.scale;
    gl.uniform1f(this.programs.flat.size, this.ratio * Math.min(4.5, Math.max(1.25, 0.35 * room)));
    gl.uniform1i(this.programs.flat.isRound, 1);
    // Where points lie on each other, the crowd makes the shade.
    this.color(palette.point, room < 4 ? 0.55 : 0.9);
    gl.drawArrays(gl.POINTS, 0, vertices.end);
  }

  /** Fills each hole where an odd number of triangles from one corner of its walks lie: what is inside them. */
  drawHoles({ vertices, frame }, { alive, cycles }, hit) {
    const { gl } = this;
    if (!frame || frame.view.simplify !== "No") return;
    const ranges = this.layFans(vertices, alive, cycles);
    gl.enable(gl.STENCIL_TEST);
    for (const { track, from, count } of ranges) {
      gl.colorMask(false, false, false, false);
      gl.stencilFunc(gl.ALWAYS, 0, 1);
      gl.stencilOp(gl.KEEP, gl.KEEP, gl.INVERT);
      gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 4 * from);
      gl.colorMask(true, true, true, true);
      gl.stencilFunc(gl.NOTEQUAL, 0, 1);
      gl.stencilOp(gl.ZERO, gl.ZERO, gl.ZERO);
      this.color(colorOf(track.id), isMeant(hit, track.id) ? 0.5 : track.selected ? 0.26 : 0.1);
      gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 4 * from);
    }
    gl.disable(gl.STENCIL_TEST);
  }

  /** Lays out the triangles of all holes, the largest hole first. */
  layFans(vertices, alive, cycles) {
    const holes = alive
      .filter((track) => cycles.get(track.id)?.length)
      .sort((a, b) => b.area - a.area)
      .slice(0, MOST_HOLES);
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

/** A context with smooth edges; without, where there is no graphics card and every pixel costs. */
function contextOf(canvas) {
  return canvas.getContext("webgl2", { stencil: true, antialias: !isSoftware(), powerPreference: "high-performance" });
}

/** Whether WebGL is drawn by the processor. A context cannot be changed afterwards, so another one is asked. */
function isSoftware() {
  const probe = document.createElement("canvas").getContext("webgl2");
  if (!probe) return true;
  const info = probe.getExtension("WEBGL_debug_renderer_info");
  const name = String(probe.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : probe.RENDERER));
  probe.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

/** Calls for each run of blocks that have changed, and notes that they are dealt with. */
function forRuns({ changed, end }, write) {
  for (let block = 0; block * BLOCK < end; block++) {
    if (!changed[block]) continue;
    const from = block;
    while (block * BLOCK < end && changed[block]) changed[block++] = 0;
    write(from * BLOCK, Math.min(block * BLOCK, end));
  }
}

/** The slots of an edge's ends; of an edge that is gone, one slot twice. */
function linkOf(vertices, edges, slot, into) {
  const a = edges.rows[2 * slot];
  const [from, to] = a < 0 ? [-1, -1] : [vertices.find(a), vertices.find(edges.rows[2 * slot + 1])];
  const isThere = from >= 0 && to >= 0;
  into[2 * slot] = isThere ? from : 0;
  into[2 * slot + 1] = isThere ? to : 0;
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

/** @param {import("./elements.js").Elements} vertices */
function boundsOf({ rows, end }) {
  let [left, bottom, right, top] = [Infinity, Infinity, -Infinity, -Infinity];
  for (let at = 0; at < 3 * end; at += 3) {
    if (rows[at] < 0) continue;
    const [x, y] = [rows[at + 1], rows[at + 2]];
    if (x < left) left = x;
    if (x > right) right = x;
    if (y < bottom) bottom = y;
    if (y > top) top = y;
  }
  return [left, bottom, right, top];
}
