//! Regions of holes that were looked at, kept until something changes that may change them.
//!
//! In: what is asked for, what changes. Out: regions. Invariants: what is given is what would be found; what nobody has asked for in the frame before
//! is forgotten. Must not know: how regions are found, who asks.

use std::collections::HashMap;

use super::region::Region;
use crate::topology::cloud::{Position, VertexId};

/// So many looks at whether a vertex touches a region are taken, at the most; where there would be more, all is forgotten.
const MOST_LOOKS: usize = 1 << 20;

/// What a region depends on, beside its triangles: where it is filled, and what it was about to open to.
pub type HoleName = ([VertexId; 3], [VertexId; 2]);

/// Regions, by their names.
#[derive(Clone, Debug, Default)]
pub struct RegionCache(HashMap<HoleName, Kept>);

#[derive(Clone, Debug)]
struct Kept {
    region: Region,
    /// Whether somebody has asked for it since the change before.
    is_asked_for: bool,
}

impl RegionCache {
    /// The region of a hole; it is found if it is not kept. One that is not there is not kept.
    pub fn get(&mut self, name: HoleName, find: impl FnOnce() -> Option<Region>) -> Region {
        if let Some(kept) = self.0.get_mut(&name) {
            kept.is_asked_for = true;
            return kept.region.clone();
        }
        let Some(region) = find() else { return Region::default() };
        self.0.insert(name, Kept { region: region.clone(), is_asked_for: true });
        region
    }

    /// Vertices have come or gone there.
    pub fn disturb(&mut self, changed: &[Position]) {
        if changed.len().saturating_mul(self.0.len()) > MOST_LOOKS {
            return self.clear();
        }
        self.0.retain(|_, kept| {
            std::mem::take(&mut kept.is_asked_for) && !changed.iter().any(|&vertex| kept.region.is_touched(vertex))
        });
    }

    /// Whether nothing is kept.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    #[cfg(test)]
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// Anything may have changed.
    pub fn clear(&mut self) {
        self.0.clear();
    }
}

#[cfg(test)]
mod tests {
    use std::num::NonZeroU32;

    use proptest::prelude::*;

    use crate::topology::testing::{Points, clouds, lattice, ring};
    use crate::topology::{Options, Pipeline, TrackOptions, TrackRule, Tracker};

    /// A point that comes, or one that goes, by its place among those that are there.
    type Step = (bool, usize, [f64; 2]);

    /// A cloud with holes, and points that come and go, a few a frame.
    fn scripts() -> impl Strategy<Value = (Points, Vec<Vec<Step>>)> {
        let rings = (10..40_u32, 10..40_u32).prop_map(|(a, b)| [ring(a, 1.0), ring(b, 2.5)].concat());
        let grid = (4..9_u32, 4..9_u32).prop_map(|(columns, rows)| lattice(columns, rows));
        let cloud = (clouds(), prop_oneof![rings, grid]).prop_map(|(cloud, holes)| [holes, cloud].concat());
        let near = (-3.0..3.0, -3.0..3.0).prop_map(|(x, y)| [x, y]);
        let node = (0..9, 0..9).prop_map(|(x, y)| [f64::from(x), f64::from(y)]);
        let change = (any::<bool>(), any::<usize>(), prop_oneof![near, node]);
        (cloud, prop::collection::vec(prop::collection::vec(change, 0..4), 1..12))
    }

    /// Of so many dots, which are tracks at once.
    fn tracker(most: u32) -> Tracker {
        let rule = TrackRule::Top(NonZeroU32::new(most).unwrap());
        Tracker::new(TrackOptions { confirm: NonZeroU32::MIN, ..TrackOptions::new(rule) })
    }

    fn apply(pipeline: &mut Pipeline, points: &mut Points, changes: Vec<Step>) {
        for (comes, place, point) in changes {
            if comes || points.is_empty() {
                points.push(point);
                pipeline.feed_points(&[point], None);
            } else {
                let [x, y] = points.swap_remove(place % points.len());
                pipeline.feed_retraction(x, y).unwrap();
            }
        }
        pipeline.commit(None);
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

        #[test]
        fn what_is_kept_is_what_would_be_found((cloud, script) in scripts()) {
            let mut pipeline = Pipeline::new(Options::default()).with_leaf(6);
            let mut tracker = tracker(60);
            let mut points = cloud;
            pipeline.feed_points(&points, None);
            pipeline.commit(None);
            for changes in script {
                pipeline.poll_tracks(&mut tracker);
                let kept = pipeline.track_regions(&tracker);
                let mut other = pipeline.clone();
                other.forget_regions();
                prop_assert_eq!(kept, other.track_regions(&tracker));
                apply(&mut pipeline, &mut points, changes);
            }
        }
    }

    /// How many regions of a ring and a far one have to be found again when points of the far one change.
    #[test]
    fn what_is_out_of_reach_is_not_found_again() {
        let far = |count| ring(count, 1.0).into_iter().map(|[x, y]| [x + 10.0, y]).collect::<Points>();
        let mut pipeline = Pipeline::new(Options::default()).with_leaf(6);
        let mut tracker = tracker(2);
        let mut points = [far(40), ring(40, 1.0)].concat();
        pipeline.feed_points(&points, None);
        pipeline.commit(None);
        pipeline.poll_tracks(&mut tracker);
        assert_eq!(pipeline.track_regions(&tracker).len(), 2);
        let there = points[7];
        apply(&mut pipeline, &mut points, vec![(false, 7, there)]);
        pipeline.poll_frame();
        assert_eq!(pipeline.cached_regions(), 1);
        pipeline.poll_tracks(&mut tracker);
        assert_eq!(pipeline.track_regions(&tracker).len(), 2);
        assert_eq!(pipeline.cached_regions(), 2);
    }
}
