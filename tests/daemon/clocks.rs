//! Windows of time as producers see them: commits date points, and a wrong clock hurts its own producer only.

use hopes_protocol::*;

use crate::common::peers::{Daemon, FULL, Point, Producer, open};

fn timed(daemon: &Daemon, length: f64) -> Producer {
    Producer::open(daemon.client(), Open { window: Some(Window::Time(length)), ..open("cam") })
}

/// Commits with a time. Returns the number of the frame.
fn commit(producer: &mut Producer, time: Option<f64>) -> u64 {
    producer.sequence += 1;
    let sequence = producer.sequence;
    producer.client.send(Producer::CHANNEL, Commit { sequence, time });
    producer.is_committed(sequence)
}

/// Points of one place each, in a row.
fn row(y: f64, count: u32) -> Vec<Point> {
    (0..count).map(|x| (f64::from(x), y)).collect()
}

/// Sends points without a time, and a commit with one.
fn frame(producer: &mut Producer, points: &[Point], time: f64) -> u64 {
    let sequence = producer.batch(points);
    producer.is_accepted(sequence, points.len());
    commit(producer, Some(time))
}

/// Sends points of one time. Returns the answer.
fn send(producer: &mut Producer, points: &[Point], time: f64) -> Message {
    producer.sequence += 1;
    let (sequence, times) = (producer.sequence, vec![time; points.len()]);
    producer.client.ask(Producer::CHANNEL, Batch { sequence, points: points.to_vec(), times, tags: Vec::new() })
}

#[test]
fn a_commit_dates_the_points_of_its_frame() {
    let daemon = Daemon::start("");
    let mut producer = timed(&daemon, 2.5);
    let mut consumer = daemon.consumer("cam", FULL);
    for (number, points) in [(1, 20), (2, 40), (3, 60), (4, 60), (5, 60)] {
        let time = number as f64;
        assert_eq!(frame(&mut producer, &row(time, 20), time), number);
        if number == 1 {
            consumer.expect_snapshot(Cause::Start);
        } else {
            consumer.expect_diff(number);
        }
        let shown = consumer.mirror.frame().unwrap();
        assert_eq!((shown.time, shown.points, shown.rejected), (Some(time), points, 0), "frame {number}");
        let oldest = consumer.mirror.vertices().values().map(|&(_, y)| y).fold(f64::MAX, f64::min);
        assert_eq!(oldest, (time - 2.0).max(1.0));
    }
    daemon.stop();
}

#[test]
fn points_for_which_no_time_is_known_are_refused_at_their_commit() {
    let daemon = Daemon::start("");
    let mut producer = timed(&daemon, 10.0);
    let mut consumer = daemon.consumer("cam", FULL);
    let sequence = producer.batch(&row(0.0, 3));
    producer.is_accepted(sequence, 3);
    commit(&mut producer, None);
    consumer.expect_snapshot(Cause::Start);
    let shown = consumer.mirror.frame().unwrap();
    assert_eq!((shown.points, shown.rejected, shown.time), (0, 3, None));
    let finished = daemon.stop();
    let says = "3 points are refused at their producer's commit: the point has no event time";
    assert!(finished.err.contains(says), "{}", finished.err);
}

#[test]
fn a_wrong_clock_loses_its_own_points_only() {
    let daemon = Daemon::start("");
    let (mut honest, mut wrong) = (timed(&daemon, 10.0), timed(&daemon, 10.0));
    let mut consumer = daemon.consumer("cam", FULL);
    frame(&mut honest, &row(0.0, 30), 100.0);
    consumer.expect_snapshot(Cause::Start);
    let mut refused = 0;
    for number in 1..6_u32 {
        let answer = send(&mut wrong, &row(f64::from(number) + 0.5, 30), 1e9 + f64::from(number));
        match (number, answer) {
            (1, Message::Accepted(accepted)) => {
                assert_eq!(accepted.points, 30);
                refused += 30;
            }
            (1, answer) => panic!("the commit may confirm it: {answer:?}"),
            (_, Message::Refused(answer)) => {
                assert_eq!((answer.accepted, answer.refused), (0, 30));
                assert_eq!(answer.reasons[0].code, RefusalCode::TooLate as u16);
                let text = &answer.reasons[0].text;
                assert!(text.contains("too far ahead of 10") && text.contains("another producer"), "{text}");
                refused += 30;
            }
            (_, answer) => panic!("{answer:?}"),
        }
        let of_wrong = commit(&mut wrong, None);
        assert_eq!(consumer.expect_diff(of_wrong).frame.rejected, 30);
        let of_honest = frame(&mut honest, &row(f64::from(number), 30), 100.0 + f64::from(number));
        let shown = consumer.expect_diff(of_honest).frame;
        assert_eq!((shown.rejected, shown.points), (0, 30 * u64::from(number + 1)));
        assert_eq!(shown.time, Some(100.0 + f64::from(number)));
    }
    let stream = daemon.stream("cam");
    assert_eq!((stream.accepted + stream.refused, refused), (330, 150), "each point is answered once");
    let finished = daemon.stop();
    assert_eq!(finished.err.matches("a producer is outside the time window").count(), 1, "{}", finished.err);
}

