//! Streams in a space, R^d with a metric: their messages in the form that those of the plane have.
//!
//! In: `SpaceSnapshot`, `SpaceDiff`, `SpaceDots` and `SpaceTracks` messages.
//! Out: `Snapshot`, `Diff`, `Dots` and `Tracks`, whose vertices are rows of an id and `dimension` coordinates. A cycle
//! that never dies has the death +infinity. Dots have labels only and tracks no area: a hole of a space is no disc.
//! Invariants: coordinates that are not whole vertices are a contradiction.
//! Must not know: mirrors, projections.

import { Contradiction } from "./mirror.js";

/** A message in the form of the plane: its name and its body. Other messages are left as they are. */
export function inFormOfPlane(name, body) {
  if (name === "SpaceSnapshot") return ["Snapshot", snapshotOf(body)];
  if (name === "SpaceDiff") return ["Diff", diffOf(body)];
  if (name === "SpaceDots") return ["Dots", dotsOf(body)];
  if (name === "SpaceTracks") return ["Tracks", tracksOf(body)];
  return [name, body];
}

function snapshotOf({ ids, coordinates, ...rest }) {
  return { ...rest, vertices: verticesOf(ids, coordinates, rest.dimension) };
}

function diffOf({ ids_added, coordinates_added, ...rest }) {
  return { ...rest, vertices_added: verticesOf(ids_added, coordinates_added, rest.dimension) };
}

/** Rows of vertices. In dimension 0 there are none. */
function verticesOf(ids, coordinates, dimension) {
  const isWhole = ids.length * dimension === coordinates.length && (dimension > 0 || ids.length === 0);
  if (!isWhole) {
    const sizes = `${coordinates.length} coordinates came for ${ids.length} vertices`;
    throw new Contradiction(`${sizes} of ${dimension} coordinates each`);
  }
  const rows = new Float64Array(ids.length * (1 + dimension));
  ids.forEach((id, i) => {
    rows[i * (1 + dimension)] = id;
    rows.set(coordinates.subarray(i * dimension, (i + 1) * dimension), i * (1 + dimension) + 1);
  });
  return rows;
}

const dotsOf = ({ frame, total, dots }) => ({
  frame,
  total,
  dots: new Float64Array(0),
  labels: Float64Array.from(dots.flatMap(({ birth, death }) => [birth, death ?? Infinity])),
});

const trackOf = (track) => ({ ...track, death: track.death ?? Infinity, area: null });

const tracksOf = ({ events, alive, ...rest }) => ({
  ...rest,
  events: events.map((event) => ({ ...event, track: trackOf(event.track) })),
  alive: alive?.map(trackOf) ?? null,
});
