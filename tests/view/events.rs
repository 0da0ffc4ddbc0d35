//! Frames as server-sent events, for clients that do not speak the protocol.

use std::io::Write;
use std::process::{Command, Stdio};

use hopes_protocol::*;
use rustix::process::Signal;
use serde_json::{Value, json};

use super::event_client::Events;
use super::page::Page;
use crate::common::peers::{FULL, Producer, assert_clean_exit, held, open, points};
use crate::common::process::{eventually, hopes};
use crate::common::random::Random;

fn refusal(page: &Page, path: &str, fields: &str) -> super::page::Reply {
    page.request(&format!("GET {path} HTTP/1.1\r\nHost: {}\r\n{fields}\r\n", page.host))
}

/// A stream whose frames replace each other, with a first frame.
fn replaced(page: &Page, name: &str, random: &mut Random, count: usize) -> Producer {
    let mut producer = Producer::open(page.daemon.client(), Open { window: Some(Window::Frames(1)), ..open(name) });
    producer.frame(&points(random, count));
    producer
}

/// The ids of all events are those of the stream's present epoch.
fn id(page: &Page, name: &str, frame: u64) -> String {
    format!("{frame}-{:x}", page.daemon.stream(name).info.epoch)
}

// ---- what they say

#[test]
fn changes_are_the_lines_of_watch() {
    let page = Page::start("");
    let mut random = Random::new(1);
    let mut producer = Producer::open(page.daemon.client(), Open { window: Some(Window::Frames(3)), ..open("cam") });
    producer.frame(&points(&mut random, 200));
    for (query, view) in [("full", "--full"), ("k=2&l=3", "-k 2 -l 3"), ("alpha=0.05", "--alpha 0.05"), ("", "")] {
        let mut watch = hopes("watch --stream cam --output jsonl --from").with(&page.daemon.address).and(view).start();
        let mut events = Events::of(&page, "cam", &format!("?changes&{query}"));
        let mut consumer = page.daemon.consumer("cam", FULL);
        for step in 0..6 {
            let (line, event) = (watch.line().unwrap(), events.due());
            assert_eq!((event.name.as_str(), &event.data), ("frame", &line), "{query}");
            let number = event.frames().1;
            assert_eq!(event.id, Some(id(&page, "cam", number)));
            assert_eq!(event.json()["from"], if step == 0 { 0 } else { number - 1 });
            consumer.follow_to(number);
            assert_eq!(event.json()["points"], consumer.mirror.vertices().len());
            producer.frame(&points(&mut random, 150));
        }
    }
    page.daemon.stop();
}

#[test]
fn whole_frames_are_those_of_a_consumer() {
    let page = Page::start("");
    let mut random = Random::new(2);
    let mut producer = Producer::open(page.daemon.client(), Open { window: Some(Window::Frames(2)), ..open("a/b") });
    producer.frame(&points(&mut random, 300));
    let mut consumer = page.daemon.consumer("a/b", FULL);
    let mut events = Events::of(&page, "a%2Fb", "?full");
    let mut derived = Events::of(&page, "a%2Fb", "?k=3");
    assert_eq!(events.fields["content-type"], "text/event-stream");
    assert_eq!((&events.fields["cache-control"][..], &events.fields["x-accel-buffering"][..]), ("no-store", "no"));
    for _ in 0..8 {
        let event = events.due();
        let (from, number) = event.frames();
        consumer.follow_to(number);
        let json = event.json();
        let mirror = &consumer.mirror;
        let vertices: Vec<_> = mirror.vertices().iter().map(|(id, (x, y))| (id, x, y)).collect();
        let critical: Vec<_> = mirror.critical().iter().map(|((a, b), (birth, death))| (a, b, birth, death)).collect();
        assert_eq!((from, &json["stream"]), (0, &json!("a/b")));
        assert_eq!(json["vertices"], json!({"add": vertices, "del": []}));
        assert_eq!(json["edges"], json!({"add": mirror.edges(), "del": []}));
        assert_eq!(json["critical"], json!({"set": critical, "del": []}));
        assert_eq!(json["checksum"], format!("{:016x}", mirror.checksum()));
        // The line is that of a snapshot, of any view.
        let snapshot = |query: &str| String::from_utf8(page.get(&format!("/api/streams/a%2Fb/snapshot{query}")).ok());
        assert_eq!(format!("{}\n", event.data), snapshot("?full").unwrap());
        assert_eq!(format!("{}\n", derived.due().data), snapshot("?k=3").unwrap());
        producer.frame(&points(&mut random, 200));
    }
    page.daemon.stop();
}

