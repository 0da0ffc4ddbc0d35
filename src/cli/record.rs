//! `hopes record`: streams of a daemon into a file, as they were sent and when.
//!
//! In: options. Out: a recording (protocol/SPEC.md, section 8). Invariants: the file has whole frames only, each written as it comes; every frame in it was proved. Must not know: what frames say.

use std::fs::File;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context;
use clap::Args;
use indicatif::{HumanBytes, ProgressBar, ProgressStyle};

use super::Failure;
use super::args::FollowArgs;
use crate::client::follow::follow;
use crate::formats::messages::{Output, Show};

/// Record streams of a daemon to a file, for replay.
///
/// Ends with the daemon, on Ctrl-C, or after --frames. What was written until then is good, however it ends.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  hopes record --from unix:/tmp/hopes.sock --stream camera -o camera.hopes
  hopes record --from tcp:127.0.0.1:7878 --stream camera --full --frames 100 -o - | hopes replay - --fast")]
pub struct Record {
    #[command(flatten)]
    wanted: FollowArgs,
    /// Where to write it; - for stdout.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

impl Record {
    pub fn run(self) -> Result<(), Failure> {
        let wanted = self.wanted.subscription()?;
        let unwritten = || format!("cannot write {}", self.output.display());
        let sink: Box<dyn Write> = if self.output == Path::new("-") {
            Box::new(io::stdout().lock())
        } else {
            Box::new(File::create(&self.output).with_context(unwritten)?)
        };
        let mut show = Show::new(Output::Bin, sink).with_context(unwritten)?;
        let progress = spinner();
        let ended = follow(&wanted, &mut show, &progress);
        progress.finish_and_clear();
        let frames = ended?;
        tracing::info!("{frames} frames recorded, {}", HumanBytes(show.recorded()));
        Ok(())
    }
}

fn spinner() -> ProgressBar {
    if !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{spinner} {msg} {elapsed}");
    let progress = ProgressBar::new_spinner().with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
    progress.enable_steady_tick(Duration::from_millis(100));
    progress
}
