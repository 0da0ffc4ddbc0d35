//! The rows of bars: relatives beside each other.
//!
//! In: how many tracks there are, in the order of their beginnings, and links between them.
//! Out: the tracks from top to bottom.
//! Invariants: a family (all that links connect) stands together, families in the order of their eldest. The same
//! links give the same order. It takes no more than n log n, and no recursion.
//! Must not know: what a track is.

use std::collections::VecDeque;

/// All numbers below `count`, relatives side by side.
pub fn order(count: usize, links: &[[usize; 2]]) -> Vec<usize> {
    let mut tree = Tree::new(count, links);
    let sizes = tree.sizes();
    // The larger a child's family, the farther off it stands: what lies between a parent and its children is small.
    for children in &mut tree.children {
        children.sort_by_key(|&child| (sizes[child], child));
    }
    let mut rows = vec![0; count];
    let mut tops = vec![0; count];
    let mut next = 0;
    for &node in &tree.found {
        if tree.is_root[node] {
            tops[node] = next;
            next += sizes[node];
        }
        let children = &tree.children[node];
        let above = children.iter().skip(1).step_by(2).rev();
        let below = children.iter().step_by(2);
        let mut top = tops[node];
        for &child in above {
            tops[child] = top;
            top += sizes[child];
        }
        rows[top] = node;
        top += 1;
        for &child in below {
            tops[child] = top;
            top += sizes[child];
        }
    }
    rows
}

/// A tree in each family, by breadth from its eldest.
struct Tree {
    /// Parents before children.
    found: Vec<usize>,
    is_root: Vec<bool>,
    children: Vec<Vec<usize>>,
}

impl Tree {
    fn new(count: usize, links: &[[usize; 2]]) -> Self {
        let mut linked = vec![Vec::new(); count];
        for &[a, b] in links {
            linked[a].push(b);
            linked[b].push(a);
        }
        let mut tree = Self { found: Vec::new(), is_root: vec![false; count], children: vec![Vec::new(); count] };
        let mut is_found = vec![false; count];
        for root in 0..count {
            if is_found[root] {
                continue;
            }
            (is_found[root], tree.is_root[root]) = (true, true);
            let mut waiting = VecDeque::from([root]);
            while let Some(node) = waiting.pop_front() {
                tree.found.push(node);
                for &other in &linked[node] {
                    if !is_found[other] {
                        is_found[other] = true;
                        tree.children[node].push(other);
                        waiting.push_back(other);
                    }
                }
            }
        }
        tree
    }

    /// How many stand in the tree below each, itself included.
    fn sizes(&self) -> Vec<usize> {
        let mut sizes = vec![1; self.found.len()];
        for &node in self.found.iter().rev() {
            sizes[node] += self.children[node].iter().map(|&child| sizes[child]).sum::<usize>();
        }
        sizes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strangers_stand_in_order() {
        assert!(order(0, &[]).is_empty());
        assert_eq!(order(4, &[]), [0, 1, 2, 3]);
    }

    #[test]
    fn children_stand_on_both_sides_of_their_parent() {
        assert_eq!(order(5, &[[1, 2], [1, 4], [1, 3]]), [0, 3, 1, 2, 4]);
    }

    #[test]
    fn families_stay_together_whatever_links_they_have() {
        // A ring of links, one track linked to itself, one link given twice.
        assert_eq!(order(6, &[[0, 2], [2, 4], [4, 0], [1, 5], [1, 5], [3, 3]]), [4, 0, 2, 1, 5, 3]);
    }

    #[test]
    fn every_track_stands_once() {
        let links: Vec<[usize; 2]> = (1..2000).map(|child| [child * 7919 / 13 % child, child]).collect();
        let mut rows = order(2000, &links);
        let longest = |rows: &[usize]| {
            let mut places = vec![0i64; 2000];
            rows.iter().zip(0..).for_each(|(&track, place)| places[track] = place);
            links.iter().map(|&[a, b]| (places[a] - places[b]).abs()).sum::<i64>()
        };
        let unordered: Vec<usize> = (0..2000).collect();
        assert!(longest(&rows) * 10 < longest(&unordered), "{} {}", longest(&rows), longest(&unordered));
        rows.sort_unstable();
        assert_eq!(rows, unordered);
    }

    #[test]
    fn a_long_line_of_descent_is_no_danger() {
        let links: Vec<[usize; 2]> = (1..200_000).map(|child| [child - 1, child]).collect();
        assert_eq!(order(200_000, &links).len(), 200_000);
    }
}
