//! Which files are meant: those that are named, and the pictures of folders that are.
//!
//! In: names. Out: files, in order. Invariants: the pictures of a folder come in the order of their names as people
//! count: 2 before 10; what is not there is told before anything is read. Must not know: what is in files.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

/// Stands for stdin.
pub const STDIN: &str = "-";

/// Endings of the names of pictures, in any case.
const ENDINGS: [&str; 3] = ["png", "jpg", "jpeg"];

/// All files that are meant by these names.
pub fn listed(names: &[PathBuf]) -> anyhow::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for name in names {
        if name == Path::new(STDIN) {
            files.push(name.clone());
            continue;
        }
        let data = std::fs::metadata(name).with_context(|| format!("cannot open {}", name.display()))?;
        if data.is_dir() {
            files.extend(pictures(name)?);
        } else {
            files.push(name.clone());
        }
    }
    Ok(files)
}

fn pictures(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let unread = || format!("cannot list {}", folder.display());
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(unread)? {
        let path = entry.with_context(unread)?.path();
        if is_picture(&path) && !path.is_dir() {
            files.push(path);
        }
    }
    if files.is_empty() {
        bail!("there is no picture in {}: their names end in .png, .jpg or .jpeg", folder.display());
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
    fn names_are_counted_as_people_do() {
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
