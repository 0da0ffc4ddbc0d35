//! `hopes compute` as a process: files and pipes as input; answers, pictures, messages and exit codes as output.

mod common;
#[path = "compute/declutter.rs"]
mod declutter;
#[path = "compute/figures.rs"]
mod figures;
#[path = "compute/projected.rs"]
mod projected;
#[path = "compute/spaces.rs"]
mod spaces;

use std::collections::BTreeSet;
use std::io::Read;
use std::path::Path;

use common::process::{Hopes, hopes};
use common::random::Random;
use common::reply::{Margins, Reply, Simplified, half_length};
use common::{Case, DerivedAnswer, cases};
use serde_json::{Value, json};

/// The tolerance for scales, relative to the largest death.
const CLOSE: f64 = 1e-9;

/// Rounded coordinates: ties differ by an ulp. Dots and trees are compared, skeletons are not.
const ROUNDED_TIES: [&str; 3] = ["lattice_20x20_step0.1", "lattice_tri_sqrt3", "regular_60gon_float"];

const SQUARE: &str = "0,0\n1,0\n1,1\n0,1\n";

/// Two squares that share a side, and an isolated point.
const SQUARES: &str = "0,0\n2,0\n2,2\n0,2\n5,0\n5,2\n9,9\n";

fn reply(program: &Hopes, input: impl AsRef<[u8]>) -> Reply {
    Reply::of(program.reads(input).out())
}

/// The answer for these arguments and this input.
fn answer(arguments: &str, input: impl AsRef<[u8]>) -> Reply {
    reply(&hopes(&format!("compute - {arguments}")), input)
}

fn case_file(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases").join(format!("{name}.csv"))
}

fn csv(points: &[[f64; 2]]) -> String {
    points.iter().map(|[x, y]| format!("{x},{y}\n")).collect()
}

fn random_points(seed: u64, count: usize) -> Vec<[f64; 2]> {
    let mut random = Random::new(seed);
    (0..count).map(|_| random.point()).collect()
}

// ---- answers

