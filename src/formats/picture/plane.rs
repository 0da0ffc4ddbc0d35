//! The left panel: the cloud, the tree, the critical edges, their holes or cycles, the simplified skeleton.
//!
//! In: a [`Scene`].
//! Out: shapes on the page, the most important on top.
//! Invariants: holes and cycles are drawn for the most persistent dots only, marks are thinned to the panel's pixels;
//! critical edges, holes and cycles have the colour of their persistence.
//! Must not know: the diagram, gaps.

use hopes::topology::Edge;

use super::canvas::camera::{Camera, Extent};
use super::canvas::colors::{EDGE, POINT};
use super::canvas::layout::Rect;
use super::canvas::marks::Grid;
use super::canvas::numbers::short;
use super::canvas::page::{FRAME, GROUND, INK, Page};
use super::canvas::ramp::{BUCKETS, Bucket, Rgb, STOPS};
use super::scene::Scene;

/// Smaller holes than this cannot be seen.
const LEAST_HOLE: f64 = 1.0;
/// Outlines of smaller holes than this would be clutter.
const LEAST_OUTLINE: f64 = 16.0;
/// So many cycles are few.
const STACKED: usize = 4;
/// How much wider the next of few cycles is, in widths of the one on top.
const CYCLE_STEP: f64 = 2.0;
/// How opaque the wider ones are.
const BAND: f64 = 0.6;
/// How much wider the ground of a cycle is than the cycle, in the same.
const CYCLE_GROUND: f64 = 1.1;
/// At most so many vertices of a simplified skeleton are marked.
const NODES: usize = 2000;

/// The colours and widths of an outlier's dots.
pub(super) const OUTLIER: [(&str, f64); 2] = [(POINT, 4.6), (GROUND, 2.8)];

pub(super) const CRITICAL_STYLE: &str = "fill=\"none\" stroke-linecap=\"round\"";
pub(super) const SIMPLE_STYLE: &str =
    "fill=\"none\" stroke=\"#1b2432\" stroke-linecap=\"round\" stroke-linejoin=\"round\"";

/// Draws the panel, and returns how many pixels a unit of the plane has.
pub(super) fn draw(page: &mut Page, panel: Rect, scene: &Scene<'_>) -> f64 {
    let camera = Camera::new(extent(scene), panel);
    page.rect(panel.grown(0.5), format_args!("fill=\"{GROUND}\" stroke=\"{FRAME}\""));
    let view = Plane { scene, camera, area: panel.width * panel.height };
    page.panel(panel, |page| match scene.simplified {
        None => view.draw_original(page),
        Some((positions, edges)) => {
            page.group(format_args!("opacity=\".35\""), |page| view.draw_original(page));
            view.draw_simplified(page, positions, edges);
        }
    });
    camera.scale()
}

fn extent(scene: &Scene<'_>) -> Extent {
    let outliers = scene.of.outliers.iter().copied();
    let around_points = scene.of.places().chain(outliers).fold(Extent::EMPTY, Extent::with);
    scene.holes.iter().fold(around_points, |extent, (_, hole)| extent.with_circle(hole.center, hole.radius))
}

/// How bold marks are where there are so many on so many square pixels: from 1 down.
fn weight(marks: usize, area: f64) -> f64 {
    ((area / marks.max(1) as f64).sqrt() / 12.0).clamp(0.3, 1.0)
}

/// The cloud in its panel.
pub(super) struct Plane<'a> {
    pub(super) scene: &'a Scene<'a>,
    pub(super) camera: Camera,
    /// Square pixels of the panel.
    pub(super) area: f64,
}

