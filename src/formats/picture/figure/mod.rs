//! Figures: panels side by side, as papers have them: picture, cloud, diagram, skeleton, simplified skeleton.
//!
//! In: a skeleton, perhaps the picture that it comes from, and panels in the order wanted, each with its view.
//! Out: an SVG document, or its description of what is where.
//! Invariants: all panels of the plane have one scale and one place, so that they can be compared; a picture stands
//! once in the document, however often it is shown. The same input gives the same bytes.
//! Must not know: arguments, files.

mod caption;
mod foot;
mod grid;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use hopes::topology::{Skeleton, View};

use super::super::layout::Layout;
use super::canvas::camera::{Camera, Extent};
use super::canvas::layout::Rect;
use super::canvas::numbers::count;
use super::canvas::page::{Anchor, FRAME, GROUND, INK, MUTED, Page, Px, Type};
use super::plane::{self, Plane};
use super::scene::{Scene, Simplified, Subject};
use super::{diagram, legend, words};
use grid::Grid;

/// How much of a picture shows under a skeleton.
const PALE: &str = ".3";

/// What is to be drawn.
pub struct Figure<'a> {
    /// What it is called, in the headline.
    pub name: Option<&'a str>,
    /// The whole skeleton.
    pub skeleton: &'a Skeleton,
    /// Where points are that were left out of it as outliers.
    pub outliers: &'a [[f64; 2]],
    /// Where its vertices are drawn; none in the plane.
    pub layout: Option<&'a Layout<2>>,
    /// The picture whose edges the points are.
    pub photo: Option<Backdrop>,
    /// From left to right, row by row.
    pub panels: Vec<Panel<'a>>,
}

/// A picture under points.
pub struct Backdrop {
    /// As a file.
    pub png: Vec<u8>,
    /// Its pixels in a row and its rows, before it was made small: the unit of the points.
    pub size: [u32; 2],
}

/// A part of a figure.
pub enum Panel<'a> {
    /// The picture.
    Image,
    /// The points.
    Cloud,
    /// The persistence diagram, with the gaps that chose a view.
    Diagram(&'a View),
    /// A view, over the pale picture.
    Skeleton(&'a View),
    /// A view simplified, over the pale picture.
    Simplified {
        /// The view.
        view: &'a View,
        /// Below which half-length its edges were collapsed.
        threshold: f64,
        /// What is left.
        simplified: Simplified<'a>,
    },
}

impl Panel<'_> {
    fn is_diagram(&self) -> bool {
        matches!(self, Self::Diagram(_))
    }
}

/// Draws a figure, as an SVG document.
///
/// # Panics
/// When an edge of a simplified view names a vertex that is not there.
pub fn figure(figure: &Figure<'_>) -> String {
    let full = View::new(figure.skeleton, hopes::topology::ViewSpec::Full);
    let subject = Subject { skeleton: figure.skeleton, layout: figure.layout, outliers: figure.outliers };
    let scenes: Vec<Scene<'_>> = figure.panels.iter().map(|panel| scene(subject, panel, &full)).collect();
    let extent = extent(figure, &scenes);
    let grid = Grid::new(&figure.panels, extent.size());
    let title = caption::title(figure);
    let mut page = Page::new(grid.size(), &title, &caption::description(figure));
    page.text([grid.left(), 36.0], Type::new(Anchor::Start, INK).sized(20.0), &title);
    page.text([grid.left(), 58.0], Type::new(Anchor::Start, MUTED).sized(14.0), &facts(subject));
    let drawing = Drawing { figure, camera: Camera::new(extent, grid.plane()) };
    drawing.define_photo(&mut page);
    let mut has_bar = false;
    for ((panel, scene), cell) in figure.panels.iter().zip(&scenes).zip(grid.cells()) {
        let [title, facts] = caption::of_panel(figure, panel, scene);
        page.text([cell.corner[0], cell.corner[1] + 14.0], Type::new(Anchor::Start, INK).sized(14.0), &title);
        page.text([cell.corner[0], cell.corner[1] + 31.0], Type::new(Anchor::Start, MUTED), &facts);
        if panel.is_diagram() {
            diagram::draw(&mut page, cell.panel, scene);
            // One bar stands for all diagrams: they have the same dots.
            if !std::mem::replace(&mut has_bar, true) {
                legend::draw_bar(&mut page, grid::bar_beside(cell.panel), scene.ramp);
            }
        } else {
            drawing.plane(&mut page, cell.panel, panel, scene);
        }
    }
    if figure.panels.iter().any(|panel| !panel.is_diagram()) {
        let scale = if subject.has_lengths() { drawing.camera.scale() } else { 0.0 };
        foot::draw(&mut page, grid.foot(), figure, scale);
    }
    page.finish()
}

