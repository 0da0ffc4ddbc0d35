//! Numbers as text.
//!
//! In: numbers.
//! Out: short texts.
//! Invariants: a number that is missing is a dash, and one that is infinite is ∞.
//! Must not know: what is counted or measured.

/** A number with four significant digits. */
export function formatNumber(value) {
  if (value === null || value === undefined) return "–";
  if (value === 0) return "0";
  if (value === Infinity) return "∞";
  const size = Math.abs(value);
  return size >= 1e6 || size < 1e-4 ? value.toExponential(2) : String(Number(value.toPrecision(4)));
}

/** An integer with separated thousands. */
export const formatCount = (value) => Number(value).toLocaleString("en");
