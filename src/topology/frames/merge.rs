//! Merging several diffs into one: from where the first starts to where the last leads.
//!
//! In: [`Diff`]s of one view, each of which starts where the one before leads.
//! Out: one [`Diff`]. The contract as an equation: for a run of snapshots it is `first.diff(&last)`. One exception: a
//! vertex that went and came back is in it, removed and added, since diffs do not say where it was. So it is with one
//! of a simplified view that moved and moved back, and with one that was an outlier for a while.
//! Must not know: why diffs are merged.

use std::collections::BTreeMap;

use super::diff::Diff;
use crate::topology::cloud::VertexId;
use crate::topology::skeleton::{Critical, EdgeId};

impl Diff {
    /// The merged diff of a run of diffs.
    pub fn merged<'a>(run: impl IntoIterator<Item = &'a Diff>) -> Diff {
        let mut vertices = Elements::<VertexId, _>::default();
        let mut tree = Elements::<EdgeId, _>::default();
        let mut critical = BTreeMap::<EdgeId, Labels>::new();
        for diff in run {
            diff.vertices_removed.iter().for_each(|&id| vertices.remove(id));
            diff.vertices_added.iter().for_each(|(id, coordinates)| vertices.add(id, coordinates));
            diff.tree_removed.iter().for_each(|&edge| tree.remove(edge));
            diff.tree_added.iter().for_each(|&edge| tree.add(edge, ()));
            note_labels(&mut critical, diff);
        }
        let mut merged = Diff::default();
        for (id, element) in vertices.0 {
            // A vertex that was there and is there has moved, else no diff would contain it.
            merged.vertices_removed.extend(element.was_there.then_some(id));
            merged.vertices_added.extend(element.is.map(|coordinates| (id, coordinates)));
        }
        for (edge, element) in tree.0 {
            match (element.was_there, element.is) {
                (true, None) => merged.tree_removed.push(edge),
                (false, Some(())) => merged.tree_added.push(edge),
                _ => {}
            }
        }
        for Labels { was, is } in critical.into_values() {
            if was == is {
                continue;
            }
            merged.critical_before.extend(was);
            match (was, is) {
                (_, Some(is)) => merged.critical_set.push(is),
                (Some(was), None) => merged.critical_removed.push(was.edge),
                (None, None) => {}
            }
        }
        merged
    }
}

/// The elements that some diff of the run adds or removes.
struct Elements<K, T>(BTreeMap<K, Element<T>>);

struct Element<T> {
    /// Before the run.
    was_there: bool,
    /// After the diffs so far.
    is: Option<T>,
}

impl<K, T> Default for Elements<K, T> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

impl<K: Ord, T> Elements<K, T> {
    fn remove(&mut self, key: K) {
        self.0.entry(key).or_insert(Element { was_there: true, is: None }).is = None;
    }

    fn add(&mut self, key: K, element: T) {
        self.0.entry(key).or_insert(Element { was_there: false, is: None }).is = Some(element);
    }
}

/// A critical edge before the run and after the diffs so far.
#[derive(Default)]
struct Labels {
    was: Option<Critical>,
    is: Option<Critical>,
}

fn note_labels(critical: &mut BTreeMap<EdgeId, Labels>, diff: &Diff) {
    for &was in &diff.critical_before {
        critical.entry(was.edge).or_insert(Labels { was: Some(was), is: None });
    }
    for edge in &diff.critical_removed {
        critical.entry(*edge).or_default().is = None;
    }
    for &is in &diff.critical_set {
        critical.entry(is.edge).or_default().is = Some(is);
    }
}
