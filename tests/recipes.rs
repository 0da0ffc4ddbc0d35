//! The README's commands as a reader runs them: first commands, recipes and Python, each run against the built program.
//!
//! In: README.md. Out: whether each command ends well and prints what is expected of it.
//! Invariants: a command of the README without an entry here fails the test; what the README shows as output is what
//! the program prints; the stand-ins of other programs (`ffmpeg`, `lidar`) refuse arguments that the real ones would
//! not take.
//! Must not know: how the program works.

mod common;
#[path = "recipes/documents.rs"]
mod documents;
#[path = "recipes/readme.rs"]
mod readme;
#[path = "recipes/stage.rs"]
mod stage;

use std::path::Path;

use stage::Stage;

// ---- three first commands

/// How a first command is run: what is replaced in it, and what then differs in its output.
struct First {
    begins: &'static str,
    command: (&'static str, &'static str),
    output: (&'static str, &'static str),
}

const FIRSTS: [First; 3] = [
    First {
        begins: "cargo run --release -- demo",
        command: ("cargo run --release -- demo", "hopes demo --view 127.0.0.1:0 --frames 262 --rate 2000"),
        output: ("at 2000 frames a second", "at 30 frames a second"),
    },
    First { begins: "hopes serve --input jsonl", command: ("", ""), output: ("", "") },
    First { begins: "hopes compute tests/cases/fig1.csv", command: ("", ""), output: ("", "") },
];

#[test]
fn the_first_commands_print_what_the_readme_shows() {
    let section = readme::section("Three first commands");
    let commands = readme::blocks(&section, "sh");
    let outputs = readme::blocks(&section, "text");
    assert_eq!((commands.len(), outputs.len()), (FIRSTS.len(), FIRSTS.len()), "each has its output");
    for ((command, shown), first) in commands.iter().zip(&outputs).zip(&FIRSTS) {
        let command = readme::without_comments(command);
        assert!(command.starts_with(first.begins), "{command:?} has no entry in this test");
        let stage = Stage::new();
        let printed = stage.start(&command.replace(first.command.0, first.command.1)).finish();
        let printed = on_the_usual_port(&printed).replace(first.output.0, first.output.1);
        shows(&printed, shown);
    }
}

/// With the address that the README shows, where the test took any port that was free.
fn on_the_usual_port(text: &str) -> String {
    let Some((before, after)) = text.split_once("http://127.0.0.1:") else { return text.to_owned() };
    format!("{before}http://127.0.0.1:8080{}", after.trim_start_matches(|mark: char| mark.is_ascii_digit()))
}

/// Whether all lines that are shown are printed, in that order. `...` stands for any lines; the demo's lines are a
/// choice.
fn shows(printed: &str, shown: &str) {
    let mut lines = printed.lines();
    for line in shown.lines().filter(|line| *line != "...") {
        assert!(lines.any(|printed| printed == line), "README shows {line:?}, which is not printed there:\n{printed}");
    }
}

// ---- recipes

/// How a recipe is tried.
struct Trial {
    /// The first words of its comment.
    title: &'static str,
    try_it: fn(&Stage, &str),
}

const TRIALS: [Trial; 8] = [
    Trial { title: "a picture as a figure", try_it: figure_of_a_picture },
    Trial { title: "a webcam", try_it: video_on_a_page },
    Trial { title: "a film, at its own pace", try_it: video_on_a_page },
    Trial { title: "LiDAR as CSV", try_it: lidar },
    Trial { title: "a log that grows", try_it: growing_log },
    Trial { title: "a folder of pictures", try_it: pictures },
    Trial { title: "the lives of holes in a film", try_it: lives },
    Trial { title: "a daemon for many", try_it: daemon },
];

#[test]
fn every_recipe_does_what_it_says() {
    let recipes = readme::recipes();
    let titles: Vec<&str> = recipes.iter().map(|recipe| recipe.title.as_str()).collect();
    assert_eq!(titles.len(), TRIALS.len(), "each recipe is tried here: {titles:?}");
    std::thread::scope(|scope| {
        for recipe in &recipes {
            let trial = TRIALS.iter().find(|trial| recipe.title.starts_with(trial.title));
            let trial = trial.unwrap_or_else(|| panic!("the recipe {:?} has no entry in this test", recipe.title));
            scope.spawn(|| (trial.try_it)(&Stage::new(), &recipe.commands));
        }
    });
}