#[test]
fn an_answer_has_exactly_these_keys() {
    let half_diagonal = 0.5f64.sqrt();
    let persistence = half_diagonal - 0.5;
    let answer: Value = serde_json::from_str(&hopes("compute -").reads(SQUARE).text()).unwrap();
    let expected = json!({
        "points": 4,
        "duplicates": 0,
        "rejected": 0,
        "vertices": [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        "dots": [{
            "birth": 0.5,
            "death": half_diagonal,
            "edge": [1, 2],
            "hole": {"center": [0.5, 0.5], "radius": half_diagonal},
        }],
        "mst": {"edges": [[0, 1], [0, 3], [2, 3]], "length": 3.0},
        "view": {
            "kind": "derived",
            "k": 1,
            "l": 1,
            "ds": persistence,
            "vs": 0.5,
            "edges": [[0, 1], [0, 3], [2, 3]],
            "critical": [[1, 2]],
            "components": 1,
            "cycles": 1,
            "length": 4.0,
            "margins": {"diagonal": persistence / 8.0, "vertical": null},
        },
    });
    assert_eq!(answer, expected);
}

#[test]
fn the_keys_depend_on_the_view() {
    let keys = |arguments: &str, pointer: &str| -> Vec<String> {
        let answer: Value = serde_json::from_slice(&hopes(arguments).reads(SQUARE).out()).unwrap();
        let mut keys: Vec<_> = answer.pointer(pointer).unwrap().as_object().unwrap().keys().cloned().collect();
        keys.sort();
        keys
    };
    let of_all = ["components", "critical", "cycles", "edges", "kind", "length"];
    assert_eq!(keys("compute - --full", "/view"), of_all);
    assert_eq!(keys("compute - --alpha 1", "/view"), [&["alpha"][..], &of_all].concat());
    assert_eq!(keys("compute - --simplify", "/simplified"), ["edges", "threshold", "vertices"]);
    assert_eq!(
        keys("compute - --simplify", ""),
        ["dots", "duplicates", "mst", "points", "rejected", "simplified", "vertices", "view"]
    );
}

#[test]
fn infinite_values_are_null() {
    let two = answer("", "0,0\n1,0\n").view;
    assert_eq!((two.ds, two.vs), (None, None));
    assert_eq!(two.margins, Some(Margins { diagonal: None, vertical: None }));
    let first = answer("--l 1", SQUARES).view.margins.unwrap();
    let second = answer("--l 2", SQUARES).view.margins.unwrap();
    assert!(
        first.vertical.is_none() && first.diagonal.is_some(),
        "the strip right of all births has no end: {first:?}"
    );
    assert!(second.vertical.is_some(), "{second:?}");
}

#[test]
fn every_case_is_answered_exactly_from_a_file_and_from_stdin() {
    for case in cases() {
        let file = case_file(&case.name);
        let from_file = hopes("compute").with(&file).runs().out();
        let from_stdin = hopes("compute -").reads(std::fs::read(&file).unwrap()).out();
        assert!(from_file == from_stdin, "{}: a file and stdin are answered alike", case.name);
        assert_exact(&case, &Reply::of(from_file));
    }
}

fn assert_exact(case: &Case, reply: &Reply) {
    let (name, want) = (&case.name, &case.answer);
    assert_eq!(reply.points, want.n_distinct, "{name}");
    assert_eq!(reply.vertices.len(), want.n_distinct, "{name}");
    assert_eq!((reply.duplicates, reply.rejected), ((case.points.len() - want.n_distinct) as u64, 0), "{name}");
    assert_eq!(reply.mst.edges.len(), want.n_distinct.saturating_sub(1), "{name}");
    assert!((reply.mst.length - want.mst_length).abs() <= CLOSE * want.mst_length, "{name}: length of the tree");
    let ours: Vec<[f64; 2]> = reply.dots.iter().map(|dot| [dot.birth, dot.death]).collect();
    let mut theirs = [&want.dots[..], &want.near_dots].concat();
    theirs.retain(|dot| dot[1] - dot[0] > 1e-12 * dot[1]);
    assert_eq!(ours.len(), theirs.len(), "{name}: number of dots");
    let largest = theirs.iter().map(|dot| dot[1]).fold(0.0, f64::max);
    let sorted = |dots: &[[f64; 2]], [birth, death]: [f64; 2]| {
        let mut values: Vec<f64> = dots.iter().map(|dot| birth * dot[0] + death * dot[1]).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    // Dots are compared by births, deaths, persistences and a mixture, each sorted. So ties need no pairing.
    for share in [[1.0, 0.0], [0.0, 1.0], [-1.0, 1.0], [1.0, 3.0]] {
        for (our, their) in sorted(&ours, share).into_iter().zip(sorted(&theirs, share)) {
            assert!((our - their).abs() <= 4.0 * CLOSE * largest, "{name}: {our} should be {their}");
        }
    }
    let persistences = reply.dots.iter().map(|dot| dot.death - dot.birth);
    assert!(persistences.is_sorted_by(|a, b| a >= b), "{name}: the most persistent dot is first");
    for dot in &reply.dots {
        assert!((reply.half_length(dot.edge) - dot.birth).abs() <= CLOSE * largest, "{name}: {dot:?}");
        assert_eq!(dot.hole.radius, dot.death, "{name}");
    }
}

#[test]
fn every_derived_view_is_exact() {
    for case in cases().filter(|case| !ROUNDED_TIES.contains(&case.name.as_str())) {
        for (ranks, want) in &case.answer.skeletons {
            let (k, l) = ranks.split_once(',').unwrap();
            let program = hopes(&format!("compute -k{k} --l {l}")).with(case_file(&case.name));
            assert_view(&format!("{} at {ranks}", case.name), &Reply::of(program.runs().out()), want);
        }
    }
}

fn assert_view(what: &str, reply: &Reply, want: &DerivedAnswer) {
    let view = &reply.view;
    let largest = reply.dots.iter().map(|dot| dot.death).fold(0.0, f64::max);
    let same = |ours: Option<f64>, theirs: Option<f64>| match (ours, theirs) {
        (Some(ours), Some(theirs)) => (ours - theirs).abs() <= CLOSE * largest,
        (ours, theirs) => ours == theirs,
    };
    assert!(same(view.ds, want.ds), "{what}: ds {:?} {:?}", view.ds, want.ds);
    assert!(same(view.vs, want.vs.as_f64()), "{what}: vs {:?} {:?}", view.vs, want.vs);
    assert_eq!((view.edges.len(), view.critical.len()), (want.mst_kept, want.critical), "{what}: tree, critical");
    assert_eq!((view.cycles, view.components), (want.h1, want.components), "{what}: cycles, components");
    assert!((view.length - want.length).abs() <= CLOSE * want.length, "{what}: length");
}

#[test]
fn a_reduced_view_has_the_cycles_alive_at_its_scale() {
    for name in ["fig1", "eight_n300_e0.05", "lattice_20x20", "n1"] {
        let whole = reply(&hopes("compute --full").with(case_file(name)), "");
        let lives = whole.dots.iter().step_by(7).map(|dot| f64::midpoint(dot.birth, dot.death));
        for alpha in lives.chain([0.0, 1e9]) {
            let program = hopes(&format!("compute --alpha {alpha:?}")).with(case_file(name));
            let view = reply(&program, "").view;
            let short = |edge: &&[usize; 2]| whole.half_length(**edge) <= alpha;
            let edges: Vec<_> = whole.mst.edges.iter().filter(short).copied().collect();
            let alive = whole.dots.iter().filter(|dot| dot.birth <= alpha && alpha < dot.death);
            assert_eq!((view.kind.as_str(), view.alpha), ("reduced", Some(alpha)), "{name}");
            assert_eq!(view.components, whole.points - edges.len(), "{name} at {alpha}");
            assert_eq!(view.edges, edges, "{name} at {alpha}");
            assert_eq!(view.critical, alive.map(|dot| dot.edge).collect::<Vec<_>>(), "{name} at {alpha}");
        }
    }
}

#[test]
fn the_full_view_has_all_edges() {
    for name in ["fig1", "eight_n300_e0.05", "empty0"] {
        let whole = reply(&hopes("compute --full").with(case_file(name)), "");
        let length: f64 = whole.dots.iter().map(|dot| 2.0 * dot.birth).sum::<f64>() + whole.mst.length;
        assert_eq!(whole.view.kind, "full");
        assert_eq!(whole.view.edges, whole.mst.edges);
        assert_eq!(whole.view.critical, whole.dots.iter().map(|dot| dot.edge).collect::<Vec<_>>());
        assert_eq!((whole.view.cycles, whole.view.components), (whole.dots.len(), whole.points.min(1)));
        assert!((whole.view.length - length).abs() <= CLOSE * length);
    }
}

#[test]
fn a_simplified_view_keeps_components_and_cycles() {
    let file = case_file("B_n400_e0.08");
    for view in ["", "--alpha 0.1", "--full --simplify=0.07", "--k 3 --l 2"] {
        let simplify = if view.contains("simplify") { "" } else { "--simplify" };
        let reply = reply(&hopes("compute").with(&file).and(view).and(simplify), "");
        let simplified = reply.simplified.as_ref().unwrap();
        let threshold = reply.view.alpha.or(reply.view.vs).unwrap_or(0.07);
        assert_eq!(simplified.threshold, Some(threshold), "{view}");
        let components = components(simplified.vertices.len(), &simplified.edges);
        assert_eq!(components, reply.view.components, "{view}");
        let cycles = simplified.edges.len() + components - simplified.vertices.len();
        assert_eq!(cycles, reply.view.cycles, "{view}");
        assert!(simplified.vertices.len() < reply.points, "{view}: some of the noise is gone");
        for &[a, b] in &simplified.edges {
            let ends = [a, b].map(|end| simplified.vertices[end]);
            let share = neighbours(simplified, a).any(|other| neighbours(simplified, b).any(|third| third == other));
            assert!(half_length(ends) >= threshold || share, "{view}: {ends:?} is short and could go");
        }
    }
}

fn neighbours(graph: &Simplified, vertex: usize) -> impl Iterator<Item = usize> + '_ {
    graph.edges.iter().filter_map(move |&[a, b]| match vertex {
        v if v == a => Some(b),
        v if v == b => Some(a),
        _ => None,
    })
}

fn components(vertices: usize, edges: &[[usize; 2]]) -> usize {
    let mut parents: Vec<usize> = (0..vertices).collect();
    let root = |parents: &mut [usize], mut at: usize| {
        while parents[at] != at {
            parents[at] = parents[parents[at]];
            at = parents[at];
        }
        at
    };
    let mut joins = |&&[a, b]: &&[usize; 2]| {
        let [a, b] = [a, b].map(|end| root(&mut parents, end));
        parents[a] = b;
        a != b
    };
    vertices - edges.iter().filter(&mut joins).count()
}

#[test]
fn simplifying_below_0_changes_nothing() {
    let simplified = answer("--simplify=0", SQUARES).simplified.unwrap();
    assert_eq!((simplified.threshold, simplified.vertices.len()), (Some(0.0), 7));
    let without_dots = answer("--simplify", "0,0\n3,4\n").simplified.unwrap();
    assert_eq!((without_dots.threshold, without_dots.vertices), (None, vec![[1.5, 2.0]]));
}

#[test]
fn a_resolution_snaps_points_to_a_grid() {
    let snapped = answer("--resolution 0.5", "0.1,0.2\n-0.2,0\n0.26,0.74\n7,-0.24\n");
    assert_eq!(snapped.vertices, [[0.0, 0.0], [0.5, 0.5], [7.0, 0.0]]);
    assert_eq!((snapped.points, snapped.duplicates), (3, 1));
}

#[test]
fn the_order_of_points_changes_only_indices() {
    let case = cases().find(|case| case.name == "lattice_rect3x7").unwrap();
    let mut points = case.points;
    let forward = answer("", csv(&points)).picture();
    points.reverse();
    assert_eq!(answer("", csv(&points)).picture(), forward);
}

// ---- every form of input

#[test]
fn all_input_formats_give_the_same_answer() {
    let expected = hopes("compute -").reads("0,0\n2,0\n2,2.5\n-1e-1,2\n5,.25\n").out();
    let same = |arguments: &str, input: &str| {
        let got = hopes(&format!("compute - {arguments}")).reads(input).out();
        assert!(got == expected, "{arguments} {input:?} gives {}", String::from_utf8_lossy(&got));
    };
    for separator in [",", ";", "\t", " ", "   ", " , ", ";\t"] {
        let rows = [["0", "0"], ["2", "0"], ["2", "2.5"], ["-0.1", "2"], ["5", "0.25"]];
        same("", &rows.map(|row| row.join(separator)).join("\n"));
    }
    same("", "x,y\n0,0\n2,0\n2,2.5\n-0.1,2\n5,0.25\n");
    same("", "\"east of it\" \"north of it\"\n0 0\n2 0\n2 2.5\n-0.1 2\n5 0.25\n");
    same("", "# a comment\n\n0,0 # the origin\n2,0\n  # more\n2,2.5\n\n\n-0.1,2\n#\n5,0.25 #");
    same("", "\u{feff}x,y\r\n0,0\r\n2,0\r\n2,2.5\r\n-0.1,2\r\n5,0.25");
    same("", "\u{feff}0,0\n2,0\n2,2.5\n-0.1,2\n5,0.25");
    same("--input text", "0,0\n2,0\n2,2.5\n-0.1,2\n5,0.25");

    let table = "id,lat,name,lon\n1,0,a,0\n2,0,b,2\n3,2.5,\"c, d\",2\n4,2,,-0.1\n5,0.25,e,5\n";
    same("--columns 4,2", table);
    same("--columns lon,lat", table);
    same("--columns lon,2", table);
    same("--columns 2,1", "0;0\n0;2\n2.5;2\n2;-0.1\n0.25;5\n");

    let objects = r#"{"x":0,"y":0}
        {"y":0,"x":2,"t":7}
        {"x":2,"y":2.5,"name":"c"}
        {"x":-0.1,"y":2,"t":null}
        {"x":5,"y":25e-2}"#;
    same("", objects);
    same("--input jsonl", objects);
    same("", "[0,0]\n[2,0,1.5]\n[2,2.5,null]\n\n# a comment\n[-0.1,2]\n[5,0.25]");
    same("", "\u{feff}\r\n[0,0]\r\n[2,0]\r\n[2,2.5]\r\n[-0.1,2]\r\n[5,0.25]\r\n");
    same("", "{\"points\":[[0,0],[2,0],[2,2.5]],\"t\":1}\n{\"points\":[]}\n{\"points\":[[-0.1,2],[5,0.25]]}");
}

#[test]
fn the_format_may_follow_from_the_file_name() {
    let folder = tempfile::tempdir().unwrap();
    let written = |name: &str, text: &str| {
        let file = folder.path().join(name);
        std::fs::write(&file, text).unwrap();
        hopes("compute").with(file)
    };
    for name in ["points.jsonl", "points.NDJSON", "points.json", "points", "points.csv"] {
        assert_eq!(reply(&written(name, "[1,2]\n"), "").vertices, [[1.0, 2.0]], "{name}");
    }
    // A first line without either form is a bad line of the form that the name suggests.
    assert_eq!(reply(&written("points.jsonl", "1,2\n[3,4]\n"), "").vertices, [[3.0, 4.0]]);
    assert_eq!(reply(&written("points with blanks.txt", "1,2\n"), "").vertices, [[1.0, 2.0]]);
}

#[test]
fn points_can_be_retracted_and_commits_are_ignored() {
    let input = "{\"points\":[[0,0],[9,9],[1,0]]}\n{\"commit\":true}\n{\"retract\":[[9,9]]}\n[1,1]\n[0,1]\n";
    let expected = answer("", SQUARE);
    assert_eq!(answer("", input), expected);
}

#[cfg(target_os = "linux")]
#[test]
fn the_first_bytes_of_a_pipe_may_come_one_by_one() {
    let mut running = hopes("compute -").start();
    for piece in ["# a comm", "ent\n", "\n", "[1", ",2]\n"] {
        running.say(piece);
        running.until_read();
    }
    assert_eq!(Reply::of(running.finish().out()).vertices, [[1.0, 2.0]]);
}

// ---- small clouds

#[test]
fn small_clouds_have_the_same_format() {
    for nothing in ["", "\n\n", "# nothing\n", "\u{feff}"] {
        let empty = answer("", nothing);
        assert_eq!((empty.points, empty.rejected, empty.view.components), (0, 0, 0), "{nothing:?}");
    }
    let one = answer("", "3,4\n");
    assert_eq!((one.vertices, one.view.components, one.view.cycles), (vec![[3.0, 4.0]], 1, 0));
    let two = answer("", "0,0\n3,4\n");
    assert_eq!((two.mst.edges, two.mst.length, two.view.length), (vec![[0, 1]], 5.0, 5.0));
    let same = answer("", "1,1\n1,1\n1,1\n");
    assert_eq!((same.points, same.duplicates, same.vertices), (1, 2, vec![[1.0, 1.0]]));
}

#[test]
fn a_negative_zero_is_a_zero() {
    let text = hopes("compute -").reads("-0,0\n0,-0.0\n0,0\n-0e7,-0\n1,-0\n").text();
    let reply = Reply::of(&text);
    assert_eq!((reply.points, reply.duplicates), (2, 3));
    assert!(!text.contains("-0"), "{text}");
}

// ---- invalid input

#[test]
fn conflicting_arguments_give_an_error_with_a_remedy() {
    for (arguments, words) in [
        ("compute", &["<FILE>", "Usage: hopes compute"][..]),
        ("compute a b", &["'b'"]),
        ("compute - --k 0", &["'0'", "--k"]),
        ("compute - --l -1", &["-1"]),
        ("compute - --k 2 --alpha 1", &["--alpha", "cannot be used with", "--k"]),
        ("compute - --full --l 2", &["--full", "cannot be used with", "--l"]),
        ("compute - --alpha 1 --full", &["--alpha", "cannot be used with", "--full"]),
        ("compute - --alpha=-1", &["--alpha", "negative: a scale is a radius"]),
        ("compute - --alpha nan", &["--alpha", "not a finite number"]),
        ("compute - --resolution 0", &["--resolution", "must be above 0"]),
        ("compute - --resolution inf", &["--resolution", "not a finite number"]),
        ("compute - --simplify=-1", &["--simplify", "negative"]),
        ("compute - --full --simplify", &["--simplify=RADIUS"]),
        ("compute - --columns 1", &["--columns", "choose two"]),
        ("compute - --columns 2,2", &["--columns", "choose two different ones"]),
        ("compute - --columns 0,1", &["--columns", "count columns from 1"]),
        ("compute - --format pdf", &["pdf", "svg"]),
        ("compute - --input xml", &["xml", "jsonl"]),
        ("paint", &["paint"]),
        ("", &["compute", "serve"]),
    ] {
        hopes(arguments).reads(SQUARE).fails(2, words);
    }
}

#[test]
fn a_missing_column_is_named() {
    let program = hopes("compute - --columns lon,alt");
    program.reads("# c\nlon,lat\n1,2\n").fails(1, &["line 2", "\"alt\"", "lon,lat", "number the columns from 1"]);
}

#[test]
fn strict_stops_at_the_first_bad_line() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("answer.json");
    for (arguments, input, words) in [
        ("", "1,2\nx,3\n", ["line 2,", "column 1", "\"x\" is not a number"]),
        ("", "1,2\n3\n4,5\n", ["line 2,", "column 2", "missing"]),
        ("", "1,2\n\"1,5\",2\n", ["line 2,", "\"1,5\"", "write \"1.5\" if it is decimal"]),
        ("", "# c\nx,y\n\n1,2\n# c\nnan,3\n", ["line 6,", "x = NaN", "not a finite number"]),
        ("", "1,2\n3,-inf\n", ["line 2,", "y = -inf", "not a finite number"]),
        ("", "1e61,0\n", ["line 1,", "x = 1e61", "2^201"]),
        ("", "0,1e-60\n", ["line 1,", "y = 1e-60", "2^-142"]),
        ("--resolution 1e-300", "1,2\n1e50,0\n", ["line 2,", "x = inf", "(1"]),
        ("", "[1,2]\n[1]\n", ["line 2", "1 element(s)", "write [x,y]"]),
        ("", "[1,2]\n[3,4]]\n", ["line 2,", "byte 6", "correct the JSON"]),
        ("", "[1,2]\n{\"points\":[[1,2],[3,null]]}\n", ["line 2,", "point (3, NaN)", "y = NaN is not a finite number"]),
        ("", "# c\n[1,2]\n\n{\"retract\":[[1,2],[3,4]]}\n", ["line 4,", "(3, 4)", "to retract"]),
    ] {
        let program = hopes(&format!("compute - --strict {arguments}"));
        program.reads(input).fails(3, &[&words[..], &["--strict stops here"]].concat());
        program.with("-o").with(&output).reads(input).fails(3, &words);
        assert!(!output.exists(), "nothing is written");
    }
    hopes("compute - --strict").reads(b"1,2\n3,\xff\n").fails(3, &["line 2,", "byte 3", "UTF-8"]);
    assert_eq!(hopes("compute - --strict").reads(SQUARE), hopes("compute -").reads(SQUARE));
}

