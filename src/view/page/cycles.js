//! Which track a cycle is, and which cycle is meant by a pointer.
//!
//! In: what lives in a frame, labels, a place in the plane. Out: tracks, hits. Invariants: a cycle is its track where
//! it has one, else its label. Must not know: drawing, the page.

/**
 * What a pointer or a key means: a track, or a cycle without one.
 * @typedef {{track: number | null, birth: number, death: number}} Hit
 */

/** Finds tracks by the labels that they have in a frame. */
export class Labels {
  constructor() {
    this.of = null;
    this.byDeath = new Map();
  }

  /** Takes the tracks of a frame. @param {import("./protocol.js").Track[]} alive */
  take(alive) {
    if (alive === this.of) return;
    this.of = alive;
    this.byDeath.clear();
    for (const track of alive) {
      const others = this.byDeath.get(track.death);
      if (others) others.push(track);
      else this.byDeath.set(track.death, [track]);
    }
  }

  /** The track of this label, or null. */
  find(birth, death) {
    for (const track of this.byDeath.get(death) ?? []) if (track.birth === birth) return track;
    return null;
  }

  /** @returns {Hit} */
  hit(birth, death) {
    return { track: this.find(birth, death)?.id ?? null, birth, death };
  }
}

/** Whether this track, or the cycle of this label if it has none, is what is meant. @param {Hit | null} hit */
export const isMeant = (hit, track, birth, death) =>
  hit !== null && (track !== null ? hit.track === track : hit.birth === birth && hit.death === death);

/**
 * The cycle at a place: the nearest critical edge within reach, else the smallest hole around it.
 * @returns {Hit | null}
 */
export function cycleAt(mirror, beside, labels, x, y, reach) {
  return criticalAt(mirror, labels, x, y, reach) ?? holeAt(mirror, beside, x, y);
}

function criticalAt({ critical, vertices }, labels, x, y, reach) {
  const { rows, end } = critical;
  let [best, nearest] = [-1, reach * reach];
  for (let at = 0; at < 4 * end; at += 4) {
    if (rows[at] < 0) continue;
    const distance = squaredDistance(vertices, rows[at], rows[at + 1], x, y);
    if (distance < nearest) [best, nearest] = [at, distance];
  }
  return best < 0 ? null : labels.hit(rows[best + 2], rows[best + 3]);
}

/** The squared distance of a place from an edge. */
function squaredDistance(vertices, a, b, x, y) {
  const [from, to] = [3 * vertices.find(a), 3 * vertices.find(b)];
  if (from < 0 || to < 0) return Infinity;
  const { rows } = vertices;
  const [ax, ay] = [rows[from + 1], rows[from + 2]];
  const [dx, dy] = [rows[to + 1] - ax, rows[to + 2] - ay];
  const along = Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1)));
  return (x - ax - along * dx) ** 2 + (y - ay - along * dy) ** 2;
}

function holeAt({ vertices, frame }, { alive, cycles }, x, y) {
  let best = null;
  // A simplified view lacks most vertices of walks, and shows circles.
  const isSimple = frame !== null && frame.view.simplify !== "No";
  for (const track of alive) {
    if (best && track.area >= best.area) continue;
    const walks = cycles.get(track.id);
    const { center, radius } = track;
    const isIn = isSimple
      ? Math.hypot(x - center[0], y - center[1]) < radius
      : walks?.length > 0 && isInside(vertices, walks, x, y);
    if (isIn) best = track;
  }
  return best && { track: best.id, birth: best.birth, death: best.death };
}

/** Whether an odd number of the walks' edges lies to the right of a place. */
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
