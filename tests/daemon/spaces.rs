//! Streams of points in R^d: what producers may send, what consumers receive, compared with the library on the same
//! points, and what clients of older versions are told.

use std::num::{NonZeroU32, NonZeroU64};

use hopes::topology::spaces::Metric as OfCore;
use hopes::topology::{self, SpaceOptions, SpacePipeline, SpaceTracker, TrackOptions, TrackRule, ViewSpec};
use hopes_protocol::*;

use crate::common::client::Client;
use crate::common::peers::{DERIVED, Daemon, FULL, open, points, subscribe};
use crate::common::random::Random;

fn open_space(name: &str) -> OpenSpace {
    OpenSpace { name: name.to_owned(), window: None, resolution: None, metric: None, dimension: None }
}

fn opened(client: &mut Client, channel: u32, open: OpenSpace) -> SpaceOpened {
    match client.ask(channel, open) {
        Message::SpaceOpened(opened) => opened,
        other => panic!("SpaceOpened is due, not {other:?}"),
    }
}

fn batch(sequence: u64, dimension: u32, coordinates: &[f64]) -> SpaceBatch {
    SpaceBatch { sequence, dimension, coordinates: coordinates.to_vec(), times: vec![], tags: vec![] }
}

fn cloud(random: &mut Random, dimension: usize, count: usize) -> Vec<f64> {
    points(random, (count * dimension).div_ceil(2))
        .into_iter()
        .flat_map(|(x, y)| [x, y])
        .take(count * dimension)
        .collect()
}

/// Sends points and a commit, which are accepted.
fn frame(client: &mut Client, sequence: u64, dimension: u32, coordinates: &[f64]) -> u64 {
    client.send(1, batch(sequence, dimension, coordinates));
    client.send(1, Commit { sequence: sequence + 1, time: None });
    assert!(matches!(client.receive_on(1), Message::Accepted(_)));
    let Message::Committed(committed) = client.receive_on(1) else { panic!("Committed is due") };
    committed.frame
}

/// The frame of a message, proved by a mirror.
fn follow(mirror: &mut SpaceMirror, message: &Message) -> Cause {
    match message {
        Message::SpaceSnapshot(snapshot) => {
            mirror.apply_space_snapshot(snapshot).unwrap();
            snapshot.cause
        }
        Message::SpaceDiff(diff) => {
            mirror.apply_space_diff(diff).unwrap();
            Cause::Start
        }
        other => panic!("a frame of a space is due, not {other:?}"),
    }
}

/// What the library says of the same points.
fn assert_same(mirror: &SpaceMirror, frame: &topology::Frame, view: ViewSpec) {
    let snapshot = topology::Snapshot::new(&frame.skeleton, &frame.view(view));
    let vertices = frame.skeleton.vertices().iter();
    let held = mirror.vertices().iter().map(|(&id, point)| (id, point.to_vec()));
    assert!(vertices.map(|(id, point)| (id.0, point.to_vec())).eq(held));
    assert_eq!(mirror.checksum(), snapshot.checksum().0);
}

