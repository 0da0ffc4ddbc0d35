//! `hopes demo`: the address it prints, the page, its output, and its end.

use std::net::TcpListener;
use std::process::Stdio;

use rustix::process::Signal;

use crate::common::process::{Running, eventually, hopes};
use crate::page::HttpClient;

const ANYWHERE: &str = "--view 127.0.0.1:0";

/// A running demo, and host and port of its page.
fn started(arguments: &str) -> (Running, String) {
    let mut running = hopes("demo").and(arguments).start();
    let first = running.line().expect("there is a first line");
    let (_, rest) = first.split_once("open http://").unwrap_or_else(|| panic!("{first:?} has no address to open"));
    let host = rest.split_once('/').unwrap().0.to_owned();
    (running, host)
}

fn get(host: &str, path: &str) -> crate::page::Reply {
    let mut client = HttpClient::at(host);
    client.send(format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes());
    client.reply().expect("there is a response")
}

#[test]
fn a_demo_ends_after_a_given_number_of_frames() {
    let finished = hopes(&format!("demo --scene static --frames 45 --rate 300 {ANYWHERE}")).runs();
    let text = finished.text();
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[0].starts_with("open http://127.0.0.1:"), "{text}");
    assert!(
        lines[1].starts_with("scene static: 8 rings stay; only their points change, at 300 frames a second"),
        "{text}"
    );
    assert!(text.ends_with("demo  closed after frame 45: the stream has ended\nthe demo is over\n"), "{text}");
    assert_eq!(lines.iter().filter(|line| line.contains(" is born: at (")).count(), 8, "{text}");
}

#[test]
fn the_page_shows_the_running_demo_and_a_signal_ends_it() {
    for (signal, name) in [(Signal::INT, "SIGINT"), (Signal::TERM, "SIGTERM")] {
        let (mut running, host) = started(&format!("--rate 100 {ANYWHERE}"));
        assert!(String::from_utf8(get(&host, "/").ok()).unwrap().contains("<canvas"));
        let frame = || {
            let streams = get(&host, "/api/streams").json();
            let stream = streams["streams"].as_array()?.iter().find(|stream| stream["info"]["name"] == "demo")?.clone();
            stream["info"]["frame"].as_u64()
        };
        let seen = eventually("frames come", || frame().filter(|frame| *frame > 2));
        eventually("more come", || frame().filter(|frame| *frame > seen));
        running.signal(signal);
        let mut last = String::new();
        while let Some(line) = running.line() {
            last = line;
        }
        let finished = running.finish();
        assert_eq!((finished.code, finished.err.as_str()), (Some(0), ""), "{name}");
        assert_eq!(last, name);
        assert!(std::net::TcpStream::connect(&host).is_err(), "the port is still open");
    }
}

#[test]
fn the_film_repeats() {
    let text = hopes(&format!("demo --video --frames 60 --rate 300 {ANYWHERE}")).runs().text();
    assert!(text.contains("Big Buck Bunny") && text.contains("CC BY 3.0"), "{text}");
    assert!(text.ends_with("demo  closed after frame 60: the stream has ended\nthe demo is over\n"), "{text}");
}

#[test]
fn a_closed_stdout_ends_the_demo_without_leftovers() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = hopes(&format!("demo --frames 30 --rate 300 {ANYWHERE}")).command();
    let mut child = command.env("TMPDIR", folder.path()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr.len()), (Some(0), 0), "{output:?}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_port_in_use_is_avoided_or_refused() {
    // If another process has it already, that serves as well.
    let taken = TcpListener::bind("127.0.0.1:8080");
    let (running, host) = started("--frames 1");
    assert!(host != "127.0.0.1:8080", "the port is in use");
    running.finish().out();
    drop(taken);
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = taken.local_addr().unwrap().to_string();
    hopes(&format!("demo --view {place}")).runs().fails(1, &["another daemon is listening at", &place]);
}

#[test]
fn invalid_options_are_refused() {
    for (arguments, words) in [
        ("--scene nothing", "there is no scene \"nothing\""),
        ("--scene pinch --video", "cannot be used with"),
        ("--frames 0", "frames"),
        ("--rate 0", "above 0"),
        ("--view 8080", "is no HOST:PORT"),
        ("--allow-remote", "--view"),
    ] {
        hopes("demo").and(arguments).runs().fails(2, &[words]);
    }
    hopes("demo --view 0.0.0.0:0").runs().fails(1, &["can be reached from other machines", "--allow-remote"]);
}
