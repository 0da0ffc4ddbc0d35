//! What chose the view, inside the diagram: gaps as shaded strips, ds and vs (or alpha) as lines, all of them labelled.
//!
//! In: a [`Scene`] and the diagram's [`Scale`]. Out: shapes on the page. Invariants: labels of diagonal gaps are above the frame, all others at
//! its foot, right of the diagonal, where no dot can be; of many gaps the widest are labelled. Must not know: dots.

use hopes::topology::{Gap, Selection};

use super::Scene;
use super::diagram::Scale;
use super::labels::{Label, Row};
use super::page::Page;

const DIAGONAL: &str = "#0b7d62";
const VERTICAL: &str = "#2563c9";
const ALPHA: &str = "#9a3412";
/// Height of the texts at the foot of the frame, with the room below them.
const FOOT: f64 = 22.0;

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
    let mut above = Vec::new();
    if let Some(ds) = selection.ds {
        let (from, to) = (scale.place(0.0, ds), [scale.side - scale.length(ds), 0.0]);
        page.line(from, to, line_style(DIAGONAL, "ds"));
        above.push(Label { about: to[0], text: "ds".to_owned(), color: DIAGONAL });
    }
    let mut below = Vec::new();
    if selection.vs <= scale.top {
        below.push(vertical_line(page, scale, selection.vs, "vs", VERTICAL));
    }
    above.extend(labels(&selection.diagonal, "dgap", DIAGONAL, |gap| scale.side - middle(scale, gap)));
    below.extend(labels(&selection.vertical, "vgap", VERTICAL, |gap| middle(scale, gap)));
    Row { from: 0.0, to: scale.side, edge: 0.0, reach: -6.0, base: -9.0 }.draw(page, above);
    foot(scale).draw(page, below);
}

/// Dots of the view are left of one line and above the other.
fn draw_alpha(page: &mut Page, scale: Scale, alpha: f64) {
    if alpha > scale.top {
        return;
    }
    let [x, y] = scale.place(alpha, alpha);
    let corners = [[0.0, 0.0], [x, 0.0], [x, y], [0.0, y]];
    page.polygon(&corners, format_args!("class=\"alive\" fill=\"{ALPHA}\" fill-opacity=\".06\""));
    page.line([0.0, y], [scale.side, y], line_style(ALPHA, "alpha"));
    let label = vertical_line(page, scale, alpha, "alpha", ALPHA);
    foot(scale).draw(page, vec![label]);
}

fn foot(scale: Scale) -> Row {
    let side = scale.side;
    Row { from: FOOT, to: side, edge: side, reach: side - 5.0, base: side - 8.0 }
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

fn vertical_line(page: &mut Page, scale: Scale, birth: f64, name: &str, color: &'static str) -> Label {
    let x = scale.length(birth);
    page.line([x, 0.0], [x, scale.side], line_style(color, name));
    Label { about: x, text: name.to_owned(), color }
}

/// Labels in order of rank.
fn labels(gaps: &[Gap], name: &str, color: &'static str, about: impl Fn(&Gap) -> f64) -> Vec<Label> {
    let label = |(index, gap)| Label { about: about(gap), text: format!("{name} {}", index + 1), color };
    gaps.iter().enumerate().map(label).collect()
}

fn strip_style(color: &str, class: &str) -> String {
    format!(
        "class=\"{class}\" fill=\"{color}\" fill-opacity=\".1\" stroke=\"{color}\" stroke-opacity=\".35\" stroke-width=\".75\""
    )
}

fn line_style(color: &str, class: &str) -> String {
    format!("class=\"{class}\" stroke=\"{color}\" stroke-width=\"1.4\" stroke-dasharray=\"5 3\"")
}

fn middle(scale: Scale, gap: &Gap) -> f64 {
    (scale.length(gap.low) + scale.length(gap.high)) / 2.0
}
