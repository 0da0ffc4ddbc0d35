//! What the picture says in words.
//!
//! In: a [`Scene`], a name.
//! Out: headline, facts, a description for screen readers.
//! Invariants: one line each.
//! Must not know: shapes.

use hopes::topology::spaces::Metric;
use hopes::topology::{Filtration, ViewSpec};

use super::super::layout::{Account, Layout};
use super::canvas::numbers::{count, short};
use super::scene::{Scene, Subject};

/// Longest name shown, in characters.
const NAME: usize = 40;

/// The picture's name.
pub(super) fn headline(scene: &Scene<'_>, name: Option<&str>) -> String {
    let what = match scene.view.spec {
        ViewSpec::Full => "full skeleton HoPeS".to_owned(),
        ViewSpec::Reduced { .. } => "reduced skeleton HoPeS(\u{3b1})".to_owned(),
        ViewSpec::Derived { k, l } => format!("derived skeleton HoPeS({k}, {l})"),
    };
    match name.map(shortened).filter(|name| !name.is_empty()) {
        Some(name) => format!("{name}: {what}"),
        None => what,
    }
}

/// A name that is short enough for a headline.
pub fn shortened(name: &str) -> String {
    if name.chars().count() <= NAME {
        return name.to_owned();
    }
    name.chars().take(NAME - 1).chain(['\u{2026}']).collect()
}

/// Numbers about the picture.
pub(super) fn facts(scene: &Scene<'_>) -> String {
    let mut facts = vec![points(scene.of)];
    facts.extend(outliers(scene.of));
    facts.extend(filtration(scene.of));
    facts.extend(parameters(scene));
    facts.push(count(scene.view.components, "component"));
    facts.push(count(scene.view.cycles, "cycle"));
    facts.push(format!("{} in the diagram", count(scene.skeleton.dots().len(), "dot")));
    facts.join(" \u{b7} ")
}

/// How many points there are, and of which space, if it is not the plane.
pub(super) fn points(of: Subject<'_>) -> String {
    let vertices = of.skeleton.vertices();
    let points = count(vertices.len(), "point");
    match (of.layout, vertices.dimension()) {
        (None, _) | (_, 0) => points,
        (Some(_), dimension) => format!("{points} of R{}", superscript(dimension)),
    }
}

/// How many points were left out, if any.
pub(super) fn outliers(of: Subject<'_>) -> Option<String> {
    let outliers = of.outliers.len();
    (outliers > 0).then(|| format!("{} left out", count(outliers, "outlier")))
}

/// The filtration and the metric, if the space is not the plane.
pub(super) fn filtration(of: Subject<'_>) -> Option<String> {
    if of.skeleton.filtration() == Filtration::Alpha {
        return None;
    }
    let metric = match of.layout.and_then(Layout::metric) {
        Some(Metric::Euclidean) => "Euclidean metric",
        Some(Metric::Manhattan) => "Manhattan metric",
        Some(Metric::Chebyshev) => "Chebyshev metric",
        Some(Metric::Angular) => "angles",
        Some(Metric::Haversine) => "arcs on the Earth",
        None => "given distances",
    };
    Some(format!("Vietoris-Rips, {metric}"))
}

/// How the places of a layout were found.
pub(super) fn account(layout: &Layout<2>) -> Option<String> {
    let directions = if layout.metric() == Some(Metric::Angular) { " of the directions" } else { "" };
    match layout.account() {
        Account::Coordinates if layout.metric() == Some(Metric::Angular) => {
            Some("Directions, on the circle".to_owned())
        }
        Account::Coordinates => None,
        Account::Principal(shares) => {
            let held = Some(shares.iter().sum()).filter(|&held: &f64| held > 0.0);
            let held = held.map_or("no variance".to_owned(), |held| format!("{} of the variance", percent(held)));
            Some(format!("Principal components 1 and 2{directions}: {held}"))
        }
        Account::Scaling { share, parts } => {
            let beside = if parts > 1 { format!(", {} side by side", count(parts, "part")) } else { String::new() };
            Some(format!("Classical MDS: {} of the squared distances{beside}", percent(share)))
        }
    }
}

/// A share in whole percent; one that is not all is not called all.
fn percent(share: f64) -> String {
    let whole = (100.0 * share).round();
    let shown = if whole >= 100.0 && share < 1.0 - 1e-6 { 99.0 } else { whole };
    format!("{shown}%")
}

fn superscript(number: usize) -> String {
    let raised = [
        '\u{2070}', '\u{b9}', '\u{b2}', '\u{b3}', '\u{2074}', '\u{2075}', '\u{2076}', '\u{2077}', '\u{2078}',
        '\u{2079}',
    ];
    number.to_string().bytes().map(|digit| raised[usize::from(digit - b'0')]).collect()
}

/// Numbers that say how the view was chosen, if any did.
pub(super) fn parameters(scene: &Scene<'_>) -> Option<String> {
    match scene.view.spec {
        ViewSpec::Full => None,
        ViewSpec::Reduced { alpha } => Some(format!("alpha = {}", short(alpha))),
        ViewSpec::Derived { k, l } => {
            let selection = scene.view.selection.as_ref()?;
            let ds = selection.ds.map_or("none".to_owned(), short);
            Some(format!("k = {k}, l = {l}, ds = {ds}, vs = {}", short(selection.vs)))
        }
    }
}

/// A sentence for each panel.
pub(super) fn description(scene: &Scene<'_>) -> String {
    let (skeleton, view) = (scene.skeleton, scene.view);
    let mut text = format!(
        "Left: a cloud of {} with {} of its minimum spanning tree and {}. Right: its persistence diagram, {}",
        count(skeleton.vertices().len(), "point"),
        count(view.tree.len(), "edge"),
        count(view.critical.len(), "critical edge"),
        count(skeleton.dots().len(), "dot"),
    );
    if let Some(dot) = skeleton.dots().first() {
        text +=
            &format!(", the most persistent of which is born at {} and dies at {}", short(dot.birth), short(dot.death));
    }
    text += ".";
    if let Some(account) = scene.of.layout.and_then(account) {
        text += &format!(" {account}.");
    }
    text
}
