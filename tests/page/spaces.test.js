//! Streams in a space: mirrors of the golden vectors, contradictions, deaths that never come, steps back, tracks.

import assert from "node:assert/strict";
import { test } from "node:test";

import { labelsOf, holesOf, marksOf } from "../../src/view/page/session/dots.js";
import { readFrame } from "../../src/view/page/session/frames.js";
import { History } from "../../src/view/page/session/history.js";
import { Contradiction, Mirror } from "../../src/view/page/session/mirror.js";
import { readMessage } from "../../src/view/page/session/protocol.js";
import { inFormOfPlane } from "../../src/view/page/session/spaces.js";
import { Tracks } from "../../src/view/page/session/tracks.js";
import { bytesOf, jsonOf } from "./vectors.js";

/** A vector as a message. Some have an id that no double can hold; they are taken from the JSON, rounded. */
function sent(name) {
  const { type, body } = readFrame(bytesOf("v4", name), () => true);
  try {
    return readMessage(4, type, body);
  } catch {
    const { type: known, body: fields } = jsonOf("v4", name);
    const walksOf = ({ id, walks }) => ({ id, walks: walks.map((walk) => Float64Array.from(walk, Number)) });
    return { name: known, body: { ...fields, cycles: fields.cycles.map(walksOf) } };
  }
}
/** A vector in the form of the plane. */
const message = (name) => {
  const { name: type, body } = sent(name);
  return inFormOfPlane(type, body)[1];
};
const annotations = () => ({
  alive: [],
  cycles: new Map(),
  dots: { labels: new Float64Array(0), isShown: new Uint8Array(0), holes: new Float64Array(0) },
});

/** The positions of a mirror by id. */
function positions({ vertices }) {
  const { rows, width, end } = vertices;
  const found = [];
  for (let at = 0; at < width * end; at += width) if (rows[at] >= 0) found.push([...rows.subarray(at, at + width)]);
  return found.sort((a, b) => a[0] - b[0]);
}

const STORY = ["space_snapshot", "space_diff", "space_diff_onwards"];

test("the snapshot and the diffs of the vectors are applied and verified, and steps lead back through them", () => {
  const [mirror, history] = [new Mirror(), new History()];
  mirror.applySnapshot(message("space_snapshot"));
  assert.deepEqual([mirror.metric, mirror.dimension], ["Euclidean", 3]);
  const [first, ...others] = [positions(mirror)];
  const { ids, coordinates } = jsonOf("v4", "space_snapshot").body;
  assert.deepEqual(
    first,
    ids.map((id, i) => [id, ...coordinates.slice(3 * i, 3 * i + 3)]),
  );
  history.restart(mirror.frame, annotations());
  for (const name of STORY.slice(1)) {
    const [forward, from] = [message(name), mirror.frame];
    const backward = mirror.applyDiff(forward);
    history.push(mirror.frame, [{ mirror, forward, backward, from, to: mirror.frame }], annotations());
    others.push(positions(mirror));
  }
  history.moveBy(-2);
  assert.deepEqual(positions(mirror), first);
  for (const after of others) {
    history.moveBy(1);
    assert.deepEqual(positions(mirror), after);
  }
});

test("snapshots of every kind of space are verified", () => {
  for (const [name, metric, dimension] of [
    ["space_snapshot_earth", "Haversine", 2],
    ["space_snapshot_nothing", "Manhattan", 0],
  ]) {
    const mirror = new Mirror();
    const { body } = sent(name);
    mirror.applySnapshot(inFormOfPlane("SpaceSnapshot", body)[1]);
    assert.equal(mirror.frame.number, body.frame.number);
    assert.deepEqual([mirror.metric, mirror.dimension], [metric, dimension]);
    assert.equal(mirror.vertices.count, body.ids.length);
  }
});

