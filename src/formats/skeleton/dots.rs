//! The persistence diagram as a table, one dot a line, the most persistent first.
//!
//! In: an [`Answer`].
//! Out: CSV with a header.
//! Invariants: all dots are there, whatever the view; `shown` is 1 for those of the view, else 0. Scales are radii. A
//! number that is not finite is empty, and so is the centre of a hole that has none. Positions are there for points in
//! two dimensions only.
//! Must not know: files.

use std::io::{self, Write};

use hopes::topology::Dot;

use super::{Answer, Cell};

/// Writes the table.
pub fn write(answer: &Answer, out: &mut impl Write) -> io::Result<()> {
    let positions = if answer.is_flat() { "x1,y1,x2,y2,center_x,center_y,radius," } else { "" };
    writeln!(out, "birth,death,persistence,i,j,{positions}shown")?;
    let mut shown = vec![false; answer.skeleton.dots().len()];
    for &index in &answer.view.critical {
        shown[index as usize] = true;
    }
    for (dot, shown) in answer.skeleton.dots().iter().zip(shown) {
        let [i, j] = dot.edge;
        let [birth, death, persistence] = [dot.birth, dot.death, dot.persistence()].map(Cell);
        write!(out, "{birth},{death},{persistence},{i},{j}")?;
        if answer.is_flat() {
            write_positions(answer, out, dot)?;
        }
        writeln!(out, ",{}", u8::from(shown))?;
    }
    Ok(())
}

fn write_positions(answer: &Answer, out: &mut impl Write, dot: &Dot) -> io::Result<()> {
    let [[x1, y1], [x2, y2]] = answer.segment(dot.edge);
    let hole = answer.skeleton.hole(dot);
    let [x, y, radius] = hole.map_or([f64::NAN; 3], |hole| [hole.center[0], hole.center[1], hole.radius]);
    [x1, y1, x2, y2, x, y, radius].map(Cell).iter().try_for_each(|number| write!(out, ",{number}"))
}
