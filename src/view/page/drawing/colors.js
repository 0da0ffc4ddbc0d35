//! Colours: those of the style sheet for canvases, and one for each track.
//!
//! In: the style sheet's custom properties; ids of tracks.
//! Out: CSS colours, and triples from 0 to 1 for WebGL.
//! Invariants: a track keeps its colour as long as it lives. The hues of neighbouring ids are far apart; all colours of
//! tracks have about the same lightness.
//! Must not know: what is drawn.

/** @typedef {{css: string, rgb: [number, number, number]}} Color */

const NAMES = ["ground", "ink", "muted", "line", "point", "edge", "critical", "diagonal", "vertical"];
/** The golden angle in degrees: the hues of any number of ids are spread evenly. */
const GOLDEN_ANGLE = 137.50776;
/** Colours of tracks that are cached at the most. */
const MAX_CACHED = 4096;

/** @type {Map<number, Color>} */
const cache = new Map();
/** The colours of the style sheet. @type {Record<string, Color>} */
export const palette = {};
let lightness = 0.6;

/** Reads the style sheet's colours, which depend on the colour scheme. */
export function readPalette() {
  const style = getComputedStyle(document.documentElement);
  for (const name of NAMES) palette[name] = fromHex(style.getPropertyValue(`--${name}`).trim());
  lightness = palette.ground.rgb[0] < 0.5 ? 0.76 : 0.58;
  cache.clear();
}

/** The colour of a track. @returns {Color} */
export function colorOf(id) {
  let color = cache.get(id);
  if (!color) {
    if (cache.size >= MAX_CACHED) cache.clear();
    color = fromRgb(oklch(lightness, 0.145, ((id * GOLDEN_ANGLE + 200) % 360) * (Math.PI / 180)));
    cache.set(id, color);
  }
  return color;
}

/** A CSS colour with an opacity. @param {Color} color */
export const withAlpha = (color, alpha) =>
  `${color.css}${Math.round(255 * alpha)
    .toString(16)
    .padStart(2, "0")}`;

/** @returns {Color} */
function fromHex(css) {
  return { css, rgb: [1, 3, 5].map((at) => parseInt(css.slice(at, at + 2), 16) / 255) };
}

function fromRgb(rgb) {
  const css = `#${rgb
    .map((part) =>
      Math.round(255 * part)
        .toString(16)
        .padStart(2, "0"),
    )
    .join("")}`;
  return { css, rgb };
}

/** A colour of perceptual lightness (Ottosson's Oklab), clipped to sRGB. */
function oklch(light, chroma, hue) {
  const [a, b] = [chroma * Math.cos(hue), chroma * Math.sin(hue)];
  const l = (light + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (light - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (light - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ].map((part) => {
    const cut = Math.min(1, Math.max(0, part));
    return cut <= 0.0031308 ? 12.92 * cut : 1.055 * cut ** (1 / 2.4) - 0.055;
  });
}
