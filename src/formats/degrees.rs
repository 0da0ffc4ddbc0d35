//! Degrees that are taken as if they were lengths.
//!
//! In: names of columns; what a reader has chosen.
//! Out: a warning; lines of the log.
//! Must not know: how degrees become metres.

use std::fmt;

use super::input::Choice;

/// Words that stand for degrees in headers of tables, in small letters.
const DEGREES: [&str; 7] = ["lon", "lat", "lng", "long", "longitude", "latitude", "degrees"];

/// What is said of coordinates that come from columns of these names, if they look like degrees.
pub fn warning_of_degrees<'a>(names: impl IntoIterator<Item = &'a str>) -> Option<DegreesWarning> {
    let bare = |name: &str| {
        name.trim_start_matches(['#', ' ']).split(['[', '(']).next().map(|name| name.trim().to_lowercase())
    };
    let stands_for_degrees = |name: &&str| bare(name).is_some_and(|name| DEGREES.contains(&name.as_str()));
    names.into_iter().find(stands_for_degrees).map(|name| DegreesWarning(name.to_owned()))
}

/// Tells what was chosen in an input of that name, and warns if it is degrees that stay so.
pub fn tell_choice(input: &str, choice: &Choice, is_projected: bool) {
    tracing::info!("{input}: {}", choice.text);
    let names = choice.names.iter().map(String::as_str).filter(|_| !is_projected);
    if let Some(warning) = warning_of_degrees(names) {
        tracing::warn!("{input}: {warning}");
    }
}

/// Degrees are taken as if they were lengths.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DegreesWarning(String);

impl fmt::Display for DegreesWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the column {} has degrees, which are no lengths: a degree of longitude is shorter than one of latitude, \
             and round holes come out oblong; --project makes metres of them",
            self.0
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_degrees_are_known() {
        for names in [["lon", "lat"], ["Longitude", "Latitude"], ["x", "LAT [deg]"], ["# lng", "y"]] {
            assert!(warning_of_degrees(names).is_some_and(|warning| warning.to_string().contains("--project")));
        }
        for names in [["x", "y"], ["1", "2"], ["latency", "longest"], ["easting", "northing"]] {
            assert_eq!(warning_of_degrees(names), None);
        }
    }
}