#[test]
fn consumers_receive_what_the_library_computes() {
    let metrics = [
        (Metric::Euclidean, OfCore::Euclidean, 3),
        (Metric::Manhattan, OfCore::Manhattan, 1),
        (Metric::Chebyshev, OfCore::Chebyshev, 7),
        (Metric::Angular, OfCore::Angular, 4),
        (Metric::Haversine, OfCore::Haversine, 2),
    ];
    let (daemon, mut random) = (Daemon::start("--check"), Random::new(17));
    for (metric, of_core, dimension) in metrics {
        let window = Some(Window::Points(60));
        let name = metric.name();
        let mut producer = daemon.client();
        let made = opened(&mut producer, 1, OpenSpace { window, metric: Some(metric), ..open_space(name) });
        let known = (metric == Metric::Haversine).then_some(2);
        assert_eq!((made.metric, made.dimension, made.max_vertices), (metric, known, 4096));
        assert!(made.opened.created);
        let mut consumers: Vec<(Client, SpaceMirror, ViewSpec)> =
            [(FULL, ViewSpec::Full), (DERIVED, ViewSpec::default())]
                .map(|(view, spec)| {
                    let mut client = daemon.client();
                    let dots = DotsWanted::Top(5);
                    client.send(1, Subscribe { dots, ..subscribe(name, view) });
                    assert!(matches!(client.receive_on(1), Message::StreamOpened(_)));
                    (client, SpaceMirror::default(), spec)
                })
                .into();
        let options = SpaceOptions {
            metric: of_core,
            window: topology::Window::Points(NonZeroU64::new(60).unwrap()),
            ..SpaceOptions::default()
        };
        let mut pipeline = SpacePipeline::new(options).unwrap();
        let mut before = None;
        for number in 1..=6 {
            let coordinates = cloud(&mut random, dimension, 25);
            for point in coordinates.chunks_exact(dimension) {
                pipeline.feed_point(point, None).unwrap();
            }
            pipeline.commit(None);
            let of_library = pipeline.poll_frame().expect("a frame was committed");
            assert_eq!(frame(&mut producer, 2 * number, dimension as u32, &coordinates), number);
            let ranking = pipeline.poll_dots(5);
            // In place of dots that did not change comes a heartbeat.
            let now = Some((ranking.total, ranking.dots.clone()));
            let is_new = now != before;
            before = now;
            for (client, mirror, view) in &mut consumers {
                follow(mirror, &client.receive_on(1));
                assert_eq!(mirror.number(), number);
                let shape = Place { metric: Some(metric), dimension: dimension as u32 };
                assert_eq!(mirror.place(), shape);
                assert_same(mirror, &of_library, *view);
                if !is_new {
                    continue;
                }
                let Message::SpaceDots(dots) = client.receive_on(1) else { panic!("dots are due") };
                assert_eq!((dots.frame, dots.total), (number, ranking.total as u64));
                for (dot, ranked) in dots.dots.iter().zip(&ranking.dots) {
                    assert_eq!((dot.birth, dot.death), (ranked.critical.birth, Some(ranked.critical.death)));
                    assert_eq!(dot.death_edge, ranked.death_edge.map(|[a, b]| (a.0, b.0)));
                    assert!(dot.death_edge.is_some(), "every cycle of a whole filtration is filled");
                }
            }
        }
        assert_eq!(daemon.stream(name).info.vertices, 60);
    }
    daemon.stop();
}

#[test]
fn retracted_points_leave_and_the_rest_is_refused_with_its_reason() {
    let daemon = Daemon::start("--max-vertices 5");
    let mut client = daemon.client();
    assert_eq!(opened(&mut client, 1, open_space("s")).max_vertices, 5);
    frame(&mut client, 1, 3, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0]);
    client.send(1, SpaceRetract { sequence: 3, dimension: 3, coordinates: vec![1.0, 1.0, 0.0, 9.0, 9.0, 9.0] });
    let Message::Refused(refused) = client.receive_on(1) else { panic!("one of them is not there") };
    assert_eq!(
        refused.reasons.iter().map(|refusal| (refusal.index, refusal.code)).collect::<Vec<_>>(),
        [(1, RefusalCode::NotThere as u16)]
    );
    let coordinates = [f64::NAN, 0.0, 0.0, 2.0, 0.0, 0.0, 3.0, f64::INFINITY, 0.0, 3.0, 0.0, 0.0];
    client.send(1, batch(4, 3, &coordinates));
    let Message::Refused(refused) = client.receive_on(1) else { panic!("two of them cannot be") };
    assert_eq!(refused.reasons.iter().map(|refusal| refusal.index).collect::<Vec<_>>(), [0, 2]);
    client.send(1, Commit { sequence: 5, time: None });
    assert!(matches!(client.receive_on(1), Message::Committed(_)));
    assert_eq!(daemon.stream("s").info.vertices, 4);
    // The fifth fits, the sixth does not: that shows at the commit, before which others may leave.
    assert_eq!(frame(&mut client, 6, 3, &[4.0, 0.0, 0.0, 5.0, 0.0, 0.0]), 3);
    assert_eq!(daemon.stream("s").info.vertices, 5);
    let finished = daemon.stop();
    assert!(finished.err.contains("1 points are refused at their producer's commit"), "{}", finished.err);
    assert!(finished.err.contains("raise max-vertices"), "{}", finished.err);
}

