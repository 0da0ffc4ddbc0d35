//! Indices for renderers: ranges of slots that changed, and the two slots that an edge connects.
//!
//! In: elements of a mirror.
//! Out: ranges of slots, pairs of slots.
//! Invariants: each change is reported once.
//! Must not know: what is drawn, and how.

import { BLOCK_BITS } from "../session/elements.js";

const BLOCK = 1 << BLOCK_BITS;

/** Calls `write` for each range of changed blocks, and resets their flags. */
export function forChangedRanges({ changed, end }, write) {
  for (let block = 0; block * BLOCK < end; block++) {
    if (!changed[block]) continue;
    const from = block;
    while (block * BLOCK < end && changed[block]) changed[block++] = 0;
    write(from * BLOCK, Math.min(block * BLOCK, end));
  }
}

/** Writes the slots of an edge's ends; of a removed edge, one slot twice. */
export function writeEdgeIndices(vertices, edges, slot, into) {
  const a = edges.rows[2 * slot];
  const [from, to] = a < 0 ? [-1, -1] : [vertices.find(a), vertices.find(edges.rows[2 * slot + 1])];
  const isThere = from >= 0 && to >= 0;
  into[2 * slot] = isThere ? from : 0;
  into[2 * slot + 1] = isThere ? to : 0;
}