/// Not for a bad line, which the reading thread finds, and not for a refusal by the thread that inserts.
#[test]
fn strict_does_not_wait_for_more_input() {
    let mut running = hopes("compute - --strict --input text").start();
    running.say("1,2\nx,3\n");
    running.ends().fails(3, &["line 2,", "--strict stops here"]);
    let mut running = hopes("compute - --strict --input jsonl").start();
    running.say("[1,2]\n{\"retract\":[[3,4]]}\n");
    running.ends().fails(3, &["line 2,", "to retract", "--strict stops here"]);
}

#[test]
fn bad_lines_are_named_counted_and_skipped() {
    let input = "# made by hand\nx,y\n0,0\nnan,1\n1,0\n# more\nzwei,3\n1,1\n1e300,0\n4\n0,-inf\n0,1e-50\n0,1\n,\n";
    let finished = hopes("compute -").reads(input);
    for reason in [
        "line 4, point (NaN, 1): x = NaN is not a finite number",
        "line 7, column 1: \"zwei\" is not a number",
        "line 9, point (1",
        "x = 1e300 is beyond 2^201",
        "line 10, column 2: missing",
        "line 11, point (0, -inf): y = -inf is not a finite number",
        "line 12, point (0, 1e-50): y = 1e-50 is nearer to 0",
        "line 14, column 1: empty",
    ] {
        assert!(finished.err.contains(reason), "{reason:?} is missing in {}", finished.err);
    }
    // One line says what the header has chosen.
    assert_eq!(finished.err.lines().count(), 8, "{}", finished.err);
    assert_eq!(Reply::of(finished.out()), Reply { rejected: 7, ..answer("", SQUARE) });
}

