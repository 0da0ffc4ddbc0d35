//! The contract of the mirror of a space: after a diff was applied it equals the original, in any dimension, and it
//! refuses what does not fit.
//!
//! In: sequences of random skeletons in 1, 3 and 20 dimensions; diffs and snapshots that this test makes of them by
//! SPEC.md alone. Out: whether the mirror equals the original, and whether messages that do not fit give the right
//! error.
//!
//! Invariants: coordinates are compared bit by bit. The checksum is computed from scratch by SPEC.md.
//!
//! Must not know: how the mirror works.

use std::collections::{BTreeMap, BTreeSet};

use hopes_protocol::{
    Cause, Cut, FrameInfo, Happening, Metric, Mirror, MirrorError, Place, Simplify, Snapshot, SpaceDiff, SpaceMirror,
    SpaceSnapshot, SpaceTrack, SpaceTrackEvent, SpaceTrackMirror, SpaceTracks, TrackMirrorError, View,
};
use proptest::prelude::*;

type Ends = (u64, u64);

const DIMENSIONS: [usize; 3] = [1, 3, 20];

/// The content that a consumer should have. Numbers are stored as bits, so that 0.0 and -0.0 differ.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Original {
    vertices: BTreeMap<u64, Vec<u64>>,
    edges: BTreeSet<Ends>,
    critical: BTreeMap<Ends, (u64, u64)>,
}

fn f(bits: u64) -> f64 {
    f64::from_bits(bits)
}

