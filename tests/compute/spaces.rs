//! Pictures of metric spaces.

use std::path::Path;

use roxmltree::{Document, Node};

use crate::common::process::hopes;

/// A ring in R^3 that is tilted, a few of its points twice.
fn ring() -> String {
    let point = |i: u32| {
        let turn = f64::from(i % 24) * std::f64::consts::TAU / 24.0;
        format!("{},{},{}\n", 3.0 * turn.cos(), 2.0 * turn.sin(), turn.cos() + 0.1 * (3.0 * turn).sin())
    };
    (0..26).map(point).collect()
}

fn of_class<'a>(document: &'a Document<'_>, class: &str) -> Vec<Node<'a, 'a>> {
    document.descendants().filter(|node| node.attribute("class") == Some(class)).collect()
}

fn texts<'a>(document: &'a Document<'_>) -> Vec<&'a str> {
    document.descendants().filter(|node| node.has_tag_name("text")).filter_map(|node| node.text()).collect()
}

/// The picture of what is read from stdin, without a number that is none.
fn svg(arguments: &str, input: &str) -> String {
    let text = hopes("compute - --format svg").and(arguments).reads(input).text();
    assert!(!text.contains("NaN") && !text.contains("\"inf\""), "{text}");
    text
}

#[test]
fn a_ring_in_space_is_drawn_as_a_cycle() {
    let text = svg("--metric euclidean", &ring());
    let document = Document::parse(&text).unwrap();
    assert_eq!(["cycle", "critical", "hole", "scale"].map(|class| of_class(&document, class).len()), [1, 1, 0, 1]);
    let texts = texts(&document);
    assert!(texts.iter().any(|text| text.starts_with("24 points of R\u{b3} \u{b7} Vietoris-Rips, Euclidean metric")));
    assert!(texts.iter().any(|text| text.starts_with("Principal components 1 and 2: 9")), "{texts:?}");
    assert!(texts.contains(&"cycle") && !texts.contains(&"hole"));
    // The cycle closes: as many segments as points, in one path.
    let cycle = of_class(&document, "cycle")[0].children().find(|node| node.has_tag_name("path")).unwrap();
    assert_eq!(cycle.attribute("d").unwrap().matches(['l', 'h', 'v']).count(), 24);
}

#[test]
fn the_order_of_points_and_the_threads_do_not_change_a_picture() {
    let there = svg("--metric euclidean --simplify", &ring());
    let reversed: String = ring().lines().rev().map(|line| format!("{line}\n")).collect();
    assert_eq!(svg("--metric euclidean --simplify", &reversed), there);
    let alone = hopes("compute - --format svg --metric euclidean --simplify").set("RAYON_NUM_THREADS", "1");
    assert_eq!(alone.reads(ring()).text(), there);
}

#[test]
fn metrics_say_what_is_drawn() {
    for (metric, words, has_bar) in [
        ("manhattan", "Manhattan metric", false),
        ("chebyshev", "Chebyshev metric", false),
        ("angular", "of the directions: ", false),
        ("euclidean", "Euclidean metric", true),
    ] {
        let text = svg(&format!("--metric {metric}"), &ring());
        assert!(text.contains(words), "{metric}: {text}");
        assert_eq!(of_class(&Document::parse(&text).unwrap(), "scale").len(), usize::from(has_bar), "{metric}");
    }
    let earth = svg("--metric haversine", "lon,lat\n10,50\n11,50\n11,51\n10,51\n");
    assert!(earth.contains("4 points of R\u{b2}") && earth.contains("arcs on the Earth"), "{earth}");
    assert_eq!(of_class(&Document::parse(&earth).unwrap(), "scale").len(), 0);
    assert!(svg("--metric euclidean", "1\n2\n4\n").contains("3 points of R\u{b9}"));
}

#[test]
fn distances_are_laid_out() {
    let hops = |a: i32, b: i32| (a - b).abs().min(12 - (a - b).abs());
    let rows: Vec<String> =
        (0..12).map(|a| (0..12).map(|b| hops(a, b).to_string()).collect::<Vec<_>>().join(",")).collect();
    let text = svg("--metric matrix", &(rows.join("\n") + "\n"));
    let document = Document::parse(&text).unwrap();
    assert!(text.contains("12 points \u{b7} Vietoris-Rips, given distances") && text.contains("Classical MDS: "));
    assert_eq!(["cycle", "scale"].map(|class| of_class(&document, class).len()), [1, 1]);
    assert_eq!(of_class(&document, "points")[0].attribute("d").unwrap().matches(['m', 'M']).count(), 12);
    // Points that are one under two names are one in the picture, too.
    let twins = svg("--metric matrix", "0,0,1\n0,0,1\n1,1,0\n");
    assert!(twins.contains("2 points \u{b7} Vietoris-Rips"), "{twins}");
}

#[test]
fn cycles_that_never_die_are_on_a_line_at_the_top() {
    let squares = "0 1 1\n1 2 1\n2 3 1\n3 0 1\n4 5 2\n5 6 2\n6 7 2\n7 4 2\n";
    let text = svg("--metric matrix --distances sparse --full", squares);
    let document = Document::parse(&text).unwrap();
    let [line] = of_class(&document, "infinity")[..] else { panic!("{text}") };
    let dots: Vec<_> = of_class(&document, "shown").iter().map(|dot| dot.attribute("cy")).collect();
    assert_eq!(dots, [line.attribute("y1"); 2]);
    assert!(texts(&document).contains(&"\u{221e}") && text.contains("2 parts side by side"), "{text}");
    let derived = svg("--metric matrix --distances sparse", squares);
    assert_eq!(of_class(&Document::parse(&derived).unwrap(), "infinity").len(), 1);
}

#[test]
fn spaces_have_figures_and_pixels() {
    let text = svg("--metric euclidean --panels cloud,diagram,skeleton,simplified", &ring());
    let document = Document::parse(&text).unwrap();
    for words in ["Cloud", "Persistence diagram", "Skeleton HoPeS(1, 1)", "Simplified HoPeS(1, 1)", "cycle"] {
        assert!(texts(&document).contains(&words), "{words}: {:?}", texts(&document));
    }
    assert!(text.contains("\u{b7} Principal components 1 and 2: ") && !of_class(&document, "cycle").is_empty());
    hopes("compute - --metric euclidean --panels image").reads(ring()).fails(2, &["has points: leave out image"]);
    let folder = tempfile::tempdir().unwrap();
    let path: &Path = &folder.path().join("ring.png");
    hopes("compute - --metric angular -o").with(path).reads(ring()).out();
    assert!(std::fs::read(path).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn extremes_have_pictures() {
    for (arguments, input) in [
        ("--metric euclidean", "1e150,0,0\n-1e150,1,0\n0,1e150,0\n0,-1e150,1e150\n"),
        ("--metric euclidean", "1e-150,0,0\n-1e-150,0,0\n0,1e-150,0\n0,-1e-150,1e-160\n"),
        ("--metric euclidean", "1,2,3\n"),
        ("--metric angular", "1,0,0\n5,0,0\n-2,0,0\n"),
        ("--metric matrix", "0,inf,inf\ninf,0,inf\ninf,inf,0\n"),
        ("--metric matrix", "0,1e300,1e300\n1e300,0,1e300\n1e300,1e300,0\n"),
    ] {
        let text = svg(arguments, input);
        assert_eq!(of_class(&Document::parse(&text).unwrap(), "points").len(), 1, "{arguments} {input}");
    }
}