#[test]
fn a_second_producer_confirms_a_step_back_and_the_window_starts_anew() {
    let daemon = Daemon::start("");
    let (mut one, mut other) = (timed(&daemon, 10.0), timed(&daemon, 10.0));
    let mut consumer = daemon.consumer("cam", FULL);
    // The first time of all is wild.
    frame(&mut one, &row(0.0, 30), 4e9);
    consumer.expect_snapshot(Cause::Start);
    frame(&mut one, &row(1.0, 30), 100.0);
    let shown = consumer.expect_diff(2).frame;
    assert_eq!((shown.points, shown.rejected, shown.time), (30, 30, Some(4e9)));
    frame(&mut other, &row(2.0, 5), 101.0);
    let shown = consumer.expect_diff(3).frame;
    assert_eq!((shown.points, shown.rejected, shown.time), (5, 0, Some(101.0)));
    frame(&mut one, &row(3.0, 5), 102.0);
    let shown = consumer.expect_diff(4).frame;
    assert_eq!((shown.points, shown.rejected, shown.time), (10, 0, Some(102.0)));
    let finished = daemon.stop();
    assert!(finished.err.contains("the time window starts anew: 4000000000 was believed, now 101"), "{}", finished.err);
}

#[test]
fn a_producer_alone_recovers_by_itself_and_one_that_is_gone_has_no_say() {
    let daemon = Daemon::start("");
    let mut wrong = timed(&daemon, 10.0);
    let mut consumer = daemon.consumer("cam", FULL);
    frame(&mut wrong, &row(0.0, 20), 4e9);
    consumer.expect_snapshot(Cause::Start);
    wrong.close(false);
    let mut producer = timed(&daemon, 10.0);
    let rejected: Vec<u64> = (1..4)
        .map(|number| {
            let frame = frame(&mut producer, &row(f64::from(number), 20), 100.0 + f64::from(number));
            consumer.expect_diff(frame).frame.rejected
        })
        .collect();
    assert_eq!(rejected, [20, 0, 0]);
    assert_eq!(consumer.mirror.frame().unwrap().points, 40);
    // A pause that is longer than the window.
    let frame = frame(&mut producer, &row(9.0, 20), 9000.0);
    let shown = consumer.expect_diff(frame).frame;
    assert_eq!((shown.points, shown.rejected, shown.time), (20, 0, Some(9000.0)));
    daemon.stop();
}

#[test]
fn a_stream_that_closes_its_frames_dates_points_by_the_newest_time() {
    let daemon = Daemon::start("--stream cam:window=time:10,frame-points=4");
    let mut producer = daemon.producer("cam");
    let mut consumer = daemon.consumer("cam", FULL);
    let sequence = producer.batch(&row(0.0, 3));
    producer.is_accepted(sequence, 3);
    send(&mut producer, &[(9.0, 9.0)], 5.0);
    consumer.expect_snapshot(Cause::Start);
    let shown = consumer.mirror.frame().unwrap();
    assert_eq!((shown.points, shown.time, shown.rejected), (4, Some(5.0), 0));
    // A commit with a time dates what all have sent, and a frame is not closed twice.
    let mut other = daemon.producer("cam");
    let sequence = producer.batch(&row(1.0, 2));
    producer.is_accepted(sequence, 2);
    let sequence = other.batch(&row(2.0, 1));
    other.is_accepted(sequence, 1);
    assert_eq!(commit(&mut other, Some(14.0)), 2);
    let shown = consumer.expect_diff(2).frame;
    assert_eq!((shown.points, shown.time), (7, Some(14.0)));
    assert_eq!(commit(&mut other, Some(15.5)), 3);
    let shown = consumer.expect_diff(3).frame;
    assert_eq!((shown.points, shown.time), (3, Some(15.5)), "those of 5 have left, those of 14 have not");
    daemon.stop();
}
