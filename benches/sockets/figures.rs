//! Single figures: latency, ingest, bytes.
//!
//! In: the program and sizes. Out: one line for each. Invariants: both sides of a comparison do the same work on the
//! same points in one run.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use hopes_protocol::{Batch, Commit, Cut, Message, Mirror, Open, Simplify, Window};

use crate::daemon::Daemon;
use crate::peer::{Peer, subscribe};

const CHANNEL: u32 = 1;

/// Random numbers that are the same in every run.
pub struct Random(pub u64);

impl Random {
    /// From 0 to 1.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform points of the unit square.
    pub fn points(&mut self, count: usize) -> Vec<(f64, f64)> {
        (0..count).map(|_| (self.unit(), self.unit())).collect()
    }
}

fn batch(sequence: u64, points: Vec<(f64, f64)>) -> Batch {
    Batch { sequence, points, times: Vec::new(), tags: Vec::new() }
}

/// A percentile of sorted numbers.
pub fn percentile(sorted: &[f64], share: f64) -> f64 {
    sorted
        .get(((sorted.len() as f64 * share) as usize).min(sorted.len().saturating_sub(1)))
        .copied()
        .unwrap_or(f64::NAN)
}

pub fn latency(hopes: &Path, points: usize, replace: usize, frames: usize, rate: f64) -> anyhow::Result<()> {
    let mut random = Random(7);
    let first = random.points(points);
    let batches: Vec<_> = (0..frames).map(|_| random.points(replace)).collect();
    let (daemon, log) = Daemon::start_traced(hopes)?;
    let engine = thread::spawn(move || engine_times(log));
    let start = Instant::now();
    let socket = daemon.socket.clone();
    let mut producer = Peer::connect(&socket)?;
    let window = Some(Window::Points(points as u64));
    producer.send(CHANNEL, Open { name: "s".to_owned(), window, resolution: None })?;
    let total = frames as u64 + 1;
    let (ready, begin) = std::sync::mpsc::channel();
    let consumer = thread::spawn(move || -> anyhow::Result<Vec<f64>> {
        let mut consumer = Peer::connect(&socket)?;
        consumer.send(CHANNEL, subscribe("s", Cut::Derived(1, 1), Simplify::No, None))?;
        let (mut mirror, mut held) = (Mirror::new(), Vec::new());
        while mirror.number() < total {
            match consumer.receive()?.1 {
                Message::StreamOpened(_) => ready.send(())?,
                Message::Snapshot(snapshot) => mirror.apply_snapshot(&snapshot)?,
                Message::Diff(diff) => {
                    let now = start.elapsed().as_secs_f64();
                    mirror.apply_diff(&diff)?;
                    held.push(now - diff.frame.time.unwrap_or(f64::NAN));
                }
                _ => {}
            }
        }
        Ok(held)
    });
    begin.recv()?;
    let mut due = Instant::now();
    for (place, points) in std::iter::once(first).chain(batches).enumerate() {
        let batch = batch(place as u64, points);
        let time = Some(start.elapsed().as_secs_f64());
        producer.send(CHANNEL, batch)?;
        producer.send(CHANNEL, Commit { sequence: place as u64, time })?;
        while !matches!(producer.receive()?.1, Message::Committed(_)) {}
        due += Duration::from_secs_f64(1.0 / rate);
        thread::sleep(due.saturating_duration_since(Instant::now()));
    }
    let mut held = consumer.join().map_err(|_| anyhow::anyhow!("the consumer panicked"))??;
    daemon.stop()?;
    // The consumer has the first frame as a snapshot.
    let mut alone = engine.join().map_err(|_| anyhow::anyhow!("reading the log panicked"))?.split_off(1);
    anyhow::ensure!(alone.len() == held.len(), "{} frames in the log, {} with the consumer", alone.len(), held.len());
    let mut added: Vec<f64> = held.iter().zip(&alone).map(|(held, alone)| held - alone).collect();
    for list in [&mut held, &mut alone, &mut added] {
        list.sort_unstable_by(f64::total_cmp);
    }
    println!("{points} points, {replace} replaced a frame, {frames} frames, milliseconds: median, 99th percentile");
    for (name, list) in [("commit to consumer", &held), ("of which the engine", &alone), ("the daemon adds", &added)] {
        println!("{name:20} {:8.3} {:8.3}", percentile(list, 0.5) * 1e3, percentile(list, 0.99) * 1e3);
    }
    Ok(())
}

