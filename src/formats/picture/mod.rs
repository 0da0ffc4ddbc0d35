//! Pictures: a cloud's skeleton beside its persistence diagram, as SVG or PNG; lives as bars, as SVG.
//!
//! In: a skeleton, where its vertices are drawn, a view of it, perhaps the view's simplified form; or bars.
//! Out: a document. That of a skeleton has two panels: the left one has the cloud, the tree, the critical edges and
//! the holes that they enclose, the right one the diagram with the gaps that chose them. Where holes have no place of
//! their own, which is anywhere but in the plane, the left panel has cycles.
//! Invariants: the same input gives the same bytes. The size of a document is bounded by its pixels, not by the
//! cloud. It needs no other file.
//! Must not know: where it is written to, streams, frames.
//!
//! Charts are drawn here and not by a crate such as `plotters`: those write one shape a point, so a picture grows
//! with the cloud (here marks on the same pixel are one, and a million points give two megabytes); their bytes may
//! change with every release of theirs; and diagonal strips of gaps, labels that keep clear of each other and hints
//! of single dots would have to be drawn by hand all the same.
//!
//! Data flows from the `scene` to the page: `plane`, `diagram` (with `scale` and `strips`) and `legend` draw,
//! `words` has the texts, all of it on the `canvas`; `raster` makes pixels of it (feature `png`). `barcode`, which
//! draws lives, needs no scene. `figure` has panels side by side, of the same parts.

mod barcode;
mod canvas;
mod diagram;
mod figure;
mod legend;
mod plane;
#[cfg(feature = "png")]
mod raster;
mod scale;
mod scene;
mod strips;
mod words;

use hopes::topology::View;

use canvas::layout::Layout;
use canvas::page::{Anchor, INK, MUTED, Page, Type};
use scene::Scene;

pub use barcode::{Bar, Barcode, Link, LinkKind, barcode};
pub use canvas::numbers::count;
pub use figure::{Backdrop, Figure, Panel, figure};
#[cfg(feature = "png")]
pub use raster::png;
pub use scene::{Simplified, Subject, places};
pub use words::shortened;

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

/// Draws a view of a skeleton, as an SVG document. If its simplified form is given, that is drawn bold over the faint
/// original.
///
/// # Panics
/// When an edge of `simplified` names a vertex that is not there.
pub fn svg(of: Subject<'_>, view: &View, simplified: Option<Simplified<'_>>, options: &Options) -> String {
    let scene = Scene::new(of, view, simplified);
    let layout = Layout::new(options.width, options.height);
    let headline = words::headline(&scene, options.name.as_deref());
    let mut page = Page::new(layout.size, &headline, &words::description(&scene));
    page.text([layout.plane.x, 36.0], Type::new(Anchor::Start, INK).sized(20.0), &headline);
    page.text([layout.plane.x, 58.0], Type::new(Anchor::Start, MUTED).sized(14.0), &words::facts(&scene));
    legend::draw_captions(&mut page, layout.plane, layout.diagram, &scene);
    let scale = plane::draw(&mut page, layout.plane, &scene);
    legend::draw_samples(&mut page, layout.plane, &scene, scale);
    diagram::draw(&mut page, layout.diagram, &scene);
    legend::draw_bar(&mut page, layout.bar, scene.ramp);
    page.finish()
}

#[cfg(test)]
mod tests {
    use std::num::NonZeroU32;

    use hopes::topology::{Frame, Pipeline, ViewSpec};
    use roxmltree::{Document, Node};

    use super::*;

    /// A cloud with the diagram of Figure 1 of the paper: (1.5, 2.577) and (2, 2.577).
    const FIG_1: [[f64; 2]; 10] = [
        [0.0, 0.0],
        [4.0, 0.0],
        [0.0, 4.0],
        [3.0, 4.0],
        [0.0, -4.0],
        [3.0, -4.0],
        [-1.5, 2.0],
        [-1.5, -2.0],
        [5.0, 2.0],
        [5.0, -2.0],
    ];

    fn frame(points: &[[f64; 2]]) -> Frame {
        let mut pipeline = Pipeline::new(hopes::topology::Options::default());
        assert!(pipeline.feed_points(points, None).is_empty());
        pipeline.commit(None);
        Frame::clone(&pipeline.poll_frame().unwrap())
    }

    fn derived(k: u32, l: u32) -> ViewSpec {
        let rank = |rank| NonZeroU32::new(rank).unwrap();
        ViewSpec::Derived { k: rank(k), l: rank(l) }
    }

    fn picture(points: &[[f64; 2]], spec: ViewSpec) -> String {
        let frame = frame(points);
        svg((&frame.skeleton).into(), &frame.view(spec), None, &Options::default())
    }

