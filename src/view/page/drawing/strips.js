//! Thick lines of the plane as strips: outlines of holes, critical edges above them, the simplified skeleton above all.
//!
//! In: a picture, the picked cycle, the renderer's origin and positions.
//! Out: a texture of strips.
//! Invariants: a track's strips have its colour. The order of strips is the order in which they are drawn.
//! Must not know: cameras.

import { fadeBetween } from "../projection/vertices.js";
import { palette } from "./colors.js";
import { CORNERS, SIMPLIFIED_WIDTH, forCriticalEdges, outlinesOf } from "./styles.js";
import { STRIP, StripTexture } from "./webgl.js";

export class Strips {
  /** @param {WebGL2RenderingContext} gl @param {import("./picking.js").TracksByLabel} tracksByLabel */
  constructor(gl, tracksByLabel) {
    this.tracksByLabel = tracksByLabel;
    this.texture = new StripTexture(gl);
    this.count = 0;
  }

  /**
   * Writes all strips to the texture. Returns how many there are.
   *
   * `space` is the renderer's origin and unit, the positions of vertices in it, and the pixels of a CSS pixel.
   * @param {{x: number, y: number, unit: number, positions: Float32Array, ratio: number}} space
   */
  build({ mirror, simplified, annotations }, pick, space) {
    this.space = space;
    const { vertices, critical } = mirror;
    const outlines = outlinesOf(annotations, this.tracksByLabel, pick);
    const lines = outlines.reduce((sum, { length }) => sum + length, critical.count);
    this.texture.reserve(lines + simplified.edges.count);
    this.count = 0;
    for (const { circle, walk, color, alpha, width } of outlines) {
      if (circle) this.addCircle(circle, color.rgb, alpha, width);
      for (let i = 0; walk && i < walk.length; i++) {
        this.addLine(vertices, walk[i], walk[(i + 1) % walk.length], color.rgb, alpha, width);
      }
    }
    forCriticalEdges(critical, this.tracksByLabel, pick, (a, b, { rgb }, alpha, width) =>
      this.addLine(vertices, a, b, rgb, alpha, width),
    );
    if (annotations.simplified !== null) this.addSimplified(simplified);
    this.texture.write(this.count);
    return this.count;
  }

  /** A place of the plane as the renderer has it. */
  place(x, y) {
    const { space } = this;
    return [(x - space.x) / space.unit, (y - space.y) / space.unit];
  }

  /** Adds the inscribed circle of a hole. */
  addCircle({ x, y, radius }, rgb, alpha, width) {
    const turn = (2 * Math.PI) / CORNERS;
    const at = (angle) => this.place(x + radius * Math.cos(angle), y + radius * Math.sin(angle));
    for (let i = 0; i < CORNERS; i++) this.addStrip(...at(i * turn), ...at((i + 1) * turn), rgb, alpha, width);
  }

  /** Adds the edges of the simplified skeleton, whose vertices are its own. */
  addSimplified({ vertices, edges }) {
    const { rgb } = palette.ink;
    for (let at = 0; at < 2 * edges.end; at += 2) {
      if (edges.rows[at] < 0) continue;
      const ends = [edges.rows[at], edges.rows[at + 1]].map((id) => 3 * vertices.find(id));
      const [from, to] = ends.map((row) => this.place(vertices.rows[row + 1], vertices.rows[row + 2]));
      this.addStrip(...from, ...to, rgb, 1, SIMPLIFIED_WIDTH);
    }
  }

  /** Adds a line between two vertices. */
  addLine(vertices, a, b, rgb, alpha, width) {
    const [from, to] = [vertices.find(a), vertices.find(b)];
    if (from < 0 || to < 0) return;
    const { positions } = this.space;
    const [ax, ay] = [positions[2 * from], positions[2 * from + 1]];
    const opacity = alpha * fadeBetween(vertices, from, to);
    this.addStrip(ax, ay, positions[2 * to], positions[2 * to + 1], rgb, opacity, width);
  }

  addStrip(ax, ay, bx, by, rgb, alpha, width) {
    if (this.count === this.texture.capacity) return;
    const into = this.texture.array;
    let at = STRIP * this.count++;
    into[at++] = ax;
    into[at++] = ay;
    into[at++] = bx;
    into[at++] = by;
    into[at++] = (Math.round(255 * rgb[0]) << 16) | (Math.round(255 * rgb[1]) << 8) | Math.round(255 * rgb[2]);
    into[at++] = alpha;
    into[at] = width * this.space.ratio;
  }
}
