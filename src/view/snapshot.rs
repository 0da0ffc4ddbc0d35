//! One frame of a stream: which view of it is wanted in which form, and that form.
//!
//! In: a query, a snapshot. Out: JSON (a line as `hopes serve` writes it), GeoJSON, or SVG. Invariants: a query that
//! says nothing known, or two things at once, is refused by name; the size of a picture is bounded by its pixels. Must
//! not know: where snapshots come from.

mod geojson;
mod svg;

use hopes_protocol::{Cut, Simplify, Snapshot, View};

use crate::formats::frame_line::FrameLine;

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Which part of the skeleton.
    pub view: View,
    /// In which form.
    pub form: Form,
}

/// Forms of a snapshot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Form {
    /// A line as on the daemon's stdout.
    #[default]
    Json,
    /// Features.
    GeoJson,
    /// A picture.
    Svg,
}

impl Wanted {
    /// What a query asks for: `format=json|geojson|svg`, and `k=..&l=..`, `alpha=..` or `full`.
    ///
    /// # Errors
    /// What is wrong with it, and what may be asked for.
    pub fn parse(query: &str) -> Result<Self, String> {
        let (mut form, mut k, mut l, mut alpha, mut full) = (None, None, None, None, None);
        for part in query.split('&').filter(|part| !part.is_empty()) {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            let value = decoded(value)?;
            match key {
                "format" => once(key, &mut form, Form::parse(&value)?)?,
                "k" => once(key, &mut k, count(key, &value)?)?,
                "l" => once(key, &mut l, count(key, &value)?)?,
                "alpha" => once(key, &mut alpha, radius(&value)?)?,
                "full" if value.is_empty() => once(key, &mut full, ())?,
                "full" => return Err("full has no value".to_owned()),
                _ => return Err(format!("{key:?} cannot be asked for: there are format, k, l, alpha, full")),
            }
        }
        let cut = match (full, alpha, k.or(l)) {
            (Some(()), None, None) => Cut::Full,
            (None, Some(alpha), None) => Cut::Reduced(alpha),
            (None, None, _) => Cut::Derived(k.unwrap_or(1), l.unwrap_or(1)),
            _ => return Err("ask for k and l, or for alpha, or for full: these are different views".to_owned()),
        };
        Ok(Self { view: View { cut, simplify: Simplify::No }, form: form.unwrap_or_default() })
    }
}

fn once<T>(key: &str, place: &mut Option<T>, value: T) -> Result<(), String> {
    match place.replace(value) {
        None => Ok(()),
        Some(_) => Err(format!("{key} is asked for twice")),
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

impl Form {
    fn parse(word: &str) -> Result<Self, String> {
        match word {
            "json" => Ok(Self::Json),
            "geojson" => Ok(Self::GeoJson),
            "svg" => Ok(Self::Svg),
            _ => Err(format!("{word:?} is no format: there are json, geojson, svg")),
        }
    }

    /// As HTTP calls it.
    pub fn kind(self) -> &'static str {
        match self {
            Self::Json => "application/json",
            Self::GeoJson => "application/geo+json",
            Self::Svg => "image/svg+xml",
        }
    }

    /// A snapshot of a stream in this form.
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

/// Where a vertex is; none, if the snapshot has none of that id. Its vertices are sorted.
fn place(snapshot: &Snapshot, id: u64) -> Option<(f64, f64)> {
    let index = snapshot.vertices.binary_search_by_key(&id, |vertex| vertex.0).ok()?;
    let (_, x, y) = snapshot.vertices[index];
    Some((x, y))
}

/// Where the ends of an edge are.
fn segment(snapshot: &Snapshot, a: u64, b: u64) -> Option<[(f64, f64); 2]> {
    Some([place(snapshot, a)?, place(snapshot, b)?])
}

/// A part of an address, in which `%` and two digits stand for a byte.
///
/// # Errors
/// What is wrong with it.
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
    fn queries_say_which_view_and_which_form() {
        for (query, cut, form) in [
            ("", Cut::Derived(1, 1), Form::Json),
            ("format=svg&l=3", Cut::Derived(1, 3), Form::Svg),
            ("k=2&l=3", Cut::Derived(2, 3), Form::Json),
            ("alpha=0%2E5&format=geojson", Cut::Reduced(0.5), Form::GeoJson),
            ("full", Cut::Full, Form::Json),
            ("full=&", Cut::Full, Form::Json),
        ] {
            let view = View { cut, simplify: Simplify::No };
            assert_eq!(Wanted::parse(query), Ok(Wanted { view, form }), "{query}");
        }
    }

    #[test]
    fn queries_that_make_no_sense_say_why() {
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
            ("colour=red", "there are format"),
            ("k=%zz", "two digits"),
            ("k=%2", "two digits"),
        ] {
            let error = Wanted::parse(query).unwrap_err();
            assert!(error.contains(says), "{query}: {error}");
        }
    }

    #[test]
    fn names_are_decoded() {
        assert_eq!(decoded("a%20%C3%A4%2Fb+").as_deref(), Ok("a ä/b+"));
        assert!(decoded("%FF").unwrap_err().contains("UTF-8"));
    }
}