fn scene<'a>(of: Subject<'a>, panel: &Panel<'a>, full: &'a View) -> Scene<'a> {
    match panel {
        Panel::Image | Panel::Cloud => Scene::new(of, full, None),
        Panel::Diagram(view) | Panel::Skeleton(view) => Scene::new(of, view, None),
        Panel::Simplified { view, simplified, .. } => Scene::new(of, view, Some(*simplified)),
    }
}

fn facts(of: Subject<'_>) -> String {
    let mut facts = vec![words::points(of)];
    facts.extend(words::outliers(of));
    facts.extend(words::filtration(of));
    facts.push(format!("{} in the diagram", count(of.skeleton.dots().len(), "dot")));
    facts.extend(of.layout.and_then(words::account));
    facts.join(" \u{b7} ")
}

/// What all panels of the plane show: the picture, or the points and the holes of all views.
fn extent(figure: &Figure<'_>, scenes: &[Scene<'_>]) -> Extent {
    if let Some(Backdrop { size, .. }) = &figure.photo {
        let [right, top] = size.map(|side| f64::from(side) - 0.5);
        return Extent::EMPTY.with([-0.5, -0.5]).with([right, top]);
    }
    let subject = Subject { skeleton: figure.skeleton, layout: figure.layout, outliers: figure.outliers };
    let skeletons = figure.panels.iter().zip(scenes).filter(|(panel, _)| matches!(panel, Panel::Skeleton(_)));
    let holes = skeletons.flat_map(|(_, scene)| &scene.holes);
    let points = subject.places().chain(figure.outliers.iter().copied());
    holes.fold(points.fold(Extent::EMPTY, Extent::with), |extent, (_, hole)| {
        extent.with_circle(hole.center, hole.radius)
    })
}

/// What panels of the plane have in common.
struct Drawing<'a> {
    figure: &'a Figure<'a>,
    camera: Camera,
}

impl Drawing<'_> {
    fn define_photo(&self, page: &mut Page) {
        let Some(Backdrop { png, size }) = &self.figure.photo else { return };
        let [width, height] = size.map(|side| Px(f64::from(side) * self.camera.scale()));
        page.put(format_args!(
            "<defs><image id=\"photo\" width=\"{width}\" height=\"{height}\" preserveAspectRatio=\"none\" \
             href=\"data:image/png;base64,{}\"/></defs>\n",
            STANDARD.encode(png)
        ));
    }

    fn photo(&self, page: &mut Page, opacity: &str) {
        let Some(Backdrop { size: [_, rows], .. }) = &self.figure.photo else { return };
        // Points are in the middle of their pixels.
        let [x, y] = self.camera.place([-0.5, f64::from(*rows) - 0.5]).map(Px);
        page.put(format_args!("<use href=\"#photo\" x=\"{x}\" y=\"{y}\" opacity=\"{opacity}\"/>\n"));
    }

    fn plane(&self, page: &mut Page, rect: Rect, panel: &Panel<'_>, scene: &Scene<'_>) {
        page.rect(rect.grown(0.5), format_args!("fill=\"{GROUND}\" stroke=\"{FRAME}\""));
        let plane = Plane { scene, camera: self.camera, area: rect.width * rect.height };
        page.panel(rect, |page| match panel {
            Panel::Image => self.photo(page, "1"),
            Panel::Cloud => plane.draw_points(page),
            Panel::Skeleton(_) => {
                self.photo(page, PALE);
                plane.draw_original(page);
            }
            Panel::Simplified { simplified: (positions, edges), .. } => {
                self.photo(page, PALE);
                plane.draw_simplified(page, positions, edges);
            }
            Panel::Diagram(_) => {}
        });
    }
}

#[cfg(test)]
mod tests;
