//! Where points are written, and in which form.
//!
//! In: a form, if one is given, and a file.
//! Out: the form, stdout for it.
//! Must not know: how points are written.

use std::fs::File;
use std::path::Path;

use super::{Failure, binary_stdout, stdout};
use crate::cli::args::by_suffix;
use crate::formats::point_writer::PointForm;

/// What the suffix of a file says.
const SUFFIXES: [(&str, PointForm); 5] = [
    ("csv", PointForm::Text),
    ("txt", PointForm::Text),
    ("jsonl", PointForm::Jsonl),
    ("hopes", PointForm::Bin),
    ("bin", PointForm::Bin),
];

/// The form that is given, else that of the file's suffix, else text.
pub fn point_form(given: Option<PointForm>, file: Option<&Path>) -> Result<PointForm, Failure> {
    match given {
        Some(form) => Ok(form),
        None => Ok(by_suffix(file, &SUFFIXES)?.unwrap_or_default()),
    }
}

/// Stdout, for points of this form.
pub fn point_stdout(form: PointForm) -> Result<File, Failure> {
    match form {
        PointForm::Bin => binary_stdout("the protocol's binary form", "--output FILE or another --format"),
        PointForm::Text | PointForm::Jsonl => Ok(stdout()?),
    }
}