test("what does not fit what is held is a contradiction", () => {
  const changed = (name, change) => () => {
    const mirror = new Mirror();
    mirror.applySnapshot(message("space_snapshot"));
    const { name: type, body } = sent(name);
    const [, inForm] = inFormOfPlane(type, { ...body, ...change });
    if (type === "SpaceSnapshot") mirror.applySnapshot(inForm);
    else mirror.applyDiff(inForm);
  };
  changed("space_diff", {})();
  const { coordinates_added: coordinates, checksum } = sent("space_diff").body;
  for (const [name, change] of [
    ["space_diff", { dimension: 2, coordinates_added: coordinates.slice(0, 4) }],
    ["space_diff", { coordinates_added: coordinates.slice(1) }],
    ["space_diff", { coordinates_added: coordinates.map((x, i) => (i === 5 ? x + 1e-12 : x)) }],
    ["space_diff", { checksum: BigInt(checksum) ^ 1n }],
    ["space_snapshot", { dimension: 0, coordinates: new Float64Array(0) }],
    ["space_snapshot", { dimension: 2 }],
  ]) {
    assert.throws(changed(name, change), Contradiction, `${name} ${JSON.stringify(change, (_, v) => String(v))}`);
  }
});

test("the first point of a stream fixes its dimension, and a step leads back to before it", () => {
  const [mirror, none] = [new Mirror(), new Float64Array(0)];
  mirror.applySnapshot(message("space_snapshot_nothing"));
  const { body: full } = sent("space_snapshot");
  const diff = {
    from: 1,
    frame: { ...full.frame, number: 2 },
    dimension: 3,
    ids_added: full.ids,
    coordinates_added: full.coordinates,
    vertices_removed: none,
    edges_added: full.edges,
    edges_removed: none,
    critical_set: full.critical,
    critical_removed: none,
    checksum: full.checksum,
  };
  const [, forward] = inFormOfPlane("SpaceDiff", diff);
  const backward = mirror.applyDiff(forward);
  const after = positions(mirror);
  assert.deepEqual([mirror.dimension, after.length], [3, 5]);
  mirror.moveTo(backward, null);
  assert.deepEqual(positions(mirror), []);
  mirror.moveTo(forward, diff.frame);
  assert.deepEqual(positions(mirror), after);
});

test("a plane and a space follow each other in one mirror", () => {
  const mirror = new Mirror();
  const { type, body } = readFrame(bytesOf("v1", "snapshot"), () => true);
  const plane = readMessage(1, type, body).body;
  for (let round = 0; round < 2; round++) {
    mirror.applySnapshot(message("space_snapshot"));
    assert.equal(mirror.dimension, 3);
    mirror.applySnapshot(plane);
    assert.deepEqual([mirror.metric, mirror.dimension, mirror.vertices.width], [null, 2, 3]);
  }
});

test("dots that never die have an infinite death, are marked like others, and have no hole", () => {
  const { labels, total, dots } = message("space_dots_endless");
  assert.deepEqual([...labels], [0.25, Infinity, 0.5, 8]);
  assert.equal(total, 251);
  const mirror = new Mirror();
  mirror.critical.add(Float64Array.of(250, 251, 0.25, Infinity), 0);
  const marks = marksOf(labels, mirror.critical);
  assert.deepEqual([...marks], [1, 0]);
  assert.equal(holesOf(dots, marks).length, 0);
  assert.equal(labelsOf(dots).length, 0);
});

test("the tracks of the vectors are applied, with infinite deaths and without areas", () => {
  const tracks = new Tracks();
  for (const name of ["space_tracks_start", "space_tracks", "space_tracks_merged"]) {
    assert.equal(tracks.apply(message(name)), true, name);
    const { alive } = jsonOf("v4", name).body;
    assert.deepEqual(
      tracks.current.alive.map(({ id, death, area, center }) => [id, death, area, center]),
      alive.map(({ id, death, center }) => [id, death ?? Infinity, null, center]),
      name,
    );
  }
});

test("events alone have no list of living tracks", () => {
  const { body } = sent("space_tracks_updated");
  assert.equal(inFormOfPlane("SpaceTracks", { ...body, alive: null })[1].alive, null);
});

test("other messages are left as they are", () => {
  const body = {};
  for (const name of ["Snapshot", "Heartbeat", "Tracks"]) assert.deepEqual(inFormOfPlane(name, body), [name, body]);
});
