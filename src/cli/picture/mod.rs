//! A picture of a cloud's skeleton beside its persistence diagram, as SVG or PNG.
//!
//! In: a skeleton, a view of it, perhaps the view's simplified form. Out: a document with two panels; the left one has the cloud, the tree, the critical
//! edges and the holes they enclose, the right one the diagram with the gaps that chose them. Invariants: the same input gives the same bytes; the
//! size of a document is bounded by its pixels, not by the cloud; it needs no other file. Must not know: where it is written to, streams,
//! frames.
//!
//! Data flows from the scene to the page: `layout` says where, `plane`, `diagram` (with `strips`) and `legend` say what, `camera`, `marks`, `labels`,
//! `ramp`, `numbers` and `words` help them, `page` writes it down; `raster` makes pixels of it.

mod camera;
mod diagram;
mod labels;
mod layout;
mod legend;
mod marks;
mod numbers;
mod page;
mod plane;
mod ramp;
mod raster;
mod strips;
mod words;

use hopes::topology::{Dot, Skeleton, View, ViewSpec};

use layout::Layout;
use page::{Anchor, INK, MUTED, Page, Type};
use ramp::Ramp;

pub use raster::{PictureError, png};

/// Vertices and edges of a simplified skeleton.
pub type Simplified<'a> = (&'a [[f64; 2]], &'a [[u32; 2]]);

/// How a picture is made.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Width in pixels; at least 800.
    pub width: u32,
    /// Height in pixels; at least 400.
    pub height: u32,
    /// What the cloud is called, in the headline.
    pub name: Option<String>,
}

impl Default for Options {
    fn default() -> Self {
        Self { width: 1200, height: 560, name: None }
    }
}

/// Draws a view of a skeleton, as an SVG document. If its simplified form is given, that is drawn bold over the faint original.
///
/// # Panics
/// When an edge of `simplified` names a vertex that is not there.
pub fn svg(skeleton: &Skeleton, view: &View, simplified: Option<Simplified<'_>>, options: &Options) -> String {
    let scene = Scene::new(skeleton, view, simplified);
    let layout = Layout::new(options.width, options.height);
    let headline = words::headline(&scene, options.name.as_deref());
    let mut page = Page::new(layout.size, &headline, &words::description(&scene));
    page.text([layout.plane.x, 36.0], Type::new(Anchor::Start, INK).sized(20.0), &headline);
    page.text([layout.plane.x, 58.0], Type::new(Anchor::Start, MUTED).sized(14.0), &words::facts(&scene));
    legend::draw_captions(&mut page, layout.plane, layout.diagram, &scene);
    let scale = plane::draw(&mut page, layout.plane, &scene);
    legend::draw_samples(&mut page, layout.plane, &scene, scale);
    diagram::draw(&mut page, layout.diagram, &scene);
    legend::draw_bar(&mut page, layout.bar, &scene);
    page.finish()
}

/// What is to be shown.
struct Scene<'a> {
    skeleton: &'a Skeleton,
    view: &'a View,
    simplified: Option<Simplified<'a>>,
    ramp: Ramp,
}

impl<'a> Scene<'a> {
    fn new(skeleton: &'a Skeleton, view: &'a View, simplified: Option<Simplified<'a>>) -> Self {
        let persistences = skeleton.dots().iter().map(Dot::persistence).filter(|value| value.is_finite());
        Self { skeleton, view, simplified, ramp: Ramp::new(persistences.fold(0.0, f64::max)) }
    }

    /// Dots whose critical edges are in the view, the most persistent first.
    fn shown_dots(&self) -> impl Iterator<Item = &'a Dot> {
        let dots = self.skeleton.dots();
        self.view.critical.iter().map(move |&index| &dots[index as usize])
    }

    /// The scale of a reduced view.
    fn alpha(&self) -> Option<f64> {
        match self.view.spec {
            ViewSpec::Reduced { alpha } => Some(alpha),
            ViewSpec::Full | ViewSpec::Derived { .. } => None,
        }
    }
}
