//! Many consumers of one stream: all of them well behaved, and then a tenth that reads nothing and a tenth that floods.
//!
//! In: how many, and the size of the stream. Out: the times from commit to consumer, of both.
//!
//! Invariants: the same consumers are measured in both halves, which take turns. One thread reads for all of them. It
//! takes the time when it has read the whole of a diff.

use std::os::fd::BorrowedFd;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use clap::Args;
use hopes_protocol::{
    Batch, ChangeView, Commit, Cut, DotsWanted, Message, Open, Simplify, VERSION, View, Window, encode,
};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::daemon::Daemon;
use crate::figures::{Random, percentile};
use crate::peer::{Peer, subscribe};

/// Many consumers of one stream.
#[derive(Clone, Debug, Args)]
pub struct Crowd {
    /// Consumers. A tenth of them is stopped in the rough half, and a tenth floods.
    #[arg(long, default_value_t = 1000)]
    consumers: usize,
    /// Points of the stream.
    #[arg(long, default_value_t = 2000)]
    points: usize,
    /// Points replaced in a frame.
    #[arg(long, default_value_t = 20)]
    replace: usize,
    /// Frames of each half in a turn.
    #[arg(long, default_value_t = 100)]
    frames: usize,
    /// Frames a second.
    #[arg(long, default_value_t = 8.0)]
    rate: f64,
    /// Turns.
    #[arg(long, default_value_t = 3)]
    turns: usize,
}

const CHANNEL: u32 = 1;

const NAMES: [&str; 2] = ["calm", "rough"];

/// What the threads that read share.
#[derive(Default)]
struct Shared {
    is_over: AtomicBool,
    is_rough: AtomicBool,
}

impl Crowd {
    /// Prints the times of each turn and of all.
    pub fn run(self, hopes: &Path) -> anyhow::Result<()> {
        let arguments = ["--max-connections", "8192", "--timeout", "1h", "--history", "1MiB"];
        let daemon = Daemon::start(hopes, &arguments)?;
        let start = Instant::now();
        let mut feeder = Feeder::new(&daemon, start, &self)?;
        let tenth = self.consumers / 10;
        let measured = join(&daemon, self.consumers - 2 * tenth)?;
        let (stopped, flooding) = (join(&daemon, tenth)?, join(&daemon, tenth)?);
        let shared = Arc::new(Shared::default());
        let [of_measured, of_others] = [Arc::clone(&shared), Arc::clone(&shared)];
        let reader = thread::spawn(move || read(measured, &of_measured, start));
        let others = thread::spawn(move || misbehave(stopped, flooding, &of_others));
        println!("{} consumers, {} points, {} replaced a frame", self.consumers, self.points, self.replace);
        for _ in 0..self.turns {
            for is_rough in [false, true] {
                shared.is_rough.store(is_rough, Ordering::Release);
                // The time between halves is not measured: what one has left behind is worked off.
                thread::sleep(Duration::from_secs(1));
                feeder.feed(self.frames, self.rate, is_rough)?;
            }
        }
        thread::sleep(Duration::from_secs(1));
        shared.is_over.store(true, Ordering::Release);
        let times = reader.join().map_err(|_| anyhow::anyhow!("the reader panicked"))??;
        others.join().map_err(|_| anyhow::anyhow!("a flood panicked"))??;
        self.report(feeder.halves.as_slice(), &times);
        anyhow::ensure!(daemon.stop()?, "the daemon did not end in good order");
        Ok(())
    }

    fn report(&self, halves: &[(f64, f64, bool)], times: &[(f64, f64)]) {
        let mut all = [Vec::new(), Vec::new()];
        println!("commit to consumer, ms: median, 99th percentile");
        for &(from, to, is_rough) in halves {
            let within = |&&(committed, _): &&(f64, f64)| committed >= from && committed <= to;
            let of_half: Vec<f64> = times.iter().filter(within).map(|(committed, got)| got - committed).collect();
            println!("{:6} {}", NAMES[usize::from(is_rough)], figures(of_half.clone()));
            all[usize::from(is_rough)].extend(of_half);
        }
        for (name, times) in NAMES.into_iter().zip(&all) {
            println!("all {name:6} {}", figures(times.clone()));
        }
        let [calm, rough] = all.map(|mut times| {
            times.sort_unstable_by(f64::total_cmp);
            percentile(&times, 0.99)
        });
        println!("the 99th percentile, rough to calm: {:.3}", rough / calm);
    }
}

fn figures(mut times: Vec<f64>) -> String {
    times.sort_unstable_by(f64::total_cmp);
    let [median, slow] = [0.5, 0.99].map(|share| 1e3 * percentile(&times, share));
    format!("{median:8.2} {slow:8.2}, of {} frames of consumers", times.len())
}

/// The producer.
struct Feeder {
    peer: Peer,
    random: Random,
    replace: usize,
    sequence: u64,
    start: Instant,
    /// When the halves began and ended, in seconds, and whether they were rough.
    halves: Vec<(f64, f64, bool)>,
}

