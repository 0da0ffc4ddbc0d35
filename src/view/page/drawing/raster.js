//! A raster image that the processor draws: dots and thin lines, as many as a graphics card would draw.
//!
//! In: positions in pixels, packed colours.
//! Out: one packed colour for each pixel, row by row.
//! Invariants: nothing is allocated for a dot or a line. A dot or line outside of the image costs a comparison only.
//! Must not know: skeletons, cameras.

const bytes = new Uint8ClampedArray(4);
const words = new Uint32Array(bytes.buffer);

/** A colour and an opacity, packed as a word of the image. @param {[number, number, number]} rgb */
export function packColor([red, green, blue], alpha) {
  bytes[0] = 255 * red;
  bytes[1] = 255 * green;
  bytes[2] = 255 * blue;
  bytes[3] = 255 * alpha;
  return words[0];
}

export class Raster {
  constructor() {
    this.width = this.height = 0;
    this.words = new Uint32Array(0);
    this.setStamp([0, 0]);
  }

  /** Resizes and clears the image. True if `words` is a new array. */
  reset(width, height) {
    const isOther = this.width !== width || this.height !== height;
    if (isOther) [this.width, this.height, this.words] = [width, height, new Uint32Array(width * height)];
    else this.words.fill(0);
    return isOther;
  }

  /** Sets the diameter of dots. */
  setDotSize(size) {
    const reach = Math.ceil(size / 2);
    const offsets = [];
    for (let y = -reach; y <= reach; y++) {
      for (let x = -reach; x <= reach; x++) if (Math.hypot(x, y) <= size / 2) offsets.push(x, y);
    }
    this.setStamp(size < 2 ? [0, 0] : offsets);
  }

  /** Sets the pixels of a dot: offsets to the right and downwards, in turn. */
  setStamp(offsets) {
    this.offsets = Int32Array.from(offsets);
    this.reach = Math.max(...offsets);
  }

  /** Draws a dot. */
  dot(x, y, word) {
    const { offsets, reach, width, height, words: pixels } = this;
    if (!(x >= reach && y >= reach && x < width - reach && y < height - reach)) return this.clippedDot(x, y, word);
    const at = (y | 0) * width + (x | 0);
    if (reach === 0) pixels[at] = word;
    else for (let i = 0; i < offsets.length; i += 2) pixels[at + offsets[i + 1] * width + offsets[i]] = word;
  }

  /** Draws a dot that may be partly outside. */
  clippedDot(left, top, word) {
    const { offsets, reach, width, height, words: pixels } = this;
    if (!(left > -reach - 1 && top > -reach - 1 && left < width + reach && top < height + reach)) return;
    for (let i = 0; i < offsets.length; i += 2) {
      const [x, y] = [Math.floor(left) + offsets[i], Math.floor(top) + offsets[i + 1]];
      if (x >= 0 && y >= 0 && x < width && y < height) pixels[y * width + x] = word;
    }
  }

  /** Draws a line of one pixel's width. */
  line(ax, ay, bx, by, word) {
    const { width, height } = this;
    const isIn = ax >= 0 && bx >= 0 && ay >= 0 && by >= 0 && ax < width && bx < width && ay < height && by < height;
    if (isIn) this.insideLine(ax, ay, bx, by, word);
    else this.clippedLine(ax, ay, bx, by, word);
  }

  /** Draws the part of a line that is inside. */
  clippedLine(ax, ay, bx, by, word) {
    const [right, bottom] = [this.width - 1e-3, this.height - 1e-3];
    let [from, to] = [0, 1];
    for (const [start, along, most] of [
      [ax, bx - ax, right],
      [ay, by - ay, bottom],
    ]) {
      if (along === 0 && !(start >= 0 && start <= most)) return;
      if (along === 0) continue;
      const [first, last] = [-start / along, (most - start) / along];
      from = Math.max(from, Math.min(first, last));
      to = Math.min(to, Math.max(first, last));
    }
    // This also holds where a coordinate is NaN.
    if (!(from < to)) return;
    const [x, y] = [bx - ax, by - ay];
    const clamped = (value, most) => Math.min(most, Math.max(0, value));
    this.insideLine(
      clamped(ax + from * x, right),
      clamped(ay + from * y, bottom),
      clamped(ax + to * x, right),
      clamped(ay + to * y, bottom),
      word,
    );
  }

  /** Draws a line both of whose ends are inside. */
  insideLine(ax, ay, bx, by, word) {
    const { width, words: pixels } = this;
    const steps = Math.ceil(Math.max(Math.abs(bx - ax), Math.abs(by - ay))) || 1;
    const [right, down] = [(bx - ax) / steps, (by - ay) / steps];
    for (let i = 0, x = ax, y = ay; i <= steps; i++, x += right, y += down) pixels[(y | 0) * width + (x | 0)] = word;
  }
}
