//! Projections of clouds in R^d: principal axes, signs, no jump from frame to frame, turning, clouds of low rank.

import assert from "node:assert/strict";
import { test } from "node:test";

import { TracksByLabel, pickCycle } from "../../src/view/page/drawing/picking.js";
import { Bounds } from "../../src/view/page/drawing/bounds.js";
import { eigenvectors, nearestOrthogonal, orthonormalize } from "../../src/view/page/projection/linear.js";
import { Orientation } from "../../src/view/page/projection/orientation.js";
import { Projection, sampleOf } from "../../src/view/page/projection/projection.js";
import { fadeBetween } from "../../src/view/page/projection/vertices.js";
import { Mirror } from "../../src/view/page/session/mirror.js";

/** Pseudorandom numbers from -1 to 1. */
function randomFrom(seed) {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 31 - 1;
  };
}

/** A mirror of points, whose ids are their places in the list. */
function mirrorOf(points, dimension, metric = "Euclidean") {
  const mirror = new Mirror();
  mirror.setSpace(metric, dimension);
  mirror.vertices.clear(points.length);
  points.forEach((point, id) => mirror.vertices.add(Float64Array.of(id, ...point), 0));
  return mirror;
}

const annotations = { alive: [], cycles: new Map(), dots: { holes: new Float64Array(0) } };

/** The projected vertices of a mirror. */
const project = (projection, mirror) =>
  projection.project({ mirror, simplified: new Mirror(), annotations }).mirror.vertices;

/** The position of each vertex with its depth. */
const positionsOf = (vertices) =>
  Array.from({ length: vertices.end }, (_, slot) => [
    ...vertices.rows.slice(3 * slot + 1, 3 * slot + 3),
    ...(vertices.depths ? [vertices.depths[slot]] : []),
  ]);

const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
const axesOf = ({ map: { axes } }) =>
  [0, 1, 2].map((i) => [...axes.slice((i * axes.length) / 3, ((i + 1) * axes.length) / 3)]);
const degrees = (a, b) => (Math.acos(Math.min(1, dot(a, b))) * 180) / Math.PI;
const close = (a, b, within, what) => assert.ok(Math.abs(a - b) <= within, `${what}: ${a} and ${b}`);

function assertOrthonormal(axes, what) {
  axes.forEach((a, i) => axes.forEach((b, j) => close(dot(a, b), i === j ? 1 : 0, 1e-12, `${what}: ${i}, ${j}`)));
}

test("eigenvectors are those of a matrix with known ones, the largest value first", () => {
  const random = randomFrom(3);
  for (let size = 1; size <= 6; size++) {
    const vectors = new Float64Array(size * size).map(random);
    orthonormalize(vectors, size, size);
    const matrix = new Float64Array(size * size);
    for (let k = 0; k < size; k++) {
      for (let i = 0; i < size * size; i++) {
        matrix[i] += (size - k) * vectors[k * size + Math.floor(i / size)] * vectors[k * size + (i % size)];
      }
    }
    const found = eigenvectors(matrix, size);
    for (let k = 0; k < size; k++) {
      const along = dot(found.slice(k * size, (k + 1) * size), vectors.slice(k * size, (k + 1) * size));
      close(Math.abs(along), 1, 1e-12, `vector ${k} of ${size}`);
    }
  }
});

test("missing rank is filled, and the nearest orthogonal matrix of a turned and stretched one is the turn", () => {
  const rows = Float64Array.of(0, 0, 0, 1, 2, 2, 2, 4, 4);
  orthonormalize(rows, 3, 3);
  assertOrthonormal([rows.slice(0, 3), rows.slice(3, 6), rows.slice(6, 9)], "rows of rank 1");
  const alike = Float64Array.of(1, 1, 1, 1, 1, 1 + 1e-7, 1, 1 + 1e-7, 1);
  orthonormalize(alike, 3, 3);
  assertOrthonormal([alike.slice(0, 3), alike.slice(3, 6), alike.slice(6, 9)], "rows that are almost the same");
  const turn = new Orientation();
  turn.turn(120, -70, [0, 0, 0]);
  // A turn times a symmetric positive matrix.
  const stretch = [2, 0.3, 0, 0.3, 1, 0.2, 0, 0.2, 0.5];
  const product = Float64Array.from({ length: 9 }, (_, i) =>
    dot(
      [0, 1, 2].map((k) => turn.matrix[3 * Math.floor(i / 3) + k]),
      [0, 1, 2].map((k) => stretch[3 * k + (i % 3)]),
    ),
  );
  nearestOrthogonal(product).forEach((value, i) => close(value, turn.matrix[i], 1e-12, `entry ${i}`));
  assertOrthonormal(
    [0, 3, 6].map((at) => [...nearestOrthogonal(new Float64Array(9)).slice(at, at + 3)]),
    "of zeros",
  );
});

