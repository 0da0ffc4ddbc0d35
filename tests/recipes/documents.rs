//! The documents: their links lead somewhere, and README keeps its measure.
//!
//! In: the project's Markdown. Out: whether each link to a file or a heading of the project leads to one.
//! Must not know: what the documents say.

use std::path::{Path, PathBuf};

use crate::readme::README;

const DOCUMENTS: [&str; 9] = [
    "README.md",
    "benches/README.md",
    "protocol/SPEC.md",
    "protocol/python/README.md",
    "protocol/vectors/README.md",
    "src/formats/README.md",
    "src/view/README.md",
    "tests/cases/README.md",
    "tests/data/README.md",
];

/// What a newcomer needs stands on one page, in lines that a terminal shows.
#[test]
fn the_readme_is_short_and_has_both_commands() {
    assert!(README.lines().count() <= 180, "{} lines", README.lines().count());
    for command in ["\ncargo run --release -- demo\n", "`./tests/run`"] {
        assert!(README.contains(command), "{command:?}");
    }
    let is_prose = |line: &&str| !line.starts_with(['|', '!']);
    for line in README.lines().filter(is_prose) {
        assert!(line.chars().count() <= 120, "too long: {line}");
    }
}

#[test]
fn links_lead_somewhere() {
    for document in DOCUMENTS {
        let text = std::fs::read_to_string(document).unwrap();
        for target in links(&text).filter(|target| !target.contains("://")) {
            let (file, heading) = target.split_once('#').unwrap_or((target, ""));
            let path = if file.is_empty() { PathBuf::from(document) } else { beside(document, file) };
            assert!(path.exists(), "{document} links to {target}, which is not there");
            let there = || std::fs::read_to_string(&path).unwrap();
            assert!(heading.is_empty() || anchors(&there()).any(|anchor| anchor == heading), "{document}: {target}");
        }
    }
}

fn beside(document: &str, file: &str) -> PathBuf {
    Path::new(document).parent().expect("it is in a folder").join(file)
}

/// What stands in the round brackets of links and pictures.
fn links(text: &str) -> impl Iterator<Item = &str> {
    text.split("](").skip(1).filter_map(|rest| rest.split_once(')').map(|(target, _)| target))
}

/// The anchors that GitHub gives to headings.
fn anchors(text: &str) -> impl Iterator<Item = String> {
    let mark = |mark: char| match mark {
        ' ' => Some('-'),
        mark if mark.is_alphanumeric() || mark == '-' || mark == '_' => Some(mark.to_ascii_lowercase()),
        _ => None,
    };
    let headings = text.lines().filter(|line| line.starts_with('#'));
    headings.map(move |line| line.trim_start_matches('#').trim().chars().filter_map(mark).collect())
}
