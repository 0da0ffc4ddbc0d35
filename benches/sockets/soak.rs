//! Many producers and consumers for minutes. Some of them are stopped, killed, slow, or reconnect.
//!
//! In: how many, and how long. Out: counts, latencies in calm and in rough phases, memory, and violated invariants.
//!
//! Invariants, which are tested: every frame of a consumer was verified. Frames follow each other, or the consumer gets
//! the missing range. The last frame has the points of every committed batch and no others. The daemon's memory does
//! not grow.
//!
//! Each producer owns some points of its stream and replaces a few of them each time, so the points at the end are
//! known.

use std::collections::{BTreeSet, VecDeque};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use clap::Args;
use hopes_protocol::{Batch, Commit, Cut, Message, Mirror, Open, Resume, Retract, Simplify, StatusWanted, Window};
use rustix::process::Signal;

use crate::daemon::{Daemon, signal};
use crate::figures::{Random, percentile};
use crate::peer::{Peer, subscribe};

/// Many peers, some of them badly behaved.
#[derive(Clone, Debug, Args)]
pub struct Soak {
    /// The duration in minutes.
    #[arg(long, default_value_t = 10.0)]
    minutes: f64,
    /// Streams; producers and consumers are spread over them.
    #[arg(long, default_value_t = 4)]
    streams: usize,
    /// Producers.
    #[arg(long, default_value_t = 16)]
    producers: usize,
    /// Consumers.
    #[arg(long, default_value_t = 200)]
    consumers: usize,
    /// Frames a second of each stream.
    #[arg(long, default_value_t = 30.0)]
    rate: f64,
    /// Points of each producer.
    #[arg(long, default_value_t = 250)]
    points: usize,
    /// Points that each producer replaces in a frame.
    #[arg(long, default_value_t = 5)]
    replace: usize,
    /// Let the daemon recompute every frame and compare.
    #[arg(long)]
    check: bool,
}

/// Calm and rough phases alternate, so that both run on the same machine.
const PHASE: Duration = Duration::from_secs(15);

const CHANNEL: u32 = 1;

struct Shared {
    soak: Soak,
    socket: PathBuf,
    start: Instant,
    /// No more frames are made.
    is_over: AtomicBool,
    /// Some consumers are being stopped.
    is_rough: AtomicBool,
    frames: AtomicU64,
    lagged: AtomicU64,
    snapshots: AtomicU64,
    resumed: AtomicU64,
    not_resumed: AtomicU64,
    latencies: [Mutex<Vec<f64>>; 2],
    problems: Mutex<Vec<String>>,
}

impl Shared {
    fn problem(&self, what: String) {
        let mut problems = self.problems.lock().expect("no thread panics while it holds the lock");
        if problems.len() < 20 {
            eprintln!("PROBLEM: {what}");
        }
        problems.push(what);
    }

    fn name(&self, peer: usize) -> String {
        format!("stream {}", peer % self.soak.streams)
    }
}

impl Soak {
    pub fn run(self, hopes: &Path) -> anyhow::Result<()> {
        // Small limits, so that they are reached.
        let mut arguments = vec!["--history", "4MiB", "--consumer-queue", "64KiB"];
        arguments.extend(self.check.then_some("--check"));
        let daemon = Daemon::start(hopes, &arguments)?;
        let shared = Arc::new(Shared {
            socket: daemon.socket.clone(),
            start: Instant::now(),
            is_over: AtomicBool::new(false),
            is_rough: AtomicBool::new(false),
            frames: AtomicU64::new(0),
            lagged: AtomicU64::new(0),
            snapshots: AtomicU64::new(0),
            resumed: AtomicU64::new(0),
            not_resumed: AtomicU64::new(0),
            latencies: [Mutex::default(), Mutex::default()],
            problems: Mutex::default(),
            soak: self.clone(),
        });
        // Every twentieth consumer is a process of its own, which can be stopped and killed.
        let processes = self.consumers / 20;
        let peers = |count: usize, work: fn(&Shared, usize) -> anyhow::Result<()>| -> Vec<_> {
            (0..count).map(|peer| (peer, work)).map(|(peer, work)| spawn(&shared, peer, work)).collect()
        };
        let producers: Vec<_> = (0..self.producers)
            .map(|peer| {
                let shared = Arc::clone(&shared);
                thread::spawn(move || produce(&shared, peer))
            })
            .collect();
        let consumers = peers(self.consumers - processes, consume);
        let memory = disturb(&shared, hopes, processes, &daemon)?;
        shared.is_over.store(true, Relaxed);
        let mut left: Vec<FinalPoints> = Vec::new();
        for producer in producers {
            match producer.join() {
                Ok(Ok(points)) => left.push(points),
                Ok(Err(error)) => shared.problem(format!("a producer: {error:#}")),
                Err(_) => shared.problem("a producer panicked".to_owned()),
            }
        }
        check_last_frames(&shared, &left)?;
        for consumer in consumers {
            drop(consumer.join());
        }
        report(&shared, &memory);
        if !daemon.stop()? {
            shared.problem("the daemon did not end in good order".to_owned());
        }
        let problems = shared.problems.lock().expect("no thread panics while it holds the lock");
        anyhow::ensure!(problems.is_empty(), "{} problems, the first: {}", problems.len(), problems[0]);
        println!("nothing was wrong");
        Ok(())
    }
}

