//! A file that takes its place when it is whole.
//!
//! In: a path, bytes.
//! Out: the file under that path, once it is finished.
//! Invariants: until then, and if it is never finished, the path has what it had before. What is written grows in the
//! same folder, without a name where the system can do that, so that nothing is left of a program that is killed.
//! Permissions are those of a plain creation, or of the file that is replaced; links are followed. What no file can
//! take the place of (a device, a pipe, a mount) is written as it is.
//! Must not know: what is written.

use std::fs::{self, File, Metadata, OpenOptions, Permissions};
use std::io::{self, Write};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{MetadataExt, PermissionsExt, fchown};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile, TempPath};

/// How the name of an unfinished file begins, where it has one.
const PREFIX: &str = ".hopes-";

/// Links that lead to each other end here, as they do for the system.
const LINKS: usize = 40;

/// What a new file may be, before the umask.
const NEW: u32 = 0o666;

/// What of a mode is kept: a file that is written loses the other bits.
const MODE: u32 = 0o777;

/// A file that is not finished yet. Several writers may share it.
#[derive(Debug)]
pub struct NewFile {
    file: File,
    place: Place,
}

#[derive(Debug)]
enum Place {
    /// It is what is written.
    Taken,
    /// It is still to be taken.
    Free { unfinished: Unfinished, target: PathBuf },
}

/// The name of an unfinished file.
#[derive(Debug)]
enum Unfinished {
    Named(TempPath),
    #[cfg(target_os = "linux")]
    Nameless,
}

impl NewFile {
    /// Begins.
    ///
    /// # Errors
    /// Those of a plain creation.
    pub fn create(path: &Path) -> io::Result<Self> {
        let Some(target) = replaceable(path) else { return Self::plain(path) };
        let replaced = match fs::metadata(&target) {
            Ok(replaced) if replaced.is_file() => {
                // A file that may not be written may not be replaced.
                OpenOptions::new().write(true).open(&target)?;
                Some(replaced)
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            _ => return Self::plain(path),
        };
        // In a folder that takes no new file, the file itself can still be written.
        let Ok((file, unfinished)) = unfinished(folder(&target)) else { return Self::plain(path) };
        match replaced.map_or(Ok(()), |replaced| resemble(&file, &replaced)) {
            Ok(()) => Ok(Self { file, place: Place::Free { unfinished, target } }),
            Err(_) => Self::plain(path),
        }
    }

    fn plain(path: &Path) -> io::Result<Self> {
        Ok(Self { file: File::create(path)?, place: Place::Taken })
    }

    /// Takes the place.
    ///
    /// # Errors
    /// Those of the system. The path has what it had before, unless it had to be written as it is.
    pub fn finish(self) -> io::Result<()> {
        let Place::Free { unfinished, target } = self.place else { return Ok(()) };
        // The new bytes must be there before the old ones are given up, even if the machine stops.
        self.file.sync_all()?;
        let unfinished = match unfinished {
            Unfinished::Named(path) => path,
            #[cfg(target_os = "linux")]
            Unfinished::Nameless => named(&self.file, folder(&target))?,
        };
        match unfinished.persist(&target) {
            Ok(()) => Ok(()),
            // A file that is mounted by itself, or that only its owner may rename: it was found to be writable.
            Err(error) if is_fixed(&error.error) && target.exists() => {
                io::copy(&mut File::open(&error.path)?, &mut File::create(&target)?).map(drop)
            }
            Err(error) => Err(error.error),
        }
    }
}

impl Write for &NewFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        (&self.file).write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        (&self.file).flush()
    }
}

/// The file that a plain creation would write, if another one can take its place.
fn replaceable(path: &Path) -> Option<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..LINKS {
        // The names of open files lead to a path too, but what is written there goes where that file stands.
        if path.as_os_str().as_bytes().ends_with(b"/") || is_of_system(folder(&path)) {
            return None;
        }
        match fs::read_link(&path) {
            Ok(link) => path = folder(&path).join(link),
            Err(_) => return path.file_name().is_some().then_some(path),
        }
    }
    None
}

fn is_of_system(folder: &Path) -> bool {
    let folder = folder.canonicalize().unwrap_or_default();
    folder == Path::new("/dev") || folder.starts_with("/dev/fd") || folder.starts_with("/proc")
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// An empty file that no other program knows of.
fn unfinished(folder: &Path) -> io::Result<(File, Unfinished)> {
    #[cfg(target_os = "linux")]
    if let Ok(file) = nameless(folder) {
        return Ok((file, Unfinished::Nameless));
    }
    let file = Builder::new().prefix(PREFIX).permissions(Permissions::from_mode(NEW)).tempfile_in(folder)?;
    let (file, path) = NamedTempFile::into_parts(file);
    Ok((file, Unfinished::Named(path)))
}

/// A file without a name. Not every file system has them.
#[cfg(target_os = "linux")]
fn nameless(folder: &Path) -> io::Result<File> {
    use rustix::fs::{Mode, OFlags};
    let flags = OFlags::TMPFILE | OFlags::WRONLY | OFlags::CLOEXEC;
    let file = File::from(rustix::fs::open(folder, flags, Mode::from_raw_mode(NEW))?);
    // Without the names of open files it could never be given one.
    fs::metadata(name_of_open(&file))?;
    Ok(file)
}

#[cfg(target_os = "linux")]
fn name_of_open(file: &File) -> String {
    use std::os::fd::AsRawFd;
    format!("/proc/self/fd/{}", file.as_raw_fd())
}

/// Names a file without a name.
#[cfg(target_os = "linux")]
fn named(file: &File, folder: &Path) -> io::Result<TempPath> {
    use rustix::fs::{AtFlags, CWD, linkat};
    let open = name_of_open(file);
    let link = |path: &Path| Ok(linkat(CWD, &open, CWD, path, AtFlags::SYMLINK_FOLLOW)?);
    Ok(Builder::new().prefix(PREFIX).make_in(folder, link)?.into_temp_path())
}

/// Whether a name cannot be given to another file, though the file of that name may be written.
fn is_fixed(error: &io::Error) -> bool {
    use io::ErrorKind::{CrossesDevices, PermissionDenied, ResourceBusy};
    matches!(error.kind(), CrossesDevices | PermissionDenied | ResourceBusy)
}

/// Gives a file the owner and the mode of the one that it replaces.
fn resemble(file: &File, replaced: &Metadata) -> io::Result<()> {
    let ours = file.metadata()?;
    if (ours.uid(), ours.gid()) != (replaced.uid(), replaced.gid()) {
        fchown(file, Some(replaced.uid()), Some(replaced.gid()))?;
    }
    file.set_permissions(Permissions::from_mode(replaced.mode() & MODE))
}
