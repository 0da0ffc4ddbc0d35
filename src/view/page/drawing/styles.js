//! Styles of cycles, shared by both renderers: which are drawn, in which order, and how.
//!
//! In: a mirror and its annotations, the picked cycle.
//! Out: holes, outlines and critical edges with colours, opacities, and half their widths in pixels. A hole that is no
//! track, whose boundary is not known, is a circle. In a space holes are neither filled nor circles: cycles are loops.
//! Invariants: a track has one colour everywhere.
//! Must not know: cameras, canvases.

import { HOLE } from "../session/dots.js";
import { colorOf, palette } from "./colors.js";
import { isPicked } from "./picking.js";

/** Holes that are filled at the most. */
const MAX_HOLES = 1500;
/** Up to so many critical edges are all drawn thick. */
const MAX_THICK = 200;
/** How much wider the loop of a cycle is than the outline of a hole, which is filled. */
const LOOP_WIDTH = 2;
/** Corners of the polygon that is drawn for a circle. */
export const CORNERS = 48;

/** The diameter of a point, for a mean spacing of points in pixels. */
export const pointSize = (spacing) => Math.min(4.5, Math.max(1.25, 0.35 * spacing));

/** Half the width of the simplified skeleton, in pixels. */
export const SIMPLIFIED_WIDTH = 1.5;
/** The opacity of tree edges, also under a simplified skeleton. */
export const treeOpacity = ({ simplified }) => (simplified === null ? 1 : 0.45);

/** The tracks whose holes are filled, the largest first. */
export function filledHoles({ alive, cycles }) {
  return alive
    .filter((track) => track.area !== null && cycles.get(track.id)?.length)
    .sort((a, b) => b.area - a.area)
    .slice(0, MAX_HOLES);
}

/** The opacity of a filled hole. */
export const fillOpacity = (track, pick) => (isPicked(pick, track.id) ? 0.5 : track.selected ? 0.26 : 0.1);

/** The outlines of holes: walks of tracks, and circles of the view's cycles that are no tracks. */
export function outlinesOf({ alive, cycles, dots }, tracksByLabel, pick) {
  const ofTracks = alive.flatMap((track) => {
    const wider = track.area === null ? LOOP_WIDTH : 1;
    const [alpha, width] = isPicked(pick, track.id) ? [1, 1.3 * wider] : [track.selected ? 0.8 : 0.3, 0.65 * wider];
    const style = { color: colorOf(track.id), alpha, width, circle: null };
    return (cycles.get(track.id) ?? []).map((walk) => ({ ...style, walk, length: walk.length }));
  });
  const ofOthers = [];
  for (let at = 0; at < dots.holes.length; at += HOLE) {
    const [birth, death, x, y, radius] = dots.holes.subarray(at, at + HOLE);
    if (tracksByLabel.find(birth, death)) continue;
    const [alpha, width] = isPicked(pick, null, birth, death) ? [1, 1.3] : [0.7, 0.65];
    const style = { color: palette.critical, alpha, width, walk: null };
    ofOthers.push({ ...style, circle: { x, y, radius }, length: CORNERS });
  }
  return [...ofTracks, ...ofOthers];
}

/**
 * Calls `draw` for each critical edge. Those of tracks are thick. The others, where there are many, are thin, and pale
 * if their persistence is small.
 */
export function forCriticalEdges({ rows, end, count }, tracksByLabel, pick, draw) {
  let largest = 0;
  for (let at = 0; at < 4 * end; at += 4) {
    const persistence = rows[at + 3] - rows[at + 2];
    if (rows[at] >= 0 && persistence < Infinity) largest = Math.max(largest, persistence);
  }
  for (let at = 0; at < 4 * end; at += 4) {
    if (rows[at] < 0) continue;
    const [birth, death] = [rows[at + 2], rows[at + 3]];
    const track = tracksByLabel.find(birth, death);
    const color = track ? colorOf(track.id) : palette.critical;
    const isThick = track !== null || count <= MAX_THICK;
    const alpha = isThick ? 1 : 0.25 + 0.75 * Math.sqrt(Math.min(1, (death - birth) / largest || 0));
    const width = isPicked(pick, track?.id ?? null, birth, death) ? 2.4 : isThick ? 1.4 : 0.6;
    draw(rows[at], rows[at + 1], color, alpha, width);
  }
}
