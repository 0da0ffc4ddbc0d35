//! The page's tracks: the sequences of the golden vectors, contradictions, and lifetimes in their lanes.

import assert from "node:assert/strict";
import { test } from "node:test";

import { readFrame } from "../../src/view/page/frames.js";
import { Lifelines, SPAN } from "../../src/view/page/lifelines.js";
import { readMessage } from "../../src/view/page/protocol.js";
import { Tracks } from "../../src/view/page/tracks.js";
import { bytesOf, jsonOf } from "./vectors.js";

/** A vector as a message. One cycle in it has an id that no double holds: the page takes it from the JSON, rounded. */
function message(name) {
  const { type, body } = readFrame(bytesOf("v2", name), () => true);
  try {
    return readMessage(2, type, body).body;
  } catch {
    const { body: fields } = jsonOf("v2", name);
    const cycles = fields.cycles.map(({ id, walks }) => ({
      id,
      walks: walks.map((walk) => Float64Array.from(walk, Number)),
    }));
    return { ...fields, cycles };
  }
}

const track = (id, age, more = {}) => ({
  id,
  age,
  birth: 1,
  death: 2,
  center: [0, 0],
  radius: 1,
  area: 1,
  velocity: [0, 0],
  selected: true,
  ...more,
});
const event = (frame, happening, of) => ({ frame, time: null, happening, track: of });

test("the story of the vectors is followed", () => {
  const tracks = new Tracks();
  for (const name of ["tracks_start", "tracks", "tracks_merged"]) {
    const told = message(name);
    assert.equal(tracks.take(told), true, name);
    assert.equal(tracks.frame, told.frame);
    assert.deepEqual(tracks.living.alive, told.alive);
    for (const id of tracks.living.cycles.keys()) assert.ok(tracks.living.byId.has(id), `${name}: cycle of ${id}`);
  }
});

test("a cycle that was not told of again stays, and goes with its track", () => {
  const tracks = new Tracks();
  tracks.take(message("tracks_start"));
  const before = tracks.living.cycles;
  tracks.take(message("tracks"));
  assert.equal(tracks.living.cycles.get(2), before.get(2));
  assert.deepEqual(Array.from(tracks.living.cycles.get(1)[0]), [0, 1, 251]);
  assert.deepEqual([...before.keys()], [1, 2], "what was kept of the frame before is as it was");
});

test("what does not go with what is known asks for a new start, and nothing else is taken until then", () => {
  const wrong = [
    { from: 10, frame: 12 },
    { events: [event(12, "Born", track(1, 2))] },
    { events: [event(12, "Died", track(9, 2))] },
    { alive: [track(1, 2)] },
  ];
  for (const change of wrong) {
    const tracks = new Tracks();
    tracks.take(message("tracks_start"));
    assert.equal(tracks.take({ ...message("tracks"), ...change }), false, JSON.stringify(change));
    assert.equal(tracks.frame, null);
    const living = tracks.living;
    assert.equal(tracks.take(message("tracks")), true, "passed over");
    assert.equal(tracks.living, living);
    assert.equal(tracks.take(message("tracks_start")), true);
    assert.equal(tracks.frame, 11);
  }
});

test("a life begins, is split off, turns pale, and ends", () => {
  const lifelines = new Lifelines();
  lifelines.restart(10, [track(1, 4)]);
  lifelines.take(event(12, { Split: 1 }, track(2, 2)));
  lifelines.take(event(14, "Unselected", track(2, 4, { selected: false })));
  lifelines.take(event(17, "Reselected", track(2, 7)));
  lifelines.take(event(20, { Merged: 1 }, track(2, 9)));
  const [first, second] = [lifelines.lives.get(1), lifelines.lives.get(2)];
  assert.deepEqual([first.from, first.to, first.began], [7, null, "before"]);
  assert.deepEqual([second.from, second.to, second.began, second.parent], [11, 20, "split", 1]);
  assert.deepEqual([second.ended, second.into, second.pale], ["merged", 1, [14, 17]]);
  assert.notEqual(first.lane, second.lane);
});

test("a new start ends what is not there any more, and goes on with what is", () => {
  const lifelines = new Lifelines();
  lifelines.restart(10, [track(1, 4), track(2, 4)]);
  lifelines.restart(30, [track(2, 24), track(3, 5)]);
  assert.deepEqual(
    [...lifelines.lives.values()].map(({ id, from, to, ended }) => [id, from, to, ended]),
    [
      [1, 7, 30, "unseen"],
      [2, 7, null, null],
      [3, 26, null, null],
    ],
  );
});

test("lives do not share a lane at one time, lanes are used again, and nothing is kept for ever", () => {
  const lifelines = new Lifelines();
  const alive = new Map();
  let random = 1;
  for (let frame = 1; frame <= 20_000; frame++) {
    random = (Math.imul(random, 1664525) + 1013904223) >>> 0;
    if (random % 3 === 0 && alive.size < 30) {
      alive.set(frame, frame);
      lifelines.take(event(frame, "Born", track(frame, 1)));
    } else if (random % 5 < 2 && alive.size > 0) {
      const id = [...alive.keys()][random % alive.size];
      lifelines.take(event(frame, "Died", track(id, frame - alive.get(id))));
      alive.delete(id);
    }
    lifelines.forget(frame);
  }
  assert.ok(lifelines.lives.size < SPAN && lifelines.lives.size > 100, `${lifelines.lives.size} lives`);
  assert.ok(lifelines.lanes.length < 60, `${lifelines.lanes.length} lanes`);
  const ends = new Map();
  for (const { lane, from, to } of [...lifelines.lives.values()].sort((a, b) => a.from - b.from)) {
    assert.ok((ends.get(lane) ?? 0) < from, `lane ${lane} is taken at ${from}`);
    ends.set(lane, to ?? Infinity);
  }
});