/// The seconds that each frame took the engine, from the daemon's log.
fn engine_times(log: impl Read) -> Vec<f64> {
    let mut times = Vec::new();
    for line in BufReader::new(log).lines().map_while(Result::ok) {
        let said = line.rsplit_once(" took ").filter(|(before, _)| before.contains("frame"));
        let Some((_, duration)) = said else { continue };
        let number = duration.trim_end_matches(|unit: char| !unit.is_ascii_digit());
        let scale = match &duration[number.len()..] {
            "s" => 1.0,
            "ms" => 1e-3,
            "µs" => 1e-6,
            _ => 1e-9,
        };
        times.push(number.parse::<f64>().map_or(f64::NAN, |number| number * scale));
    }
    times
}

pub fn ingest(hopes: &Path, points: usize) -> anyhow::Result<()> {
    const TOGETHER: usize = 8192;
    let daemon = Daemon::start(hopes, &[])?;
    let mut producer = Peer::connect(&daemon.socket)?;
    let window = Some(Window::Points(100_000));
    producer.send(CHANNEL, Open { name: "s".to_owned(), window, resolution: None })?;
    let mut random = Random(3);
    let pieces: Vec<Vec<u8>> = (0..32)
        .map(|place| {
            let message = Message::from(batch(place, random.points(TOGETHER)));
            hopes_protocol::encode(hopes_protocol::VERSION, CHANNEL, &message)
        })
        .collect::<Result<_, _>>()?;
    let batches = points / TOGETHER;
    let mut wire = producer.split()?;
    let begun = Instant::now();
    let sender = thread::spawn(move || {
        (0..batches).try_for_each(|place| std::io::Write::write_all(&mut wire, &pieces[place % pieces.len()]))
    });
    let mut accepted = 0;
    while accepted < (batches * TOGETHER) as u64 {
        if let (_, Message::Accepted(answer)) = producer.receive()? {
            accepted += u64::from(answer.points);
        }
    }
    let seconds = begun.elapsed().as_secs_f64();
    sender.join().map_err(|_| anyhow::anyhow!("the sender panicked"))??;
    println!("{accepted} points in {seconds:.2} s: {:.2} million a second", accepted as f64 / seconds / 1e6);
    println!("memory of the daemon at the most: {} MiB", daemon.memory().1);
    daemon.stop()?;
    Ok(())
}

pub fn bytes(hopes: &Path, points: usize, replace: usize) -> anyhow::Result<()> {
    let daemon = Daemon::start(hopes, &[])?;
    let mut producer = Peer::connect(&daemon.socket)?;
    let window = Some(Window::Points(points as u64));
    producer.send(CHANNEL, Open { name: "s".to_owned(), window, resolution: None })?;
    let mut random = Random(5);
    // The oldest points are replaced. They form stripes, so they are in one place.
    let stripes = points.div_ceil(replace);
    let mut stripe = |place: usize| -> Vec<(f64, f64)> {
        let left = (place % stripes) as f64 / stripes as f64;
        random.points(replace).into_iter().map(|(x, y)| (left + x / stripes as f64, y)).collect()
    };
    for place in 0..stripes {
        producer.send(CHANNEL, batch(place as u64, stripe(place)))?;
    }
    producer.send(CHANNEL, Commit { sequence: 0, time: None })?;
    while !matches!(producer.receive()?.1, Message::Committed(_)) {}
    for (name, cut) in [("full", Cut::Full), ("derived (1, 1)", Cut::Derived(1, 1))] {
        let mut consumer = Peer::connect(&daemon.socket)?;
        consumer.send(CHANNEL, subscribe("s", cut, Simplify::No, None))?;
        let mut mirror = Mirror::new();
        while mirror.number() == 0 {
            if let (_, Message::Snapshot(snapshot)) = consumer.receive()? {
                mirror.apply_snapshot(&snapshot)?;
            }
        }
        let whole = consumer.received;
        let mut sizes = Vec::new();
        for place in 0..20 {
            producer.send(CHANNEL, batch(place as u64, stripe(place)))?;
            producer.send(CHANNEL, Commit { sequence: 0, time: None })?;
            let before = consumer.received;
            let number = mirror.number();
            while mirror.number() == number {
                if let (_, Message::Diff(diff)) = consumer.receive()? {
                    mirror.apply_diff(&diff)?;
                }
            }
            sizes.push((consumer.received - before) as f64);
        }
        sizes.sort_unstable_by(f64::total_cmp);
        let (median, most) = (percentile(&sizes, 0.5), percentile(&sizes, 1.0));
        println!(
            "{points} points, {replace} replaced in one place, {name}: a frame {median} bytes, {most} at the most; a snapshot {whole}: {:.2}%",
            median / whole as f64 * 100.0
        );
    }
    daemon.stop()?;
    Ok(())
}
