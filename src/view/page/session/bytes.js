//! Encoding of fields: values to bytes and back, in bincode 2's standard configuration.
//!
//! In: bytes, or values.
//! Out: types, each with `read`, `write` and the fewest bytes that a value takes.
//! Invariants: nothing is allocated for a list or a text before its bytes are known to be there. Reading throws nothing
//! but `BodyError`. An integer is a Number where that is exact, else a BigInt.
//! Must not know: messages, sockets.

/** A body does not fit its type. */
export class BodyError extends Error {}

const utf8 = new TextDecoder("utf-8", { fatal: true, ignoreBOM: true });
const toUtf8 = new TextEncoder();

/** Reads fields from bytes, from the first to the last. */
export class Reader {
  /** @param {Uint8Array} bytes */
  constructor(bytes) {
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    this.at = 0;
  }

  /** The number of bytes left. */
  get left() {
    return this.bytes.length - this.at;
  }

  /** Skips so many bytes. Returns where they begin. */
  take(count) {
    if (count > this.left) throw new BodyError(`${count} bytes are needed at ${this.at}, and ${this.left} are left`);
    this.at += count;
    return this.at - count;
  }

  byte() {
    return this.bytes[this.take(1)];
  }

  /** An integer of at most so many bytes: a Number, or a BigInt where a Number would not be exact. */
  unsigned(size) {
    const tag = this.byte();
    if (tag < 251) return tag;
    const wide = 1 << (tag - 250);
    if (tag > 253 || wide > size) throw new BodyError(`${tag} is no tag of an integer of ${8 * size} bits`);
    const at = this.take(wide);
    if (wide === 2) return this.view.getUint16(at, true);
    if (wide === 4) return this.view.getUint32(at, true);
    const high = this.view.getUint32(at + 4, true);
    if (high < 0x200000) return high * 0x100000000 + this.view.getUint32(at, true);
    return this.view.getBigUint64(at, true);
  }

  /** An id, as a Number. Ids count from 0 or 1, so no daemon runs long enough to need more than 53 bits. */
  id() {
    const id = this.unsigned(8);
    if (typeof id === "bigint") throw new BodyError(`id ${id} is above 2^53 - 1, more than this page can hold`);
    return id;
  }

  f64() {
    const value = this.scale();
    if (value === Infinity) throw new BodyError(`${value} is not finite`);
    return value;
  }

  /** A number that may be +infinity, as the death of a cycle that is never filled. */
  scale() {
    const value = this.view.getFloat64(this.take(8), true);
    if (!(value > -Infinity)) throw new BodyError(`${value} is not finite`);
    return value;
  }

  bool() {
    const byte = this.byte();
    if (byte > 1) throw new BodyError(`${byte} is neither 0 nor 1`);
    return byte === 1;
  }

  /** The number of elements that follow, checked against the bytes left. */
  count(smallest) {
    const count = this.unsigned(8);
    if (typeof count === "bigint" || count * smallest > this.left) {
      throw new BodyError(`${count} elements do not fit into the ${this.left} bytes that are left`);
    }
    return count;
  }

  text() {
    const length = this.count(1);
    const at = this.take(length);
    try {
      return utf8.decode(this.bytes.subarray(at, at + length));
    } catch {
      throw new BodyError(`the text at ${at} is not UTF-8`);
    }
  }
}

/** Appends fields to bytes. A plain array suffices, since messages of a consumer are short. */
export class Writer {
  constructor() {
    /** @type {number[]} */
    this.bytes = [];
  }

  unsigned(value) {
    let rest = BigInt(value);
    if (rest < 251n) return void this.bytes.push(Number(rest));
    const size = rest < 1n << 16n ? 2 : rest < 1n << 32n ? 4 : 8;
    this.bytes.push(size === 2 ? 251 : size === 4 ? 252 : 253);
    for (let i = 0; i < size; i++, rest >>= 8n) this.bytes.push(Number(rest & 255n));
  }

  f64(value) {
    this.bytes.push(...new Uint8Array(Float64Array.of(value).buffer));
  }

  text(value) {
    const raw = toUtf8.encode(value);
    this.unsigned(raw.length);
    for (const byte of raw) this.bytes.push(byte);
  }
}

