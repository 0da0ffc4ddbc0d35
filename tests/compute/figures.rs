//! Formats by suffix, dots as a table, pictures as input, figures of several panels.

use std::path::Path;

use roxmltree::Document;
use serde_json::Value;

use crate::common::process::hopes;
use crate::{SQUARES, answer};

const COINS: &str = "tests/data/edges/coins.png";

#[test]
fn the_suffix_of_the_output_chooses_the_format() {
    let folder = tempfile::tempdir().unwrap();
    let written = |name: &str, arguments: &str| {
        let path = folder.path().join(name);
        hopes("compute tests/cases/fig1.csv").and(arguments).with("-o").with(&path).runs().out();
        std::fs::read(path).unwrap()
    };
    for (suffix, format) in [("json", "json"), ("svg", "svg"), ("PNG", "png"), ("csv", "csv"), ("geojson", "geojson")] {
        let by_suffix = written(&format!("a.{suffix}"), "");
        assert!(by_suffix == hopes("compute tests/cases/fig1.csv --format").with(format).runs().out(), "{suffix}");
    }
    let json = hopes("compute tests/cases/fig1.csv").runs().out();
    assert_eq!(written("answer", ""), json, "without a suffix, as before");
    assert_eq!(written("table.csv", "--format json"), json, "what is said comes first");
    // Before anything is read.
    hopes("compute none.csv -o /none/x.svg").runs().fails(1, &["cannot write /none/x.svg: No such file"]);
    hopes("compute none.csv -o tests").runs().fails(1, &["cannot write tests: is a directory"]);
    hopes("compute none.csv -o Cargo.toml/x.svg")
        .runs()
        .fails(1, &["cannot write Cargo.toml/x.svg", "not a directory"]);
    hopes("compute tests/cases/fig1.csv -o x.jpg").runs().fails(2, &["x.jpg", ".json, .svg, .png, .csv, .geojson"]);
}

#[test]
fn dots_are_a_table() {
    let table = hopes("compute - --format dots").reads(SQUARES).text();
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("birth,death,persistence,i,j,x1,y1,x2,y2,center_x,center_y,radius,shown"));
    let expected = answer("", SQUARES);
    let rows: Vec<Vec<f64>> = lines.map(|line| line.split(',').map(|field| field.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), expected.dots.len());
    assert!(rows.len() >= 2);
    for (row, dot) in rows.iter().zip(&expected.dots) {
        assert_eq!((row[0], row[1], row[2]), (dot.birth, dot.death, dot.death - dot.birth));
        let [i, j] = [row[3], row[4]].map(|index| index as usize);
        assert_eq!([[row[5], row[6]], [row[7], row[8]]], [i, j].map(|vertex| expected.vertices[vertex]));
        assert_eq!(row[11], dot.death, "the radius of a hole is the death of its dot");
    }
    let shown = rows.iter().filter(|row| row[12] == 1.0).count();
    assert_eq!(shown, expected.view.critical.len());
}

#[test]
fn a_picture_is_the_cloud_of_its_edges() {
    let edges = hopes("edges").with(COINS).runs().out();
    let of_edges = hopes("compute -").reads(edges).out();
    assert!(hopes("compute").with(COINS).runs().out() == of_edges);
    assert!(hopes("compute -").reads(std::fs::read(COINS).unwrap()).out() == of_edges, "also on stdin");
    let options = "--low 100 --ratio 2 --blur 1";
    let edges = hopes("edges").with(COINS).and(options).runs().out();
    assert!(hopes("compute").with(COINS).and(options).runs().out() == hopes("compute -").reads(edges).out());
    // The name says nothing, the bytes do.
    let folder = tempfile::tempdir().unwrap();
    let disguised = folder.path().join("coins.csv");
    std::fs::copy(COINS, &disguised).unwrap();
    assert!(hopes("compute").with(disguised).runs().out() == of_edges);
    let damaged = folder.path().join("damaged.png");
    std::fs::write(&damaged, &std::fs::read(COINS).unwrap()[..2000]).unwrap();
    hopes("compute").with(damaged).runs().fails(1, &["damaged.png", "damaged PNG"]);
    hopes("compute --input picture tests/cases/fig1.csv").runs().fails(1, &["fig1.csv", "neither PNG nor JPEG"]);
}

fn texts<'a>(document: &'a Document<'_>) -> Vec<&'a str> {
    document.descendants().filter(|node| node.has_tag_name("text")).filter_map(|node| node.text()).collect()
}

