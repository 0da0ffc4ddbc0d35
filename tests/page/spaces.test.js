//! Streams in a space: mirrors of the golden vectors, contradictions, deaths that never come, steps, tracks, loops.

import assert from "node:assert/strict";
import { test } from "node:test";

import { assignColors, colorIndexOf, forgetColors } from "../../src/view/page/drawing/colors.js";
import { Layers, NOWHERE } from "../../src/view/page/drawing/layers.js";
import { TracksByLabel } from "../../src/view/page/drawing/picking.js";
import { filledHoles, forCriticalEdges, outlinesOf } from "../../src/view/page/drawing/styles.js";
import { extentOf, gapsOf } from "../../src/view/page/panels/diagram.js";
import { formatNumber } from "../../src/view/page/panels/numbers.js";
import { axesOf, shortSpaceName, spaceName, unitOf } from "../../src/view/page/panels/spaces.js";
import { labelsOf, holesOf, marksOf } from "../../src/view/page/session/dots.js";
import { Elements } from "../../src/view/page/session/elements.js";
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

for (const dimension of [1, 3, 6]) {
  test(`vertices of R^${dimension} that come, go and move are those of a plain model, and steps lead back`, () => {
    let [state, next] = [dimension, 0];
    const random = () => {
      state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
      return state / 2 ** 32;
    };
    const flat = (rows) => Float64Array.from(rows.flat());
    const [mirror, model, frames, moves, none] = [new Mirror(), new Map(), [[]], [], new Float64Array(0)];
    const snapshot = { metric: "Euclidean", dimension, vertices: none, edges: none, critical: none };
    mirror.applySnapshot({ ...snapshot, frame: { number: 0 }, checksum: 0 });
    for (let number = 1; number <= 40; number++) {
      const [removed, added] = [[], []];
      const place = (id) => added.push([id, ...Array.from({ length: dimension }, random)]);
      for (const id of [...model.keys()].sort((a, b) => a - b)) {
        const chance = random();
        if (chance < 0.3) removed.push([id]);
        if (chance < 0.15) place(id);
      }
      for (let i = 0; i < 9; i++) place(next++);
      for (const [id] of removed) model.delete(id);
      for (const row of added) model.set(row[0], row);
      frames.push([...model.values()].sort((a, b) => a[0] - b[0]));
      const sum = new Elements(1, 1, 1 + dimension);
      for (const row of model.values()) sum.add(Float64Array.from(row), 0);
      const diff = {
        from: number - 1,
        frame: { number },
        dimension,
        ids_added: flat(added.map((row) => row.slice(0, 1))),
        coordinates_added: flat(added.map((row) => row.slice(1))),
        vertices_removed: flat(removed),
        edges_added: none,
        edges_removed: none,
        critical_set: none,
        critical_removed: none,
        checksum: (BigInt(sum.sum[0]) << 32n) + BigInt(sum.sum[1]),
      };
      const [, forward] = inFormOfPlane("SpaceDiff", diff);
      moves.push({ forward, backward: mirror.applyDiff(forward) });
      assert.deepEqual(positions(mirror), frames[number], `frame ${number}`);
    }
    for (let number = 40; number > 0; number--) {
      mirror.moveTo(moves[number - 1].backward, { number });
      assert.deepEqual(positions(mirror), frames[number - 1], `back at frame ${number - 1}`);
    }
  });
}

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

test("spaces are told in words, and their pictures have axes and units only where they are the metric's", () => {
  const space = (metric, dimension) => ({ metric, dimension });
  for (const [one, name, short, axes, unit] of [
    [space("Euclidean", 3), "R^3, euclidean", "R^3", [], ""],
    [space("Manhattan", 2), "R^2, manhattan", "R^2", ["x", "y"], ""],
    [space("Chebyshev", 1), "R^1, chebyshev", "R^1", ["x"], ""],
    [space("Angular", 2), "R^2, angular", "R^2", [], null],
    [space("Haversine", 2), "longitude and latitude, haversine", "haversine", ["lon", "lat"], "°"],
    [space("Euclidean", 0), "euclidean", "euclidean", [], ""],
    [space("Euclidean", null), "euclidean", "euclidean", [], ""],
  ]) {
    assert.deepEqual([spaceName(one), shortSpaceName(one), axesOf(one), unitOf(one)], [name, short, axes, unit]);
  }
  assert.deepEqual([spaceName(space(null, 2)), axesOf(space(null, 2)), unitOf(space(null, 2))], ["", ["x", "y"], ""]);
});

