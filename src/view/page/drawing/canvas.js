//! 2D canvases of the panels: a context that is sharp on every screen, and ticks of axes.
//!
//! In: a canvas; the range of an axis.
//! Out: a context in CSS pixels; ticks.
//! Invariants: the bitmap has as many pixels as the screen shows of it.
//! Must not know: what is drawn.

export const FONT = "11px system-ui, sans-serif";

/** A context in CSS pixels, cleared; null while the canvas is not shown. @param {HTMLCanvasElement} canvas */
export function clearedContext(canvas) {
  const { clientWidth: width, clientHeight: height } = canvas;
  if (width === 0 || height === 0) return null;
  const ratio = Math.min(devicePixelRatio || 1, 3);
  const [wide, high] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== wide || canvas.height !== high) [canvas.width, canvas.height] = [wide, high];
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = FONT;
  context.lineWidth = 1;
  return { context, width, height };
}

/** About `wanted` round numbers from 0 to a largest one. */
export function ticks(largest, wanted) {
  const rough = largest / wanted;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find((factor) => factor * power >= rough) * power;
  if (!(step > 0) || !Number.isFinite(step)) return [];
  return Array.from({ length: Math.floor(largest / step + 1e-9) + 1 }, (_, i) => i * step);
}