#[test]
fn a_stream_without_a_frame_is_waited_for() {
    let page = Page::start("--heartbeat 100ms");
    let mut producer = page.daemon.producer("cam");
    let (mut events, mut changes) = (Events::of(&page, "cam", ""), Events::of(&page, "cam", "?changes"));
    // What clients skip shows that the daemon is there.
    events.until_comment();
    changes.until_comment();
    producer.frame(&[(0.0, 0.0), (1.0, 0.0)]);
    for events in [&mut events, &mut changes] {
        assert_eq!((events.due().json()["points"].clone(), events.comments > 0), (json!(2), false));
        events.until_comment();
    }
    page.daemon.stop();
}

// ---- where they begin

#[test]
fn changes_go_on_after_the_last_event() {
    let page = Page::start("");
    let mut random = Random::new(3);
    let mut producer = replaced(&page, "cam", &mut random, 50);
    let mut before = Events::of(&page, "cam", "?changes&full");
    before.due();
    for _ in 0..2 {
        producer.frame(&points(&mut random, 50));
    }
    let last = before.up_to(3).pop().unwrap().id.unwrap();
    drop(before);
    for _ in 0..3 {
        producer.frame(&points(&mut random, 50));
    }
    for id in [&last, "3"] {
        let mut after = Events::after(&page, "cam", "?changes&full", id);
        let frames: Vec<_> = (0..3).map(|_| after.due().frames()).collect();
        assert_eq!(frames, [(3, 4), (4, 5), (5, 6)], "{id}");
    }
    // Frames of another stream of that name, and frames that are not there, cannot be gone on from.
    for id in ["3-1", "99", &id(&page, "cam", 99)] {
        assert_eq!(Events::after(&page, "cam", "?changes&full", id).due().frames(), (0, 6), "{id}");
    }
    assert_eq!(producer.close(true), 6);
    let mut anew = replaced(&page, "cam", &mut random, 50);
    for _ in 0..4 {
        anew.frame(&points(&mut random, 50));
    }
    assert_eq!(Events::after(&page, "cam", "?changes&full", &last).due().frames(), (0, 5));
    page.daemon.stop();
}

#[test]
fn whole_frames_go_on_and_what_is_missing_is_told() {
    let page = Page::start("");
    let mut random = Random::new(4);
    let mut producer = replaced(&page, "cam", &mut random, 50);
    for _ in 0..4 {
        producer.frame(&points(&mut random, 50));
    }
    let mut after = Events::after(&page, "cam", "", &id(&page, "cam", 2));
    assert_eq!((after.due().lagged(), after.due().frames()), ((3, 4), (0, 5)));
    let mut next = Events::after(&page, "cam", "", &id(&page, "cam", 4));
    assert_eq!(next.due().frames(), (0, 5), "nothing is missing");
    let mut newest = Events::after(&page, "cam", "", &id(&page, "cam", 5));
    let mut other = Events::after(&page, "cam", "", "5-1");
    assert_eq!(other.due().frames(), (0, 5), "that was another stream");
    // Its subscription may begin after the frame that it waits for.
    eventually("all follow", || (page.daemon.stream("cam").info.consumers == 4).then_some(()));
    producer.frame(&points(&mut random, 50));
    let frames = [&mut after, &mut next, &mut newest, &mut other].map(|events| events.due().frames());
    assert_eq!(frames, [(0, 6); 4], "the newest frame does not come twice");
    page.daemon.stop();
}

// ---- slow clients

/// Reads all events up to a frame, of which some lagged, and returns how many frames did not come.
fn missed(events: &mut Events, last: u64) -> u64 {
    let mut at = 1;
    let mut missed = 0;
    for event in events.up_to(last) {
        if event.name == "lagged" {
            let (first, to) = event.lagged();
            assert_eq!(first, at + 1);
            missed += to - first + 1;
            at = to;
        } else {
            assert_eq!(event.frames().1, at + 1, "no frame is left out without a word");
            at += 1;
        }
    }
    missed
}

