//! Layers of a cloud by depth: what is near is drawn over what is farther away, which is paler.
//!
//! In: elements and how near they are.
//! Out: their slots, layer by layer, the farthest first, with an opacity for each layer.
//! Invariants: sorting takes as long as counting. Every element is in one layer.
//! Must not know: what is drawn, and how.

import { fadeOf } from "../projection/vertices.js";

const LAYERS = 12;
/** The depth of a slot that is free. */
export const NOWHERE = -1;

export class Layers {
  constructor() {
    /** Slots. */
    this.order = new Uint32Array(0);
    this.layers = new Uint8Array(0);
    /** Where each layer begins, and where the last one ends. */
    this.starts = new Uint32Array(LAYERS + 1);
  }

  /** Sorts slots by depth, which is from 0 to 1. @param {(slot: number) => number} depthOf */
  sort(end, depthOf) {
    if (this.order.length < end) [this.order, this.layers] = [new Uint32Array(2 * end), new Uint8Array(2 * end)];
    const { order, layers, starts } = this;
    starts.fill(0);
    for (let slot = 0; slot < end; slot++) {
      const depth = depthOf(slot);
      // A depth that is no number, of a coordinate that is too large, becomes 0 here: the farthest.
      layers[slot] = depth === NOWHERE ? LAYERS : Math.max(0, Math.min(LAYERS - 1, Math.floor(depth * LAYERS)));
      if (layers[slot] < LAYERS) starts[layers[slot] + 1] += 1;
    }
    for (let i = 0; i < LAYERS; i++) starts[i + 1] += starts[i];
    const next = starts.slice();
    for (let slot = 0; slot < end; slot++) if (layers[slot] < LAYERS) order[next[layers[slot]]++] = slot;
  }

  /** The number of slots that are in a layer. */
  get count() {
    return this.starts[LAYERS];
  }
}

/** Layers of a picture's points and edges. */
export class DepthOrder {
  constructor() {
    this.points = new Layers();
    this.edges = new Layers();
  }

  /** Sorts points and edges. `edgeIndices` are the slots of each edge's ends. */
  sort({ vertices, edges }, edgeIndices) {
    const { rows, depths } = vertices;
    this.points.sort(vertices.end, (slot) => (rows[3 * slot] < 0 ? NOWHERE : depths[slot]));
    this.edges.sort(edges.end, (slot) => {
      const [from, to] = [edgeIndices[2 * slot], edgeIndices[2 * slot + 1]];
      return edges.rows[2 * slot] < 0 || from === to ? NOWHERE : (depths[from] + depths[to]) / 2;
    });
  }

  /** Calls `draw` for each layer, the farthest first: with a range of edges, a range of points, and their opacity. */
  forEach(draw) {
    const { points, edges } = this;
    const rangeOf = ({ starts }, i) => [starts[i], starts[i + 1]];
    for (let i = 0; i < LAYERS; i++) draw(rangeOf(edges, i), rangeOf(points, i), fadeOf((i + 0.5) / LAYERS));
  }
}
