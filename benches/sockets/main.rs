//! The cost of a daemon's sockets, and a load test: `cargo run --release --example sockets --
//! latency|ingest|bytes|crowd|soak`.
//!
//! In: options; the program `hopes` of the same build, which is started for each run. Out: a table on stdout. The exit
//! code is 1 if an invariant is violated.
//!
//! Invariants: the content of every consumer is verified by its checksum. Must not know: how the daemon works inside.

mod crowd;
mod daemon;
mod figures;
mod peer;
mod soak;

use std::path::PathBuf;

use clap::{Parser, Subcommand};

/// Measure a daemon's sockets.
#[derive(Debug, Parser)]
struct Args {
    /// The program to measure [default: the one beside this].
    #[arg(long, global = true)]
    hopes: Option<PathBuf>,
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// From a commit until a consumer has the frame, compared with the engine's own time.
    Latency {
        /// Vertices.
        #[arg(long, default_value_t = 10_000)]
        points: usize,
        /// Points replaced in each frame.
        #[arg(long, default_value_t = 1_000)]
        replace: usize,
        /// Frames.
        #[arg(long, default_value_t = 600)]
        frames: usize,
        /// Frames in a second.
        #[arg(long, default_value_t = 20.0)]
        rate: f64,
    },
    /// Points in a second, without frames.
    Ingest {
        /// Number of points.
        #[arg(long, default_value_t = 20_000_000)]
        points: usize,
    },
    /// Bytes of a frame, compared with those of a snapshot.
    Bytes {
        /// Vertices.
        #[arg(long, default_value_t = 100_000)]
        points: usize,
        /// Points replaced in each frame, in one place.
        #[arg(long, default_value_t = 1_000)]
        replace: usize,
    },
    /// Many consumers of one stream, with and without some that are stopped and some that flood.
    Crowd(crowd::Crowd),
    /// Many peers, some of them badly behaved.
    Soak(soak::Soak),
}

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    let beside = std::env::current_exe()?.parent().and_then(|examples| Some(examples.parent()?.join("hopes")));
    let hopes = args.hopes.or(beside).filter(|path| path.exists());
    let hopes = hopes.ok_or_else(|| anyhow::anyhow!("there is no hopes beside this: build it, or give --hopes"))?;
    match args.what {
        What::Latency { points, replace, frames, rate } => figures::latency(&hopes, points, replace, frames, rate),
        What::Ingest { points } => figures::ingest(&hopes, points),
        What::Bytes { points, replace } => figures::bytes(&hopes, points, replace),
        What::Crowd(crowd) => crowd.run(&hopes),
        What::Soak(soak) => soak.run(&hopes),
    }
}
