//! A daemon under attack: what a stream beside the attacked one takes, what the daemon holds, how it ends.

use std::thread;
use std::time::{Duration, Instant};

use hopes_protocol::*;
use rustix::process::Signal;

use crate::common::client::{Client, bytes};
use crate::common::peers::{Consumer, DERIVED, Daemon, Point, Producer, open, points};
use crate::common::process::Finished;
use crate::common::random::Random;

/// What the daemon may take beyond its limit of memory.
const SLACK: u64 = 64 << 20;

/// How long a signal may take to end the daemon.
const PATIENCE: Duration = Duration::from_secs(5);

/// Frames by which a stream is measured.
const FRAMES: usize = 200;

/// A stream beside the attacked one, with enough points that a frame takes some milliseconds.
pub struct Beside {
    producer: Producer,
    consumer: Consumer,
    random: Random,
}

impl Beside {
    /// The points of its window.
    const POINTS: u64 = 20_000;

    pub fn new(daemon: &Daemon) -> Self {
        let window = Some(Window::Points(Self::POINTS));
        let mut producer = Producer::open(daemon.client(), Open { window, ..open("beside") });
        let mut random = Random::new(7);
        producer.frame(&points(&mut random, Self::POINTS as usize));
        let mut consumer = daemon.consumer("beside", DERIVED);
        consumer.expect_snapshot(Cause::Start);
        Self { producer, consumer, random }
    }

    /// The time from commit to frame, of the slowest in a hundred frames.
    pub fn slowest_percent(&mut self) -> Duration {
        let mut times: Vec<Duration> = (0..FRAMES).map(|_| self.step()).collect();
        times.sort_unstable();
        times[FRAMES - FRAMES / 100 - 1]
    }

    fn step(&mut self) -> Duration {
        let some = points(&mut self.random, 500);
        let batch = self.producer.batch(&some);
        self.producer.is_accepted(batch, some.len());
        let begun = Instant::now();
        let commit = self.producer.commit();
        let frame = self.producer.is_committed(commit);
        self.consumer.follow_to(frame);
        begun.elapsed()
    }
}

/// Measures the stream beside, calm and attacked, and demands that the attack at most doubles its times. `attack` runs
/// on a thread of its own until its argument says that it is over.
///
/// On a machine that others use too, one measurement may be disturbed: of three, the best counts.
pub fn assert_beside_is_served(daemon: &Daemon, attack: impl Fn(&dyn Fn() -> bool) + Sync) {
    let mut beside = Beside::new(daemon);
    let mut seen = Vec::new();
    for _ in 0..3 {
        let calm = beside.slowest_percent();
        let over = std::sync::atomic::AtomicBool::new(false);
        let attacked = thread::scope(|scope| {
            scope.spawn(|| attack(&|| over.load(std::sync::atomic::Ordering::Acquire)));
            thread::sleep(Duration::from_millis(200));
            let attacked = beside.slowest_percent();
            over.store(true, std::sync::atomic::Ordering::Release);
            attacked
        });
        if attacked <= 2 * calm {
            return;
        }
        seen.push((calm, attacked));
    }
    panic!("the slowest in a hundred frames, calm and attacked: {seen:?}");
}

/// Ends the daemon by a signal. It obeys within seconds, and has never held more than its limit and some slack.
pub fn assert_ends_well(daemon: Daemon, limit: Option<u64>) -> Finished {
    let peak = daemon.running.peak_memory();
    if let Some(limit) = limit {
        assert!(peak <= limit + SLACK, "{peak} bytes were held, with a limit of {limit}");
    }
    let begun = Instant::now();
    daemon.running.signal(Signal::TERM);
    let finished = daemon.running.ends();
    assert!(begun.elapsed() < PATIENCE, "it took {:?} to end", begun.elapsed());
    finished
}

/// A producer of a stream with so many points.
pub fn stream_of(daemon: &Daemon, name: &str, count: usize) -> (Producer, Vec<Point>) {
    let mut random = Random::new(count as u64);
    let cloud = points(&mut random, count);
    let mut producer = daemon.producer(name);
    cloud.chunks(10_000).for_each(|some| {
        let batch = producer.batch(some);
        producer.is_accepted(batch, some.len());
    });
    let commit = producer.commit();
    producer.is_committed(commit);
    (producer, cloud)
}

/// A view of its own for each number.
pub fn view(number: u32) -> View {
    View { cut: Cut::Derived(1 + number % 50, 1 + number / 50), simplify: Simplify::No }
}

/// Follows a stream on a channel, and reads nothing.
pub fn follow(client: &mut Client, channel: u32, name: &str, view: View) {
    let subscribe = Subscribe { pattern: name.to_owned(), view, dots: DotsWanted::No, resume: None };
    client.write(&bytes(channel, subscribe));
}