/// The hash of SPEC.md, section 7.
fn h(words: &[u64]) -> u64 {
    let mut hash = 0_u64;
    for word in words {
        let mut z = (hash ^ word).wrapping_add(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        hash = z ^ (z >> 31);
    }
    hash
}

impl Original {
    fn of(mirror: &SpaceMirror) -> Self {
        let bits = |numbers: &[f64]| numbers.iter().map(|number| number.to_bits()).collect();
        let label = |&(birth, death): &(f64, f64)| (birth.to_bits(), death.to_bits());
        Self {
            vertices: mirror.vertices().iter().map(|(&id, at)| (id, bits(at))).collect(),
            edges: mirror.edges().clone(),
            critical: mirror.critical().iter().map(|(&ends, at)| (ends, label(at))).collect(),
        }
    }

    fn checksum(&self) -> u64 {
        let vertices = self.vertices.iter().map(|(&id, at)| h(&[&[1, id], &at[..]].concat()));
        let edges = self.edges.iter().map(|&(a, b)| h(&[2, a, b]));
        let critical = self.critical.iter().map(|(&(a, b), &(birth, death))| h(&[3, a, b, birth, death]));
        vertices.chain(edges).chain(critical).fold(0, u64::wrapping_add)
    }

    fn snapshot(&self, dimension: usize, number: u64) -> SpaceSnapshot {
        SpaceSnapshot {
            stream: 1,
            cause: Cause::Start,
            frame: frame(number),
            metric: Metric::Chebyshev,
            dimension: dimension as u32,
            ids: self.vertices.keys().copied().collect(),
            coordinates: self.vertices.values().flatten().map(|&bits| f(bits)).collect(),
            edges: self.edges.iter().copied().collect(),
            critical: self.critical.iter().map(|(&(a, b), &(birth, death))| (a, b, f(birth), f(death))).collect(),
            checksum: self.checksum(),
        }
    }

    /// The diff from this content to `there`.
    fn diff(&self, dimension: usize, from: u64, there: &Self, to: u64) -> SpaceDiff {
        let is_new = |(id, at): &(&u64, &Vec<u64>)| self.vertices.get(id) != Some(at);
        let added: Vec<(&u64, &Vec<u64>)> = there.vertices.iter().filter(is_new).collect();
        let removed = self.vertices.iter().filter(|(id, at)| there.vertices.get(id) != Some(at));
        let set = there.critical.iter().filter(|(ends, label)| self.critical.get(ends) != Some(label));
        let gone = self.critical.keys().filter(|ends| !there.critical.contains_key(ends));
        SpaceDiff {
            stream: 1,
            from,
            frame: frame(to),
            dimension: dimension as u32,
            ids_added: added.iter().map(|(id, _)| **id).collect(),
            coordinates_added: added.iter().flat_map(|(_, at)| at.iter().map(|&bits| f(bits))).collect(),
            vertices_removed: removed.map(|(&id, _)| id).collect(),
            edges_added: there.edges.difference(&self.edges).copied().collect(),
            edges_removed: self.edges.difference(&there.edges).copied().collect(),
            critical_set: set.map(|(&(a, b), &(birth, death))| (a, b, f(birth), f(death))).collect(),
            critical_removed: gone.copied().collect(),
            checksum: there.checksum(),
        }
    }
}

fn frame(number: u64) -> FrameInfo {
    FrameInfo {
        number,
        time: None,
        points: 0,
        vertices: 0,
        rejected: 0,
        view: View { cut: Cut::Full, simplify: Simplify::No },
        ds: None,
        vs: None,
        components: 0,
        cycles: 0,
    }
}

// ---- random skeletons: few ids and few numbers, so that elements are added, moved, removed and added again

fn numbers() -> impl Strategy<Value = u64> {
    prop::sample::select(vec![0.0, -0.0, 1.0, -1.5, 5e-324, f64::MAX]).prop_map(f64::to_bits)
}

fn ends() -> impl Strategy<Value = Ends> {
    (0_u64..7, 1_u64..7).prop_map(|(a, more)| (a, a + more))
}

fn originals(dimension: usize) -> impl Strategy<Value = Original> {
    let ids = prop_oneof![0_u64..8, Just(u64::MAX)];
    let position = prop::collection::vec(numbers(), dimension);
    let death = prop_oneof![numbers(), Just(f64::INFINITY.to_bits())];
    let vertices = prop::collection::btree_map(ids, position, 0..9);
    let edges = prop::collection::btree_set(ends(), 0..9);
    let critical = prop::collection::btree_map(ends(), (numbers(), death), 0..6);
    (vertices, edges, critical).prop_map(|(vertices, edges, critical)| Original { vertices, edges, critical })
}

fn dimensions() -> impl Strategy<Value = usize> {
    prop::sample::select(DIMENSIONS.to_vec())
}

/// A dimension, and the following contents: how many frames later, and whether each comes as a snapshot.
fn sequences() -> impl Strategy<Value = (usize, Vec<(Original, u64, bool)>)> {
    let sequence = |dimension| {
        let step = (originals(dimension), 1_u64..4, prop::bool::weighted(0.2));
        (Just(dimension), prop::collection::vec(step, 1..10))
    };
    dimensions().prop_flat_map(sequence)
}

fn two() -> impl Strategy<Value = (usize, Original, Original)> {
    dimensions().prop_flat_map(|dimension| (Just(dimension), originals(dimension), originals(dimension)))
}

fn mirror_of(original: &Original, dimension: usize) -> SpaceMirror {
    let mut mirror = SpaceMirror::default();
    mirror.apply_space_snapshot(&original.snapshot(dimension, 9)).expect("snapshots can always be taken");
    mirror
}

/// Applies a diff that must not fit. After it, only a snapshot helps.
fn refusal(mut mirror: SpaceMirror, diff: &SpaceDiff) -> MirrorError {
    let error = mirror.apply_space_diff(diff).expect_err("it does not fit");
    assert!(mirror.needs_snapshot());
    assert_eq!(mirror.apply_space_diff(diff), Err(MirrorError::Lost));
    let healed = Original { vertices: BTreeMap::from([(3, vec![0; 5])]), ..Original::default() };
    assert_eq!(mirror.apply_space_snapshot(&healed.snapshot(5, 77)), Ok(()), "a snapshot of another space, too");
    assert_eq!((Original::of(&mirror), mirror.needs_snapshot()), (healed, false));
    error
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    #[test]
    fn a_mirror_equals_its_original_after_each_message((dimension, sequence) in sequences()) {
        let (mut mirror, mut original, mut number) = (SpaceMirror::default(), Original::default(), 0);
        for (next, frames, is_snapshot) in sequence {
            let applied = if is_snapshot {
                mirror.apply_space_snapshot(&next.snapshot(dimension, number + frames))
            } else {
                mirror.apply_space_diff(&original.diff(dimension, number, &next, number + frames))
            };
            prop_assert_eq!(applied, Ok(()));
            (original, number) = (next, number + frames);
            prop_assert_eq!(&Original::of(&mirror), &original);
            prop_assert_eq!((mirror.checksum(), mirror.number()), (original.checksum(), number));
            prop_assert_eq!(mirror.place().dimension, dimension as u32);
        }
    }

    #[test]
    fn an_incomplete_diff_is_refused((dimension, here, there) in two(), list in 0..6_usize) {
        let mut diff = here.diff(dimension, 9, &there, 10);
        let left_out = match list {
            0 => {
                let rest = diff.coordinates_added.len().saturating_sub(dimension);
                diff.coordinates_added.truncate(rest);
                diff.ids_added.pop().is_some()
            }
            1 => diff.vertices_removed.pop().is_some(),
            2 => diff.edges_added.pop().is_some(),
            3 => diff.edges_removed.pop().is_some(),
            4 => diff.critical_set.pop().is_some(),
            _ => diff.critical_removed.pop().is_some(),
        };
        let mut mirror = mirror_of(&here, dimension);
        let applied = mirror.apply_space_diff(&diff);
        prop_assert_eq!(applied.is_err(), left_out, "{:?}", applied);
        prop_assert_eq!(mirror.needs_snapshot(), left_out);
    }

    #[test]
    fn another_dimension_is_refused((dimension, here, there) in two(), other in 0_u32..25) {
        let held = dimension as u32;
        prop_assume!(other != held);
        let diff = SpaceDiff { dimension: other, ..here.diff(dimension, 9, &there, 10) };
        let error = MirrorError::Dimension { frame: 10, found: other, held };
        prop_assert_eq!(refusal(mirror_of(&here, dimension), &diff), error);
    }

    #[test]
    fn coordinates_that_are_no_whole_points_are_refused((dimension, here, there) in two(), more in 1_usize..25) {
        let right = here.diff(dimension, 9, &there, 10);
        let mut diff = right.clone();
        diff.coordinates_added.resize(right.coordinates_added.len() + more, 0.5);
        let (coordinates, vertices) = (diff.coordinates_added.len(), diff.ids_added.len());
        let error = MirrorError::Coordinates { frame: 10, coordinates, vertices, dimension: dimension as u32 };
        prop_assert_eq!(refusal(mirror_of(&here, dimension), &diff), error);
        let mut snapshot = there.snapshot(dimension, 10);
        snapshot.ids.push(100);
        let (coordinates, vertices) = (snapshot.coordinates.len(), snapshot.ids.len());
        let error = MirrorError::Coordinates { frame: 10, coordinates, vertices, dimension: dimension as u32 };
        prop_assert_eq!(SpaceMirror::default().apply_space_snapshot(&snapshot), Err(error));
    }

    #[test]
    fn coordinates_that_are_not_finite_are_refused(
        (dimension, here, there) in two(),
        at in any::<prop::sample::Index>(),
        wrong in prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY]),
    ) {
        let mut diff = here.diff(dimension, 9, &there, 10);
        prop_assume!(!diff.ids_added.is_empty());
        let at = at.index(diff.coordinates_added.len());
        diff.coordinates_added[at] = wrong;
        let vertex = diff.ids_added[at / dimension];
        let error = MirrorError::NotFinite { frame: 10, vertex };
        prop_assert_eq!(refusal(mirror_of(&here, dimension), &diff), error);
    }
}

