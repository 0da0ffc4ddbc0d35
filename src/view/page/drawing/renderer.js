//! The renderer of the plane: WebGL2 where there is a graphics card, else the processor.
//!
//! In: a canvas.
//! Out: one of two renderers with the same interface: `draw`, `isBusy`, `visibleFrame`, `bounds`, `holes`.
//! Invariants: a canvas keeps its renderer.
//! Must not know: what is drawn.

import { SoftwareRenderer } from "./software_renderer.js";
import { WebglRenderer } from "./webgl_renderer.js";

/**
 * What is drawn: skeleton, simplified skeleton and annotations of one frame.
 * @typedef {{mirror: import("../session/mirror.js").Mirror, simplified: import("../session/mirror.js").Mirror,
 *   annotations: import("../session/history.js").Annotations}} Picture
 */

/**
 * @param {HTMLCanvasElement} canvas @param {import("./camera.js").Camera} camera
 * @param {import("./picking.js").TracksByLabel} tracksByLabel
 */
export function createRenderer(canvas, camera, tracksByLabel) {
  const gl = isSoftware()
    ? null
    : canvas.getContext("webgl2", { stencil: true, antialias: true, powerPreference: "high-performance" });
  return gl
    ? new WebglRenderer(canvas, gl, camera, tracksByLabel)
    : new SoftwareRenderer(canvas, camera, tracksByLabel);
}

/**
 * Whether there is no WebGL, or one that the processor emulates at a tenth of the software renderer's speed. The probe
 * uses a canvas of its own, since a canvas never gives up a context.
 */
function isSoftware() {
  const probe = document.createElement("canvas").getContext("webgl2");
  if (!probe) return true;
  const info = probe.getExtension("WEBGL_debug_renderer_info");
  const name = String(probe.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : probe.RENDERER));
  probe.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}