impl Plane<'_> {
    pub(super) fn draw_original(&self, page: &mut Page) {
        self.draw_holes(page);
        self.draw_tree(page);
        self.draw_cycles(page);
        self.draw_points(page);
        self.draw_critical(page);
    }

    fn draw_holes(&self, page: &mut Page) {
        for (dot, hole) in &self.scene.holes {
            let radius = hole.radius * self.camera.scale();
            if radius < LEAST_HOLE {
                continue;
            }
            let color = self.scene.ramp.bucket(dot.persistence()).color();
            let hint = format!("hole: birth {}, death {}", short(dot.birth), short(dot.death));
            let style = hole_style(color, radius >= LEAST_OUTLINE);
            page.circle(self.camera.place(hole.center), radius, format_args!("class=\"hole\" {style}"), Some(&hint));
        }
    }

    fn draw_tree(&self, page: &mut Page) {
        let edges = &self.scene.view.tree;
        let data = self.segments(edges.len(), edges.iter().copied());
        let width = 1.1 * weight(self.scene.skeleton.vertices().len(), self.area);
        page.path(&data, format_args!("class=\"tree\" {} stroke-width=\"{width:.2}\"", line_style(EDGE)));
    }

    pub(super) fn draw_points(&self, page: &mut Page) {
        self.draw_outliers(page);
        let places = self.scene.of.places().map(|point| self.camera.place(point));
        let count = places.len();
        let data = Grid::new(count, self.area).dots(places);
        let width = 3.6 * weight(count, self.area);
        page.path(&data, format_args!("class=\"points\" {} stroke-width=\"{width:.2}\"", line_style(POINT)));
    }

    /// Small hollow circles: dots with lighter ones on top.
    fn draw_outliers(&self, page: &mut Page) {
        let outliers = self.scene.of.outliers;
        if outliers.is_empty() {
            return;
        }
        let places = outliers.iter().map(|&outlier| self.camera.place(outlier));
        let data = Grid::new(outliers.len(), self.area).dots(places);
        let weight = weight(outliers.len() + self.scene.of.places().len(), self.area);
        page.group(format_args!("class=\"outliers\""), |page| {
            for (color, width) in OUTLIER {
                page.path(&data, format_args!("{} stroke-width=\"{:.2}\"", line_style(color), width * weight));
            }
        });
    }

    /// Each on a pale ground of its own, so that one sees which is above where two of them cross. The more persistent
    /// a cycle is, the farther on top. Where they are few, those below are wider, so that one sees all of them where
    /// they run together.
    fn draw_cycles(&self, page: &mut Page) {
        let cycles = self.scene.cycles();
        let length = cycles.iter().map(|(_, cycle)| cycle.len()).sum();
        let thin = 1.8 * weight(length, self.area);
        let step = if cycles.len() <= STACKED { CYCLE_STEP } else { 0.0 };
        for (rank, (dot, cycle)) in cycles.iter().enumerate().rev() {
            let next = cycle.iter().cycle().skip(1);
            let data = self.segments(length, cycle.iter().zip(next).map(|(&a, &b)| [a.min(b), a.max(b)]));
            if data.is_empty() {
                continue;
            }
            let color = self.scene.ramp.bucket(dot.persistence()).color();
            let width = thin * (1.0 + step * rank as f64);
            // Bold bands would look more persistent than the line on top.
            let opacity = if width > thin { BAND } else { 1.0 };
            page.group(format_args!("class=\"cycle\" fill=\"none\" stroke-linecap=\"round\""), |page| {
                page.hint(&format!("cycle: birth {}, death {}", short(dot.birth), short(dot.death)));
                page.path(
                    &data,
                    format_args!("stroke=\"{GROUND}\" stroke-width=\"{:.2}\"", width + CYCLE_GROUND * thin),
                );
                page.path(
                    &data,
                    format_args!("stroke=\"{color}\" stroke-width=\"{width:.2}\" stroke-opacity=\"{opacity}\""),
                );
            });
        }
    }

    /// The more persistent an edge is, the bolder and the farther on top.
    fn draw_critical(&self, page: &mut Page) {
        let weight = weight(self.scene.view.critical.len(), self.area);
        let mut buckets = vec![Vec::new(); BUCKETS];
        for dot in self.scene.shown_dots() {
            buckets[self.scene.ramp.bucket(dot.persistence()).index()].push(dot.edge);
        }
        for bucket in Bucket::all() {
            let edges = &buckets[bucket.index()];
            let data = self.segments(self.scene.view.critical.len(), edges.iter().copied());
            let width = weight * (1.5 + 2.5 * bucket.share());
            let color = bucket.color();
            page.path(
                &data,
                format_args!("class=\"critical\" {CRITICAL_STYLE} stroke=\"{color}\" stroke-width=\"{width:.2}\""),
            );
        }
    }

    fn segments(&self, marks: usize, edges: impl Iterator<Item = Edge>) -> String {
        let ends = |edge: Edge| edge.map(|end| self.camera.place(self.scene.of.xy(end)));
        Grid::new(marks, self.area).segments(edges.map(ends))
    }

    pub(super) fn draw_simplified(&self, page: &mut Page, positions: &[[f64; 2]], edges: &[[u32; 2]]) {
        let weight = weight(edges.len(), self.area);
        let place = |end: u32| self.camera.place(positions[end as usize]);
        let data = Grid::new(edges.len(), self.area).segments(edges.iter().map(|edge| edge.map(place)));
        let width = 3.0 * weight;
        page.path(&data, format_args!("class=\"simplified\" {SIMPLE_STYLE} stroke-width=\"{width:.2}\""));
        let nodes = nodes(positions.len(), edges).take(NODES).map(place);
        let data = Grid::new(positions.len(), self.area).dots(nodes);
        for (color, width) in [(INK, 8.0 * weight), ("#fff", 4.0 * weight)] {
            page.path(
                &data,
                format_args!("fill=\"none\" stroke=\"{color}\" stroke-linecap=\"round\" stroke-width=\"{width:.2}\""),
            );
        }
    }
}

/// How points and tree edges look.
pub(super) fn line_style(color: &str) -> String {
    format!("fill=\"none\" stroke=\"{color}\" stroke-linecap=\"round\"")
}

/// How the most persistent cycle looks.
pub(super) fn cycle_style() -> String {
    format!("{CRITICAL_STYLE} stroke=\"{}\" stroke-width=\"1.8\"", STOPS[STOPS.len() - 1])
}

/// How a hole looks.
pub(super) fn hole_style(color: Rgb, outlined: bool) -> String {
    let mut style = format!("fill=\"{color}\" fill-opacity=\".09\"");
    if outlined {
        style += &format!(" stroke=\"{color}\" stroke-opacity=\".55\" stroke-width=\".9\" stroke-dasharray=\"4 3\"");
    }
    style
}

/// Vertices where a skeleton ends or forks.
fn nodes(vertices: usize, edges: &[[u32; 2]]) -> impl Iterator<Item = u32> {
    let mut degrees = vec![0_u32; vertices];
    for end in edges.iter().flatten() {
        degrees[*end as usize] += 1;
    }
    (0..vertices as u32).filter(move |&vertex| degrees[vertex as usize] != 2)
}