#[test]
fn a_flood_of_bad_lines_is_counted_but_not_logged() {
    let input = SQUARE.to_owned() + &"none,0\n".repeat(1000);
    let finished = hopes("compute -").reads(&input);
    assert!(finished.err.lines().count() <= 103, "{}", finished.err);
    assert!(finished.err.contains("line 104,") && !finished.err.contains("line 105,"), "{}", finished.err);
    assert!(finished.err.contains("1000 lines or points in all"), "{}", finished.err);
    assert_eq!(Reply::of(finished.out()).rejected, 1000);
    let quiet = hopes("compute - --quiet").reads(&input);
    assert_eq!(quiet.err, "");
    assert_eq!(Reply::of(quiet.out()).rejected, 1000);
}

// ---- other formats

/// Everything that is drawn or listed: with and without dots, of a simplified view, of a cloud and of an empty cloud.
fn shown() -> impl Iterator<Item = Hopes> {
    let views = ["", "--full --simplify=0.5", "--alpha 2.2", "--k 2 --l 2 --simplify"];
    let names = ["fig1", "eight_n300_e0.05", "collinear_horizontal50", "theta_scale1e-9", "dup_all_same", "empty0"];
    let programs = move |name| views.map(|view| hopes("compute").with(case_file(name)).and(view));
    names.into_iter().flat_map(programs)
}

