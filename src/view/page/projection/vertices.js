//! Vertices of a space as vertices of the plane: positions on the screen, with depths.
//!
//! In: the vertices of a mirror, their places, how they are turned.
//! Out: what renderers need of vertices: rows of an id and two coordinates, by the slots of the mirror.
//! Invariants: slots are those of the mirror, so its edges hold for the projection too. The box is the same however the
//! cloud is turned, so the camera keeps still then.
//! Must not know: axes, cameras, renderers.

/** The height of the box of points on a line, as a share of its length. */
const LINE_HEIGHT = 0.04;
/** The opacity of the farthest things. */
const FARTHEST = 0.3;

export class ProjectedVertices {
  constructor() {
    this.rows = new Float64Array(0);
    /** How near each vertex is: from 0, the farthest, to 1. Null in the plane. @type {Float64Array | null} */
    this.depths = null;
    /** [left, bottom, right, top]; null where it is that of the positions. @type {[number, number, number, number] | null} */
    this.box = null;
    /** 1 for each block of slots that changed since the renderer reset it to 0. */
    this.changed = new Uint8Array(0);
    this.version = 0;
    this.source = null;
  }

  /** The number of vertices. */
  get count() {
    return this.source.count;
  }

  /** All vertices are in slots below this one. */
  get end() {
    return this.source.end;
  }

  /** Two numbers for each slot that is reserved. */
  get hashes() {
    return this.source.hashes;
  }

  /** The slot of a vertex, or -1. */
  find(id) {
    return this.source.find(id);
  }

  /**
   * Projects vertices of a dimension.
   * @param {import("../session/elements.js").Elements} source @param {import("./places.js").Places} places
   * @param {import("./orientation.js").Orientation} orientation
   */
  update(source, places, orientation, dimension) {
    this.source = source;
    const capacity = source.hashes.length / 2;
    if (this.rows.length < 3 * capacity) this.rows = new Float64Array(3 * capacity);
    if (this.changed.length !== source.changed.length) this.changed = new Uint8Array(source.changed.length);
    this.changed.fill(1);
    this.version += 1;
    this.depths = dimension > 2 ? this.reservedDepths(capacity) : null;
    this.box = boxOf(places, orientation, dimension);
    const [center, size] = [orientation.component(2, places.center), 2 * places.radius || 1];
    for (let slot = 0; slot < source.end; slot++) {
      const id = source.rows[source.width * slot];
      this.rows[3 * slot] = id;
      if (id < 0) continue;
      const place = places.values.subarray(3 * slot, 3 * slot + 3);
      for (let i = 0; i < 2; i++) this.rows[3 * slot + 1 + i] = orientation.component(i, place);
      if (this.depths) this.depths[slot] = 0.5 + (orientation.component(2, place) - center) / size;
    }
  }

  reservedDepths(capacity) {
    return this.depths && this.depths.length >= capacity ? this.depths : new Float64Array(capacity);
  }
}

/**
 * The box of a ball around all places; of points on a line, one that is as long as they are.
 * @returns {[number, number, number, number] | null}
 */
function boxOf({ center, radius }, orientation, dimension) {
  const [x, y] = [orientation.component(0, center), orientation.component(1, center)];
  if (dimension === 2) return null;
  const height = dimension === 1 ? LINE_HEIGHT * radius : radius;
  return [x - radius, y - height, x + radius, y + height];
}

/** The opacity of what is so near: farther things are paler. */
export const fadeOf = (depth) => FARTHEST + (1 - FARTHEST) * Math.min(1, Math.max(0, depth));

/** The opacity of an edge between two slots. @param {{depths?: Float64Array | null}} vertices */
export const fadeBetween = ({ depths }, from, to) => (depths ? fadeOf((depths[from] + depths[to]) / 2) : 1);
