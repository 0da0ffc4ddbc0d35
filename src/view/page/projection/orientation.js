//! How a cloud is turned: a rotation of three-dimensional places, by dragging and by keys.
//!
//! In: turns, in pixels of a drag; the centre to turn around.
//! Out: the coordinates of a place to the right, upwards and towards the viewer.
//! Invariants: the matrix is a rotation. The centre of a turn stays where it is, so nothing leaves the view by turning.
//! Must not know: points, cameras, events.

import { orthonormalize } from "./linear.js";

/** Radians that a drag of one pixel turns. */
const RADIANS_PER_PIXEL = 0.008;
/** The view of three coordinates: x to the right, y into the distance, z upwards, seen from the side and from above. */
const AZIMUTH = Math.PI / 6;
const ELEVATION = (25 * Math.PI) / 180;

const FRONT = [1, 0, 0, 0, 1, 0, 0, 0, 1];
const OBLIQUE = (() => {
  const [sine, cosine] = [Math.sin(AZIMUTH), Math.cos(AZIMUTH)];
  const [low, high] = [Math.cos(ELEVATION), Math.sin(ELEVATION)];
  return [cosine, sine, 0, -high * sine, high * cosine, low, low * sine, -low * cosine, high];
})();

export class Orientation {
  constructor() {
    this.reset(false);
  }

  /** Turns back to the beginning: an oblique view, or one along the third axis. */
  reset(isOblique) {
    /** Three rows: to the right, upwards, towards the viewer. */
    this.matrix = Float64Array.from(isOblique ? OBLIQUE : FRONT);
    this.shift = new Float64Array(3);
  }

  /** The component of a place along a row of the matrix. */
  component(row, place) {
    const { matrix, shift } = this;
    const at = 3 * row;
    return matrix[at] * place[0] + matrix[at + 1] * place[1] + matrix[at + 2] * place[2] + shift[row];
  }

  /** Turns around a centre, as a drag by so many pixels asks for: what is near follows the pointer. */
  turn(right, down, center) {
    const before = [0, 1, 2].map((row) => this.component(row, center));
    this.rotate(2, 0, right * RADIANS_PER_PIXEL);
    this.rotate(1, 2, down * RADIANS_PER_PIXEL);
    orthonormalize(this.matrix, 3, 3);
    for (let row = 0; row < 3; row++) this.shift[row] += before[row] - this.component(row, center);
  }

  /** Turns the direction of one row to that of another. */
  rotate(from, to, angle) {
    const [sine, cosine] = [Math.sin(angle), Math.cos(angle)];
    const { matrix } = this;
    for (let i = 0; i < 3; i++) {
      const [a, b] = [matrix[3 * from + i], matrix[3 * to + i]];
      matrix[3 * from + i] = cosine * a - sine * b;
      matrix[3 * to + i] = sine * a + cosine * b;
    }
  }
}
