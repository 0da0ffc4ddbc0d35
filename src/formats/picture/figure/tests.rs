//! Figures as documents: what stands where, and how often.

use std::num::NonZeroU32;

use hopes::topology::{Frame, Pipeline, ViewSpec, simplify};
use roxmltree::{Document, Node};

use super::*;

fn frame(points: &[[f64; 2]]) -> Frame {
    let mut pipeline = Pipeline::new(hopes::topology::Options::default());
    assert!(pipeline.feed_points(points, None).is_empty());
    pipeline.commit(None);
    Frame::clone(&pipeline.poll_frame().unwrap())
}

/// Two squares that share a side, and a point of its own.
const SQUARES: [[f64; 2]; 7] = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [4.4, 0.0], [4.4, 2.0], [9.0, 9.0]];

fn derived(k: u32, l: u32) -> ViewSpec {
    let rank = |rank| NonZeroU32::new(rank).unwrap();
    ViewSpec::Derived { k: rank(k), l: rank(l) }
}

fn backdrop() -> Backdrop {
    Backdrop { png: b"bytes".to_vec(), size: [20, 10] }
}

fn texts<'a>(document: &'a Document<'_>) -> Vec<&'a str> {
    document.descendants().filter(|node| node.has_tag_name("text")).filter_map(|node| node.text()).collect()
}

fn named<'a>(document: &'a Document<'_>, tag: &str) -> Vec<Node<'a, 'a>> {
    document.descendants().filter(|node| node.has_tag_name(("http://www.w3.org/2000/svg", tag))).collect()
}

#[test]
fn panels_stand_in_the_order_given() {
    let frame = frame(&SQUARES);
    let (one, two) = (frame.view(derived(1, 1)), frame.view(derived(2, 1)));
    let simplified = simplify(&frame.skeleton, &one, 0.5);
    let simplified = Panel::Simplified {
        view: &one,
        threshold: 0.5,
        simplified: (simplified.positions.planar(), &simplified.edges),
    };
    let panels = vec![
        simplified,
        Panel::Skeleton(&two),
        Panel::Diagram(&one),
        Panel::Image,
        Panel::Cloud,
        Panel::Skeleton(&one),
    ];
    let text = figure(&Figure {
        name: Some("two & one"),
        skeleton: &frame.skeleton,
        outliers: &[],
        layout: None,
        photo: Some(backdrop()),
        panels,
    });
    let document = Document::parse(&text).unwrap();
    let texts = texts(&document);
    let titles = [
        "two & one",
        "Simplified HoPeS(1, 1)",
        "Skeleton HoPeS(2, 1)",
        "Persistence diagram",
        "Picture",
        "Cloud",
        "Skeleton HoPeS(1, 1)",
    ];
    let places: Vec<usize> =
        titles.iter().map(|title| texts.iter().position(|text| text == title).expect(title)).collect();
    assert!(places.is_sorted(), "{texts:?}");
    // The picture stands once, is seen as it is once, and pale under three skeletons.
    assert_eq!(named(&document, "image").len(), 1);
    let seen: Vec<&str> = named(&document, "use").iter().filter_map(|node| node.attribute("opacity")).collect();
    assert_eq!(seen, [PALE, PALE, "1", PALE]);
    assert!(
        texts.contains(&"critical edge") && texts.contains(&"simplified") && texts.contains(&"20 \u{d7} 10 pixels")
    );
}

