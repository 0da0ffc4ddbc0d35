//! What marks and colours mean: the colour bar right of the diagram, the line of samples below the plane.
//!
//! In: a [`Scene`], rectangles.
//! Out: shapes on the page.
//! Invariants: only what the picture may show is explained; samples have the styles of what they stand for; numbers
//! are round.
//! Must not know: how panels are drawn.

use hopes::topology::ViewSpec;

use super::canvas::colors::{EDGE, POINT};
use super::canvas::layout::Rect;
use super::canvas::numbers::{Ticks, round_step, short};
use super::canvas::page::{Anchor, FRAME, INK, MUTED, Page, Type, text_width};
use super::canvas::ramp::{Ramp, STOPS};
use super::plane::{CRITICAL_STYLE, SIMPLE_STYLE, cycle_style, hole_style, line_style};
use super::scene::Scene;
use super::words;

/// Width of a sample, with the room before its name.
const SAMPLE: f64 = 24.0;
const SPACE: f64 = 14.0;
/// The longest scale bar, as a share of the panel.
const SCALE_BAR: f64 = 0.25;

/// Draws the colour bar, unless there is nothing to colour.
pub(super) fn draw_bar(page: &mut Page, bar: Rect, ramp: Ramp) {
    let top = ramp.top();
    if top <= 0.0 {
        return;
    }
    let ticks = Ticks::new(top, bar.height / 75.0);
    define_gradient(page);
    page.rect(bar, format_args!("fill=\"url(#persistence)\" stroke=\"{FRAME}\""));
    for (value, label) in ticks.all() {
        let y = bar.bottom() - value / top * bar.height;
        page.line([bar.right(), y], [bar.right() + 4.0, y], format_args!("stroke=\"{MUTED}\""));
        page.text([bar.right() + 8.0, y + 4.0], Type::new(Anchor::Start, MUTED), &label);
    }
    let middle = bar.x + bar.width / 2.0;
    page.text([middle, bar.bottom() + 38.0], Type::new(Anchor::Middle, INK).sized(13.0), "persistence");
    page.text([middle, bar.bottom() + 22.0], Type::new(Anchor::Middle, MUTED), ticks.factor().trim());
}

fn define_gradient(page: &mut Page) {
    page.put(format_args!("<linearGradient id=\"persistence\" x1=\"0\" y1=\"1\" x2=\"0\" y2=\"0\">"));
    for (index, stop) in STOPS.iter().enumerate() {
        let offset = index as f64 / (STOPS.len() - 1) as f64;
        page.put(format_args!("<stop offset=\"{offset:.4}\" stop-color=\"{stop}\"/>"));
    }
    page.put(format_args!("</linearGradient>\n"));
}

/// Draws the samples and a bar of round length below the plane, a unit of which has `scale` pixels.
pub(super) fn draw_samples(page: &mut Page, plane: Rect, scene: &Scene<'_>, scale: f64) {
    let y = plane.bottom() + 24.0;
    let mut x = plane.x;
    for sample in samples(scene) {
        sample.draw(page, [x, y - 4.0]);
        page.text([x + SAMPLE, y], Type::new(Anchor::Start, MUTED), sample.name);
        x += SAMPLE + text_width(sample.name) + SPACE;
    }
    if scale > 0.0 && scene.of.has_lengths() {
        draw_scale_bar(page, plane, scale);
    }
}

enum Shape {
    Dot,
    Ring,
    Line,
    Disc,
}

struct Sample {
    name: &'static str,
    shape: Shape,
    style: String,
}

impl Sample {
    fn draw(&self, page: &mut Page, [x, y]: [f64; 2]) {
        let [left, middle, y] = [x + 3.0, x + 10.0, y].map(|v| v.round());
        match self.shape {
            Shape::Dot => page.path(&format!("M{middle} {y}h0"), &self.style),
            Shape::Ring => page.circle([middle, y], 1.9, &self.style, None),
            Shape::Line => page.path(&format!("M{left} {y}h14"), &self.style),
            Shape::Disc => page.circle([middle, y], 7.0, &self.style, None),
        }
    }
}

fn samples(scene: &Scene<'_>) -> Vec<Sample> {
    let dark = STOPS[STOPS.len() - 1];
    let sample = |name, shape, style| Sample { name, shape, style };
    let mut samples = vec![
        sample("point", Shape::Dot, format!("{} stroke-width=\"3.6\"", line_style(POINT))),
        sample("tree edge", Shape::Line, format!("{} stroke-width=\"1.1\"", line_style(EDGE))),
    ];
    if !scene.of.outliers.is_empty() {
        samples.push(sample("outlier", Shape::Ring, format!("{} stroke-width=\".9\"", line_style(POINT))));
    }
    if !scene.view.critical.is_empty() {
        let style = format!("{CRITICAL_STYLE} stroke=\"{dark}\" stroke-width=\"4\"");
        samples.push(sample("critical edge", Shape::Line, style));
    }
    if !scene.holes.is_empty() {
        samples.push(sample("hole", Shape::Disc, hole_style(dark, true)));
    }
    if scene.has_cycles() {
        samples.push(sample("cycle", Shape::Line, cycle_style()));
    }
    if scene.simplified.is_some() {
        samples.push(sample("simplified", Shape::Line, format!("{SIMPLE_STYLE} stroke-width=\"3\"")));
    }
    samples
}

/// Draws a bar of round length below a panel, at its right end.
pub(super) fn draw_scale_bar(page: &mut Page, plane: Rect, scale: f64) {
    let (digit, power) = round_step(SCALE_BAR / 2.0 * plane.width / scale);
    let length = f64::from(digit) * 10f64.powi(power);
    let (right, y) = (plane.right(), plane.bottom() + 20.0);
    let left = right - length * scale;
    let data = format!("M{left:.2} {}v8m0-4H{right}m0-4v8", y - 4.0);
    page.path(&data, format_args!("class=\"scale\" fill=\"none\" stroke=\"{MUTED}\""));
    page.text([(left + right) / 2.0, y + 18.0], Type::new(Anchor::Middle, MUTED), &short(length));
}

/// What the panels are, above them.
pub(super) fn draw_captions(page: &mut Page, plane: Rect, diagram: Rect, scene: &Scene<'_>) {
    let caption = Type::new(Anchor::Start, INK).sized(13.0);
    let y = plane.y - 28.0;
    let what = match (scene.simplified.is_some(), scene.view.spec) {
        (true, _) => "Simplified skeleton, over the original",
        (false, ViewSpec::Full) => "Skeleton: all of it",
        (false, ViewSpec::Reduced { .. }) => "Skeleton, reduced at alpha",
        (false, ViewSpec::Derived { .. }) => "Skeleton, derived by the gaps",
    };
    page.text([plane.x, y], caption, what);
    if let Some(note) = scene.of.layout.and_then(words::account) {
        page.text([plane.x, plane.y - 10.0], Type::new(Anchor::Start, MUTED), &note);
    }
    page.text([diagram.x, y], caption, "Persistence diagram");
}
