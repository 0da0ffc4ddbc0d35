//! What is said of values that make no sense: the value, and what it may be, never the words of a library.

use std::fs::File;
use std::io::Read;
use std::process::Stdio;

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

use crate::common::process::{eventually, hopes};

/// Words that are for programmers.
const FOREIGN: [&str; 8] = [
    "invalid digit",
    "non-zero type",
    "Os {",
    "Some(",
    "None",
    "ParseIntError",
    "invalid float",
    "not in 0..18446744073709551615",
];

#[test]
fn values_that_make_no_sense_are_named_with_what_may_be() {
    for (arguments, words) in [
        ("compute x -k 0", "\"0\" is no rank: gaps are counted from 1"),
        ("compute x -k 1.5", "\"1.5\" is no rank"),
        ("compute x -l -1", "\"-1\" is no rank"),
        ("compute x --alpha -1", "-1 is negative: a scale is a radius"),
        ("compute x --alpha nan", "\"nan\" is not a finite number"),
        ("compute x --alpha -1e-320", "-1e-320 is negative"),
        ("compute x --simplify=-1", "-1 is negative"),
        ("compute x --resolution 0", "0 is not a step of a grid"),
        ("compute x -o y.pdf", "y.pdf: .pdf is the suffix of no format: use .json, .svg, .png, .csv, .geojson"),
        ("compute x --panels cloud,stars", "\"stars\" is no panel: there are image, cloud"),
        ("compute x --panels skeleton:0:1", "\"0\" is no rank"),
        ("compute x --panels cloud -o y.json", "--panels draws a picture"),
        ("compute x --project=60", "\"60\" is no LON,LAT"),
        ("compute x --project=60,95", "latitude 95 is no place on Earth"),
        ("serve --window frames:-1", "\"-1\" is not a number of frames"),
        ("serve --threads 0", "\"0\" is not a whole number from 1"),
        ("serve --frame-points 0", "\"0\" is not a whole number from 1"),
        ("serve --frame-points x", "\"x\" is not a whole number"),
        ("serve --frame-every -1s", "write it as 100ms or 2s"),
        ("serve --timeout 0s --listen unix:x", "0s is no time at all"),
        ("serve --track view --track-confirm 0", "\"0\" is not a whole number from 1"),
        ("serve --max-views 0", "\"0\" is not a whole number from 1"),
        ("serve --max-streams x", "\"x\" is not a whole number"),
        ("serve --max-points -5", "\"-5\" is not a whole number"),
        ("serve --max-batch 0", "\"0\" is not a whole number from 1 to 100000"),
        ("feed - --rate -5", "-5 is not a rate"),
        ("feed - --frame-points 0", "from 1"),
        ("watch --frames -1", "\"-1\" is not a whole number from 1"),
        ("watch --stream=", "1 to 200 bytes"),
        ("scene pinch --frames 0", "\"0\" is not a whole number from 1"),
        ("scene pinch --seed x", "\"x\" is not a whole number"),
        ("scene pinch --noise -1", "must be 0 to 0.3"),
        ("disconnect x", "\"x\" is not a whole number"),
        ("demo --frames 0", "from 1"),
        ("tracks x --svg y --most 0", "\"0\" is not a whole number from 1 to 10000"),
        ("edges - --blur -1", "-1 is not a standard deviation"),
        ("replay x --speed -1", "-1 is not a rate"),
    ] {
        let finished = hopes(arguments).runs();
        for foreign in FOREIGN {
            assert!(!finished.err.contains(foreign), "{arguments}: {foreign:?} in {}", finished.err);
        }
        finished.fails(2, &[words]);
    }
}

#[test]
fn tiny_numbers_are_short() {
    let refused = hopes("compute - --strict").reads("1e-320,5\n");
    assert!(refused.err.contains("point (1e-320, 5)") && refused.err.len() < 400, "{}", refused.err);
    refused.fails(3, &["nearer to 0"]);
    let served = hopes("serve --strict").reads("5,1e-320\n");
    assert!(served.err.contains("(5, 1e-320)"), "{}", served.err);
    let table = hopes("compute - --format csv").reads("0,0\n1e-40,1e60\n").text();
    assert!(table.contains(",1e-40,1e60,") && table.lines().all(|line| line.len() < 120), "{table}");
}

#[test]
fn one_picture_without_a_track_is_explained() {
    let served = hopes("serve --track view").reads("0,0\n2,0\n2,2\n0,2\n").out();
    let table = hopes("tracks -").reads(&served);
    for words in ["has no track in 1 frame", "--track-confirm", "hopes serve --track-confirm 1"] {
        assert!(table.err.contains(words), "{words}: {}", table.err);
    }
    assert_eq!(table.code, Some(0));
    let confirmed = hopes("serve --track view --track-confirm 1").reads("0,0\n2,0\n2,2\n0,2\n").out();
    let table = hopes("tracks -").reads(confirmed);
    assert!(!table.err.contains("--track-confirm") && table.text().contains("born"));
}

/// Runs the program with a terminal as stdout. Its exit code, and its log.
fn on_a_terminal(arguments: &str) -> (Option<i32>, String) {
    let terminal = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&terminal).unwrap();
    unlockpt(&terminal).unwrap();
    let name = ptsname(&terminal, Vec::new()).unwrap();
    let other_end = File::options().read(true).write(true).open(name.to_str().unwrap()).unwrap();
    let mut command = hopes(arguments).command();
    let mut child = command.stdout(Stdio::from(other_end)).stderr(Stdio::piped()).spawn().unwrap();
    let status = eventually("it ends", || child.try_wait().unwrap());
    let mut log = String::new();
    child.stderr.take().unwrap().read_to_string(&mut log).unwrap();
    (status.code(), log)
}

#[test]
fn bytes_are_not_written_to_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("a.hopes");
    std::fs::write(&recording, hopes("serve --output bin").reads("0,0\n1,0\n").out()).unwrap();
    let recording = recording.display();
    for arguments in [
        "compute tests/cases/fig1.csv --format png".to_owned(),
        "serve --output bin".to_owned(),
        "edges tests/data/edges/text.png --format bin".to_owned(),
        "scene pinch --frames 1 --format bin".to_owned(),
        format!("replay {recording} --fast --output bin"),
        "record --from unix:/none -o -".to_owned(),
        "watch --from unix:/none --output bin".to_owned(),
    ] {
        let (code, log) = on_a_terminal(&arguments);
        assert_eq!(code, Some(2), "{arguments}: {log}");
        assert!(log.contains("is not written to a terminal: use ") && log.contains("another program"), "{log}");
    }
    let (code, log) = on_a_terminal("compute tests/cases/fig1.csv --format csv");
    assert_eq!(code, Some(0), "{log}");
}
