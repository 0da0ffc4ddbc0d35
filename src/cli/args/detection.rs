//! Options of the detector of edges.
//!
//! In: words of the command line.
//! Out: the detector's options.
//! Must not know: pictures, input and output.

use clap::Args;
use hopes::edges::Options;

use super::values::number;

/// How edges are found.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Detection of edges")]
pub struct DetectionArgs {
    /// Gradients above LOW continue an edge.
    #[arg(long, value_name = "LOW", default_value = "150", value_parser = threshold)]
    low: f64,
    /// Gradients above LOW times RATIO begin an edge.
    #[arg(long, value_name = "RATIO", default_value = "3", value_parser = ratio)]
    ratio: f64,
    /// Gradients above HIGH begin an edge.
    #[arg(
        long,
        value_name = "HIGH",
        value_parser = threshold,
        conflicts_with = "ratio"
    )]
    high: Option<f64>,
    /// Blur before, by a Gaussian of this standard deviation in pixels, as OpenCV's GaussianBlur does.
    #[arg(long, value_name = "SIGMA", value_parser = sigma)]
    blur: Option<f64>,
}

impl DetectionArgs {
    /// What they ask for.
    pub fn options(self) -> Options {
        Options { low: self.low, high: self.high.unwrap_or(self.low * self.ratio), blur: self.blur }
    }
}

fn ratio(word: &str) -> Result<f64, String> {
    match number(word)? {
        ratio if ratio >= 1.0 => Ok(ratio),
        ratio => Err(format!("{ratio} is no ratio of the high threshold to the low one: it must be 1 or more")),
    }
}

fn threshold(word: &str) -> Result<f64, String> {
    checked(number(word)?, |low| Options { low, ..Options::default() })
}

fn sigma(word: &str) -> Result<f64, String> {
    checked(number(word)?, |sigma| Options { blur: Some(sigma), ..Options::default() })
}

fn checked(value: f64, options: impl Fn(f64) -> Options) -> Result<f64, String> {
    options(value).check().map_err(|error| error.to_string()).map(|()| value)
}
