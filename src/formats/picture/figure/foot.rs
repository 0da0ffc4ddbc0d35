//! What the marks of a figure mean, below its panels, and a bar of round length.
//!
//! In: a figure, the scale of the plane.
//! Out: shapes on the page.
//! Invariants: only what the panels may show is explained; samples have the styles of what they stand for.
//! Must not know: how panels are drawn.

use hopes::topology::Filtration;

use super::super::canvas::colors::{EDGE, POINT};
use super::super::canvas::layout::Rect;
use super::super::canvas::page::{Anchor, MUTED, Page, Type, text_width};
use super::super::canvas::ramp::STOPS;
use super::super::legend::draw_scale_bar;
use super::plane::{CRITICAL_STYLE, SIMPLE_STYLE, cycle_style, hole_style, line_style};
use super::{Figure, Panel};

/// Width of a sample, with the room before its name.
const SAMPLE: f64 = 24.0;
const SPACE: f64 = 14.0;
/// The panel that the bar's length is a share of.
const MEASURE: f64 = 460.0;

/// A sample's name, and the data and the style of its path, from the place of its left end and its middle.
type Sample = (&'static str, fn(f64, f64) -> String, String);

/// Draws samples in a line, and the bar below its right end, where a unit of the plane has `scale` pixels.
pub fn draw(page: &mut Page, foot: Rect, figure: &Figure<'_>, scale: f64) {
    let y = foot.y + 14.0;
    let mut x = foot.x;
    for (name, data, style) in samples(figure) {
        page.path(&data((x + 3.0).round(), y.round()), style);
        page.text([x + SAMPLE, y + 4.0], Type::new(Anchor::Start, MUTED), name);
        x += SAMPLE + text_width(name) + SPACE;
    }
    if scale > 0.0 {
        // Below the line of samples, which may be as long as the page is wide.
        draw_scale_bar(page, Rect { x: foot.right() - MEASURE, y: 0.0, width: MEASURE, height: foot.y }, scale);
    }
}

fn samples(figure: &Figure<'_>) -> Vec<Sample> {
    let has = |wanted: fn(&Panel<'_>) -> bool| figure.panels.iter().any(wanted);
    let dark = STOPS[STOPS.len() - 1];
    let line: fn(f64, f64) -> String = |x, y| format!("M{x} {y}h14");
    let mut samples: Vec<Sample> = Vec::new();
    if has(|panel| matches!(panel, Panel::Cloud | Panel::Skeleton(_))) {
        samples.push(("point", |x, y| format!("M{} {y}h0", x + 7.0), line_style(POINT) + " stroke-width=\"3.6\""));
    }
    if !figure.outliers.is_empty() {
        let ring: fn(f64, f64) -> String = |x, y| format!("M{} {y}a1.9 1.9 0 0 1 3.8 0a1.9 1.9 0 0 1-3.8 0", x + 5.1);
        samples.push(("outlier", ring, line_style(POINT) + " stroke-width=\".9\""));
    }
    if has(|panel| matches!(panel, Panel::Skeleton(_))) {
        let critical = format!("{CRITICAL_STYLE} stroke=\"{dark}\" stroke-width=\"4\"");
        let disc: fn(f64, f64) -> String = |x, y| format!("M{x} {y}a7 7 0 0 1 14 0a7 7 0 0 1-14 0");
        samples.push(("tree edge", line, line_style(EDGE) + " stroke-width=\"1.1\""));
        samples.push(("critical edge", line, critical));
        samples.push(match figure.skeleton.filtration() {
            Filtration::Alpha => ("hole", disc, hole_style(dark, true)),
            Filtration::Rips => ("cycle", line, cycle_style()),
        });
    }
    if has(|panel| matches!(panel, Panel::Simplified { .. })) {
        samples.push(("simplified", line, format!("{SIMPLE_STYLE} stroke-width=\"3\"")));
    }
    samples
}
