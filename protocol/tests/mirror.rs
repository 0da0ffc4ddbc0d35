//! The contract of the mirror: after a diff was applied it equals the original, and it detects when it does not.
//!
//! In: sequences of random skeletons; diffs and snapshots that this test makes of them by SPEC.md alone. Out: whether
//! the mirror equals the original, and whether messages that do not fit give the right error.
//!
//! Invariants: positions, births and deaths are compared bit by bit. The checksum is computed from scratch by SPEC.md.
//!
//! Must not know: how the mirror works.

use std::collections::{BTreeMap, BTreeSet};

use hopes_protocol::{Cause, Cut, Diff, ElementId, FrameInfo, Mirror, MirrorError, Simplify, Snapshot, View};
use proptest::prelude::*;

type Ends = (u64, u64);

/// The content that a consumer should have. Numbers are stored as bits, so that 0.0 and -0.0 differ.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Original {
    vertices: BTreeMap<u64, (u64, u64)>,
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
    fn of(mirror: &Mirror) -> Self {
        let bits = |&(x, y): &(f64, f64)| (x.to_bits(), y.to_bits());
        Self {
            vertices: mirror.vertices().iter().map(|(&id, at)| (id, bits(at))).collect(),
            edges: mirror.edges().clone(),
            critical: mirror.critical().iter().map(|(&ends, label)| (ends, bits(label))).collect(),
        }
    }

    fn checksum(&self) -> u64 {
        let vertices = self.vertices.iter().map(|(&id, &(x, y))| h(&[1, id, x, y]));
        let edges = self.edges.iter().map(|&(a, b)| h(&[2, a, b]));
        let critical = self.critical.iter().map(|(&(a, b), &(birth, death))| h(&[3, a, b, birth, death]));
        vertices.chain(edges).chain(critical).fold(0, u64::wrapping_add)
    }

    fn snapshot(&self, number: u64) -> Snapshot {
        Snapshot {
            stream: 1,
            cause: Cause::Lagged,
            frame: frame(number),
            vertices: self.vertices.iter().map(|(&id, &(x, y))| (id, f(x), f(y))).collect(),
            edges: self.edges.iter().copied().collect(),
            critical: self.critical.iter().map(|(&(a, b), &(birth, death))| (a, b, f(birth), f(death))).collect(),
            checksum: self.checksum(),
        }
    }

    /// The diff from this content to `there`.
    fn diff(&self, from: u64, there: &Self, to: u64) -> Diff {
        let added = there.vertices.iter().filter(|(id, at)| self.vertices.get(id) != Some(at));
        let removed = self.vertices.iter().filter(|(id, at)| there.vertices.get(id) != Some(at));
        let set = there.critical.iter().filter(|(ends, label)| self.critical.get(ends) != Some(label));
        let gone = self.critical.keys().filter(|ends| !there.critical.contains_key(ends));
        Diff {
            stream: 1,
            from,
            frame: frame(to),
            vertices_added: added.map(|(&id, &(x, y))| (id, f(x), f(y))).collect(),
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
        time: Some(number as f64 / 4.0),
        points: 0,
        vertices: 0,
        rejected: 0,
        view: View { cut: Cut::Reduced(1.0), simplify: Simplify::AtScale },
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

fn originals() -> impl Strategy<Value = Original> {
    let pair = || (numbers(), numbers());
    let ids = prop_oneof![0_u64..8, Just(u64::MAX)];
    let vertices = prop::collection::btree_map(ids, pair(), 0..9);
    let edges = prop::collection::btree_set(ends(), 0..9);
    let critical = prop::collection::btree_map(ends(), pair(), 0..6);
    (vertices, edges, critical).prop_map(|(vertices, edges, critical)| Original { vertices, edges, critical })
}

/// The following contents: how many frames later, and whether each comes as a snapshot.
fn sequences() -> impl Strategy<Value = Vec<(Original, u64, bool)>> {
    prop::collection::vec((originals(), 1_u64..4, prop::bool::weighted(0.2)), 1..12)
}

/// A mirror of an original.
fn mirror_of(original: &Original, number: u64) -> Mirror {
    let mut mirror = Mirror::new();
    mirror.apply_snapshot(&original.snapshot(number)).expect("snapshots can always be taken");
    mirror
}

/// Checks that the mirror shows the original at a frame.
fn check_equal(mirror: &Mirror, original: &Original, number: u64) -> Result<(), TestCaseError> {
    prop_assert_eq!(&Original::of(mirror), original);
    prop_assert_eq!(mirror.checksum(), original.checksum());
    prop_assert_eq!((mirror.number(), mirror.frame()), (number, Some(&frame(number))));
    prop_assert!(!mirror.needs_snapshot());
    Ok(())
}

/// Checks that a diff gives this error, and that the mirror then accepts only a snapshot.
fn check_refused(mut mirror: Mirror, diff: &Diff, error: MirrorError, right: &Diff) -> Result<(), TestCaseError> {
    prop_assert_eq!(mirror.apply_diff(diff), Err(error));
    prop_assert!(mirror.needs_snapshot());
    for next in [right, &Diff { from: mirror.number(), ..right.clone() }, diff] {
        prop_assert_eq!(mirror.apply_diff(next), Err(MirrorError::Lost));
    }
    let healed = Original { edges: BTreeSet::from([(3, 4)]), ..Original::default() };
    prop_assert_eq!(mirror.apply_snapshot(&healed.snapshot(77)), Ok(()));
    check_equal(&mirror, &healed, 77)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    #[test]
    fn a_mirror_equals_its_original_after_each_message(sequence in sequences()) {
        let (mut mirror, mut original, mut number) = (Mirror::new(), Original::default(), 0);
        for (next, frames, is_snapshot) in sequence {
            let applied = if is_snapshot {
                mirror.apply_snapshot(&next.snapshot(number + frames))
            } else {
                mirror.apply_diff(&original.diff(number, &next, number + frames))
            };
            prop_assert_eq!(applied, Ok(()));
            (original, number) = (next, number + frames);
            check_equal(&mirror, &original, number)?;
        }
    }

    #[test]
    fn merged_diffs_give_the_same_result(sequence in sequences()) {
        let mut singly = Mirror::new();
        let mut original = Original::default();
        for ((next, ..), number) in sequence.iter().zip(0..) {
            prop_assert_eq!(singly.apply_diff(&original.diff(number, next, number + 1)), Ok(()));
            original = next.clone();
        }
        let number = sequence.len() as u64;
        let mut at_once = Mirror::new();
        prop_assert_eq!(at_once.apply_diff(&Original::default().diff(0, &original, number)), Ok(()));
        prop_assert_eq!(&at_once, &singly);
        prop_assert_eq!(at_once, mirror_of(&original, number));
    }

    #[test]
    fn a_diff_from_another_frame_is_a_gap((here, there) in (originals(), originals()), from in 0_u64..20) {
        prop_assume!(from != 9);
        let right = here.diff(9, &there, 12);
        let gap = MirrorError::Gap { holds: 9, from, to: 12 };
        check_refused(mirror_of(&here, 9), &Diff { from, ..right.clone() }, gap, &right)?;
        // The content is unchanged: no part of the diff was applied.
        let mut mirror = mirror_of(&here, 9);
        prop_assert_eq!(mirror.apply_diff(&Diff { from, ..right }), Err(gap));
        prop_assert_eq!((Original::of(&mirror), mirror.number()), (here, 9));
    }

    #[test]
    fn removed_elements_must_exist((here, there) in (originals(), originals()), id in 100_u64..200) {
        let right = here.diff(9, &there, 10);
        let missing = |what| MirrorError::Missing { frame: 10, what };
        let mut diff = right.clone();
        diff.vertices_removed.push(id);
        check_refused(mirror_of(&here, 9), &diff, missing(ElementId::Vertex(id)), &right)?;
        let mut diff = right.clone();
        diff.edges_removed.push((5, id));
        check_refused(mirror_of(&here, 9), &diff, missing(ElementId::Edge(5, id)), &right)?;
        let mut diff = right.clone();
        diff.critical_removed.push((5, id));
        check_refused(mirror_of(&here, 9), &diff, missing(ElementId::Critical(5, id)), &right)?;
    }

    #[test]
    fn added_elements_must_not_exist((here, there) in (originals(), originals()), pick in any::<prop::sample::Index>()) {
        let right = here.diff(9, &there, 10);
        let there_already = |what| MirrorError::AlreadyThere { frame: 10, what };
        if !there.vertices.is_empty() {
            let (&id, &(x, y)) = there.vertices.iter().nth(pick.index(there.vertices.len())).expect("it is there");
            let mut diff = right.clone();
            diff.vertices_added.push((id, f(x), f(y)));
            check_refused(mirror_of(&here, 9), &diff, there_already(ElementId::Vertex(id)), &right)?;
        }
        if !there.edges.is_empty() {
            let &(a, b) = there.edges.iter().nth(pick.index(there.edges.len())).expect("it is there");
            let mut diff = right.clone();
            diff.edges_added.push((a, b));
            check_refused(mirror_of(&here, 9), &diff, there_already(ElementId::Edge(a, b)), &right)?;
        }
    }

    #[test]
    fn a_diff_with_another_result_fails_its_checksum((here, there) in (originals(), originals()), wrong in 1_u64..) {
        let right = here.diff(9, &there, 10);
        let held = there.checksum();
        let sent = held.wrapping_add(wrong);
        let error = MirrorError::Checksum { frame: 10, sent, held };
        check_refused(mirror_of(&here, 9), &Diff { checksum: sent, ..right.clone() }, error, &right)?;
    }

    /// Leaving out or changing any single element is detected.
    #[test]
    fn an_incomplete_diff_is_refused((here, there) in (originals(), originals()), list in 0..6_usize) {
        let right = here.diff(9, &there, 10);
        let mut diff = right.clone();
        let left_out = match list {
            0 => diff.vertices_added.pop().is_some(),
            1 => diff.vertices_removed.pop().is_some(),
            2 => diff.edges_added.pop().is_some(),
            3 => diff.edges_removed.pop().is_some(),
            4 => diff.critical_set.pop().is_some(),
            _ => diff.critical_removed.pop().is_some(),
        };
        let mut mirror = mirror_of(&here, 9);
        let applied = mirror.apply_diff(&diff);
        prop_assert_eq!(applied.is_err(), left_out, "{:?}", applied);
        prop_assert_eq!(mirror.needs_snapshot(), left_out);
    }

    /// A consumer has a frame with the right number, but with other content.
    #[test]
    fn a_diff_of_another_original_is_refused((here, elsewhere, there) in (originals(), originals(), originals())) {
        prop_assume!(here != elsewhere);
        let mut mirror = mirror_of(&elsewhere, 9);
        let applied = mirror.apply_diff(&here.diff(9, &there, 10));
        prop_assert!(applied.is_err() || Original::of(&mirror) == there, "{applied:?}");
        prop_assert_eq!(applied.is_err(), mirror.needs_snapshot());
    }

    #[test]
    fn a_bad_snapshot_is_refused_and_a_good_one_helps((here, there) in (originals(), originals()), wrong in 1_u64..) {
        let good = there.snapshot(10);
        let sent = good.checksum.wrapping_add(wrong);
        let mut mirror = mirror_of(&here, 9);
        let error = MirrorError::Checksum { frame: 10, sent, held: good.checksum };
        prop_assert_eq!(mirror.apply_snapshot(&Snapshot { checksum: sent, ..good.clone() }), Err(error));
        prop_assert_eq!(mirror.apply_diff(&there.diff(10, &here, 11)), Err(MirrorError::Lost));
        prop_assert_eq!(mirror.apply_snapshot(&good), Ok(()));
        check_equal(&mirror, &there, 10)?;
        prop_assert_eq!(mirror.apply_diff(&there.diff(10, &here, 11)), Ok(()));
        check_equal(&mirror, &here, 11)?;
    }

    #[test]
    fn a_snapshot_that_lists_something_twice_is_refused(there in originals()) {
        prop_assume!(!there.vertices.is_empty() && !there.edges.is_empty() && !there.critical.is_empty());
        let good = there.snapshot(10);
        let there_already = |what| Err(MirrorError::AlreadyThere { frame: 10, what });
        let mut twice = good.clone();
        twice.vertices.push(good.vertices[0]);
        prop_assert_eq!(Mirror::new().apply_snapshot(&twice), there_already(ElementId::Vertex(good.vertices[0].0)));
        let mut twice = good.clone();
        twice.edges.push(good.edges[0]);
        let (a, b) = good.edges[0];
        prop_assert_eq!(Mirror::new().apply_snapshot(&twice), there_already(ElementId::Edge(a, b)));
        // A critical edge that is set again only gets a new birth and death. A mirror that counted both would have
        // another checksum.
        let mut twice = good.clone();
        let (a, b, birth, death) = good.critical[0];
        twice.critical.push((a, b, birth, death));
        twice.checksum = good.checksum.wrapping_add(h(&[3, a, b, birth.to_bits(), death.to_bits()]));
        let error = MirrorError::Checksum { frame: 10, sent: twice.checksum, held: good.checksum };
        prop_assert_eq!(Mirror::new().apply_snapshot(&twice), Err(error));
    }
}

#[test]
fn a_new_mirror_is_empty_and_has_the_checksum_0() {
    let mut mirror = Mirror::new();
    assert_eq!((Original::of(&mirror), mirror.checksum(), mirror.number()), (Original::default(), 0, 0));
    assert_eq!((mirror.frame(), mirror.needs_snapshot()), (None, false));
    let nothing = Original::default();
    assert_eq!(
        mirror.apply_diff(&nothing.diff(4, &nothing, 5)),
        Err(MirrorError::Gap { holds: 0, from: 4, to: 5 }),
        "a diff that does not start from nothing needs a snapshot before it"
    );
}

/// In a simplified view a vertex moves when one diff removes and adds it. Its edges stay.
#[test]
fn a_vertex_of_a_simplified_view_moves() {
    let at = |x: f64, y: f64| (x.to_bits(), y.to_bits());
    let vertices = BTreeMap::from([(1, at(0.0, 0.0)), (2, at(1.0, 0.0)), (3, at(2.0, 0.0))]);
    let before = Original { vertices, edges: BTreeSet::from([(1, 2), (2, 3)]), critical: BTreeMap::new() };
    let mut after = before.clone();
    after.vertices.insert(2, at(1.25, -0.0));
    let diff = before.diff(5, &after, 6);
    assert_eq!((diff.vertices_removed.as_slice(), diff.vertices_added.as_slice()), (&[2][..], &[(2, 1.25, -0.0)][..]));
    assert!(diff.edges_added.is_empty() && diff.edges_removed.is_empty());
    let mut mirror = mirror_of(&before, 5);
    assert_eq!(mirror.apply_diff(&diff), Ok(()));
    assert_eq!(Original::of(&mirror), after);
    assert_eq!(
        mirror_of(&before, 5).apply_diff(&Diff { vertices_removed: vec![], ..diff }),
        Err(MirrorError::AlreadyThere { frame: 6, what: ElementId::Vertex(2) }),
        "added without having been removed"
    );
}

/// 0.0 and -0.0 are equal, but a mirror must hold the value that was sent.
#[test]
fn a_vertex_moves_from_zero_to_minus_zero() {
    let one = |x: f64| Original { vertices: BTreeMap::from([(1, (x.to_bits(), 0))]), ..Original::default() };
    let diff = one(0.0).diff(1, &one(-0.0), 2);
    assert_eq!((diff.vertices_removed.len(), diff.vertices_added.len()), (1, 1));
    let mut mirror = mirror_of(&one(0.0), 1);
    assert_eq!(mirror.apply_diff(&diff), Ok(()));
    assert_eq!(Original::of(&mirror), one(-0.0));
}

#[test]
fn errors_state_the_cause_and_the_remedy() {
    let texts = [
        (MirrorError::Gap { holds: 3, from: 5, to: 6 }, "frame 6 starts from frame 5, but the mirror holds frame 3"),
        (
            MirrorError::Missing { frame: 6, what: ElementId::Edge(1, 2) },
            "frame 6 removes edge 1-2, which is not there",
        ),
        (
            MirrorError::AlreadyThere { frame: 6, what: ElementId::Vertex(9) },
            "frame 6 adds vertex 9, which is there already",
        ),
        (MirrorError::Missing { frame: 6, what: ElementId::Critical(1, 2) }, "frame 6 removes critical edge 1-2"),
        (MirrorError::Checksum { frame: 6, sent: 1, held: 255 }, "frame 6 has checksum 0000000000000001"),
        (MirrorError::Lost, "the mirror has lost its place"),
    ];
    for (error, text) in texts {
        let said = error.to_string();
        assert!(said.starts_with(text) && said.ends_with("subscribe again"), "{said}");
    }
}
