//! Detections: the most persistent dots of a frame, as a tracker takes them.
//!
//! In: the current skeleton, and the options and bounds of a tracker.
//! Out: [`Detections`].
//! Invariant: their order depends on positions alone: the most persistent first, equal ones as their kind orders them.
//! Must not know: which detection belongs to which track, what else is told of a dot.

use std::cmp::Ordering;
use std::collections::HashSet;
use std::hash::Hash;

use super::rule::TrackRule;
use crate::topology::frames::{HeldSkeleton, ViewRule};
use crate::topology::skeleton::Critical;

/// A dot of a frame.
pub trait Detected {
    /// What differs between the dots of a frame.
    type Name: Eq + Hash;
    /// The critical edge and its label.
    fn critical(&self) -> &Critical;
    /// Its name.
    fn name(&self) -> Self::Name;
    /// The order by position of dots of equal persistence.
    fn by_position(&self, other: &Self) -> Ordering;

    /// Death minus birth.
    fn persistence(&self) -> f64 {
        let critical = self.critical();
        critical.death - critical.birth
    }
}

/// The current skeleton in a representation that also gives dots as a tracker takes them.
pub trait DetectionSource: HeldSkeleton {
    /// A dot.
    type Detection: Detected;
    /// The most persistent dots down to a persistence, in order: at most `most`, and all that are as persistent as the
    /// last of these.
    fn detections(&mut self, most: usize, least: f64) -> Vec<Self::Detection>;
}

/// The largest number of detections in a frame.
pub const MOST_DETECTIONS: usize = 8192;

/// The detections of a frame.
#[derive(Debug)]
pub struct Detections<D> {
    /// In order.
    pub all: Vec<D>,
    /// Whether the rule selects each of them.
    pub is_selected: Vec<bool>,
    /// The number of further dots that the rule selects.
    pub left_out: usize,
}

/// The dots that a rule selects, and those down to the persistence `least` that may continue one of `tracks` tracks.
pub fn detect<S: DetectionSource>(
    rule: TrackRule,
    (tracks, least): (usize, f64),
    held: &mut S,
) -> Detections<S::Detection> {
    let mut selected = select(rule, held);
    let left_out = selected.len().saturating_sub(MOST_DETECTIONS);
    selected.truncate(MOST_DETECTIONS);
    // Not all noise, if tracks have become as faint as noise: a missing dot is likely among the most persistent ones.
    let most = (selected.len().max(tracks) * 3 / 2 + 16).min(MOST_DETECTIONS);
    let mut all = if tracks > 0 { held.detections(most, least) } else { Vec::new() };
    let known: HashSet<_> = all.iter().map(Detected::name).collect();
    let names: HashSet<_> = selected.iter().map(Detected::name).collect();
    all.extend(selected.into_iter().filter(|detection| !known.contains(&detection.name())));
    in_order(&mut all);
    let is_selected = all.iter().map(|detection| names.contains(&detection.name())).collect();
    Detections { all, is_selected, left_out }
}

/// The dots that a rule selects, in order.
fn select<S: DetectionSource>(rule: TrackRule, held: &mut S) -> Vec<S::Detection> {
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
            shown.retain(|detection| rule.shows(detection.critical()));
            shown
        }
    }
}

/// Sorts: the most persistent first, equal ones by position.
pub fn in_order<D: Detected>(detections: &mut [D]) {
    detections.sort_unstable_by(|a, b| b.persistence().total_cmp(&a.persistence()).then_with(|| a.by_position(b)));
}