#[test]
fn csv_is_a_table_of_the_views_edges() {
    for program in shown() {
        let reply = reply(&program, "");
        let table = program.and("--format csv").runs().text();
        let mut rows = table.lines();
        assert_eq!(rows.next(), Some("kind,i,j,x1,y1,x2,y2,length,birth,death,persistence"));
        let mut read = (Vec::new(), Vec::new());
        for row in rows {
            let fields: Vec<&str> = row.split(',').collect();
            let &[kind, i, j, x1, y1, x2, y2, length, birth, death, persistence] = &fields[..] else { panic!("{row}") };
            let number = |field: &str| field.parse::<f64>().unwrap();
            let edge = [i, j].map(|end| end.parse::<usize>().unwrap());
            assert_eq!([x1, y1].map(number), reply.position(edge[0]), "{row}");
            assert_eq!([x2, y2].map(number), reply.position(edge[1]), "{row}");
            let exact = 2.0 * reply.half_length(edge);
            assert!((number(length) - exact).abs() <= 1e-15 * exact, "{row}");
            match kind {
                "tree" => {
                    assert_eq!([birth, death, persistence], ["", "", ""]);
                    assert!(read.1.is_empty(), "the tree is first");
                    read.0.push(edge);
                }
                "critical" => {
                    let dot = reply.dot(edge);
                    let label = [dot.birth, dot.death, dot.death - dot.birth];
                    assert_eq!([birth, death, persistence].map(number), label, "{row}");
                    read.1.push(edge);
                }
                _ => panic!("{row}"),
            }
        }
        assert_eq!(read, (reply.view.edges, reply.view.critical));
    }
}

