//! Gated optimal assignment. The only file that imports `pathfinding`.
//!
//! In: possible pairs of rows and columns, each with a gain.
//! Out: pairs in which no row or column repeats, with the largest sum of gains.
//! Invariant: the same pairs in the same order give the same answer.
//! Must not know: what is assigned.

use std::collections::{BTreeMap, BTreeSet};

use pathfinding::kuhn_munkres::kuhn_munkres;
use pathfinding::matrix::Matrix;

/// The optimum takes cubic time in the size of a connected group. In larger groups the pair with the largest gain is
/// taken first, repeatedly.
const MOST_IN_GROUP: usize = 256;

/// The largest gain of a group is this many units. Gains are integers in them.
const GAIN_UNITS: f64 = (1_u64 << 40) as f64;

/// A possible pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// One side.
    pub row: usize,
    /// The other side.
    pub column: usize,
    /// What is gained by it: from 0, in any unit.
    pub gain: f64,
}

/// The best assignment: pairs of a row and a column, in no order.
pub fn assign(pairs: &[Pair]) -> Vec<(usize, usize)> {
    connected_groups(pairs).iter().flat_map(|group| assign_group(group)).collect()
}

/// The pairs in groups that share no row or column.
fn connected_groups(pairs: &[Pair]) -> Vec<Vec<Pair>> {
    let mut of_row: BTreeMap<usize, Vec<&Pair>> = BTreeMap::new();
    let mut of_column: BTreeMap<usize, Vec<&Pair>> = BTreeMap::new();
    for pair in pairs {
        of_row.entry(pair.row).or_default().push(pair);
        of_column.entry(pair.column).or_default().push(pair);
    }
    let mut groups = Vec::new();
    while let Some((first, _)) = of_row.first_key_value() {
        let (mut group, mut rows) = (Vec::new(), vec![*first]);
        while let Some(row) = rows.pop() {
            for pair in of_row.remove(&row).unwrap_or_default() {
                group.push(*pair);
                rows.extend(of_column.remove(&pair.column).unwrap_or_default().iter().map(|pair| pair.row));
            }
        }
        groups.push(group);
    }
    groups
}

fn assign_group(group: &[Pair]) -> Vec<(usize, usize)> {
    if let [only] = group {
        return vec![(only.row, only.column)];
    }
    let [rows, columns] = [|pair: &Pair| pair.row, |pair: &Pair| pair.column].map(|side| {
        let mut all: Vec<usize> = group.iter().map(side).collect();
        all.sort_unstable();
        all.dedup();
        all
    });
    if rows.len().max(columns.len()) > MOST_IN_GROUP {
        return largest_first(group);
    }
    let largest = group.iter().map(|pair| pair.gain).fold(f64::MIN_POSITIVE, f64::max);
    // The library requires at least as many columns as rows. A pair without gain is not a pair.
    let is_wide = rows.len() <= columns.len();
    let mut gains = Matrix::new(rows.len().min(columns.len()), rows.len().max(columns.len()), 0_i64);
    for pair in group {
        let place = |all: &[usize], one| all.binary_search(&one).unwrap_or_default();
        let (row, column) = (place(&rows, pair.row), place(&columns, pair.column));
        let gain = 1 + (pair.gain / largest * GAIN_UNITS) as i64;
        gains[if is_wide { (row, column) } else { (column, row) }] = gain;
    }
    let (_, assigned) = kuhn_munkres(&gains);
    let real = assigned.into_iter().enumerate().filter(|&place| gains[place] > 0);
    real.map(|(a, b)| if is_wide { (rows[a], columns[b]) } else { (rows[b], columns[a]) }).collect()
}

fn largest_first(group: &[Pair]) -> Vec<(usize, usize)> {
    let mut pairs = group.to_vec();
    pairs.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let (mut rows, mut columns) = (BTreeSet::new(), BTreeSet::new());
    pairs.retain(|pair| {
        let is_free = !rows.contains(&pair.row) && !columns.contains(&pair.column);
        if is_free {
            rows.insert(pair.row);
            columns.insert(pair.column);
        }
        is_free
    });
    pairs.iter().map(|pair| (pair.row, pair.column)).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn sorted(mut pairs: Vec<(usize, usize)>) -> Vec<(usize, usize)> {
        pairs.sort_unstable();
        pairs
    }

    #[test]
    fn one_near_pair_beats_two_far_pairs() {
        let pair = |row, column, gain| Pair { row, column, gain };
        assert_eq!(assign(&[pair(0, 0, 9.0), pair(0, 1, 1.0), pair(1, 0, 1.0)]), [(0, 0)]);
        let both = assign(&[pair(0, 0, 9.0), pair(0, 1, 7.0), pair(1, 0, 7.0)]);
        assert_eq!(sorted(both), [(0, 1), (1, 0)]);
        assert_eq!(assign(&[]), []);
    }

    #[test]
    fn large_groups_are_assigned_in_time() {
        let pairs: Vec<Pair> = (0..400 * 400)
            .map(|index| (index / 400, index % 400))
            .map(|(row, column): (usize, usize)| Pair { row, column, gain: 1.0 - row.abs_diff(column) as f64 / 400.0 })
            .collect();
        assert_eq!(sorted(assign(&pairs)), (0..400).map(|place| (place, place)).collect::<Vec<_>>());
    }

    /// The largest gain of all assignments, row by row.
    fn best(pairs: &[Pair], row: usize, taken: &mut Vec<usize>) -> f64 {
        let Some(last) = pairs.iter().map(|pair| pair.row).max().filter(|&last| row <= last) else { return 0.0 };
        debug_assert!(row <= last);
        let mut most = best(pairs, row + 1, taken);
        for pair in pairs.iter().filter(|pair| pair.row == row) {
            if !taken.contains(&pair.column) {
                taken.push(pair.column);
                most = most.max(pair.gain + best(pairs, row + 1, taken));
                taken.pop();
            }
        }
        most
    }

    /// Possible pairs and their gains.
    fn possible_pairs() -> impl Strategy<Value = BTreeMap<(usize, usize), f64>> {
        prop::collection::btree_map((0..6_usize, 0..6_usize), 0.0..1.0, 0..20)
    }

    proptest! {
        #[test]
        fn oracle_no_assignment_gains_more(pairs in possible_pairs()) {
            let pairs: Vec<Pair> = pairs.into_iter().map(|((row, column), gain)| Pair { row, column, gain }).collect();
            let assigned = assign(&pairs);
            let gain = |&(row, column): &(usize, usize)| {
                pairs.iter().find(|pair| (pair.row, pair.column) == (row, column)).map(|pair| pair.gain)
            };
            let gain: f64 = assigned.iter().map(|pair| gain(pair).expect("a pair that was given")).sum();
            prop_assert!((gain - best(&pairs, 0, &mut Vec::new())).abs() < 1e-9);
            for side in [|pair: &(usize, usize)| pair.0, |pair: &(usize, usize)| pair.1] {
                let mut all: Vec<usize> = assigned.iter().map(side).collect();
                all.sort_unstable();
                all.dedup();
                prop_assert_eq!(all.len(), assigned.len());
            }
        }
    }
}
