//! The contract of the mirror: after a diff that was applied it equals the original, and it knows when it does not.
//!
//! In: random skeletons, one after the other; diffs and snapshots that this test makes of them by SPEC.md alone. Out: whether the mirror holds what the original does, and whether
//! messages from elsewhere are refused by name. Invariants: positions and labels are compared bit by bit; the checksum is the one of SPEC.md, computed from scratch. Must
//! not know: how the mirror works.

use std::collections::{BTreeMap, BTreeSet};

use hopes_protocol::{Cause, Cut, Diff, FrameInfo, Mirror, MirrorError, Simplify, Snapshot, Thing, View};
use proptest::prelude::*;

type Ends = (u64, u64);

/// What a consumer should hold. Numbers are bits, so that 0.0 and -0.0 differ.
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

    /// What leads from here to there.
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

// ---- random skeletons: few ids and few numbers, so that the same ones come, go, move and come back

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

/// What comes next: how many frames on, and whether as a snapshot.
fn stories() -> impl Strategy<Value = Vec<(Original, u64, bool)>> {
    prop::collection::vec((originals(), 1_u64..4, prop::bool::weighted(0.2)), 1..12)
}

/// A mirror of an original.
fn mirror_of(original: &Original, number: u64) -> Mirror {
    let mut mirror = Mirror::new();
    mirror.apply_snapshot(&original.snapshot(number)).expect("snapshots can always be taken");
    mirror
}

/// Whether the mirror shows the original as of a frame.
fn check_equal(mirror: &Mirror, original: &Original, number: u64) -> Result<(), TestCaseError> {
    prop_assert_eq!(&Original::of(mirror), original);
    prop_assert_eq!(mirror.checksum(), original.checksum());
    prop_assert_eq!((mirror.number(), mirror.frame()), (number, Some(&frame(number))));
    prop_assert!(!mirror.needs_snapshot());
    Ok(())
}

