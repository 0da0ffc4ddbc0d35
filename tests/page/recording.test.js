//! The page's mirror on what a daemon sends: the frames of a film.
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

const file = (path) => fileURLToPath(new URL(`../../${path}`, import.meta.url));
const program = [process.env.HOPES, file("target/release/hopes"), file("target/debug/hopes")].find(
  (path) => path && existsSync(path),
);

/** The messages of the film in a view, as the program writes them to stdout. */
function messages(...options) {
  const input = readFileSync(file("tests/data/bunny.jsonl"));
  const args = ["serve", "--input", "jsonl", "--window", "frames:1", "--output", "bin", ...options];
  const received = new ReceiveBuffer();
  received.push(
    new Uint8Array(execFileSync(program, args, { input, maxBuffer: 1 << 28, stdio: ["pipe", "pipe", "ignore"] })),
  );
  const version = readBanner(received.rest).highest;
  received.skip(BANNER);
  const all = [];
  for (let frame; (frame = received.next((other) => other === version));) {
    // 0x0f01 is Elapsed, which only recordings have.
    if (frame.type !== 0x0f01) all.push(readMessage(version, frame.type, frame.body));
  }
  return all;
}

for (const options of [["--full"], ["--alpha", "8"], ["-k", "2", "-l", "2"]]) {
  test(`every frame of a film is applied and verified, ${options.join(" ")}`, { skip: !program }, () => {
    const mirror = new Mirror();
    mirror.applySnapshot({
      frame: { number: 0 },
      vertices: new Float64Array(0),
      edges: new Float64Array(0),
      critical: new Float64Array(0),
      checksum: 0,
    });
    let frames = 0;
    for (const { name, body } of messages(...options)) {
      if (name === "Snapshot") mirror.applySnapshot(body);
      if (name === "Diff") mirror.applyDiff(body);
      if (name !== "Snapshot" && name !== "Diff") continue;
      frames += 1;
      assert.equal(mirror.vertices.count, body.frame.vertices);
      assert.equal(
        mirror.edges.count + mirror.critical.count,
        body.frame.vertices - body.frame.components + body.frame.cycles,
      );
    }
    assert.equal(frames, 26);
  });
}
