//! The page's mirror on what a daemon sends: the frames of a film, and of streams in R^d.
//!
//! HOPES in the environment is the program, else a build in `target`. Without a program the tests are skipped.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { test } from "node:test";

import { BANNER, ReceiveBuffer, readBanner } from "../../src/view/page/session/frames.js";
import { Mirror } from "../../src/view/page/session/mirror.js";
import { readMessage } from "../../src/view/page/session/protocol.js";
import { inFormOfPlane } from "../../src/view/page/session/spaces.js";

/** What only recordings have. */
const ELAPSED = 0x0f01;

const file = (path) => fileURLToPath(new URL(`../../${path}`, import.meta.url));
const program = [process.env.HOPES, file("target/release/hopes"), file("target/debug/hopes")].find(
  (path) => path && existsSync(path),
);

/** The messages for some input, as the program writes them to stdout. */
function messages(input, ...options) {
  const args = ["serve", "--output", "bin", ...options];
  const received = new ReceiveBuffer();
  received.push(
    new Uint8Array(execFileSync(program, args, { input, maxBuffer: 1 << 28, stdio: ["pipe", "pipe", "ignore"] })),
  );
  const version = readBanner(received.rest).highest;
  received.skip(BANNER);
  const all = [];
  for (let frame; (frame = received.next((other) => other === version));) {
    if (frame.type === ELAPSED) continue;
    const { name, body } = readMessage(version, frame.type, frame.body);
    const [plain, plainBody] = inFormOfPlane(name, body);
    all.push({ sent: name, name: plain, body: plainBody });
  }
  return all;
}

/** Applies all frames to a mirror, and checks their counts. Returns their messages. */
function follow(mirror, all) {
  const frames = all.filter(({ name }) => name === "Snapshot" || name === "Diff");
  for (const { name, body } of frames) {
    if (name === "Snapshot") mirror.applySnapshot(body);
    else mirror.applyDiff(body);
    assert.equal(mirror.vertices.count, body.frame.vertices);
    assert.equal(
      mirror.edges.count + mirror.critical.count,
      body.frame.vertices - body.frame.components + body.frame.cycles,
    );
  }
  return frames;
}

/** A mirror of a stream before its first frame, which in a space is of no dimension yet. */
function emptyMirror(space = {}) {
  const [mirror, none] = [new Mirror(), new Float64Array(0)];
  mirror.applySnapshot({ ...space, frame: { number: 0 }, vertices: none, edges: none, critical: none, checksum: 0 });
  return mirror;
}

for (const options of [["--full"], ["--alpha", "8"], ["-k", "2", "-l", "2"]]) {
  test(`every frame of a film is applied and verified, ${options.join(" ")}`, { skip: !program }, () => {
    const input = readFileSync(file("tests/data/bunny.jsonl"));
    const all = messages(input, "--input", "jsonl", "--window", "frames:1", ...options);
    assert.equal(follow(emptyMirror(), all).length, 26);
  });
}

/** Frames of a ring in R^d, each with some points more, as text. */
function ringInSpace(dimension, frames) {
  let state = 1;
  const random = () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
  const point = (_, i) => {
    const angle = 2 * Math.PI * (i / 20 + 0.02 * random());
    return Array.from({ length: dimension }, (_, at) => [Math.cos(angle), Math.sin(angle)][at] ?? 0.1 * random());
  };
  const frame = () => Array.from({ length: 20 }, point).map((row) => row.join(","));
  return Array.from({ length: frames }, () => `${frame().join("\n")}\n`).join("\n");
}

for (const [metric, dimension, ...options] of [
  ["euclidean", 3, "--full"],
  ["manhattan", 1, "--full"],
  ["chebyshev", 7, "-k", "1"],
  ["angular", 20, "--full"],
  ["haversine", 2, "--alpha", "100"],
]) {
  test(`every frame of a stream in R^${dimension}, ${metric}, is applied and verified`, { skip: !program }, () => {
    const mirror = emptyMirror({ metric, dimension: 0 });
    const window = ["--metric", metric, "--window", "frames:2"];
    const all = messages(ringInSpace(dimension, 9), ...window, ...options);
    const frames = follow(mirror, all);
    assert.equal(frames.length, 9);
    assert.ok(frames.every(({ sent }) => sent.startsWith("Space")));
    assert.deepEqual([mirror.dimension, mirror.vertices.count], [dimension, 40]);
  });
}
