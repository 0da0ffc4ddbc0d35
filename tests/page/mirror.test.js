//! Mirror and history of the page: checksums of the golden vectors, random changes against a plain model, steps back.

import assert from "node:assert/strict";
import { test } from "node:test";

import { readFrame } from "../../src/view/page/session/frames.js";
import { History } from "../../src/view/page/session/history.js";
import { Contradiction, Mirror } from "../../src/view/page/session/mirror.js";
import { readMessage } from "../../src/view/page/session/protocol.js";
import { bytesOf } from "./vectors.js";

const message = (name) => {
  const { type, body } = readFrame(bytesOf("v1", name), () => true);
  return readMessage(1, type, body).body;
};

/** The checksum as the SPEC defines it, in integers of 64 bits. */
function checksumOf({ vertices, edges, critical }) {
  const mask = 2n ** 64n - 1n;
  const bits = (v) => new BigUint64Array(Float64Array.of(v).buffer)[0];
  const h = (...words) =>
    words.reduce((hash, word) => {
      let z = ((hash ^ word) + 0x9e3779b97f4a7c15n) & mask;
      z = ((z ^ (z >> 30n)) * 0xbf58476d1ce4e5b9n) & mask;
      z = ((z ^ (z >> 27n)) * 0x94d049bb133111ebn) & mask;
      return z ^ (z >> 31n);
    }, 0n);
  let sum = 0n;
  for (const [id, x, y] of vertices) sum += h(1n, BigInt(id), bits(x), bits(y));
  for (const [a, b] of edges) sum += h(2n, BigInt(a), BigInt(b));
  for (const [a, b, birth, death] of critical) sum += h(3n, BigInt(a), BigInt(b), bits(birth), bits(death));
  return sum & mask;
}

/** The rows of a mirror, sorted. */
function held(mirror) {
  const rowsOf = ({ rows, width, end }) => {
    const all = [];
    for (let slot = 0; slot < end; slot++) {
      if (rows[slot * width] >= 0) all.push(Array.from(rows.subarray(slot * width, (slot + 1) * width)));
    }
    return all.sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  };
  return { vertices: rowsOf(mirror.vertices), edges: rowsOf(mirror.edges), critical: rowsOf(mirror.critical) };
}

test("the snapshot and the diffs of the vectors are applied and verified", () => {
  const mirror = new Mirror();
  mirror.applySnapshot(message("snapshot"));
  for (const name of ["diff", "diff_onwards"]) {
    mirror.applyDiff(message(name));
    assert.equal(mirror.frame.number, message(name).frame.number);
  }
});

test("a wrong checksum, a gap and an unknown vertex are contradictions", () => {
  const start = () => {
    const mirror = new Mirror();
    mirror.applySnapshot(message("snapshot"));
    return mirror;
  };
  const diff = message("diff");
  assert.throws(() => start().applyDiff({ ...diff, checksum: BigInt(diff.checksum) ^ 1n }), Contradiction);
  assert.throws(() => start().applyDiff({ ...diff, from: diff.from - 1 }), Contradiction);
  assert.throws(() => start().applyDiff({ ...diff, vertices_removed: Float64Array.of(1e6) }), Contradiction);
  assert.throws(() => start().applyDiff({ ...diff, edges_added: message("snapshot").edges }), Contradiction);
});

/** Annotations with these cycles and dots. */
const annotations = (cycles = new Map(), labels = new Float64Array(0)) => ({
  alive: [],
  cycles,
  dots: { labels, isShown: new Uint8Array(0), holes: new Float64Array(0) },
});