test("up to two coordinates are shown as they are, without depths, and cannot be turned", () => {
  const projection = new Projection();
  const plane = project(
    projection,
    mirrorOf(
      [
        [3, 4],
        [-1, 1e9],
      ],
      2,
    ),
  );
  assert.deepEqual(positionsOf(plane), [
    [3, 4],
    [-1, 1e9],
  ]);
  assert.deepEqual([projection.canTurn, plane.box], [false, null]);
  const earth = project(projection, mirrorOf([[13.4, 52.5]], 2, "Haversine"));
  assert.deepEqual(positionsOf(earth), [[13.4, 52.5]]);
  const line = project(projection, mirrorOf([[3], [-1], [0.5]], 1));
  assert.deepEqual(positionsOf(line), [
    [3, 0],
    [-1, 0],
    [0.5, 0],
  ]);
  const [left, bottom, right, top] = new Bounds().update(line);
  assert.deepEqual([left, right], [-1, 3]);
  assert.ok(bottom < 0 && top > 0 && top - bottom < 0.2, "the box of a line is flat and not empty");
});

test("a picture of the plane is left as it is", () => {
  const picture = { mirror: new Mirror(), simplified: new Mirror(), annotations };
  const projected = new Projection().project(picture);
  assert.equal(projected.mirror, picture.mirror);
});

test("three coordinates are turned around the centre of the cloud: lengths in space and the box stay", () => {
  const random = randomFrom(5);
  const points = Array.from({ length: 60 }, () => [500 + random(), 40 * random(), 3 * random()]);
  const [projection, mirror] = [new Projection(), mirrorOf(points, 3)];
  const spatial = () => {
    const { component } = projection.orientation;
    const { values } = projection.places[0];
    return points.map((_, slot) =>
      [0, 1, 2].map((row) => component.call(projection.orientation, row, values.slice(3 * slot))),
    );
  };
  const first = project(projection, mirror);
  assert.ok(projection.canTurn);
  const box = [...first.box];
  const start = positionsOf(first);
  for (const [right, down] of [
    [40, 0],
    [0, 55],
    [-300, 20],
    [1, 1],
    [1e5, -1e5],
  ]) {
    projection.turn(right, down);
    const vertices = project(projection, mirror);
    vertices.box.forEach((side, i) => close(side, box[i], 1e-9, "a side of the box"));
    spatial().forEach((place, slot) => {
      assert.deepEqual([...vertices.rows.slice(3 * slot + 1, 3 * slot + 3)], place.slice(0, 2));
      assert.ok(place[0] >= box[0] - 1e-9 && place[0] <= box[2] + 1e-9, "a point is outside of the box");
    });
    const [a, b] = [spatial()[3], spatial()[40]];
    close(
      Math.hypot(...a.map((x, i) => x - b[i])),
      Math.hypot(...points[3].map((x, i) => x - points[40][i])),
      1e-9,
      "length",
    );
  }
  projection.turnBack();
  positionsOf(project(projection, mirror)).forEach((position, i) =>
    close(position[0], start[i][0], 1e-9, "turned back"),
  );
});

test("what is near follows the pointer, and is less pale", () => {
  const [projection, mirror] = [
    new Projection(),
    mirrorOf(
      [
        [0, 0, 0, 1],
        [0, 0, 0, -1],
        [3, 0, 0, 0],
        [-3, 0, 0, 0],
        [0, 2, 0, 0],
        [0, -2, 0, 0],
      ],
      4,
    ),
  ];
  const before = positionsOf(project(projection, mirror));
  const near = before.findIndex(([, , depth], i) => i < 2 && depth > 0.5);
  projection.turn(10, 0);
  const turned = positionsOf(project(projection, mirror));
  assert.ok(turned[near][0] > before[near][0] && turned[1 - near][0] < before[1 - near][0]);
  projection.turn(-10, 10);
  assert.ok(positionsOf(project(projection, mirror))[near][1] < before[near][1], "downwards");
  const vertices = project(projection, mirror);
  assert.ok(fadeBetween(vertices, near, near) > fadeBetween(vertices, 1 - near, 1 - near) + 0.1);
  assert.equal(fadeBetween({ depths: null }, 0, 1), 1);
});

