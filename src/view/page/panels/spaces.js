//! Spaces in words: metric and dimension of a stream, what its picture's axes are and what lengths in it are.
//!
//! In: metric and dimension of a mirror.
//! Out: short texts.
//! Invariants: nothing is said of the plane, which needs no word. Lengths have a unit only where the picture has them.
//! Must not know: pictures, cameras.

/** Metric and dimension, as "R^3, euclidean"; empty for the plane. */
export function spaceName({ metric, dimension }) {
  if (metric === null) return "";
  const name = metric.toLowerCase();
  if (metric === "Haversine") return `longitude and latitude, ${name}`;
  return dimension > 0 ? `R^${dimension}, ${name}` : name;
}

/** The same in short: the dimension, or the metric that says it. */
export const shortSpaceName = ({ metric, dimension }) =>
  metric === "Haversine" || !(dimension > 0) ? metric.toLowerCase() : `R^${dimension}`;

/** The names of the picture's axes. Where a cloud is turned there are none. */
export function axesOf({ metric, dimension }) {
  if (metric === "Haversine") return ["lon", "lat"];
  // Vectors that are compared by their angles are shown at length 1.
  if (metric === "Angular" || dimension > 2) return [];
  return ["x", "y"].slice(0, dimension);
}

/** The unit of lengths in the picture: none, degrees, or null where lengths in it are not those of the metric. */
export function unitOf({ metric }) {
  if (metric === "Haversine") return "°";
  return metric === "Angular" ? null : "";
}
