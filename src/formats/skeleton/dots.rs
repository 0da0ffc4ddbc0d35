//! The persistence diagram as a table, one dot a line, the most persistent first.
//!
//! In: an [`Answer`].
//! Out: CSV with a header.
//! Invariants: all dots are there, whatever the view; `shown` is 1 for those of the view, else 0. Scales are radii. A
//! number that is not finite is empty.
//! Must not know: files.

use std::io::{self, Write};

use super::{Answer, Cell};

/// Writes the table.
pub fn write(answer: &Answer, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "birth,death,persistence,i,j,x1,y1,x2,y2,center_x,center_y,radius,shown")?;
    let mut shown = vec![false; answer.skeleton.dots().len()];
    for &index in &answer.view.critical {
        shown[index as usize] = true;
    }
    for (dot, shown) in answer.skeleton.dots().iter().zip(shown) {
        let ([i, j], hole) = (dot.edge, answer.skeleton.hole(dot));
        let [[x1, y1], [x2, y2]] = answer.segment(dot.edge);
        let [birth, death, persistence] = [dot.birth, dot.death, dot.persistence()].map(Cell);
        write!(out, "{birth},{death},{persistence},{i},{j}")?;
        for number in [x1, y1, x2, y2, hole.center[0], hole.center[1], hole.radius].map(Cell) {
            write!(out, ",{number}")?;
        }
        writeln!(out, ",{}", u8::from(shown))?;
    }
    Ok(())
}
