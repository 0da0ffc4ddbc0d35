//! What is drawn of cycles, in which order, and how it looks, whatever it is drawn with.
//!
//! In: a mirror and what lives beside it, what is meant. Out: holes, outlines and critical edges with colours, how far
//! they hide what is below, and half their widths in pixels. Invariants: a track has its colour everywhere. Must not
//! know: cameras, canvases.

import { colorOf, palette } from "./colors.js";
import { isMeant } from "./cycles.js";

/** Holes that are filled, at most. */
const MOST_HOLES = 1500;
/** So many critical edges are all worth a thick line. */
const FEW = 200;
/** Corners of what is drawn as a circle. */
export const CORNERS = 48;

/** The size of a point, where each has so many pixels of room. */
export const pointSize = (room) => Math.min(4.5, Math.max(1.25, 0.35 * room));

/** The tracks whose holes are filled, the largest first. A simplified view lacks most vertices of their walks. */
export function holesOf({ frame }, { alive, cycles }) {
  if (!frame || frame.view.simplify !== "No") return [];
  return alive
    .filter((track) => cycles.get(track.id)?.length)
    .sort((a, b) => b.area - a.area)
    .slice(0, MOST_HOLES);
}

/** How far the filling of a hole hides what is below. */
export const fillingOf = (track, hit) => (isMeant(hit, track.id) ? 0.5 : track.selected ? 0.26 : 0.1);

/** What is drawn around holes: walks, or circles in a simplified view, which lacks most of their vertices. */
export function outlinesOf({ frame }, { alive, cycles }, hit) {
  const look = (track) => {
    const [alpha, width] = isMeant(hit, track.id) ? [1, 1.3] : [track.selected ? 0.8 : 0.3, 0.65];
    return { track, color: colorOf(track.id), alpha, width };
  };
  if (frame && frame.view.simplify !== "No") {
    return alive.map((track) => ({ ...look(track), walk: null, length: CORNERS }));
  }
  return alive.flatMap((track) =>
    (cycles.get(track.id) ?? []).map((walk) => ({ ...look(track), walk, length: walk.length })),
  );
}

/**
 * Calls for each critical edge: those of tracks thick; the others, where there are many, thin and pale if they matter
 * little.
 */
export function forCritical({ rows, end, count }, labels, hit, draw) {
  let largest = 0;
  for (let at = 0; at < 4 * end; at += 4) if (rows[at] >= 0) largest = Math.max(largest, rows[at + 3] - rows[at + 2]);
  for (let at = 0; at < 4 * end; at += 4) {
    if (rows[at] < 0) continue;
    const [birth, death] = [rows[at + 2], rows[at + 3]];
    const track = labels.find(birth, death);
    const color = track ? colorOf(track.id) : palette.critical;
    const isPlain = track !== null || count <= FEW;
    const alpha = isPlain ? 1 : 0.25 + 0.75 * Math.sqrt((death - birth) / largest || 0);
    const width = isMeant(hit, track?.id ?? null, birth, death) ? 2.4 : isPlain ? 1.4 : 0.6;
    draw(rows[at], rows[at + 1], color, alpha, width);
  }
}
