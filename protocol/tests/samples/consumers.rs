//! Samples of the messages between a consumer and the daemon (SPEC.md, section 7).
//!
//! In: nothing. Out: samples.
//!
//! Invariants: `snapshot`, `diff` and `diff_onwards` are one sequence as a client would receive it, and so are
//! `diff_from_nothing` and `diff_merged`. All checksums are right. Otherwise as in the parent module.

use hopes_protocol::{
    Cause, ChangeView, Critical, Cut, Diff, Dot, Dots, DotsWanted, Edge, FrameInfo, Heartbeat, Lagged, Resume, Resumed,
    Simplify, Snapshot, StreamClosed, StreamOpened, Subscribe, Unsubscribe, Unsubscribed, Vertex, View, Window,
};

use super::{Sample, checksum, sample};

pub fn samples() -> Vec<Sample> {
    [subscriptions(), streams(), snapshots(), sequence(), other_diffs(), merged(), dots(), notices()].concat()
}

const FULL: View = View { cut: Cut::Full, simplify: Simplify::No };
const REDUCED: View = View { cut: Cut::Reduced(0.75), simplify: Simplify::AtScale };
const DERIVED: View = View { cut: Cut::Derived(250, 4_294_967_295), simplify: Simplify::Below(1.25) };

fn subscriptions() -> Vec<Sample> {
    let all = Subscribe { pattern: "*".into(), view: FULL, dots: DotsWanted::All, resume: None };
    let resume = Some(Resume { epoch: 0xFEDC_BA98_7654_3210, frame: 251 });
    let reduced = Subscribe { pattern: "scan".into(), view: REDUCED, dots: DotsWanted::Top(250), resume };
    let derived = Subscribe { pattern: "größe/*".into(), view: DERIVED, dots: DotsWanted::No, resume: None };
    vec![
        sample("subscribe", 11, all),
        sample("subscribe_resume", 12, reduced),
        sample("subscribe_derived", 13, derived),
        sample("change_view", 11, ChangeView { view: DERIVED, dots: DotsWanted::Top(u32::MAX) }),
        sample("change_view_full", 12, ChangeView { view: FULL, dots: DotsWanted::All }),
        sample("change_view_reduced", 13, ChangeView { view: REDUCED, dots: DotsWanted::No }),
        sample("unsubscribe", 11, Unsubscribe {}),
        sample("unsubscribed", 11, Unsubscribed {}),
    ]
}

fn streams() -> Vec<Sample> {
    let opened = StreamOpened {
        stream: 1,
        name: "scan".into(),
        epoch: 0xFEDC_BA98_7654_3210,
        window: Window::Points(65_535),
        resolution: Some(0.5),
        frame: 3,
    };
    let timed =
        StreamOpened { stream: 251, window: Window::Time(5e-324), resolution: None, frame: 0, ..opened.clone() };
    vec![
        sample("stream_opened", 11, opened),
        sample("stream_opened_time", 11, timed),
        sample("stream_closed", 11, StreamClosed { stream: 1, frame: 65_536, reason: "its producer ended it".into() }),
    ]
}

/// A frame of the full view.
fn frame(number: u64, vertices: u64, components: u64, cycles: u64) -> FrameInfo {
    let points = vertices + 2;
    FrameInfo { number, time: None, points, vertices, rejected: 0, view: FULL, ds: None, vs: None, components, cycles }
}

/// A square with one diagonal, and an isolated point.
fn square() -> (Vec<Vertex>, Vec<Edge>, Vec<Critical>) {
    let vertices = vec![(0, 0.0, 0.0), (1, 2.0, 0.0), (2, 2.0, 2.0), (3, 0.0, 2.0), (7, 10.0, -0.5)];
    (vertices, vec![(0, 1), (0, 3), (1, 2)], vec![(2, 3, 1.0, 1.4375)])
}

fn snapshots() -> Vec<Sample> {
    let (vertices, edges, critical) = square();
    let proof = checksum(&vertices, &edges, &critical);
    let frame = FrameInfo { time: Some(12.5), rejected: 6, points: 8, ..frame(11, 5, 2, 1) };
    let first = Snapshot { stream: 4, cause: Cause::Start, frame, vertices, edges, critical, checksum: proof };
    let empty = |cause, frame| Snapshot {
        stream: u32::MAX,
        cause,
        frame,
        vertices: vec![],
        edges: vec![],
        critical: vec![],
        checksum: 0,
    };
    vec![
        sample("snapshot", 11, first),
        sample("snapshot_view_changed", 12, simplified()),
        sample("snapshot_lagged", 11, empty(Cause::Lagged, borders())),
        sample("snapshot_cannot_resume", 11, empty(Cause::CannotResume, nothing())),
    ]
}

/// A frame without elements in a reduced view.
fn nothing() -> FrameInfo {
    FrameInfo { points: 0, view: REDUCED, time: Some(-0.0), ..frame(1, 0, 0, 0) }
}

/// A frame with numbers at the borders of the encoding.
fn borders() -> FrameInfo {
    FrameInfo {
        number: u64::MAX,
        time: Some(f64::MAX),
        points: 0x1_0000_0000,
        vertices: 0xFFFF_FFFF,
        rejected: 65_536,
        view: View { cut: Cut::Derived(1, 2), simplify: Simplify::AtScale },
        ds: Some(5e-324),
        vs: Some(f64::MIN_POSITIVE),
        components: 65_535,
        cycles: 251,
    }
}