#[test]
fn geojson_has_the_view_as_features() {
    for program in shown() {
        let reply = reply(&program, "");
        let collection: Value = serde_json::from_slice(&program.and("--format geojson").runs().out()).unwrap();
        assert_eq!(collection["type"], "FeatureCollection");
        let feature = |geometry: &str, coordinates: Value, properties: Value| {
            json!({
                "type": "Feature",
                "geometry": {"type": geometry, "coordinates": coordinates},
                "properties": properties,
            })
        };
        let lines = |edges: &[[usize; 2]], places: &[[f64; 2]]| -> Value {
            edges.iter().map(|edge| json!(edge.map(|end| places[end]))).collect()
        };
        let tree = lines(&reply.view.edges, &reply.vertices);
        let mut expected = vec![
            feature("MultiPoint", json!(reply.vertices), json!({"role": "vertices"})),
            feature("MultiLineString", tree, json!({"role": "tree", "components": reply.view.components})),
        ];
        for &edge in &reply.view.critical {
            let dot = reply.dot(edge);
            let label = |role: &str| json!({"role": role, "birth": dot.birth, "death": dot.death, "persistence": dot.death - dot.birth});
            let ends = edge.map(|end| reply.position(end));
            expected.push(feature("LineString", json!(ends), label("critical")));
            expected.push(feature("Point", json!(dot.hole.center), label("hole")));
        }
        if let Some(simplified) = &reply.simplified {
            let lines = lines(&simplified.edges, &simplified.vertices);
            let label = json!({"role": "simplified", "threshold": simplified.threshold});
            expected.push(feature("MultiLineString", lines, label));
        }
        assert_eq!(collection["features"], Value::Array(expected));
    }
}

