//! Colours: those of the style sheet for canvases, and one for each track.
//!
//! In: the style sheet's custom properties; living tracks.
//! Out: CSS colours, and triples from 0 to 1 for WebGL.
//! Invariants: a track keeps its colour as long as it lives. A new one gets the colour whose tracks are farthest away,
//! so as many tracks as there are colours all differ. Any two colours of a scheme can be told apart, also by the
//! colour-blind, and from the ground (tests/page/colors.test.js has the figures).
//! Must not know: what is drawn.

/** @typedef {{css: string, rgb: [number, number, number]}} Color */

const NAMES = ["ground", "panel", "ink", "muted", "line", "point", "edge", "critical", "diagonal", "vertical"];
/** Colours of tracks on light and on dark ground. */
export const TRACK_COLORS = {
  light: ["#8c418b", "#04a322", "#831c0b", "#c17277", "#2258e5", "#0c6944", "#7a6813", "#a27fce"],
  dark: ["#6357f0", "#d02f14", "#92e8aa", "#137b5e", "#fcb5f9", "#4f99f9", "#b2954a", "#f4428d"],
};
const COUNT = TRACK_COLORS.light.length;
/** Tracks whose colours are remembered at the most. */
const MAX_KNOWN = 8192;

/** The colours of the style sheet. @type {Record<string, Color>} */
export const palette = {};
/** @type {Color[]} */
let trackColors = [];
/** The index of each track's colour, by id, in the order in which they were given. @type {Map<number, number>} */
const known = new Map();

/** Reads the style sheet's colours, which depend on the colour scheme. */
export function readPalette() {
  const style = getComputedStyle(document.documentElement);
  for (const name of NAMES) palette[name] = fromHex(style.getPropertyValue(`--${name}`).trim());
  trackColors = TRACK_COLORS[palette.ground.rgb[0] < 0.5 ? "dark" : "light"].map(fromHex);
  document.documentElement.style.setProperty("--track", trackColors[0].css);
}

/** Forgets all tracks: in another stream their ids are those of other tracks. */
export const forgetColors = () => known.clear();

/** Gives colours to tracks that have none yet. @param {import("../session/tracks.js").Track[]} alive */
export function assignColors(alive) {
  const colored = alive.filter(({ id }) => known.has(id));
  for (const track of alive) {
    if (known.has(track.id)) continue;
    known.set(track.id, freestColor(track, colored));
    colored.push(track);
  }
  if (known.size > MAX_KNOWN) forgetOldest(alive);
}

/** The colour whose nearest track is farthest away; of several that no track has, the first from that of the id on. */
function freestColor({ id, center }, colored) {
  const nearest = new Array(COUNT).fill(Infinity);
  for (const other of colored) {
    const index = known.get(other.id);
    const distance = Math.hypot(...center.map((value, axis) => value - other.center[axis]));
    if (!(distance >= nearest[index])) nearest[index] = distance;
  }
  let best = id % COUNT;
  for (let i = 1; i < COUNT; i++) {
    const index = (id + i) % COUNT;
    if (nearest[index] > nearest[best]) best = index;
  }
  return best;
}

/** Forgets the tracks that got their colours first, but for those that live. */
function forgetOldest(alive) {
  const living = new Set(alive.map(({ id }) => id));
  for (const id of known.keys()) {
    if (known.size <= MAX_KNOWN / 2) return;
    if (!living.has(id)) known.delete(id);
  }
}

/** The index of a track's colour. One that was never seen alive has any. */
export const colorIndexOf = (id) => known.get(id) ?? id % COUNT;

/** The colour of a track. @returns {Color} */
export const colorOf = (id) => trackColors[colorIndexOf(id)];

/** The colour of a track in legends. */
export const sampleColor = () => trackColors[0];

/** A CSS colour with an opacity. @param {Color} color */
export const withAlpha = (color, alpha) =>
  `${color.css}${Math.round(255 * alpha)
    .toString(16)
    .padStart(2, "0")}`;

/** @returns {Color} */
function fromHex(css) {
  return { css, rgb: [1, 3, 5].map((at) => parseInt(css.slice(at, at + 2), 16) / 255) };
}
