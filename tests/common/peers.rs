//! A real daemon with producers and consumers, in few words: `let daemon = Daemon::start(""); let mut cam =
//! daemon.producer("cam"); cam.frame(&points);`.
//!
//! In: options of `hopes serve`, points. Out: frames, verified by mirrors.
//!
//! Invariants: a producer checks that answers fit what it has sent. A consumer checks that every frame starts from the
//! previous one and has the right content.

use std::path::PathBuf;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use hopes_protocol::*;
use rustix::process::Signal;
use tempfile::TempDir;

use super::client::{Client, brief};
use super::process::{Finished, Running, hopes};
use super::random::Random;

/// The pause between the frames of a pair that runs beside a test.
const PAUSE: Duration = Duration::from_millis(5);

pub type Point = (f64, f64);

pub const FULL: View = View { cut: Cut::Full, simplify: Simplify::No };
pub const DERIVED: View = View { cut: Cut::Derived(1, 1), simplify: Simplify::No };

/// Points of the unit square.
pub fn points(random: &mut Random, count: usize) -> Vec<Point> {
    (0..count).map(|_| random.point().into()).collect()
}

// ---- the daemon

/// A running daemon with a socket of its own.
pub struct Daemon {
    pub running: Running,
    pub address: String,
    /// The folder of the socket.
    pub folder: TempDir,
}

impl Daemon {
    /// Starts it with options of `serve` besides its socket.
    pub fn start(options: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut running = serve_at(&socket_in(&folder)).and(options).and(&timeout(options)).start();
        let address = listening(&mut running);
        Self { running, address, folder }
    }

    /// The same over TCP.
    pub fn over_tcp(options: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut running = hopes("serve --listen tcp:127.0.0.1:0").and(options).and(&timeout(options)).start();
        let address = listening(&mut running);
        Self { running, address, folder }
    }

    /// The path of its socket.
    pub fn socket(&self) -> PathBuf {
        socket_in(&self.folder)
    }

    pub fn client(&self) -> Client {
        Client::with_hello(&self.address)
    }

    /// A producer of a stream. The stream's options are kept as they are.
    pub fn producer(&self, name: &str) -> Producer {
        Producer::open(self.client(), open(name))
    }

    /// A consumer without dots.
    pub fn consumer(&self, pattern: &str, view: View) -> Consumer {
        Consumer::subscribe(self.client(), subscribe(pattern, view))
    }

    pub fn status(&self) -> Status {
        self.client().status()
    }

    /// The status of a stream.
    pub fn stream(&self, name: &str) -> StreamStatus {
        let status = self.status();
        status.streams.into_iter().find(|stream| stream.info.name == name).expect("the stream is there")
    }

    /// Stops it with a signal. No thread may have panicked, and the exit must be clean.
    pub fn stop(self) -> Finished {
        self.running.signal(Signal::TERM);
        assert_clean_exit(self.running.ends())
    }
}

/// Long timeouts: a message that is not sent when it is due is not sent later by a heartbeat, so the test fails.
fn timeout(options: &str) -> String {
    [("--heartbeat", "1000s"), ("--timeout", "8000s")]
        .iter()
        .filter(|(option, _)| !options.contains(option))
        .map(|(option, long)| format!("{option} {long} "))
        .collect()
}

/// Checks for a clean exit.
pub fn assert_clean_exit(finished: Finished) -> Finished {
    assert!(!finished.err.contains("panicked") && !finished.err.contains("by itself"), "{}", finished.err);
    assert_eq!(finished.code, Some(0), "{}", finished.err);
    finished
}

pub fn socket_in(folder: &TempDir) -> PathBuf {
    folder.path().join("socket")
}

/// A daemon at that socket, before it is started.
pub fn serve_at(socket: &std::path::Path) -> super::process::Hopes {
    hopes("serve --listen").with(format!("unix:{}", socket.display()))
}

/// The next address in the log at which it listens.
pub fn listening(running: &mut Running) -> String {
    const WORDS: &str = "listening at ";
    let line = running.until_log(WORDS);
    let (_, address) = line.split_once(WORDS).expect("the line has these words");
    address.trim_end().to_owned()
}

pub fn open(name: &str) -> Open {
    Open { name: name.to_owned(), window: None, resolution: None }
}

pub fn subscribe(pattern: &str, view: View) -> Subscribe {
    Subscribe { pattern: pattern.to_owned(), view, dots: DotsWanted::No, resume: None }
}

// ---- producers

/// Writes to one stream on channel 1.
pub struct Producer {
    pub client: Client,
    pub opened: Opened,
    pub sequence: u64,
}

impl Producer {
    pub const CHANNEL: u32 = 1;

    pub fn open(mut client: Client, open: Open) -> Self {
        match client.ask(Self::CHANNEL, open) {
            Message::Opened(opened) => Self { client, opened, sequence: 0 },
            other => panic!("Opened is due, not {}", brief(&other)),
        }
    }

    /// Sends a batch. Returns its sequence number.
    pub fn batch(&mut self, points: &[Point]) -> u64 {
        self.sequence += 1;
        let sequence = self.sequence;
        self.client
            .send(Self::CHANNEL, Batch { sequence, points: points.to_vec(), times: Vec::new(), tags: Vec::new() });
        sequence
    }

    pub fn retract(&mut self, points: &[Point]) -> u64 {
        self.sequence += 1;
        let sequence = self.sequence;
        self.client.send(Self::CHANNEL, Retract { sequence, points: points.to_vec() });
        sequence
    }

    pub fn commit(&mut self) -> u64 {
        self.sequence += 1;
        let sequence = self.sequence;
        self.client.send(Self::CHANNEL, Commit { sequence, time: None });
        sequence
    }

