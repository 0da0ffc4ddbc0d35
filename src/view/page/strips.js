//! What stands out in the plane: outlines of holes, and critical edges above them, as strips of some width.
//!
//! In: a mirror and what lives beside it, what is meant, where the plane's places are counted from. Out: a texture of
//! strips. Invariants: a track's strips have its colour; strips lie in the order in which they are drawn. Must not
//! know: cameras.

import { STRIP, StripTexture } from "./gl.js";
import { CORNERS, forCritical, outlinesOf } from "./looks.js";

export class Strips {
  /** @param {WebGL2RenderingContext} gl @param {import("./cycles.js").Labels} labels */
  constructor(gl, labels) {
    this.labels = labels;
    this.texture = new StripTexture(gl);
    this.laid = 0;
  }

  /**
   * Lays out all strips, and tells how many there are.
   * @param {{x: number, y: number, unit: number, places: Float32Array, ratio: number}} ground
   */
  lay(mirror, beside, hit, ground) {
    this.ground = ground;
    const { vertices, critical } = mirror;
    const outlines = outlinesOf(mirror, beside, hit);
    this.texture.reserve(critical.count + outlines.reduce((sum, { length }) => sum + length, 0));
    this.laid = 0;
    for (const { track, walk, color, alpha, width } of outlines) {
      if (!walk) this.layCircle(track, color.rgb, alpha, width);
      for (let i = 0; walk && i < walk.length; i++) {
        this.layStrip(vertices, walk[i], walk[(i + 1) % walk.length], color.rgb, alpha, width);
      }
    }
    forCritical(critical, this.labels, hit, (a, b, { rgb }, alpha, width) =>
      this.layStrip(vertices, a, b, rgb, alpha, width),
    );
    this.texture.write(this.laid);
    return this.laid;
  }

  /** A hole whose walks are not known, as the circle inside it. */
  layCircle({ center, radius }, rgb, alpha, width) {
    const { ground } = this;
    const [x, y] = [(center[0] - ground.x) / ground.unit, (center[1] - ground.y) / ground.unit];
    const r = radius / ground.unit;
    const turn = (2 * Math.PI) / CORNERS;
    for (let i = 0; i < CORNERS; i++) {
      const at = (angle) => [x + r * Math.cos(angle), y + r * Math.sin(angle)];
      this.putStrip(...at(i * turn), ...at((i + 1) * turn), rgb, alpha, width);
    }
  }

  layStrip(vertices, a, b, rgb, alpha, width) {
    const [from, to] = [vertices.find(a), vertices.find(b)];
    if (from < 0 || to < 0) return;
    const { places: array } = this.ground;
    this.putStrip(array[2 * from], array[2 * from + 1], array[2 * to], array[2 * to + 1], rgb, alpha, width);
  }

  putStrip(ax, ay, bx, by, rgb, alpha, width) {
    if (this.laid === this.texture.most) return;
    const into = this.texture.array;
    let at = STRIP * this.laid++;
    into[at++] = ax;
    into[at++] = ay;
    into[at++] = bx;
    into[at++] = by;
    into[at++] = (Math.round(255 * rgb[0]) << 16) | (Math.round(255 * rgb[1]) << 8) | Math.round(255 * rgb[2]);
    into[at++] = alpha;
    into[at] = width * this.ground.ratio;
  }
}
