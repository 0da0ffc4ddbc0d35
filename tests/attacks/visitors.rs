//! Visitors of the page that do not read, or take all places.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use super::scene::{assert_ends_well, stream_of};
use crate::common::peers::{Daemon, points};
use crate::common::process::{eventually, hopes};
use crate::common::random::Random;

/// A daemon with a page, and where that is.
fn with_page(options: &str) -> (Daemon, String) {
    let folder = tempfile::tempdir().unwrap();
    let socket = folder.path().join("socket");
    let mut running = hopes("serve --view 127.0.0.1:0")
        .and(options)
        .with("--listen")
        .with(format!("unix:{}", socket.display()))
        .start();
    let log = running.until_log("the page is at http://");
    let place = log.rsplit_once("http://").unwrap().1.trim().trim_end_matches('/').to_owned();
    (Daemon { running, address: format!("unix:{}", socket.display()), folder }, place)
}

fn request(place: &str, path: &str) -> TcpStream {
    let mut stream = TcpStream::connect(place).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: {place}\r\n\r\n").unwrap();
    stream
}

fn response(mut stream: TcpStream) -> String {
    let mut bytes = Vec::new();
    // A connection that is refused may be reset after the response.
    let _ = stream.read_to_end(&mut bytes);
    String::from_utf8_lossy(&bytes).into_owned()
}

#[test]
fn visitors_that_do_not_read_keep_nobody_from_a_snapshot() {
    let (daemon, place) = with_page("");
    let (_producer, _) = stream_of(&daemon, "cam", 50_000);
    let path = "/api/streams/cam/snapshot?full";
    let mute: Vec<TcpStream> = (0..10).map(|_| request(&place, path)).collect();
    let begun = Instant::now();
    for _ in 0..3 {
        let response = response(request(&place, path));
        assert!(response.starts_with("HTTP/1.1 200 OK"), "{}", &response[..200.min(response.len())]);
    }
    assert!(begun.elapsed() < Duration::from_secs(20), "it took {:?}", begun.elapsed());
    drop(mute);
    assert_ends_well(daemon, None);
}

#[test]
fn health_has_a_place_of_its_own() {
    let (daemon, place) = with_page("--max-connections 4");
    // All places are taken by visitors that say nothing.
    let idle: Vec<TcpStream> = (0..16).map(|_| TcpStream::connect(&place).unwrap()).collect();
    let answer = |path| response(request(&place, path));
    eventually("the places are taken", || answer("/metrics").starts_with("HTTP/1.1 503").then_some(()));
    let healthy = eventually("health is told", || Some(answer("/healthz")).filter(|text| text.contains("200 OK")));
    assert!(healthy.ends_with("ok\n"), "{healthy}");
    drop(idle);
    assert_ends_well(daemon, None);
}

#[test]
fn health_tells_which_stream_does_not_answer() {
    const LARGE: usize = 500_000;
    // Every frame is compared with recomputation, which takes seconds for so many points.
    let (daemon, place) = with_page("--check");
    let (mut producer, _) = stream_of(&daemon, "cam", 100);
    assert!(response(request(&place, "/healthz")).ends_with("ok\n"));
    let mut large = daemon.producer("large");
    for some in points(&mut Random::new(1), LARGE).chunks(10_000) {
        let batch = large.batch(some);
        large.is_accepted(batch, some.len());
    }
    let commit = large.commit();
    let unwell = eventually("the engine is busy", || {
        Some(response(request(&place, "/healthz"))).filter(|text| text.starts_with("HTTP/1.1 503"))
    });
    assert!(unwell.contains("stream \"large\" has not answered within 1 s"), "{unwell}");
    assert!(!unwell.contains("\"cam\""), "{unwell}");
    producer.frame(&[(0.5, 0.5)]);
    large.is_committed(commit);
    eventually("it is well again", || response(request(&place, "/healthz")).ends_with("ok\n").then_some(()));
    assert_ends_well(daemon, None);
}
