//! Files and pipes that options name; - stands for stdin or stdout.
//!
//! In: paths of the command line.
//! Out: open sources and sinks, or which of them cannot be opened.
//! Invariants: a standard stream that was closed when the program started is an error where it is needed.
//! Must not know: what is read and written.

mod growing;
mod new_file;
mod patience;
mod points;
mod standard;

use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Read, Write};
use std::path::Path;

use anyhow::Context;

use super::Failure;
use crate::formats::messages::MessageForm;

pub use growing::Growing;
pub use new_file::NewFile;
pub use patience::end_in_time;
pub use points::{point_form, point_stdout};
pub use standard::{check_stdin, stdout};

/// What is said of a stdout that takes no more.
pub const CANNOT_WRITE_TO_STDOUT: &str = "cannot write to stdout";

/// Whether a path stands for stdin or stdout.
pub fn is_pipe(path: &Path) -> bool {
    path == Path::new("-")
}

/// The name of a file; none of a pipe.
pub fn name(path: &Path) -> Option<String> {
    (!is_pipe(path)).then(|| path.display().to_string())
}

/// The bytes of a file, or of stdin.
pub fn open(path: &Path) -> anyhow::Result<Box<dyn Read + Send>> {
    if is_pipe(path) {
        check_stdin()?;
        return Ok(Box::new(std::io::stdin()));
    }
    Ok(Box::new(File::open(path).with_context(|| format!("cannot open {}", path.display()))?))
}

/// Stdout, for bytes that a terminal cannot show; `instead` is what else can be done with them.
pub fn binary_stdout(what: &str, instead: &str) -> Result<File, Failure> {
    let stdout = stdout()?;
    if stdout.is_terminal() {
        return Err(Failure::usage(format!(
            "{what} is not written to a terminal: use {instead}, or send stdout to a file or another program"
        )));
    }
    Ok(stdout)
}

/// Stdout, for messages of this form.
pub fn message_stdout(form: MessageForm) -> Result<File, Failure> {
    match form {
        MessageForm::Bin => binary_stdout("a recording", "hopes record -o FILE or another --output"),
        MessageForm::Text | MessageForm::Events | MessageForm::Jsonl => Ok(stdout()?),
    }
}

/// A file that takes its place when it is whole.
pub fn create(path: &Path) -> anyhow::Result<NewFile> {
    NewFile::create(path).with_context(|| cannot_write(path))
}

/// Refuses a file that could never be made, before the work for it is done.
pub fn check_place(path: &Path) -> anyhow::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let place = std::fs::metadata(folder);
    let reason = match place {
        Ok(place) if !place.is_dir() => Some(io::ErrorKind::NotADirectory.into()),
        Ok(_) if path.is_dir() => Some(io::ErrorKind::IsADirectory.into()),
        Ok(_) => None,
        Err(error) => Some(error),
    };
    reason.map_or(Ok(()), |error: io::Error| Err(error).with_context(|| cannot_write(path)))
}

/// A file that is seen while it grows, without a known end.
pub fn grow(path: &Path) -> anyhow::Result<Growing> {
    Growing::open(path).with_context(|| cannot_write(path))
}

/// What is said of a file that cannot be written.
pub fn cannot_write(path: &Path) -> String {
    format!("cannot write {}", path.display())
}

/// With room for many small writes.
pub fn buffered<W: Write>(sink: W) -> BufWriter<W> {
    BufWriter::with_capacity(1 << 16, sink)
}
