//! What the plane is drawn with: the graphics card where there is one, else the processor.
//!
//! In: a canvas. Out: a plane or a sketch of it, with the same words: `draw`, `isBusy`, `seen`, `bounds`. Invariants: a canvas
//! keeps what it is drawn with. Must not know: what is drawn.

import { Plane } from "./plane.js";
import { Sketch } from "./sketch.js";

/** @param {HTMLCanvasElement} canvas @param {import("./camera.js").Camera} camera */
export function painterOf(canvas, camera, labels) {
  const gl = isSoftware()
    ? null
    : canvas.getContext("webgl2", { stencil: true, antialias: true, powerPreference: "high-performance" });
  return gl ? new Plane(canvas, gl, camera, labels) : new Sketch(canvas, camera, labels);
}

/**
 * Whether there is no WebGL, or the processor would draw it too, at a tenth of a sketch's speed. A context cannot be
 * taken back from a canvas, so another one is asked.
 */
function isSoftware() {
  const probe = document.createElement("canvas").getContext("webgl2");
  if (!probe) return true;
  const info = probe.getExtension("WEBGL_debug_renderer_info");
  const name = String(probe.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : probe.RENDERER));
  probe.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}
