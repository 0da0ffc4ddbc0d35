//! A mirror against a plain model of it: any snapshots and diffs, right and wrong ones, lead to the content that they
//! say or to the error.
//!
//! The input: steps, by `arbitrary`.
#![no_main]

use std::collections::{BTreeMap, BTreeSet};

use arbitrary::Arbitrary;
use hopes_protocol::{Cause, Checksum, Critical, Cut, Diff, Edge, FrameInfo, Mirror, Simplify, Snapshot, Vertex, View};
use libfuzzer_sys::fuzz_target;

/// Ids are few, so that steps meet the same elements.
type Id = u8;

#[derive(Arbitrary, Debug)]
struct Step {
    is_snapshot: bool,
    /// Whether the diff starts from another frame than the mirror's.
    from: Option<u8>,
    /// How many frames it leads on.
    by: u8,
    added: Elements,
    vertices_removed: Vec<Id>,
    edges_removed: Vec<(Id, Id)>,
    critical_removed: Vec<(Id, Id)>,
    /// What the checksum is off by.
    off: u8,
}

#[derive(Arbitrary, Debug)]
struct Elements {
    vertices: Vec<(Id, i8)>,
    edges: Vec<(Id, Id)>,
    critical: Vec<(Id, Id, i8)>,
}

impl Elements {
    fn vertices(&self) -> Vec<Vertex> {
        self.vertices.iter().map(|&(id, at)| (id.into(), at.into(), -f64::from(at))).collect()
    }

    fn critical(&self) -> Vec<Critical> {
        self.critical.iter().map(|&(a, b, birth)| (a.into(), b.into(), birth.into(), f64::from(birth) + 1.0)).collect()
    }
}

fn edges(edges: &[(Id, Id)]) -> Vec<Edge> {
    edges.iter().map(|&(a, b)| (a.into(), b.into())).collect()
}

/// What a mirror should hold.
#[derive(Clone, Debug, Default, PartialEq)]
struct Content {
    vertices: BTreeMap<u64, (f64, f64)>,
    edges: BTreeSet<Edge>,
    critical: BTreeMap<Edge, (f64, f64)>,
}

impl Content {
    fn of(mirror: &Mirror) -> Self {
        let (vertices, edges, critical) =
            (mirror.vertices().clone(), mirror.edges().clone(), mirror.critical().clone());
        Self { vertices, edges, critical }
    }

    /// None: the diff does not fit.
    fn after(mut self, diff: &Diff) -> Option<Self> {
        let fits = diff.vertices_removed.iter().all(|id| self.vertices.remove(id).is_some())
            && diff.vertices_added.iter().all(|&(id, x, y)| self.vertices.insert(id, (x, y)).is_none())
            && diff.edges_removed.iter().all(|edge| self.edges.remove(edge))
            && diff.edges_added.iter().all(|edge| self.edges.insert(*edge))
            && diff.critical_removed.iter().all(|edge| self.critical.remove(edge).is_some());
        self.critical.extend(diff.critical_set.iter().map(|&(a, b, birth, death)| ((a, b), (birth, death))));
        fits.then_some(self)
    }

    /// The checksum of a mirror that does not look whether vertices and edges are there.
    fn careless_checksum(&self, diff: &Diff) -> u64 {
        let mut sum = Checksum(self.checksum());
        let removed = diff.vertices_removed.iter().filter_map(|id| self.vertices.get_key_value(id));
        removed.for_each(|(&id, &(x, y))| sum.remove((id, x, y)));
        diff.vertices_added.iter().for_each(|&vertex| sum.add(vertex));
        diff.edges_removed.iter().for_each(|&edge| sum.remove(edge));
        diff.edges_added.iter().for_each(|&edge| sum.add(edge));
        sum.0
    }

    fn checksum(&self) -> u64 {
        let mut sum = Checksum::default();
        self.vertices.iter().for_each(|(&id, &(x, y))| sum.add((id, x, y)));
        self.edges.iter().for_each(|&edge| sum.add(edge));
        self.critical.iter().for_each(|(&(a, b), &(birth, death))| sum.add((a, b, birth, death)));
        sum.0
    }
}

fuzz_target!(|steps: Vec<Step>| {
    let mut mirror = Mirror::new();
    for step in &steps {
        take(&mut mirror, step);
    }
});

fn take(mirror: &mut Mirror, step: &Step) {
    let (held, was_lost) = (mirror.number(), mirror.needs_snapshot());
    let before = if step.is_snapshot { Content::default() } else { Content::of(mirror) };
    let mut diff = diff(step, step.from.map_or(held, u64::from));
    let careless = before.careless_checksum(&diff);
    let expected = before.after(&diff);
    let right = expected.as_ref().map_or(careless, Content::checksum);
    diff.checksum = right.wrapping_add(step.off.into());
    let applied = if step.is_snapshot { mirror.apply_snapshot(&snapshot(&diff)) } else { mirror.apply_diff(&diff) };
    let follows = step.is_snapshot || !was_lost && diff.from == held && step.by > 0;
    match expected.filter(|_| follows && step.off == 0) {
        Some(expected) => {
            assert_eq!(applied, Ok(()), "{step:?}");
            assert_eq!((Content::of(mirror), mirror.checksum()), (expected, right));
            assert_eq!((mirror.frame(), mirror.needs_snapshot()), (Some(&diff.frame), false));
        }
        None => {
            let error = applied.expect_err("what does not fit is refused");
            assert!(mirror.needs_snapshot() && error.to_string().len() < 200, "{error}");
        }
    }
}

/// The change that a step makes. Its checksum is not set.
fn diff(step: &Step, from: u64) -> Diff {
    // A snapshot removes nothing.
    let removed = |list| if step.is_snapshot { Vec::new() } else { edges(list) };
    Diff {
        stream: 1,
        from,
        frame: frame(from + u64::from(step.by)),
        vertices_added: step.added.vertices(),
        vertices_removed: step.vertices_removed.iter().filter(|_| !step.is_snapshot).map(|&id| id.into()).collect(),
        edges_added: edges(&step.added.edges),
        edges_removed: removed(&step.edges_removed),
        critical_set: step.added.critical(),
        critical_removed: removed(&step.critical_removed),
        checksum: 0,
    }
}

fn snapshot(diff: &Diff) -> Snapshot {
    Snapshot {
        stream: diff.stream,
        cause: Cause::Start,
        frame: diff.frame.clone(),
        vertices: diff.vertices_added.clone(),
        edges: diff.edges_added.clone(),
        critical: diff.critical_set.clone(),
        checksum: diff.checksum,
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