test("the scales of a diagram leave out deaths that never come, and its gaps end at finite dots", () => {
  const labels = Float64Array.of(0.25, Infinity, 9, Infinity, 0.5, 8, 2, 2.5);
  assert.deepEqual(extentOf(labels), { highest: 9, hasImmortals: true });
  assert.deepEqual(extentOf(labels.subarray(4)), { highest: 8, hasImmortals: false });
  assert.deepEqual(gapsOf({ ds: 7.5, vs: 0.5 }, labels, 4), { diagonal: [0.5, 7.5], vertical: [0.5, 9] });
  assert.equal(formatNumber(Infinity), "∞");
});

test("loops of a space are outlines without circles and without fill, in the colours of their tracks", () => {
  const walk = Float64Array.of(1, 2, 3);
  const track = (id, area) => ({ id, birth: 1, death: Infinity, center: [0, 0, id], area, selected: true });
  const alive = [track(1, null), track(2, null)];
  const cycles = new Map(alive.map(({ id }) => [id, [walk]]));
  const inSpace = { ...annotations(), alive, cycles };
  forgetColors();
  assignColors(alive);
  const outlines = outlinesOf(inSpace, new TracksByLabel(), null);
  assert.deepEqual(
    outlines.map(({ walk: one, circle }) => [one, circle]),
    [
      [walk, null],
      [walk, null],
    ],
  );
  assert.deepEqual(filledHoles(inSpace), []);
  const [ofPlane] = outlinesOf({ ...inSpace, alive: [track(1, 5)] }, new TracksByLabel(), null);
  assert.ok(outlines[0].width > ofPlane.width, "a loop is wider than the outline of a hole that is filled");
  assert.equal(filledHoles({ ...inSpace, alive: [track(1, 5)] }).length, 1);
  // Colours go by all coordinates, and tracks of one place differ as well.
  assert.notEqual(colorIndexOf(1), colorIndexOf(2));
});

test("a critical edge that never dies is as strong as the most persistent one", () => {
  const critical = new Mirror().critical;
  const rows = [[1, 2, 0, Infinity], [1, 3, 0, 4], ...Array.from({ length: 300 }, (_, i) => [5, 6 + i, 0, 1])];
  for (const row of rows) critical.add(Float64Array.from(row), 0);
  const alphas = new Map();
  forCriticalEdges(critical, new TracksByLabel(), null, (a, b, _, alpha) => alphas.set(`${a} ${b}`, alpha));
  assert.deepEqual([alphas.get("1 2"), alphas.get("1 3"), alphas.get("5 6")], [1, 1, 0.625]);
});

test("layers have every slot once, the farthest first, whatever its depth is", () => {
  const layers = new Layers();
  const depths = [0.95, 0.1, -1, 1.7, NaN, 0.5, -0.2, 0.1];
  layers.sort(depths.length, (slot) => (slot === 2 ? NOWHERE : depths[slot]));
  const order = [...layers.order.subarray(0, layers.count)];
  assert.deepEqual([...order].sort(), [0, 1, 3, 4, 5, 6, 7]);
  const places = order.map((slot) => Math.min(1, Math.max(0, depths[slot] || 0)));
  places.slice(1).forEach((place, i) => assert.ok(place >= places[i] - 1 / 12, `${places}`));
  assert.deepEqual(order.slice(-2).sort(), [0, 3]);
  layers.sort(0, () => 0);
  assert.equal(layers.count, 0);
});
