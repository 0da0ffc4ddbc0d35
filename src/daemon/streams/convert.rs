//! Between the core's types and those of the wire.
//!
//! In: steps, options, refusals of the core; messages of the protocol. Out: the same of the other side.
//!
//! Invariants: numbers go over bit by bit; what is infinite on one side is none on the other.
//!
//! Must not know: bytes, threads.

mod frames;
mod tracks;

use std::num::{NonZeroU32, NonZeroU64};

use hopes::topology::spaces::Metric;
use hopes::topology::{Refusal, ViewSpec, Window};
use hopes_protocol as wire;

pub use self::frames::{Dots, Shape, diff, frame_info, snapshot, snapshot_size};
pub use self::tracks::{TrackKind, TrackSpan, space_track, space_track_event, track, track_event};

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

/// A metric for the core.
pub fn metric(metric: wire::Metric) -> Metric {
    match metric {
        wire::Metric::Euclidean => Metric::Euclidean,
        wire::Metric::Manhattan => Metric::Manhattan,
        wire::Metric::Chebyshev => Metric::Chebyshev,
        wire::Metric::Angular => Metric::Angular,
        wire::Metric::Haversine => Metric::Haversine,
    }
}

/// A metric for the wire.
pub fn wire_metric(metric: Metric) -> wire::Metric {
    match metric {
        Metric::Euclidean => wire::Metric::Euclidean,
        Metric::Manhattan => wire::Metric::Manhattan,
        Metric::Chebyshev => wire::Metric::Chebyshev,
        Metric::Angular => wire::Metric::Angular,
        Metric::Haversine => wire::Metric::Haversine,
    }
}

/// The step of a grid for the core.
///
/// # Errors
/// What is wrong with it.
pub fn resolution(resolution: Option<f64>) -> Result<Option<f64>, &'static str> {
    let is_step = |step: &f64| step.is_finite() && *step > 0.0;
    if resolution.as_ref().is_some_and(|step| !is_step(step)) {
        return Err("a resolution must be a finite number above 0");
    }
    Ok(resolution)
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
