//! Samples of the messages about streams in R^d (SPEC.md, section 13), all of version 4, and one message of an older
//! version in a frame of version 4.
//!
//! In: nothing. Out: samples.
//!
//! Invariants: `space_snapshot`, `space_diff` and `space_diff_onwards` are one sequence as a client would receive it,
//! and so are `space_tracks_start`, `space_tracks` and `space_tracks_merged`. All checksums are right. Otherwise as in
//! the parent module.

use hopes_protocol::*;

use super::{BORDERS, SPECIAL, Sample, sample};

pub fn samples() -> Vec<Sample> {
    [lists(), opens(), points(), snapshots(), diffs(), dots(), tracks(), borders(), older()].concat()
}

fn lists() -> Vec<Sample> {
    let all = [Metric::Euclidean, Metric::Manhattan, Metric::Chebyshev, Metric::Angular, Metric::Haversine];
    let info = |(metric, stream)| SpaceInfo { stream, metric, dimension: (stream % 2 == 1).then_some(stream - 1) };
    let streams = all.into_iter().zip([3, 250, 251, 65_536, u32::MAX]).map(info).collect();
    vec![
        sample("list_spaces", 31, ListSpaces {}),
        sample("spaces", 31, Spaces { streams }),
        sample("spaces_none", 32, Spaces { streams: vec![] }),
    ]
}

fn opens() -> Vec<Sample> {
    let bare =
        |name: &str| OpenSpace { name: name.into(), window: None, resolution: None, metric: None, dimension: None };
    let full = |name: &str, window, resolution, metric, dimension| OpenSpace {
        window: Some(window),
        resolution: Some(resolution),
        metric: Some(metric),
        dimension: Some(dimension),
        ..bare(name)
    };
    let opened = Opened {
        stream: 251,
        epoch: 0xFEDC_BA98_7654_3210,
        created: true,
        window: Window::Points(1_000),
        resolution: Some(0.125),
        frame: 17,
        largest_batch: 65_536,
    };
    let joined =
        Opened { stream: 2, created: false, window: Window::All, resolution: None, frame: 0, ..opened.clone() };
    let answer = |opened, metric, dimension, max_vertices| SpaceOpened { opened, metric, dimension, max_vertices };
    vec![
        sample("open_space", 33, bare("cloud")),
        sample("open_space_full", 34, full("größe/2 µm", Window::Frames(250), 0.5, Metric::Euclidean, 3)),
        sample("open_space_points", 35, full("a", Window::Points(7), 0.25, Metric::Manhattan, 1)),
        sample("open_space_time", 36, full("z", Window::Time(1.5), f64::MAX, Metric::Chebyshev, 4_096)),
        sample("open_space_all", 37, full("v", Window::All, 1e-3, Metric::Angular, 251)),
        sample("open_space_earth", 38, OpenSpace { metric: Some(Metric::Haversine), ..bare("e") }),
        sample("space_opened", 34, answer(opened, Metric::Euclidean, Some(3), 4_096)),
        sample("space_opened_joined", 33, answer(joined, Metric::Angular, None, u64::MAX)),
    ]
}

fn points() -> Vec<Sample> {
    let coordinates = vec![0.0, 0.5, 1.0, -2.0, 1e300, -1e-300];
    let plain = SpaceBatch { sequence: 1, dimension: 3, coordinates: coordinates.clone(), times: vec![], tags: vec![] };
    let timed = SpaceBatch { sequence: 2, dimension: 2, times: vec![10.0, 9.5, 1.7e9], ..plain.clone() };
    let line = SpaceBatch { sequence: 250, dimension: 1, tags: (250..256).collect(), ..plain.clone() };
    let special = SpaceBatch {
        sequence: u64::MAX,
        dimension: 1,
        coordinates: SPECIAL.to_vec(),
        times: SPECIAL.iter().rev().copied().collect(),
        tags: BORDERS[..SPECIAL.len()].to_vec(),
    };
    vec![
        sample("space_batch", 34, plain.clone()),
        sample("space_batch_times", 34, timed),
        sample("space_batch_tags", 35, line),
        sample("space_batch_empty", 34, SpaceBatch { sequence: 3, coordinates: vec![], ..plain }),
        sample("space_batch_special", 0x0102_0304, special),
        sample("space_retract", 34, SpaceRetract { sequence: 65_535, dimension: 3, coordinates }),
        sample("space_retract_empty", 34, SpaceRetract { sequence: 0, dimension: 4_096, coordinates: vec![] }),
    ]
}

