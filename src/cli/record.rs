//! `hopes record`: streams of a daemon into a file, as they were sent and when.
//!
//! In: options.
//! Out: a recording (protocol/SPEC.md, section 8).
//! Invariants: the file has whole frames only, each written as it comes; every frame in it was proved. It ends with an
//! end, unless this program was killed.
//! Must not know: what is in frames.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use indicatif::HumanBytes;

use super::args::FollowArgs;
use super::following::Shown;
use super::{Failure, files, progress};
use crate::client::follow::{Subscription, follow};
use crate::formats::messages::{MessageForm, MessageWriter};

/// Record streams of a daemon to a file, for replay.
///
/// Writes what a consumer is sent, with its times. Every frame is proved by its checksum. Ends with the daemon, on
/// Ctrl-C, or after --frames. What was written until then is good, however it ends. A recording that was cut is known
/// by its missing end.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  hopes record --stream camera --frames 20 -o camera1.hopes
  hopes record --from unix:/tmp/hopes.sock --stream camera -o camera2.hopes
  hopes record --from tcp:127.0.0.1:7878 --stream camera --frames 20 -o - | hopes replay - --fast")]
pub struct Record {
    /// Where to write it; - for stdout.
    ///
    /// It grows message by message, so that it can be read meanwhile and outlives this program. A file that is there is
    /// replaced when the first frame comes.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    wanted: FollowArgs,
}

impl Record {
    pub fn run(self) -> Result<(), Failure> {
        let Self { output, wanted } = self;
        let wanted = wanted.subscription()?;
        if files::is_pipe(&output) {
            return record(&wanted, &output, files::message_stdout(MessageForm::Bin)?, false);
        }
        let file = files::grow(&output)?;
        let has_old = file.has_old();
        record(&wanted, &output, file, has_old)
    }
}

/// Records; what is there already stays until something comes.
fn record(wanted: &Subscription, output: &Path, sink: impl Write, has_old: bool) -> Result<(), Failure> {
    let progress = progress::spinner();
    let mut writer = MessageWriter::new(MessageForm::Bin, sink);
    if wanted.has_many() {
        writer.set_mixed();
    }
    let mut shown = Shown::new(writer, progress.clone());
    let ended = follow(wanted, &mut shown);
    progress.finish_and_clear();
    let is_kept = has_old && shown.bytes_written() == 0;
    let finished = if is_kept { Ok(()) } else { shown.finish(&ended) };
    if ended.is_ok() || shown.frames() > 0 {
        tracing::info!("{} frames recorded, {}", shown.frames(), HumanBytes(shown.bytes_written()));
    }
    if is_kept && ended.is_ok() {
        tracing::info!("{} is left as it was", output.display());
    }
    ended?;
    Ok(finished.with_context(|| files::cannot_write(output))?)
}