#[test]
fn a_picture_lies_under_its_pixels() {
    let frame = frame(&[[0.0, 0.0], [19.0, 9.0]]);
    let figure = figure(&Figure {
        name: None,
        skeleton: &frame.skeleton,
        outliers: &[],
        layout: None,
        photo: Some(backdrop()),
        panels: vec![Panel::Image, Panel::Cloud],
    });
    let document = Document::parse(&figure).unwrap();
    let number = |node: Node<'_, '_>, name: &str| node.attribute(name).unwrap().parse::<f64>().unwrap();
    let (image, shown) = (named(&document, "image")[0], named(&document, "use")[0]);
    let scale = number(image, "width") / 20.0;
    assert!((number(image, "height") / 10.0 - scale).abs() < 0.01);
    // The dot of the upper right pixel is half a pixel from the corner.
    let dots = document.descendants().find(|node| node.attribute("class") == Some("points")).unwrap();
    let first: Vec<f64> = dots.attribute("d").unwrap()[1..]
        .split('h')
        .next()
        .unwrap()
        .split(' ')
        .map(|number| number.parse().unwrap())
        .collect();
    let corner = [number(shown, "x") + 20.0 * scale, number(shown, "y")];
    assert!((first[0] - (corner[0] - scale / 2.0)).abs() < 0.02, "{first:?} {corner:?}");
    assert!((first[1] - (corner[1] + scale / 2.0)).abs() < 0.02, "{first:?} {corner:?}");
}

/// A diagram is smaller than a panel of the plane, wherever it stands.
#[test]
fn panels_of_the_plane_are_the_same_behind_a_diagram() {
    let frame = frame(&SQUARES);
    let view = frame.view(derived(1, 1));
    let points = |panels| {
        let text =
            figure(&Figure { name: None, skeleton: &frame.skeleton, outliers: &[], layout: None, photo: None, panels });
        let document = Document::parse(&text).unwrap();
        let dots = document.descendants().find(|node| node.attribute("class") == Some("points")).unwrap();
        dots.attribute("d").unwrap().to_owned()
    };
    assert_eq!(points(vec![Panel::Diagram(&view), Panel::Cloud]), points(vec![Panel::Cloud, Panel::Diagram(&view)]));
}

#[test]
fn a_panel_alone_has_only_what_it_needs() {
    let frame = frame(&SQUARES);
    let view = frame.view(derived(1, 1));
    let alone = |panel| {
        figure(&Figure {
            name: None,
            skeleton: &frame.skeleton,
            outliers: &[],
            layout: None,
            photo: None,
            panels: vec![panel],
        })
    };
    let cloud = alone(Panel::Cloud);
    let document = Document::parse(&cloud).unwrap();
    let said = texts(&document);
    assert!(said.contains(&"point") && !said.contains(&"tree edge") && !said.contains(&"birth"), "{said:?}");
    let diagram = alone(Panel::Diagram(&view));
    let document = Document::parse(&diagram).unwrap();
    let said = texts(&document);
    assert!(said.contains(&"birth") && said.contains(&"persistence") && !said.contains(&"point"), "{said:?}");
}

#[test]
fn two_diagrams_have_one_colour_bar_and_different_gaps() {
    let frame = frame(&SQUARES);
    let (one, two) = (frame.view(derived(1, 1)), frame.view(derived(2, 2)));
    let panels = vec![Panel::Diagram(&one), Panel::Diagram(&two)];
    let text =
        figure(&Figure { name: None, skeleton: &frame.skeleton, outliers: &[], layout: None, photo: None, panels });
    let document = Document::parse(&text).unwrap();
    assert_eq!(named(&document, "linearGradient").len(), 1);
    let facts: Vec<&str> = texts(&document).into_iter().filter(|text| text.starts_with("k = ")).collect();
    assert!(facts[0].starts_with("k = 1, l = 1") && facts[1].starts_with("k = 2, l = 2"), "{facts:?}");
}

#[test]
fn degenerate_clouds_have_figures() {
    for cloud in [&[][..], &[[1e8, -1e8]], &[[0.0, 0.0], [1e-9, 1e-9]]] {
        let frame = frame(cloud);
        let view = frame.view(derived(3, 2));
        let simplified = simplify(&frame.skeleton, &view, view.scale());
        let simplified = Panel::Simplified {
            view: &view,
            threshold: view.scale(),
            simplified: (simplified.positions.planar(), &simplified.edges),
        };
        let panels = vec![Panel::Cloud, Panel::Diagram(&view), Panel::Skeleton(&view), simplified];
        let text =
            figure(&Figure { name: None, skeleton: &frame.skeleton, outliers: &[], layout: None, photo: None, panels });
        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        Document::parse(&text).unwrap();
    }
}