impl Feeder {
    fn new(daemon: &Daemon, start: Instant, crowd: &Crowd) -> anyhow::Result<Self> {
        let mut peer = Peer::connect(&daemon.socket)?;
        let window = Some(Window::Points(crowd.points as u64));
        peer.send(CHANNEL, Open { name: "s".to_owned(), window, resolution: None })?;
        let (random, replace) = (Random(5), crowd.replace);
        let mut feeder = Self { peer, random, replace, sequence: 0, start, halves: Vec::new() };
        feeder.frame(crowd.points)?;
        Ok(feeder)
    }

    fn frame(&mut self, points: usize) -> anyhow::Result<()> {
        let points = self.random.points(points);
        self.peer.send(CHANNEL, Batch { sequence: self.sequence, points, times: Vec::new(), tags: Vec::new() })?;
        let time = Some(self.start.elapsed().as_secs_f64());
        self.peer.send(CHANNEL, Commit { sequence: self.sequence + 1, time })?;
        self.sequence += 2;
        while !matches!(self.peer.receive()?.1, Message::Committed(_)) {}
        Ok(())
    }

    fn feed(&mut self, frames: usize, rate: f64, is_rough: bool) -> anyhow::Result<()> {
        let from = self.start.elapsed().as_secs_f64();
        let mut due = Instant::now();
        for _ in 0..frames {
            self.frame(self.replace)?;
            due += Duration::from_secs_f64(1.0 / rate);
            thread::sleep(due.saturating_duration_since(Instant::now()));
        }
        self.halves.push((from, self.start.elapsed().as_secs_f64(), is_rough));
        Ok(())
    }
}

/// Consumers of the stream, which do not wait when they read.
fn join(daemon: &Daemon, count: usize) -> anyhow::Result<Vec<Peer>> {
    let one = |_| {
        let mut peer = Peer::connect(&daemon.socket)?;
        peer.send(CHANNEL, subscribe("s", Cut::Derived(1, 1), Simplify::No, None))?;
        peer.set_nonblocking()?;
        Ok(peer)
    };
    (0..count).map(one).collect()
}

/// Waits a little for any of them. Returns which can be read.
fn readable(peers: &[Peer], flags: PollFlags) -> anyhow::Result<Vec<usize>> {
    let wait = Timespec { tv_sec: 0, tv_nsec: 100_000_000 };
    let sockets: Vec<BorrowedFd<'_>> = peers.iter().map(Peer::socket).collect();
    let mut polled: Vec<PollFd<'_>> = sockets.iter().map(|socket| PollFd::new(socket, flags)).collect();
    poll(&mut polled, Some(&wait))?;
    Ok(polled.iter().enumerate().filter(|(_, polled)| !polled.revents().is_empty()).map(|(place, _)| place).collect())
}

/// Reads for all. Returns, for each diff of each of them, when its frame was committed and when it was there.
fn read(mut peers: Vec<Peer>, shared: &Shared, start: Instant) -> anyhow::Result<Vec<(f64, f64)>> {
    let mut times = Vec::new();
    while !shared.is_over.load(Ordering::Acquire) {
        for place in readable(&peers, PollFlags::IN)? {
            peers[place].read_now()?;
            while let Some(message) = peers[place].next_now()? {
                if let Message::Diff(diff) = message {
                    times.push((diff.frame.time.unwrap_or(f64::NAN), start.elapsed().as_secs_f64()));
                }
            }
        }
    }
    Ok(times)
}

/// Reads for others while it is calm. While it is rough, some of them read nothing, and the rest sends one change of
/// the view after the other.
fn misbehave(mut stopped: Vec<Peer>, mut flooding: Vec<Peer>, shared: &Shared) -> anyhow::Result<()> {
    let flood = flood()?;
    let mut sent = vec![0; flooding.len()];
    let mut written = 0;
    while !shared.is_over.load(Ordering::Acquire) {
        let is_rough = shared.is_rough.load(Ordering::Acquire);
        if !is_rough {
            for place in readable(&stopped, PollFlags::IN)? {
                stopped[place].discard_now()?;
            }
        }
        let flags = if is_rough { PollFlags::IN | PollFlags::OUT } else { PollFlags::IN };
        for place in readable(&flooding, flags)? {
            flooding[place].discard_now()?;
            if is_rough {
                // It goes round, so that no message is cut.
                let length = flooding[place].write_now(&flood[sent[place]..])?;
                sent[place] = (sent[place] + length) % flood.len();
                written += length;
            }
        }
    }
    println!("the flood had {} kB", written / 1000);
    Ok(())
}

/// Changes of the view, among a few views.
fn flood() -> anyhow::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    for number in 0..256 {
        let view = View { cut: Cut::Derived(1 + number % 8, 1), simplify: Simplify::No };
        let change: Message = ChangeView { view, dots: DotsWanted::No }.into();
        bytes.extend(encode(VERSION, CHANNEL, &change)?);
    }
    Ok(bytes)
}
