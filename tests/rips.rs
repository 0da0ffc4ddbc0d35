//! `hopes compute --metric` against GUDHI's and Ripser's dots of small spaces, which `data/rips/make.py` has stored.
//! The answer does not depend on the order of the points, nor on the number of threads.

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::process::hopes;
use common::random::Random;
use serde::Deserialize;
use serde_json::Value;

/// The tolerance for scales; a dot with less persistence than this part of its death is dropped on both sides.
const CLOSE: f64 = 1e-9;

/// From this many vertices on, several threads are used.
const MANY: usize = 1200;

/// What `make.py` has written of a space.
#[derive(Deserialize)]
struct Stored {
    arguments: String,
    /// Births and deaths, sorted. A cycle that never dies has no death.
    dots: Vec<(f64, Option<f64>)>,
}

struct Case {
    name: String,
    rows: String,
    stored: Stored,
}

/// The names of what an edge joins: coordinates to the last bit.
type Place = Vec<u64>;

impl Case {
    fn answer(&self) -> Value {
        answer(&self.stored.arguments, &self.rows)
    }

    fn is_of_points(&self) -> bool {
        !self.stored.arguments.contains("--metric matrix")
    }
}

fn cases() -> Vec<Case> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/rips");
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut answers: Vec<PathBuf> = files.filter(|file| file.extension().is_some_and(|end| end == "json")).collect();
    answers.sort();
    let text = |file: &Path| fs::read_to_string(file).unwrap();
    let case = |file: &PathBuf| Case {
        name: file.file_stem().unwrap().to_string_lossy().into_owned(),
        rows: text(&file.with_extension("csv")),
        stored: serde_json::from_str(&text(file)).unwrap(),
    };
    answers.iter().map(case).collect()
}

fn answer(arguments: &str, rows: &str) -> Value {
    serde_json::from_slice(&hopes("compute -").and(arguments).reads(rows).out()).unwrap()
}

fn list<'a>(answer: &'a Value, pointer: &str) -> &'a [Value] {
    answer.pointer(pointer).and_then(Value::as_array).unwrap_or_else(|| panic!("no {pointer} in {answer}"))
}

/// Births and deaths, sorted; infinite for null.
fn scales(answer: &Value) -> Vec<[f64; 2]> {
    let scale = |value: &Value| if value.is_null() { f64::INFINITY } else { value.as_f64().unwrap() };
    sorted(list(answer, "/dots").iter().map(|dot| [scale(&dot["birth"]), scale(&dot["death"])]))
}

fn sorted(dots: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    let mut dots: Vec<_> = dots.collect();
    dots.sort_by(|p, q| p.partial_cmp(q).unwrap());
    dots
}

fn is_clear([birth, death]: &[f64; 2]) -> bool {
    death.is_infinite() || death - birth > CLOSE * death
}

fn are_close(p: [f64; 2], q: [f64; 2]) -> bool {
    let close = |a: f64, b: f64| a == b || (a - b).abs() <= CLOSE * b.abs();
    close(p[0], q[0]) && close(p[1], q[1])
}

/// Whether all dots of one side have one of their own on the other. Births that rounding keeps apart on one side only
/// may be sorted otherwise.
fn agree(ours: &[[f64; 2]], theirs: &[[f64; 2]]) -> bool {
    let mut left: Vec<[f64; 2]> = theirs.iter().copied().filter(is_clear).collect();
    let found = ours.iter().filter(|dot| is_clear(dot)).all(|&dot| {
        let place = left.iter().position(|&other| are_close(dot, other));
        place.map(|place| left.remove(place)).is_some()
    });
    found && left.is_empty()
}

/// Everything of a skeleton in R^d, by positions: dots with their edges, and the tree.
fn by_position(answer: &Value) -> (Vec<Vec<Place>>, Vec<Vec<Place>>) {
    let bits = |value: &Value| value.as_f64().map_or(u64::MAX, f64::to_bits);
    let vertices: Vec<Place> =
        list(answer, "/vertices").iter().map(|vertex| list(vertex, "").iter().map(bits).collect()).collect();
    let ends = |edge: &Value| -> Vec<Place> {
        let indices = edge.as_array().into_iter().flatten();
        let mut ends: Vec<_> = indices.map(|index| vertices[index.as_u64().unwrap() as usize].clone()).collect();
        ends.sort();
        ends
    };
    let dot = |dot: &Value| -> Vec<Place> {
        let scales = vec![bits(&dot["birth"]), bits(&dot["death"])];
        [vec![scales], ends(&dot["edge"]), ends(&dot["death_edge"])].concat()
    };
    let mut dots: Vec<_> = list(answer, "/dots").iter().map(dot).collect();
    let mut tree: Vec<_> = list(answer, "/mst/edges").iter().map(ends).collect();
    dots.sort();
    tree.sort();
    (dots, tree)
}

