//! The messages of the protocol that a consumer needs. `protocol/SPEC.md` defines every byte.
//!
//! In: a type and a body, or a message.
//! Out: a message, or a frame.
//! Invariants: fields have the names of the SPEC. Lists of vertices, edges, critical edges and dots are rows in one
//! Float64Array. A body is read to its last byte or refused.
//! Must not know: sockets, what is done with messages.

import {
  BodyError,
  Reader,
  Writer,
  bool,
  f64,
  id,
  list,
  maybe,
  oneOf,
  record,
  rows,
  text,
  tuple,
  u16,
  u32,
  u64,
} from "./bytes.js";
import { writeFrame } from "./frames.js";

/** The lowest and the highest version that the page speaks. */
export const VERSIONS = { lowest: 1, highest: 4 };

/** The part of a skeleton that is followed. @typedef {{cut: any, simplify: any}} View */
/** @typedef {{name: string, body: any}} Message */
/**
 * One living cycle. In a space other than the plane it has no area.
 * @typedef {{id: number, age: number, birth: number, death: number, center: number[], radius: number,
 *   area: number | null, velocity: number[], selected: boolean}} Track
 */

const nothing = record({});
const pair = tuple(f64, f64);
const window_ = oneOf("Window", [["All"], ["Points", u64], ["Frames", u64], ["Time", f64]]);
const cut = oneOf("Cut", [["Full"], ["Reduced", f64], ["Derived", tuple(u32, u32)]]);
const simplify = oneOf("Simplify", [["No"], ["AtScale"], ["Below", f64]]);
const view = record({ cut, simplify });
const dotsWanted = oneOf("DotsWanted", [["No"], ["Top", u32], ["All"]]);
const cause = oneOf("Cause", [["Start"], ["ViewChanged"], ["Lagged"], ["CannotResume"]]);
const tracksWanted = oneOf("TracksWanted", [["No"], ["Events"], ["Alive"], ["Cycles"]]);

const frame = record({
  number: u64,
  time: maybe(f64),
  points: u64,
  vertices: u64,
  rejected: u64,
  view,
  ds: maybe(f64),
  vs: maybe(f64),
  components: u64,
  cycles: u64,
});

const streamInfo = record({
  stream: u32,
  name: text,
  epoch: u64,
  window: window_,
  resolution: maybe(f64),
  frame: u64,
  points: u64,
  vertices: u64,
  producers: u32,
  consumers: u32,
});

const track = record({
  id: u64,
  age: u64,
  birth: f64,
  death: f64,
  center: pair,
  radius: f64,
  area: f64,
  velocity: pair,
  selected: bool,
});

/** A track in a space: one that never dies has no death. */
const spaceTrack = record({
  id: u64,
  age: u64,
  birth: f64,
  death: maybe(f64),
  center: list(f64),
  radius: f64,
  velocity: list(f64),
  selected: bool,
});

const happening = oneOf("Happening", [
  ["Born"],
  ["Split", u64],
  ["Updated", record({ center: bool, birth: bool, death: bool })],
  ["Unselected"],
  ["Reselected"],
  ["Merged", u64],
  ["Died"],
]);

const vertices = rows(1, 2);
const ids = rows(1, 0);
const edges = rows(2, 0);
const critical = rows(2, 2);

const metric = oneOf("Metric", [["Euclidean"], ["Manhattan"], ["Chebyshev"], ["Angular"], ["Haversine"]]);
const coordinates = rows(0, 1);
const spaceCritical = rows(2, 2, true);

/** A dot in a space: one that never dies has no death. */
const edge = tuple(id, id);
const spaceDot = record({ edge, birth: f64, death: maybe(f64), death_edge: maybe(edge) });

/** A message about tracks. */
const tracks = (one) =>
  record({
    stream: u32,
    from: u64,
    frame: u64,
    time: maybe(f64),
    events: list(record({ frame: u64, time: maybe(f64), happening, track: one })),
    alive: maybe(list(one)),
    cycles: list(record({ id: u64, walks: list(ids) })),
  });

/**
 * Name and body of each type; the third entry is the first version that has it, if that is not 1.
 * @type {Record<number, [string, any, number?]>}
 */
