//! What the picture says in words.
//!
//! In: a [`Scene`], a name.
//! Out: headline, facts, a description for screen readers.
//! Invariants: one line each.
//! Must not know: shapes.

use hopes::topology::ViewSpec;

use super::canvas::numbers::{count, short};
use super::scene::Scene;

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
    let mut facts = vec![count(scene.skeleton.vertices().len(), "point")];
    facts.extend(parameters(scene));
    facts.push(count(scene.view.components, "component"));
    facts.push(count(scene.view.cycles, "cycle"));
    facts.push(format!("{} in the diagram", count(scene.skeleton.dots().len(), "dot")));
    facts.join(" \u{b7} ")
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
    text + "."
}
