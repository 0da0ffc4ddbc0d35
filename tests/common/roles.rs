//! A real daemon and those who use it, in few words: `let daemon = Daemon::start(""); let mut cam = daemon.producer("cam"); cam.frame(&points);`.
//!
//! In: options of `hopes serve`, points. Out: frames, proved by mirrors. Invariants: a producer checks that its answers fit what it has sent, a consumer that every frame starts
//! from the one before and is what it should be.

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

/// Between the frames of those who are there beside others.
const PAUSE: Duration = Duration::from_millis(5);

pub type Point = (f64, f64);

pub const FULL: View = View { cut: Cut::Full, simplify: Simplify::No };
pub const DERIVED: View = View { cut: Cut::Derived(1, 1), simplify: Simplify::No };

/// Points of the unit square.
pub fn points(random: &mut Random, count: usize) -> Vec<Point> {
    (0..count).map(|_| random.point().into()).collect()
}

// ---- the daemon

/// A daemon at work on a socket of its own.
pub struct Daemon {
    pub running: Running,
    pub address: String,
    /// Holds the socket.
    pub folder: TempDir,
}

impl Daemon {
    /// With options of `serve` besides its socket.
    pub fn start(options: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut running = serve_at(&socket_in(&folder)).and(options).and(&patience(options)).start();
        let address = listening(&mut running);
        Self { running, address, folder }
    }

    /// The same over TCP.
    pub fn over_tcp(options: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut running = hopes("serve --listen tcp:127.0.0.1:0").and(options).and(&patience(options)).start();
        let address = listening(&mut running);
        Self { running, address, folder }
    }

    /// Its socket.
    pub fn socket(&self) -> PathBuf {
        socket_in(&self.folder)
    }

    pub fn client(&self) -> Client {
        Client::greeted(&self.address)
    }

    /// A producer of a stream with whatever options it has.
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

    /// How a stream is.
    pub fn stream(&self, name: &str) -> StreamStatus {
        let status = self.status();
        status.streams.into_iter().find(|stream| stream.info.name == name).expect("the stream is there")
    }

    /// Ends it politely: no thread of it may have panicked, and all is done in good order.
    pub fn stop(self) -> Finished {
        self.running.signal(Signal::TERM);
        is_fine(self.running.ends())
    }
}

/// Signs of life so seldom that nothing comes with them that was forgotten: what is not sent when it is due is missed.
fn patience(options: &str) -> String {
    [("--heartbeat", "1000s"), ("--timeout", "8000s")]
        .iter()
        .filter(|(option, _)| !options.contains(option))
        .map(|(option, long)| format!("{option} {long} "))
        .collect()
}

/// It has ended in good order.
pub fn is_fine(finished: Finished) -> Finished {
    assert!(!finished.err.contains("panicked") && !finished.err.contains("by itself"), "{}", finished.err);
    assert_eq!(finished.code, Some(0), "{}", finished.err);
    finished
}

pub fn socket_in(folder: &TempDir) -> PathBuf {
    folder.path().join("socket")
}

/// A daemon at that socket, not started yet.
pub fn serve_at(socket: &std::path::Path) -> super::process::Hopes {
    hopes("serve --listen").with(format!("unix:{}", socket.display()))
}

/// The next place where it says that it listens.
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

/// Feeds one stream on channel 1.
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

    /// Sends a batch; its number.
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
        self.client.hear_on(Self::CHANNEL)
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

    /// A frame with these points besides what is there; all are taken. Its number.
    pub fn frame(&mut self, points: &[Point]) -> u64 {
        let batch = self.batch(points);
        let commit = self.commit();
        self.is_accepted(batch, points.len());
        self.is_committed(commit)
    }

    /// Ends the channel, or the stream too. Its last frame.
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

    /// Subscribes, and waits until the stream is there.
    pub fn subscribe(mut client: Client, subscribe: Subscribe) -> Self {
        match client.ask(Self::CHANNEL, subscribe) {
            Message::StreamOpened(opened) => Self { client, mirror: Mirror::new(), opened, dots: None },
            other => panic!("StreamOpened is due, not {}", brief(&other)),
        }
    }

    /// The next message, which the mirror has followed if it is for it.
    pub fn next(&mut self) -> Message {
        let message = self.client.hear_on(Self::CHANNEL);
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

    /// Follows to a frame; what came on the way.
    pub fn follow_to(&mut self, frame: u64) -> Vec<Message> {
        let mut heard = Vec::new();
        while self.mirror.number() < frame {
            heard.push(self.next());
        }
        assert_eq!(self.mirror.number(), frame, "{}", brief(&heard));
        heard
    }

    /// The next message is a diff of one frame.
    pub fn is_told_of(&mut self, frame: u64) -> Diff {
        match self.next() {
            Message::Diff(diff) => {
                assert_eq!((diff.from, diff.frame.number), (frame - 1, frame));
                diff
            }
            other => panic!("a diff to frame {frame} is due, not {}", brief(&other)),
        }
    }

    /// The next message is a snapshot for that reason.
    pub fn is_shown(&mut self, cause: Cause) -> u64 {
        match self.next() {
            Message::Snapshot(snapshot) if snapshot.cause == cause => snapshot.frame.number,
            other => panic!("a snapshot because of {cause:?} is due, not {}", brief(&other)),
        }
    }

    /// The next messages, all diffs of one frame each, up to that frame.
    pub fn is_told_of_all_to(&mut self, frame: u64) {
        for number in self.mirror.number() + 1..=frame {
            self.is_told_of(number);
        }
    }
}

/// What a mirror holds, to be compared with another one's.
pub fn held(mirror: &Mirror) -> impl PartialEq + std::fmt::Debug + use<> {
    (mirror.number(), mirror.vertices().clone(), mirror.edges().clone(), mirror.critical().clone(), mirror.checksum())
}

// ---- both

/// A producer and a consumer who behave well, and are served well whatever others do.
pub struct Pair {
    pub producer: Producer,
    pub consumer: Consumer,
    random: Random,
}

impl Pair {
    pub fn new(daemon: &Daemon, name: &str) -> Self {
        let mut pair = Self {
            producer: daemon.producer(name),
            consumer: daemon.consumer(name, DERIVED),
            random: Random::new(name.len() as u64),
        };
        let frame = pair.producer.frame(&[(0.5, 0.5)]);
        pair.consumer.is_shown(Cause::Start);
        pair.consumer.follow_to(frame);
        pair
    }

    /// A frame goes all the way.
    pub fn step(&mut self) {
        let points = points(&mut self.random, 5);
        let frame = self.producer.frame(&points);
        self.consumer.is_told_of(frame);
    }

    /// One frame after the other goes all the way, while something else happens.
    pub fn beside<T>(daemon: &Daemon, happens: impl FnOnce() -> T) -> T {
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