/** A cloud around known axes of R^d with known extents, and the rest of it noise. */
function cloud(count, dimension, extents, random, noise = 0.05) {
  const frame = new Float64Array(extents.length * dimension).map(randomFrom(11));
  orthonormalize(frame, extents.length, dimension);
  const rows = extents.map((_, i) => frame.slice(i * dimension, (i + 1) * dimension));
  const point = () => {
    const factors = extents.map((extent) => extent * random());
    return Array.from(
      { length: dimension },
      (_, at) =>
        7 +
        noise * random() +
        dot(
          factors,
          rows.map((row) => row[at]),
        ),
    );
  };
  return { rows, point, points: Array.from({ length: count }, point) };
}

for (const dimension of [4, 20, 41, 300]) {
  test(`the first axes are the principal components, the largest loading positive, in R^${dimension}`, () => {
    const { rows, points } = cloud(2000, dimension, [9, 5, 2], randomFrom(7), dimension > 4 ? 0.05 : 0.2);
    const [projection, mirror] = [new Projection(), mirrorOf(points, dimension)];
    project(projection, mirror);
    const axes = axesOf(projection);
    assertOrthonormal(axes, "axes");
    axes.forEach((axis, i) => {
      assert.ok(Math.abs(dot(axis, rows[i])) > 0.995, `axis ${i} is ${dot(axis, rows[i])} along the known one`);
      const largest = axis.reduce((best, x) => (Math.abs(x) > Math.abs(best) ? x : best), 0);
      assert.ok(largest > 0, `the largest loading of axis ${i} is ${largest}`);
    });
    const again = new Projection();
    project(again, mirror);
    assert.deepEqual(axesOf(again), axes, "the same cloud has the same axes");
  });
}

test("components that are about equally strong are uncorrelated, the strongest first", () => {
  const { points } = cloud(2000, 60, [3, 2.95, 2.9, 2.85], randomFrom(23));
  const projection = new Projection();
  project(projection, mirrorOf(points, 60));
  const places = points.map((point) => axesOf(projection).map((axis) => dot(axis, point)));
  const mean = [0, 1, 2].map((i) => places.reduce((sum, place) => sum + place[i], 0) / places.length);
  const product = (i, j) => places.reduce((sum, place) => sum + (place[i] - mean[i]) * (place[j] - mean[j]), 0);
  assert.ok(product(0, 0) > product(1, 1) && product(1, 1) > product(2, 2), "the strongest first");
  for (const [i, j] of [
    [0, 1],
    [0, 2],
    [1, 2],
  ]) {
    close(product(i, j) / product(0, 0), 0, 1e-9, `components ${i} and ${j}`);
  }
});

/** Replaces some of the vertices by new ones, the oldest first. */
function replace(mirror, count, point, state) {
  for (let i = 0; i < count; i++) {
    mirror.vertices.remove(state.oldest++);
    mirror.vertices.add(Float64Array.of(state.next++, ...point()), 0);
  }
}

// The extents of the last but one are equal, so that its components are anything: a cloud like a ball.
for (const [dimension, extents, most] of [
  [4, [3, 2, 1], 3],
  [20, [3, 2.9, 2.8], 3],
  [20, [1, 1, 1, 1, 1, 1, 1, 1], 3.5],
  [100, [3, 2, 1], 3],
]) {
  test(`no axis jumps while 5% of the points are replaced in each frame, extents ${extents} in R^${dimension}`, () => {
    const { points, point } = cloud(400, dimension, extents, randomFrom(13));
    const [projection, mirror] = [new Projection(), mirrorOf(points, dimension)];
    const state = { oldest: 0, next: points.length };
    let before = null;
    for (let number = 0; number < 60; number++) {
      const kept = positionsOf(project(projection, mirror));
      const axes = axesOf(projection);
      assertOrthonormal(axes, `frame ${number}`);
      axes.forEach((axis, i) => {
        const angle = before ? degrees(axis, before[i]) : 0;
        assert.ok(angle < most, `axis ${i} turns by ${angle.toFixed(1)} degrees in frame ${number}`);
      });
      before = axes;
      const { offset } = projection.map;
      const slotOfOldest = mirror.vertices.find(state.oldest);
      const vector = mirror.vertices.rows.slice(
        (dimension + 1) * slotOfOldest + 1,
        (dimension + 1) * (slotOfOldest + 1),
      );
      const place = projection.places[0].values.slice(3 * slotOfOldest, 3 * slotOfOldest + 3);
      place.forEach((value, i) => close(value, dot(axes[i], vector) + offset[i], 1e-9, "a place by the newest axes"));
      replace(mirror, 20, point, state);
      // Points that stay move by little: the picture is turned around its centre.
      const slot = mirror.vertices.find(state.oldest);
      const now = positionsOf(project(projection, mirror))[slot];
      const moved = Math.hypot(now[0] - kept[slot][0], now[1] - kept[slot][1]);
      const reach = projection.places[0].radius;
      assert.ok(moved < 0.2 * reach, `a point that stays moves by ${moved} of ${reach} in frame ${number}`);
    }
  });
}

