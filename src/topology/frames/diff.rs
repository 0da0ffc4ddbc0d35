//! Snapshots of a view, and the smallest change between two of them.
//!
//! In: two [`Snapshot`]s of one stream.
//! Out: a [`Diff`]. The contract as an equation: `old.apply(&old.diff(&new)) == new`.
//! Invariants: all lists are sorted and without repetitions. Equal snapshots have an empty diff. A diff contains
//! nothing that did not change. The checksum of a snapshot is the sum of its elements' hashes, so it can be updated by
//! diffs as well.
//! Must not know: formats, how snapshots are made.

use std::cmp::Ordering;
use std::fmt;

use thiserror::Error;

use crate::topology::cloud::{Position, VertexId, Vertices};
use crate::topology::skeleton::{Critical, EdgeId, Filtration, Positions, Simplified, Skeleton, View};

/// A view of a frame by ids: the whole state of a consumer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// All vertices of the cloud, by id.
    pub vertices: Vertices,
    /// The view's tree edges, in order.
    pub tree: Vec<EdgeId>,
    /// The view's critical edges, in order of their ends.
    pub critical: Vec<Critical>,
}

/// The change from one snapshot to another.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diff {
    /// Vertices that are new, by id.
    pub vertices_added: Vertices,
    /// Vertices that are gone, in order.
    pub vertices_removed: Vec<VertexId>,
    /// Tree edges that are new, in order.
    pub tree_added: Vec<EdgeId>,
    /// Tree edges that are gone, in order.
    pub tree_removed: Vec<EdgeId>,
    /// Critical edges that are new or have a new label, in order.
    pub critical_set: Vec<Critical>,
    /// Critical edges that are gone, in order.
    pub critical_removed: Vec<EdgeId>,
    /// Critical edges that are gone or have a new label, as they were, in order. Not needed by [`Snapshot::apply`], but
    /// by merging.
    pub critical_before: Vec<Critical>,
}

/// Why a diff does not fit a snapshot: it starts from another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum ApplyError {
    /// A vertex to add is of another space.
    #[error(
        "the diff is not of this snapshot's space: it adds vertices of {diff} coordinates to vertices of {snapshot}"
    )]
    Dimension {
        /// The number of coordinates of the snapshot's vertices.
        snapshot: usize,
        /// The number of coordinates of the vertices that the diff adds.
        diff: usize,
    },
    /// A vertex to remove is missing, or one to add is there.
    #[error("the diff does not start from this snapshot: vertex {} is {}", .0.0, there(*.1))]
    Vertex(VertexId, Presence),
    /// A tree edge to remove is missing, or one to add is there.
    #[error("the diff does not start from this snapshot: tree edge {}-{} is {}", .0[0].0, .0[1].0, there(*.1))]
    Tree(EdgeId, Presence),
    /// A critical edge to remove is missing.
    #[error("the diff does not start from this snapshot: critical edge {}-{} is {}", .0[0].0, .0[1].0, there(*.1))]
    Critical(EdgeId, Presence),
}

/// How an element of a snapshot contradicts a diff.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// It is there and should not be.
    There,
    /// It is missing and should be there.
    Missing,
}

fn there(presence: Presence) -> &'static str {
    match presence {
        Presence::There => "there already",
        Presence::Missing => "not there",
    }
}

/// Lets a consumer verify that its mirror equals the original: the sum, modulo 2^64, of a hash of each element.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Checksum(pub u64);

impl fmt::Display for Checksum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

impl Snapshot {
    /// The state of a consumer of `view`.
    pub fn new(skeleton: &Skeleton, view: &View) -> Self {
        let dots = view.critical.iter().map(|&index| &skeleton.dots()[index as usize]);
        let mut critical: Vec<Critical> = dots.map(|dot| skeleton.critical(dot)).collect();
        critical.sort_unstable_by_key(|critical| critical.edge);
        let tree = view.tree.iter().map(|&edge| skeleton.edge_id(edge)).collect();
        Self { vertices: skeleton.vertices().clone(), tree, critical }
    }

