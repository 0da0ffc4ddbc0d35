//! Forms of output by the names of files.
//!
//! In: a file's name, the suffixes that are known.
//! Out: the form that the suffix stands for.
//! Invariants: a suffix that stands for nothing is refused, with those that do; a name without one says nothing.
//! Must not know: what forms are.

use std::path::Path;

use crate::cli::Failure;

/// The form of a file that is to be written, by its suffix in any case; none if there is no file, or it has no suffix.
pub fn by_suffix<F: Copy>(file: Option<&Path>, known: &[(&str, F)]) -> Result<Option<F>, Failure> {
    let Some((file, suffix)) = file.and_then(|file| Some((file, file.extension()?.to_string_lossy()))) else {
        return Ok(None);
    };
    if let Some((_, form)) = known.iter().find(|(name, _)| name.eq_ignore_ascii_case(&suffix)) {
        return Ok(Some(*form));
    }
    let names: Vec<String> = known.iter().map(|(name, _)| format!(".{name}")).collect();
    Err(Failure::usage(format!(
        "{}: .{suffix} is the suffix of no format: use {}, or say the format by --format",
        file.display(),
        names.join(", ")
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suffixes_choose_or_are_refused_with_the_choices() {
        let known = [("csv", 1), ("svg", 2)];
        let chosen = |name: &str| by_suffix(Some(Path::new(name)), &known);
        for (name, form) in [("a.csv", Some(1)), ("b/c.x.SVG", Some(2)), ("out", None), (".csv", None), ("-", None)] {
            assert_eq!(chosen(name).unwrap(), form, "{name}");
        }
        let Err(Failure::Usage(reason)) = chosen("a.pdf") else { panic!("it is refused") };
        assert!(reason.contains("a.pdf: .pdf") && reason.contains("use .csv, .svg, or"), "{reason}");
        assert_eq!(by_suffix(None, &known).unwrap(), None);
    }
}