#[test]
fn messages_that_do_not_fit_a_stream_are_answered_and_the_channel_stays_open() {
    let daemon = Daemon::start("--stream plane --stream space:metric=manhattan,dimension=3,window=points:9");
    let (bad, other, unreadable) =
        (ErrorCode::BadOptions as u16, ErrorCode::OtherSpace as u16, ErrorCode::Unreadable as u16);
    let mut client = daemon.client();
    assert_eq!(client.is_refused(1, open("space")), other);
    assert_eq!(client.is_refused(1, open_space("plane")), other);
    for wrong in [
        OpenSpace { metric: Some(Metric::Euclidean), ..open_space("space") },
        OpenSpace { dimension: Some(2), ..open_space("space") },
        OpenSpace { window: Some(Window::All), ..open_space("space") },
    ] {
        assert_eq!(client.is_refused(1, wrong), ErrorCode::OtherOptions as u16);
    }
    for (metric, dimension) in
        [(None, 0), (None, 4097), (None, u32::MAX), (Some(Metric::Haversine), 3), (Some(Metric::Haversine), 1)]
    {
        let open = OpenSpace { metric, dimension: Some(dimension), ..open_space("new") };
        assert_eq!(client.is_refused(1, open), bad, "{dimension}");
    }
    let there = opened(&mut client, 1, open_space("space"));
    assert_eq!((there.metric, there.dimension, there.opened.created), (Metric::Manhattan, Some(3), false));
    assert_eq!(there.opened.window, Window::Points(9));
    assert_eq!(
        client.is_refused(1, Batch { sequence: 1, points: vec![(0.0, 0.0)], times: vec![], tags: vec![] }),
        other
    );
    assert_eq!(client.is_refused(1, Retract { sequence: 1, points: vec![(0.0, 0.0)] }), other);
    assert_eq!(client.is_refused(1, batch(1, 3, &[0.0; 4])), unreadable);
    assert_eq!(client.is_refused(1, batch(1, 2, &[0.0; 4])), bad);
    assert_eq!(client.is_refused(1, batch(1, 0, &[])), bad);
    assert_eq!(client.is_refused(1, batch(1, 4097, &[])), bad);
    assert_eq!(client.is_refused(1, SpaceBatch { times: vec![1.0], ..batch(1, 3, &[0.0; 6]) }), unreadable);
    assert_eq!(client.is_refused(1, SpaceBatch { tags: vec![1], ..batch(1, 3, &[0.0; 6]) }), unreadable);
    assert_eq!(client.is_refused(1, SpaceRetract { sequence: 1, dimension: 3, coordinates: vec![0.0; 5] }), unreadable);
    assert_eq!(frame(&mut client, 1, 3, &[0.0, 1.0, 2.0]), 1, "the channel stays open");
    assert!(matches!(client.ask(2, open("plane")), Message::Opened(_)));
    assert_eq!(client.is_refused(2, batch(1, 2, &[0.0; 2])), other);
    assert_eq!(client.is_refused(2, SpaceRetract { sequence: 1, dimension: 2, coordinates: vec![0.0; 2] }), other);
    assert_eq!(client.is_refused(3, batch(1, 2, &[0.0; 2])), ErrorCode::NoChannel as u16);
    daemon.stop();
}

#[test]
fn the_first_point_settles_the_dimension() {
    let daemon = Daemon::start("");
    let (mut one, mut other) = (daemon.client(), daemon.client());
    let mut consumer = daemon.client();
    assert_eq!(opened(&mut one, 1, open_space("s")).dimension, None);
    assert_eq!(opened(&mut other, 1, open_space("s")).dimension, None);
    let infos = |client: &mut Client| match client.ask(9, ListSpaces {}) {
        Message::Spaces(spaces) => spaces.streams.iter().map(|info| (info.metric, info.dimension)).collect::<Vec<_>>(),
        other => panic!("Spaces is due, not {other:?}"),
    };
    assert_eq!(infos(&mut consumer), [(Metric::Euclidean, None)]);
    // A batch without points settles nothing, and its commit is a frame without a dimension.
    assert_eq!(frame(&mut one, 1, 5, &[]), 1);
    consumer.send(1, subscribe("s", FULL));
    assert!(matches!(consumer.receive_on(1), Message::StreamOpened(_)));
    let mut mirror = SpaceMirror::default();
    follow(&mut mirror, &consumer.receive_on(1));
    assert_eq!(mirror.place().dimension, 0);
    assert_eq!(frame(&mut other, 1, 2, &[1.0, 2.0]), 2);
    follow(&mut mirror, &consumer.receive_on(1));
    assert_eq!((mirror.place().dimension, mirror.vertices().len()), (2, 1));
    assert_eq!(one.is_refused(1, batch(3, 5, &[0.0; 5])), ErrorCode::BadOptions as u16);
    assert_eq!(infos(&mut consumer), [(Metric::Euclidean, Some(2))]);
    assert_eq!(opened(&mut one, 2, OpenSpace { dimension: Some(2), ..open_space("s") }).dimension, Some(2));
    daemon.stop();
}

