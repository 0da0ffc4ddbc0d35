//! A follower: a view that is updated from frame to frame, at the cost of what changes in it.
//!
//! In: the [`Change`] of a frame, and the current skeleton.
//! Out: a [`Step`]: the [`Diff`] of the view, its checksum and counts.
//! Invariants: steps equal what [`Snapshot::diff`](super::diff::Snapshot::diff) gives for the views of whole skeletons.
//! A follower that missed a frame gets the whole view as new.
//! Must not know: how skeletons are found, formats.
//!
//! A view shows tree edges up to a scale, and dots by a rule ([`ViewRule`]). Given the scales that the gaps select,
//! both are decided for each edge or dot alone, so a change is filtered. Only if these scales move, the edges and dots
//! between the old and the new scales are looked up as well.

use std::collections::{BTreeMap, HashSet};

use super::change::Change;
use super::diff::{Checksum, Diff};
use super::held::HeldSkeleton;
use super::step::Step;
use super::view_rule::ViewRule;
use crate::topology::skeleton::{Critical, EdgeId, TreeEdgeId, ViewSpec};

/// Follows one view.
#[derive(Clone, Debug)]
pub struct Follower {
    spec: ViewSpec,
    /// The frame that it was updated to; 0 for none.
    frame: u64,
    rule: ViewRule,
    edges: usize,
    /// Labels of the critical edges shown.
    critical: BTreeMap<EdgeId, [f64; 2]>,
    checksum: Checksum,
}

impl Follower {
    /// A follower of a view, at no frame yet.
    pub fn new(spec: ViewSpec) -> Self {
        Self {
            spec,
            frame: 0,
            rule: ViewRule::NOTHING,
            edges: 0,
            critical: BTreeMap::new(),
            checksum: Checksum::default(),
        }
    }

    /// The view that it follows.
    pub fn spec(&self) -> ViewSpec {
        self.spec
    }

    /// The number of the frame that it was updated to; 0 for none.
    pub fn frame(&self) -> u64 {
        self.frame
    }

    /// The number of tree edges in the view.
    pub fn edges(&self) -> usize {
        self.edges
    }

    /// The number of independent cycles in the view.
    pub fn cycles(&self) -> usize {
        self.critical.len()
    }

    /// The checksum of the view.
    pub fn checksum(&self) -> Checksum {
        self.checksum
    }

    /// Updates it to frame `number`. `change` leads from the frame it was updated to before; without it, the whole view
    /// is new.
    pub(crate) fn advance(&mut self, number: u64, held: &mut impl HeldSkeleton, change: Option<&Change>) -> Step {
        let selection = held.select(self.spec);
        let rule = ViewRule::new(self.spec, selection.as_ref());
        let mut diff = Diff::default();
        let from = match change {
            Some(change) => {
                self.follow_vertices(change, &mut diff);
                self.follow_tree(change, held, rule.limit, &mut diff);
                self.follow_dots(change, held, &rule, &mut diff);
                change.from
            }
            None => {
                *self = Self::new(self.spec);
                self.begin(held, &rule, &mut diff);
                0
            }
        };
        diff.critical_before.sort_unstable_by_key(|dot| dot.edge);
        self.rule = rule;
        self.frame = number;
        let vertices = held.vertex_count();
        Step {
            number,
            from,
            time: None,
            points: 0,
            decluttered: None,
            vertices,
            spec: self.spec,
            selection,
            components: vertices - self.edges,
            cycles: self.critical.len(),
            diff,
            checksum: self.checksum,
        }
    }

    fn begin(&mut self, held: &impl HeldSkeleton, rule: &ViewRule, diff: &mut Diff) {
        diff.vertices_added = held.vertices();
        diff.vertices_added.iter().for_each(|(id, coordinates)| self.checksum.add_vertex(id, coordinates));
        diff.tree_added = held.tree_between(None, rule.limit).into_iter().map(|edge| edge.edge).collect();
        self.count_tree(diff);
        self.show_dots(held.dots_down_to(rule.least).into_iter().filter(|dot| rule.shows(dot)).collect(), diff);
    }