fn spawn(shared: &Arc<Shared>, peer: usize, work: fn(&Shared, usize) -> anyhow::Result<()>) -> thread::JoinHandle<()> {
    let shared = Arc::clone(shared);
    thread::spawn(move || {
        if let Err(error) = work(&shared, peer) {
            shared.problem(format!("peer {peer} of {}: {error:#}", shared.name(peer)));
        }
    })
}

/// The points of a producer in its stream at the end.
struct FinalPoints {
    stream: String,
    points: Vec<(f64, f64)>,
}

fn produce(shared: &Shared, peer: usize) -> anyhow::Result<FinalPoints> {
    let Soak { streams, producers, rate, points, replace, .. } = shared.soak;
    let mut random = Random(peer as u64 + 1);
    let name = shared.name(peer);
    let mut daemon = Peer::connect(&shared.socket)?;
    daemon.send(CHANNEL, Open { name: name.clone(), window: Some(Window::All), resolution: None })?;
    daemon.receive()?;
    let (mut own, mut sequence, mut frames) = (VecDeque::new(), 0, 0);
    let mut due = Instant::now();
    while !shared.is_over.load(Relaxed) {
        let new = random.points(replace);
        own.extend(new.iter().copied());
        daemon.send(CHANNEL, Batch { sequence, points: new, times: Vec::new(), tags: Vec::new() })?;
        let old: Vec<_> = own.drain(..own.len().saturating_sub(points)).collect();
        daemon.send(CHANNEL, Retract { sequence: sequence + 1, points: old })?;
        sequence += 2;
        let time = Some(shared.start.elapsed().as_secs_f64());
        daemon.send(CHANNEL, Commit { sequence, time })?;
        sequence += 1;
        let mut unanswered = 3;
        while unanswered > 0 {
            match daemon.receive()?.1 {
                Message::Accepted(_) => {}
                Message::Committed(committed) if committed.frame > frames => frames = committed.frame,
                other => anyhow::bail!("an unexpected answer: {other:?}"),
            }
            unanswered -= 1;
        }
        // The producers of a stream commit in turn.
        due += Duration::from_secs_f64(producers.div_ceil(streams) as f64 / rate);
        thread::sleep(due.saturating_duration_since(Instant::now()));
    }
    Ok(FinalPoints { stream: name, points: own.into_iter().collect() })
}

/// The views of the consumers, in turn.
fn view_of(peer: usize) -> (Cut, Simplify) {
    match peer % 5 {
        0 => (Cut::Derived(1, 1), Simplify::No),
        1 => (Cut::Full, Simplify::No),
        2 => (Cut::Reduced(0.05), Simplify::No),
        3 => (Cut::Derived(2, 2), Simplify::No),
        _ => (Cut::Derived(1, 1), Simplify::AtScale),
    }
}

/// How a consumer of this process behaves.
#[derive(Clone, Copy, PartialEq)]
enum Behaviour {
    Steady,
    /// Stops reading for some seconds.
    Slow,
    /// Closes its connection and reconnects.
    Reconnecting,
}

