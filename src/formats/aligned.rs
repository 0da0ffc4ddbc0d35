//! A table for people: columns as wide as their widest cell.
//!
//! In: the heads of columns, rows of cells.
//! Out: a line a row.
//! Invariants: words stand at the left, numbers at the right. No blanks follow the last cell of a line. Rows are
//! made twice and never kept, so memory does not grow with them.
//! Must not know: what cells say.

use std::io::{self, Write};

/// A column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Column {
    /// What stands above it.
    pub head: &'static str,
    /// Whether it has words, and no numbers.
    pub is_word: bool,
}

/// A column of words.
pub const fn words(head: &'static str) -> Column {
    Column { head, is_word: true }
}

/// A column of numbers.
pub const fn numbers(head: &'static str) -> Column {
    Column { head, is_word: false }
}

/// Writes the heads, then the rows, each of which has a cell for every column.
pub fn write(
    out: &mut impl Write,
    columns: &[Column],
    rows: impl Iterator<Item = Vec<String>> + Clone,
) -> io::Result<()> {
    let heads: Vec<String> = columns.iter().map(|column| column.head.to_owned()).collect();
    let all = || std::iter::once(heads.clone()).chain(rows.clone());
    let mut widths = vec![0; columns.len()];
    for row in all() {
        for (width, cell) in widths.iter_mut().zip(&row) {
            *width = cell.chars().count().max(*width);
        }
    }
    for row in all() {
        let mut line = String::new();
        for ((column, cell), &width) in columns.iter().zip(&row).zip(&widths) {
            line += &if column.is_word { format!("{cell:<width$}  ") } else { format!("{cell:>width$}  ") };
        }
        writeln!(out, "{}", line.trim_end())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_as_wide_as_their_widest_cell() {
        let rows = [["a", "1"], ["length", "12345"], ["", "6"]].map(|row| row.map(str::to_owned).to_vec());
        let mut out = Vec::new();
        write(&mut out, &[words("name"), numbers("size")], rows.into_iter()).unwrap();
        let expected = "\
name     size
a           1
length  12345
            6
";
        assert_eq!(String::from_utf8(out).unwrap(), expected);
    }
}