/**
 * A type: how its values are read and written.
 * @typedef {{smallest: number, read: (from: Reader) => any, write: (to: Writer, value: any) => void}} Type
 */

/** @returns {Type} */
const unsigned = (size) => ({
  smallest: 1,
  read: (from) => from.unsigned(size),
  write: (to, value) => to.unsigned(value),
});

export const u16 = unsigned(2);
export const u32 = unsigned(4);
export const u64 = unsigned(8);
/** An id that fits a Number. @type {Type} */
export const id = { smallest: 1, read: (from) => from.id(), write: (to, value) => to.unsigned(value) };
/** @type {Type} */
export const f64 = { smallest: 8, read: (from) => from.f64(), write: (to, value) => to.f64(value) };
/** @type {Type} */
export const bool = { smallest: 1, read: (from) => from.bool(), write: (to, value) => to.bytes.push(value ? 1 : 0) };
/** @type {Type} */
export const text = { smallest: 1, read: (from) => from.text(), write: (to, value) => to.text(value) };

/** A list of values. @param {Type} item @returns {Type} */
export const list = (item) => ({
  smallest: 1,
  read(from) {
    const values = new Array(from.count(item.smallest));
    for (let i = 0; i < values.length; i++) values[i] = item.read(from);
    return values;
  },
  write(to, values) {
    to.unsigned(values.length);
    for (const value of values) item.write(to, value);
  },
});

/** A value, or null. @param {Type} some @returns {Type} */
export const maybe = (some) => ({
  smallest: 1,
  read: (from) => (from.bool() ? some.read(from) : null),
  write(to, value) {
    to.bytes.push(value === null ? 0 : 1);
    if (value !== null) some.write(to, value);
  },
});

/** Several values, as an array. @param {...Type} parts @returns {Type} */
export const tuple = (...parts) => ({
  smallest: parts.reduce((sum, part) => sum + part.smallest, 0),
  read: (from) => parts.map((part) => part.read(from)),
  write: (to, values) => parts.forEach((part, i) => part.write(to, values[i])),
});

/** Named fields in order, as an object. @param {Record<string, Type>} fields @returns {Type} */
export const record = (fields) => {
  const entries = Object.entries(fields);
  return {
    smallest: entries.reduce((sum, [, type]) => sum + type.smallest, 0),
    read(from) {
      const value = {};
      for (const [name, type] of entries) value[name] = type.read(from);
      return value;
    },
    write(to, value) {
      for (const [name, type] of entries) type.write(to, value[name]);
    },
  };
};

/**
 * One of several cases: its name if it has no field, else an object of its name and its field.
 * @param {string} what the type's name in error messages
 * @param {[string, Type?][]} cases
 * @returns {Type}
 */
export const oneOf = (what, cases) => ({
  smallest: 1,
  read(from) {
    const number = from.unsigned(4);
    if (number >= cases.length) throw new BodyError(`${what} has no case ${number}`);
    const [name, field] = cases[number];
    return field ? { [name]: field.read(from) } : name;
  },
  write(to, value) {
    const name = typeof value === "string" ? value : Object.keys(value)[0];
    const number = cases.findIndex(([other]) => other === name);
    to.unsigned(number);
    cases[number][1]?.write(to, value[name]);
  },
});

/**
 * A list of rows, each of ids and then numbers, in one flat array: nothing is allocated for a row. Such lists are only
 * read, since a consumer sends none. If the rows may be endless, the last number of each may be +infinity.
 * @returns {Type}
 */
export const rows = (ids, numbers, mayBeEndless = false) => ({
  smallest: 1,
  read(from) {
    const width = ids + numbers;
    const values = new Float64Array(from.count(ids + 8 * numbers) * width);
    for (let at = 0; at < values.length; at += width) {
      for (let i = 0; i < ids; i++) values[at + i] = from.id();
      for (let i = ids; i < width; i++) values[at + i] = mayBeEndless && i === width - 1 ? from.scale() : from.f64();
    }
    return values;
  },
  write() {
    throw new TypeError("rows are only read");
  },
});
