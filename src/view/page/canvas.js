//! What the small pictures share: a sharp 2D canvas, numbers for people, ticks.
//!
//! In: a canvas, ranges. Out: a context in CSS pixels, words. Invariants: none beyond that. Must not know: what is
//! drawn.

export const FONT = "11px system-ui, sans-serif";

/** A context in CSS pixels, cleared; null while the canvas is not shown. @param {HTMLCanvasElement} canvas */
export function contextOf(canvas) {
  const { clientWidth: width, clientHeight: height } = canvas;
  if (width === 0 || height === 0) return null;
  const ratio = Math.min(devicePixelRatio || 1, 3);
  const [wide, high] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== wide || canvas.height !== high) [canvas.width, canvas.height] = [wide, high];
  const to = canvas.getContext("2d", { willReadFrequently: true });
  to.setTransform(ratio, 0, 0, ratio, 0, 0);
  to.clearRect(0, 0, width, height);
  to.font = FONT;
  to.lineWidth = 1;
  return { to, width, height };
}

/** A number with four digits that count. */
export function short(value) {
  if (value === null || value === undefined) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e6 || size < 1e-4 ? value.toExponential(2) : String(Number(value.toPrecision(4)));
}

/** A whole number with its thousands apart. */
export const whole = (value) => Number(value).toLocaleString("en");

/** Round numbers, about so many of them, from 0 to a largest one. */
export function ticks(largest, wanted) {
  const rough = largest / wanted;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find((factor) => factor * power >= rough) * power;
  if (!(step > 0) || !Number.isFinite(step)) return [];
  return Array.from({ length: Math.floor(largest / step + 1e-9) + 1 }, (_, i) => i * step);
}
