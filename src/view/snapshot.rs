//! A snapshot of a stream as a document: which view and format a query requests, and the formats.
//!
//! In: a query, a snapshot.
//! Out: JSON (a line as `hopes serve` writes it), GeoJSON, or SVG.
//! Invariants: a query with an unknown key, or with two values for one, is refused with the reason. The size of a
//! picture is bounded by its pixels.
//! Must not know: where snapshots come from.

mod geojson;
mod svg;

use hopes_protocol::{Cut, Simplify, Snapshot, View};

use crate::formats::frame_line::FrameLine;

/// What a query requests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SnapshotRequest {
    /// The view.
    pub view: View,
    /// The format.
    pub format: Format,
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
    /// The request of a query: `format=json|geojson|svg`, and `k=..&l=..`, `alpha=..` or `full`.
    ///
    /// # Errors
    /// The text says what is wrong with it, and what may be requested.
    pub fn parse(query: &str) -> Result<Self, String> {
        let (mut format, mut k, mut l, mut alpha, mut full) = (None, None, None, None, None);
        for part in query.split('&').filter(|part| !part.is_empty()) {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            let value = decoded(value)?;
            match key {
                "format" => set_once(key, &mut format, Format::parse(&value)?)?,
                "k" => set_once(key, &mut k, count(key, &value)?)?,
                "l" => set_once(key, &mut l, count(key, &value)?)?,
                "alpha" => set_once(key, &mut alpha, radius(&value)?)?,
                "full" if value.is_empty() => set_once(key, &mut full, ())?,
                "full" => return Err("full has no value".to_owned()),
                _ => return Err(format!("{key:?} cannot be requested: use format, k, l, alpha, full")),
            }
        }
        let cut = match (full, alpha, k.or(l)) {
            (Some(()), None, None) => Cut::Full,
            (None, Some(alpha), None) => Cut::Reduced(alpha),
            (None, None, _) => Cut::Derived(k.unwrap_or(1), l.unwrap_or(1)),
            _ => return Err("request k and l, or alpha, or full: these are different views".to_owned()),
        };
        Ok(Self { view: View { cut, simplify: Simplify::No }, format: format.unwrap_or_default() })
    }
}

fn set_once<T>(key: &str, slot: &mut Option<T>, value: T) -> Result<(), String> {
    match slot.replace(value) {
        None => Ok(()),
        Some(_) => Err(format!("{key} is requested twice")),
    }
}

fn count(key: &str, value: &str) -> Result<u32, String> {
    let count = value.parse().ok().filter(|count| *count > 0);
    count.ok_or_else(|| format!("{key} is a number from 1 to {}, not {value:?}", u32::MAX))
}

fn radius(value: &str) -> Result<f64, String> {
    let radius = value.parse().ok().filter(|radius: &f64| radius.is_finite() && *radius >= 0.0);
    radius.ok_or_else(|| format!("alpha is a radius, a finite number from 0, not {value:?}"))
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
    /// Of the serializer, which has none to expect.
    pub fn write(self, name: &str, snapshot: &Snapshot) -> serde_json::Result<Vec<u8>> {
        match self {
            Self::Json => {
                let mut line = serde_json::to_vec(&FrameLine::of_snapshot(name, snapshot))?;
                line.push(b'\n');
                Ok(line)
            }
            Self::GeoJson => geojson::write(snapshot),
            Self::Svg => Ok(svg::write(name, snapshot).into_bytes()),
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

/// Decodes the percent-encoding of a part of an address.
///
/// # Errors
/// The text says what is wrong with it.
pub fn decoded(part: &str) -> Result<String, String> {
    let mut bytes = Vec::with_capacity(part.len());
    let mut rest = part.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        rest = after;
        let byte = match (first, after) {
            (b'%', &[high, low, ref after @ ..]) => {
                rest = after;
                let digit = |byte: u8| char::from(byte).to_digit(16);
                digit(high).zip(digit(low)).map(|(high, low)| (high << 4 | low) as u8)
            }
            (b'%', _) => None,
            _ => Some(first),
        };
        bytes.push(byte.ok_or_else(|| format!("{part:?} has a % without two digits after it: write %25 for %"))?);
    }
    String::from_utf8(bytes).map_err(|_| format!("{part:?} is no UTF-8"))
}

#[cfg(test)]
mod tests {
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

    #[test]
    fn percent_encoding_is_decoded() {
        assert_eq!(decoded("a%20%C3%A4%2Fb+").as_deref(), Ok("a ä/b+"));
        assert!(decoded("%FF").unwrap_err().contains("UTF-8"));
    }
}
