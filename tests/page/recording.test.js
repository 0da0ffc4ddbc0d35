//! The page's mirror and tracks on a real daemon's messages: the frames of a film, made by the program.
//!
//! The program is HOPES in the environment, else a build in `target`. The test is skipped if there is none.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { test } from "node:test";

import { BANNER, Inbox, readBanner } from "../../src/view/page/frames.js";
import { Mirror } from "../../src/view/page/mirror.js";
import { readMessage } from "../../src/view/page/protocol.js";

const file = (path) => fileURLToPath(new URL(`../../${path}`, import.meta.url));
const program = [process.env.HOPES, file("target/release/hopes"), file("target/debug/hopes")].find(
  (path) => path && existsSync(path),
);

/** The messages of the film in a view, as the program writes them. */
function messages(...options) {
  const input = readFileSync(file("tests/data/bunny.jsonl"));
  const args = ["serve", "--input", "jsonl", "--window", "frames:1", "--output", "bin", ...options];
  const inbox = new Inbox();
  inbox.push(
    new Uint8Array(execFileSync(program, args, { input, maxBuffer: 1 << 28, stdio: ["pipe", "pipe", "ignore"] })),
  );
  const version = readBanner(inbox.rest).highest;
  inbox.skip(BANNER);
  const all = [];
  for (let frame; (frame = inbox.next((other) => other === version));) {
    // Elapsed is only in recordings.
    if (frame.type !== 0x0f01) all.push(readMessage(version, frame.type, frame.body));
  }
  return all;
}

for (const options of [["--full"], ["--alpha", "8"], ["-k", "2", "-l", "2"]]) {
  test(`every frame of a film is followed and proved, ${options.join(" ")}`, { skip: !program }, () => {
    const mirror = new Mirror();
    mirror.takeSnapshot({
      frame: { number: 0 },
      vertices: new Float64Array(0),
      edges: new Float64Array(0),
      critical: new Float64Array(0),
      checksum: 0,
    });
    let frames = 0;
    for (const { name, body } of messages(...options)) {
      if (name === "Snapshot") mirror.takeSnapshot(body);
      if (name === "Diff") mirror.takeDiff(body);
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
