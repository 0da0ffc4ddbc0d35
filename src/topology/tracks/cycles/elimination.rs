//! Sums of dots over Z/2, turned into pairs of a row and one of its dots.
//!
//! In: for each row the dots that it is the sum of, which of them are possible, and which is the better one of two.
//! Out: [`Pairs`].
//! Invariants: no dot has two rows. A row that has none is zero, or none of its dots is possible, after the rows before
//! were taken out of it.
//! Must not know: tracks, cycles.
//!
//! Row by row, the best possible dot of a row is its own. The row is added to all later rows with this dot, so
//! that none of them has it. If these sums are a basis of classes, as for shortest cycles of most frames, this is the
//! bijection between them and the dots: each step exchanges one dot of the basis for one row (Steinitz).

use std::cmp::Ordering;
use std::collections::BTreeSet;

/// What elimination finds for each row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pairs {
    /// Its dot.
    pub own: Vec<Option<usize>>,
    /// The row whose addition made it zero: the last row of a sum that is equal to it.
    pub absorbed_by: Vec<Option<usize>>,
}

/// Pairs each row with a dot. The first rows choose first: of the dots that are possible for a row, the first one in
/// the order `by_rank`.
pub fn eliminate(
    mut rows: Vec<BTreeSet<usize>>,
    is_possible: impl Fn(usize, usize) -> bool,
    by_rank: impl Fn(usize, usize) -> Ordering,
) -> Pairs {
    let mut pairs = Pairs { own: vec![None; rows.len()], absorbed_by: vec![None; rows.len()] };
    for row in 0..rows.len() {
        let possible = rows[row].iter().copied().filter(|&dot| is_possible(row, dot));
        let Some(dot) = possible.min_by(|&a, &b| by_rank(a, b)) else { continue };
        pairs.own[row] = Some(dot);
        let (done, later) = rows.split_at_mut(row + 1);
        for (place, other) in later.iter_mut().enumerate().filter(|(_, other)| other.contains(&dot)) {
            *other = other.symmetric_difference(&done[row]).copied().collect();
            if other.is_empty() {
                pairs.absorbed_by[row + 1 + place] = Some(row);
            }
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn sums(rows: &[&[usize]]) -> Vec<BTreeSet<usize>> {
        rows.iter().map(|row| row.iter().copied().collect()).collect()
    }

    fn any(_: usize, _: usize) -> bool {
        true
    }

    #[test]
    fn a_basis_of_sums_becomes_a_bijection() {
        let own = |rows: &[&[usize]]| eliminate(sums(rows), any, |a, b| a.cmp(&b)).own;
        assert_eq!(own(&[&[0], &[1]]), [Some(0), Some(1)]);
        assert_eq!(own(&[&[0, 1], &[1]]), [Some(0), Some(1)]);
        assert_eq!(own(&[&[0, 1], &[0]]), [Some(0), Some(1)]);
        assert_eq!(own(&[&[2], &[0, 1], &[0, 1, 2]]), [Some(2), Some(0), None]);
        assert_eq!(own(&[&[], &[0, 2]]), [None, Some(0)]);
    }

    #[test]
    fn a_row_that_is_the_sum_of_others_is_absorbed() {
        let pairs = eliminate(sums(&[&[0], &[1, 2], &[0, 1, 2], &[]]), any, |a, b| a.cmp(&b));
        assert_eq!(pairs.own, [Some(0), Some(1), None, None]);
        assert_eq!(pairs.absorbed_by, [None, None, Some(1), None]);
    }

    #[test]
    fn impossible_dots_are_left_to_others() {
        let pairs = eliminate(sums(&[&[0], &[0, 1]]), |row, _| row != 0, |a, b| a.cmp(&b));
        assert_eq!(pairs.own, [None, Some(0)]);
        assert_eq!(pairs.absorbed_by, [None, None]);
    }

    proptest! {
        #[test]
        fn independent_rows_all_have_dots_and_none_has_two(
            rows in prop::collection::vec(prop::collection::btree_set(0..9_usize, 0..5), 0..9),
        ) {
            let pairs = eliminate(rows.clone(), any, |_, _| Ordering::Equal);
            let taken: BTreeSet<usize> = pairs.own.iter().flatten().copied().collect();
            prop_assert_eq!(taken.len(), pairs.own.iter().flatten().count());
            for (row, own) in pairs.own.iter().enumerate() {
                // Whether it is the sum of some of the rows before.
                let is_sum = (0..1_u32 << row).any(|chosen| {
                    let mut left = rows[row].clone();
                    for other in (0..row).filter(|other| chosen >> other & 1 != 0) {
                        left = left.symmetric_difference(&rows[other]).copied().collect();
                    }
                    left.is_empty()
                });
                prop_assert_eq!(own.is_none(), is_sum);
                prop_assert_eq!(pairs.absorbed_by[row].is_some(), is_sum && !rows[row].is_empty());
            }
        }
    }
}
