//! Between the core's types and those of the wire.
//!
//! In: steps, options, refusals of the core; messages of the protocol. Out: the same of the other side.
//!
//! Invariants: numbers go over bit by bit; what is infinite on one side is none on the other.
//!
//! Must not know: bytes, threads.

use std::num::{NonZeroU32, NonZeroU64};

use hopes::topology::{
    Critical, Diff, EdgeId, EventKind, Refusal, Step, Track, TrackEvent, Vertices, ViewSpec, Window,
};
use hopes_protocol as wire;

use super::pipeline::PipelineOptions;

/// What turns the frame before into this one.
pub fn diff(stream: u32, view: wire::View, step: &Step, rejected: u64) -> wire::Diff {
    wire_diff(stream, step.from, frame_info(view, step, rejected), &step.diff, step.checksum.0)
}

/// A diff of the core, as the change of a view from one frame to another.
pub fn wire_diff(stream: u32, from: u64, frame: wire::FrameInfo, diff: &Diff, checksum: u64) -> wire::Diff {
    wire::Diff {
        stream,
        from,
        frame,
        vertices_added: vertices(&diff.vertices_added),
        vertices_removed: diff.vertices_removed.iter().map(|id| id.0).collect(),
        edges_added: diff.tree_added.iter().map(edge).collect(),
        edges_removed: diff.tree_removed.iter().map(edge).collect(),
        critical_set: diff.critical_set.iter().map(critical).collect(),
        critical_removed: diff.critical_removed.iter().map(edge).collect(),
        checksum,
    }
}

/// A step from nothing, as a whole.
pub fn snapshot(stream: u32, view: wire::View, cause: wire::Cause, step: &Step, rejected: u64) -> wire::Snapshot {
    debug_assert_eq!(step.from, 0, "a snapshot starts from nothing");
    wire::Snapshot {
        stream,
        cause,
        frame: frame_info(view, step, rejected),
        vertices: vertices(&step.diff.vertices_added),
        edges: step.diff.tree_added.iter().map(edge).collect(),
        critical: step.diff.critical_set.iter().map(critical).collect(),
        checksum: step.checksum.0,
    }
}

/// About how many bytes a snapshot of a frame has on the wire.
pub fn snapshot_size(frame: &wire::FrameInfo) -> u64 {
    // An id has about four bytes.
    20 * frame.vertices + 8 * frame.vertices.saturating_sub(frame.components) + 24 * frame.cycles
}

/// A track as it was last seen.
pub fn track(track: &Track) -> wire::Track {
    let &Track { id, age, birth, death, hole, area, velocity, is_selected } = track;
    let (center, velocity) = (hole.center.into(), velocity.into());
    wire::Track { id: id.0, age, birth, death, center, radius: hole.radius, area, velocity, selected: is_selected }
}

/// What has happened to a track.
pub fn track_event(event: &TrackEvent) -> wire::TrackEvent {
    let happening = match event.kind {
        EventKind::Born => wire::Happening::Born,
        EventKind::Split { from } => wire::Happening::Split(from.0),
        EventKind::Updated(changed) => {
            let hopes::topology::Changed { center, birth, death } = changed;
            wire::Happening::Updated(wire::TrackChanges { center, birth, death })
        }
        EventKind::Unselected => wire::Happening::Unselected,
        EventKind::Reselected => wire::Happening::Reselected,
        EventKind::Merged { into } => wire::Happening::Merged(into.0),
        EventKind::Died => wire::Happening::Died,
    };
    let time = event.time.filter(|time| time.is_finite());
    wire::TrackEvent { frame: event.frame, time, happening, track: track(&event.track) }
}

fn frame_info(view: wire::View, step: &Step, rejected: u64) -> wire::FrameInfo {
    let selection = step.selection.as_ref();
    wire::FrameInfo {
        number: step.number,
        time: step.time.filter(|time| time.is_finite()),
        points: step.points,
        vertices: step.vertices as u64,
        rejected,
        view,
        ds: selection.and_then(|selection| selection.ds).filter(|ds| ds.is_finite()),
        vs: selection.map(|selection| selection.vs).filter(|vs| vs.is_finite()),
        components: step.components as u64,
        cycles: step.cycles as u64,
    }
}

/// The wire's vertices are those of the plane.
fn vertices(vertices: &Vertices) -> Vec<wire::Vertex> {
    vertices.ids().iter().zip(vertices.positions()).map(|(id, [x, y])| (id.0, x, y)).collect()
}

