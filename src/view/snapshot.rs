//! A snapshot of a stream as a document: which view and format a query requests, and the formats.
//!
//! In: a query, a snapshot.
//! Out: JSON (a line as `hopes serve` writes it), GeoJSON, or SVG.
//! Invariants: the size of a picture is bounded by its pixels.
//! Must not know: where snapshots come from.

mod geojson;
mod svg;

use hopes_protocol::{Message, Snapshot, View};
use thiserror::Error;

use super::query::Query;
use crate::formats::frame_line::FrameLine;

/// What a query requests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SnapshotRequest {
    /// The view.
    pub view: View,
    /// The format.
    pub format: Format,
}

/// Why a snapshot is no document.
#[derive(Debug, Error)]
pub enum FormatError {
    /// The stream is not of the plane.
    #[error("GeoJSON is for maps, and stream {0:?} is of points in R^d: use json or svg")]
    NoMap(String),
    /// The stream is not of the plane, nor laid out in it.
    #[error("stream {0:?} is of points in R^d, which have no place in a picture yet")]
    NoPicture(String),
    /// It is no snapshot. The daemon has none to expect.
    #[error("the daemon has sent no snapshot")]
    NoSnapshot,
    /// Of the serializer, which has none to expect.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
}

/// Formats of a snapshot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// A line as `hopes serve` writes it.
    #[default]
    Json,
    /// A FeatureCollection.
    GeoJson,
    /// A picture.
    Svg,
}

impl SnapshotRequest {
    /// The request of a query: `format=json|geojson|svg`, and a view.
    ///
    /// # Errors
    /// The text says what is wrong with it, and what may be requested.
    pub fn parse(query: &str) -> Result<Self, String> {
        let query = Query::parse(query, &["format"])?;
        let format = query.value("format").map(Format::parse).transpose()?;
        Ok(Self { view: query.view()?, format: format.unwrap_or_default() })
    }
}

impl Format {
    fn parse(word: &str) -> Result<Self, String> {
        match word {
            "json" => Ok(Self::Json),
            "geojson" => Ok(Self::GeoJson),
            "svg" => Ok(Self::Svg),
            _ => Err(format!("{word:?} is no format: use json, geojson, svg")),
        }
    }

    /// Its media type.
    pub fn media_type(self) -> &'static str {
        match self {
            Self::Json => "application/json",
            Self::GeoJson => "application/geo+json",
            Self::Svg => "image/svg+xml",
        }
    }

    /// A snapshot of a stream in this format.
    ///
    /// # Errors
    /// [`FormatError`].
    pub fn write(self, name: &str, snapshot: &Message) -> Result<Vec<u8>, FormatError> {
        match (self, snapshot) {
            (Self::Json, _) => {
                let line = FrameLine::new(name, snapshot).ok_or(FormatError::NoSnapshot)?;
                let mut line = serde_json::to_vec(&line)?;
                line.push(b'\n');
                Ok(line)
            }
            (Self::GeoJson, Message::Snapshot(snapshot)) => Ok(geojson::write(snapshot)?),
            (Self::GeoJson, _) => Err(FormatError::NoMap(name.to_owned())),
            (Self::Svg, Message::Snapshot(snapshot)) => Ok(svg::write(name, snapshot).into_bytes()),
            (Self::Svg, _) => Err(FormatError::NoPicture(name.to_owned())),
        }
    }
}

/// The position of a vertex; none if the snapshot has no such id. Its vertices are sorted.
fn position(snapshot: &Snapshot, id: u64) -> Option<(f64, f64)> {
    let index = snapshot.vertices.binary_search_by_key(&id, |vertex| vertex.0).ok()?;
    let (_, x, y) = snapshot.vertices[index];
    Some((x, y))
}

/// The positions of an edge's ends.
fn segment(snapshot: &Snapshot, a: u64, b: u64) -> Option<[(f64, f64); 2]> {
    Some([position(snapshot, a)?, position(snapshot, b)?])
}

#[cfg(test)]
mod tests {
    use hopes_protocol::{Cut, Simplify};

    use super::*;

    #[test]
    fn queries_request_a_view_and_a_format() {
        for (query, cut, format) in [
            ("", Cut::Derived(1, 1), Format::Json),
            ("format=svg&l=3", Cut::Derived(1, 3), Format::Svg),
            ("k=2&l=3", Cut::Derived(2, 3), Format::Json),
            ("alpha=0%2E5&format=geojson", Cut::Reduced(0.5), Format::GeoJson),
            ("full", Cut::Full, Format::Json),
            ("full=&", Cut::Full, Format::Json),
        ] {
            let view = View { cut, simplify: Simplify::No };
            assert_eq!(SnapshotRequest::parse(query), Ok(SnapshotRequest { view, format }), "{query}");
        }
    }

    #[test]
    fn invalid_queries_are_refused_with_the_reason() {
        for (query, says) in [
            ("k=0", "from 1"),
            ("k=99999999999", "from 1"),
            ("alpha=-1", "finite number"),
            ("alpha=NaN", "finite number"),
            ("alpha=", "finite number"),
            ("full=yes", "no value"),
            ("full&k=1", "different views"),
            ("alpha=1&l=2", "different views"),
            ("k=1&k=1", "twice"),
            ("format=png", "json, geojson, svg"),
            ("colour=red", "use format"),
            ("k=%zz", "two digits"),
            ("k=%2", "two digits"),
        ] {
            let error = SnapshotRequest::parse(query).unwrap_err();
            assert!(error.contains(says), "{query}: {error}");
        }
    }
}