/// The first point fixes the dimension. Before that it is 0, and there are no vertices.
#[test]
fn a_stream_without_points_has_the_dimension_0() {
    let (nothing, one) = (Original::default(), Original { vertices: [(4, vec![0; 7])].into(), ..Original::default() });
    let mut mirror = SpaceMirror::default();
    assert_eq!(mirror.place(), Place { metric: None, dimension: 0 });
    assert_eq!(mirror.apply_space_snapshot(&nothing.snapshot(0, 1)), Ok(()));
    assert_eq!(mirror.place(), Place { metric: Some(Metric::Chebyshev), dimension: 0 });
    assert_eq!(mirror.apply_space_diff(&nothing.diff(0, 1, &nothing, 2)), Ok(()));
    assert_eq!(mirror.apply_space_diff(&nothing.diff(7, 2, &one, 3)), Ok(()));
    assert_eq!(mirror.place(), Place { metric: Some(Metric::Chebyshev), dimension: 7 });
    let mut without = one.snapshot(0, 4);
    without.coordinates.clear();
    let error = MirrorError::Coordinates { frame: 4, coordinates: 0, vertices: 1, dimension: 0 };
    assert_eq!(mirror.apply_space_snapshot(&without), Err(error), "a vertex has at least one coordinate");
}

/// The product of ids and dimension is not computed beyond what a number holds, and takes no memory.
#[test]
fn a_huge_dimension_takes_no_memory() {
    let mut snapshot = Original::default().snapshot(3, 1);
    snapshot.dimension = u32::MAX;
    assert_eq!(SpaceMirror::default().apply_space_snapshot(&snapshot), Ok(()), "nothing has any dimension");
    snapshot.ids = (0..1000).collect();
    let error = MirrorError::Coordinates { frame: 1, coordinates: 0, vertices: 1000, dimension: u32::MAX };
    assert_eq!(SpaceMirror::default().apply_space_snapshot(&snapshot), Err(error));
}

