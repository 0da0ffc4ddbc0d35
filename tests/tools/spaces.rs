//! `feed`, `watch`, `record` and `replay` with streams of points in R^d.

use hopes_protocol::{Banner, FILE_VERSION, SPACE_FILE_VERSION};

use crate::common::peers::Daemon;
use crate::common::process::hopes;

const SQUARES: &str = "x,y,z\n0,0,5\n1,0,5\n1,1,5\n0,1,5\n\n0,0,6\n2,0,6\n2,2,6\n0,2,6\n";

#[test]
fn a_stream_is_fed_watched_recorded_and_played_again() {
    let daemon = Daemon::start("--stream cam:metric=euclidean,window=frames:1");
    let (from, to) = (format!("--from {}", daemon.address), format!("--to {}", daemon.address));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cam.hopes");
    let record = hopes("record --stream cam --full --frames 2").and(&from).and("-o").with(&file).start();
    let watch = hopes("watch --stream cam --full --frames 2 --dots 1 --check --output jsonl").and(&from).start();
    while daemon.stream("cam").info.consumers < 2 {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let fed = hopes("feed - --stream cam --metric euclidean").and(&to).reads(SQUARES);
    assert!(fed.err.contains("8 points accepted, 0 refused"), "{}", fed.err);
    fed.out();
    let watched = watch.finish().text();
    assert!(watched.contains("[0,0.0,0.0,5.0]") && watched.contains("\"death_edge\":[4,6]"), "{watched}");
    record.finish().out();
    let bytes = std::fs::read(&file).unwrap();
    assert_eq!(Banner::decode(&bytes).unwrap().lowest, SPACE_FILE_VERSION);
    let played = hopes("replay --fast --output jsonl").with(&file).runs().text();
    let frames: String =
        watched.lines().filter(|line| !line.contains("\"dots\"")).map(|line| line.to_owned() + "\n").collect();
    assert_eq!(played, frames);
    daemon.stop();
}

#[test]
fn a_recording_of_any_names_has_both_kinds_and_one_of_the_plane_stays_readable_for_older_programs() {
    let daemon = Daemon::start("--stream flat --stream deep:metric=manhattan");
    let (from, to) = (format!("--from {}", daemon.address), format!("--to {}", daemon.address));
    hopes("feed - --stream flat").and(&to).reads("0,0\n1,0\n1,1\n0,1\n").out();
    hopes("feed - --stream deep --metric manhattan").and(&to).reads(SQUARES).out();
    let status = hopes("status --spaces --connect").with(&daemon.address);
    let table = status.runs().text();
    assert!(table.contains("deep    manhattan") && table.ends_with("        3\n"), "{table}");
    let json = status.and("--json").runs().text();
    assert!(json.lines().nth(1).unwrap().contains("\"metric\":\"Manhattan\",\"dimension\":3"), "{json}");
    let all = hopes("record --stream * --frames 2 -o -").and(&from).runs().out();
    assert_eq!(Banner::decode(&all).unwrap().lowest, SPACE_FILE_VERSION);
    let played = hopes("replay - --fast").reads(&all).text();
    assert!(played.contains("flat  frame 1") && played.contains("deep  frame 2"), "{played}");
    let again = hopes("replay - --fast --output bin").reads(&all).out();
    assert_eq!(hopes("replay - --fast").reads(&again).text(), played);
    let flat = hopes("record --stream flat --frames 1 -o -").and(&from).runs().out();
    assert_eq!(Banner::decode(&flat).unwrap().lowest, FILE_VERSION);
    daemon.stop();
}

#[test]
fn a_stream_of_another_kind_is_not_opened() {
    let daemon = Daemon::start("--stream flat --stream deep:metric=euclidean,dimension=3");
    let to = format!("--to {}", daemon.address);
    for (arguments, words) in [
        ("feed - --stream deep", "with the metric euclidean"),
        ("feed - --stream flat --metric euclidean", "of the plane"),
        ("feed - --stream deep --metric angular", "metric euclidean, dimension 3"),
        ("feed - --stream deep --embed 4:1", "dimension 3"),
    ] {
        hopes(arguments).and(&to).reads(SQUARES).fails(1, &[words]);
    }
    let narrow = hopes("feed - --stream deep --metric euclidean --columns x,y").and(&to).reads(SQUARES);
    assert_eq!(narrow.code, Some(1), "{}", narrow.err);
    assert!(narrow.err.contains("points of 2 coordinates"), "{}", narrow.err);
    daemon.stop();
}
