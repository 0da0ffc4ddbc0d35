//! Refused points: which, why, and what happens to the others; windows; retracted points.

use hopes_protocol::*;

use crate::common::peers::{Consumer, Daemon, FULL, Point, Producer, open};

/// Sends a batch with times and tags. Returns the answer.
fn answered(producer: &mut Producer, points: &[Point], times: &[f64], tags: &[u64]) -> Message {
    producer.sequence += 1;
    let (sequence, points) = (producer.sequence, points.to_vec());
    producer.client.ask(Producer::CHANNEL, Batch { sequence, points, times: times.to_vec(), tags: tags.to_vec() })
}

/// Accepted points, refused points, index and code of each refusal, and tags with vertices.
type Outcome = (u32, u32, Vec<(u32, u16)>, Vec<(u64, u64)>);

fn outcome(answer: Message) -> Outcome {
    match answer {
        Message::Accepted(Accepted { points, placed, .. }) => (points, 0, Vec::new(), placed),
        Message::Refused(Refused { accepted, refused, reasons, placed, .. }) => {
            assert!(reasons.iter().all(|reason| !reason.text.is_empty()));
            let reasons = reasons.into_iter().map(|reason| (reason.index, reason.code)).collect();
            (accepted, refused, reasons, placed)
        }
        other => panic!("{other:?} is no answer to a batch"),
    }
}

fn windowed(daemon: &Daemon, window: Window) -> Producer {
    Producer::open(daemon.client(), Open { window: Some(window), ..open("cam") })
}

fn seen(consumer: &Consumer) -> Vec<Point> {
    consumer.mirror.vertices().values().copied().collect()
}

#[test]
fn each_refused_point_is_named_and_the_others_are_placed() {
    let daemon = Daemon::start("");
    let mut producer = daemon.producer("cam");
    let mut consumer = daemon.consumer("cam", FULL);
    let points = [(0.0, 0.0), (f64::NAN, 0.0), (1.0, 0.0), (0.0, f64::NEG_INFINITY), (1.0, 0.0), (1e300, 0.0)];
    let coordinate = RefusalCode::Coordinate as u16;
    let (accepted, refused, reasons, placed) =
        outcome(answered(&mut producer, &points, &[], &[70, 71, 72, 73, 74, 75]));
    assert_eq!((accepted, refused), (3, 3));
    assert_eq!(reasons, [(1, coordinate), (3, coordinate), (5, coordinate)]);
    let [(70, first), (72, second), (74, again)] = placed[..] else { panic!("{placed:?}") };
    assert!(second == again && first != second, "one position is one vertex");
    // -0 equals 0, and tags may be any number.
    let (.., placed) = outcome(answered(&mut producer, &[(-0.0, 0.0), (1.0, -0.0)], &[], &[u64::MAX, 0]));
    assert_eq!(placed, [(u64::MAX, first), (0, second)]);
    let commit = producer.commit();
    producer.is_committed(commit);
    consumer.expect_snapshot(Cause::Start);
    let ids: Vec<u64> = consumer.mirror.vertices().keys().copied().collect();
    assert_eq!(ids, [first, second]);
    let frame = consumer.mirror.frame().unwrap();
    assert_eq!((frame.points, frame.vertices, frame.rejected), (5, 2, 3));
    let stream = daemon.stream("cam");
    assert_eq!((stream.accepted, stream.refused, stream.info.points), (5, 3, 5));
    daemon.stop();
}

#[test]
fn the_first_thousand_refusals_are_listed_and_all_are_counted() {
    let daemon = Daemon::start("");
    let mut producer = daemon.producer("cam");
    let points: Vec<Point> =
        (0..2500).map(|at| if at % 5 == 0 { (f64::from(at), 0.0) } else { (0.0, f64::NAN) }).collect();
    let (accepted, refused, reasons, placed) = outcome(answered(&mut producer, &points, &[], &[]));
    assert_eq!((accepted, refused, reasons.len()), (500, 2000, LISTED_REFUSALS));
    let expected = (0..2500).filter(|at| at % 5 != 0).take(LISTED_REFUSALS);
    assert!(reasons.iter().map(|(index, _)| *index).eq(expected));
    assert_eq!(placed, []);
    assert_eq!(daemon.stream("cam").refused, 2000);
    daemon.stop();
}

#[test]
fn points_that_are_not_there_cannot_be_retracted() {
    let daemon = Daemon::start("");
    let mut producer = daemon.producer("cam");
    let mut consumer = daemon.consumer("cam", FULL);
    producer.frame(&[(0.0, 0.0), (0.0, 0.0), (1.0, 0.0)]);
    consumer.expect_snapshot(Cause::Start);
    producer.retract(&[(0.0, 0.0), (2.0, 0.0), (f64::NAN, 0.0), (1.0, 0.0), (1.0, 0.0)]);
    let (accepted, refused, reasons, _) = outcome(producer.answer());
    assert_eq!((accepted, refused), (2, 3));
    assert_eq!(reasons.iter().map(|(index, _)| *index).collect::<Vec<_>>(), [1, 2, 4]);
    assert_eq!((reasons[0].1, reasons[2].1), (RefusalCode::NotThere as u16, RefusalCode::NotThere as u16));
    let commit = producer.commit();
    producer.is_committed(commit);
    let diff = consumer.expect_diff(2);
    assert_eq!((diff.frame.points, diff.frame.rejected), (1, 3));
    assert_eq!(seen(&consumer), [(0.0, 0.0)], "of two points at one place one is still there");
    let retraction = producer.retract(&[(0.0, 0.0)]);
    producer.is_accepted(retraction, 1);
    let commit = producer.commit();
    producer.is_committed(commit);
    consumer.expect_diff(3);
    assert_eq!(consumer.mirror.checksum(), 0, "nothing is left");
    daemon.stop();
}

