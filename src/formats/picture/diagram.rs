//! The right panel: the persistence diagram.
//!
//! In: a [`Scene`].
//! Out: shapes on the page.
//! Invariants: both axes begin at 0 and have one scale, so the diagonal is one; every dot is inside the frame, those
//! that never die on a line at its top; dots of the view are on top and have their colour.
//! Must not know: the plane.

use hopes::topology::Dot;

use super::canvas::colors::OTHER;
use super::canvas::layout::Rect;
use super::canvas::marks::Grid;
use super::canvas::numbers::{Ticks, short};
use super::canvas::page::{Anchor, FRAME, GRID, GROUND, INK, MUTED, Page, Type};
use super::canvas::ramp::{BUCKETS, Bucket, STOPS};
use super::scale::Scale;
use super::scene::Scene;
use super::strips;

/// Up to so many dots are circles with hints; more are paths.
const CIRCLES: usize = 400;
/// Pixels between ticks, about.
const TICK_SPACE: f64 = 75.0;

const DOT_STYLE: &str = "fill=\"none\" stroke-linecap=\"round\"";

/// Draws the panel.
pub(super) fn draw(page: &mut Page, panel: Rect, scene: &Scene<'_>) {
    let scale = Scale::new(scene, panel.width);
    page.group(format_args!("transform=\"translate({} {})\"", panel.x, panel.y), |page| {
        draw_box(page, scale.side, GROUND, "none");
        if scale.top > 0.0 {
            draw_grid(page, scale);
            strips::draw(page, scale, scene);
            page.line([0.0, scale.side], [scale.side, 0.0], format_args!("class=\"diagonal\" stroke=\"{MUTED}\""));
            draw_dots(page, scale, scene);
        } else {
            draw_nothing(page, scale.side);
        }
        draw_box(page, scale.side, "none", FRAME);
    });
}

fn draw_box(page: &mut Page, side: f64, fill: &str, stroke: &str) {
    let inside = Rect { x: 0.0, y: 0.0, width: side, height: side };
    page.rect(inside.grown(0.5), format_args!("fill=\"{fill}\" stroke=\"{stroke}\""));
}

fn draw_nothing(page: &mut Page, side: f64) {
    page.line([0.0, side], [side, 0.0], format_args!("class=\"diagonal\" stroke=\"{FRAME}\""));
    page.text([0.36 * side, 0.25 * side], Type::new(Anchor::Middle, MUTED), "no dots: the cloud has no cycle");
    draw_names(page, side, "");
}

fn draw_grid(page: &mut Page, scale: Scale) {
    let ticks = Ticks::new(scale.top, scale.side / TICK_SPACE);
    for (value, label) in ticks.all() {
        let [x, y] = scale.place(value, value);
        if value > 0.0 {
            page.line([x, 0.0], [x, scale.side], format_args!("stroke=\"{GRID}\""));
            page.line([0.0, y], [scale.side, y], format_args!("stroke=\"{GRID}\""));
        }
        page.line([x, scale.side], [x, scale.side + 5.0], format_args!("stroke=\"{FRAME}\""));
        page.line([-5.0, y], [0.0, y], format_args!("stroke=\"{FRAME}\""));
        page.text([x, scale.side + 18.0], Type::new(Anchor::Middle, MUTED), &label);
        page.text([-9.0, y + 4.0], Type::new(Anchor::End, MUTED), &label);
    }
    if let Some(y) = scale.line() {
        page.line([-5.0, y], [scale.side, y], format_args!("class=\"infinity\" stroke=\"{FRAME}\""));
        page.text([-9.0, y + 4.0], Type::new(Anchor::End, MUTED).sized(15.0), "\u{221e}");
    }
    draw_names(page, scale.side, &ticks.factor());
}

fn draw_names(page: &mut Page, side: f64, factor: &str) {
    let name = Type::new(Anchor::Middle, INK).sized(13.0);
    page.text([side / 2.0, side + 38.0], name, &format!("birth{factor}"));
    page.upward_text([-48.0, side / 2.0], name, &format!("death{factor}"));
}

/// What the view makes of the dots.
struct Sorted<'a> {
    /// Their critical edges are in the view.
    shown: Vec<&'a Dot>,
    /// Those of DS_k that are not.
    selected: Vec<&'a Dot>,
    others: Vec<&'a Dot>,
}

impl<'a> Sorted<'a> {
    fn new(scene: &Scene<'a>) -> Self {
        let dots = scene.skeleton.dots();
        let selected = scene.view.selection.as_ref().map_or(0, |selection| selection.ds_count);
        let mut is_shown = vec![false; dots.len()];
        for &index in &scene.view.critical {
            is_shown[index as usize] = true;
        }
        let mut sorted = Self { shown: Vec::new(), selected: Vec::new(), others: Vec::new() };
        for (index, dot) in dots.iter().enumerate() {
            let list = match is_shown[index] {
                true => &mut sorted.shown,
                false if index < selected => &mut sorted.selected,
                false => &mut sorted.others,
            };
            list.push(dot);
        }
        sorted
    }
}

