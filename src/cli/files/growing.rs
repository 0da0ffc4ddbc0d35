//! A file that is seen while it grows, without a known end.
//!
//! In: a path, bytes.
//! Out: the file.
//! Invariants: what was written is there for others at once. Until the first bytes are written, the path has what it
//! had before, or nothing.
//! Must not know: what is written.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A file that grows.
#[derive(Debug)]
pub struct Growing {
    path: PathBuf,
    /// None until there are bytes for it.
    file: Option<File>,
    /// Whether it still has what it had before.
    has_old: bool,
}

impl Growing {
    /// Finds out whether it can be written.
    ///
    /// # Errors
    /// Those of a plain creation.
    pub fn open(path: &Path) -> io::Result<Self> {
        let (file, has_old) = match fs::metadata(path) {
            Ok(data) if data.is_file() => (Some(OpenOptions::new().write(true).open(path)?), data.len() > 0),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                try_to_create(path)?;
                (None, false)
            }
            // What is no file, such as a pipe, has nothing to lose.
            _ => (Some(File::create(path)?), false),
        };
        Ok(Self { path: path.to_owned(), file, has_old })
    }

    /// Whether it still has what it had before it was opened.
    pub fn has_old(&self) -> bool {
        self.has_old
    }

    fn file(&mut self) -> io::Result<&mut File> {
        match &mut self.file {
            Some(file) => {
                if std::mem::take(&mut self.has_old) {
                    file.set_len(0)?;
                }
                Ok(file)
            }
            none => Ok(none.insert(File::create(&self.path)?)),
        }
    }
}

impl Write for Growing {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file()?.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.as_mut().map_or(Ok(()), File::flush)
    }
}

/// Leaves nothing behind.
fn try_to_create(path: &Path) -> io::Result<()> {
    match OpenOptions::new().write(true).create_new(true).open(path) {
        Ok(_) => fs::remove_file(path),
        // A link to nothing is there, and becomes a file when bytes are written.
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Ok(()),
        Err(error) => Err(error),
    }
}
