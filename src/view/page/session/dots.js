//! Dots of a picture: which of them are in the view, and where their holes are.
//!
//! In: the rows of a `Dots` message; the critical edges of the view.
//! Out: labels, marks, holes.
//! Invariants: a dot is marked if and only if the view has a critical edge with its label. So what is marked is what
//! the daemon has chosen (in a derived view by Definition 14: dots of VS with death above vs). Nothing is chosen here.
//! Must not know: gaps, drawing.

/** Columns of a dot: its edge's ends, birth, death, centre and radius. */
const DOT = 7;
/** Holes that are kept of a picture at the most, those of the most persistent dots. */
const MAX_HOLES = 200;
/** Columns of a hole: birth, death, centre and radius. */
export const HOLE = 5;

/** Without any dots. */
export const noDots = () => ({
  frame: null,
  total: 0,
  labels: new Float64Array(0),
  isShown: new Uint8Array(0),
  holes: new Float64Array(0),
});

/** Birth and death of each dot: what the diagram needs of it, and what is kept for every picture of the history. */
export function labelsOf(rows) {
  const labels = new Float64Array((2 * rows.length) / DOT);
  for (let i = 0; i < labels.length; i += 2) {
    labels[i] = rows[(i / 2) * DOT + 2];
    labels[i + 1] = rows[(i / 2) * DOT + 3];
  }
  return labels;
}

/** 1 for each label that a critical edge has, else 0. @param {import("./elements.js").Elements} critical */
export function marksOf(labels, critical) {
  const marks = new Uint8Array(labels.length / 2);
  // There are far fewer dots than a full view has critical edges.
  const byDeath = new Map();
  for (let i = 0; i < marks.length; i++) {
    const known = byDeath.get(labels[2 * i + 1]);
    if (known) known.push(i);
    else byDeath.set(labels[2 * i + 1], [i]);
  }
  for (let at = 0; at < 4 * critical.end; at += 4) {
    if (critical.rows[at] < 0) continue;
    const birth = critical.rows[at + 2];
    for (const i of byDeath.get(critical.rows[at + 3]) ?? []) if (labels[2 * i] === birth) marks[i] = 1;
  }
  return marks;
}

/** The holes of the most persistent marked dots: label, centre and radius. Dots of a space have no rows, and no holes. */
export function holesOf(rows, marks) {
  const holes = [];
  for (let i = 0; DOT * i < rows.length && holes.length < HOLE * MAX_HOLES; i++) {
    if (marks[i]) holes.push(...rows.subarray(DOT * i + 2, DOT * i + 7));
  }
  return Float64Array.from(holes);
}
