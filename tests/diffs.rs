//! The contract of diffs as an equation: `old.apply(&old.diff(&new)) == new`, for frames of random streams in random
//! views.

mod common;

use std::num::NonZeroU32;

use common::clouds::cases;
use common::random_script::scripts;
use common::script::{Script, run};
use hopes::topology::{Diff, Frame, Snapshot, VertexId, ViewSpec};
use proptest::prelude::*;

/// A view. Scales are shares of the frame's largest death.
#[derive(Clone, Copy, Debug)]
enum ViewChoice {
    Full,
    Reduced(f64),
    Derived(NonZeroU32, NonZeroU32),
}

impl ViewChoice {
    fn at(self, frame: &Frame) -> Snapshot {
        let spec = match self {
            ViewChoice::Full => ViewSpec::Full,
            ViewChoice::Reduced(share) => ViewSpec::Reduced { alpha: share * frame.skeleton.largest_death() },
            ViewChoice::Derived(k, l) => ViewSpec::Derived { k, l },
        };
        Snapshot::new(&frame.skeleton, &frame.view(spec))
    }
}

fn looks() -> impl Strategy<Value = ViewChoice> {
    let rank = || (1..5_u32).prop_map(|rank| NonZeroU32::new(rank).expect("ranks start from 1"));
    prop_oneof![
        Just(ViewChoice::Full),
        (0.0..1.2).prop_map(ViewChoice::Reduced),
        (rank(), rank()).prop_map(|(k, l)| ViewChoice::Derived(k, l)),
    ]
}

fn snapshots(script: &Script, look: ViewChoice) -> Vec<Snapshot> {
    let frames = run(script);
    std::iter::once(Snapshot::default()).chain(frames.iter().map(|frame| look.at(frame))).collect()
}

fn assert_canonical(snapshot: &Snapshot) {
    assert!(snapshot.vertices.ids().is_sorted_by(|a, b| a < b));
    assert!(snapshot.tree.is_sorted_by(|a, b| a < b));
    assert!(snapshot.critical.is_sorted_by(|a, b| a.edge < b.edge));
    let edges = snapshot.tree.iter().copied().chain(snapshot.critical.iter().map(|critical| critical.edge));
    assert!(edges.into_iter().all(|[a, b]| a < b), "the smaller end of an edge first");
}

/// Sorted, without duplicates, and without elements that did not change.
fn assert_minimal(diff: &Diff, old: &Snapshot, new: &Snapshot) {
    let rises = |ids: &[VertexId]| ids.is_sorted_by(|a, b| a < b);
    assert!(rises(diff.vertices_added.ids()));
    assert!(rises(&diff.vertices_removed));
    assert!(
        [&diff.tree_added, &diff.tree_removed, &diff.critical_removed].iter().all(|l| l.is_sorted_by(|a, b| a < b))
    );
    assert!(diff.critical_set.is_sorted_by(|a, b| a.edge < b.edge));

    let shows = |snapshot: &Snapshot, vertex| snapshot.vertices.iter().any(|v| v == vertex);
    assert!(diff.vertices_added.iter().all(|v| shows(new, v) && !shows(old, v)));
    assert!(diff.tree_added.iter().all(|e| new.tree.contains(e) && !old.tree.contains(e)));
    assert!(diff.tree_removed.iter().all(|e| old.tree.contains(e) && !new.tree.contains(e)));
    assert!(diff.critical_set.iter().all(|c| new.critical.contains(c) && !old.critical.contains(c)));
    let has = |snapshot: &Snapshot, id| snapshot.vertices.ids().contains(&id);
    assert!(diff.vertices_removed.iter().all(|&id| has(old, id) && !has(new, id)));
    let is_critical = |snapshot: &Snapshot, edge| snapshot.critical.iter().any(|c| c.edge == edge);
    assert!(diff.critical_removed.iter().all(|&edge| is_critical(old, edge) && !is_critical(new, edge)));
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn a_diff_leads_to_the_next_frame(script in scripts(), look in looks()) {
        for pair in snapshots(&script, look).windows(2) {
            let [old, new] = pair else { unreachable!() };
            assert_canonical(new);
            let diff = old.diff(new);
            assert_minimal(&diff, old, new);
            let mirror = old.apply(&diff);
            prop_assert_eq!(mirror.as_ref(), Ok(new));
            prop_assert_eq!(mirror.map(|mirror| mirror.checksum()), Ok(new.checksum()));
            prop_assert_eq!(diff.is_empty(), old == new);
            prop_assert_eq!(old.checksum() == new.checksum(), old == new);
        }
    }

    /// A consumer may change its view, so any snapshot of a stream can be reached from any other.
    #[test]
    fn a_diff_connects_any_two_views(script in scripts(), looks in [looks(), looks()]) {
        let [from, to] = looks.map(|look| snapshots(&script, look));
        for old in &from {
            prop_assert!(old.diff(old).is_empty());
            for new in &to {
                let mirror = old.apply(&old.diff(new));
                prop_assert_eq!(mirror.as_ref(), Ok(new));
            }
        }
    }

    /// On a wrong base a diff fails or gives another checksum.
    #[test]
    fn a_wrong_base_is_always_detected(script in scripts(), look in looks()) {
        let snapshots = snapshots(&script, look);
        for pair in snapshots.windows(2) {
            let [old, new] = pair else { unreachable!() };
            let diff = old.diff(new);
            for base in &snapshots {
                if let Ok(result) = base.apply(&diff) {
                    assert_canonical(&result);
                    prop_assert_eq!(result.checksum() == new.checksum(), &result == new);
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(cases(200))]

    /// Merging consecutive diffs gives the diff between the first and the last frame.
    #[test]
    fn merged_diffs_equal_the_diff_between_the_ends(script in scripts(), look in looks(), cut in 0..8_usize) {
        let snapshots = snapshots(&script, look);
        let first = cut.min(snapshots.len() - 1);
        let diffs: Vec<Diff> = snapshots[first..].windows(2).map(|pair| pair[0].diff(&pair[1])).collect();
        let last = &snapshots[snapshots.len() - 1];
        prop_assert_eq!(Diff::merged(&diffs), snapshots[first].diff(last));
    }
}