const FULL: View = View { cut: Cut::Full, simplify: Simplify::No };
const DERIVED: View = View { cut: Cut::Derived(1, 2), simplify: Simplify::AtScale };

fn frame(number: u64, vertices: u64, components: u64, cycles: u64) -> FrameInfo {
    let points = vertices + 2;
    FrameInfo { number, time: None, points, vertices, rejected: 0, view: FULL, ds: None, vs: None, components, cycles }
}

/// The checksum of a skeleton whose vertices have `dimension` coordinates.
fn checksum(dimension: usize, ids: &[u64], coordinates: &[f64], edges: &[Edge], critical: &[Critical]) -> u64 {
    let mut checksum = Checksum::default();
    ids.iter().zip(coordinates.chunks_exact(dimension)).for_each(|(&id, point)| checksum.add((id, point)));
    edges.iter().for_each(|&edge| checksum.add(edge));
    critical.iter().for_each(|&critical| checksum.add(critical));
    checksum.0
}

/// A square in space, and a point beside it.
fn square() -> SpaceSnapshot {
    let ids = vec![0, 1, 2, 3, 7];
    let coordinates = vec![0.0, 0.0, 1.5, 2.0, 0.0, 1.5, 2.0, 2.0, 1.5, 0.0, 2.0, 1.5, 10.0, -0.5, 1e-3];
    let (edges, critical) = (vec![(0, 1), (0, 3), (1, 2)], vec![(2, 3, 1.0, 1.4375)]);
    SpaceSnapshot {
        stream: 4,
        cause: Cause::Start,
        frame: FrameInfo { time: Some(12.5), rejected: 6, points: 8, ..frame(11, 5, 2, 1) },
        metric: Metric::Euclidean,
        dimension: 3,
        checksum: checksum(3, &ids, &coordinates, &edges, &critical),
        ids,
        coordinates,
        edges,
        critical,
    }
}

fn snapshots() -> Vec<Sample> {
    let nothing = SpaceSnapshot {
        stream: u32::MAX,
        cause: Cause::CannotResume,
        frame: FrameInfo { points: 0, ..frame(1, 0, 0, 0) },
        metric: Metric::Manhattan,
        dimension: 0,
        ids: vec![],
        coordinates: vec![],
        edges: vec![],
        critical: vec![],
        checksum: 0,
    };
    let (ids, coordinates) = (vec![250, 65_536], vec![13.4, 52.5, -0.1, 51.5]);
    let earth = SpaceSnapshot {
        cause: Cause::Lagged,
        frame: FrameInfo { view: DERIVED, ds: Some(0.125), ..frame(251, 2, 1, 0) },
        metric: Metric::Haversine,
        dimension: 2,
        checksum: checksum(2, &ids, &coordinates, &[(250, 65_536)], &[]),
        ids,
        coordinates,
        edges: vec![(250, 65_536)],
        ..nothing.clone()
    };
    let wide: Vec<f64> = (0_u16..251).map(|at| f64::from(at) / 8.0).collect();
    let vector = SpaceSnapshot {
        cause: Cause::ViewChanged,
        frame: frame(2, 1, 1, 0),
        metric: Metric::Angular,
        dimension: 251,
        checksum: checksum(251, &[u64::MAX], &wide, &[], &[]),
        ids: vec![u64::MAX],
        coordinates: wide,
        ..nothing.clone()
    };
    vec![
        sample("space_snapshot", 11, square()),
        sample("space_snapshot_nothing", 11, nothing),
        sample("space_snapshot_earth", 12, earth),
        sample("space_snapshot_251", 13, vector),
    ]
}

/// A diff without changes.
fn unchanged(from: u64, frame: FrameInfo) -> SpaceDiff {
    SpaceDiff {
        stream: 4,
        from,
        frame,
        dimension: 3,
        ids_added: vec![],
        coordinates_added: vec![],
        vertices_removed: vec![],
        edges_added: vec![],
        edges_removed: vec![],
        critical_set: vec![],
        critical_removed: vec![],
        checksum: 0,
    }
}

