//! What a figure says in words.
//!
//! In: a figure, its panels.
//! Out: a title, captions, a description for screen readers.
//! Invariants: one line each.
//! Must not know: shapes.

use hopes::topology::ViewSpec;

use super::super::canvas::numbers::{count, short};
use super::super::scene::Scene;
use super::{Backdrop, Figure, Panel, words};

/// The figure's name.
pub fn title(figure: &Figure<'_>) -> String {
    let name = figure.name.map(words::shortened).filter(|name| !name.is_empty());
    name.unwrap_or_else(|| "HoPeS".to_owned())
}

/// All panels in a sentence.
pub fn description(figure: &Figure<'_>) -> String {
    let names: Vec<&str> = figure.panels.iter().map(name).collect();
    let vertices = figure.skeleton.vertices().len();
    format!("{} of {}: {}.", count(names.len(), "panel"), count(vertices, "point"), names.join(", "))
}

fn name(panel: &Panel<'_>) -> &'static str {
    match panel {
        Panel::Image => "the picture",
        Panel::Cloud => "the cloud",
        Panel::Diagram(_) => "its persistence diagram",
        Panel::Skeleton(_) => "a skeleton",
        Panel::Simplified { .. } => "a simplified skeleton",
    }
}

/// A panel's title, and facts about it.
pub fn of_panel(figure: &Figure<'_>, panel: &Panel<'_>, scene: &Scene<'_>) -> [String; 2] {
    let view = || format!("{} \u{b7} {}", count(scene.view.cycles, "cycle"), count(scene.view.components, "component"));
    match panel {
        Panel::Image => ["Picture".to_owned(), figure.photo.as_ref().map(size).unwrap_or_default()],
        Panel::Cloud => ["Cloud".to_owned(), count(figure.skeleton.vertices().len(), "point")],
        Panel::Diagram(_) => [
            "Persistence diagram".to_owned(),
            words::parameters(scene).unwrap_or_else(|| count(figure.skeleton.dots().len(), "dot")),
        ],
        Panel::Skeleton(_) => [format!("Skeleton {}", symbol(scene.view.spec)), view()],
        Panel::Simplified { threshold, .. } => {
            let facts = format!("{} \u{b7} edges of half-length below {} collapsed", view(), short(*threshold));
            [format!("Simplified {}", symbol(scene.view.spec)), facts]
        }
    }
}

fn size(Backdrop { size: [width, height], .. }: &Backdrop) -> String {
    format!("{width} \u{d7} {height} pixels")
}

fn symbol(spec: ViewSpec) -> String {
    match spec {
        ViewSpec::Full => "HoPeS, all of it".to_owned(),
        ViewSpec::Reduced { alpha } => format!("HoPeS(\u{3b1} = {})", short(alpha)),
        ViewSpec::Derived { k, l } => format!("HoPeS({k}, {l})"),
    }
}
