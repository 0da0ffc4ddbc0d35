//! A view that is followed from frame to frame, at the cost of what changes in it.
//!
//! In: the [`Change`] of a frame, and the skeleton as it is held now. Out: a [`Step`]: the [`Diff`] of the view, its checksum and counts. A view
//! shows tree edges up to some scale and dots by a rule; both are told of one edge or dot alone, given the scales that the gaps
//! choose. So a change is filtered; only when those scales move, edges and dots between the old ones and the new ones are looked for besides.
//! Invariants: steps give what [`Snapshot::diff`](super::diff::Snapshot::diff) gives for the views of the whole skeletons; a follower that has missed a
//! frame gets all of the view as new. Must not know: how skeletons are found, formats.

use std::collections::{BTreeMap, HashSet};

use super::change::{Change, TreeEdgeId};
use super::cloud::Vertex;
use super::diff::{Checksum, Critical, Diff, EdgeId};
use super::gaps::Selection;
use super::sighting::Sighting;
use super::view::{ViewSpec, up_to};

/// A skeleton as it is held now, asked for parts of it.
pub trait Held {
    /// Number of vertices.
    fn vertex_count(&self) -> usize;
    /// All vertices, by id.
    fn vertices(&self) -> Vec<Vertex>;
    /// Tree edges that enter after one scale and not after another one, in no order; all up to the second, if there is no first.
    fn tree_between(&self, low: Option<f64>, high: f64) -> Vec<TreeEdgeId>;
    /// Dots of at least this persistence, in no order.
    fn dots_down_to(&self, persistence: f64) -> Vec<Critical>;
    /// The most persistent dots down to a persistence: so many at the most, and all that are as persistent as the last of them; in order.
    fn sightings(&mut self, most: usize, least: f64) -> Vec<Sighting>;
    /// What gaps select.
    fn select(&mut self, spec: ViewSpec) -> Option<Selection>;
}

/// What has changed in a view, from one frame to another.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Number of the frame it leads to.
    pub number: u64,
    /// Number of the frame it starts from; 0: from nothing.
    pub from: u64,
    /// The time given at the frame's commit.
    pub time: Option<f64>,
    /// Points in the window, duplicates among them.
    pub points: u64,
    /// Distinct positions.
    pub vertices: usize,
    /// What is shown.
    pub spec: ViewSpec,
    /// What the gaps selected, in a derived view.
    pub selection: Option<Selection>,
    /// Number of connected components shown, lone vertices among them.
    pub components: usize,
    /// Number of independent cycles shown.
    pub cycles: usize,
    /// The change.
    pub diff: Diff,
    /// Proves the view that it leads to.
    pub checksum: Checksum,
}

/// Which dots and edges a view shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rule {
    /// Edges enter up to this scale.
    limit: f64,
    /// Dots are at least as persistent.
    pub least: f64,
    /// Dots are born no later.
    latest_birth: f64,
    /// Dots die after this.
    alive_at: f64,
}

impl Rule {
    const NOTHING: Self = Self {
        limit: f64::NEG_INFINITY,
        least: f64::INFINITY,
        latest_birth: f64::NEG_INFINITY,
        alive_at: f64::INFINITY,
    };

    pub fn new(spec: ViewSpec, selection: Option<&Selection>) -> Self {
        let all = Self { limit: f64::INFINITY, least: 0.0, latest_birth: f64::INFINITY, alive_at: f64::NEG_INFINITY };
        match (spec, selection) {
            (ViewSpec::Reduced { alpha }, _) => {
                Self { limit: up_to(alpha), latest_birth: up_to(alpha), alive_at: alpha, ..all }
            }
            (ViewSpec::Derived { .. }, Some(Selection { ds, vs, .. })) => {
                Self { limit: up_to(*vs), least: ds.unwrap_or(f64::INFINITY), latest_birth: *vs, alive_at: *vs }
            }
            (ViewSpec::Full | ViewSpec::Derived { .. }, _) => all,
        }
    }

    pub fn shows(&self, dot: &Critical) -> bool {
        dot.death - dot.birth >= self.least && dot.birth <= self.latest_birth && dot.death > self.alive_at
    }

    fn same_dots(&self, other: &Self) -> bool {
        Self { limit: other.limit, ..*self } == *other
    }
}

/// Follows one view.
#[derive(Clone, Debug)]
pub struct Follower {
    spec: ViewSpec,
    /// The frame it has been brought to; 0 for none.
    frame: u64,
    rule: Rule,
    edges: usize,
    /// Labels of the critical edges shown.
    critical: BTreeMap<EdgeId, [f64; 2]>,
    checksum: Checksum,
}

impl Follower {
    /// Has seen nothing yet.
    pub fn new(spec: ViewSpec) -> Self {
        Self { spec, frame: 0, rule: Rule::NOTHING, edges: 0, critical: BTreeMap::new(), checksum: Checksum::default() }
    }

    /// What it follows.
    pub fn spec(&self) -> ViewSpec {
        self.spec
    }

    /// Number of the frame it has been brought to; 0 for none.
    pub fn frame(&self) -> u64 {
        self.frame
    }

    /// Number of tree edges that it shows.
    pub fn edges(&self) -> usize {
        self.edges
    }

    /// Number of independent cycles that it shows.
    pub fn cycles(&self) -> usize {
        self.critical.len()
    }

    /// Proves what it shows.
    pub fn checksum(&self) -> Checksum {
        self.checksum
    }

    /// Brings it to frame `number`. `change` is that of the frame, if it starts from the one that was reached before.
    pub(super) fn advance(&mut self, number: u64, held: &mut impl Held, change: Option<&Change>) -> Step {
        let selection = held.select(self.spec);
        let rule = Rule::new(self.spec, selection.as_ref());
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
            vertices,
            spec: self.spec,
            selection,
            components: vertices - self.edges,
            cycles: self.critical.len(),
            diff,
            checksum: self.checksum,
        }
    }

    fn begin(&mut self, held: &impl Held, rule: &Rule, diff: &mut Diff) {
        diff.vertices_added = held.vertices();
        diff.vertices_added.iter().for_each(|vertex| self.checksum.add_vertex(vertex));
        diff.tree_added = held.tree_between(None, rule.limit).into_iter().map(|edge| edge.edge).collect();
        self.count_tree(diff);
        self.show_dots(held.dots_down_to(rule.least).into_iter().filter(|dot| rule.shows(dot)).collect(), diff);
    }

    fn follow_vertices(&mut self, change: &Change, diff: &mut Diff) {
        change.vertices_added.iter().for_each(|vertex| self.checksum.add_vertex(vertex));
        change.vertices_removed.iter().for_each(|vertex| self.checksum.remove_vertex(vertex));
        diff.vertices_added.clone_from(&change.vertices_added);
        diff.vertices_removed = change.vertices_removed.iter().map(|vertex| vertex.id).collect();
    }

    fn follow_tree(&mut self, change: &Change, held: &impl Held, limit: f64, diff: &mut Diff) {
        let old = self.rule.limit;
        let up_to = |edges: &[TreeEdgeId], limit: f64| -> Vec<EdgeId> {
            edges.iter().filter(|edge| edge.scale <= limit).map(|edge| edge.edge).collect()
        };
        diff.tree_removed = up_to(&change.tree_removed, old);
        diff.tree_added = up_to(&change.tree_added, limit);
        if limit != old {
            // Edges that stay in the tree, but come into view or go out of it.
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

    fn follow_dots(&mut self, change: &Change, held: &impl Held, rule: &Rule, diff: &mut Diff) {
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

    /// Shows these dots and no others.
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
