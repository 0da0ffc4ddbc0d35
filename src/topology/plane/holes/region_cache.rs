//! A cache of the regions of holes.
//!
//! In: names of holes, positions at which vertices appear or vanish.
//! Out: regions.
//! Invariants: a cached region equals the one that would be found. A region that was not used since the last change is
//! dropped.
//! Must not know: how regions are found, what they are used for.

use std::collections::HashMap;

use super::region::Region;
use crate::topology::cloud::{Position, VertexId};

/// The most tests of a vertex against a region in one change. Beyond it the cache is cleared.
const MOST_TESTS: usize = 1 << 20;

/// The name of a hole: the triangle at which it is filled and its critical edge. Beside the cloud near it, its region
/// depends on nothing else.
pub type HoleName = ([VertexId; 3], [VertexId; 2]);

/// Regions by the names of their holes.
#[derive(Clone, Debug, Default)]
pub struct RegionCache(HashMap<HoleName, CachedRegion>);

#[derive(Clone, Debug)]
struct CachedRegion {
    region: Region,
    /// Whether it was used since the last change.
    is_used: bool,
}

impl RegionCache {
    /// The region of a hole; it is found if it is not cached. A hole that is not found is not cached.
    pub fn get(&mut self, name: HoleName, find: impl FnOnce() -> Option<Region>) -> Region {
        if let Some(cached) = self.0.get_mut(&name) {
            cached.is_used = true;
            return cached.region.clone();
        }
        let Some(region) = find() else { return Region::default() };
        self.0.insert(name, CachedRegion { region: region.clone(), is_used: true });
        region
    }

    /// Drops the regions that vertices at these positions may have changed, and those that were not used.
    pub fn invalidate(&mut self, changed: &[Position]) {
        if changed.len().saturating_mul(self.0.len()) > MOST_TESTS {
            return self.clear();
        }
        self.0.retain(|_, cached| {
            std::mem::take(&mut cached.is_used) && !changed.iter().any(|&vertex| cached.region.is_touched(vertex))
        });
    }

    /// Whether nothing is cached.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    #[cfg(test)]
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// Drops all regions.
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

    /// A point that appears, or one that vanishes, by its place among the current ones.
    type Step = (bool, usize, [f64; 2]);

    /// A cloud with holes, and some points that appear or vanish in each frame.
    fn scripts() -> impl Strategy<Value = (Points, Vec<Vec<Step>>)> {
        let rings = (10..40_u32, 10..40_u32).prop_map(|(a, b)| [ring(a, 1.0), ring(b, 2.5)].concat());
        let grid = (4..9_u32, 4..9_u32).prop_map(|(columns, rows)| lattice(columns, rows));
        let cloud = (clouds(), prop_oneof![rings, grid]).prop_map(|(cloud, holes)| [holes, cloud].concat());
        let near = (-3.0..3.0, -3.0..3.0).prop_map(|(x, y)| [x, y]);
        let node = (0..9, 0..9).prop_map(|(x, y)| [f64::from(x), f64::from(y)]);
        let change = (any::<bool>(), any::<usize>(), prop_oneof![near, node]);
        (cloud, prop::collection::vec(prop::collection::vec(change, 0..4), 1..12))
    }

    /// Tracks the most persistent dots from their first frame on.
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
        fn cached_regions_equal_found_ones((cloud, script) in scripts()) {
            let mut pipeline = Pipeline::new(Options::default()).with_leaf(6);
            let mut tracker = tracker(60);
            let mut points = cloud;
            pipeline.feed_points(&points, None);
            pipeline.commit(None);
            for changes in script {
                pipeline.poll_tracks(&mut tracker);
                let cached = pipeline.track_regions(&tracker);
                let mut other = pipeline.clone();
                other.forget_regions();
                prop_assert_eq!(cached, other.track_regions(&tracker));
                apply(&mut pipeline, &mut points, changes);
            }
        }
    }

    /// Two rings. Points of the far one change; the region of the other stays cached.
    #[test]
    fn regions_out_of_reach_stay_cached() {
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