/// The figure that the README shows; that it is this one is tested with the other pictures.
fn figure_of_a_picture(stage: &Stage, recipe: &str) {
    stage.start(recipe).finish();
    let drawn = std::fs::read_to_string(stage.path("coins.svg")).unwrap();
    assert!(drawn.contains("Simplified HoPeS(7, 4)"), "all five panels are there");
}

/// A page with tracks, fed by `ffmpeg` with three frames of a film.
fn video_on_a_page(stage: &Stage, recipe: &str) {
    let mut job = stage.start(recipe);
    let port = job.page_port();
    let stream = stage::stream_on_page(port, |stream| stream["info"]["frame"] == 3);
    assert!(stream["info"]["points"].as_u64() > Some(100), "edges of the film are points: {stream}");
    job.end_well("serve");
    job.finish();
}

/// A page with the last second of a scanner.
fn lidar(stage: &Stage, recipe: &str) {
    let mut job = stage.start(recipe);
    let port = job.page_port();
    // The scanner's clock goes from 0 to 2 s in steps of 1/100 s, and its places are 4 mm apart on a grid of 1 cm.
    let stream = stage::stream_on_page(port, |stream| stream["accepted"] == 201 && stream["waiting"] == 0);
    let (points, places) = (stream["info"]["points"].as_u64(), stream["info"]["vertices"].as_u64());
    assert_eq!(points, Some(101), "those of the last second stay: {stream}");
    assert!(places < Some(60), "neighbours share a place of the grid: {stream}");
    job.end_well("serve");
    job.finish();
}

/// A log whose last line comes while it is read; `tail` ends when its reader has ended.
fn growing_log(stage: &Stage, recipe: &str) {
    let log = stage.path("places.csv");
    let mut job = stage.start(recipe);
    // A square: time, points and cycles.
    job.lines_until(|line| numbers(line) == [Some(100.0), Some(4.0), Some(1.0)]);
    stage::append(&log, "9.0,47.5,3800\n");
    // The others are older than an hour.
    job.lines_until(|line| numbers(line) == [Some(3800.0), Some(1.0), Some(0.0)]);
    job.end_well("serve");
    // Where `tail` does not see that nobody reads, it finds out when it writes.
    stage::append(&log, "9.0,47.5,3801\n");
    job.finish();
}

/// Three numbers, or nulls, in a line of JSON.
fn numbers(line: &str) -> [Option<f64>; 3] {
    serde_json::from_str(line).unwrap_or_else(|error| panic!("{line:?} is not three numbers: {error}"))
}

fn pictures(stage: &Stage, recipe: &str) {
    let table = stage.start(recipe).finish();
    let mut lines = table.lines();
    assert!(lines.next().is_some_and(|header| header.starts_with("id  from  to")), "{table}");
    assert!(lines.any(|line| line.contains("born")), "a hole lasts in two pictures: {table}");
}

fn lives(stage: &Stage, recipe: &str) {
    let table = stage.start(recipe).finish();
    let formats = std::fs::read_to_string("src/formats/README.md").unwrap();
    assert!(formats.contains(table.trim_end()), "src/formats/README.md shows another table than\n{table}");
    let picture = std::fs::read_to_string(stage.path("lives.svg")).unwrap();
    assert!(picture.starts_with("<svg") && picture.contains("persistence"), "{picture}");
}

/// Three terminals: the daemon, a producer, a consumer.
fn daemon(stage: &Stage, recipe: &str) {
    let lines: Vec<&str> = recipe.lines().collect();
    let [serve, feed, watch] = lines[..] else { panic!("three commands, not {lines:?}") };
    let mut daemon = stage.start(serve);
    daemon.until_log("listening at unix:");
    let mut producer = stage.start(feed);
    let mut consumer = stage.start(watch);
    for _ in 0..2 {
        let line = consumer.lines_until(|line| line.contains("frame"));
        assert!(line.starts_with("cam  frame ") && line.contains("cycles"), "{line}");
    }
    for (job, command) in [(&mut consumer, "watch"), (&mut producer, "feed"), (&mut daemon, "serve")] {
        job.end_well(command);
    }
    for job in [consumer, producer, daemon] {
        job.finish();
    }
}

