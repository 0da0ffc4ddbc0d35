//! The view's edges as a table, one a line, tree edges first.
//!
//! In: an [`Answer`].
//! Out: CSV with a header.
//! Invariants: `i` and `j` are the vertices' numbers in order of first appearance; birth, death and persistence are
//! empty for tree edges; scales are radii. Positions are there for points in two dimensions only.
//! Must not know: files.

use std::io::{self, Write};

use hopes::topology::Edge;

use super::{Answer, Cell};

/// Writes the table.
pub fn write(answer: &Answer, out: &mut impl Write) -> io::Result<()> {
    let positions = if answer.is_flat() { "x1,y1,x2,y2," } else { "" };
    writeln!(out, "kind,i,j,{positions}length,birth,death,persistence")?;
    for &edge in &answer.view.tree {
        write_edge(answer, out, "tree", edge)?;
        writeln!(out, ",,,")?;
    }
    for &index in &answer.view.critical {
        let dot = &answer.skeleton.dots()[index as usize];
        write_edge(answer, out, "critical", dot.edge)?;
        let [birth, death, persistence] = [dot.birth, dot.death, dot.persistence()].map(Cell);
        writeln!(out, ",{birth},{death},{persistence}")?;
    }
    Ok(())
}

fn write_edge(answer: &Answer, out: &mut impl Write, kind: &str, edge: Edge) -> io::Result<()> {
    let [i, j] = edge;
    write!(out, "{kind},{i},{j}")?;
    if answer.is_flat() {
        let [[x1, y1], [x2, y2]] = answer.segment(edge).map(|end| end.map(Cell));
        write!(out, ",{x1},{y1},{x2},{y2}")?;
    }
    write!(out, ",{}", Cell(answer.skeleton.length(edge)))
}