#[test]
fn a_slow_consumer_gets_merged_diffs_and_one_that_comes_back_resumes() {
    let daemon = Daemon::start("--consumer-queue 1KiB");
    let (mut producer, mut consumer) = (daemon.client(), daemon.client());
    let made = opened(&mut producer, 1, open_space("s"));
    let mut random = Random::new(3);
    frame(&mut producer, 1, 3, &cloud(&mut random, 3, 40));
    consumer.send(1, subscribe("s", FULL));
    assert!(matches!(consumer.receive_on(1), Message::StreamOpened(_)));
    let mut mirror = SpaceMirror::default();
    follow(&mut mirror, &consumer.receive_on(1));
    for number in 2..=6 {
        frame(&mut producer, 2 * number, 3, &cloud(&mut random, 3, 10));
    }
    while mirror.number() < 6 {
        match consumer.receive_on(1) {
            Message::Lagged(_) => {}
            message => drop(follow(&mut mirror, &message)),
        }
    }
    assert_eq!(mirror.vertices().len(), 90);
    drop(consumer);
    frame(&mut producer, 20, 3, &cloud(&mut random, 3, 10));
    let mut again = daemon.client();
    let resume = Some(Resume { epoch: made.opened.epoch, frame: 6 });
    again.send(1, Subscribe { resume, ..subscribe("s", FULL) });
    assert!(matches!(again.receive_on(1), Message::StreamOpened(_)));
    assert!(matches!(again.receive_on(1), Message::Resumed(_)));
    follow(&mut mirror, &again.receive_on(1));
    assert_eq!((mirror.number(), mirror.vertices().len()), (7, 100));
    daemon.stop();
}

#[test]
fn older_clients_are_told_why_they_cannot_follow() {
    let daemon = Daemon::start("--stream flat --stream deep:metric=euclidean");
    let older = || {
        let mut client = Client::without_banner(&daemon.address);
        client.write(&Banner { lowest: 1, highest: 3 }.encode());
        client.banner();
        client.set_version(3);
        let put = |client: &mut Client, channel: u32, message: Message| {
            client.write(&encode(3, channel, &message).unwrap());
        };
        let hello = Hello { software: "an older client".to_owned(), capabilities: Vec::new() };
        put(&mut client, 0, hello.into());
        assert!(matches!(client.receive_on(0), Message::Welcome(_)));
        (client, put)
    };
    let needs = ErrorCode::NeedsVersion as u16;
    let (mut client, put) = older();
    put(&mut client, 1, subscribe("deep", FULL).into());
    let report = client.expect_error_on(1);
    assert_eq!((report.code, report.answers), (needs, 0x0201));
    for words in ["\"deep\"", "R^d", "version 4"] {
        assert!(report.text.contains(words), "{}", report.text);
    }
    // The channel is free: there is no subscription.
    put(&mut client, 1, subscribe("*", FULL).into());
    let mut came = [client.receive_on(1), client.receive_on(1)];
    came.sort_by_key(Message::kind);
    let [Message::Error(report), Message::StreamOpened(opened)] = &came else { panic!("{came:?}") };
    assert_eq!((report.code, report.answers, opened.name.as_str()), (needs, 0, "flat"));
    // One that comes later is told, too, and the subscription goes on.
    let mut producer = daemon.client();
    opened_later(&mut producer);
    let report = client.expect_error_on(1);
    assert_eq!((report.code, report.answers), (needs, 0));
    assert!(report.text.contains("\"later\""), "{}", report.text);
    let mut plane = daemon.producer("flat");
    plane.frame(&[(0.0, 0.0)]);
    assert!(matches!(client.receive_on(1), Message::Snapshot(_)));
    daemon.stop();
}