    /// The diff that leads from this snapshot to `new`.
    pub fn diff(&self, new: &Snapshot) -> Diff {
        let mut diff = Diff::default();
        merge(
            self.vertices.iter(),
            new.vertices.iter(),
            |vertex| vertex.0,
            |change| match change {
                (Some((old, _)), None) => diff.vertices_removed.push(old),
                (None, Some((id, coordinates))) => diff.vertices_added.push(id, coordinates),
                // Vertices move in simplified views only.
                (Some(old), Some(new)) if old != new => {
                    diff.vertices_removed.push(old.0);
                    diff.vertices_added.push(new.0, new.1);
                }
                _ => {}
            },
        );
        merge(
            self.tree.iter(),
            new.tree.iter(),
            |edge| **edge,
            |change| match change {
                (Some(old), None) => diff.tree_removed.push(*old),
                (None, Some(new)) => diff.tree_added.push(*new),
                _ => {}
            },
        );
        merge(
            self.critical.iter(),
            new.critical.iter(),
            |critical| critical.edge,
            |change| match change {
                (Some(old), None) => {
                    diff.critical_removed.push(old.edge);
                    diff.critical_before.push(*old);
                }
                (None, Some(new)) => diff.critical_set.push(*new),
                (Some(old), Some(new)) if old != new => {
                    diff.critical_set.push(*new);
                    diff.critical_before.push(*old);
                }
                _ => {}
            },
        );
        diff
    }

    /// The state of a consumer of a simplified view. Each vertex has the smallest id of those merged into it; without
    /// coordinates, that of the one that stayed. All edges are tree edges.
    pub fn of_simplified(skeleton: &Skeleton, simplified: &Simplified) -> Self {
        let ids = ids_of_simplified(skeleton, simplified);
        let mut order: Vec<u32> = (0..ids.len() as u32).collect();
        order.sort_unstable_by_key(|&place| ids[place as usize]);
        let mut vertices = Vertices::with_capacity(skeleton.vertices().dimension(), ids.len());
        for place in order {
            let (id, coordinates) = (ids[place as usize], simplified.positions.coordinates(place));
            match (skeleton.filtration(), coordinates) {
                (Filtration::Alpha, &[x, y]) => vertices.push(id, &Position::between(x, y).xy()),
                _ => vertices.push(id, coordinates),
            }
        }
        let mut tree: Vec<EdgeId> = (simplified.edges.iter())
            .map(|edge| edge.map(|end| ids[end as usize]))
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        tree.sort_unstable();
        Self { vertices, tree, critical: Vec::new() }
    }

    /// The snapshot that a diff leads to.
    ///
    /// # Errors
    /// [`ApplyError`] when the diff starts from another snapshot.
    pub fn apply(&self, diff: &Diff) -> Result<Snapshot, ApplyError> {
        let (old, added) = (&self.vertices, &diff.vertices_added);
        if !old.is_empty() && !added.is_empty() && old.dimension() != added.dimension() {
            return Err(ApplyError::Dimension { snapshot: old.dimension(), diff: added.dimension() });
        }
        Ok(Snapshot {
            vertices: patch(
                self.vertices.iter(),
                &diff.vertices_removed,
                diff.vertices_added.iter(),
                |vertex| vertex.0,
                false,
            )
            .map_err(|(id, presence)| ApplyError::Vertex(id, presence))?,
            tree: patch(
                self.tree.iter().copied(),
                &diff.tree_removed,
                diff.tree_added.iter().copied(),
                |edge| *edge,
                false,
            )
            .map_err(|(edge, presence)| ApplyError::Tree(edge, presence))?,
            critical: patch(
                self.critical.iter().copied(),
                &diff.critical_removed,
                diff.critical_set.iter().copied(),
                |critical| critical.edge,
                true,
            )
            .map_err(|(edge, presence)| ApplyError::Critical(edge, presence))?,
        })
    }

    /// The sum of the hashes of all elements.
    pub fn checksum(&self) -> Checksum {
        let mut checksum = Checksum::default();
        self.vertices.iter().for_each(|(id, coordinates)| checksum.add_vertex(id, coordinates));
        self.tree.iter().for_each(|edge| checksum.add_tree(edge));
        self.critical.iter().for_each(|critical| checksum.add_critical(critical));
        checksum
    }
}

