//! Dots of the page: marked are those that the view has, by Definition 14 and not only by the gaps.

import assert from "node:assert/strict";
import { test } from "node:test";

import { wordsFor, waitingFor } from "../../src/view/page/panels/status.js";
import { formatPlace, roundLength } from "../../src/view/page/panels/ruler.js";
import { gapsOf } from "../../src/view/page/panels/diagram.js";
import { holesOf, labelsOf, marksOf } from "../../src/view/page/session/dots.js";
import { Elements } from "../../src/view/page/session/elements.js";

/** Rows of a `Dots` message: ends of the edge, birth, death, centre and radius. */
const ROWS = Float64Array.of(
  ...[1, 2, 0.5, 3, 10, 20, 3],
  ...[3, 4, 0.4, 1.2, 11, 21, 1.2],
  ...[5, 6, 1.5, 2.2, 12, 22, 2.2],
  ...[7, 8, 0.1, 0.2, 13, 23, 0.2],
);

function criticalOf(...rows) {
  const critical = new Elements(3, 2, 4);
  for (const row of rows) critical.add(Float64Array.from(row), 0);
  return critical;
}

test("dots are marked if the view has their cycle", () => {
  // ds = 0.7 and vs = 1.5. The second dot is above both gaps but dead at vs, so the view lacks it.
  const critical = criticalOf([1, 2, 0.5, 3], [5, 6, 1.5, 2.2]);
  const labels = labelsOf(ROWS);
  assert.deepEqual([...labels], [0.5, 3, 0.4, 1.2, 1.5, 2.2, 0.1, 0.2]);
  const marks = marksOf(labels, critical);
  assert.deepEqual([...marks], [1, 0, 1, 0]);
  assert.deepEqual([...holesOf(ROWS, marks)], [0.5, 3, 10, 20, 3, 1.5, 2.2, 12, 22, 2.2]);
});

test("equal deaths do not mix up births, and removed edges count no more", () => {
  const critical = criticalOf([1, 2, 0.5, 3], [3, 4, 0.6, 3]);
  critical.remove(1, 2);
  assert.deepEqual([...marksOf(Float64Array.of(0.5, 3, 0.6, 3, 0.7, 3), critical)], [0, 1, 0]);
  assert.deepEqual([...marksOf(Float64Array.of(0.5, 3), criticalOf())], [0]);
});

test("gaps end at the next dots", () => {
  const labels = labelsOf(ROWS);
  assert.deepEqual(gapsOf({ ds: 0.7000000000000002, vs: 1.5 }, labels, 4), {
    diagonal: [0.1, 0.7000000000000002],
    vertical: [1.5, Infinity],
  });
  assert.deepEqual(gapsOf({ ds: null, vs: null }, labels, 4), { diagonal: null, vertical: null });
});

test("counts are told in words", () => {
  assert.equal(wordsFor({ cycles: 1 }, 5), "1 cycle in the view, 5 tracks");
  assert.equal(wordsFor({ cycles: 0 }, 1), "0 cycles in the view, 1 track");
  assert.equal(wordsFor({ cycles: 1234 }, null), "1,234 cycles in the view, no tracks");
});

test("a stream with points and without a frame waits for a commit, after a while", () => {
  const stream = (frame, points, vertices) => ({ frame, points, vertices });
  for (const [info, waited] of [
    [stream(0, 0, 0), 9000],
    [stream(0, 25, 25), 500],
    [stream(3, 25, 25), 9000],
  ]) {
    assert.match(waitingFor(info, waited), /^Waiting for the first frame/);
  }
  assert.match(waitingFor(stream(0, 25, 25), 2500), /^25 points wait for a commit.*--frame-every/);
  assert.match(waitingFor(stream(0, 0, 1), 2500), /^1 point waits for a commit/);
});

test("scale bars have round lengths, and coordinates as many digits as can be seen", () => {
  assert.deepEqual([9.9, 5, 4.9, 2, 1.99, 0.07].map(roundLength), [5, 5, 2, 2, 1, 0.05]);
  assert.deepEqual([0, NaN, Infinity].map(roundLength), [0, 0, 0]);
  assert.equal(formatPlace(512345.678912, 250), "512345.679");
  assert.equal(formatPlace(-0.0004, 3), "0.0");
  assert.equal(formatPlace(1234.5, 0.01), "1235");
  assert.equal(formatPlace(1e-30, 1e32), "1.00e-30");
});