#[test]
fn pictures_are_well_formed_and_of_one_size() {
    for program in shown() {
        let svg = program.and("--format svg").runs().text();
        let document = roxmltree::Document::parse(&svg).unwrap();
        let root = document.root_element();
        assert_eq!(
            (root.tag_name().name(), root.attribute("width"), root.attribute("height")),
            ("svg", Some("1200"), Some("560"))
        );
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}

#[cfg(feature = "png")]
#[test]
fn pixels_have_the_size_of_the_picture() {
    for program in shown() {
        let png = program.and("--format png").runs().out();
        assert_eq!(png[..8], *b"\x89PNG\r\n\x1a\n");
        assert_eq!(&png[12..16], b"IHDR");
        let side = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
        assert_eq!((side(16), side(20)), (2400, 1120), "two pixels for each of the SVG's");
        assert_eq!(&png[png.len() - 8..png.len() - 4], b"IEND");
    }
}

#[test]
fn a_picture_shows_every_dot_and_every_edge_of_a_small_cloud() {
    let svg = hopes("compute - --format svg").reads(SQUARES).text();
    let document = roxmltree::Document::parse(&svg).unwrap();
    let texts: String = document.descendants().filter_map(|node| node.text()).collect();
    let reply = answer("", SQUARES);
    for number in [reply.points, reply.view.cycles] {
        assert!(texts.contains(&number.to_string()), "{number} is missing in {texts}");
    }
    assert_ne!(svg, hopes("compute - --format svg").reads(SQUARE).text());
}

#[cfg(not(feature = "png"))]
#[test]
fn a_build_without_png_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.png");
    let program = hopes("compute - --format png -o").with(&file);
    program.reads(SQUARES).fails(2, &["built without PNG output", "--format svg", "feature png"]);
    assert!(!file.exists());
}

