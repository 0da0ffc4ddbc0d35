//! Detections: the most persistent dots of a frame, each with its hole and the ids of its triangle.
//!
//! In: the current skeleton, and the options and bounds of a tracker.
//! Out: [`Detections`].
//! Invariant: their order depends on positions alone: the most persistent first, equal ones by the triangle that names
//! the death.
//! Must not know: which detection belongs to which track.

use std::collections::HashSet;

use super::rule::TrackRule;
use crate::topology::cloud::{Cloud, Located, Position, Slot, VertexId};
use crate::topology::frames::{HeldSkeleton, ViewRule};
use crate::topology::skeleton::{Critical, Hole};

/// The current skeleton in a representation that also gives dots with their holes.
pub trait DetectionSource: HeldSkeleton {
    /// The most persistent dots down to a persistence, in order: at most `most`, and all that are as persistent as the
    /// last of these.
    fn detections(&mut self, most: usize, least: f64) -> Vec<Detection>;
}

/// A dot of a frame, as a tracker uses it.
#[derive(Clone, Debug, PartialEq)]
pub struct Detection {
    /// The critical edge and its label.
    pub critical: Critical,
    /// The positions of the ends of the critical edge.
    pub edge: [Position; 2],
    /// The triangle that names the death.
    pub name: [Located<Slot>; 3],
    /// The same triangle by ids, which are never reused.
    pub triangle: [VertexId; 3],
    /// The last point of its hole to be filled.
    pub hole: Hole,
}

impl Detection {
    /// A detection of a dot by slots.
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

/// The largest number of detections in a frame.
pub const MOST_DETECTIONS: usize = 8192;

/// The detections of a frame.
#[derive(Debug)]
pub struct Detections {
    /// In order.
    pub all: Vec<Detection>,
    /// Whether the rule selects each of them.
    pub is_selected: Vec<bool>,
    /// The number of further dots that the rule selects.
    pub left_out: usize,
}

/// The dots that a rule selects, and those down to the persistence `least` that may continue one of `tracks` tracks.
pub fn detect(rule: TrackRule, (tracks, least): (usize, f64), held: &mut impl DetectionSource) -> Detections {
    let mut selected = select(rule, held);
    let left_out = selected.len().saturating_sub(MOST_DETECTIONS);
    selected.truncate(MOST_DETECTIONS);
    // Not all noise, if tracks have become as faint as noise: a missing dot is likely among the most persistent ones.
    let most = (selected.len().max(tracks) * 3 / 2 + 16).min(MOST_DETECTIONS);
    let mut all = if tracks > 0 { held.detections(most, least) } else { Vec::new() };
    let known: HashSet<[VertexId; 3]> = all.iter().map(|detection| detection.triangle).collect();
    let names: HashSet<[VertexId; 3]> = selected.iter().map(|detection| detection.triangle).collect();
    all.extend(selected.into_iter().filter(|detection| !known.contains(&detection.triangle)));
    in_order(&mut all);
    let is_selected = all.iter().map(|detection| names.contains(&detection.triangle)).collect();
    Detections { all, is_selected, left_out }
}

/// The dots that a rule selects, in order.
fn select(rule: TrackRule, held: &mut impl DetectionSource) -> Vec<Detection> {
    match rule {
        TrackRule::Top(most) => {
            let mut first = held.detections(most.get() as usize, 0.0);
            first.truncate(most.get() as usize);
            first
        }
        TrackRule::Above(least) => held.detections(usize::MAX, least),
        TrackRule::View(spec) => {
            let selection = held.select(spec);
            let rule = ViewRule::new(spec, selection.as_ref());
            let mut shown = held.detections(usize::MAX, rule.least);
            shown.retain(|detection| rule.shows(&detection.critical));
            shown
        }
    }
}

/// Sorts: the most persistent first, equal ones by position.
pub fn in_order(detections: &mut [Detection]) {
    detections.sort_unstable_by(|a, b| {
        let corners = |detection: &Detection| detection.name.map(|site| site.0);
        b.persistence().total_cmp(&a.persistence()).then_with(|| corners(a).cmp(&corners(b)))
    });
}