#[test]
fn times_and_tags_are_none_or_one_for_each_point() {
    let daemon = Daemon::start("");
    let mut producer = daemon.producer("cam");
    for (times, tags) in [(&[1.0][..], &[][..]), (&[], &[1]), (&[1.0; 3], &[1, 2]), (&[1.0, 2.0], &[1, 2, 3])] {
        match answered(&mut producer, &[(0.0, 0.0), (1.0, 0.0)], times, tags) {
            Message::Error(report) => {
                assert_eq!((report.code, report.answers), (ErrorCode::Unreadable as u16, 0x0103), "{report:?}");
            }
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(producer.frame(&[]), 1, "a batch may be empty, and the channel goes on");
    assert_eq!(daemon.stream("cam").info.points, 0, "nothing of those was taken");
    daemon.stop();
}

#[test]
fn a_time_window_refuses_missing_and_late_times() {
    let daemon = Daemon::start("");
    let mut producer = windowed(&daemon, Window::Time(10.0));
    let mut consumer = daemon.consumer("cam", FULL);
    let refused = |answer: Message| outcome(answer).2;
    // A point without a time waits for one.
    assert_eq!(refused(answered(&mut producer, &[(0.0, 0.0)], &[], &[])), []);
    let answer = answered(
        &mut producer,
        &[(1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (4.0, 0.0)],
        &[7.0, f64::NAN, f64::INFINITY, 16.5],
        &[],
    );
    let not_finite = RefusalCode::TimeNotFinite as u16;
    assert_eq!(refused(answer), [(1, not_finite), (2, not_finite)]);
    let answer = answered(&mut producer, &[(5.0, 0.0), (6.0, 0.0)], &[6.0, 7.0], &[]);
    assert_eq!(refused(answer), [(0, RefusalCode::TooLate as u16)]);
    assert_eq!(refused(answered(&mut producer, &[(7.0, 0.0)], &[], &[])), []);
    let commit = producer.commit();
    producer.is_committed(commit);
    consumer.expect_snapshot(Cause::Start);
    assert_eq!(seen(&consumer), [(0.0, 0.0), (1.0, 0.0), (4.0, 0.0), (6.0, 0.0), (7.0, 0.0)]);
    let frame = consumer.mirror.frame().unwrap();
    assert_eq!((frame.time, frame.rejected), (Some(16.5), 3));
    // The time of a commit advances the window too.
    producer.client.send(Producer::CHANNEL, Commit { sequence: 99, time: Some(20.0) });
    assert_eq!(producer.is_committed(99), 2);
    assert_eq!(consumer.expect_diff(2).frame.time, Some(20.0));
    assert_eq!(seen(&consumer), [(0.0, 0.0), (4.0, 0.0), (7.0, 0.0)], "those without a time are of 16.5");
    daemon.stop();
}

#[test]
fn windows_of_points_and_of_frames_remove_the_oldest() {
    for (window, expected) in [
        (Window::Points(3), vec![(2.0, 0.0), (3.0, 0.0), (4.0, 0.0)]),
        (Window::Frames(1), vec![(3.0, 0.0), (4.0, 0.0)]),
        (Window::All, (0..5).map(|x| (f64::from(x), 0.0)).collect()),
    ] {
        let daemon = Daemon::start("");
        let mut producer = windowed(&daemon, window);
        let mut consumer = daemon.consumer("cam", FULL);
        assert_eq!(consumer.opened.window, window);
        producer.frame(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]);
        consumer.expect_snapshot(Cause::Start);
        producer.frame(&[(3.0, 0.0), (4.0, 0.0)]);
        consumer.expect_diff(2);
        assert_eq!(seen(&consumer), expected, "{window:?}");
        daemon.stop();
    }
}

#[test]
fn a_resolution_merges_near_points() {
    let daemon = Daemon::start("");
    let mut producer = Producer::open(daemon.client(), Open { resolution: Some(1.0), ..open("cam") });
    let mut consumer = daemon.consumer("cam", FULL);
    assert_eq!(consumer.opened.resolution, Some(1.0));
    producer.frame(&[(0.1, -0.2), (-0.3, 0.4), (1.9, 0.0)]);
    consumer.expect_snapshot(Cause::Start);
    assert_eq!(seen(&consumer), [(0.0, 0.0), (2.0, 0.0)]);
    daemon.stop();
}