fn opened_later(client: &mut Client) {
    assert!(opened(client, 1, open_space("later")).opened.created);
}

/// A ring in R^3 whose centre moves along the third axis, with points at other places in every frame.
fn ring(random: &mut Random, frame: u64) -> Vec<f64> {
    let point = |number: u32| {
        let [x, y] = random.point();
        let angle = (f64::from(number) + 0.3 * x) / 40.0 * std::f64::consts::TAU;
        let radius = 2.0 + 0.05 * y;
        [radius * angle.cos(), radius * angle.sin(), 0.1 * frame as f64]
    };
    (0..40).map(point).collect::<Vec<_>>().concat()
}

#[test]
fn tracks_of_a_space_are_those_of_the_library() {
    let daemon = Daemon::start("--track top:1 --track-confirm 2 --track-miss 2");
    let (mut producer, mut consumer) = (daemon.client(), daemon.client());
    let window = Some(Window::Frames(1));
    opened(&mut producer, 1, OpenSpace { window, ..open_space("s") });
    consumer.send(1, subscribe("s", DERIVED));
    consumer.send(1, WantTracks { tracks: TracksWanted::Cycles });
    assert!(matches!(consumer.receive_on(1), Message::StreamOpened(_)));
    let window = topology::Window::Frames(NonZeroU64::MIN);
    let mut pipeline = SpacePipeline::new(SpaceOptions { window, ..SpaceOptions::default() }).unwrap();
    let mut options = TrackOptions::new(TrackRule::Top(NonZeroU32::MIN));
    (options.confirm, options.miss) = (NonZeroU32::new(2).unwrap(), NonZeroU32::new(2).unwrap());
    let mut tracker = SpaceTracker::new(options);
    let (mut random, mut mirror, mut tracks) = (Random::new(5), SpaceMirror::default(), SpaceTrackMirror::default());
    let mut kinds = Vec::new();
    for number in 1..=8 {
        // The ring is gone in the last frames.
        let coordinates = if number <= 5 { ring(&mut random, number) } else { vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0] };
        for point in coordinates.chunks_exact(3) {
            pipeline.feed_point(point, None).unwrap();
        }
        pipeline.commit(None);
        let step = pipeline.poll_tracks(&mut tracker).expect("there is a new frame");
        frame(&mut producer, 2 * number, 3, &coordinates);
        follow(&mut mirror, &consumer.receive_on(1));
        let Message::SpaceTracks(message) = consumer.receive_on(1) else { panic!("tracks are due") };
        tracks.apply(&message).unwrap();
        let alive: Vec<(u64, f64, Vec<f64>, f64)> =
            step.alive.iter().map(|track| (track.id.0, track.birth, track.center.clone(), track.radius)).collect();
        let held: Vec<(u64, f64, Vec<f64>, f64)> =
            tracks.alive().values().map(|track| (track.id, track.birth, track.center.clone(), track.radius)).collect();
        assert_eq!(held, alive, "frame {number}");
        if number > 1 {
            assert_eq!(message.events.len(), step.events.len());
            kinds.extend(message.events.iter().map(|event| event.happening));
        }
        for (id, cycle) in pipeline.track_cycles(&tracker) {
            let walk: Vec<u64> = cycle.iter().map(|vertex| vertex.0).collect();
            assert_eq!(tracks.cycles()[&id.0], std::slice::from_ref(&walk));
            assert!(walk.len() > 10 && walk.iter().all(|vertex| mirror.vertices().contains_key(vertex)));
        }
    }
    let [Happening::Born, rest @ .., Happening::Died] = &kinds[..] else { panic!("{kinds:?}") };
    assert!(rest.iter().all(|kind| matches!(kind, Happening::Updated(_))), "one ring is one track: {kinds:?}");
    assert!(rest.len() >= 2, "it moves");
    daemon.stop();
}
