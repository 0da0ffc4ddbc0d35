//! Picking: the cycle at a point of the plane, and the track of a cycle.
//!
//! In: the tracks of a frame, labels (birth and death) of cycles, a point of the plane.
//! Out: tracks, picked cycles.
//! Invariants: a cycle is identified by its track if it has one, else by its label.
//! Must not know: drawing, the page.

import { HOLE } from "../session/dots.js";

/**
 * A picked cycle: its track, if it has one, and its label.
 * @typedef {{track: number | null, birth: number, death: number}} Pick
 */

/** The tracks of a frame by their labels. */
export class TracksByLabel {
  constructor() {
    this.alive = null;
    this.byDeath = new Map();
  }

  /** Indexes the tracks of a frame. @param {import("../session/tracks.js").Track[]} alive */
  update(alive) {
    if (alive === this.alive) return;
    this.alive = alive;
    this.byDeath.clear();
    for (const track of alive) {
      const others = this.byDeath.get(track.death);
      if (others) others.push(track);
      else this.byDeath.set(track.death, [track]);
    }
  }

  /** The track with this label, or null. */
  find(birth, death) {
    for (const track of this.byDeath.get(death) ?? []) if (track.birth === birth) return track;
    return null;
  }

  /** @returns {Pick} */
  pick(birth, death) {
    return { track: this.find(birth, death)?.id ?? null, birth, death };
  }
}

/** Whether a picked cycle is this track, or the cycle with this label if it has no track. @param {Pick | null} pick */
export const isPicked = (pick, track, birth, death) =>
  pick !== null && (track !== null ? pick.track === track : pick.birth === birth && pick.death === death);

/**
 * The cycle at a point: that of the nearest critical edge within a radius, else that of the smallest hole around it; in
 * a space, where cycles are loops, that of the nearest loop within the radius.
 * @returns {Pick | null}
 */
export function pickCycle(mirror, annotations, tracksByLabel, x, y, radius) {
  return (
    pickCritical(mirror, tracksByLabel, x, y, radius) ??
    pickLoop(mirror, annotations, x, y, radius) ??
    pickHole(mirror, annotations, tracksByLabel, x, y)
  );
}

function pickCritical({ critical, vertices }, tracksByLabel, x, y, radius) {
  const { rows, end } = critical;
  let [best, nearest] = [-1, radius * radius];
  for (let at = 0; at < 4 * end; at += 4) {
    if (rows[at] < 0) continue;
    const distance = squaredDistance(vertices, rows[at], rows[at + 1], x, y);
    if (distance < nearest) [best, nearest] = [at, distance];
  }
  return best < 0 ? null : tracksByLabel.pick(rows[best + 2], rows[best + 3]);
}

/** The squared distance of a point from an edge. */
function squaredDistance(vertices, a, b, x, y) {
  const [from, to] = [3 * vertices.find(a), 3 * vertices.find(b)];
  if (from < 0 || to < 0) return Infinity;
  const { rows } = vertices;
  const [ax, ay] = [rows[from + 1], rows[from + 2]];
  const [dx, dy] = [rows[to + 1] - ax, rows[to + 2] - ay];
  const along = Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1)));
  return (x - ax - along * dx) ** 2 + (y - ay - along * dy) ** 2;
}

function pickLoop({ vertices }, { alive, cycles }, x, y, radius) {
  let [best, nearest] = [null, radius * radius];
  for (const track of alive) {
    if (track.area !== null) continue;
    for (const walk of cycles.get(track.id) ?? []) {
      for (let i = 0; i < walk.length; i++) {
        const distance = squaredDistance(vertices, walk[i], walk[(i + 1) % walk.length], x, y);
        if (distance < nearest) [best, nearest] = [track, distance];
      }
    }
  }
  return best && { track: best.id, birth: best.birth, death: best.death };
}

function pickHole({ vertices }, { alive, cycles, dots }, tracksByLabel, x, y) {
  let best = null;
  for (const track of alive) {
    if (track.area === null || (best && track.area >= best.area)) continue;
    const walks = cycles.get(track.id);
    if (walks?.length > 0 && isInside(vertices, walks, x, y)) best = track;
  }
  if (best) return { track: best.id, birth: best.birth, death: best.death };
  // A hole without a track has a circle.
  for (let at = 0; at < dots.holes.length; at += HOLE) {
    const [birth, death, left, bottom, radius] = dots.holes.subarray(at, at + HOLE);
    if (Math.hypot(x - left, y - bottom) < radius) return tracksByLabel.pick(birth, death);
  }
  return null;
}

/** Whether a point is inside: an odd number of the walks' edges is to the right of it. */
function isInside(vertices, walks, x, y) {
  let inside = false;
  for (const walk of walks) {
    let before = 3 * vertices.find(walk[walk.length - 1]);
    for (const id of walk) {
      const at = 3 * vertices.find(id);
      if (at < 0 || before < 0) return false;
      const [ax, ay, bx, by] = [
        ...vertices.rows.subarray(before + 1, before + 3),
        ...vertices.rows.subarray(at + 1, at + 3),
      ];
      if (ay > y !== by > y && x < ax + ((bx - ax) * (y - ay)) / (by - ay)) inside = !inside;
      before = at;
    }
  }
  return inside;
}
