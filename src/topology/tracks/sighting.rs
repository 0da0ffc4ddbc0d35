//! The dots that a tracker looks at: the most persistent ones, each with its hole and the names that last.
//!
//! In: a skeleton as it is held, and what a tracker looks for. Out: [`Sightings`]. Invariants: their order depends on positions alone: the most persistent first, equal
//! ones by the triangle that names the death. Must not know: which dot is whose.

use std::collections::HashSet;

use super::rule::TrackRule;
use crate::topology::cloud::{Cloud, Located, Position, Slot, VertexId};
use crate::topology::frames::{HeldSkeleton, ViewRule};
use crate::topology::skeleton::{Critical, Hole};

/// A skeleton as it is held, asked for dots with their holes.
pub trait SightingSource: HeldSkeleton {
    /// The most persistent dots down to a persistence: so many at the most, and all that are as persistent as the last of them; in order.
    fn sightings(&mut self, most: usize, least: f64) -> Vec<Sighting>;
}

/// A dot, as a tracker sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sighting {
    /// The critical edge and its label.
    pub critical: Critical,
    /// The ends of the critical edge.
    pub edge: [Position; 2],
    /// The triangle that names the death.
    pub name: [Located<Slot>; 3],
    /// The same by ids, which are never given twice.
    pub triangle: [VertexId; 3],
    /// Where it is filled.
    pub hole: Hole,
}

impl Sighting {
    /// From slots.
    pub fn new(cloud: &Cloud, critical: Critical, edge: [Slot; 2], triangle: [Slot; 3], hole: Hole) -> Self {
        let position = |slot: Slot| cloud.position(slot);
        let name = triangle.map(|slot| (position(slot), slot));
        Self { critical, edge: edge.map(position), name, triangle: triangle.map(|slot| cloud.id(slot)), hole }
    }

    /// Death minus birth.
    pub fn persistence(&self) -> f64 {
        persistence(&self.critical)
    }
}

fn persistence(critical: &Critical) -> f64 {
    critical.death - critical.birth
}

/// So many dots are looked at, at the most.
pub const MOST: usize = 8192;

/// The dots of a frame that are worth looking at.
#[derive(Debug)]
pub struct Sightings {
    /// In order.
    pub all: Vec<Sighting>,
    /// Of each, whether the rule selects it.
    pub is_selected: Vec<bool>,
    /// How many more it would select.
    pub left_out: usize,
}

/// Looks for dots that a rule selects, and for those that may continue some of so many tracks, down to a persistence.
pub fn sight(rule: TrackRule, (tracks, least): (usize, f64), held: &mut impl SightingSource) -> Sightings {
    let mut selected = select(rule, held);
    let left_out = selected.len().saturating_sub(MOST);
    selected.truncate(MOST);
    // Not all noise, where tracks have become as faint as it: the most persistent is likelier to be what is missing.
    let most = (selected.len().max(tracks) * 3 / 2 + 16).min(MOST);
    let mut all = if tracks > 0 { held.sightings(most, least) } else { Vec::new() };
    let known: HashSet<[VertexId; 3]> = all.iter().map(|sighting| sighting.triangle).collect();
    let names: HashSet<[VertexId; 3]> = selected.iter().map(|sighting| sighting.triangle).collect();
    all.extend(selected.into_iter().filter(|sighting| !known.contains(&sighting.triangle)));
    in_order(&mut all);
    let is_selected = all.iter().map(|sighting| names.contains(&sighting.triangle)).collect();
    Sightings { all, is_selected, left_out }
}

/// What a rule selects, in order.
fn select(rule: TrackRule, held: &mut impl SightingSource) -> Vec<Sighting> {
    match rule {
        TrackRule::Top(most) => {
            let mut first = held.sightings(most.get() as usize, 0.0);
            first.truncate(most.get() as usize);
            first
        }
        TrackRule::Above(least) => held.sightings(usize::MAX, least),
        TrackRule::View(spec) => {
            let selection = held.select(spec);
            let rule = ViewRule::new(spec, selection.as_ref());
            let mut shown = held.sightings(usize::MAX, rule.least);
            shown.retain(|sighting| rule.shows(&sighting.critical));
            shown
        }
    }
}

/// The most persistent first; the rest does not depend on ids.
pub fn in_order(sightings: &mut [Sighting]) {
    sightings.sort_unstable_by(|a, b| {
        let corners = |sighting: &Sighting| sighting.name.map(|site| site.0);
        b.persistence().total_cmp(&a.persistence()).then_with(|| corners(a).cmp(&corners(b)))
    });
}
