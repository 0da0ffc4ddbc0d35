//! Which files are meant: those that are named, and the pictures of folders that are named.
//!
//! In: names.
//! Out: files, in order.
//! Invariants: the pictures of a folder come in natural order of their names: 2 before 10. A name that cannot be
//! opened is refused before anything is read.
//! Must not know: what is in files.
//!
//! Natural order is ours, not that of the crate `natord`: that one skips blanks and compares numbers that begin
//! with a zero as fractions, so that `f002` would not stand beside `f2`.

use std::cmp::Ordering;
use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Stands for stdin.
pub const STDIN: &str = "-";

/// Endings of the names of pictures, in any case.
const ENDINGS: [&str; 3] = ["png", "jpg", "jpeg"];

/// Why files cannot be listed.
#[derive(Debug, Error)]
pub enum ListError {
    /// A name that leads to nothing.
    #[error("cannot open {}", path.display())]
    Open {
        /// The name.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A folder that cannot be read.
    #[error("cannot list {}", path.display())]
    List {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A folder without pictures.
    #[error("there is no picture in {}: their names end in .png, .jpg or .jpeg", path.display())]
    NoPicture {
        /// The folder.
        path: PathBuf,
    },
}

/// All files that are meant by these names.
///
/// # Errors
/// [`ListError`].
pub fn listed(names: &[PathBuf]) -> Result<Vec<PathBuf>, ListError> {
    let mut files = Vec::new();
    for name in names {
        if name == Path::new(STDIN) {
            files.push(name.clone());
            continue;
        }
        let data = std::fs::metadata(name).map_err(|source| ListError::Open { path: name.clone(), source })?;
        if data.is_dir() {
            files.extend(pictures(name)?);
        } else {
            files.push(name.clone());
        }
    }
    Ok(files)
}

fn pictures(folder: &Path) -> Result<Vec<PathBuf>, ListError> {
    let unread = |source| ListError::List { path: folder.to_owned(), source };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unread)? {
        let path = entry.map_err(unread)?.path();
        if is_picture(&path) && !path.is_dir() {
            files.push(path);
        }
    }
    if files.is_empty() {
        return Err(ListError::NoPicture { path: folder.to_owned() });
    }
    files.sort_by(|a, b| by_number(name_of(a), name_of(b)));
    Ok(files)
}

fn is_picture(path: &Path) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str());
    ending.is_some_and(|ending| ENDINGS.iter().any(|known| ending.eq_ignore_ascii_case(known)))
}

fn name_of(path: &Path) -> &[u8] {
    path.file_name().unwrap_or_default().as_encoded_bytes()
}

/// Runs of digits compare as numbers, of any length; all else, and what is equal so, byte by byte.
fn by_number(a: &[u8], b: &[u8]) -> Ordering {
    let (mut left, mut right) = (a, b);
    while let (Some(&first), Some(&other)) = (left.first(), right.first()) {
        let order = if first.is_ascii_digit() && other.is_ascii_digit() {
            let (number, other) = (take_number(&mut left), take_number(&mut right));
            number.len().cmp(&other.len()).then_with(|| number.cmp(other))
        } else {
            (left, right) = (&left[1..], &right[1..]);
            first.cmp(&other)
        };
        if order.is_ne() {
            return order;
        }
    }
    left.len().cmp(&right.len()).then_with(|| a.cmp(b))
}

/// Takes the digits at the beginning; without zeros before them.
fn take_number<'a>(name: &mut &'a [u8]) -> &'a [u8] {
    let end = name.iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(name.len());
    let (digits, rest) = name.split_at(end);
    *name = rest;
    let zeros = digits.iter().take_while(|&&digit| digit == b'0').count();
    &digits[zeros..]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_in_natural_order() {
        let mut names =
            ["f10.png", "f9.png", "f2b.png", "f2.png", "f002.png", "f.png", "e99", "f99999999999999999999999", "g"];
        let expected =
            ["e99", "f.png", "f002.png", "f2.png", "f2b.png", "f9.png", "f10.png", "f99999999999999999999999", "g"];
        names.sort_by(|a, b| by_number(a.as_bytes(), b.as_bytes()));
        assert_eq!(names, expected);
        for a in expected {
            for b in expected {
                assert_eq!(by_number(a.as_bytes(), b.as_bytes()), by_number(b.as_bytes(), a.as_bytes()).reverse());
            }
        }
    }
}