fn consume(shared: &Shared, peer: usize) -> anyhow::Result<()> {
    let habit = match peer % 20 {
        7 => Behaviour::Slow,
        11 | 17 => Behaviour::Reconnecting,
        _ => Behaviour::Steady,
    };
    let mut random = Random(1000 + peer as u64);
    let (cut, simplify) = view_of(peer / shared.soak.streams);
    let mut mirror = Mirror::new();
    let mut resume = None;
    while !shared.is_over.load(Relaxed) {
        let mut daemon = Peer::connect(&shared.socket)?;
        daemon.send(CHANNEL, subscribe(&shared.name(peer), cut, simplify, resume))?;
        let until = Duration::from_secs_f64(2.0 + 8.0 * random.unit());
        let epoch = follow(shared, &mut daemon, &mut mirror, habit, Instant::now() + until)?;
        resume = (mirror.number() > 0).then_some(Resume { epoch, frame: mirror.number() });
    }
    Ok(())
}

/// Follows until the end, or until the consumer's behaviour makes it leave. Returns the stream's epoch.
fn follow(
    shared: &Shared,
    daemon: &mut Peer,
    mirror: &mut Mirror,
    habit: Behaviour,
    mut until: Instant,
) -> anyhow::Result<u64> {
    let (mut epoch, mut missing) = (0, None);
    loop {
        let (_, message) = daemon.receive()?;
        match message {
            Message::StreamOpened(opened) => epoch = opened.epoch,
            Message::Resumed(resumed) => {
                shared.resumed.fetch_add(1, Relaxed);
                anyhow::ensure!(resumed.frame == mirror.number(), "resumed from another frame");
            }
            Message::Lagged(lagged) => {
                anyhow::ensure!(lagged.first == mirror.number() + 1, "lagged from another frame");
                shared.lagged.fetch_add(lagged.last - lagged.first + 1, Relaxed);
                missing = Some(lagged.last);
            }
            Message::Snapshot(snapshot) => {
                shared.snapshots.fetch_add(1, Relaxed);
                if snapshot.cause == hopes_protocol::Cause::CannotResume {
                    shared.not_resumed.fetch_add(1, Relaxed);
                }
                mirror.apply_snapshot(&snapshot)?;
                missing = None;
            }
            Message::Diff(diff) => {
                let now = shared.start.elapsed().as_secs_f64();
                let step = diff.frame.number - diff.from;
                let is_told = missing.take() == Some(diff.frame.number - 1);
                anyhow::ensure!(step == 1 || is_told, "frames are missing, and nobody has said so");
                mirror.apply_diff(&diff)?;
                shared.frames.fetch_add(1, Relaxed);
                if habit == Behaviour::Steady {
                    let phase = usize::from(shared.is_rough.load(Relaxed));
                    let latency = now - diff.frame.time.unwrap_or(f64::NAN);
                    shared.latencies[phase].lock().expect("no thread panics while it holds the lock").push(latency);
                }
            }
            _ => {}
        }
        if shared.is_over.load(Relaxed) {
            return Ok(epoch);
        }
        if Instant::now() > until {
            match habit {
                Behaviour::Steady => {}
                Behaviour::Slow => thread::sleep(Duration::from_secs(4)),
                Behaviour::Reconnecting => return Ok(epoch),
            }
            until = Instant::now() + Duration::from_secs(8);
        }
    }
}

/// Stops, kills and starts consumer processes, and measures memory. Returns the memory of each phase.
fn disturb(shared: &Shared, hopes: &Path, processes: usize, daemon: &Daemon) -> anyhow::Result<Vec<(u64, u64)>> {
    let start = |peer: usize| -> anyhow::Result<Child> {
        let address = format!("unix:{}", shared.socket.display());
        let child = Command::new(hopes)
            .args(["--quiet", "watch", "--from", &address, "--stream", &shared.name(peer), "--output", "bin"])
            .stdout(Stdio::null())
            .spawn()?;
        Ok(child)
    };
    let mut watchers = (0..processes).map(start).collect::<anyhow::Result<Vec<Child>>>()?;
    let mut memory = Vec::new();
    let end = shared.start + Duration::from_secs_f64(shared.soak.minutes * 60.0);
    let mut phase = 0;
    while Instant::now() < end {
        let is_rough = phase % 2 == 1;
        shared.is_rough.store(is_rough, Relaxed);
        if is_rough {
            watchers.iter().step_by(2).for_each(|watcher| signal(watcher.id(), Signal::STOP));
        }
        thread::sleep(PHASE.min(end.saturating_duration_since(Instant::now())));
        for (peer, watcher) in watchers.iter_mut().enumerate() {
            if is_rough && peer % 4 == 0 {
                watcher.kill()?;
                watcher.wait()?;
                *watcher = start(peer)?;
            } else if is_rough && peer % 2 == 0 {
                signal(watcher.id(), Signal::CONT);
            } else if let Some(status) = watcher.try_wait()? {
                shared.problem(format!("a watching process has ended: {status}"));
                *watcher = start(peer)?;
            }
        }
        memory.push(daemon.memory());
        phase += 1;
    }
    for watcher in &mut watchers {
        drop(watcher.kill());
        drop(watcher.wait());
    }
    Ok(memory)
}