#[test]
fn a_client_that_paused_reading_gets_lagged_and_goes_on() {
    let page = Page::start("--consumer-queue 64KiB");
    let mut random = Random::new(6);
    let mut producer = replaced(&page, "cam", &mut random, 12_000);
    let mut paused = [Events::of(&page, "cam", "?full"), Events::of(&page, "cam", "?full&changes")];
    let mut reading = page.daemon.consumer("cam", FULL);
    reading.expect_snapshot(Cause::Start);
    assert_eq!(paused.each_mut().map(|events| events.due().frames()), [(0, 1); 2]);
    // More than the buffers of sockets hold.
    let mut last = 1;
    for _ in 0..40 {
        last = producer.frame(&points(&mut random, 12_000));
        reading.follow_to(last);
    }
    let missed = paused.each_mut().map(|events| missed(events, last));
    assert!(missed.iter().all(|count| *count > 0), "{missed:?}");
    assert_eq!(page.daemon.stream("cam").lagged, missed.iter().sum::<u64>());
    last = producer.frame(&points(&mut random, 100));
    reading.follow_to(last);
    let [whole, changes] = paused.each_mut().map(|events| events.due());
    assert_eq!((whole.frames(), changes.frames().1), ((0, last), last));
    assert_eq!(whole.json()["checksum"], changes.json()["checksum"]);
    assert_eq!(whole.json()["checksum"], format!("{:016x}", reading.mirror.checksum()));
    page.daemon.stop();
}

#[test]
fn a_client_that_never_reads_is_disconnected_and_delays_nothing() {
    let page = Page::start("--timeout 4s --heartbeat 500ms");
    let mut random = Random::new(5);
    let mut producer = replaced(&page, "cam", &mut random, 12_000);
    let silent = Events::of(&page, "cam", "?full");
    let mut beside = page.daemon.consumer("cam", FULL);
    eventually("both follow", || (page.daemon.stream("cam").info.consumers == 2).then_some(()));
    let begun = std::time::Instant::now();
    while page.daemon.stream("cam").info.consumers == 2 {
        let frame = producer.frame(&points(&mut random, 12_000));
        beside.follow_to(frame);
        assert!(begun.elapsed().as_secs() < 90, "the one that does not read is still there after frame {frame}");
    }
    drop(silent);
    page.daemon.stop();
}

#[test]
fn what_a_client_holds_is_its_own() {
    let page = Page::start("");
    let _producer = replaced(&page, "cam", &mut Random::new(8), 20_000);
    let (mut whole, mut changes) = (Events::of(&page, "cam", "?full"), Events::of(&page, "cam", "?full&changes"));
    whole.due();
    changes.due();
    let mut client = page.daemon.client();
    // 20,000 vertices and as many edges are held to make the next frame whole of a change.
    let held = eventually("what was sent is given back", || {
        let Message::Peers(peers) = client.ask(9, ListPeers {}) else { panic!("peers are due") };
        let mut held: Vec<u64> = peers.peers.iter().filter(|peer| is_events(peer)).map(|peer| peer.held).collect();
        held.sort_unstable();
        (held.len() == 2 && held[1] < 4_000_000).then_some(held)
    });
    assert!(held[0] < 500_000 && held[1] > 20_000 * 64, "{held:?}");
    drop((whole, changes));
    eventually("they are gone", || {
        let Message::Peers(peers) = client.ask(9, ListPeers {}) else { panic!("peers are due") };
        (!peers.peers.iter().any(is_events)).then_some(())
    });
    page.daemon.stop();
}

fn is_events(peer: &Peer) -> bool {
    let is_events = peer.software == "server-sent events";
    assert_eq!(is_events, peer.place.ends_with("/api/streams/*/frames"), "{peer:?}");
    is_events
}

// ---- how they end

#[test]
fn the_end_of_a_stream_is_told() {
    let page = Page::start("");
    let mut producer = page.daemon.producer("cam");
    producer.frame(&[(0.0, 0.0), (1.0, 0.0)]);
    let mut clients = [Events::of(&page, "cam", ""), Events::of(&page, "cam", "?changes")];
    assert_eq!(clients.each_mut().map(|events| events.due().frames()), [(0, 1); 2]);
    producer.frame(&[(0.0, 1.0)]);
    assert_eq!(producer.close(true), 2);
    for events in &mut clients {
        assert_eq!(events.due().frames().1, 2);
        let rest = events.rest();
        assert_eq!(rest.len(), 1, "{rest:?}");
        let said: Value = rest[0].json();
        assert_eq!((&rest[0].name[..], &said["stream"], &said["frame"]), ("end", &json!("cam"), &json!(2)));
        assert!(said["reason"].as_str().unwrap().contains("ended"), "{said}");
    }
    // So a browser, which asks again, is told that there is nothing more.
    refusal(&page, "/api/streams/cam/frames", "").is_refused(404, "no stream \"cam\"");
    page.daemon.stop();
}