fn edge([a, b]: &EdgeId) -> wire::Edge {
    (a.0, b.0)
}

/// A critical edge: its ends, birth and death.
pub fn critical(critical: &Critical) -> wire::Critical {
    let [a, b] = critical.edge;
    (a.0, b.0, critical.birth, critical.death)
}

/// The view of the core that shows a cut.
///
/// # Errors
/// What is wrong with it, and what it may be.
pub fn spec(cut: wire::Cut) -> Result<ViewSpec, &'static str> {
    match cut {
        wire::Cut::Full => Ok(ViewSpec::Full),
        wire::Cut::Reduced(alpha) if alpha.is_finite() && alpha >= 0.0 => Ok(ViewSpec::Reduced { alpha }),
        wire::Cut::Reduced(_) => Err("alpha must be a finite number, from 0: it is a radius"),
        wire::Cut::Derived(k, l) => match (NonZeroU32::new(k), NonZeroU32::new(l)) {
            (Some(k), Some(l)) => Ok(ViewSpec::Derived { k, l }),
            _ => Err("k and l count from 1"),
        },
    }
}

/// Whether there is such a view.
///
/// # Errors
/// What is wrong with it, and what it may be.
pub fn check_view(view: wire::View) -> Result<(), &'static str> {
    spec(view.cut)?;
    match view.simplify {
        wire::Simplify::AtScale if view.cut == wire::Cut::Full => {
            Err("the full skeleton has no scale of its own to simplify at: give one")
        }
        wire::Simplify::Below(threshold) if !(threshold.is_finite() && threshold >= 0.0) => {
            Err("a threshold must be a finite number, from 0: it is a radius")
        }
        _ => Ok(()),
    }
}

/// The cut that a view of the core shows.
pub fn cut(spec: ViewSpec) -> wire::Cut {
    match spec {
        ViewSpec::Full => wire::Cut::Full,
        ViewSpec::Reduced { alpha } => wire::Cut::Reduced(alpha),
        ViewSpec::Derived { k, l } => wire::Cut::Derived(k.get(), l.get()),
    }
}

/// A window for the core.
///
/// # Errors
/// What is wrong with it.
pub fn window(window: wire::Window) -> Result<Window, &'static str> {
    let count =
        |number| NonZeroU64::new(number).ok_or("a window of 0 points or frames holds nothing: it counts from 1");
    match window {
        wire::Window::All => Ok(Window::All),
        wire::Window::Points(number) => count(number).map(Window::Points),
        wire::Window::Frames(number) => count(number).map(Window::Frames),
        wire::Window::Time(length) if length.is_finite() && length > 0.0 => Ok(Window::Time(length)),
        wire::Window::Time(_) => Err("a window of time must have a finite length above 0"),
    }
}

/// A window for the wire.
pub fn wire_window(window: Window) -> wire::Window {
    match window {
        Window::All => wire::Window::All,
        Window::Points(number) => wire::Window::Points(number.get()),
        Window::Frames(number) => wire::Window::Frames(number.get()),
        Window::Time(length) => wire::Window::Time(length),
    }
}

/// Options for the core.
///
/// # Errors
/// What is wrong with them.
pub fn options(of_window: Option<wire::Window>, resolution: Option<f64>) -> Result<PipelineOptions, &'static str> {
    let is_step = |step: &f64| step.is_finite() && *step > 0.0;
    if resolution.as_ref().is_some_and(|step| !is_step(step)) {
        return Err("a resolution must be a finite number above 0");
    }
    Ok(PipelineOptions { window: window(of_window.unwrap_or(wire::Window::All))?, resolution, space: None })
}

/// Which of the protocol's reasons a refusal has.
pub fn refusal_code(refusal: &Refusal) -> wire::RefusalCode {
    match refusal {
        Refusal::Coordinate(_) | Refusal::Point(_) => wire::RefusalCode::Coordinate,
        Refusal::NoTime => wire::RefusalCode::NoTime,
        Refusal::TimeNotFinite(_) => wire::RefusalCode::TimeNotFinite,
        Refusal::TooLate { .. } | Refusal::Unconfirmed { .. } | Refusal::Outdated { .. } => wire::RefusalCode::TooLate,
        Refusal::NotThere { .. } | Refusal::Absent(_) => wire::RefusalCode::NotThere,
        Refusal::Full(_) | Refusal::TooMany(_) => wire::RefusalCode::StreamFull,
    }
}
