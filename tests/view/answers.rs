//! The resources of the page's server, and their formats.

use std::collections::BTreeSet;

use hopes_protocol::{Cause, Cut, Snapshot};
use serde_json::{Value, json};

use super::page::Page;
use crate::common::peers::{FULL, assert_clean_exit, open};
use crate::common::process::{eventually, hopes};

/// A quadrilateral, and a point far away from it.
const SQUARE: [(f64, f64); 5] = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.5), (0.0, 4.25), (20.0, 2.0)];

fn with_square(name: &str) -> Page {
    let page = Page::start("");
    let mut producer = page.daemon.producer(name);
    producer.frame(&SQUARE);
    page
}

fn path(name: &str, query: &str) -> String {
    format!("/api/streams/{name}/snapshot{query}")
}

#[test]
fn the_page_and_its_files_are_served_with_strict_headers() {
    let page = Page::start("");
    let answer = page.get("/");
    assert_eq!(answer.field("content-type"), "text/html; charset=utf-8");
    let policy = answer.field("content-security-policy").to_owned();
    for part in
        ["default-src 'none'", "script-src 'self'", "style-src 'self'", "connect-src 'self'", "form-action 'none'"]
    {
        assert!(policy.split("; ").any(|found| found == part), "{part} is missing in {policy}");
    }
    for part in ["img-src 'self' data:", "base-uri 'none'", "frame-ancestors 'none'"] {
        assert!(policy.split("; ").any(|found| found == part), "{part} is missing in {policy}");
    }
    assert!(!policy.contains("unsafe"), "{policy}");
    assert_eq!(answer.field("x-content-type-options"), "nosniff");
    assert_eq!(answer.field("referrer-policy"), "no-referrer");
    assert_eq!(answer.field("cross-origin-resource-policy"), "same-origin");
    assert!(!answer.fields.contains_key("access-control-allow-origin"));
    let html = String::from_utf8(answer.ok()).unwrap();
    // Every file that the page names, and every module that these import, is served with its media type.
    let mut files = named_files("/", &html);
    let mut at = 0;
    while let Some(file) = files.get(at).cloned() {
        let answer = page.get(&file);
        let is_script = file.ends_with(".js");
        let media_type = if is_script { "text/javascript; charset=utf-8" } else { "text/css; charset=utf-8" };
        assert_eq!(answer.field("content-type"), media_type, "{file}");
        assert_eq!(answer.field("content-security-policy"), policy);
        let text = String::from_utf8(answer.ok()).unwrap();
        for imported in named_files(&file, &text) {
            if !files.contains(&imported) {
                files.push(imported);
            }
        }
        at += 1;
    }
    assert!(files.len() > 20, "{files:?}");
    page.get("/no/such/thing").is_refused(404, "start at /");
    page.get("/../Cargo.toml").is_refused(404, "nothing here");
    page.daemon.stop();
}

/// The scripts and style sheets that a file names in quotes, as paths.
pub fn named_files(path: &str, text: &str) -> Vec<String> {
    let folder = path.rsplit_once('/').unwrap().0;
    let words = text.split(['"', '\'']).filter(|word| word.ends_with(".js") || word.ends_with(".css"));
    let resolved = words.map(|word| match word.strip_prefix("../") {
        Some(rest) => format!("{}/{rest}", folder.rsplit_once('/').unwrap().0),
        None => format!("{folder}/{}", word.trim_start_matches("./")),
    });
    resolved.collect()
}

#[test]
fn a_file_is_sent_once_per_version() {
    let page = Page::start("");
    let first = page.get("/");
    assert_eq!(first.field("cache-control"), "no-cache");
    let tag = first.field("etag").to_owned();
    let again =
        |tag: &str| page.request(&format!("GET / HTTP/1.1\r\nHost: {}\r\nIf-None-Match: {tag}\r\n\r\n", page.host));
    for tag in [tag.clone(), format!("\"x\", {tag}"), format!("W/{tag}")] {
        let known = again(&tag);
        assert_eq!((known.status, known.field("etag"), known.body.len()), (304, first.field("etag"), 0), "{tag}");
    }
    assert_eq!(again("\"other\""), first);
    page.daemon.stop();
}

#[test]
fn the_response_to_head_has_no_body() {
    let page = with_square("cam");
    for path in ["/", "/healthz", &path("cam", "?full"), "/nowhere"] {
        let head = page.request(&format!("HEAD {path} HTTP/1.1\r\nHost: {}\r\n\r\n", page.host));
        let whole = page.get(path);
        assert_eq!((head.status, &head.fields, head.body.len()), (whole.status, &whole.fields, 0), "{path}");
        assert!(!whole.body.is_empty());
    }
    page.daemon.stop();
}