test("a cloud that grows in other directions gets other axes", () => {
  const random = randomFrom(17);
  const at = (axis, extent) => Array.from({ length: 8 }, (_, i) => (i === axis ? extent * random() : 0.001 * random()));
  const points = Array.from({ length: 90 }, (_, i) => at(i % 3, 1));
  const [projection, mirror] = [new Projection(), mirrorOf(points, 8)];
  project(projection, mirror);
  const state = { oldest: 0, next: 90 };
  for (let number = 0; number < 12; number++) {
    replace(mirror, 15, () => at(3 + (state.next % 3), 5), state);
    project(projection, mirror);
  }
  const captured = axesOf(projection).reduce((sum, axis) => sum + dot(axis.slice(3, 6), axis.slice(3, 6)), 0);
  close(captured, 3, 0.01, "the axes span the three new directions");
});

test("clouds without extent or of low rank are shown, and their next frames do not jump", () => {
  const line = Array.from({ length: 20 }, (_, i) => [i, 2 * i, -i, 0, 3 * i]);
  for (const [name, points] of [
    ["no points", []],
    ["a point", [[1, 2, 3, 4, 5]]],
    [
      "two points",
      [
        [1, 2, 3, 4, 5],
        [1, 2, 3, 4, 9],
      ],
    ],
    ["equal points", Array.from({ length: 9 }, () => [1, 2, 3, 4, 5])],
    ["points on a line", line],
    [
      "huge points",
      [
        [1e308, -1e308, 0, 0, 0],
        [-1e308, 1e308, 0, 0, 0],
        [0, 0, 1e308, 0, 0],
      ],
    ],
    [
      "tiny points",
      [
        [1e-320, 0, 0, 0, 0],
        [0, 1e-320, 0, 0, 0],
      ],
    ],
  ]) {
    const [projection, mirror] = [new Projection(), mirrorOf(points, 5)];
    const first = positionsOf(project(projection, mirror));
    assert.equal(first.length, points.length, name);
    if (!/huge/.test(name)) assert.ok(first.flat().every(Number.isFinite), `${name}: ${first}`);
    const axes = projection.map.axes;
    if (!axes) continue;
    assertOrthonormal(axesOf(projection), name);
    mirror.vertices.add(Float64Array.of(1000, ...(points[0] ?? [])), 0);
    project(projection, mirror);
    axesOf(projection).forEach((axis, i) => assert.ok(degrees(axis, [...axes.slice(5 * i, 5 * i + 5)]) < 15, name));
  }
  const [projection, mirror] = [new Projection(), mirrorOf(line, 5)];
  const shown = positionsOf(project(projection, mirror));
  const length = Math.hypot(shown[19][0] - shown[0][0], shown[19][1] - shown[0][1]);
  close(length, 19 * Math.sqrt(15), 1e-9, "a line lies in the plane of the screen");
  for (const [, y] of shown) close(y, shown[0][1], 1e-9, "and is level");
});

test("vectors that are compared by angles are shown at length 1", () => {
  const projection = new Projection();
  const mirror = mirrorOf(
    [
      [3, 0, 0, 4],
      [0, 1e-300, 0, 0],
      [1e300, 1e300, 0, 0],
      [0, 0, 0, 0],
    ],
    4,
    "Angular",
  );
  project(projection, mirror);
  const { values, radius } = projection.places[0];
  assert.ok(radius <= 1 && values.every(Number.isFinite), `${radius}`);
  const pair = new Projection();
  const twice = mirrorOf(
    [
      [3, 0, 0, 4],
      [0.3, 0, 0, 0.4],
      [1, 1, 0, 0],
    ],
    4,
    "Angular",
  );
  const [a, b] = positionsOf(project(pair, twice));
  a.forEach((x, i) => close(x, b[i], 1e-12, "a vector and a multiple of it"));
});

