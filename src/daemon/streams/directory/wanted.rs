//! What a peer asks of a stream that it opens, and whether a stream that is there is such a one.
//!
//! In: messages that open a stream. Out: the options of a new stream, or whether a stream has them.
//!
//! Invariants: what is not given may be anything. A refusal says what the stream is, and how it is opened.
//!
//! Must not know: which streams there are, connections.

use hopes::topology::{Exact, Window};
use hopes_protocol as wire;

use super::OpenError;
use crate::daemon::settings::Limits;
use crate::daemon::streams::convert;
use crate::daemon::streams::pipeline::{PipelineOptions, SpaceRule};
use crate::daemon::streams::stream::Stream;

/// What a peer asks of the stream that it opens.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Its name.
    pub name: String,
    /// Which points stay.
    pub window: Option<wire::Window>,
    /// The step of the grid that positions are snapped to.
    pub resolution: Option<f64>,
    /// The space of its points; none for the plane.
    pub space: Option<WantedSpace>,
}

/// What a peer asks of a space.
#[derive(Clone, Copy, Debug)]
pub struct WantedSpace {
    /// The metric.
    pub metric: Option<wire::Metric>,
    /// The number of coordinates of a point.
    pub dimension: Option<u32>,
}

impl From<&wire::Open> for Wanted {
    fn from(open: &wire::Open) -> Self {
        Self { name: open.name.clone(), window: open.window, resolution: open.resolution, space: None }
    }
}

impl From<&wire::OpenSpace> for Wanted {
    fn from(open: &wire::OpenSpace) -> Self {
        let space = WantedSpace { metric: open.metric, dimension: open.dimension };
        Self { name: open.name.clone(), window: open.window, resolution: open.resolution, space: Some(space) }
    }
}

impl Wanted {
    /// The options of a new stream.
    ///
    /// # Errors
    /// [`OpenError`]: the name or the options cannot be.
    pub fn options(&self, limits: &Limits) -> Result<PipelineOptions, OpenError> {
        if !wire::is_name(&self.name) {
            let text = format!(
                "{:?} is no name: it has 1 to {} bytes, no control character and no *",
                self.name,
                wire::LONGEST_NAME
            );
            return Err(OpenError { code: wire::ErrorCode::BadName, text });
        }
        let bad = |text: &str| OpenError { code: wire::ErrorCode::BadOptions, text: text.to_owned() };
        let window = convert::window(self.window.unwrap_or(wire::Window::All)).map_err(bad)?;
        let resolution = convert::resolution(self.resolution).map_err(bad)?;
        let space = self.space.map(|space| space.rule(limits)).transpose()?;
        Ok(PipelineOptions { window, resolution, space })
    }

    /// Whether a stream that is there has the options. A dimension that is not settled yet is settled.
    ///
    /// # Errors
    /// [`OpenError`]: it has others, or is of another kind.
    pub fn check(&self, options: PipelineOptions, stream: &Stream) -> Result<(), OpenError> {
        let (state, has) = (&stream.state, stream.state.options);
        let is_other = self.window.is_some() && options.window != has.window
            || self.resolution.is_some() && options.resolution != has.resolution;
        let is_other = match (&self.space, &state.space) {
            (None, None) => is_other,
            (Some(_), None) => return Err(other_kind(&state.name, "of the plane", "Open, without a metric")),
            (None, Some(space)) => {
                let how = format!("OpenSpace, with the metric {}", space.metric.name());
                return Err(other_kind(&state.name, "of points in R^d", &how));
            }
            (Some(wanted), Some(space)) => {
                is_other
                    || wanted.metric.is_some_and(|metric| metric != space.metric)
                    || wanted.dimension.is_some_and(|dimension| space.settle(dimension) != dimension)
            }
        };
        if is_other {
            let text = format!("stream {:?} has {}: open it so, or without options", state.name, in_words(stream));
            return Err(OpenError { code: wire::ErrorCode::OtherOptions, text });
        }
        Ok(())
    }
}

impl WantedSpace {
    fn rule(self, limits: &Limits) -> Result<SpaceRule, OpenError> {
        let metric = convert::metric(self.metric.unwrap_or(wire::Metric::Euclidean));
        let dimension = self.dimension.map(|dimension| dimension as usize);
        if let Some(error) = dimension.and_then(|dimension| metric.check_dimension(dimension).err()) {
            return Err(OpenError { code: wire::ErrorCode::BadOptions, text: error.to_string() });
        }
        Ok(SpaceRule { metric, dimension, max_vertices: limits.space_vertices })
    }
}

fn other_kind(name: &str, what: &str, message: &str) -> OpenError {
    let text = format!("stream {name:?} is {what}: open it by {message}");
    OpenError { code: wire::ErrorCode::OtherSpace, text }
}

/// Options as the command line has them.
pub fn in_words(stream: &Stream) -> String {
    let PipelineOptions { window, resolution, .. } = stream.state.options;
    let window = match window {
        Window::All => "all".to_owned(),
        Window::Points(number) => format!("points:{number}"),
        Window::Frames(number) => format!("frames:{number}"),
        Window::Time(length) => format!("time:{}", Exact(length)),
    };
    let grid = resolution.map_or("none".to_owned(), |step| Exact(step).to_string());
    let space = stream.state.space.as_ref().map_or(String::new(), |space| {
        let dimension = space.dimension().map_or("that of the first point".to_owned(), |number| number.to_string());
        format!(", metric {}, dimension {dimension}", space.metric.name())
    });
    format!("window {window}, resolution {grid}{space}")
}
