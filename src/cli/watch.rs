//! `hopes watch`: streams of a daemon, as they change, on stdout.
//!
//! In: options. Out: a line a frame, JSON lines, or a recording. Invariants: a closed pipe and a polite signal are no errors. Must not know: how streams are followed or shown.

use std::io::{self, BufWriter};

use clap::Args;
use hopes_protocol::{DotsWanted, Simplify, TracksWanted};
use indicatif::ProgressBar;

use super::Failure;
use super::args::{From, WireViewArgs, dots, pattern, tracks};
use super::follow::{Subscription, follow};
use super::show::{Output, Show};

/// Follow streams of a daemon: a line a frame with what changed.
///
/// Every frame is proved by its checksum; after a gap it says so, and subscribes again. Ends with the daemon, on Ctrl-C, or after --frames.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  hopes watch --from unix:/tmp/hopes.sock                          the stream called default, for people
  hopes watch --from tcp:127.0.0.1:7878 --stream 'cam*' --dots 3   all streams whose names begin with cam
  hopes watch --from unix:/tmp/hopes.sock --tracks                 what happens to tracks, besides
  hopes watch --from unix:/tmp/hopes.sock --output events          what happens to tracks, and nothing else
  hopes watch --from unix:/tmp/hopes.sock --output jsonl | jq -c '[.frame, .view.cycles]'")]
pub struct Watch {
    #[command(flatten)]
    from: From,
    /// Name of the stream, or a pattern in which * stands for any characters; it may still be to come.
    #[arg(long, value_name = "NAME", default_value = "default", value_parser = pattern)]
    stream: String,
    #[command(flatten)]
    view: WireViewArgs,
    /// Also show the most persistent dots whenever they change: so many, or all.
    #[arg(long, value_name = "N|all", value_parser = dots)]
    dots: Option<DotsWanted>,
    /// Also tell what happens to tracks; the daemon follows them if it was started with --track. With "all", JSON lines list all living tracks in every frame.
    #[arg(long, value_name = "events|all", value_parser = tracks, num_args = 0..=1, require_equals = true, default_missing_value = "events")]
    tracks: Option<TracksWanted>,
    /// How frames are written on stdout.
    #[arg(long, value_enum, default_value_t)]
    output: Output,
    /// End after so many frames.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames: Option<u64>,
    /// Recompute every frame from its vertices and compare; stop at a difference or a gap (exit code 1). Slow: for those who want to be sure.
    #[arg(long)]
    check: bool,
    /// Connect again when the connection is lost or the daemon says goodbye, for up to a minute, and resume where possible.
    #[arg(long)]
    reconnect: bool,
}

impl Watch {
    pub fn run(self) -> Result<(), Failure> {
        let view = self.view.view()?;
        let events = (self.output == Output::Events).then_some(TracksWanted::Events);
        if self.check && view.simplify != Simplify::No {
            return Err(Failure::Usage("--check needs all vertices: leave out --simplify"));
        }
        let wanted = Subscription {
            from: self.from.from,
            pattern: self.stream,
            view,
            dots: self.dots.unwrap_or(DotsWanted::No),
            tracks: self.tracks.or(events).unwrap_or_default(),
            frames: self.frames,
            check: self.check,
            reconnect: self.reconnect,
        };
        let sink = BufWriter::with_capacity(1 << 16, io::stdout().lock());
        let mut show = Show::new(self.output, sink)?;
        let frames = follow(&wanted, &mut show, &ProgressBar::hidden())?;
        tracing::debug!("{frames} frames");
        Ok(())
    }
}
