//! `hopes record`: streams of a daemon into a file, as they were sent and when.
//!
//! In: options.
//! Out: a recording (protocol/SPEC.md, section 8).
//! Invariants: the file has whole frames only, each written as it comes; every frame in it was proved.
//! Must not know: what is in frames.

use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use indicatif::HumanBytes;

use super::args::FollowArgs;
use super::following::Shown;
use super::{Failure, files, progress};
use crate::client::follow::follow;
use crate::formats::messages::{MessageForm, MessageWriter};

/// Record streams of a daemon to a file, for replay.
///
/// Writes what a consumer is sent, with its times. Every frame is proved by its checksum. Ends with the daemon, on
/// Ctrl-C, or after --frames. What was written until then is good, however it ends.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  hopes record --from unix:/tmp/hopes.sock --stream camera -o camera2.hopes
  hopes record --from tcp:127.0.0.1:7878 --stream camera --frames 20 -o - | hopes replay - --fast")]
pub struct Record {
    /// Where to write it; - for stdout.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    wanted: FollowArgs,
}

impl Record {
    pub fn run(self) -> Result<(), Failure> {
        let wanted = self.wanted.subscription()?;
        let sink: Box<dyn Write> = if files::is_pipe(&self.output) {
            Box::new(io::stdout().lock())
        } else {
            Box::new(files::create(&self.output)?)
        };
        let writer = MessageWriter::new(MessageForm::Bin, sink);
        let writer = writer.with_context(|| files::cannot_write(&self.output))?;
        let mut shown = Shown { writer, progress: progress::spinner() };
        let ended = follow(&wanted, &mut shown);
        shown.progress.finish_and_clear();
        let frames = ended?;
        tracing::info!("{frames} frames recorded, {}", HumanBytes(shown.writer.bytes_written()));
        Ok(())
    }
}
