//! The page's tracks: the golden vectors, contradictions, lifetimes and their lanes.

import assert from "node:assert/strict";
import { test } from "node:test";

import { readFrame } from "../../src/view/page/session/frames.js";
import { Lifetimes, SPAN } from "../../src/view/page/session/lifetimes.js";
import { readMessage } from "../../src/view/page/session/protocol.js";
import { Tracks } from "../../src/view/page/session/tracks.js";
import { bytesOf, jsonOf } from "./vectors.js";

/** A vector as a message. One has an id that no double can hold; it is taken from the JSON, rounded. */
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

test("the messages of the vectors are applied", () => {
  const tracks = new Tracks();
  for (const name of ["tracks_start", "tracks", "tracks_merged"]) {
    const sent = message(name);
    assert.equal(tracks.apply(sent), true, name);
    assert.equal(tracks.frame, sent.frame);
    assert.deepEqual(tracks.current.alive, sent.alive);
    for (const id of tracks.current.cycles.keys()) assert.ok(tracks.current.byId.has(id), `${name}: cycle of ${id}`);
  }
});

test("a cycle that is not sent again stays until its track ends", () => {
  const tracks = new Tracks();
  tracks.apply(message("tracks_start"));
  const before = tracks.current.cycles;
  tracks.apply(message("tracks"));
  assert.equal(tracks.current.cycles.get(2), before.get(2));
  assert.deepEqual(Array.from(tracks.current.cycles.get(1)[0]), [0, 1, 251]);
  assert.deepEqual([...before.keys()], [1, 2], "the state of the frame before is unchanged");
});

test("a contradiction asks for a restart, and messages are ignored until then", () => {
  const wrong = [
    { from: 10, frame: 12 },
    { events: [event(12, "Born", track(1, 2))] },
    { events: [event(12, "Died", track(9, 2))] },
    { alive: [track(1, 2)] },
  ];
  for (const change of wrong) {
    const tracks = new Tracks();
    tracks.apply(message("tracks_start"));
    assert.equal(tracks.apply({ ...message("tracks"), ...change }), false, JSON.stringify(change));
    assert.equal(tracks.frame, null);
    const before = tracks.current;
    assert.equal(tracks.apply(message("tracks")), true, "ignored");
    assert.equal(tracks.current, before);
    assert.equal(tracks.apply(message("tracks_start")), true);
    assert.equal(tracks.frame, 11);
  }
});

test("a lifetime begins by a split, leaves and enters the selection, and ends", () => {
  const lifetimes = new Lifetimes();
  lifetimes.restart(10, [track(1, 4)]);
  lifetimes.apply(event(12, { Split: 1 }, track(2, 2)));
  lifetimes.apply(event(14, "Unselected", track(2, 4, { selected: false })));
  lifetimes.apply(event(17, "Reselected", track(2, 7)));
  lifetimes.apply(event(20, { Merged: 1 }, track(2, 9)));
  const [first, second] = [lifetimes.byId.get(1), lifetimes.byId.get(2)];
  assert.deepEqual([first.from, first.to, first.began], [7, null, "before"]);
  assert.deepEqual([second.from, second.to, second.began, second.parent], [11, 20, "split", 1]);
  assert.deepEqual([second.ended, second.into, second.selectionChanges], ["merged", 1, [14, 17]]);
  assert.notEqual(first.lane, second.lane);
});

test("a restart ends the lifetimes of tracks that are gone, and continues the others", () => {
  const lifetimes = new Lifetimes();
  lifetimes.restart(10, [track(1, 4), track(2, 4)]);
  lifetimes.restart(30, [track(2, 24), track(3, 5)]);
  assert.deepEqual(
    [...lifetimes.byId.values()].map(({ id, from, to, ended }) => [id, from, to, ended]),
    [
      [1, 7, 30, "unseen"],
      [2, 7, null, null],
      [3, 26, null, null],
    ],
  );
});

test("lifetimes in a lane do not overlap, lanes are reused, and old lifetimes are dropped", () => {
  const lifetimes = new Lifetimes();
  const alive = new Map();
  let random = 1;
  for (let frame = 1; frame <= 20_000; frame++) {
    random = (Math.imul(random, 1664525) + 1013904223) >>> 0;
    if (random % 3 === 0 && alive.size < 30) {
      alive.set(frame, frame);
      lifetimes.apply(event(frame, "Born", track(frame, 1)));
    } else if (random % 5 < 2 && alive.size > 0) {
      const id = [...alive.keys()][random % alive.size];
      lifetimes.apply(event(frame, "Died", track(id, frame - alive.get(id))));
      alive.delete(id);
    }
    lifetimes.prune(frame);
  }
  assert.ok(lifetimes.byId.size < SPAN && lifetimes.byId.size > 100, `${lifetimes.byId.size} lifetimes`);
  assert.ok(lifetimes.lanes.length < 60, `${lifetimes.lanes.length} lanes`);
  const ends = new Map();
  for (const { lane, from, to } of [...lifetimes.byId.values()].sort((a, b) => a.from - b.from)) {
    assert.ok((ends.get(lane) ?? 0) < from, `lane ${lane} is taken at ${from}`);
    ends.set(lane, to ?? Infinity);
  }
});