test("in R^4096 work is bounded, and places are computed again only where something has changed", () => {
  const { points, point } = cloud(300, 4096, [9, 5, 2], randomFrom(19), 0.01);
  const [projection, mirror] = [new Projection(), mirrorOf(points, 4096)];
  project(projection, mirror);
  const { map } = projection;
  const computed = [];
  const { compute } = projection.places[0];
  projection.places[0].compute = function (vertices, slot, ...more) {
    computed.push(slot);
    compute.call(this, vertices, slot, ...more);
  };
  replace(mirror, 15, point, { oldest: 0, next: 300 });
  project(projection, mirror);
  assert.equal(projection.map, map, "axes that turn by little stay");
  assert.equal(computed.length, 15);
  projection.turn(30, 30);
  project(projection, mirror);
  const after = computed.length;
  project(projection, mirror);
  assert.equal(computed.length, after, "turning computes no place");
});

test("a sample is spread over the cloud, and axes of samples are averaged over frames", () => {
  const random = randomFrom(29);
  let next = 0;
  // The first coordinate grows with the id, and the others are noise.
  const point = () => Array.from({ length: 4096 }, (_, i) => (i === 0 ? next++ / 300 : 0.1 * random()));
  const mirror = mirrorOf(Array.from({ length: 300 }, point), 4096);
  const { mean, count, isWhole } = sampleOf(mirror.vertices, false);
  assert.ok(count > 40 && count <= 64 && !isWhole, `${count} of the sample`);
  close(mean[0], 0.5, 0.15, "the mean of the sample");
  const projection = new Projection();
  const state = { oldest: 0, next: 300 };
  const turns = [];
  for (let number = 0; number < 8; number++) {
    const before = projection.principal?.axes;
    project(projection, mirror);
    const { axes } = projection.principal;
    const turned = (from) => degrees(axes.slice(from, from + 4096), before.slice(from, from + 4096));
    if (before) turns.push(Math.max(turned(0), turned(4096), turned(8192)));
    replace(mirror, 15, point, state);
  }
  assert.ok(Math.max(...turns) < 3.5, `axes turn by ${turns} degrees`);
  assert.ok(turns.reduce((sum, turn) => sum + turn) / 7 < 2.9, `axes turn by ${turns} degrees`);
});

test("the space of another stream begins with other axes", () => {
  const projection = new Projection();
  project(projection, mirrorOf(cloud(50, 6, [3, 2, 1], randomFrom(1)).points, 6));
  assert.equal(projection.map.axes.length, 18);
  project(projection, mirrorOf(cloud(50, 9, [3, 2, 1], randomFrom(1)).points, 9));
  assert.equal(projection.map.axes.length, 27);
  project(projection, mirrorOf([[1, 2, 3]], 3));
  assert.equal(projection.map.axes, null);
  assert.ok(projection.canTurn);
  projection.project({ mirror: new Mirror(), simplified: new Mirror(), annotations });
  assert.equal(projection.canTurn, false);
});

test("the loop of a track is picked near its lines, as it is turned, and not inside", () => {
  const points = [
    [0, 0, 0],
    [10, 0, 0],
    [10, 0, 10],
    [0, 0, 10],
  ];
  const [projection, mirror] = [new Projection(), mirrorOf(points, 3)];
  const track = { id: 5, birth: 1, death: Infinity, area: null };
  const loops = { ...annotations, alive: [track], cycles: new Map([[5, [Float64Array.of(0, 1, 2, 3)]]]) };
  const pickAt = (x, y) => {
    const picture = projection.project({ mirror, simplified: new Mirror(), annotations: loops });
    return pickCycle(picture.mirror, picture.annotations, new TracksByLabel(), x, y, 0.5)?.track ?? null;
  };
  for (const [right, down] of [
    [0, 0],
    [80, 0],
    [13, -60],
  ]) {
    projection.turn(right, down);
    const places = positionsOf(project(projection, mirror));
    const middle = (a, b) => [(places[a][0] + places[b][0]) / 2, (places[a][1] + places[b][1]) / 2];
    assert.equal(pickAt(...middle(0, 1)), 5);
    assert.equal(pickAt(...middle(3, 0)), 5, "the line that closes the loop");
    assert.equal(pickAt(...middle(0, 2)), null, "the middle of the loop");
  }
});
