//! The difference of a skeleton that a round of reductions makes.
//!
//! In: what tiles had resolved, and what they resolve now.
//! Out: a [`Difference`].
//! Invariants: an element that only moved from one tile to another is not in it. As sets, its lists do not depend on
//! the order in which tiles were compared.
//! Must not know: the tree of tiles, ids.

use std::cmp::Ordering;

use hashbrown::HashTable;

use super::resolved::{EdgeOrder, Resolved};
use crate::topology::cloud::Slot;
use crate::topology::plane::elements::{TileDot, TreeEdge};

/// What a change did to a skeleton, by slots. No element is on both sides.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Difference {
    /// New edges of the tree.
    pub tree_added: Vec<TreeEdge>,
    /// Edges that left the tree.
    pub tree_removed: Vec<TreeEdge>,
    /// Dots that are new or have a new label.
    pub dots_added: Vec<TileDot>,
    /// Dots that are gone or had another label.
    pub dots_removed: Vec<TileDot>,
}

impl Difference {
    /// Adds the difference of one tile's old and new lists, which are in order.
    pub(super) fn compare(&mut self, order: &EdgeOrder<'_>, old: &Resolved, new: &Resolved) {
        let by_edge = |a: &TreeEdge, b: &TreeEdge| order.of(a.scale, a.ends, b.scale, b.ends);
        difference(&old.tree, &new.tree, by_edge, &mut self.tree_removed, &mut self.tree_added);
        let by_birth = |a: &TileDot, b: &TileDot| order.of(a.birth, a.edge, b.birth, b.edge);
        difference(&old.dots, &new.dots, by_birth, &mut self.dots_removed, &mut self.dots_added);
    }

    /// Moves the elements of another difference here.
    pub(super) fn take(&mut self, other: &mut Self) {
        self.tree_added.append(&mut other.tree_added);
        self.tree_removed.append(&mut other.tree_removed);
        self.dots_added.append(&mut other.dots_added);
        self.dots_removed.append(&mut other.dots_removed);
    }

    /// Removes elements that only moved from one tile to another.
    pub(super) fn cancel(&mut self) {
        let key = |[a, b]: [Slot; 2]| u64::from(a) << 32 | u64::from(b);
        cancel(&mut self.tree_removed, &mut self.tree_added, |edge| key(edge.ends));
        cancel(&mut self.dots_removed, &mut self.dots_added, |dot| key(dot.edge));
    }
}

/// Merges two sorted lists, and collects the elements that are in one of them only.
fn difference<T: Copy + PartialEq>(
    old: &[T],
    new: &[T],
    order: impl Fn(&T, &T) -> Ordering,
    removed: &mut Vec<T>,
    added: &mut Vec<T>,
) {
    let (mut old, mut new) = (old, new);
    while let ([a, old_rest @ ..], [b, new_rest @ ..]) = (old, new) {
        if a == b {
            (old, new) = (old_rest, new_rest);
            continue;
        }
        let order = order(a, b);
        if order.is_le() {
            removed.push(*a);
            old = old_rest;
        }
        if order.is_ge() {
            added.push(*b);
            new = new_rest;
        }
    }
    removed.extend_from_slice(old);
    added.extend_from_slice(new);
}

/// Removes elements that are in both of two lists without repetitions.
fn cancel<T: Copy + PartialEq>(removed: &mut Vec<T>, added: &mut Vec<T>, key: impl Fn(&T) -> u64) {
    let hash = |item: &T| {
        let mixed = key(item).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        mixed ^ (mixed >> 32)
    };
    let mut places = HashTable::with_capacity(removed.len());
    for place in 0..removed.len() {
        places.insert_unique(hash(&removed[place]), place, |&place| hash(&removed[place]));
    }
    let mut has_moved = vec![false; removed.len()];
    added.retain(|item| {
        let same = places.find(hash(item), |&place| removed[place] == *item);
        same.inspect(|&&place| has_moved[place] = true).is_none()
    });
    let mut has_moved = has_moved.into_iter();
    removed.retain(|_| !has_moved.next().unwrap_or(false));
}
