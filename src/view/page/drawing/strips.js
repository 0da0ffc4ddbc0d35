//! Thick lines of the plane as strips: outlines of holes, and critical edges above them.
//!
//! In: a mirror and its annotations, the picked cycle, the renderer's origin and positions.
//! Out: a texture of strips.
//! Invariants: a track's strips have its colour. The order of strips is the order in which they are drawn.
//! Must not know: cameras.

import { CORNERS, forCriticalEdges, outlinesOf } from "./styles.js";
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
  build(mirror, annotations, pick, space) {
    this.space = space;
    const { vertices, critical } = mirror;
    const outlines = outlinesOf(mirror, annotations, pick);
    this.texture.reserve(critical.count + outlines.reduce((sum, { length }) => sum + length, 0));
    this.count = 0;
    for (const { track, walk, color, alpha, width } of outlines) {
      if (!walk) this.addCircle(track, color.rgb, alpha, width);
      for (let i = 0; walk && i < walk.length; i++) {
        this.addLine(vertices, walk[i], walk[(i + 1) % walk.length], color.rgb, alpha, width);
      }
    }
    forCriticalEdges(critical, this.tracksByLabel, pick, (a, b, { rgb }, alpha, width) =>
      this.addLine(vertices, a, b, rgb, alpha, width),
    );
    this.texture.write(this.count);
    return this.count;
  }

  /** Adds the inscribed circle of a hole whose walks are not known. */
  addCircle({ center, radius }, rgb, alpha, width) {
    const { space } = this;
    const [x, y] = [(center[0] - space.x) / space.unit, (center[1] - space.y) / space.unit];
    const r = radius / space.unit;
    const turn = (2 * Math.PI) / CORNERS;
    for (let i = 0; i < CORNERS; i++) {
      const at = (angle) => [x + r * Math.cos(angle), y + r * Math.sin(angle)];
      this.addStrip(...at(i * turn), ...at((i + 1) * turn), rgb, alpha, width);
    }
  }

  /** Adds a line between two vertices. */
  addLine(vertices, a, b, rgb, alpha, width) {
    const [from, to] = [vertices.find(a), vertices.find(b)];
    if (from < 0 || to < 0) return;
    const { positions } = this.space;
    const [ax, ay] = [positions[2 * from], positions[2 * from + 1]];
    this.addStrip(ax, ay, positions[2 * to], positions[2 * to + 1], rgb, alpha, width);
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
