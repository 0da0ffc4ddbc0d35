//! Progress on stderr, for people who wait.
//!
//! In: how far the work is.
//! Out: a bar or a spinner.
//! Invariants: nothing is shown if stderr is no terminal.
//! Must not know: what the work is.

use std::io::{self, IsTerminal};
use std::path::Path;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use crate::client::delivery::Progress;

/// How often a spinner turns.
pub const TICK: Duration = Duration::from_millis(100);

/// A bar over `length` units, in a form of `indicatif`.
pub fn bar(length: u64, template: &str) -> ProgressBar {
    if !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(length).with_style(style)
}

/// A spinner, for work without a known end.
pub fn spinner() -> ProgressBar {
    if !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{spinner} {msg} {elapsed}");
    let progress = ProgressBar::new_spinner().with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
    progress.enable_steady_tick(TICK);
    progress
}

/// Bytes of a file; 0 if they are not known.
pub fn length(file: &Path) -> u64 {
    std::fs::metadata(file).map_or(0, |data| data.len())
}

/// Shows a step of a delivery.
pub fn show(bar: &ProgressBar, step: Progress) {
    match step {
        Progress::Frames(frames) => bar.set_message(format!("{frames} frames")),
        Progress::Done => bar.finish_and_clear(),
    }
}
