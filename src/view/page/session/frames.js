//! Frames of the protocol: banner, header, CRC-32C, and a buffer for bytes that come in pieces.
//!
//! In: pieces of a byte stream; bodies to send.
//! Out: complete frames whose CRCs were verified; bytes to send.
//! Invariants: nothing is allocated for an announced length, and none above the cap is accepted. The buffer holds at
//! most one frame and one piece.
//! Must not know: what bodies mean.

/** @typedef {"malformed" | "unsupported version" | "too large"} FrameFault */

/** The byte stream cannot be read any further. */
export class FrameError extends Error {
  /** @param {FrameFault} fault @param {string} message */
  constructor(fault, message) {
    super(message);
    this.fault = fault;
  }
}

/** @typedef {{version: number, type: number, channel: number, body: Uint8Array, end: number}} Frame */

const HEADER = 20;
export const BANNER = 20;
/** Bytes of a body at the most. */
const CAP = 1 << 28;
const BANNER_MAGIC = [0x48, 0x4f, 0x50, 0x45, 0x53, 0x0d, 0x0a, 0x1a];
/** `hopF`, little-endian. */
const FRAME_MAGIC = 0x46706f68;

/** Four tables of 256 entries: the CRC of a byte followed by 0, 1, 2 or 3 zero bytes. */
const TABLES = (() => {
  const tables = new Int32Array(1024);
  for (let byte = 0; byte < 256; byte++) {
    let crc = byte;
    for (let bit = 0; bit < 8; bit++) crc = crc & 1 ? (crc >>> 1) ^ 0x82f63b78 : crc >>> 1;
    tables[byte] = crc;
  }
  for (let i = 256; i < 1024; i++) tables[i] = (tables[i - 256] >>> 8) ^ tables[tables[i - 256] & 255];
  return tables;
})();

/** The CRC-32C of some bytes. @param {Uint8Array} bytes */
export function crc32c(bytes, from = 0, to = bytes.length) {
  let crc = -1;
  let at = from;
  for (; at + 4 <= to; at += 4) {
    crc ^= bytes[at] | (bytes[at + 1] << 8) | (bytes[at + 2] << 16) | (bytes[at + 3] << 24);
    crc =
      TABLES[768 + (crc & 255)] ^
      TABLES[512 + ((crc >>> 8) & 255)] ^
      TABLES[256 + ((crc >>> 16) & 255)] ^
      TABLES[crc >>> 24];
  }
  for (; at < to; at++) crc = (crc >>> 8) ^ TABLES[(crc ^ bytes[at]) & 255];
  return ~crc >>> 0;
}

/** @param {Uint8Array} bytes */
const viewOf = (bytes) => new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);

/** A banner that announces these versions. */
export function writeBanner(lowest, highest) {
  const bytes = new Uint8Array(BANNER);
  const view = viewOf(bytes);
  bytes.set(BANNER_MAGIC);
  view.setUint16(8, lowest, true);
  view.setUint16(10, highest, true);
  view.setUint32(16, crc32c(bytes, 0, 16), true);
  return bytes;
}

/** The versions that a banner announces. @param {Uint8Array} bytes */
export function readBanner(bytes) {
  const view = viewOf(bytes);
  if (view.getUint32(16, true) !== crc32c(bytes, 0, 16) || BANNER_MAGIC.some((byte, i) => byte !== bytes[i])) {
    throw new FrameError("malformed", "this is no hopes daemon: its banner is invalid");
  }
  return { lowest: view.getUint16(8, true), highest: view.getUint16(10, true) };
}

/** A whole frame. @param {Uint8Array | number[]} body */
export function writeFrame(version, type, channel, body) {
  const bytes = new Uint8Array(HEADER + body.length + 4);
  const view = viewOf(bytes);
  view.setUint32(0, FRAME_MAGIC, true);
  view.setUint16(4, version, true);
  view.setUint16(6, type, true);
  view.setUint32(8, channel, true);
  view.setUint32(12, body.length, true);
  view.setUint32(16, crc32c(bytes, 0, 16), true);
  bytes.set(body, HEADER);
  view.setUint32(HEADER + body.length, crc32c(bytes, HEADER, HEADER + body.length), true);
  return bytes;
}

/**
 * The frame at the beginning of some bytes; null if bytes of it are missing.
 * @param {Uint8Array} bytes
 * @param {(version: number) => boolean} accepts
 * @returns {Frame | null}
 */
export function readFrame(bytes, accepts, cap = CAP) {
  if (bytes.length < HEADER) return null;
  const view = viewOf(bytes);
  const length = checkHeader(bytes, view, accepts, cap);
  const end = HEADER + length + 4;
  if (bytes.length < end) return null;
  if (view.getUint32(end - 4, true) !== crc32c(bytes, HEADER, end - 4)) {
    throw new FrameError("malformed", "the CRC of a body is wrong");
  }
  return {
    version: view.getUint16(4, true),
    type: view.getUint16(6, true),
    channel: view.getUint32(8, true),
    body: bytes.subarray(HEADER, end - 4),
    end,
  };
}

/** Checks a header. Returns the length of its body. */
function checkHeader(bytes, view, accepts, cap) {
  if (view.getUint32(16, true) !== crc32c(bytes, 0, 16))
    throw new FrameError("malformed", "the CRC of a header is wrong");
  if (view.getUint32(0, true) !== FRAME_MAGIC) throw new FrameError("malformed", "the magic of a frame is wrong");
  const version = view.getUint16(4, true);
  if (!accepts(version)) throw new FrameError("unsupported version", `a frame has version ${version}`);
  const length = view.getUint32(12, true);
  if (length > cap) throw new FrameError("too large", `a body of ${length} bytes is above the cap of ${cap}`);
  return length;
}

/** Received bytes that are not read yet. */
export class ReceiveBuffer {
  constructor() {
    this.bytes = new Uint8Array(0);
    this.from = 0;
    this.to = 0;
  }

  /** The bytes held. */
  get rest() {
    return this.bytes.subarray(this.from, this.to);
  }

  /** Appends a piece. It is copied only if part of a frame is held. @param {Uint8Array} piece */
  push(piece) {
    if (this.from === this.to) {
      this.bytes = piece;
      this.from = 0;
      this.to = piece.length;
      return;
    }
    const held = this.to - this.from;
    if (this.to + piece.length > this.bytes.length) {
      const grown = new Uint8Array(2 * (held + piece.length));
      grown.set(this.rest);
      this.bytes = grown;
      this.from = 0;
      this.to = held;
    }
    this.bytes.set(piece, this.to);
    this.to += piece.length;
  }

  /** Drops the first bytes. */
  skip(count) {
    this.from += count;
  }

  /** The next complete frame, or null. Its body is valid until the next `push`. @returns {Frame | null} */
  next(accepts) {
    const frame = readFrame(this.rest, accepts);
    if (frame) this.from += frame.end;
    return frame;
  }
}