impl Checksum {
    /// Adds a vertex.
    pub fn add_vertex(&mut self, id: VertexId, coordinates: &[f64]) {
        self.0 = self.0.wrapping_add(hash_of_vertex(id, coordinates));
    }

    /// Removes a vertex.
    pub fn remove_vertex(&mut self, id: VertexId, coordinates: &[f64]) {
        self.0 = self.0.wrapping_sub(hash_of_vertex(id, coordinates));
    }

    /// Adds a tree edge.
    pub fn add_tree(&mut self, edge: &EdgeId) {
        self.0 = self.0.wrapping_add(hash_of_tree(edge));
    }

    /// Removes a tree edge.
    pub fn remove_tree(&mut self, edge: &EdgeId) {
        self.0 = self.0.wrapping_sub(hash_of_tree(edge));
    }

    /// Adds a critical edge.
    pub fn add_critical(&mut self, critical: &Critical) {
        self.0 = self.0.wrapping_add(hash_of_critical(critical));
    }

    /// Removes a critical edge.
    pub fn remove_critical(&mut self, critical: &Critical) {
        self.0 = self.0.wrapping_sub(hash_of_critical(critical));
    }
}

fn hash_of_vertex(id: VertexId, coordinates: &[f64]) -> u64 {
    hash([1, id.0].into_iter().chain(coordinates.iter().map(|v| v.to_bits())))
}

fn hash_of_tree([a, b]: &EdgeId) -> u64 {
    hash([2, a.0, b.0])
}

fn hash_of_critical(critical: &Critical) -> u64 {
    let [a, b] = critical.edge;
    hash([3, a.0, b.0, critical.birth.to_bits(), critical.death.to_bits()])
}

