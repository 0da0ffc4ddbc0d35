//! Options of metric spaces: which distances a skeleton is of.
//!
//! In: words of the command line.
//! Out: a [`SpaceKind`], or none for the plane.
//! Invariants: options that make no sense in the plane are refused there.
//! Must not know: input and output.

use clap::{Args, ValueEnum};
use hopes::topology::spaces::Metric;

use super::embedding::embedding;
use super::values::{many, scale};
use crate::cli::Failure;
use crate::formats::input::Columns;
use crate::formats::input::space::{Coordinates, DistanceForm, Embedding, SpaceColumns};

/// Which distances the skeleton is of.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Metric space")]
pub struct MetricArgs {
    /// Distances of any space, by its Vietoris-Rips filtration, instead of the plane.
    #[arg(long, value_enum, value_name = "METRIC")]
    metric: Option<MetricWord>,
    /// Stop the filtration at the scale RADIUS: cycles alive there never die.
    #[arg(long, value_name = "RADIUS", value_parser = scale)]
    threshold: Option<f64>,
    /// Take a sample of at most M points, each the farthest from those before; its covering radius is told.
    #[arg(long, value_name = "M", value_parser = many)]
    landmarks: Option<std::num::NonZeroUsize>,
    /// Take one column as a series, and its vectors of D samples, each LAG after the one before, as points.
    #[arg(long, value_name = "D:LAG", value_parser = embedding)]
    embed: Option<Embedding>,
    /// How a matrix of distances is written [default: as its rows show].
    #[arg(long, value_enum, value_name = "FORM")]
    distances: Option<DistanceForm>,
}

/// A metric by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MetricWord {
    /// The plane, by its alpha filtration.
    Plane,
    /// All columns are coordinates; the root of the sum of squares.
    Euclidean,
    /// The sum of absolute differences.
    Manhattan,
    /// The largest absolute difference.
    Chebyshev,
    /// The angle between vectors, in radians.
    Angular,
    /// Longitude and latitude in degrees; metres along the Earth.
    Haversine,
    /// The file has distances, not points.
    Matrix,
}

impl MetricWord {
    /// The metric of points; none of the plane, and of distances.
    pub(super) fn of_points(self) -> Option<Metric> {
        match self {
            Self::Plane | Self::Matrix => None,
            Self::Euclidean => Some(Metric::Euclidean),
            Self::Manhattan => Some(Metric::Manhattan),
            Self::Chebyshev => Some(Metric::Chebyshev),
            Self::Angular => Some(Metric::Angular),
            Self::Haversine => Some(Metric::Haversine),
        }
    }
}

/// What a file holds, if it is not of the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpaceKind {
    /// Points under a metric; or a series, of which they are made.
    Points(Metric, Option<Embedding>),
    /// Distances.
    Distances(Option<DistanceForm>),
}

/// How the skeleton of a space is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpaceOptions {
    /// What the file holds.
    pub kind: SpaceKind,
    /// Where the filtration stops; a radius.
    pub threshold: Option<f64>,
    /// At most so many points of a sample.
    pub landmarks: Option<usize>,
}

impl MetricArgs {
    /// What they ask for; none for the plane.
    pub fn options(self) -> Result<Option<SpaceOptions>, Failure> {
        let Some(kind) = self.kind()? else {
            return match (self.threshold, self.landmarks) {
                (Some(_), _) => Err(not_in_the_plane("--threshold")),
                (_, Some(_)) => Err(not_in_the_plane("--landmarks")),
                _ => Ok(None),
            };
        };
        let landmarks = self.landmarks.map(std::num::NonZeroUsize::get);
        Ok(Some(SpaceOptions { kind, threshold: self.threshold, landmarks }))
    }

    /// A series is of Euclidean vectors, and a form of distances is of distances, if nothing else is said.
    fn kind(self) -> Result<Option<SpaceKind>, Failure> {
        let usual = match (self.embed, self.distances) {
            (Some(_), _) => MetricWord::Euclidean,
            (_, Some(_)) => MetricWord::Matrix,
            _ => MetricWord::Plane,
        };
        let word = self.metric.unwrap_or(usual);
        match word {
            MetricWord::Plane if self.embed.is_some() => return Err(not_in_the_plane("--embed")),
            MetricWord::Haversine if self.embed.is_some() => {
                return Err(Failure::usage("--embed makes vectors, not places on the Earth: choose another --metric"));
            }
            MetricWord::Matrix if self.embed.is_some() => {
                return Err(Failure::usage("--embed is for a series of numbers: a matrix has distances"));
            }
            MetricWord::Matrix => return Ok(Some(SpaceKind::Distances(self.distances))),
            _ if self.distances.is_some() => {
                return Err(Failure::usage("--distances is for --metric matrix: of points, distances are computed"));
            }
            _ => {}
        }
        Ok(word.of_points().map(|metric| SpaceKind::Points(metric, self.embed)))
    }
}

/// Which columns have the coordinates of points under a metric.
///
/// # Errors
/// The words choose none that can be.
pub fn coordinates(metric: Metric, columns: Option<&str>) -> Result<Coordinates, Failure> {
    let wrong = |error: String| Failure::usage(format!("--columns {}: {error}", columns.unwrap_or_default()));
    let parsed = |words: &str| -> Result<Coordinates, String> {
        if metric == Metric::Haversine {
            return words.parse::<Columns>().map(Coordinates::Degrees).map_err(|error| error.to_string());
        }
        words.parse::<SpaceColumns>().map(Coordinates::Any).map_err(|error| error.to_string())
    };
    match columns {
        Some(words) => parsed(words).map_err(wrong),
        None if metric == Metric::Haversine => Ok(Coordinates::Degrees(Columns::default())),
        None => Ok(Coordinates::default()),
    }
}

pub(super) fn not_in_the_plane(option: &str) -> Failure {
    Failure::usage(format!("{option} is for metric spaces: say --metric too, such as --metric euclidean"))
}
