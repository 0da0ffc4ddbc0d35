//! Producers that end in the midst of a frame, and frames of several producers.

use hopes_protocol::*;

use super::scene::assert_ends_well;
use crate::common::peers::{Daemon, FULL, Producer, open};
use crate::common::process::eventually;

fn cam(daemon: &Daemon) -> Producer {
    Producer::open(daemon.client(), Open { window: Some(Window::Frames(1)), ..open("cam") })
}

/// The x of all points of a frame.
fn xs(mirror: &Mirror) -> Vec<f64> {
    let mut xs: Vec<f64> = mirror.vertices().values().map(|at| at.0).collect();
    xs.sort_by(f64::total_cmp);
    xs
}

#[test]
fn what_a_producer_has_not_committed_joins_no_other_frame() {
    let daemon = Daemon::start("");
    let (mut whole, mut torn) = (cam(&daemon), cam(&daemon));
    let mut consumer = daemon.consumer("cam", FULL);
    let batch = torn.batch(&[(10.0, 0.0), (11.0, 0.0)]);
    torn.is_accepted(batch, 2);
    // While it is there ..
    let frame = whole.frame(&[(1.0, 0.0), (2.0, 0.0)]);
    consumer.follow_to(frame);
    assert_eq!(xs(&consumer.mirror), [1.0, 2.0]);
    // .. and when it is gone.
    drop(torn);
    eventually("it is gone", || (daemon.stream("cam").info.producers == 1).then_some(()));
    let frame = whole.frame(&[(3.0, 0.0)]);
    consumer.follow_to(frame);
    assert_eq!(xs(&consumer.mirror), [3.0]);
    assert_eq!(daemon.stream("cam").info.points, 1);
    assert_ends_well(daemon, None);
}

#[test]
fn frames_of_two_producers_do_not_mix() {
    let daemon = Daemon::start("");
    let mut producers = [cam(&daemon), cam(&daemon)];
    let mut consumer = daemon.consumer("cam", FULL);
    // Both send their frames in halves, one after the other.
    for round in 0..20 {
        let at = |producer: usize, point: usize| (f64::from(round) + 0.25 * producer as f64, point as f64);
        for point in 0..2 {
            for (number, producer) in producers.iter_mut().enumerate() {
                let batch = producer.batch(&[at(number, point)]);
                producer.is_accepted(batch, 1);
            }
        }
        for (number, producer) in producers.iter_mut().enumerate() {
            let commit = producer.commit();
            let frame = producer.is_committed(commit);
            consumer.follow_to(frame);
            assert_eq!(xs(&consumer.mirror), [at(number, 0).0, at(number, 1).0]);
        }
    }
    assert_ends_well(daemon, None);
}

#[test]
fn a_producer_that_closes_without_a_commit_leaves_nothing_and_one_that_ends_the_stream_commits() {
    let daemon = Daemon::start("");
    let (mut first, mut second) = (cam(&daemon), cam(&daemon));
    let mut consumer = daemon.consumer("cam", FULL);
    let batch = first.batch(&[(1.0, 0.0)]);
    first.is_accepted(batch, 1);
    assert_eq!(first.close(false), 0);
    let batch = second.batch(&[(2.0, 0.0)]);
    second.is_accepted(batch, 1);
    assert_eq!(second.close(true), 1);
    consumer.follow_to(1);
    assert_eq!(xs(&consumer.mirror), [2.0]);
    let finished = assert_ends_well(daemon, None);
    assert!(finished.err.contains("1 points are left out"), "{}", finished.err);
}

#[test]
fn a_signal_publishes_no_half_of_a_frame() {
    for options in ["", "--output jsonl"] {
        let mut daemon = Daemon::start(options);
        let mut producer = daemon.producer("default");
        producer.frame(&[(0.0, 0.0), (1.0, 0.0)]);
        let batch = producer.batch(&[(2.0, 0.0)]);
        producer.is_accepted(batch, 1);
        if !options.is_empty() {
            assert!(daemon.running.line().unwrap().contains("\"frame\":1,"));
        }
        daemon.running.signal(rustix::process::Signal::TERM);
        if !options.is_empty() {
            assert_eq!(daemon.running.line(), None);
        }
        let finished = daemon.running.ends();
        assert!(finished.err.contains("SIGTERM: stream \"default\" stopped after frame 1"), "{}", finished.err);
    }
}
