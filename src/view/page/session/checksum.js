//! The hash of one row; the sum of such hashes is the checksum of a skeleton.
//!
//! In: rows of ids and numbers.
//! Out: 64 bits as two words of 32 bits.
//! Invariants: the hash is the one of `protocol/SPEC.md`, section 7. Nothing is allocated.
//! Must not know: skeletons, messages.

/**
 * The last result: [high, low]. It is shared, since nothing runs concurrently and a new pair for each result would have
 * to be collected.
 */
export const hash = new Int32Array(2);

const number = new Float64Array(1);
const words = new Int32Array(number.buffer);

/** The high word of the product of two words. */
function highOfProduct(a, b) {
  const aLow = a & 0xffff;
  const aHigh = a >>> 16;
  const bLow = b & 0xffff;
  const bHigh = b >>> 16;
  // Each sum is below 2^32, so a word holds it as long as it is shifted without a sign.
  const middle = (aHigh * bLow + (Math.imul(aLow, bLow) >>> 16)) >>> 0;
  const other = (aLow * bHigh + (middle & 0xffff)) >>> 0;
  return (Math.imul(aHigh, bHigh) + (middle >>> 16) + (other >>> 16)) | 0;
}

/** Mixes a word of 64 bits into the hash. */
function mix(wordHigh, wordLow) {
  let low = hash[1] ^ wordLow;
  let high = hash[0] ^ wordHigh;
  const sum = (low >>> 0) + 0x7f4a7c15;
  high = (high + 0x9e3779b9 + (sum > 0xffffffff ? 1 : 0)) | 0;
  low = sum | 0;

  low ^= (low >>> 30) | (high << 2);
  high ^= high >>> 30;
  let product = Math.imul(low, 0x1ce4e5b9);
  high = (highOfProduct(low, 0x1ce4e5b9) + Math.imul(high, 0x1ce4e5b9) + Math.imul(low, 0xbf58476d)) | 0;
  low = product;

  low ^= (low >>> 27) | (high << 5);
  high ^= high >>> 27;
  product = Math.imul(low, 0x133111eb);
  high = (highOfProduct(low, 0x133111eb) + Math.imul(high, 0x133111eb) + Math.imul(low, 0x94d049bb)) | 0;
  low = product;

  hash[1] = low ^ ((low >>> 31) | (high << 1));
  hash[0] = high ^ (high >>> 31);
}

/**
 * Hashes one row: a tag for its kind, then ids as integers, then the bits of its numbers. The result is in `hash`.
 * @param {Float64Array} rows
 */
export function hashRow(kind, rows, at, ids, width) {
  hash[0] = 0;
  hash[1] = 0;
  mix(0, kind);
  for (let i = 0; i < ids; i++) {
    const id = rows[at + i];
    mix(Math.floor(id / 0x100000000) | 0, (id % 0x100000000) | 0);
  }
  for (let i = ids; i < width; i++) {
    number[0] = rows[at + i];
    mix(words[1], words[0]);
  }
}