impl Diff {
    /// Whether it changes nothing.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// The ids of the vertices of a simplified view.
fn ids_of_simplified(skeleton: &Skeleton, simplified: &Simplified) -> Vec<VertexId> {
    let vertices = skeleton.vertices();
    if let Positions::Labels(labels) = &simplified.positions {
        return labels.iter().map(|&label| vertices.id(label)).collect();
    }
    let mut ids = vec![VertexId(u64::MAX); simplified.positions.len()];
    for (&vertex, &image) in vertices.ids().iter().zip(&simplified.image) {
        let id = &mut ids[image as usize];
        *id = vertex.min(*id);
    }
    ids
}

/// Merges two sorted lists: calls `visit` for each element that is in one list only, and for both elements of equal
/// keys.
fn merge<T, K: Ord>(
    old: impl Iterator<Item = T>,
    new: impl Iterator<Item = T>,
    key: impl Fn(&T) -> K,
    mut visit: impl FnMut((Option<T>, Option<T>)),
) {
    let (mut old, mut new) = (old.peekable(), new.peekable());
    loop {
        let order = match (old.peek(), new.peek()) {
            (None, None) => return,
            (Some(_), None) => Ordering::Less,
            (None, Some(_)) => Ordering::Greater,
            (Some(a), Some(b)) => key(a).cmp(&key(b)),
        };
        visit(match order {
            Ordering::Less => (old.next(), None),
            Ordering::Greater => (None, new.next()),
            Ordering::Equal => (old.next(), new.next()),
        });
    }
}

/// Removes and adds by key. If `replaces` is true, an added element may replace one of the same key.
fn patch<T: Copy, K: Ord + Copy, L: Default + Extend<T>>(
    old: impl Iterator<Item = T>,
    removed: &[K],
    added: impl Iterator<Item = T>,
    key: impl Fn(&T) -> K,
    replaces: bool,
) -> Result<L, (K, Presence)> {
    let mut removed = removed.iter().copied().peekable();
    let mut result = L::default();
    let mut error = None;
    merge(old, added, &key, |pair| {
        let (Some(element), there) = (pair.1.or(pair.0), pair.0.is_some()) else { return };
        let is_removed = there && removed.next_if_eq(&key(&element)).is_some();
        match pair {
            (Some(_), Some(_)) if !replaces && !is_removed => {
                error.get_or_insert((key(&element), Presence::There));
            }
            (Some(_), None) if is_removed => {}
            _ => result.extend(Some(element)),
        }
    });
    let missing = removed.next().map(|key| (key, Presence::Missing));
    error.or(missing).map_or(Ok(result), Err)
}

/// Folds words into one with the finaliser of SplitMix64, so that every bit of every word counts.
fn hash(words: impl IntoIterator<Item = u64>) -> u64 {
    words.into_iter().fold(0, |hash, word| {
        let z = (hash ^ word).wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn snapshot(vertices: &[u64], tree: &[[u64; 2]], critical: &[(u64, u64, f64)]) -> Snapshot {
        let mut all = Vertices::default();
        vertices.iter().for_each(|&id| all.push(VertexId(id), &[id as f64, 0.5]));
        Snapshot {
            vertices: all,
            tree: tree.iter().map(|edge| edge.map(VertexId)).collect(),
            critical: critical
                .iter()
                .map(|&(a, b, death)| Critical { edge: [VertexId(a), VertexId(b)], birth: 1.0, death })
                .collect(),
        }
    }

    #[test]
    fn a_diff_leads_from_one_snapshot_to_the_other() {
        let old = snapshot(&[1, 2, 3], &[[1, 2], [2, 3]], &[(1, 3, 5.0)]);
        let new = snapshot(&[2, 3, 4], &[[2, 3], [3, 4]], &[(2, 4, 6.0)]);
        let diff = old.diff(&new);
        assert_eq!(old.apply(&diff), Ok(new.clone()));
        assert_eq!(diff.vertices_removed, [VertexId(1)]);
        assert_eq!(diff.tree_added, [[VertexId(3), VertexId(4)]]);
        assert_eq!(diff.critical_removed, [[VertexId(1), VertexId(3)]]);
        assert_ne!(old.checksum(), new.checksum());
    }

    #[test]
    fn a_new_label_alone_is_set() {
        let old = snapshot(&[1, 2], &[], &[(1, 2, 5.0)]);
        let new = snapshot(&[1, 2], &[], &[(1, 2, 5.5)]);
        let diff = old.diff(&new);
        assert_eq!((diff.critical_set.len(), diff.critical_removed.len()), (1, 0));
        assert_eq!(old.apply(&diff), Ok(new));
    }

    #[test]
    fn equal_snapshots_have_an_empty_diff() {
        let one = snapshot(&[1, 2], &[[1, 2]], &[]);
        assert!(one.diff(&one).is_empty());
        assert_eq!(Snapshot::default().checksum(), Checksum(0));
    }

    #[test]
    fn a_diff_from_another_snapshot_is_refused() {
        let old = snapshot(&[1, 2], &[[1, 2]], &[]);
        let missing = Diff { vertices_removed: vec![VertexId(7)], ..Diff::default() };
        assert_eq!(old.apply(&missing), Err(ApplyError::Vertex(VertexId(7), Presence::Missing)));
        let there = Diff { tree_added: old.tree.clone(), ..Diff::default() };
        let error = old.apply(&there).unwrap_err();
        assert_eq!(error.to_string(), "the diff does not start from this snapshot: tree edge 1-2 is there already");
    }

    #[test]
    fn a_diff_from_another_space_is_refused() {
        let plane = snapshot(&[1, 2], &[], &[]);
        let vertices_added: Vertices = [(VertexId(3), &[0.0; 3][..])].into_iter().collect();
        let diff = Diff { vertices_added, ..Diff::default() };
        assert_eq!(plane.apply(&diff), Err(ApplyError::Dimension { snapshot: 2, diff: 3 }));
        assert!(Snapshot::default().apply(&diff).is_ok(), "nothing is of any space");
    }

    /// The checksum is part of the interface: these values must not change.
    #[test]
    fn checksums_are_frozen() {
        assert_eq!(snapshot(&[1], &[], &[]).checksum().to_string(), "c5178fb7f54c40d9");
        assert_eq!(snapshot(&[1, 2], &[[1, 2]], &[(1, 2, 5.0)]).checksum().to_string(), "27d77e13534e81a6");
    }
}