/// In two dimensions the checksum is that of the plane.
#[test]
fn two_dimensions_have_the_checksum_of_the_plane() {
    let at = |x: f64, y: f64| vec![x.to_bits(), y.to_bits()];
    let vertices = BTreeMap::from([(0, at(0.0, 0.5)), (3, at(-1.0, 2.0))]);
    let original = Original { vertices, edges: [(0, 3)].into(), critical: BTreeMap::new() };
    let sent = original.snapshot(2, 9);
    let points = sent.coordinates.chunks_exact(2);
    let vertices = sent.ids.iter().zip(points).map(|(&id, point)| (id, point[0], point[1])).collect();
    let SpaceSnapshot { stream, cause, frame, edges, critical, checksum, .. } = sent;
    let mut plane = Mirror::new();
    let snapshot = Snapshot { stream, cause, frame, vertices, edges, critical, checksum };
    assert_eq!(plane.apply_snapshot(&snapshot), Ok(()));
    assert_eq!(plane.checksum(), mirror_of(&original, 2).checksum());
}

#[test]
fn errors_state_the_cause_and_the_remedy() {
    let texts = [
        (
            MirrorError::Dimension { frame: 6, found: 3, held: 2 },
            "frame 6 has vertices of 3 coordinates, but the mirror holds 2",
        ),
        (
            MirrorError::Coordinates { frame: 6, coordinates: 7, vertices: 2, dimension: 3 },
            "frame 6 has 7 coordinates for 2 vertices of 3 each",
        ),
        (MirrorError::NotFinite { frame: 6, vertex: 9 }, "frame 6 has a coordinate of vertex 9 that is not finite"),
    ];
    for (error, text) in texts {
        let said = error.to_string();
        assert!(said.starts_with(text) && said.ends_with("subscribe again"), "{said}");
    }
}

// ---- tracks: the rules are those of the plane, which `track_mirror` tests; here are those of coordinates

fn track(id: u64, center: &[f64], velocity: &[f64]) -> SpaceTrack {
    let (center, velocity) = (center.to_vec(), velocity.to_vec());
    SpaceTrack { id, age: 1, birth: 0.5, death: None, center, radius: 1.5, velocity, selected: true }
}

fn start(tracks: Vec<SpaceTrack>) -> SpaceTracks {
    SpaceTracks { stream: 1, from: 0, frame: 5, time: None, events: vec![], alive: Some(tracks), cycles: vec![] }
}

#[test]
fn tracks_of_a_space_begin_change_and_end() {
    let mut mirror = SpaceTrackMirror::default();
    let [first, second] = [track(1, &[0.0; 3], &[0.0; 3]), track(2, &[1.0; 3], &[0.5; 3])];
    assert_eq!(mirror.apply(&start(vec![first.clone()])), Ok(()));
    let event =
        |frame, happening, track: &SpaceTrack| SpaceTrackEvent { frame, time: None, happening, track: track.clone() };
    let events = vec![event(6, Happening::Born, &second), event(7, Happening::Died, &first)];
    let later = SpaceTracks { from: 5, frame: 7, events, alive: None, ..start(vec![]) };
    assert_eq!(mirror.apply(&later), Ok(()));
    assert_eq!(mirror.alive(), &BTreeMap::from([(2, second)]));
}

#[test]
fn tracks_whose_coordinates_do_not_fit_are_refused() {
    let right = track(1, &[0.0; 3], &[0.0; 3]);
    let error = |track| Err(TrackMirrorError::Coordinates { frame: 5, track });
    for wrong in [
        track(2, &[0.0; 2], &[0.0; 2]),
        track(2, &[0.0; 3], &[0.0; 2]),
        track(2, &[0.0, f64::NAN, 0.0], &[0.0; 3]),
        track(2, &[0.0; 3], &[0.0, 0.0, f64::INFINITY]),
    ] {
        let mut mirror = SpaceTrackMirror::default();
        assert_eq!(mirror.apply(&start(vec![right.clone(), wrong.clone()])), error(2), "{wrong:?}");
        assert!(mirror.needs_start());
        assert_eq!(mirror.apply(&start(vec![right.clone()])), Ok(()), "a new start helps");
        let born = SpaceTrackEvent { frame: 6, time: None, happening: Happening::Born, track: wrong };
        let later = SpaceTracks { from: 5, frame: 6, events: vec![born], alive: None, ..start(vec![]) };
        assert_eq!(mirror.apply(&later), Err(TrackMirrorError::Coordinates { frame: 6, track: 2 }));
        assert_eq!(mirror.apply(&later), Err(TrackMirrorError::Lost));
    }
    for alone in [track(2, &[0.0], &[0.0; 2]), track(2, &[f64::NAN], &[0.0]), track(2, &[0.0], &[f64::INFINITY])] {
        assert_eq!(SpaceTrackMirror::default().apply(&start(vec![alone.clone()])), error(2), "{alone:?}");
    }
}