#[test]
fn health_status_and_metrics_are_those_of_the_daemon() {
    let page = with_square("a \"b\\ c");
    let mut consumer = page.daemon.consumer("a*", FULL);
    consumer.expect_snapshot(Cause::Start);
    assert_eq!(page.get("/healthz").ok(), b"ok\n");
    let json = eventually("the consumer is counted", || {
        let json = page.get("/api/streams").json();
        (json["streams"][0]["info"]["consumers"] == 1).then_some(json)
    });
    let status = hopes("status --json --from").with(&page.daemon.address).runs().text();
    let status: Value = serde_json::from_str(&status).unwrap();
    assert_eq!(json["streams"], status["streams"]);
    assert_eq!((&json["software"], &json["epoch"]), (&status["software"], &status["epoch"]));
    let metrics = page.get("/metrics");
    assert_eq!(metrics.field("content-type"), "application/openmetrics-text; version=1.0.0; charset=utf-8");
    assert_eq!(metrics.field("cache-control"), "no-store");
    let text = String::from_utf8(metrics.ok()).unwrap();
    let number = |name: &str| sample(&text, name);
    for (name, expected) in [
        ("frames_total", 1),
        ("points", 5),
        ("vertices", 5),
        ("consumers", 1),
        ("accepted_points_total", 5),
        ("refused_points_total", 0),
        ("dropped_points_total", 0),
        ("lagged_frames_total", 0),
    ] {
        assert_eq!(number(&format!("hopes_stream_{name}{{stream=\"a \\\"b\\\\ c\"}}")), f64::from(expected), "{name}");
    }
    assert!(number("hopes_stream_computed_total{stream=\"a \\\"b\\\\ c\"}") >= 1.0);
    assert!(number("hopes_stream_memory_bytes{stream=\"a \\\"b\\\\ c\"}") > 0.0);
    assert_eq!(number("hopes_streams"), 1.0);
    assert!(number("hopes_connections") >= 1.0 && number("hopes_uptime_seconds") > 0.0);
    is_openmetrics(&text);
    page.daemon.stop();
}

/// Checks the format: each family is described once, its samples follow, and the text ends with the marker.
fn is_openmetrics(text: &str) {
    assert!(text.ends_with("\n# EOF\n"), "{text}");
    let mut described = BTreeSet::new();
    let (mut family, mut kind) = ("", "");
    for line in text.strip_suffix("# EOF\n").unwrap().lines() {
        let words: Vec<&str> = line.splitn(4, ' ').collect();
        match words[..] {
            ["#", "HELP", name, help] => {
                assert!(!help.is_empty() && described.insert(name), "{line}");
                family = name;
            }
            ["#", "TYPE", name, is] => {
                assert_eq!(name, family);
                kind = is;
            }
            ["#", "UNIT", name, unit] => assert!(name == family && name.ends_with(&format!("_{unit}")), "{line}"),
            _ => {
                let name = line.split(['{', ' ']).next().unwrap();
                let suffix = name.strip_prefix(family).unwrap_or_else(|| panic!("{line} among {family}"));
                let suffixes: &[&str] = match kind {
                    "counter" => &["_total"],
                    "gauge" => &[""],
                    "histogram" => &["_bucket", "_count", "_sum"],
                    _ => panic!("{family} is a {kind}"),
                };
                assert!(suffixes.contains(&suffix), "{line} of a {kind}");
            }
        }
    }
}

/// The value of the only sample with this name and these labels.
fn sample(text: &str, name: &str) -> f64 {
    let found: Vec<_> = text.lines().filter_map(|line| line.strip_prefix(name)?.strip_prefix(' ')).collect();
    assert_eq!(found.len(), 1, "{name} in {text}");
    found[0].parse().unwrap()
}

#[test]
fn frame_times_are_histograms_of_each_stream() {
    let page = Page::start("");
    let mut producer = page.daemon.producer("cam");
    let _consumer = page.daemon.consumer("cam", FULL);
    for frame in 1..=5 {
        producer.frame(&[(f64::from(frame), 0.0), (0.0, f64::from(frame))]);
    }
    let text = eventually("five frames are counted", || {
        let text = String::from_utf8(page.get("/metrics").ok()).unwrap();
        (sample(&text, "hopes_stream_frame_seconds_count{stream=\"cam\"}") == 5.0).then_some(text)
    });
    is_openmetrics(&text);
    for stage in ["frame", "triangulation", "reduction", "publishing"] {
        let of = |suffix: &str| sample(&text, &format!("hopes_stream_{stage}_seconds_{suffix}"));
        let count = of("count{stream=\"cam\"}");
        assert!(count >= 1.0, "{count} frames in {stage}");
        assert_eq!(of("bucket{le=\"+Inf\",stream=\"cam\"}"), count);
        assert!(of("sum{stream=\"cam\"}") > 0.0);
    }
    page.daemon.stop();
}