    fn follow_vertices(&mut self, change: &Change, diff: &mut Diff) {
        let (added, removed) = (&change.vertices_added, &change.vertices_removed);
        added.iter().for_each(|(id, coordinates)| self.checksum.add_vertex(id, coordinates));
        removed.iter().for_each(|(id, coordinates)| self.checksum.remove_vertex(id, coordinates));
        diff.vertices_added.clone_from(added);
        diff.vertices_removed = removed.ids().to_vec();
    }

    fn follow_tree(&mut self, change: &Change, held: &impl HeldSkeleton, limit: f64, diff: &mut Diff) {
        let old = self.rule.limit;
        let up_to = |edges: &[TreeEdgeId], limit: f64| -> Vec<EdgeId> {
            edges.iter().filter(|edge| edge.scale <= limit).map(|edge| edge.edge).collect()
        };
        diff.tree_removed = up_to(&change.tree_removed, old);
        diff.tree_added = up_to(&change.tree_added, limit);
        if limit != old {
            // Edges that stay in the tree, but enter or leave the view.
            let new: HashSet<EdgeId> = change.tree_added.iter().map(|edge| edge.edge).collect();
            let moved = held.tree_between(Some(old.min(limit)), old.max(limit)).into_iter().map(|edge| edge.edge);
            let moved = moved.filter(|edge| !new.contains(edge));
            if limit > old { diff.tree_added.extend(moved) } else { diff.tree_removed.extend(moved) }
        }
        self.count_tree(diff);
    }

    fn count_tree(&mut self, diff: &mut Diff) {
        diff.tree_added.sort_unstable();
        diff.tree_removed.sort_unstable();
        diff.tree_added.iter().for_each(|edge| self.checksum.add_tree(edge));
        diff.tree_removed.iter().for_each(|edge| self.checksum.remove_tree(edge));
        self.edges = self.edges + diff.tree_added.len() - diff.tree_removed.len();
    }

    fn follow_dots(&mut self, change: &Change, held: &impl HeldSkeleton, rule: &ViewRule, diff: &mut Diff) {
        let Some(changed) = change.dots.as_ref().filter(|_| rule.same_dots(&self.rule)) else {
            let shown = held.dots_down_to(rule.least).into_iter().filter(|dot| rule.shows(dot)).collect();
            return self.show_dots(shown, diff);
        };
        let added: BTreeMap<EdgeId, Critical> =
            changed.added.iter().filter(|dot| rule.shows(dot)).map(|dot| (dot.edge, *dot)).collect();
        let mut removed: Vec<EdgeId> =
            changed.removed.iter().filter(|dot| rule.shows(dot)).map(|dot| dot.edge).collect();
        removed.sort_unstable();
        for edge in removed.into_iter().filter(|edge| !added.contains_key(edge)) {
            self.hide_dot(edge, diff);
        }
        added.into_values().for_each(|dot| self.show_dot(dot, diff));
    }

    /// Replaces the dots of the view by these.
    fn show_dots(&mut self, mut dots: Vec<Critical>, diff: &mut Diff) {
        dots.sort_unstable_by_key(|dot| dot.edge);
        let stays = |edge: &EdgeId| dots.binary_search_by_key(edge, |dot| dot.edge).is_ok();
        let gone: Vec<EdgeId> = self.critical.keys().copied().filter(|edge| !stays(edge)).collect();
        gone.into_iter().for_each(|edge| self.hide_dot(edge, diff));
        dots.into_iter().for_each(|dot| self.show_dot(dot, diff));
    }

    fn show_dot(&mut self, dot: Critical, diff: &mut Diff) {
        let label = [dot.birth, dot.death];
        match self.critical.insert(dot.edge, label) {
            Some(old) if old == label => return,
            Some([birth, death]) => {
                let old = Critical { birth, death, ..dot };
                self.checksum.remove_critical(&old);
                diff.critical_before.push(old);
            }
            None => {}
        }
        self.checksum.add_critical(&dot);
        diff.critical_set.push(dot);
    }

