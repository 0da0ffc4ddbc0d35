//! Colours of page and pictures: told apart also by the colour-blind, clear on their ground, the same in both.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { TRACK_COLORS, assignColors, colorIndexOf, forgetColors } from "../../src/view/page/drawing/colors.js";
import { KINDS, ciede2000, contrast, difference } from "./color_vision.js";

const read = (path) => readFileSync(new URL(`../../${path}`, import.meta.url), "utf8");

/** The style sheet's colours, light and dark. */
const [light, dark] = (() => {
  const [, first, second] = read("src/view/page/style.css").split(":root {");
  const colors = (text) => {
    const found = text.split("}")[0].matchAll(/--([a-z]+): (#[0-9a-f]{6});/g);
    return Object.fromEntries([...found].map(([, name, hex]) => [name, hex]));
  };
  return [colors(first), colors(second)];
})();

test("differences are those of the published examples", () => {
  // Sharma, Wu and Dalal 2005, Table 1: pairs 1, 7, 13, 17, 25.
  const pairs = [
    [[50, 2.6772, -79.7751], [50, 0, -82.7485], 2.0425],
    [[50, 0, 0], [50, -1, 2], 2.3669],
    [[50, 2.49, -0.001], [50, -2.49, 0.0011], 7.2195],
    [[50, 2.5, 0], [73, 25, -18], 27.1492],
    [[60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644],
  ];
  for (const [one, other, expected] of pairs) assert.ok(Math.abs(ciede2000(one, other) - expected) < 1e-4, expected);
});

/** The smallest difference of any two of some colours, for one kind of vision. */
function smallest(colors, kind) {
  const pairs = colors.flatMap((one, i) => colors.slice(0, i).map((other) => difference(one, other, kind)));
  return Math.min(...pairs);
}

for (const scheme of ["light", "dark"]) {
  test(`any two colours of tracks are told apart, ${scheme}`, (t) => {
    const figures = KINDS.map((kind) => [kind, smallest(TRACK_COLORS[scheme], kind)]);
    t.diagnostic(`smallest CIEDE2000: ${figures.map(([kind, least]) => `${kind} ${least.toFixed(1)}`).join(", ")}`);
    for (const [kind, least] of figures) assert.ok(least >= (kind === "normal" ? 20 : 11), `${kind}: ${least}`);
  });

  test(`what is drawn is clear on its ground, ${scheme}`, () => {
    const style = scheme === "light" ? light : dark;
    const names = ["point", "edge", "critical", "diagonal", "vertical", "muted", "ink", "accent", "good", "bad"];
    const colors = [...names.map((name) => style[name]), ...TRACK_COLORS[scheme]];
    for (const color of colors) {
      for (const ground of [style.panel, style.ground]) {
        assert.ok(contrast(color, ground) >= 3, `${color} on ${ground}: ${contrast(color, ground).toFixed(2)}`);
      }
    }
  });
}

test("pictures and page have the same colours", () => {
  const rust = read("src/formats/picture/canvas/colors.rs");
  const constants = [...rust.matchAll(/pub const ([A-Z]+): &str = "(#[0-9a-f]{6})";/g)];
  const shared = constants.filter(([, name]) => name.toLowerCase() in light);
  for (const [, name, hex] of shared) assert.equal(hex, light[name.toLowerCase()], name);
  const names = shared.map(([, name]) => name.toLowerCase()).sort();
  assert.deepEqual(names, ["diagonal", "edge", "ground", "ink", "muted", "panel", "point", "vertical"]);
  // The most persistent cycle of a picture.
  const stops = [...read("src/formats/picture/canvas/ramp.rs").matchAll(/^ {4}Rgb\(\[(.*)\]\),$/gm)];
  const last = stops[stops.length - 1][1].split(", ").map((part) => part.slice(2));
  assert.equal(`#${last.join("")}`, light.critical);
});

const track = (id, x, y) => ({ id, center: [x, y] });

test("a track keeps its colour, and as many tracks as there are colours all differ", () => {
  forgetColors();
  const count = TRACK_COLORS.light.length;
  const alive = Array.from({ length: count }, (_, i) => track(3 * i, i % 3, i));
  assignColors(alive.slice(0, 5));
  const first = alive.slice(0, 5).map(({ id }) => colorIndexOf(id));
  assignColors(alive);
  assert.deepEqual(alive.slice(0, 5).map(({ id }) => colorIndexOf(id)), first);
  assert.equal(new Set(alive.map(({ id }) => colorIndexOf(id))).size, count);
  // One of them ends: the next track takes its colour.
  const ended = alive.splice(4, 1)[0];
  assignColors([...alive, track(1000, 50, 50)]);
  assert.equal(colorIndexOf(1000), colorIndexOf(ended.id));
});

test("among many tracks neighbours differ", () => {
  forgetColors();
  const alive = Array.from({ length: 400 }, (_, i) => track(i + 1, i % 20, Math.floor(i / 20)));
  assignColors(alive);
  for (const { id, center } of alive) {
    const distance = (other) => Math.hypot(other.center[0] - center[0], other.center[1] - center[1]);
    const near = alive.filter((other) => other.id !== id && distance(other) < 1.1);
    for (const other of near) assert.notEqual(colorIndexOf(other.id), colorIndexOf(id), `${id} and ${other.id}`);
  }
});

test("the memory of colours is bounded", () => {
  forgetColors();
  for (let id = 0; id < 30_000; id += 10) {
    const alive = Array.from({ length: 10 }, (_, i) => track(id + i, i, 0));
    assignColors(alive);
    assert.equal(new Set(alive.map((one) => colorIndexOf(one.id))).size, Math.min(10, TRACK_COLORS.light.length));
  }
});