const MESSAGES = {
  0x0001: ["Hello", record({ software: text, capabilities: list(text) })],
  0x0002: [
    "Welcome",
    record({
      software: text,
      capabilities: list(text),
      epoch: u64,
      largest_frame: u32,
      largest_batch: u32,
      heartbeat_ms: u32,
      timeout_ms: u32,
    }),
  ],
  0x0003: ["Ping", record({ token: u64 })],
  0x0004: ["Pong", record({ token: u64 })],
  0x0005: ["Goodbye", record({ reason: text, streams: list(tuple(text, u64)) })],
  0x0006: ["Error", record({ code: u16, answers: u16, text })],
  0x0007: ["ListStreams", record({ pattern: text })],
  0x0008: ["Streams", record({ streams: list(streamInfo) })],
  0x000b: ["ListSpaces", nothing, 4],
  0x000c: ["Spaces", record({ streams: list(record({ stream: u32, metric, dimension: maybe(u32) })) }), 4],
  0x0201: [
    "Subscribe",
    record({ pattern: text, view, dots: dotsWanted, resume: maybe(record({ epoch: u64, frame: u64 })) }),
  ],
  0x0202: ["ChangeView", record({ view, dots: dotsWanted })],
  0x0203: ["Unsubscribe", nothing],
  0x0204: [
    "StreamOpened",
    record({ stream: u32, name: text, epoch: u64, window: window_, resolution: maybe(f64), frame: u64 }),
  ],
  0x0205: ["StreamClosed", record({ stream: u32, frame: u64, reason: text })],
  0x0206: ["Snapshot", record({ stream: u32, cause, frame, vertices, edges, critical, checksum: u64 })],
  0x0207: [
    "Diff",
    record({
      stream: u32,
      from: u64,
      frame,
      vertices_added: vertices,
      vertices_removed: ids,
      edges_added: edges,
      edges_removed: edges,
      critical_set: critical,
      critical_removed: edges,
      checksum: u64,
    }),
  ],
  0x0208: [
    "Dots",
    record({
      stream: u32,
      frame: u64,
      total: u64,
      dots: rows(2, 5),
    }),
  ],
  0x0209: ["Heartbeat", record({ stream: u32, frame: u64 })],
  0x020a: ["Lagged", record({ stream: u32, first: u64, last: u64 })],
  0x020b: ["Resumed", record({ stream: u32, frame: u64 })],
  0x020c: ["Unsubscribed", nothing],
  0x020d: ["WantTracks", record({ tracks: tracksWanted }), 2],
  0x020e: ["Tracks", tracks(track), 2],
  0x0210: [
    "SpaceSnapshot",
    record({
      stream: u32,
      cause,
      frame,
      metric,
      dimension: u32,
      ids,
      coordinates,
      edges,
      critical: spaceCritical,
      checksum: u64,
    }),
    4,
  ],
  0x0211: [
    "SpaceDiff",
    record({
      stream: u32,
      from: u64,
      frame,
      dimension: u32,
      ids_added: ids,
      coordinates_added: coordinates,
      vertices_removed: ids,
      edges_added: edges,
      edges_removed: edges,
      critical_set: spaceCritical,
      critical_removed: edges,
      checksum: u64,
    }),
    4,
  ],
  0x0212: ["SpaceDots", record({ stream: u32, frame: u64, total: u64, dots: list(spaceDot) }), 4],
  0x0213: ["SpaceTracks", tracks(spaceTrack), 4],
};

const TYPES = new Map(Object.entries(MESSAGES).map(([type, [name]]) => [name, Number(type)]));

/** The number of a message's type. @param {string} name */
export const typeOf = (name) => TYPES.get(name);

/** Reads a body. @param {number} type @param {Uint8Array} body @returns {Message} */
export function readMessage(version, type, body) {
  const [name, fields, since = 1] = MESSAGES[type] ?? [];
  if (!name || since > version) throw new BodyError(`type ${type} is not known in version ${version}`);
  const from = new Reader(body);
  const message = { name, body: fields.read(from) };
  if (from.left > 0) throw new BodyError(`${from.left} bytes are left after a ${name}`);
  return message;
}

/** A message as a frame. @param {string} name */
export function writeMessage(version, channel, name, body = {}) {
  const type = TYPES.get(name);
  const to = new Writer();
  MESSAGES[type][1].write(to, body);
  return writeFrame(version, type, channel, to.bytes);
}

/** The version that both sides speak, or null. @param {{lowest: number, highest: number}} theirs */
export function agree(theirs) {
  const version = Math.min(VERSIONS.highest, theirs.highest);
  return version >= Math.max(VERSIONS.lowest, theirs.lowest) ? version : null;
}
