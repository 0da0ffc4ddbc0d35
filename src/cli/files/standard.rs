//! Stdin and stdout as they were when the program started.
//!
//! In: nothing.
//! Out: the open stream, or that it is closed.
//! Invariants: what is written to stdout is written, or an error. Before `main` the standard library opens /dev/null in
//! the place of a closed standard stream, and it takes a stdout that cannot be written for one that was. Both would
//! lose all output and report success. So what is closed is asked before that, and stdout is written as the file that
//! it is. A stdout that leads to /dev/null on purpose is a stdout as any other.
//! Must not know: what is read and written.

use std::fs::File;
use std::io;
use std::os::fd::AsFd;

use anyhow::{Context, anyhow};

/// Stdout, without a buffer.
pub fn stdout() -> anyhow::Result<File> {
    if hopes_startup::is_stdout_closed() {
        return Err(anyhow!("stdout is closed: send it to a file or a pipe, or to /dev/null if it is not wanted"))
            .context(super::CANNOT_WRITE_TO_STDOUT);
    }
    let stdout = io::stdout().as_fd().try_clone_to_owned();
    stdout.map(File::from).context(super::CANNOT_WRITE_TO_STDOUT)
}

/// Whether stdin is there to be read; one that is closed has no end that could be told from an empty one.
pub fn check_stdin() -> anyhow::Result<()> {
    if hopes_startup::is_stdin_closed() {
        return Err(anyhow!("stdin is closed: send points in, or /dev/null if there are none"))
            .context("cannot read stdin");
    }
    Ok(())
}