#[test]
fn clients_get_the_last_frame_and_a_goodbye() {
    let page = Page::start("");
    let mut producer = page.daemon.producer("cam");
    producer.frame(&[(0.0, 0.0), (1.0, 0.0)]);
    let mut clients = [Events::of(&page, "cam", ""), Events::of(&page, "cam", "?changes")];
    assert_eq!(clients.each_mut().map(|events| events.due().frames()), [(0, 1); 2]);
    // The frame is committed, but may not be computed yet.
    let batch = producer.batch(&[(0.0, 2.0)]);
    producer.is_accepted(batch, 1);
    let commit = producer.commit();
    producer.is_committed(commit);
    page.daemon.running.signal(Signal::TERM);
    for events in &mut clients {
        let rest = events.rest();
        let names: Vec<&str> = rest.iter().map(|event| &event.name[..]).collect();
        assert_eq!(names, ["frame", "end", "goodbye"], "{rest:?}");
        assert_eq!((rest[0].frames().1, &rest[1].json()["frame"]), (2, &json!(2)));
        assert!(rest[2].json()["reason"].as_str().unwrap().contains("SIGTERM"), "{rest:?}");
    }
    assert_clean_exit(page.daemon.running.ends());
}

#[test]
fn a_client_that_is_disconnected_is_told_why() {
    let page = Page::start("");
    page.daemon.producer("cam").frame(&[(0.0, 0.0)]);
    let mut events = Events::of(&page, "cam", "");
    events.due();
    let mut client = page.daemon.client();
    let Message::Peers(peers) = client.ask(9, ListPeers {}) else { panic!("peers are due") };
    let peer = peers.peers.iter().find(|peer| is_events(peer)).unwrap().peer;
    assert!(matches!(client.ask(9, Disconnect { peer }), Message::Disconnected(_)));
    let rest = events.rest();
    assert_eq!((rest.len(), &rest[0].name[..]), (1, "goodbye"), "{rest:?}");
    // More than a request has no place here.
    let mut noisy = Events::of(&page, "cam", "");
    noisy.due();
    noisy.stream().write_all(&[b'x'; 20_000]).unwrap();
    let rest = noisy.rest();
    assert!(rest[0].name == "goodbye" && rest[0].data.contains("more than its request"), "{rest:?}");
    page.daemon.stop();
}

// ---- what is refused

#[test]
fn requests_that_make_no_sense_say_why() {
    let page = Page::start("");
    page.daemon.producer("cam").frame(&[(0.0, 0.0)]);
    for (path, fields, status, words) in [
        ("dog/frames", "", 404, "no stream \"dog\""),
        ("*/frames", "", 404, "no stream \"*\""),
        ("%C3/frames", "", 400, "UTF-8"),
        ("cam/frames?k=0", "", 400, "k is a number from 1"),
        ("cam/frames?alpha=1&k=1", "", 400, "different views"),
        ("cam/frames?changes=1", "", 400, "changes has no value"),
        ("cam/frames?changes&changes", "", 400, "twice"),
        ("cam/frames?format=json", "", 400, "use changes, k, l, alpha, full"),
        ("cam/frames", "Last-Event-ID: x\r\n", 400, "Last-Event-ID is the id of an event"),
        ("cam/frames", "Last-Event-ID: 0\r\n", 400, "Last-Event-ID is the id of an event"),
        ("cam/frames", "Last-Event-ID: 1\r\nLast-Event-ID: 1\r\n", 400, "one Last-Event-ID"),
        ("cam/frames", "Origin: https://evil.example\r\n", 403, "--view-origin"),
        ("cam/frame", "", 404, "nothing here"),
    ] {
        refusal(&page, &format!("/api/streams/{path}"), fields).is_refused(status, words);
    }
    page.daemon.stop();
}

#[test]
fn the_response_to_head_is_the_head() {
    let page = Page::start("");
    page.daemon.producer("cam").frame(&[(0.0, 0.0)]);
    let events = Events::of(&page, "cam", "");
    let head = |path: &str| page.request(&format!("HEAD {path} HTTP/1.1\r\nHost: {}\r\n\r\n", page.host));
    let found = head("/api/streams/cam/frames");
    assert_eq!((found.status, &found.fields, found.body.len()), (200, &events.fields, 0));
    assert_eq!((head("/api/streams/dog/frames").status, head("/api/streams/cam/frames?k=x").status), (404, 400));
    page.daemon.stop();
}

#[test]
fn a_client_above_the_limits_is_refused_with_the_reason() {
    let page = Page::start("--max-connections 2 --stream cam");
    let (_first, _second) = (page.websocket(), page.websocket());
    refusal(&page, "/api/streams/cam/frames", "").is_refused(503, "2 connections");
    // Other requests have a limit of their own.
    page.get("/healthz").ok();
    page.daemon.stop();
}

