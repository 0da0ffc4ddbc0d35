//! `hopes watch`: streams of a daemon, as they change, on stdout.
//!
//! In: options.
//! Out: a line a frame, events, JSON lines, or a recording.
//! Invariants: a closed pipe and a first signal are no errors, unless a signal comes while nobody reads the output.
//! Must not know: how streams are followed, how messages are written.

use anyhow::Context;
use clap::Args;
use hopes_protocol::{Simplify, TracksWanted};
use indicatif::ProgressBar;

use super::args::FollowArgs;
use super::following::Shown;
use super::{Failure, files};
use crate::client::follow::follow;
use crate::formats::messages::{MessageForm, MessageWriter};

/// Follow streams of a daemon: a line a frame with what changed.
///
/// Every frame is proved by its checksum. A gap is reported, and closed by a new subscription. Ends with the daemon, on
/// Ctrl-C, or after --frames.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  hopes watch                                                      the stream default
  hopes watch --from unix:/tmp/hopes.sock                          of the one at this address
  hopes watch --from tcp:127.0.0.1:7878 --stream 'cam*' --dots 3   all whose names begin with cam
  hopes watch --from unix:/tmp/hopes.sock --tracks                 also what happens to tracks
  hopes watch --from unix:/tmp/hopes.sock --output events          only what happens to tracks
  hopes watch --from unix:/tmp/hopes.sock --output jsonl | jq -c '[.frame, .view.cycles]'")]
pub struct Watch {
    /// How frames are written on stdout.
    #[arg(long, value_enum, default_value_t)]
    output: MessageForm,
    /// Recompute every frame from its vertices and compare; stop at a difference or a gap (exit code 1). Slow.
    #[arg(long)]
    check: bool,
    #[command(flatten)]
    wanted: FollowArgs,
}

impl Watch {
    pub fn run(self) -> Result<(), Failure> {
        let mut wanted = self.wanted.subscription()?;
        wanted.check = self.check;
        if wanted.check && wanted.view.simplify != Simplify::No {
            return Err(Failure::usage("--check needs all vertices: leave out --simplify"));
        }
        if self.output == MessageForm::Events && wanted.tracks == TracksWanted::No {
            wanted.tracks = TracksWanted::Events;
        }
        let mut writer = MessageWriter::new(self.output, files::buffered(files::message_stdout(self.output)?));
        if wanted.has_many() {
            writer.set_mixed();
        }
        let mut shown = Shown::new(writer, ProgressBar::hidden());
        let ended = follow(&wanted, &mut shown);
        let finished = shown.finish(&ended);
        // A log line that nobody wants evaluates nothing.
        let frames = ended?.frames;
        tracing::debug!("{frames} frames");
        Ok(finished.context("cannot write frames")?)
    }
}
