//! Pixels drawn by the processor: dots and thin lines, as many as a graphics card would be given.
//!
//! In: places in pixels, words of colour. Out: rows of words, one for each pixel. Invariants: nothing is allocated for a dot or a line; what
//! lies outside costs no more than a look. Must not know: skeletons, cameras.

const bytes = new Uint8ClampedArray(4);
const words = new Uint32Array(bytes.buffer);

/** A colour as a word of the image's. @param {[number, number, number]} rgb */
export function wordOf([red, green, blue], alpha) {
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
    this.stamp([0, 0]);
  }

  /** Takes this size, and is empty. True if the words are others from here on. */
  begin(width, height) {
    const isOther = this.width !== width || this.height !== height;
    if (isOther) [this.width, this.height, this.words] = [width, height, new Uint32Array(width * height)];
    else this.words.fill(0);
    return isOther;
  }

  /** Dots are of this size from now on. */
  size(size) {
    const reach = Math.ceil(size / 2);
    const offsets = [];
    for (let y = -reach; y <= reach; y++) {
      for (let x = -reach; x <= reach; x++) if (Math.hypot(x, y) <= size / 2) offsets.push(x, y);
    }
    this.stamp(size < 2 ? [0, 0] : offsets);
  }

  /** What a dot is: pixels to the right and below, in turn. */
  stamp(offsets) {
    this.offsets = Int32Array.from(offsets);
    this.reach = Math.max(...offsets);
  }

  /** A dot of the size that was set. */
  dot(x, y, word) {
    const { offsets, reach, width, height, words: pixels } = this;
    if (!(x >= reach && y >= reach && x < width - reach && y < height - reach)) return this.edgeDot(x, y, word);
    const at = (y | 0) * width + (x | 0);
    if (reach === 0) pixels[at] = word;
    else for (let i = 0; i < offsets.length; i += 2) pixels[at + offsets[i + 1] * width + offsets[i]] = word;
  }

  /** A dot of which part may be outside. */
  edgeDot(left, top, word) {
    const { offsets, reach, width, height, words: pixels } = this;
    if (!(left > -reach - 1 && top > -reach - 1 && left < width + reach && top < height + reach)) return;
    for (let i = 0; i < offsets.length; i += 2) {
      const [x, y] = [Math.floor(left) + offsets[i], Math.floor(top) + offsets[i + 1]];
      if (x >= 0 && y >= 0 && x < width && y < height) pixels[y * width + x] = word;
    }
  }

  /** A line of one pixel's width. */
  line(ax, ay, bx, by, word) {
    const { width, height } = this;
    const isIn = ax >= 0 && bx >= 0 && ay >= 0 && by >= 0 && ax < width && bx < width && ay < height && by < height;
    if (isIn) this.walk(ax, ay, bx, by, word);
    else this.cutLine(ax, ay, bx, by, word);
  }

  /** The part of a line that is inside. */
  cutLine(ax, ay, bx, by, word) {
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
    // Also where a place is no number.
    if (!(from < to)) return;
    const [x, y] = [bx - ax, by - ay];
    const inside = (value, most) => Math.min(most, Math.max(0, value));
    this.walk(
      inside(ax + from * x, right),
      inside(ay + from * y, bottom),
      inside(ax + to * x, right),
      inside(ay + to * y, bottom),
      word,
    );
  }

  /** Pixel by pixel from one place to another, both inside. */
  walk(ax, ay, bx, by, word) {
    const { width, words: pixels } = this;
    const steps = Math.ceil(Math.max(Math.abs(bx - ax), Math.abs(by - ay))) || 1;
    const [right, down] = [(bx - ax) / steps, (by - ay) / steps];
    for (let i = 0, x = ax, y = ay; i <= steps; i++, x += right, y += down) pixels[(y | 0) * width + (x | 0)] = word;
  }
}
