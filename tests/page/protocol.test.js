//! The page's encoding and decoding of the protocol, compared with the golden vectors.

import assert from "node:assert/strict";
import { test } from "node:test";

import { BodyError } from "../../src/view/page/session/bytes.js";
import {
  FrameError,
  ReceiveBuffer,
  crc32c,
  readBanner,
  readFrame,
  writeBanner,
} from "../../src/view/page/session/frames.js";
import { agree, readMessage, typeOf, writeMessage } from "../../src/view/page/session/protocol.js";
import { bytesOf, jsonOf, names } from "./vectors.js";

const CAP = 2 ** 30;
/** The messages that a consumer sends. */
const SENT = [
  "Hello",
  "Ping",
  "Pong",
  "Goodbye",
  "ListStreams",
  "Subscribe",
  "ChangeView",
  "Unsubscribe",
  "WantTracks",
  "ListSpaces",
];
/** Columns of the lists that are decoded as flat rows. */
const WIDTHS = {
  vertices: 3,
  edges: 2,
  critical: 4,
  vertices_added: 3,
  vertices_removed: 1,
  edges_added: 2,
  edges_removed: 2,
  critical_set: 4,
  critical_removed: 2,
  dots: 7,
  ids: 1,
  ids_added: 1,
};

const dot = ([a, b, birth, death, x, y, radius]) => ({ edge: [a, b], birth, death, center: [x, y], radius });

/** A message in the form of the vectors' JSON. */
function plain(value, key) {
  if (value instanceof Float64Array) {
    const width = WIDTHS[key] ?? 1;
    if (width === 1) return Array.from(value);
    const row = (_, i) => Array.from(value.slice(i * width, (i + 1) * width));
    const rows = Array.from({ length: value.length / width }, row);
    return key === "dots" ? rows.map(dot) : rows;
  }
  if (Array.isArray(value)) return value.map((item) => plain(item));
  if (value === null || typeof value !== "object") return value;
  return Object.fromEntries(Object.entries(value).map(([name, item]) => [name, plain(item, name)]));
}

/** Whether a message lists an id that no double can hold: the page refuses such a message. */
function listsHugeIds(body) {
  const isBig = (value) => typeof (value?.edge?.find(big) ?? value) === "bigint";
  const big = (value) => (Array.isArray(value) ? value.some(big) : isBig(value));
  return Object.keys(WIDTHS).some((key) => big(body[key])) || (body.cycles ?? []).some?.((cycle) => big(cycle.walks));
}

test("CRC-32C has its known value", () => {
  assert.equal(crc32c(new TextEncoder().encode("123456789")), 0xe3069283);
});

/** How many messages of each version's vectors are for consumers, and how many are from them, at the least. */
const LEAST = { 1: [15, 4], 2: [15, 4], 3: [1, 0], 4: [15, 1] };

for (const version of [1, 2, 3, 4]) {
  const folder = `v${version}`;

  test(`every message for consumers in ${folder} is decoded to its vector's JSON and encoded to its bytes`, () => {
    let [read, written, huge] = [0, 0, 0];
    for (const name of names(folder)) {
      const vector = jsonOf(folder, name);
      if (vector.type === "Banner" || typeOf(vector.type) === undefined) continue;
      const bytes = bytesOf(folder, name);
      const frame = readFrame(bytes, (other) => other === version, CAP);
      assert.deepEqual([frame.type, frame.channel, frame.end], [vector.number, vector.channel, bytes.length], name);
      if (listsHugeIds(vector.body)) {
        assert.throws(() => readMessage(version, frame.type, frame.body), /more than this page can hold/, name);
        huge += 1;
        continue;
      }
      const message = readMessage(version, frame.type, frame.body);
      assert.deepEqual({ type: message.name, ...plain(message.body) }, { type: vector.type, ...vector.body }, name);
      read += 1;
      if (!SENT.includes(vector.type)) continue;
      assert.deepEqual(writeMessage(version, vector.channel, vector.type, vector.body), bytes, name);
      written += 1;
    }
    const [leastRead, leastWritten] = LEAST[version];
    const counts = `${read} read, ${written} written, ${huge} with huge ids`;
    assert.ok(read >= leastRead && written >= leastWritten && huge < Math.max(1, read / 3), counts);
  });

  test(`every bad vector of ${folder} is refused with its error`, () => {
    for (const name of names(`${folder}/bad`)) {
      const { error } = jsonOf(`${folder}/bad`, name);
      assert.equal(faultOf(bytesOf(`${folder}/bad`, name), version), error, name);
    }
  });
}