/// The values of `--format` that this build can write.
fn formats() -> impl Iterator<Item = &'static str> {
    ["json", "csv", "geojson", "svg"].into_iter().chain(cfg!(feature = "png").then_some("png"))
}

#[test]
fn an_answer_may_go_to_a_file() {
    let folder = tempfile::tempdir().unwrap();
    for format in formats() {
        let file = folder.path().join(format!("an answer.{format}"));
        std::fs::write(&file, "what was there before, and is longer than nothing").unwrap();
        let program = hopes(&format!("compute - --format {format}"));
        let silent = program.with("--output").with(&file).reads(SQUARES).out();
        assert_eq!(silent, b"", "{format}");
        assert!(std::fs::read(&file).unwrap() == program.reads(SQUARES).out(), "{format}");
    }
}

#[test]
fn the_same_input_gives_the_same_output_byte_for_byte() {
    let input = csv(&random_points(1, 3000)) + "bad\n1,1\n1,1\n";
    for format in formats() {
        let program = hopes(&format!("compute - --simplify --format {format}"));
        assert!(program.reads(&input) == program.reads(&input), "{format}");
    }
}

// ---- failures

#[test]
fn a_file_that_cannot_be_opened_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let (missing, inside) = (folder.path().join("no such.csv"), folder.path().join("no such/answer.json"));
    hopes("compute").with(&missing).runs().fails(1, &["cannot open", &missing.to_string_lossy()]);
    let program = hopes("compute - -o").with(&inside);
    program.reads(SQUARE).fails(1, &["cannot write", &inside.to_string_lossy()]);
    hopes("compute - -o")
        .with(folder.path())
        .reads(SQUARE)
        .fails(1, &["cannot write", &folder.path().to_string_lossy()]);
    for input in ["auto", "text"] {
        let folder = folder.path();
        let finished = hopes(&format!("compute --input {input}")).with(folder).runs();
        assert_eq!(finished.err.matches("directory").count(), 1, "the cause is said once: {}", finished.err);
        finished.fails(1, &[&folder.to_string_lossy()]);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_a_failure() {
    for format in formats() {
        let program = hopes(&format!("compute --format {format}")).with(case_file("fig1"));
        program.with("-o").with("/dev/full").runs().fails(1, &["cannot write /dev/full", "No space left"]);
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let output = program.command().stdout(full).output().unwrap();
        let log = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{log}");
        assert!(log.contains("cannot write to stdout") && log.contains("No space left"), "{log}");
    }
}

#[test]
fn a_closed_output_pipe_is_no_error() {
    let input = csv(&random_points(2, 20_000));
    for format in formats() {
        let mut running = hopes(&format!("compute - --format {format}")).start();
        let mut stdout = running.take_stdout();
        running.say(&input);
        drop(running.take_stdin());
        stdout.read_exact(&mut [0; 4]).unwrap();
        drop(stdout);
        let finished = running.ends();
        assert_eq!((finished.code, finished.err.as_str()), (Some(0), ""), "{format}");
    }
}

#[test]
fn a_closed_stderr_does_not_stop_the_program() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("points.csv");
    std::fs::write(&file, SQUARE.to_owned() + &"bad,0\n".repeat(200)).unwrap();
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let output = hopes("compute").with(&file).command().stderr(writer).output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(Reply::of(&output.stdout), Reply { rejected: 200, ..answer("", SQUARE) });
}

// ---- large clouds

#[test]
fn two_hundred_thousand_points_come_out_in_order_of_first_appearance() {
    let mut points = random_points(3, 200_000);
    for again in (10..points.len()).step_by(10) {
        points[again] = points[again / 2];
    }
    let mut seen = BTreeSet::new();
    let firsts: Vec<[f64; 2]> = points.iter().copied().filter(|point| seen.insert(point.map(f64::to_bits))).collect();
    let reply = answer("", csv(&points));
    assert!(reply.vertices == firsts, "vertices are in order of first appearance");
    assert_eq!((reply.points, reply.duplicates), (firsts.len(), (points.len() - firsts.len()) as u64));
    assert_eq!(reply.mst.edges.len(), firsts.len() - 1);
    assert_eq!(components(firsts.len(), &reply.mst.edges), 1, "the tree joins everything");
    assert!(reply.dots.len() > firsts.len() / 5, "noise has many holes: {}", reply.dots.len());
    assert_eq!(reply.view.edges.len() + reply.view.components, firsts.len());
    assert_eq!(reply.view.critical.len(), reply.view.cycles);
}