    fn hide_dot(&mut self, edge: EdgeId, diff: &mut Diff) {
        if let Some([birth, death]) = self.critical.remove(&edge) {
            let old = Critical { edge, birth, death };
            self.checksum.remove_critical(&old);
            diff.critical_removed.push(edge);
            diff.critical_before.push(old);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::num::NonZeroU32;

    use super::*;
    use crate::topology::cloud::{VertexId, Vertices};
    use crate::topology::frames::{Frame, SimplifiedFollower, Snapshot, Tree};
    use crate::topology::skeleton::{Dot, Killer, Skeleton, View, simplify};

    /// A ring of vertices with these ids. The edges from odd ids on are longer. The dot of the last edge, which is
    /// critical, lives up to `death`.
    fn ring(ids: &[u64], dimension: usize, death: f64) -> Skeleton {
        let mut vertices = Vertices::default();
        ids.iter().for_each(|&id| vertices.push(VertexId(id), &[id as f64, 1.0, -2.5][..dimension]));
        let last = ids.len() as u32 - 1;
        let half_length = |place: u32| 1.0 + (ids[place as usize] % 2) as f64;
        let tree = (0..last).map(|place| ([place, place + 1], half_length(place))).collect();
        let dot = Dot { birth: 2.5, death, edge: [0, last], killer: Killer::None };
        Skeleton::with_lengths(vertices, tree, vec![dot])
    }

    fn of_ids<'a>(all: &'a Skeleton, other: &'a Skeleton) -> Vertices {
        all.vertices().iter().filter(|(id, _)| !other.vertices().ids().contains(id)).collect()
    }

    #[test]
    fn views_of_any_space_are_followed() {
        let rank = NonZeroU32::MIN;
        for dimension in [0, 1, 3] {
            let frames = [
                ring(&[1, 2, 4, 7, 8], dimension, f64::INFINITY),
                ring(&[2, 4, 5, 8, 11, 12], dimension, 4.5),
                ring(&[2, 4, 5, 8, 11], dimension, f64::INFINITY),
            ];
            let specs = [ViewSpec::Full, ViewSpec::Reduced { alpha: 1.5 }, ViewSpec::Derived { k: rank, l: rank }];
            for spec in specs {
                let mut follower = Follower::new(spec);
                let (mut held, mut old) = (Snapshot::default(), None::<&Skeleton>);
                for (number, new) in (1..).zip(&frames) {
                    let change = old.map(|old| {
                        let (vertices_added, vertices_removed) = (of_ids(new, old), of_ids(old, new));
                        let change = Change { from: number - 1, vertices_added, vertices_removed, ..Change::default() };
                        change.with_trees(&Tree::Whole(old), &Tree::Whole(new))
                    });
                    let step = follower.advance(number, &mut &*new, change.as_ref());
                    let wanted = Snapshot::new(new, &View::new(new, spec));
                    assert_eq!(step.diff, held.diff(&wanted), "{spec:?}");
                    assert_eq!(step.checksum, wanted.checksum(), "{spec:?}");
                    (held, old) = (wanted, Some(new));
                }
            }
        }
    }

    #[test]
    fn simplified_views_of_any_space_are_followed() {
        for dimension in [0, 1, 3] {
            let mut follower = SimplifiedFollower::new(ViewSpec::Full, Some(1.2));
            let mut held = Snapshot::default();
            for (number, ids) in (1..).zip([&[1, 2, 4, 7, 8][..], &[2, 4, 5, 8, 11, 12], &[2, 4, 5]]) {
                let skeleton = ring(ids, dimension, 9.0);
                let frame = Frame { number, time: None, points: 0, decluttered: None, skeleton };
                let step = follower.advance(&frame);
                let simplified = simplify(&frame.skeleton, &frame.view(ViewSpec::Full), 1.2);
                let wanted = Snapshot::of_simplified(&frame.skeleton, &simplified);
                held = held.apply(&step.diff).expect("it starts from what is held");
                assert_eq!((&held, held.checksum()), (&wanted, step.checksum));
                assert!(wanted.vertices.len() < ids.len() || ids.len() == 3);
            }
        }
    }
}