/// Continues from `space_snapshot`: a diff with every kind of change, then one that ends a cycle.
fn diffs() -> Vec<Sample> {
    let ids = [0, 1, 2, 3, 8];
    let coordinates = [0.0, 0.0, 1.5, 2.0, 0.0, 1.5, 2.5, 2.5, 1.5, 0.0, 2.0, 1.5, 1.0, 1.0, -1.5];
    let (edges, critical) = ([(0, 1), (0, 8), (3, 8)], [(1, 2, 1.25, 1.5), (2, 3, 1.125, 1.75)]);
    let diff = SpaceDiff {
        ids_added: vec![2, 8],
        coordinates_added: vec![2.5, 2.5, 1.5, 1.0, 1.0, -1.5],
        vertices_removed: vec![2, 7],
        edges_added: vec![(0, 8), (3, 8)],
        edges_removed: vec![(0, 3), (1, 2)],
        critical_set: critical.to_vec(),
        checksum: checksum(3, &ids, &coordinates, &edges, &critical),
        ..unchanged(11, FrameInfo { time: Some(13.5), rejected: 9, points: 6, ..frame(12, 5, 1, 2) })
    };
    let onwards = SpaceDiff {
        critical_removed: vec![(1, 2)],
        checksum: checksum(3, &ids, &coordinates, &edges, &critical[1..]),
        ..unchanged(12, frame(13, 5, 1, 1))
    };
    let begun = SpaceDiff {
        stream: 65_536,
        dimension: 1,
        ids_added: BORDERS[..8].to_vec(),
        coordinates_added: SPECIAL.to_vec(),
        checksum: checksum(1, &BORDERS[..8], &SPECIAL, &[], &[]),
        ..unchanged(0, FrameInfo { view: DERIVED, vs: Some(0.125), ..frame(1, 8, 8, 0) })
    };
    vec![
        sample("space_diff", 11, diff),
        sample("space_diff_onwards", 11, onwards),
        sample("space_diff_borders", 0xFFFF, begun),
        sample("space_diff_empty", 11, SpaceDiff { dimension: 0, ..unchanged(0, frame(1, 0, 0, 0)) }),
    ]
}

fn dots() -> Vec<Sample> {
    let dot = |edge, birth, death, death_edge| SpaceDot { edge, birth, death, death_edge };
    let endless = dot((250, 251), 0.25, None, None);
    let filled = dot((2, 65_536), 0.5, Some(8.0), Some((3, 70_000)));
    let smallest = dot((65_536, u64::MAX), 5e-324, Some(1e-323), Some((0, 250)));
    let all = SpaceDots { stream: 4, frame: 13, total: 65_535, dots: vec![filled.clone(), endless.clone(), smallest] };
    vec![
        sample("space_dots", 11, all.clone()),
        sample("space_dots_endless", 11, SpaceDots { frame: 14, total: 251, dots: vec![endless, filled], ..all }),
        sample("space_dots_none", 11, SpaceDots { stream: 4, frame: 15, total: 0, dots: vec![] }),
    ]
}

fn track(id: u64, age: u64) -> SpaceTrack {
    SpaceTrack {
        id,
        age,
        birth: 0.75,
        death: Some(8.5),
        center: vec![1.0, -2.5, 3.0],
        radius: 8.25,
        velocity: vec![0.25, -0.125, 0.0],
        selected: true,
    }
}

fn event(frame: u64, time: Option<f64>, happening: Happening, track: SpaceTrack) -> SpaceTrackEvent {
    SpaceTrackEvent { frame, time, happening, track }
}

/// A cycle that is never filled.
fn endless(age: u64, selected: bool) -> SpaceTrack {
    let (center, velocity) = (vec![20.5, 3.0, -1.0], vec![0.0, -0.0, 5e-324]);
    SpaceTrack { id: 2, age, birth: 0.5, death: None, center, radius: 1.75, velocity, selected }
}