#[test]
#[cfg(target_os = "linux")]
fn metrics_of_the_process_have_their_standard_names() {
    let page = Page::start("");
    let text = String::from_utf8(page.get("/metrics").ok()).unwrap();
    assert!(sample(&text, "process_cpu_seconds_total") >= 0.0);
    assert!(sample(&text, "process_virtual_memory_bytes") >= sample(&text, "process_resident_memory_bytes"));
    assert!(sample(&text, "process_resident_memory_bytes") > 1e6);
    assert!(sample(&text, "process_open_fds") > 3.0);
    assert!(sample(&text, "process_threads") > 1.0);
    assert!(sample(&text, "process_start_time_seconds") > 1.7e9);
    page.daemon.stop();
}

#[test]
fn a_snapshot_is_that_of_a_consumer_of_the_same_view() {
    let page = with_square("cam");
    for (query, cut) in [
        ("", Cut::Derived(1, 1)),
        ("?k=1&l=2", Cut::Derived(1, 2)),
        ("?full", Cut::Full),
        ("?alpha=2.1", Cut::Reduced(2.1)),
        ("?format=json&alpha=0", Cut::Reduced(0.0)),
    ] {
        let mut consumer = page.daemon.consumer("cam", hopes_protocol::View { cut, ..FULL });
        let hopes_protocol::Message::Snapshot(shown) = consumer.next() else { panic!("a snapshot is due") };
        let json = page.get(&path("cam", query)).json();
        assert_eq!(json["checksum"], format!("{:016x}", shown.checksum), "{query}");
        assert_eq!((&json["stream"], &json["frame"], &json["from"]), (&json!("cam"), &json!(1), &json!(0)));
        assert_eq!(json["edges"]["add"], json!(shown.edges), "{query}");
        assert_eq!(json["critical"]["set"], json!(shown.critical), "{query}");
        geojson_shows(&page.get(&path("cam", &format!("{}format=geojson", joined(query)))).json(), &shown);
    }
    page.daemon.stop();
}

/// A query to which a parameter can be appended.
fn joined(query: &str) -> String {
    match query.replace("format=json", "") {
        query if query.is_empty() => "?".to_owned(),
        query => format!("{query}&"),
    }
}

fn geojson_shows(json: &Value, shown: &Snapshot) {
    let place = |id: u64| shown.vertices.iter().find(|vertex| vertex.0 == id).map(|&(_, x, y)| [x, y]).unwrap();
    let lines: Vec<_> = shown.edges.iter().map(|&(a, b)| [place(a), place(b)]).collect();
    let features = json["features"].as_array().unwrap();
    assert_eq!((&json["type"], features.len()), (&json!("FeatureCollection"), 2 + shown.critical.len()));
    assert_eq!(features[0]["geometry"]["coordinates"], json!(SQUARE));
    assert_eq!(features[1]["geometry"]["coordinates"], json!(lines));
    for (feature, &(a, b, birth, death)) in features[2..].iter().zip(&shown.critical) {
        assert_eq!(feature["geometry"], json!({"type": "LineString", "coordinates": [place(a), place(b)]}));
        assert_eq!((&feature["properties"]["birth"], &feature["properties"]["death"]), (&json!(birth), &json!(death)));
    }
}

#[test]
fn a_snapshot_as_svg_shows_its_elements() {
    // The name is part of the picture.
    let name = "<b>&%2F";
    let page = with_square("<b>&/");
    let answer = page.get(&path(name, "?format=svg&full"));
    assert_eq!(answer.field("content-type"), "image/svg+xml");
    let text = String::from_utf8(answer.ok()).unwrap();
    let svg = roxmltree::Document::parse(&text).unwrap();
    let drawn = |class: &str| -> usize {
        let of_class = svg.descendants().filter(|node| node.attribute("class") == Some(class));
        of_class.map(|node| node.attribute("d").unwrap().matches('M').count()).sum()
    };
    // The spanning tree of five points, and all their cycles.
    let shown = page.get(&path(name, "?full")).json();
    let cycles = shown["critical"]["set"].as_array().unwrap().len();
    assert!(cycles > 0);
    assert_eq!((drawn("vertices"), drawn("tree"), drawn("critical")), (5, 4, cycles));
    assert!(svg.descendants().any(|node| node.text().is_some_and(|text| text.starts_with("<b>&/: frame 1"))));
    page.daemon.stop();
}