    fn noisy_ring(points: u32) -> Vec<[f64; 2]> {
        let noise = |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24);
        let place = |i: u32| {
            let (angle, radius) = (f64::from(i) * 2.4, 1.0 + 0.2 * noise(i));
            [radius * angle.cos(), radius * angle.sin()]
        };
        (0..points).map(place).collect()
    }

    fn of_class<'a>(document: &'a Document<'_>, class: &str) -> Vec<Node<'a, 'a>> {
        document.descendants().filter(|node| node.attribute("class") == Some(class)).collect()
    }

    fn texts<'a>(document: &'a Document<'_>) -> Vec<&'a str> {
        document.descendants().filter(|node| node.has_tag_name("text")).filter_map(|node| node.text()).collect()
    }

    /// Subpaths in a path's data: dots, or runs of segments.
    fn subpaths(node: Node<'_, '_>) -> usize {
        node.attribute("d").unwrap().matches(['m', 'M']).count()
    }

    #[test]
    fn a_derived_view_shows_what_was_chosen() {
        let text = picture(&FIG_1, derived(1, 1));
        let document = Document::parse(&text).unwrap();
        assert_eq!(subpaths(of_class(&document, "points")[0]), 10);
        assert_eq!(of_class(&document, "tree").len(), 1);
        let counts = ["hole", "shown", "selected", "dgap", "vgap", "ds", "vs", "diagonal"];
        assert_eq!(counts.map(|class| of_class(&document, class).len()), [2, 2, 0, 1, 1, 1, 1, 1]);
        let texts = texts(&document);
        for label in ["dgap 1", "vgap 1", "ds", "vs", "birth", "death", "persistence", "critical edge", "hole"] {
            assert!(texts.contains(&label), "{label} in {texts:?}");
        }
        assert!(texts.contains(&"derived skeleton HoPeS(1, 1)"));
    }

    #[test]
    fn ranks_select_fewer_dots_and_more_gaps() {
        let text = picture(&FIG_1, derived(2, 2));
        let document = Document::parse(&text).unwrap();
        let counts = ["hole", "shown", "selected", "dgap", "vgap"];
        assert_eq!(counts.map(|class| of_class(&document, class).len()), [1, 1, 1, 2, 2]);
        assert!(texts(&document).contains(&"in DS, not shown"));
    }

    #[test]
    fn full_and_reduced_views_have_no_gaps() {
        for (spec, lines) in [(ViewSpec::Full, 0), (ViewSpec::Reduced { alpha: 1.9 }, 2)] {
            let text = picture(&FIG_1, spec);
            let document = Document::parse(&text).unwrap();
            assert_eq!(of_class(&document, "alpha").len(), lines);
            assert!(["dgap", "vgap", "ds", "vs"].iter().all(|class| of_class(&document, class).is_empty()));
        }
    }

    #[test]
    fn scales_beyond_the_diagram_have_no_line() {
        for alpha in [f64::INFINITY, 1e300, 1e3] {
            let text = picture(&FIG_1, ViewSpec::Reduced { alpha });
            assert!(of_class(&Document::parse(&text).unwrap(), "alpha").is_empty());
        }
        assert!(picture(&FIG_1, ViewSpec::Reduced { alpha: 0.0 }).contains("alpha = 0"));
    }

    #[test]
    fn the_simplified_skeleton_is_over_a_faint_original() {
        let frame = frame(&FIG_1);
        let view = frame.view(derived(1, 1));
        let square = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
        let edges = [[0, 1], [1, 2], [2, 3], [0, 3]];
        let text = svg((&frame.skeleton).into(), &view, Some((&square, &edges)), &Options::default());
        let document = Document::parse(&text).unwrap();
        assert_eq!(of_class(&document, "simplified").len(), 1);
        let tree = of_class(&document, "tree")[0];
        assert_eq!(tree.parent().unwrap().attribute("opacity"), Some(".35"));
        assert!(texts(&document).contains(&"simplified"));
    }

    #[test]
    fn degenerate_clouds_have_a_picture() {
        let line: Vec<[f64; 2]> = (0..50).map(|i| [f64::from(i), 0.0]).collect();
        for cloud in [&[][..], &[[1e8, -1e8]], &[[0.0, 0.0], [1e-9, 1e-9]], &line] {
            for spec in [ViewSpec::Full, derived(1, 1), derived(9, 9), ViewSpec::Reduced { alpha: 0.1 }] {
                let text = picture(cloud, spec);
                assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
                let document = Document::parse(&text).unwrap();
                assert!(texts(&document).iter().any(|text| text.starts_with("no dots")));
                assert_eq!(of_class(&document, "points").len(), usize::from(!cloud.is_empty()));
            }
        }
    }

    #[test]
    fn offset_and_unit_change_numbers_only() {
        let shape = |text: &str| Document::parse(text).unwrap().descendants().filter(Node::is_element).count();
        let plain = picture(&FIG_1, derived(1, 2));
        for (offset, unit) in [(1048576.0 * 128.0, 1.0), (0.0, 0.5_f64.powi(30)), (0.0, 2f64.powi(190))] {
            let moved = FIG_1.map(|[x, y]| [offset + unit * x, offset + unit * y]);
            let text = picture(&moved, derived(1, 2));
            assert!(shape(&text).abs_diff(shape(&plain)) <= 24, "other ticks, but nothing else");
            let points = |text: &str| {
                let document = Document::parse(text).unwrap();
                of_class(&document, "points")[0].attribute("d").unwrap().to_owned()
            };
            assert_eq!(points(&text), points(&plain));
        }
    }

    #[test]
    fn a_picture_is_a_function_of_its_input() {
        let mut ring = noisy_ring(300);
        let first = picture(&ring, derived(1, 1));
        assert_eq!(picture(&ring, derived(1, 1)), first);
        ring.reverse();
        assert_eq!(picture(&ring, derived(1, 1)), first, "not even the order of points matters");
    }

    #[test]
    fn crowds_stay_small() {
        let text = picture(&noisy_ring(60_000), ViewSpec::Full);
        assert!(text.len() < 2_500_000, "{}", text.len());
        assert!(Document::parse(&text).unwrap().descendants().count() < 2_000);
    }

    #[test]
    fn names_are_shown_and_shortened() {
        let frame = frame(&FIG_1);
        let view = frame.view(ViewSpec::Full);
        let named = |name: &str| {
            let options = Options { name: Some(name.to_owned()), ..Options::default() };
            svg((&frame.skeleton).into(), &view, None, &options)
        };
        assert!(named("a<b>").contains("<title>a&lt;b&gt;: full skeleton HoPeS</title>"));
        assert!(named(&"x".repeat(100)).contains(&format!(">{}\u{2026}: full", "x".repeat(39))));
        assert!(named("").contains("<title>full skeleton HoPeS</title>"));
    }
}