#[test]
fn a_view_that_the_stream_may_not_have_is_refused_with_the_reason() {
    let page = Page::start("--max-views 1");
    page.daemon.producer("cam").frame(&[(0.0, 0.0)]);
    let mut consumer = page.daemon.consumer("cam", FULL);
    consumer.expect_snapshot(Cause::Start);
    // Only the stream's engine knows, when the response has begun.
    let rest = Events::of(&page, "cam", "?alpha=3").rest();
    assert!(rest.len() == 1 && rest[0].name == "goodbye" && rest[0].data.contains("views"), "{rest:?}");
    assert_eq!(Events::of(&page, "cam", "?full").due().frames(), (0, 1));
    page.daemon.stop();
}

#[test]
fn a_daemon_without_memory_takes_no_client() {
    let page = Page::start("--max-memory 1MiB");
    let mut producer = page.daemon.producer("cam");
    producer.batch(&points(&mut Random::new(9), 20_000));
    eventually("memory is short", || {
        let json = page.get("/api/streams").json();
        (json["memory"].as_u64() > json["memory_limit"].as_u64()).then_some(())
    });
    refusal(&page, "/api/streams/cam/frames", "").is_refused(503, "limit of memory");
    page.daemon.stop();
}

// ---- as it is documented

/// The commands of the page's documentation that ask for frames.
fn documented() -> Vec<String> {
    let text = std::fs::read_to_string("src/view/README.md").unwrap();
    let commands = text.lines().filter(|line| line.starts_with("curl "));
    commands.map(str::to_owned).collect()
}

#[test]
fn the_documented_commands_print_frames() {
    if Command::new("curl").arg("--version").output().is_err() {
        assert!(std::env::var_os("CI").is_none(), "there is no curl, and CI must not skip this");
        return eprintln!("skipped: there is no curl here");
    }
    let page = Page::start("");
    let mut random = Random::new(7);
    let mut producer = replaced(&page, "cam", &mut random, 50);
    let commands = documented();
    assert!(commands.iter().any(|command| command.starts_with("curl -N ")), "{commands:?}");
    for command in commands {
        let command = command.replace("127.0.0.1:8080", &page.host);
        let mut curl =
            Command::new("sh").arg("-c").arg(&command).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut printed = std::io::BufReader::new(curl.stdout.take().unwrap());
        for _ in 0..3 {
            producer.frame(&points(&mut random, 50));
            // A pipe behind it may only print what it selects of each frame.
            let mut line = String::new();
            while !["data: {", "["].iter().any(|begin| line.starts_with(begin)) {
                line.clear();
                assert_ne!(std::io::BufRead::read_line(&mut printed, &mut line).unwrap(), 0, "{command}");
            }
        }
        curl.kill().unwrap();
        curl.wait().unwrap();
    }
    page.daemon.stop();
}

#[test]
fn a_mirror_that_applies_changes_holds_what_a_consumer_holds() {
    let page = Page::start("");
    let mut random = Random::new(10);
    let mut producer = replaced(&page, "cam", &mut random, 80);
    let mut consumer = page.daemon.consumer("cam", FULL);
    let mut events = Events::of(&page, "cam", "?full&changes");
    let mut mirror = Mirror::new();
    for _ in 0..5 {
        let event = events.due();
        mirror.apply_diff(&as_diff(&event.json())).expect("the checksum of the line fits");
        consumer.follow_to(event.frames().1);
        assert_eq!(held(&mirror), held(&consumer.mirror));
        producer.frame(&points(&mut random, 80));
    }
    page.daemon.stop();
}

/// The change that a line says, as the documentation describes its keys.
fn as_diff(line: &Value) -> Diff {
    fn of<T: serde::de::DeserializeOwned>(value: &Value) -> T {
        serde_json::from_value(value.clone()).unwrap()
    }
    let view = &line["view"];
    let frame = FrameInfo {
        number: of(&line["frame"]),
        time: of(&line["time"]),
        points: of(&line["points"]),
        vertices: of(&line["points"]),
        rejected: of(&line["rejected"]),
        view: FULL,
        ds: None,
        vs: None,
        components: of(&view["components"]),
        cycles: of(&view["cycles"]),
    };
    Diff {
        stream: 1,
        from: of(&line["from"]),
        frame,
        vertices_added: of(&line["vertices"]["add"]),
        vertices_removed: of(&line["vertices"]["del"]),
        edges_added: of(&line["edges"]["add"]),
        edges_removed: of(&line["edges"]["del"]),
        critical_set: of(&line["critical"]["set"]),
        critical_removed: of(&line["critical"]["del"]),
        checksum: u64::from_str_radix(line["checksum"].as_str().unwrap(), 16).unwrap(),
    }
}
