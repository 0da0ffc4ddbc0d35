//! The layers of the page: which of its folders may import which, and no circles.

import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { test } from "node:test";

const ROOT = new URL("../../src/view/page/", import.meta.url);
/** The folders from which the modules of a folder may import; the modules at the top may import from all. */
const LAYERS = {
  session: ["session"],
  projection: ["projection", "session"],
  drawing: ["drawing", "projection", "session"],
  panels: ["panels", "drawing", "session"],
};

const modules = readdirSync(ROOT, { recursive: true }).filter((path) => path.endsWith(".js"));
const folderOf = (path) => (path.includes("/") ? path.split("/")[0] : "");

function importsOf(path) {
  const text = readFileSync(new URL(path, ROOT), "utf8");
  const named = [...text.matchAll(/^(?:import|\}) .*from "(.+)";$/gm)].map(([, name]) => name);
  return named.map((name) => new URL(name, new URL(path, ROOT)).href.slice(ROOT.href.length));
}

test("data flows from the session to projection, drawing, panels and the page, and never back", () => {
  for (const path of modules) {
    const allowed = LAYERS[folderOf(path)];
    for (const imported of importsOf(path)) {
      assert.ok(modules.includes(imported), `${path} imports ${imported}, which does not exist`);
      if (allowed) assert.ok(allowed.includes(folderOf(imported)), `${path} must not import ${imported}`);
    }
  }
});

test("no modules import each other in a circle, and main.js reaches all", () => {
  const done = new Set();
  const visit = (path, stack) => {
    assert.ok(!stack.includes(path), `a circle: ${[...stack, path].join(" -> ")}`);
    if (done.has(path)) return;
    for (const imported of importsOf(path)) visit(imported, [...stack, path]);
    done.add(path);
  };
  visit("main.js", []);
  assert.deepEqual([...done].sort(), [...modules].sort());
});
