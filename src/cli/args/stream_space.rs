//! Options of a stream of points in R^d: its metric, and how its points are read.
//!
//! In: words of the command line.
//! Out: the space of a stream, and how lines become its points; or none for the plane.
//! Invariants: options that make no sense in the plane, or for a stream, are refused.
//! Must not know: input and output.

use clap::Args;
use hopes::topology::spaces::{MAX_VERTICES, Metric};

use super::embedding::embedding;
use super::metric::{MetricWord, coordinates, not_in_the_plane};
use super::places::{ProjectArgs, chosen};
use crate::cli::Failure;
use crate::client::delivery::WantedSpace;
use crate::daemon::{Limits, SpaceRule, wire_metric};
use crate::formats::input::Format;
use crate::formats::input::space::{Embedding, PointSettings};
use crate::formats::points::Form;

/// Which distances the skeleton of a stream is of.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Metric space")]
pub struct StreamSpaceArgs {
    /// Points are of R^d under this metric, by the Vietoris-Rips filtration, instead of the plane.
    ///
    /// All columns are coordinates, unless --columns picks some; of haversine, longitude and latitude. A frame is
    /// computed anew from its points: a thousand cost some 10 ms, and twice as many four times as much.
    #[arg(long, value_enum, value_name = "METRIC")]
    metric: Option<MetricWord>,
    /// Take one column as a series, and its vectors of D samples, each LAG after the one before, as points.
    #[arg(long, value_name = "D:LAG", value_parser = embedding)]
    embed: Option<Embedding>,
}

/// The space of a stream whose points are read.
#[derive(Clone, Copy, Debug)]
pub struct StreamSpace {
    /// The metric.
    pub metric: Metric,
    embedding: Option<Embedding>,
}

impl StreamSpaceArgs {
    /// The space that they ask for; none for the plane.
    ///
    /// # Errors
    /// They contradict each other, or ask for what no stream can be.
    pub fn space(self) -> Result<Option<StreamSpace>, Failure> {
        let usual = if self.embed.is_some() { MetricWord::Euclidean } else { MetricWord::Plane };
        let word = self.metric.unwrap_or(usual);
        if word == MetricWord::Matrix {
            return Err(Failure::usage(
                "--metric matrix is for `hopes compute`: a stream has points, whose distances are computed",
            ));
        }
        match (word.of_points(), self.embed) {
            (None, Some(_)) => Err(not_in_the_plane("--embed")),
            (None, None) => Ok(None),
            (Some(Metric::Haversine), Some(_)) => {
                Err(Failure::usage("--embed makes vectors, not places on the Earth: choose another --metric"))
            }
            (Some(metric), embedding) => Ok(Some(StreamSpace { metric, embedding })),
        }
    }
}

impl StreamSpace {
    /// What a daemon is asked for.
    pub fn wanted(self) -> WantedSpace {
        let dimension = self.embedding.map(|embedding| embedding.dimension() as u32);
        WantedSpace { metric: wire_metric(self.metric), dimension }
    }

    /// What the stream is made with.
    pub fn rule(self, max_vertices: Option<u64>) -> SpaceRule {
        let most = max_vertices.map_or(Limits::default().space_vertices, |most| most as usize);
        let dimension = self.embedding.map(Embedding::dimension);
        SpaceRule { metric: self.metric, dimension, max_vertices: most.clamp(1, MAX_VERTICES) }
    }
}

/// How lines are read: as points of the plane, or of a space.
///
/// # Errors
/// The columns cannot be.
pub fn form(
    space: Option<StreamSpace>,
    format: Option<Format>,
    columns: Option<&str>,
    project: ProjectArgs,
) -> Result<Form, Failure> {
    let Some(StreamSpace { metric, embedding }) = space else {
        return Ok(Form::Lines(format, project.columns(chosen(columns)?.as_ref())));
    };
    if project.is_on() {
        return Err(Failure::usage("--project is for the plane: for metres along the Earth say --metric haversine"));
    }
    let coordinates = coordinates(metric, columns)?;
    Ok(Form::Space(PointSettings { format, coordinates, wants_times: false, embedding }))
}
