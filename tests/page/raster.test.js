//! The software renderer's raster: dots and lines, also those that are partly or wholly outside.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Raster, packColor } from "../../src/view/page/drawing/raster.js";

const [WIDTH, HEIGHT] = [40, 30];

function empty() {
  const raster = new Raster();
  raster.reset(WIDTH, HEIGHT);
  return raster;
}

const drawn = ({ words }) =>
  [...words.keys()].filter((at) => words[at] !== 0).map((at) => [at % WIDTH, Math.floor(at / WIDTH)]);

/** Pseudorandom numbers from 0 to 1. */
function* numbers(seed = 1) {
  for (let state = seed; ; ) {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    yield state / 2 ** 32;
  }
}

test("a packed colour has its bytes in the order of an image", () => {
  const bytes = new Uint8Array(Uint32Array.of(packColor([1, 0.5, 0], 0.25)).buffer);
  assert.deepEqual([...bytes], [255, 128, 0, 64]);
});

test("a line is one pixel wide, has no gaps, reaches both ends, and is clipped at the border", () => {
  const from = numbers();
  const next = () => (from.next().value - 0.25) * 2 * WIDTH;
  for (let round = 0; round < 2000; round++) {
    const raster = empty();
    const [ax, ay, bx, by] = [next(), next(), next(), next()];
    raster.line(ax, ay, bx, by, 7);
    const pixels = drawn(raster);
    const [x, y] = [bx - ax, by - ay];
    const isSteep = Math.abs(y) > Math.abs(x);
    for (const [left, top] of pixels) {
      const off = Math.abs((left + 0.5 - ax) * y - (top + 0.5 - ay) * x) / Math.hypot(x, y);
      assert.ok(off < 1, `pixel ${left}, ${top} is ${off} off the line`);
    }
    // The rows or columns that the line crosses inside.
    const steps = 20_000;
    const places = new Set();
    for (let i = 0; i <= steps; i++) {
      const [px, py] = [ax + (x * i) / steps, ay + (y * i) / steps];
      if (px >= 0 && py >= 0 && px < WIDTH && py < HEIGHT) places.add(Math.floor(isSteep ? py : px));
    }
    const reached = new Set(pixels.map(([left, top]) => (isSteep ? top : left)));
    assert.ok(Math.abs(reached.size - places.size) <= 1, `${reached.size} of ${places.size}: ${[ax, ay, bx, by]}`);
  }
});

test("lines and dots that are far away or not finite draw nothing", () => {
  for (const far of [1e9, -1e9, 1e300, -1e300, Infinity, -Infinity, NaN]) {
    const raster = empty();
    raster.setDotSize(4);
    raster.dot(far, 5, 7);
    raster.dot(5, far, 7);
    raster.line(far, far, far, far, 7);
    raster.line(far, -5, far, HEIGHT + 5, 7);
    assert.deepEqual(drawn(raster), [], `${far}`);
  }
  const raster = empty();
  raster.line(-1e12, 10.5, 1e12, 10.5, 7);
  assert.deepEqual(
    drawn(raster),
    Array.from({ length: WIDTH }, (_, x) => [x, 10]),
  );
});

test("a dot is round, has its size, and is clipped at the border", () => {
  for (const size of [1.25, 2, 3, 4.5]) {
    const raster = empty();
    raster.setDotSize(size);
    raster.dot(20.5, 15.5, 7);
    const whole = drawn(raster);
    assert.ok(whole.every(([x, y]) => Math.hypot(x - 20, y - 15) <= size / 2));
    assert.equal(whole.length, { 1.25: 1, 2: 5, 3: 9, 4.5: 21 }[size], `of size ${size}`);
    const cut = empty();
    cut.setDotSize(size);
    cut.dot(0.5, 15.5, 7);
    assert.deepEqual(
      drawn(cut),
      whole.map(([x, y]) => [x - 20, y]).filter(([x]) => x >= 0),
    );
  }
});
