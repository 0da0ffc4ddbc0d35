//! Files and pipes that options name; - stands for stdin or stdout.
//!
//! In: paths of the command line.
//! Out: open sources and sinks, or which of them cannot be opened.
//! Must not know: what is read and written.

use std::fs::File;
use std::io::{self, BufWriter, Read, Write};
use std::path::Path;

use anyhow::Context;

/// Whether a path stands for stdin or stdout.
pub fn is_pipe(path: &Path) -> bool {
    path == Path::new("-")
}

/// The bytes of a file, or of stdin.
pub fn open(path: &Path) -> anyhow::Result<Box<dyn Read + Send>> {
    if is_pipe(path) {
        return Ok(Box::new(io::stdin()));
    }
    Ok(Box::new(File::open(path).with_context(|| format!("cannot open {}", path.display()))?))
}

/// A new file, in the place of one that is there.
pub fn create(path: &Path) -> anyhow::Result<File> {
    File::create(path).with_context(|| cannot_write(path))
}

/// What is said of a file that cannot be written.
pub fn cannot_write(path: &Path) -> String {
    format!("cannot write {}", path.display())
}

/// With room for many small writes.
pub fn buffered<W: Write>(sink: W) -> BufWriter<W> {
    BufWriter::with_capacity(1 << 16, sink)
}