/// A permutation of 0, 1, 2, ...
fn shuffled(count: usize, random: &mut Random) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    for last in (1..count).rev() {
        order.swap(last, random.below(last as u64 + 1) as usize);
    }
    order
}

fn shuffled_lines(rows: &str, random: &mut Random) -> String {
    let lines: Vec<&str> = rows.lines().collect();
    shuffled(lines.len(), random).into_iter().map(|line| format!("{}\n", lines[line])).collect()
}

/// The same distances, of which each knows its points by other numbers, as pairs. Those of no pair are infinite.
fn renumbered(case: &Case, random: &mut Random) -> String {
    let rows: Vec<Vec<&str>> = case.rows.lines().map(|line| line.split(',').collect()).collect();
    let form = case.stored.arguments.split(' ').next_back().unwrap();
    let mut pairs: Vec<(usize, usize, &str)> = match form {
        "sparse" => rows.iter().map(|row| (row[0].parse().unwrap(), row[1].parse().unwrap(), row[2])).collect(),
        // The first row of a lower triangle is that of the second point.
        "lower" => (1..).zip(&rows).flat_map(|(i, row)| (0..).zip(row).map(move |(j, d)| (i, j, *d))).collect(),
        _ => (0..).zip(&rows).flat_map(|(i, row)| (0..i).zip(row).map(move |(j, d)| (i, j, *d))).collect(),
    };
    pairs.retain(|(.., distance)| *distance != "inf");
    let count = 1 + pairs.iter().map(|&(i, j, _)| i.max(j)).max().unwrap();
    let order = shuffled(count, random);
    let lines: String =
        pairs.iter().map(|(i, j, distance)| format!("{},{},{distance}\n", order[*i], order[*j])).collect();
    shuffled_lines(&lines, random)
}

#[test]
fn all_dots_are_those_of_gudhi() {
    let cases = cases();
    assert!(cases.len() >= 32, "only {} spaces are stored", cases.len());
    for case in cases {
        let theirs = case.stored.dots.iter().map(|&(birth, death)| [birth, death.unwrap_or(f64::INFINITY)]);
        let (ours, theirs) = (scales(&case.answer()), sorted(theirs));
        assert!(agree(&ours, &theirs), "{}: {ours:?} instead of {theirs:?}", case.name);
    }
}

#[test]
fn the_order_of_points_changes_nothing() {
    let mut random = Random::new(1);
    for case in cases().iter().filter(|case| case.is_of_points()) {
        let permuted = answer(&case.stored.arguments, &shuffled_lines(&case.rows, &mut random));
        assert_eq!(by_position(&permuted), by_position(&case.answer()), "{}", case.name);
    }
}

#[test]
fn the_numbers_of_points_do_not_change_the_dots_of_distances() {
    let mut random = Random::new(2);
    for case in cases().iter().filter(|case| !case.is_of_points()) {
        let permuted = answer("--metric matrix --distances sparse", &renumbered(case, &mut random));
        assert_eq!(scales(&permuted), scales(&case.answer()), "{}", case.name);
    }
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let mut random = Random::new(3);
    // Points that tie, and more of them than one thread takes.
    let grid: String = (0..MANY).map(|_| [0; 3].map(|_| random.below(40).to_string()).join(",") + "\n").collect();
    let large = ("large".to_owned(), "--metric euclidean".to_owned(), grid);
    let small = cases().into_iter().map(|case| (case.name, case.stored.arguments, case.rows));
    for (name, arguments, rows) in small.chain([large]) {
        let [one, two] = ["1", "2"]
            .map(|threads| hopes("compute -").and(&arguments).set("RAYON_NUM_THREADS", threads).reads(&rows).out());
        assert!(one == two, "{name}: two threads give another answer than one");
    }
}