/** Pseudorandom numbers from 0 to 1. */
function randomFrom(seed) {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

/** A skeleton that changes at random, as maps. */
class Model {
  constructor(seed) {
    this.random = randomFrom(seed);
    this.vertices = new Map();
    this.edges = new Map();
    this.critical = new Map();
    this.next = 0;
  }

  lists() {
    const sorted = (map) => [...map.values()].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
    return { vertices: sorted(this.vertices), edges: sorted(this.edges), critical: sorted(this.critical) };
  }

  change() {
    const { random } = this;
    for (const id of this.vertices.keys()) if (random() < 0.2) this.vertices.delete(id);
    for (const [id, row] of this.vertices) if (random() < 0.1) this.vertices.set(id, [id, row[1] + random(), -row[2]]);
    // Some ids are above 2^32, as after months of a stream.
    for (let i = 0; i < 40; i++, this.next += random() < 0.1 ? 2 ** 33 : 1) {
      this.vertices.set(this.next, [this.next, random() - 0.5, 1e9 * random()]);
    }
    const ids = [...this.vertices.keys()];
    for (const [map, label] of [
      [this.edges, () => []],
      [this.critical, () => [random(), 1 + random()]],
    ]) {
      for (const [key, [a, b]] of map) {
        if (!this.vertices.has(a) || !this.vertices.has(b) || random() < 0.2) map.delete(key);
      }
      for (let i = 0; i < 30; i++) {
        const [a, b] = [ids[(random() * ids.length) | 0], ids[(random() * ids.length) | 0]].sort((x, y) => x - y);
        if (a !== b && !(map === this.edges && map.has(`${a} ${b}`))) map.set(`${a} ${b}`, [a, b, ...label()]);
      }
    }
  }
}

function diffOf(before, after, number) {
  const byId = (rows) => new Map(rows.map((row) => [row[0], row]));
  const byEnds = (rows) => new Map(rows.map((row) => [`${row[0]} ${row[1]}`, row]));
  const unlike = (rows, others, key) => rows.filter((row) => String(others.get(key(row))) !== String(row));
  const [id, ends] = [(row) => row[0], (row) => `${row[0]} ${row[1]}`];
  const flat = (rows) => Float64Array.from(rows.flat());
  return {
    from: number - 1,
    frame: { number },
    vertices_removed: flat(unlike(before.vertices, byId(after.vertices), id).map((row) => [row[0]])),
    vertices_added: flat(unlike(after.vertices, byId(before.vertices), id)),
    edges_removed: flat(unlike(before.edges, byEnds(after.edges), ends)),
    edges_added: flat(unlike(after.edges, byEnds(before.edges), ends)),
    critical_removed: flat(
      before.critical.filter((row) => !byEnds(after.critical).has(ends(row))).map((row) => row.slice(0, 2)),
    ),
    critical_set: flat(unlike(after.critical, byEnds(before.critical), ends)),
    checksum: checksumOf(after),
  };
}

test("random changes give the rows of a plain model, and steps backward and forward restore them", () => {
  for (const seed of [1, 2, 3]) {
    const [model, mirror, history] = [new Model(seed), new Mirror(), new History()];
    const frames = [model.lists()];
    let moves = [];
    mirror.applySnapshot({
      frame: { number: 0 },
      vertices: new Float64Array(0),
      edges: new Float64Array(0),
      critical: new Float64Array(0),
      checksum: 0,
    });
    history.restart(mirror.frame, annotations());
    for (let number = 1; number <= 60; number++) {
      model.change();
      frames.push(model.lists());
      const diff = diffOf(frames[number - 1], frames[number], number);
      moves.push({ mirror, forward: diff, from: mirror.frame, backward: mirror.applyDiff(diff), to: diff.frame });
      assert.deepEqual(held(mirror), frames[number], `frame ${number}`);
      // Some pictures are several frames after the one before.
      if (number % 3 === 1) continue;
      history.push(diff.frame, moves, annotations());
      moves = [];
    }
    for (const by of [-1, -7, 3, -60, 25, -4, 60]) {
      history.moveBy(by);
      assert.deepEqual(held(mirror), frames[mirror.frame.number], `frame ${mirror.frame.number}`);
    }
    assert.equal(mirror.frame.number, 60);
    assert.deepEqual([history.before, history.after], [40, 0]);
  }
});

test("a vertex that moves keeps its slot", () => {
  const mirror = new Mirror();
  const none = new Float64Array(0);
  const vertices = Float64Array.of(1, 0, 0, 2, 1, 0, 3, 0, 1);
  const snapshot = { frame: { number: 1 }, vertices, edges: none, critical: none };
  const lists = (rows) => ({ vertices: rows, edges: [], critical: [] });
  mirror.applySnapshot({
    ...snapshot,
    checksum: checksumOf(
      lists([
        [1, 0, 0],
        [2, 1, 0],
        [3, 0, 1],
      ]),
    ),
  });
  const slot = mirror.vertices.find(2);
  mirror.applyDiff({
    from: 1,
    frame: { number: 2 },
    vertices_removed: Float64Array.of(1, 2),
    vertices_added: Float64Array.of(2, 5, 5, 4, 1, 1),
    edges_removed: none,
    edges_added: none,
    critical_removed: none,
    critical_set: none,
    checksum: checksumOf(
      lists([
        [2, 5, 5],
        [3, 0, 1],
        [4, 1, 1],
      ]),
    ),
  });
  assert.equal(mirror.vertices.find(2), slot);
  assert.equal(mirror.vertices.find(1), -1);
});

test("history is bounded in bytes, and a snapshot empties it", () => {
  const [history, list] = [new History(), (bytes) => new Float64Array(bytes / 8)];
  history.restart({ number: 0 }, annotations());
  for (let number = 1; number <= 100; number++) {
    const move = { forward: { edges_added: list(1 << 20) }, backward: { edges_removed: list(1 << 20) } };
    history.push({ number }, [move], annotations());
    assert.ok(history.bytes <= 48 << 20);
  }
  assert.equal(history.steps.length, 23);
  history.restart({ number: 101 }, annotations());
  assert.deepEqual([history.before, history.after, history.newest], [0, 0, 101]);
  assert.ok(history.bytes < 1000);
});

test("history counts annotations, but not those that frames share", () => {
  const [history, list] = [new History(), (bytes) => new Float64Array(bytes / 8)];
  const shared = [list(1 << 20)];
  const labels = list(1 << 20);
  history.restart({ number: 0 }, annotations());
  for (let number = 1; number <= 200; number++) {
    const cycles = new Map([
      [1, shared],
      [2, [list(1 << 19)]],
    ]);
    history.push({ number }, [], annotations(cycles, number % 2 ? labels : list(1 << 20)));
    assert.ok(history.bytes <= 50 << 20, `${history.bytes} bytes`);
  }
  const known = history.steps.reduce((sum, step) => sum + step.bytes, 0);
  assert.equal(history.bytes, known);
  assert.ok(history.steps.length > 25 && history.steps.length < 40, `${history.steps.length} frames`);
});

test("a step in an empty history does nothing", () => {
  for (const by of [-1, 1, Infinity]) assert.equal(new History().moveBy(by), null);
});