// ---- Python

#[test]
fn the_python_of_the_readme_runs() {
    if stage::find("python3").is_none() {
        assert!(std::env::var_os("CI").is_none(), "python3 is missing, and CI must not skip this");
        return;
    }
    let snippets = readme::blocks(&readme::section("Python"), "python");
    let [pipe, client] = &snippets[..] else { panic!("two snippets, not {}", snippets.len()) };
    // Two squares that share a side, and a line.
    let stage = Stage::new();
    let squares = "[(0, 0), (2, 0), (2, 2), (0, 2), (4.4, 0), (4.4, 2)]";
    let printed = stage.python(&format!("clouds = [{squares}, [(0, 0), (1, 0)]]"), pipe).finish();
    assert_eq!(printed, "2\n0\n");

    let stage = Stage::new();
    let mut daemon = stage.start("hopes serve --listen unix:/tmp/hopes.sock");
    daemon.until_log("listening at unix:");
    let mut script = stage.python(&format!("points = {squares}"), client);
    let line = script.line();
    assert!(line.starts_with("1 2 {(1, 2): (1.0, 1.414"), "{line}");
    // The stream ends with the daemon, and the loop with the stream.
    daemon.end_well("serve");
    assert_eq!(script.finish(), "");
    daemon.finish();
}

// ---- the table of commands

#[test]
fn the_table_of_commands_has_all_of_them_with_options_that_exist() {
    let help = |command: &str| common::process::hopes(command).and("--help").runs().text();
    let rows = readme::rows(&readme::section("Commands"));
    let named: Vec<&str> = rows.iter().map(|row| row[0].trim_matches('`')).collect();
    let commands = help("");
    let commands: Vec<&str> = commands
        .lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .take_while(|line| !line.is_empty())
        // A long description goes on further to the right.
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|command| *command != "help")
        .collect();
    let sorted =
        |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<std::collections::BTreeSet<_>>();
    assert_eq!(sorted(&named), sorted(&commands));
    for row in &rows {
        // Each part of a pipe is a command with options of its own.
        for part in row[2].trim_matches('`').split('|') {
            let Some(words) = part.trim().trim_end_matches('\\').strip_prefix("hopes ") else { continue };
            let text = help(words.split_whitespace().next().unwrap());
            for option in words.split_whitespace().filter(|word| word.starts_with("--")) {
                assert!(text.contains(option), "{option} of {words:?} is not in its --help");
            }
        }
    }
}

// ---- pictures

#[test]
fn pictures_of_the_documents_are_what_the_program_draws() {
    let stage = Stage::new();
    for (name, commands) in [
        (
            "coins.svg",
            "hopes compute tests/data/edges/coins.png -o coins.svg \
             --panels image,cloud,diagram,skeleton,simplified -k 7 -l 4",
        ),
        ("wheel.svg", "hopes compute tests/cases/wheel7_n400_e0.02.csv --format svg -o wheel.svg"),
        (
            "frame7.svg",
            "sed -n 13p tests/data/bunny.jsonl > frame7.jsonl && hopes compute frame7.jsonl --format svg -o frame7.svg",
        ),
        (
            "frame26.svg",
            "sed -n 51p tests/data/bunny.jsonl > frame26.jsonl && hopes compute frame26.jsonl --format svg -o frame26.svg",
        ),
    ] {
        let formats = std::fs::read_to_string("src/formats/README.md").unwrap();
        assert!(formats.contains(commands), "src/formats/README.md says how {name} is drawn");
        stage.start(commands).finish();
        let drawn = std::fs::read_to_string(stage.path(name)).unwrap();
        let shown = std::fs::read_to_string(Path::new("tests/data").join(name)).unwrap();
        assert!(drawn == shown, "tests/data/{name} is not what {commands:?} draws");
    }
}