/// A simplified view of one edge.
fn simplified() -> Snapshot {
    let view = View { cut: Cut::Reduced(0.1), simplify: Simplify::Below(0.3) };
    let (vertices, edges) = (vec![(250, 0.1, 0.2), (65_536, 0.3, 0.4)], vec![(250, 65_536)]);
    let checksum = checksum(&vertices, &edges, &[]);
    let frame = FrameInfo { view, ..frame(251, 9, 1, 0) };
    Snapshot { stream: 5, cause: Cause::ViewChanged, frame, vertices, edges, critical: vec![], checksum }
}

/// Continues from `snapshot`: a diff with every kind of change, then a frame without changes.
fn sequence() -> Vec<Sample> {
    let vertices = [(0, 0.0, 0.0), (1, 2.0, 0.0), (2, 2.5, 2.5), (3, 0.0, 2.0), (8, 1.0, 1.0)];
    let (edges, critical) = ([(0, 1), (0, 8), (3, 8)], [(1, 2, 1.25, 1.5), (2, 3, 1.125, 1.75)]);
    let proof = checksum(&vertices, &edges, &critical);
    let diff = Diff {
        stream: 4,
        from: 11,
        frame: FrameInfo { time: Some(13.5), rejected: 9, points: 6, ..frame(12, 5, 1, 2) },
        vertices_added: vec![(2, 2.5, 2.5), (8, 1.0, 1.0)],
        vertices_removed: vec![2, 7],
        edges_added: vec![(0, 8), (3, 8)],
        edges_removed: vec![(0, 3), (1, 2)],
        critical_set: vec![(1, 2, 1.25, 1.5), (2, 3, 1.125, 1.75)],
        critical_removed: vec![],
        checksum: proof,
    };
    let onwards = Diff {
        from: 12,
        frame: frame(13, 5, 1, 1),
        critical_removed: vec![(1, 2)],
        checksum: checksum(&vertices, &edges, &critical[1..]),
        ..unchanged(&diff)
    };
    vec![sample("diff", 11, diff), sample("diff_onwards", 11, onwards)]
}

/// A diff after this one, without changes.
fn unchanged(diff: &Diff) -> Diff {
    Diff {
        vertices_added: vec![],
        vertices_removed: vec![],
        edges_added: vec![],
        edges_removed: vec![],
        critical_set: vec![],
        critical_removed: vec![],
        ..diff.clone()
    }
}

/// A diff from nothing to one vertex for each border of the encoding, and one back to nothing.
fn other_diffs() -> Vec<Sample> {
    let empty = Diff { stream: 250, from: 0, frame: frame(1, 0, 0, 0), checksum: 0, ..unchanged(&blank()) };
    let vertices: Vec<Vertex> = super::BORDERS.into_iter().zip(super::SPECIAL).map(|(id, at)| (id, at, -at)).collect();
    let begun = Diff {
        stream: 251,
        frame: FrameInfo { view: DERIVED, ds: Some(0.125), vs: None, ..frame(1, 8, 8, 0) },
        checksum: checksum(&vertices, &[], &[]),
        vertices_added: vertices,
        ..empty.clone()
    };
    let cleared =
        Diff { stream: 252, from: 65_535, frame: borders(), vertices_removed: (0..251).collect(), ..empty.clone() };
    vec![
        sample("diff_empty", 11, empty),
        sample("diff_borders", 0xFFFF, begun),
        sample("diff_of_251", 0x1_0000, cleared),
    ]
}

fn blank() -> Diff {
    Diff {
        stream: 0,
        from: 0,
        frame: frame(1, 0, 0, 0),
        vertices_added: vec![],
        vertices_removed: vec![],
        edges_added: vec![],
        edges_removed: vec![],
        critical_set: vec![],
        critical_removed: vec![],
        checksum: 0,
    }
}

/// A recording that starts with a diff, and a diff over several frames.
fn merged() -> Vec<Sample> {
    let (vertices, edges, critical) = square();
    let begun = Diff {
        stream: 6,
        frame: frame(1, 5, 2, 1),
        checksum: checksum(&vertices, &edges, &critical),
        vertices_added: vertices.clone(),
        edges_added: edges.clone(),
        critical_set: critical,
        ..blank()
    };
    let later = Diff {
        from: 1,
        frame: frame(9, 4, 1, 0),
        vertices_removed: vec![7],
        critical_removed: vec![(2, 3)],
        checksum: checksum(&vertices[..4], &edges, &[]),
        ..unchanged(&begun)
    };
    vec![sample("diff_from_nothing", 21, begun), sample("diff_merged", 21, later)]
}

fn dots() -> Vec<Sample> {
    let dot = |edge, birth, death, center, radius| Dot { edge, birth, death, center, radius };
    let largest = dot((250, 251), 0.25, 8.0, (-1.5, 2.5), 7.75);
    let smallest = dot((65_536, u64::MAX), 5e-324, 1e-323, (f64::MIN, f64::MAX), -0.0);
    vec![
        sample("dots", 11, Dots { stream: 4, frame: 13, total: 65_535, dots: vec![largest, smallest] }),
        sample("dots_none", 11, Dots { stream: 4, frame: 14, total: 0, dots: vec![] }),
    ]
}

fn notices() -> Vec<Sample> {
    vec![
        sample("heartbeat", 11, Heartbeat { stream: 4, frame: 14 }),
        sample("heartbeat_0", 11, Heartbeat { stream: 0xFFFF_FFFF, frame: 0 }),
        sample("lagged", 11, Lagged { stream: 65_536, first: 0xFFFF_FFFF, last: 0x1_0000_0000 }),
        sample("resumed", 12, Resumed { stream: 65_535, frame: 251 }),
    ]
}