#[test]
fn a_figure_of_a_picture_has_all_panels_in_one_file() {
    let folder = tempfile::tempdir().unwrap();
    let draw = |name: &str| {
        let path = folder.path().join(name);
        let panels = "--panels image,cloud,diagram,skeleton,simplified -k 7 -l 4 -o";
        hopes("compute").with(COINS).and(panels).with(&path).runs().out();
        std::fs::read(path).unwrap()
    };
    let svg = String::from_utf8(draw("fig.svg")).unwrap();
    let document = Document::parse(&svg).unwrap();
    let texts = texts(&document);
    for title in ["coins", "Picture", "Cloud", "Persistence diagram", "Skeleton HoPeS(7, 4)", "Simplified HoPeS(7, 4)"]
    {
        assert!(texts.contains(&title), "{title}: {texts:?}");
    }
    let images = document.descendants().filter(|node| node.has_tag_name(("http://www.w3.org/2000/svg", "image")));
    let hrefs: Vec<&str> = images.filter_map(|image| image.attribute("href")).collect();
    assert!(hrefs.len() == 1 && hrefs[0].starts_with("data:image/png;base64,iVBORw0KGgo"), "{}", hrefs.len());
    assert!(svg.len() < 300_000, "{}", svg.len());
    assert!(svg.as_bytes() == draw("fig.svg"), "the same bytes every time");
    let pixels = draw("fig.png");
    let mut reader = png::Decoder::new(std::io::Cursor::new(&pixels)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    // Where the picture is, it is dark: the panel's left upper quarter has the gray ground of the coins.
    let (width, at) = (reader.info().width as usize, |x: usize, y: usize| (x, y));
    let (x, y) = at(2 * 120, 2 * 200);
    assert!(bytes[4 * (y * width + x)] < 140, "the photo is in the pixels: {:?}", &bytes[4 * (y * width + x)..][..4]);
}

#[test]
fn points_have_figures_of_any_panels() {
    let figure = |panels: &str| hopes("compute tests/cases/wheel7_n400_e0.02.csv --panels").and(panels).runs().text();
    let several = figure("diagram:1:1,skeleton:1:1,diagram:2:1,skeleton:2:1");
    let document = Document::parse(&several).unwrap();
    let skeletons: Vec<&str> = texts(&document).into_iter().filter(|text| text.starts_with("Skeleton")).collect();
    assert_eq!(skeletons, ["Skeleton HoPeS(1, 1)", "Skeleton HoPeS(2, 1)"]);
    for (panels, title) in
        [("cloud", "Cloud"), ("diagram", "Persistence diagram"), ("skeleton --full", "Skeleton HoPeS, all of it")]
    {
        let text = figure(panels);
        let document = Document::parse(&text).unwrap();
        assert!(texts(&document).contains(&title), "{panels}");
        assert!(!text.contains("<image"), "{panels}");
    }
    let text = figure("simplified --full --simplify=0.05");
    assert!(text.contains("Simplified HoPeS, all of it"));
    let compute = |arguments: &str| hopes("compute tests/cases/fig1.csv").and(arguments).runs();
    compute("--panels image,cloud").fails(2, &["fig1.csv is no picture", "leave out image"]);
    compute("--panels simplified --full").fails(2, &["--simplify=RADIUS"]);
    compute("--panels cloud --format csv").fails(2, &["--panels draws a picture"]);
    let many = ["cloud"; 17].join(",");
    hopes("compute tests/cases/fig1.csv --panels").with(many).runs().fails(2, &["17 panels are too many"]);
    assert!(Path::new(COINS).exists());
}

/// A JPEG that its Exif turns stands upright, as `edges` has it.
#[test]
fn a_turned_picture_stands_upright_under_its_points() {
    let turned = "tests/data/edges/coffee-turned.jpg";
    let answer: Value = serde_json::from_slice(&hopes("compute").with(turned).runs().out()).unwrap();
    let vertices = answer["vertices"].as_array().unwrap();
    let most = |axis: usize| vertices.iter().map(|vertex| vertex[axis].as_f64().unwrap()).fold(0.0, f64::max);
    let figure = hopes("compute").with(turned).and("--panels image").runs().text();
    let document = Document::parse(&figure).unwrap();
    let size = texts(&document).into_iter().find(|text| text.ends_with(" pixels")).unwrap();
    let sides: Vec<f64> =
        size.trim_end_matches(" pixels").split(" \u{d7} ").map(|side| side.parse().unwrap()).collect();
    assert!(most(0) < sides[0] && most(1) < sides[1] && most(0) > 0.8 * sides[0], "{size}");
}