/// Whether a diff is refused for this reason, and the mirror then takes nothing but a snapshot.
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
    fn a_mirror_equals_its_original_after_each_message(story in stories()) {
        let (mut mirror, mut original, mut number) = (Mirror::new(), Original::default(), 0);
        for (next, frames, is_snapshot) in story {
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
    fn merged_diffs_lead_to_the_same(story in stories()) {
        let mut singly = Mirror::new();
        let mut original = Original::default();
        for ((next, ..), number) in story.iter().zip(0..) {
            prop_assert_eq!(singly.apply_diff(&original.diff(number, next, number + 1)), Ok(()));
            original = next.clone();
        }
        let number = story.len() as u64;
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
        // What was held stays in sight: nothing of the diff was applied.
        let mut mirror = mirror_of(&here, 9);
        prop_assert_eq!(mirror.apply_diff(&Diff { from, ..right }), Err(gap));
        prop_assert_eq!((Original::of(&mirror), mirror.number()), (here, 9));
    }

    #[test]
    fn what_is_removed_must_be_there((here, there) in (originals(), originals()), id in 100_u64..200) {
        let right = here.diff(9, &there, 10);
        let missing = |what| MirrorError::Missing { frame: 10, what };
        let mut diff = right.clone();
        diff.vertices_removed.push(id);
        check_refused(mirror_of(&here, 9), &diff, missing(Thing::Vertex(id)), &right)?;
        let mut diff = right.clone();
        diff.edges_removed.push((5, id));
        check_refused(mirror_of(&here, 9), &diff, missing(Thing::Edge(5, id)), &right)?;
        let mut diff = right.clone();
        diff.critical_removed.push((5, id));
        check_refused(mirror_of(&here, 9), &diff, missing(Thing::Critical(5, id)), &right)?;
    }

    #[test]
    fn what_is_added_must_not_be_there((here, there) in (originals(), originals()), pick in any::<prop::sample::Index>()) {
        let right = here.diff(9, &there, 10);
        let there_already = |what| MirrorError::There { frame: 10, what };
        if !there.vertices.is_empty() {
            let (&id, &(x, y)) = there.vertices.iter().nth(pick.index(there.vertices.len())).expect("it is there");
            let mut diff = right.clone();
            diff.vertices_added.push((id, f(x), f(y)));
            check_refused(mirror_of(&here, 9), &diff, there_already(Thing::Vertex(id)), &right)?;
        }
        if !there.edges.is_empty() {
            let &(a, b) = there.edges.iter().nth(pick.index(there.edges.len())).expect("it is there");
            let mut diff = right.clone();
            diff.edges_added.push((a, b));
            check_refused(mirror_of(&here, 9), &diff, there_already(Thing::Edge(a, b)), &right)?;
        }
    }

    #[test]
    fn a_diff_that_leads_elsewhere_fails_its_checksum((here, there) in (originals(), originals()), wrong in 1_u64..) {
        let right = here.diff(9, &there, 10);
        let held = there.checksum();
        let sent = held.wrapping_add(wrong);
        let error = MirrorError::Checksum { frame: 10, sent, held };
        check_refused(mirror_of(&here, 9), &Diff { checksum: sent, ..right.clone() }, error, &right)?;
    }

    /// Whatever single thing is left out or altered: it does not go unseen.
    #[test]
    fn a_diff_with_a_piece_missing_is_refused((here, there) in (originals(), originals()), list in 0..6_usize) {
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

    /// A consumer that holds something else than the diff starts from, though of the same number.
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
        let there_already = |what| Err(MirrorError::There { frame: 10, what });
        let mut twice = good.clone();
        twice.vertices.push(good.vertices[0]);
        prop_assert_eq!(Mirror::new().apply_snapshot(&twice), there_already(Thing::Vertex(good.vertices[0].0)));
        let mut twice = good.clone();
        twice.edges.push(good.edges[0]);
        let (a, b) = good.edges[0];
        prop_assert_eq!(Mirror::new().apply_snapshot(&twice), there_already(Thing::Edge(a, b)));
        // A critical edge that is set again only has its label replaced; whoever counted both has another checksum.
        let mut twice = good.clone();
        let (a, b, birth, death) = good.critical[0];
        twice.critical.push((a, b, birth, death));
        twice.checksum = good.checksum.wrapping_add(h(&[3, a, b, birth.to_bits(), death.to_bits()]));
        let error = MirrorError::Checksum { frame: 10, sent: twice.checksum, held: good.checksum };
        prop_assert_eq!(Mirror::new().apply_snapshot(&twice), Err(error));
    }
}

#[test]
fn a_new_mirror_holds_nothing_and_proves_it() {
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

/// In a simplified view a vertex moves by being removed and added in one diff, its edges staying as they are.
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
        Err(MirrorError::There { frame: 6, what: Thing::Vertex(2) }),
        "added without having been removed"
    );
}

/// 0.0 and -0.0 are equal, but a mirror must hold what was sent.
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
fn errors_say_what_is_wrong_and_what_to_do() {
    let texts = [
        (MirrorError::Gap { holds: 3, from: 5, to: 6 }, "frame 6 starts from frame 5, but the mirror holds frame 3"),
        (MirrorError::Missing { frame: 6, what: Thing::Edge(1, 2) }, "frame 6 removes edge 1-2, which is not there"),
        (MirrorError::There { frame: 6, what: Thing::Vertex(9) }, "frame 6 adds vertex 9, which is there already"),
        (MirrorError::Missing { frame: 6, what: Thing::Critical(1, 2) }, "frame 6 removes critical edge 1-2"),
        (MirrorError::Checksum { frame: 6, sent: 1, held: 255 }, "frame 6 has checksum 0000000000000001"),
        (MirrorError::Lost, "the mirror has lost its place"),
    ];
    for (error, text) in texts {
        let said = error.to_string();
        assert!(said.starts_with(text) && said.ends_with("subscribe again"), "{said}");
    }
}