    /// The next answer.
    pub fn answer(&mut self) -> Message {
        self.client.receive_on(Self::CHANNEL)
    }

    pub fn is_committed(&mut self, sequence: u64) -> u64 {
        match self.answer() {
            Message::Committed(committed) if committed.sequence == sequence => committed.frame,
            other => panic!("Committed {sequence} is due, not {}", brief(&other)),
        }
    }

    pub fn is_accepted(&mut self, sequence: u64, points: usize) {
        let accepted = Accepted { sequence, points: points as u32, placed: Vec::new() };
        assert_eq!(self.answer(), Message::Accepted(accepted));
    }

    /// Sends a frame with these additional points, all of which must be accepted. Returns its number.
    pub fn frame(&mut self, points: &[Point]) -> u64 {
        let batch = self.batch(points);
        let commit = self.commit();
        self.is_accepted(batch, points.len());
        self.is_committed(commit)
    }

    /// Closes the channel, and ends the stream if asked. Returns the stream's last frame.
    pub fn close(&mut self, end: bool) -> u64 {
        match self.client.ask(Self::CHANNEL, Close { end }) {
            Message::Closed(closed) => closed.frame,
            other => panic!("Closed is due, not {}", brief(&other)),
        }
    }
}

// ---- consumers

/// Follows one stream on channel 2.
pub struct Consumer {
    pub client: Client,
    pub mirror: Mirror,
    pub opened: StreamOpened,
    /// The newest dots.
    pub dots: Option<Dots>,
}

impl Consumer {
    pub const CHANNEL: u32 = 2;

    /// Subscribes and waits until the stream exists.
    pub fn subscribe(mut client: Client, subscribe: Subscribe) -> Self {
        match client.ask(Self::CHANNEL, subscribe) {
            Message::StreamOpened(opened) => Self { client, mirror: Mirror::new(), opened, dots: None },
            other => panic!("StreamOpened is due, not {}", brief(&other)),
        }
    }

    /// The next message. The mirror has applied it if it is a snapshot or diff.
    pub fn next(&mut self) -> Message {
        let message = self.client.receive_on(Self::CHANNEL);
        match &message {
            Message::Snapshot(snapshot) => self.mirror.apply_snapshot(snapshot).unwrap(),
            Message::Diff(diff) => self.mirror.apply_diff(diff).unwrap(),
            Message::Dots(dots) => {
                assert_eq!(dots.frame, self.mirror.number(), "dots belong to the frame before them");
                self.dots = Some(dots.clone());
            }
            _ => {}
        }
        message
    }

    /// Reads until a frame. Returns the messages.
    pub fn follow_to(&mut self, frame: u64) -> Vec<Message> {
        let mut heard = Vec::new();
        while self.mirror.number() < frame {
            heard.push(self.next());
        }
        assert_eq!(self.mirror.number(), frame, "{}", brief(&heard));
        heard
    }

    /// Expects a diff of one frame.
    pub fn expect_diff(&mut self, frame: u64) -> Diff {
        match self.next() {
            Message::Diff(diff) => {
                assert_eq!((diff.from, diff.frame.number), (frame - 1, frame));
                diff
            }
            other => panic!("a diff to frame {frame} is due, not {}", brief(&other)),
        }
    }

    /// Expects a snapshot with this cause.
    pub fn expect_snapshot(&mut self, cause: Cause) -> u64 {
        match self.next() {
            Message::Snapshot(snapshot) if snapshot.cause == cause => snapshot.frame.number,
            other => panic!("a snapshot because of {cause:?} is due, not {}", brief(&other)),
        }
    }

    /// Expects diffs of one frame each, up to that frame.
    pub fn expect_diffs_to(&mut self, frame: u64) {
        for number in self.mirror.number() + 1..=frame {
            self.expect_diff(number);
        }
    }
}

/// The content of a mirror, for comparison with another mirror.
pub fn held(mirror: &Mirror) -> impl PartialEq + std::fmt::Debug + use<> {
    (mirror.number(), mirror.vertices().clone(), mirror.edges().clone(), mirror.critical().clone(), mirror.checksum())
}

// ---- both

/// A producer and a consumer that behave well. They must be served well whatever other peers do.
pub struct ProducerAndConsumer {
    pub producer: Producer,
    pub consumer: Consumer,
    random: Random,
}

impl ProducerAndConsumer {
    pub fn new(daemon: &Daemon, name: &str) -> Self {
        let mut pair = Self {
            producer: daemon.producer(name),
            consumer: daemon.consumer(name, DERIVED),
            random: Random::new(name.len() as u64),
        };
        let frame = pair.producer.frame(&[(0.5, 0.5)]);
        pair.consumer.expect_snapshot(Cause::Start);
        pair.consumer.follow_to(frame);
        pair
    }

    /// One frame from the producer to the consumer.
    pub fn step(&mut self) {
        let points = points(&mut self.random, 5);
        let frame = self.producer.frame(&points);
        self.consumer.expect_diff(frame);
    }

    /// Sends frame after frame from producer to consumer while something else runs.
    pub fn while_serving<T>(daemon: &Daemon, happens: impl FnOnce() -> T) -> T {
        let (goes_on, is_over) = channel::<()>();
        let mut pair = Self::new(daemon, "beside");
        thread::scope(|scope| {
            let steps = scope.spawn(move || {
                while is_over.recv_timeout(PAUSE) == Err(RecvTimeoutError::Timeout) {
                    pair.step();
                }
                pair.step();
                pair.producer.client.part();
            });
            let outcome = happens();
            drop(goes_on);
            steps.join().expect("who behaves well is served well");
            outcome
        })
    }
}
