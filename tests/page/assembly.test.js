//! Pictures of the page: nothing is shown before all of it is there, whatever comes first or is left out.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Assembly } from "../../src/view/page/session/assembly.js";

const view = (cut = "Full") => ({ cut, simplify: "No" });
const body = (number, cut) => ({ frame: { number, view: view(cut) } });
const all = { tracks: true, simplified: false };
const nothing = { frame: null, dots: null, tracks: null, simplified: null };
const holding = (number) => ({ ...nothing, frame: body(number).frame, dots: number, tracks: number });

test("a picture has its frame, its dots and its tracks, in whatever order they come", () => {
  const parts = {
    frame: (assembly) => assembly.addFrame("Snapshot", body(7)),
    dots: (assembly) => assembly.addDots(7, { total: 3 }),
    tracks: (assembly) => assembly.addTracks({ frame: 7 }),
  };
  const orders = [
    ["frame", "dots", "tracks"],
    ["frame", "tracks", "dots"],
    ["tracks", "dots", "frame"],
  ];
  for (const order of orders) {
    const assembly = new Assembly();
    for (const name of order.slice(0, 2)) {
      parts[name](assembly);
      assert.equal(assembly.take(nothing, all), null, `${name} of ${order}`);
    }
    parts[order[2]](assembly);
    const picture = assembly.take(nothing, all);
    assert.deepEqual([picture.number, picture.frames.length, picture.dots.total], [7, 1, 3]);
    assert.equal(assembly.take(holding(7), all), null, "it is taken once");
  }
});

test("a frame whose dots never come is passed over, and its change is not lost", () => {
  const assembly = new Assembly();
  assembly.addFrame("Diff", body(8));
  assembly.addTracks({ frame: 8 });
  assert.equal(assembly.take(holding(7), all), null);
  assembly.addFrame("Diff", body(9));
  assembly.addTracks({ frame: 9 });
  assembly.addDots(9, null);
  const picture = assembly.take(holding(7), all);
  assert.deepEqual(
    [picture.number, picture.frames.map(({ body: { frame } }) => frame.number), picture.tracks.length, picture.dots],
    [9, [8, 9], 2, null],
  );
});

test("of several complete frames the newest is taken, and what belongs to later ones stays", () => {
  const assembly = new Assembly();
  for (const number of [8, 9, 10]) assembly.addFrame("Diff", body(number));
  for (const number of [8, 9]) assembly.addTracks({ frame: number });
  for (const number of [8, 9, 10]) assembly.addDots(number, { total: number });
  const picture = assembly.take(holding(7), all);
  assert.deepEqual([picture.number, picture.dots.total, assembly.frames.length, assembly.newest], [9, 9, 1, 10]);
  assembly.addTracks({ frame: 10 });
  assert.deepEqual(assembly.take(holding(9), all).dots, { total: 10 });
});

test("without tracks a picture is complete without them", () => {
  const assembly = new Assembly();
  assembly.addFrame("Diff", body(8));
  assembly.addDots(8, null);
  assert.equal(assembly.take(holding(7), all), null);
  assert.equal(assembly.take(holding(7), { ...all, tracks: false }).number, 8);
});

test("a snapshot replaces the frames before it", () => {
  const assembly = new Assembly();
  assembly.addFrame("Diff", body(8));
  assembly.addFrame("Snapshot", body(9));
  assembly.addDots(9, null);
  assembly.addTracks({ frame: 9 });
  assert.deepEqual(
    assembly.take(holding(7), all).frames.map(({ name }) => name),
    ["Snapshot"],
  );
});

test("the simplified form is that of the same frame in the same cut", () => {
  const wanted = { tracks: false, simplified: true };
  const assembly = new Assembly();
  assembly.addFrame("Diff", body(8));
  assembly.addDots(8, null);
  assembly.addSimplified("Snapshot", body(8, { Reduced: 1 }));
  assert.equal(assembly.take(holding(7), wanted), null, "another cut");
  assembly.addSimplified("Diff", body(9));
  assert.equal(assembly.take(holding(7), wanted), null, "another frame");
  assembly.addFrame("Diff", body(9));
  assembly.addDots(9, null);
  const picture = assembly.take(holding(7), wanted);
  assert.deepEqual([picture.number, picture.frames.length, picture.simplified.length], [9, 2, 2]);
  // Chosen later, for a frame that is shown already.
  assembly.addSimplified("Snapshot", body(9));
  assert.equal(assembly.take(holding(9), wanted).simplified.length, 1);
});

test("what never becomes complete is noticed", () => {
  const assembly = new Assembly();
  for (let number = 1; number < 300; number++) assembly.addFrame("Diff", body(number));
  assert.equal(assembly.take(nothing, all), null);
  assert.equal(assembly.isOverfull, true);
});