#[test]
fn pictures_are_bounded_by_their_pixels() {
    let page = Page::start("");
    let mut random = crate::common::random::Random::new(7);
    let mut producer = page.daemon.producer("many");
    let svg = |page: &Page| page.get(&path("many", "?format=svg&full")).ok().len();
    producer.frame(&[(0.0, 0.0), (1e6, 1e6)]);
    let few = svg(&page);
    // All within one pixel.
    let crowd: Vec<_> = (0..5000).map(|_| (random.unit(), random.unit())).collect();
    producer.frame(&crowd);
    assert!(svg(&page) < few + 3000, "{} after {few}", svg(&page));
    page.daemon.stop();
}

#[test]
fn questions_that_make_no_sense_say_why() {
    let page = with_square("cam");
    for (query, words) in [
        ("?k=0", "k is a number from 1"),
        ("?alpha=-1", "alpha is a radius"),
        ("?alpha=1&k=1", "different views"),
        ("?format=png", "json, geojson, svg"),
        ("?color=red", "\"color\" cannot be requested"),
        ("?k=%", "two digits"),
    ] {
        page.get(&path("cam", query)).is_refused(400, words);
    }
    page.get(&path("%C3", "")).is_refused(400, "UTF-8");
    page.get(&path("dog", "")).is_refused(404, "no stream \"dog\"");
    let empty = hopes_protocol::Open { ..open("empty") };
    let _producer = crate::common::peers::Producer::open(page.daemon.client(), empty);
    page.get(&path("empty", "")).is_refused(404, "no frame yet");
    page.daemon.stop();
}

/// What the page says of a stream that shows nothing.
#[test]
fn points_that_wait_for_a_commit_are_told_from_no_points() {
    let page = Page::start("");
    let mut producer = page.daemon.producer("cam");
    let of_stream = || {
        let stream = page.get("/api/streams").json()["streams"][0].clone();
        ["accepted", "refused", "waiting"]
            .map(|key| stream[key].as_u64().unwrap())
            .into_iter()
            .chain(stream["info"]["frame"].as_u64())
            .collect::<Vec<_>>()
    };
    assert_eq!(of_stream(), [0, 0, 0, 0], "no points");
    let batch = producer.batch(&[(0.0, 0.0), (1.0, 0.0)]);
    producer.is_accepted(batch, 2);
    assert_eq!(of_stream(), [2, 0, 0, 0], "points that wait for a commit");
    let commit = producer.commit();
    producer.is_committed(commit);
    assert_eq!(of_stream(), [2, 0, 0, 1], "a frame");
    page.daemon.stop();
    let mut running = hopes("serve --view 127.0.0.1:0").start();
    let host = super::page::listening_page(&mut running);
    running.say("0,0\n3,0\n");
    eventually("points of stdin wait too", || {
        let mut client = super::page::HttpClient::at(&host);
        client.send(format!("GET /api/streams HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes());
        let stream = client.reply().unwrap().json()["streams"][0].clone();
        (stream["accepted"] == 2 && stream["info"]["frame"] == 0).then_some(())
    });
    running.signal(rustix::process::Signal::TERM);
    assert_clean_exit(running.finish());
}

#[test]
fn snapshots_of_many_views_cost_later_frames_nothing() {
    let page = with_square("cam");
    let mut producer = page.daemon.producer("cam");
    for l in 1..=40 {
        page.get(&path("cam", &format!("?k=1&l={l}"))).ok();
    }
    let before = page.daemon.stream("cam");
    assert_eq!(before.info.consumers, 0);
    producer.frame(&[(1.0, 1.0)]);
    let newest = page.get(&path("cam", "?full")).json();
    assert_eq!((&newest["frame"], &newest["points"]), (&json!(2), &json!(6)));
    // One skeleton for the frame, whichever snapshots were requested before.
    assert!(page.daemon.stream("cam").computed <= before.computed + 1);
    page.daemon.stop();
}

#[test]
fn the_stream_of_stdin_is_shown_without_listen() {
    let mut running = hopes("serve --view 127.0.0.1:0").start();
    let host = super::page::listening_page(&mut running);
    running.say("0,0\n3,0\n0,4\n\n");
    let ask = |path: &str| {
        let mut client = super::page::HttpClient::at(&host);
        client.send(format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes());
        client.reply().unwrap()
    };
    let shown = eventually("the frame is there", || {
        let answer = ask(&path("default", "?full"));
        (answer.status == 200).then(|| answer.json())
    });
    assert_eq!(shown["points"], 3);
    running.signal(rustix::process::Signal::TERM);
    let finished = assert_clean_exit(running.finish());
    assert!(finished.out.is_empty(), "--output was not given");
}
