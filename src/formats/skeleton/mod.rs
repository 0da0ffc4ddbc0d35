//! What `compute` writes: one file a format.
//!
//! In: an [`Answer`].
//! Out: bytes.
//! Invariants: a number that is not finite is null in JSON and empty in CSV; vertices are numbered in order of
//! first appearance.
//! Must not know: where the bytes go.

mod csv;
mod dots;
mod geojson;
mod json;

use std::fmt;
use std::io::{self, Write};

use hopes::topology::{Edge, Exact, Simplified, Skeleton, View};

use super::picture;
use super::projection::Projection;

/// Everything that can be said of a cloud.
#[derive(Clone, Copy)]
pub struct Answer<'a> {
    /// What the cloud is called, if it has a name.
    pub name: Option<&'a str>,
    /// The whole skeleton.
    pub skeleton: &'a Skeleton,
    /// The view asked for.
    pub view: &'a View,
    /// The view simplified, and below which half-length its edges were collapsed.
    pub simplified: Option<(f64, &'a Simplified)>,
    /// Points beyond the first on their position.
    pub duplicates: u64,
    /// Lines and points that could not be used.
    pub rejected: u64,
    /// How metres were made of degrees, if that was so.
    pub projection: Option<&'a Projection>,
}

impl Answer<'_> {
    /// Whether its points have two coordinates, in whatever metric.
    fn is_flat(&self) -> bool {
        self.skeleton.vertices().dimension() == 2
    }

    /// The ends of an edge between points of two coordinates.
    fn segment(&self, edge: Edge) -> [[f64; 2]; 2] {
        edge.map(|vertex| self.skeleton.vertices().xy(vertex))
    }
}

/// A number of a table; nothing if it is not finite.
#[derive(Clone, Copy)]
struct Cell(f64);

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_finite() { Exact(self.0).fmt(f) } else { Ok(()) }
    }
}

/// A form of output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OutputFormat {
    /// Everything, as one JSON object.
    #[default]
    Json,
    /// Picture of the skeleton beside the persistence diagram.
    Svg,
    /// The same picture, in pixels.
    Png,
    /// A table of the view's edges.
    Csv,
    /// A table of the persistence diagram.
    Dots,
    /// The view's edges as features for maps.
    Geojson,
}

impl OutputFormat {
    /// Whether this build can write it.
    pub fn is_built_in(self) -> bool {
        self != Self::Png || cfg!(feature = "png")
    }

    /// Writes an answer in this form.
    ///
    /// # Errors
    /// Those of the sink, and of a picture that cannot be made into pixels.
    pub fn write(self, answer: &Answer, out: &mut impl Write) -> io::Result<()> {
        match self {
            Self::Json => json::write(answer, out)?,
            Self::Csv => csv::write(answer, out)?,
            Self::Geojson => geojson::write(answer, out)?,
            Self::Dots => dots::write(answer, out)?,
            Self::Svg | Self::Png => return self.write_drawing(&drawing(answer), out),
        }
        out.flush()
    }

    /// Whether it is a picture.
    pub fn is_picture(self) -> bool {
        matches!(self, Self::Svg | Self::Png)
    }

    /// Writes a picture that is drawn already, as SVG, in pixels where this form is PNG.
    ///
    /// # Errors
    /// As [`OutputFormat::write`].
    pub fn write_drawing(self, drawing: &str, out: &mut impl Write) -> io::Result<()> {
        match self {
            Self::Png => out.write_all(&pixels(drawing)?)?,
            _ => out.write_all(drawing.as_bytes())?,
        }
        out.flush()
    }
}

fn drawing(answer: &Answer) -> String {
    let simplified = answer.simplified.map(|(_, s)| (s.positions.planar(), s.edges.as_slice()));
    let options = picture::Options { name: answer.name.map(str::to_owned), ..picture::Options::default() };
    picture::svg(answer.skeleton, answer.view, simplified, &options)
}

/// A drawing as a PNG file, two pixels for each of its units.
#[cfg(feature = "png")]
fn pixels(drawing: &str) -> io::Result<Vec<u8>> {
    picture::png(drawing, 2.0).map_err(io::Error::other)
}

#[cfg(not(feature = "png"))]
fn pixels(_: &str) -> io::Result<Vec<u8>> {
    Err(io::ErrorKind::Unsupported.into())
}