/// Checks that the last frame of each stream has exactly the points that its producers left.
fn check_last_frames(shared: &Shared, left: &[FinalPoints]) -> anyhow::Result<()> {
    let mut daemon = Peer::connect(&shared.socket)?;
    for stream in 0..shared.soak.streams {
        let (name, channel) = (shared.name(stream), 10 + 2 * stream as u32);
        daemon.send(channel, Open { name: name.clone(), window: None, resolution: None })?;
        daemon.receive()?;
        daemon.send(channel, Commit { sequence: 0, time: Some(shared.start.elapsed().as_secs_f64()) })?;
        daemon.receive()?;
        daemon.send(channel + 1, subscribe(&name, Cut::Full, Simplify::No, None))?;
        let shown = loop {
            if let (_, Message::Snapshot(snapshot)) = daemon.receive()? {
                break snapshot.vertices;
            }
        };
        let bits = |&(x, y): &(f64, f64)| (x.to_bits(), y.to_bits());
        let shown: BTreeSet<_> = shown.iter().map(|&(_, x, y)| bits(&(x, y))).collect();
        let of_stream = left.iter().filter(|left| left.stream == name);
        let wanted: BTreeSet<_> = of_stream.flat_map(|left| left.points.iter().map(bits)).collect();
        if shown != wanted {
            shared.problem(format!("{name}: {} points are shown and {} are due", shown.len(), wanted.len()));
        }
    }
    daemon.send(2, StatusWanted {})?;
    let status = loop {
        if let (2, Message::Status(status)) = daemon.receive()? {
            break status;
        }
    };
    for stream in &status.streams {
        let (info, computed) = (&stream.info, stream.computed);
        println!(
            "{}: {} frames, {computed} skeletons computed, {} points accepted, {} refused",
            info.name, info.frame, stream.accepted, stream.refused
        );
        if computed > info.frame {
            shared.problem(format!("{}: {computed} skeletons for {} frames", info.name, info.frame));
        }
    }
    Ok(())
}

fn report(shared: &Shared, memory: &[(u64, u64)]) {
    let of = |counter: &AtomicU64| counter.load(Relaxed);
    println!(
        "{} frames proved by consumers, {} not sent singly, {} snapshots; {} resumed by diffs, {} not",
        of(&shared.frames),
        of(&shared.lagged),
        of(&shared.snapshots),
        of(&shared.resumed),
        of(&shared.not_resumed)
    );
    for (phase, latencies) in ["calm", "some stopped"].iter().zip(&shared.latencies) {
        let mut sorted = std::mem::take(&mut *latencies.lock().expect("no thread panics while it holds the lock"));
        sorted.sort_unstable_by(f64::total_cmp);
        let [median, high] = [0.5, 0.99].map(|share| percentile(&sorted, share) * 1e3);
        println!(
            "commit to consumer, {phase}: median {median:.2} ms, 99th percentile {high:.2} ms, of {}",
            sorted.len()
        );
    }
    let list: Vec<String> = memory.iter().map(|(now, _)| now.to_string()).collect();
    println!("memory of the daemon, MiB, phase by phase: {}", list.join(" "));
    if let (Some(&(early, _)), Some(&(late, most))) = (memory.get(memory.len() / 4), memory.last()) {
        println!("at the most {most} MiB");
        if late > early + early / 4 + 16 {
            shared.problem(format!("memory grew from {early} to {late} MiB"));
        }
    }
}
