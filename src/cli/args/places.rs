//! Options of coordinates: which columns have them, and whether they are degrees.
//!
//! In: words of the command line.
//! Out: columns, a projector.
//! Must not know: input and output.

use std::str::FromStr;

use clap::Args;

use super::values::number;
use crate::cli::Failure;
use crate::formats::degrees::warning_of_degrees;
use crate::formats::input::{Columns, ColumnsError};
use crate::formats::projection::{Projection, Projector};

/// Columns of a table, and the words that chose them.
#[derive(Clone, Debug)]
pub struct ChosenColumns {
    /// What was chosen.
    pub columns: Columns,
    words: String,
}

impl FromStr for ChosenColumns {
    type Err = ColumnsError;

    fn from_str(words: &str) -> Result<Self, ColumnsError> {
        Ok(Self { columns: words.parse()?, words: words.to_owned() })
    }
}

/// The columns that words choose, if there are any.
///
/// # Errors
/// They choose none that can be.
pub fn chosen(words: Option<&str>) -> Result<Option<ChosenColumns>, Failure> {
    let wrong = |error: ColumnsError| Failure::usage(format!("--columns {}: {error}", words.unwrap_or_default()));
    words.map(str::parse).transpose().map_err(wrong)
}

/// Whether coordinates are degrees that become metres.
#[derive(Clone, Copy, Debug, Args)]
pub struct ProjectArgs {
    /// Points are longitudes and latitudes in degrees: take them as metres east and north of the first point, or of
    /// LON,LAT. Of serve: those on stdin.
    ///
    /// A degree of longitude is shorter than one of latitude, and neither is a length. Scales, windows and grids are
    /// then in metres, and so are all coordinates that are written, but GeoJSON has degrees again. The plane is
    /// the local equirectangular one: shapes are true near the origin. Producers of one stream must name the same one.
    #[arg(long, value_name = "LON,LAT", value_parser = origin, num_args = 0..=1, require_equals = true)]
    project: Option<Option<Projection>>,
}

impl ProjectArgs {
    /// What projects points, if they are to be projected.
    pub fn projector(self) -> Option<Projector> {
        self.project.map(Projector::new)
    }

    /// Whether degrees become metres.
    pub fn is_on(self) -> bool {
        self.project.is_some()
    }

    /// The columns that were chosen, or those that the header names. Warns if they are degrees and stay so.
    pub fn columns(self, chosen: Option<&ChosenColumns>) -> Columns {
        let Some(ChosenColumns { columns, words }) = chosen else { return Columns::default() };
        if self.project.is_none()
            && let Some(warning) = warning_of_degrees(words.split(',').take(2))
        {
            tracing::warn!("{warning}");
        }
        columns.clone()
    }
}

fn origin(word: &str) -> Result<Projection, String> {
    let (longitude, latitude) = word
        .split_once(',')
        .ok_or_else(|| format!("{word:?} is no LON,LAT: write two numbers, such as 24.94,60.17"))?;
    Projection::around([number(longitude.trim())?, number(latitude.trim())?]).map_err(|error| error.to_string())
}
