//! From elements to arrays that are drawn from: which slots have changed, and which two an edge joins.
//!
//! In: elements. Out: runs of slots, pairs of slots. Invariants: each change is told of once. Must not know: what is
//! drawn, and how.

import { BLOCK_BITS } from "./elements.js";

const BLOCK = 1 << BLOCK_BITS;

/** Calls for each run of blocks that have changed, and notes that they are dealt with. */
export function forRuns({ changed, end }, write) {
  for (let block = 0; block * BLOCK < end; block++) {
    if (!changed[block]) continue;
    const from = block;
    while (block * BLOCK < end && changed[block]) changed[block++] = 0;
    write(from * BLOCK, Math.min(block * BLOCK, end));
  }
}

/** The slots of an edge's ends; of an edge that is gone, one slot twice. */
export function linkOf(vertices, edges, slot, into) {
  const a = edges.rows[2 * slot];
  const [from, to] = a < 0 ? [-1, -1] : [vertices.find(a), vertices.find(edges.rows[2 * slot + 1])];
  const isThere = from >= 0 && to >= 0;
  into[2 * slot] = isThere ? from : 0;
  into[2 * slot + 1] = isThere ? to : 0;
}
