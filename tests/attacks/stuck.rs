//! A reader of stdout that reads nothing: it stalls the stream that is shown, and nothing else.

use hopes_protocol::*;

use super::scene::assert_ends_well;
use crate::common::peers::{Daemon, FULL, Producer, ProducerAndConsumer, points};
use crate::common::random::Random;

/// Sends frames until the stream stalls: more than pipes and queues hold.
fn stall(producer: &mut Producer) {
    let mut random = Random::new(9);
    for _ in 0..40 {
        producer.batch(&points(&mut random, 1_000));
        producer.commit();
    }
}

#[test]
fn other_streams_and_readers_are_served() {
    let daemon = Daemon::start("--output jsonl --full");
    let mut producer = daemon.producer("default");
    stall(&mut producer);
    ProducerAndConsumer::new(&daemon, "beside").step();
    // The stream itself is still there for readers, at the frame that stdout has not taken.
    let mut consumer = daemon.consumer("default", FULL);
    let frame = consumer.expect_snapshot(Cause::Start);
    assert!(frame > 0 && frame < 40, "frame {frame}");
    let finished = assert_ends_well(daemon, None);
    assert_eq!(finished.code, Some(1), "{}", finished.err);
    assert!(finished.err.contains("the reader of stdout took nothing"), "{}", finished.err);
}

#[test]
fn a_reader_that_goes_on_gets_all_frames() {
    let mut daemon = Daemon::start("--output jsonl --full");
    let mut producer = daemon.producer("default");
    stall(&mut producer);
    ProducerAndConsumer::new(&daemon, "beside").step();
    for frame in 1..=40 {
        let line = daemon.running.line().expect("a line for each frame");
        assert!(line.contains(&format!("\"frame\":{frame},")), "{}", &line[..100]);
    }
    assert_eq!(assert_ends_well(daemon, None).code, Some(0));
}
