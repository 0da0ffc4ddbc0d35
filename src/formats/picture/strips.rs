//! What chose the view, inside the diagram: gaps as shaded strips, ds and vs (or alpha) as lines, all of them
//! labelled.
//!
//! In: a [`Scene`] and the diagram's [`Scale`].
//! Out: shapes on the page.
//! Invariants: labels of diagonal gaps are above the frame, all others at its foot, right of the diagonal, where no
//! dot can be; of many gaps the widest are labelled.
//! Must not know: dots.

use hopes::topology::{Gap, Selection};

use super::canvas::colors::{DIAGONAL, SCALE, VERTICAL};
use super::canvas::labels::{Label, Row, room};
use super::canvas::page::{Anchor, Page, Type, text_width};
use super::scale::Scale;
use super::scene::Scene;

/// Height of the texts at the foot of the frame, with the room below them.
const FOOT: f64 = 22.0;
/// From a vertical line to its label.
const BESIDE: f64 = 4.0;
/// So many labels of vertical gaps get room at least.
const LABELS: usize = 4;
/// How far labels may stand out above the frame.
const OVERHANG: f64 = 40.0;

/// Draws what the scene's view was chosen by.
pub(super) fn draw(page: &mut Page, scale: Scale, scene: &Scene<'_>) {
    match (&scene.view.selection, scene.alpha()) {
        (Some(selection), _) => draw_selection(page, scale, selection),
        (None, Some(alpha)) => draw_alpha(page, scale, alpha),
        (None, None) => {}
    }
}

fn draw_selection(page: &mut Page, scale: Scale, selection: &Selection) {
    for gap in &selection.vertical {
        vertical_strip(page, scale, gap);
    }
    for gap in &selection.diagonal {
        diagonal_strip(page, scale, gap);
    }
    draw_ds(page, scale, selection);
    let labels = ranks(&selection.vertical, "vgap", VERTICAL, |gap| middle(scale, gap));
    let from = if selection.vs <= scale.top { draw_vs(page, scale, selection.vs, &labels) } else { FOOT };
    Row { from, to: scale.side, edge: scale.side, reach: scale.side - 5.0, base: foot(scale) }.draw(page, labels);
}

/// The lower side of DS_k, unless only dots that never die are above it, and the labels of the diagonal gaps.
fn draw_ds(page: &mut Page, scale: Scale, selection: &Selection) {
    let Some(ds) = selection.ds else { return };
    let mut labels = Vec::new();
    if ds.is_finite() {
        let end = scale.side - scale.length(ds);
        page.line(scale.place(0.0, ds), [end, 0.0], line_style(DIAGONAL, "ds"));
        labels.push(Label { about: end, text: "ds".to_owned(), color: DIAGONAL });
    }
    labels.extend(ranks(&selection.diagonal, "dgap", DIAGONAL, |gap| scale.side - middle(scale, gap)));
    Row { from: -OVERHANG, to: scale.side + OVERHANG, edge: 0.0, reach: -7.0, base: -11.0 }.draw(page, labels);
}

/// Dots of the view are left of one line and above the other.
fn draw_alpha(page: &mut Page, scale: Scale, alpha: f64) {
    if alpha > scale.top {
        return;
    }
    let [x, y] = scale.place(alpha, alpha);
    let corners = [[0.0, 0.0], [x, 0.0], [x, y], [0.0, y]];
    page.polygon(&corners, format_args!("class=\"alive\" fill=\"{SCALE}\" fill-opacity=\".06\""));
    page.line([0.0, y], [scale.side, y], line_style(SCALE, "alpha"));
    vertical_line(page, scale, alpha, SCALE, "alpha");
    name_line(page, scale, x, SCALE, "alpha");
}

fn diagonal_strip(page: &mut Page, scale: Scale, gap: &Gap) {
    let end = |above: f64| [scale.side - scale.length(above), 0.0];
    let corners = [scale.place(0.0, gap.low), scale.place(0.0, gap.high), end(gap.high), end(gap.low)];
    page.polygon(&corners, strip_style(DIAGONAL, "dgap"));
}

fn vertical_strip(page: &mut Page, scale: Scale, gap: &Gap) {
    let [left, right] = [gap.low, gap.high].map(|birth| scale.length(birth));
    let corners = [[left, 0.0], [right, 0.0], [right, scale.side], [left, scale.side]];
    page.polygon(&corners, strip_style(VERTICAL, "vgap"));
}

/// The right side of VS_{k,l}, left of all strips. Returns from where on there is room for their labels.
fn draw_vs(page: &mut Page, scale: Scale, vs: f64, labels: &[Label]) -> f64 {
    vertical_line(page, scale, vs, VERTICAL, "vs");
    let needed: f64 = labels.iter().take(LABELS).map(room).sum();
    name_line(page, scale, scale.length(vs).min(scale.side - needed), VERTICAL, "vs")
}

fn vertical_line(page: &mut Page, scale: Scale, birth: f64, color: &str, class: &str) {
    let x = scale.length(birth);
    page.line([x, 0.0], [x, scale.side], line_style(color, class));
}

/// Writes a line's name on its left, if there is room right of the diagonal. Returns where free room begins on its
/// right.
fn name_line(page: &mut Page, scale: Scale, x: f64, color: &str, name: &str) -> f64 {
    let width = text_width(name) + BESIDE;
    if x - width > FOOT {
        page.text([x - BESIDE, foot(scale)], Type::new(Anchor::End, color), name);
        return x;
    }
    let x = x.max(FOOT) + BESIDE;
    page.text([x, foot(scale)], Type::new(Anchor::Start, color), name);
    x + width
}

/// The base line of texts at the foot of the frame.
fn foot(scale: Scale) -> f64 {
    scale.side - 8.0
}

/// Labels in order of rank.
fn ranks(gaps: &[Gap], name: &str, color: &'static str, about: impl Fn(&Gap) -> f64) -> Vec<Label> {
    let text = |rank: usize| format!("{name} {rank}");
    let label = |(index, gap)| Label { about: about(gap), text: text(index + 1), color };
    gaps.iter().enumerate().map(label).collect()
}

fn strip_style(color: &str, class: &str) -> String {
    format!(
        "class=\"{class}\" fill=\"{color}\" fill-opacity=\".1\" \
         stroke=\"{color}\" stroke-opacity=\".35\" stroke-width=\".75\""
    )
}

fn line_style(color: &str, class: &str) -> String {
    format!("class=\"{class}\" stroke=\"{color}\" stroke-width=\"1.4\" stroke-dasharray=\"5 3\"")
}

fn middle(scale: Scale, gap: &Gap) -> f64 {
    (scale.length(gap.low) + scale.length(gap.high)) / 2.0
}