function faultOf(bytes, version) {
  try {
    const frame = readFrame(bytes, (other) => other === version, CAP);
    if (!frame) return "incomplete";
    readMessage(version, frame.type, frame.body);
    return "nothing";
  } catch (error) {
    if (error instanceof FrameError) return error.fault;
    if (error instanceof BodyError) return "body";
    throw error;
  }
}

test("banners are read and written, and broken ones refused", () => {
  for (const folder of ["v1", "v2", "v3", "v4"]) {
    const { lowest, highest } = jsonOf(folder, "banner");
    assert.deepEqual(readBanner(bytesOf(folder, "banner")), { lowest, highest });
    assert.deepEqual(writeBanner(lowest, highest), bytesOf(folder, "banner"));
  }
  for (let at = 0; at < 20; at++) {
    const bytes = bytesOf("v2", "banner");
    bytes[at] ^= 4;
    assert.throws(() => readBanner(bytes), FrameError);
  }
});

test("the highest common version is chosen", () => {
  assert.equal(agree({ lowest: 1, highest: 1 }), 1);
  assert.equal(agree({ lowest: 2, highest: 9 }), 4);
  assert.equal(agree({ lowest: 1, highest: 3 }), 3);
  assert.equal(agree({ lowest: 5, highest: 9 }), null);
});

test("a death may be infinite in a space and nowhere else, and no other number is", () => {
  const { type, body } = readFrame(bytesOf("v4", "space_snapshot"), () => true);
  /** The body with another number in the place of a known one. */
  const withNumber = (known, number) => {
    const pattern = Buffer.from(Float64Array.of(known).buffer);
    const changed = Buffer.from(body);
    const at = changed.indexOf(pattern);
    assert.ok(at >= 0, `${known} is in the body`);
    changed.writeDoubleLE(number, at);
    return changed;
  };
  const death = (number) => readMessage(4, type, withNumber(1.4375, number)).body.critical[3];
  assert.equal(death(Infinity), Infinity);
  for (const number of [-Infinity, NaN]) assert.throws(() => death(number), BodyError);
  // A coordinate and a birth.
  for (const known of [-0.5, 1]) {
    for (const number of [Infinity, -Infinity, NaN]) {
      assert.throws(() => readMessage(4, type, withNumber(known, number)), BodyError, `${number} for ${known}`);
    }
  }
  const plane = readFrame(bytesOf("v1", "snapshot"), () => true);
  const { critical } = readMessage(1, plane.type, plane.body).body;
  const endless = Buffer.from(plane.body);
  endless.writeDoubleLE(Infinity, endless.indexOf(Buffer.from(Float64Array.of(critical[3]).buffer)));
  assert.throws(() => readMessage(1, plane.type, endless), BodyError);
});

test("frames are complete, whatever the size of the pieces", () => {
  const parts = ["snapshot", "diff", "diff_onwards", "heartbeat"].map((name) => bytesOf("v1", name));
  const stream = Buffer.concat(parts);
  for (const size of [1, 3, 19, 20, 21, 64, 1000, stream.length]) {
    const received = new ReceiveBuffer();
    const ends = [];
    for (let at = 0; at < stream.length; at += size) {
      received.push(Uint8Array.from(stream.subarray(at, at + size)));
      for (let frame; (frame = received.next((version) => version === 1));) ends.push(frame.end);
    }
    assert.deepEqual(
      ends,
      parts.map((part) => part.length),
      `pieces of ${size}`,
    );
    assert.equal(received.rest.length, 0);
  }
});