fn tracks() -> Vec<Sample> {
    let cycle = |id, walk: &[u64]| TrackCycle { id, walks: vec![walk.to_vec()] };
    let start = SpaceTracks {
        stream: 4,
        from: 0,
        frame: 11,
        time: Some(12.5),
        events: vec![],
        alive: Some(vec![track(1, 9), endless(4, false)]),
        cycles: vec![cycle(1, &[0, 1, 2, 250, 251]), TrackCycle { id: 2, walks: vec![] }],
    };
    let now = Some(13.5);
    let updated = |center, birth, death| Happening::Updated(TrackChanges { center, birth, death });
    let onwards = SpaceTracks {
        from: 11,
        frame: 12,
        time: now,
        events: vec![
            event(12, now, updated(true, false, true), track(1, 10)),
            event(12, now, Happening::Reselected, endless(5, true)),
            event(12, now, Happening::Split(1), track(3, 1)),
        ],
        alive: Some(vec![track(1, 10), endless(5, true), track(3, 1)]),
        cycles: vec![cycle(3, &[65_535, 65_536, u64::MAX])],
        ..start.clone()
    };
    let merged = SpaceTracks {
        from: 12,
        frame: 20,
        time: None,
        events: vec![
            event(13, None, Happening::Unselected, endless(6, false)),
            event(14, None, Happening::Merged(1), track(3, 3)),
            event(17, Some(17.0), Happening::Born, track(251, 1)),
            event(20, None, Happening::Died, endless(13, false)),
        ],
        alive: Some(vec![track(1, 18), track(251, 4)]),
        cycles: vec![],
        ..start.clone()
    };
    let alone = |name, from, happening| {
        let events = vec![event(from + 1, None, happening, track(1, 2))];
        let alive = Some(vec![track(1, 2)]);
        sample(name, 21, SpaceTracks { from, frame: from + 1, events, alive, cycles: vec![], ..start.clone() })
    };
    vec![
        sample("space_tracks", 11, onwards),
        alone("space_tracks_updated", 250, updated(false, true, true)),
        alone("space_tracks_updated_center", 251, updated(true, true, false)),
        sample("space_tracks_start", 11, start),
        sample("space_tracks_merged", 11, merged),
    ]
}

/// Numbers at the borders of the encoding, and lists without anything in them.
fn borders() -> Vec<Sample> {
    let [a, b, _, d, e, ..] = SPECIAL;
    let odd = |(id, age): (u64, u64)| SpaceTrack {
        birth: a,
        death: Some(b),
        center: SPECIAL.to_vec(),
        radius: d,
        velocity: SPECIAL.iter().rev().copied().collect(),
        ..track(id, age)
    };
    let nowhere = |id| SpaceTrack { center: vec![], velocity: vec![], ..track(id, 1) };
    let alive = BORDERS.into_iter().zip(BORDERS.into_iter().rev()).map(odd).collect();
    let cycles = vec![TrackCycle { id: u64::MAX, walks: vec![BORDERS.to_vec(), (0..251).collect()] }];
    let full = SpaceTracks {
        stream: 251,
        from: 0,
        frame: u64::MAX,
        time: Some(e),
        events: vec![],
        alive: Some(alive),
        cycles,
    };
    let walk = vec![TrackCycle { id: 250, walks: vec![vec![]] }];
    let empty = SpaceTracks { alive: Some(vec![]), cycles: walk, ..full.clone() };
    let empty_event = SpaceTracks {
        from: 65_535,
        frame: 65_536,
        events: vec![event(65_536, None, Happening::Born, nowhere(1))],
        alive: Some(vec![nowhere(1)]),
        cycles: vec![TrackCycle { id: 1, walks: vec![] }],
        ..full.clone()
    };
    vec![
        sample("space_tracks_borders", 0x0102_0304, full),
        sample("space_tracks_walk_nothing", 11, empty),
        sample("space_tracks_nowhere", 11, empty_event),
    ]
}

/// The codes that were added with version 4 come in the message that every version has.
fn older() -> Vec<Sample> {
    let text = "scan is a stream of points in R^3: open it with OpenSpace";
    let report = Report { code: ErrorCode::OtherSpace as u16, answers: 0x0101, text: text.into() };
    vec![Sample { version: 4, ..sample("error", 24, report) }]
}