fn draw_dots(page: &mut Page, scale: Scale, scene: &Scene<'_>) {
    let sorted = Sorted::new(scene);
    let others = crowd(scale, &sorted.others);
    page.path(&others, format_args!("class=\"others\" {DOT_STYLE} stroke=\"{OTHER}\" stroke-width=\"3\""));
    let color = |dot: &Dot| scene.ramp.bucket(dot.persistence()).color();
    if sorted.selected.len() <= CIRCLES {
        let style =
            |dot: &Dot| format!("class=\"selected\" fill=\"#fff\" stroke=\"{}\" stroke-width=\"1.5\"", color(dot));
        draw_circles(page, scale, &sorted.selected, |_| 3.5, style);
    } else {
        draw_rings(page, &crowd(scale, &sorted.selected));
    }
    if sorted.shown.len() <= CIRCLES {
        let style = |dot: &Dot| format!("class=\"shown\" fill=\"{}\" stroke=\"#fff\"", color(dot));
        let radius = |dot: &Dot| 3.0 + 1.5 * scene.ramp.bucket(dot.persistence()).share();
        draw_circles(page, scale, &sorted.shown, radius, style);
    } else {
        draw_crowd(page, scale, scene, &sorted.shown);
    }
    draw_legend(page, scale.side, &sorted);
}

/// The more persistent, the farther on top.
fn draw_circles(
    page: &mut Page,
    scale: Scale,
    dots: &[&Dot],
    radius: impl Fn(&Dot) -> f64,
    style: impl Fn(&Dot) -> String,
) {
    for dot in dots.iter().rev() {
        page.circle(scale.place(dot.birth, dot.death), radius(dot), style(dot), Some(&hint(dot)));
    }
}

fn draw_rings(page: &mut Page, data: &str) {
    for (color, width) in [(MUTED, 7), ("#fff", 4)] {
        page.path(data, format_args!("class=\"selected\" {DOT_STYLE} stroke=\"{color}\" stroke-width=\"{width}\""));
    }
}

fn hint(dot: &Dot) -> String {
    format!("birth {}, death {}, persistence {}", short(dot.birth), short(dot.death), short(dot.persistence()))
}

/// One path for many dots.
fn crowd(scale: Scale, dots: &[&Dot]) -> String {
    let grid = Grid::new(dots.len(), scale.side * scale.side / 2.0);
    grid.dots(dots.iter().map(|dot| scale.place(dot.birth, dot.death)))
}

fn draw_crowd(page: &mut Page, scale: Scale, scene: &Scene<'_>, dots: &[&Dot]) {
    let mut buckets = vec![Vec::new(); BUCKETS];
    for &dot in dots {
        buckets[scene.ramp.bucket(dot.persistence()).index()].push(dot);
    }
    for bucket in Bucket::all() {
        let data = crowd(scale, &buckets[bucket.index()]);
        let (color, width) = (bucket.color(), 3.0 + 4.0 * bucket.share());
        page.path(&data, format_args!("class=\"shown\" {DOT_STYLE} stroke=\"{color}\" stroke-width=\"{width:.1}\""));
    }
}

/// In the corner right of the diagonal, where no dot can be.
fn draw_legend(page: &mut Page, side: f64, sorted: &Sorted<'_>) {
    let entries: Vec<_> = legend_entries(sorted).into_iter().filter(|entry| entry.count > 0).collect();
    let height = 18.0 * entries.len() as f64;
    let ground = Rect { x: side - 132.0, y: side - 34.0 - height, width: 124.0, height: height + 6.0 };
    page.rect(ground, format_args!("rx=\"4\" fill=\"{GROUND}\" fill-opacity=\".85\""));
    for (index, entry) in entries.iter().enumerate() {
        let y = ground.y + 15.0 + 18.0 * index as f64;
        page.circle([ground.x + 12.0, y - 4.0], entry.radius, &entry.style, None);
        page.text([ground.x + 24.0, y], Type::new(Anchor::Start, MUTED), entry.name);
    }
}

struct Entry {
    count: usize,
    name: &'static str,
    radius: f64,
    style: String,
}

fn legend_entries(sorted: &Sorted<'_>) -> [Entry; 3] {
    let dark = STOPS[STOPS.len() - 1];
    let entry = |dots: &Vec<&Dot>, name, radius, style| Entry { count: dots.len(), name, radius, style };
    [
        entry(&sorted.shown, "shown cycles", 4.5, format!("fill=\"{dark}\"")),
        entry(
            &sorted.selected,
            "in DS, not shown",
            3.5,
            format!("fill=\"#fff\" stroke=\"{dark}\" stroke-width=\"1.5\""),
        ),
        entry(&sorted.others, "other dots", 1.5, format!("fill=\"{OTHER}\"")),
    ]
}
