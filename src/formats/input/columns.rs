//! Which columns of a table hold the coordinates, and the event time if there is one.
//!
//! In: a choice such as `1,2`, `lon,lat` or `2,3,1`, or none; the names in a header.
//! Out: [`Columns`] of points of the plane, and once the header is known the [`Places`] of the chosen columns; what the
//! columns of points of any kind must know, [`PointColumns`].
//!
//! Invariant: x and y are never the same choice, so a line that yields both has two columns.
//!
//! Must not know: how a line is split.

use std::fmt::{self, Debug};
use std::str::FromStr;

use super::excerpt::Excerpt;
use super::jsonl::JsonPoint;

/// Which columns make a point, of a table or of the named fields of a file.
pub trait PointColumns: Clone + Debug {
    /// What they make.
    type Point: JsonPoint;
    /// Where they are in a table.
    type Places: Clone + Debug;

    /// Whether event times are wanted where nobody has chosen columns.
    fn wants_times(&self) -> bool;

    /// The places of the chosen columns, if no header is needed to find them.
    fn places(&self) -> Option<Self::Places>;

    /// The places that the names in a header say, if nobody has chosen.
    fn named_in<'a>(&self, header: impl Iterator<Item = &'a str>) -> Option<Self::Places>;

    /// The places of the chosen columns, where `header` knows the place of a name; or the first name it does not know.
    /// Names are compared exactly.
    ///
    /// # Errors
    /// That name.
    fn find(&self, header: impl FnMut(&str) -> Option<usize>) -> Result<Self::Places, &str>;

    /// The places among named fields of a file: those that were chosen, or those that are named so.
    fn among<'a>(&self, names: impl Iterator<Item = &'a str> + Clone) -> Option<FieldPlaces>;

    /// The places in an array of this shape, whose columns have no names.
    ///
    /// # Errors
    /// What is wrong with it, and what to do.
    fn in_array(&self, shape: &[u64]) -> Result<FieldPlaces, String>;

    /// The coordinates in words, each with the name of what holds it.
    fn told(names: impl ExactSizeIterator<Item = String>) -> String;
}

/// Where the coordinates of points are among the fields of a file, counted from 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FieldPlaces {
    /// Of each coordinate.
    pub coordinates: Vec<usize>,
    /// Of the event time.
    pub time: Option<usize>,
}

impl FieldPlaces {
    /// All of them, the time last.
    pub(super) fn all(&self) -> impl Iterator<Item = usize> {
        self.coordinates.iter().copied().chain(self.time)
    }
}

impl From<Places> for FieldPlaces {
    fn from(Places { x, y, time }: Places) -> Self {
        Self { coordinates: vec![x, y], time }
    }
}

/// The columns of a table that are read; all others are ignored.
///
/// Parsed from two entries, x and y, or three, x, y and the event time, separated by commas. An
/// entry is a number counted from 1 or the name of a column in the header line; in double quotes it
/// is always a name. Without a choice, x and y are those that the header names so, in one of the ways
/// of [`NAMES`], else the first two columns. A first column without a name is an index, and not one of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Columns {
    x: Column,
    y: Column,
    time: Option<Column>,
    /// Nobody has chosen: the header may.
    is_open: bool,
    /// Without a choice, a column of event times is read if the header names one.
    wants_time: bool,
}

/// Names of x and of y, which belong together.
pub(super) const NAMES: [(&[&str], &[&str]); 4] = [
    (&["x"], &["y"]),
    (&["lon", "lng", "long"], &["lat"]),
    (&["longitude"], &["latitude"]),
    (&["easting"], &["northing"]),
];

/// Names of the event time.
pub(super) const TIMES: [&str; 4] = ["t", "time", "stamp", "timestamp"];

/// Units that may follow a name after an underscore.
const UNITS: [&str; 7] = ["m", "cm", "mm", "km", "px", "deg", "s"];

/// One chosen column.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Column {
    /// Counted from 0.
    Place(usize),
    Name(String),
}

/// Where the chosen columns are, counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Places {
    pub(super) x: usize,
    pub(super) y: usize,
    pub(super) time: Option<usize>,
}

/// A choice of columns that cannot be understood.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ColumnsError {
    /// A column twice.
    #[error("the column {column} is chosen twice: choose each once")]
    Twice {
        /// Its name or number.
        column: String,
    },
    /// Not two or three entries.
    #[error("{found} column(s) chosen: choose two, x,y, or three, x,y,t")]
    Count {
        /// How many entries there are.
        found: usize,
    },
    /// An entry without content.
    #[error("entry {entry} is empty: write the number or the name of a column")]
    Empty {
        /// The entry, counted from 1.
        entry: usize,
    },
    /// An entry is a number, but not that of a column.
    #[error("{number} is not a column: count columns from 1, or put a name in double quotes")]
    NotAColumn {
        /// The entry.
        number: String,
    },
    /// Both coordinates would come from one column.
    #[error("x and y are the same column: choose two different ones")]
    Same,
}

impl Default for Columns {
    fn default() -> Self {
        Self { x: Column::Place(0), y: Column::Place(1), time: None, is_open: true, wants_time: false }
    }
}

impl FromStr for Columns {
    type Err = ColumnsError;

    fn from_str(choice: &str) -> Result<Self, ColumnsError> {
        let mut entries = choice.split(',').zip(1..).map(|(text, entry)| column(text, entry));
        let (Some(x), Some(y), time, None) = (entries.next(), entries.next(), entries.next(), entries.next()) else {
            return Err(ColumnsError::Count { found: choice.split(',').count() });
        };
        let columns = Self { x: x?, y: y?, time: time.transpose()?, is_open: false, wants_time: false };
        if columns.x == columns.y { Err(ColumnsError::Same) } else { Ok(columns) }
    }
}

pub(super) fn column(text: &str, entry: usize) -> Result<Column, ColumnsError> {
    let text = text.trim();
    let quoted = text.strip_prefix('"').and_then(|text| text.strip_suffix('"'));
    let name = quoted.unwrap_or(text).trim();
    if name.is_empty() {
        return Err(ColumnsError::Empty { entry });
    }
    match text.parse::<usize>() {
        Ok(number @ 1..) => Ok(Column::Place(number - 1)),
        // `nan` and `inf` are names; `-1`, `0` and `1.5` are slips.
        _ if text.parse::<f64>().is_ok() && text.ends_with(|c: char| c.is_ascii_digit()) => {
            Err(ColumnsError::NotAColumn { number: text.to_owned() })
        }
        _ => Ok(Column::Name(name.to_owned())),
    }
}

/// A name as it is compared: without a mark of comments, units and the size of letters. `X [m]` and `x_m` are `x`.
pub(super) fn plain(name: &str) -> String {
    let name = name.trim_start_matches('#').split(['[', '(']).next().unwrap_or_default().trim().to_lowercase();
    match name.rsplit_once('_') {
        Some((before, unit)) if UNITS.contains(&unit) => before.to_owned(),
        _ => name,
    }
}

/// Whether the first column is an index without a name, as pandas and R write it. The others are named, or counted.
pub(super) fn begins_with_index(names: &[String]) -> bool {
    let Some((first, others)) = names.split_first().filter(|(_, others)| !others.is_empty()) else { return false };
    let are_counted = others.iter().enumerate().all(|(place, name)| *name == place.to_string());
    let are_named = others.iter().all(|name| !name.is_empty() && name.parse::<f64>().is_err());
    first.is_empty() && (are_counted || are_named)
}

impl Columns {
    /// The same, with event times where the header names them, unless columns are chosen.
    pub fn with_times(self, wants_time: bool) -> Self {
        Self { wants_time, ..self }
    }
}

impl PointColumns for Columns {
    type Point = [f64; 2];
    type Places = Places;

    fn wants_times(&self) -> bool {
        self.wants_time
    }

    fn places(&self) -> Option<Places> {
        self.find(|_| None).ok()
    }

    fn named_in<'a>(&self, header: impl Iterator<Item = &'a str>) -> Option<Places> {
        if !self.is_open {
            return None;
        }
        let names: Vec<String> = header.map(plain).collect();
        let place = |known: &[&str]| names.iter().position(|name| known.contains(&name.as_str()));
        let pair = NAMES.iter().find_map(|(x, y)| Some((place(x)?, place(y)?)));
        let (x, y) = pair.or_else(|| (names.len() > 2 && begins_with_index(&names)).then_some((1, 2)))?;
        let time = if self.wants_time { place(&TIMES) } else { None };
        Some(Places { x, y, time })
    }

    fn find(&self, mut header: impl FnMut(&str) -> Option<usize>) -> Result<Places, &str> {
        Ok(Places {
            x: self.x.find(&mut header)?,
            y: self.y.find(&mut header)?,
            time: self.time.as_ref().map(|time| time.find(&mut header)).transpose()?,
        })
    }

    fn among<'a>(&self, names: impl Iterator<Item = &'a str> + Clone) -> Option<FieldPlaces> {
        let places = match self.is_open {
            true => self.named_in(names),
            false => self.find(|name| names.clone().position(|known| known == name)).ok(),
        };
        places.map(FieldPlaces::from)
    }

    fn in_array(&self, shape: &[u64]) -> Result<FieldPlaces, String> {
        let &[rows, columns] = shape else { return Err("points are rows: save a.reshape(-1, 2)".to_owned()) };
        if columns < 2 {
            return Err("a point has two columns: numpy.column_stack((x, y))".to_owned());
        }
        if rows <= 3 && columns > 3 {
            return Err("points are rows: save a.T".to_owned());
        }
        let unnamed = |_| "its columns have no names: choose them by number, --columns 1,2".to_owned();
        self.find(|_| None).map(FieldPlaces::from).map_err(unnamed)
    }

    fn told(mut names: impl ExactSizeIterator<Item = String>) -> String {
        let [x, y] = std::array::from_fn(|_| names.next().unwrap_or_default());
        format!("x is {x}, y is {y}")
    }
}

impl fmt::Display for Column {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Place(place) => write!(f, "{}", place + 1),
            Self::Name(name) => write!(f, "{}", Excerpt::of(name.as_bytes())),
        }
    }
}

impl Column {
    pub(super) fn find(&self, header: &mut impl FnMut(&str) -> Option<usize>) -> Result<usize, &str> {
        match self {
            Self::Place(place) => Ok(*place),
            Self::Name(name) => header(name).ok_or(name),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(name: &str) -> Column {
        Column::Name(name.to_owned())
    }

    #[test]
    fn columns_are_numbers_or_names() {
        let cases = [
            ("1,2", Column::Place(0), Column::Place(1), None),
            (" 3 , 4 ", Column::Place(2), Column::Place(3), None),
            ("2,1,3", Column::Place(1), Column::Place(0), Some(Column::Place(2))),
            ("1,2,1", Column::Place(0), Column::Place(1), Some(Column::Place(0))),
            ("lon,lat", name("lon"), name("lat"), None),
            ("x,2,time stamp", name("x"), Column::Place(1), Some(name("time stamp"))),
            ("\"2020\",\"2021\"", name("2020"), name("2021"), None),
            ("nan,2nd", name("nan"), name("2nd"), None),
        ];
        for (text, x, y, time) in cases {
            assert_eq!(text.parse(), Ok(Columns { x, y, time, is_open: false, wants_time: false }), "{text}");
        }
    }

    #[test]
    fn malformed_columns_are_refused() {
        let number = |number: &str| ColumnsError::NotAColumn { number: number.to_owned() };
        let cases = [
            ("", ColumnsError::Count { found: 1 }),
            ("1", ColumnsError::Count { found: 1 }),
            ("1,2,3,4", ColumnsError::Count { found: 4 }),
            ("1,", ColumnsError::Empty { entry: 2 }),
            (",2", ColumnsError::Empty { entry: 1 }),
            ("1,2, ", ColumnsError::Empty { entry: 3 }),
            ("\"\",2", ColumnsError::Empty { entry: 1 }),
            ("0,1", number("0")),
            ("1,-2", number("-2")),
            ("1.5,2", number("1.5")),
            ("1,99999999999999999999999", number("99999999999999999999999")),
            ("2,2", ColumnsError::Same),
            ("lat,lat", ColumnsError::Same),
        ];
        for (text, error) in cases {
            assert_eq!(text.parse::<Columns>(), Err(error), "{text:?}");
        }
    }

    #[test]
    fn a_header_names_x_and_y() {
        let named = |header: &str, wants_time| {
            let columns = Columns::default().with_times(wants_time);
            columns.named_in(header.split(',')).map(|Places { x, y, time }| (x, y, time))
        };
        let cases = [
            ("x,y", Some((0, 1, None))),
            (",x,y", Some((1, 2, None))),
            ("Y,X", Some((1, 0, None))),
            ("id,lat,lon", Some((2, 1, None))),
            ("Latitude,Longitude", Some((1, 0, None))),
            ("Easting (m),Northing (m)", Some((0, 1, None))),
            ("# x [m], y [m]", Some((0, 1, None))),
            ("name,x_m,y_m", Some((1, 2, None))),
            ("x,lat", None),
            (",V1,V2", Some((1, 2, None))),
            (",0,1,2", Some((1, 2, None))),
            (",1,2", None),
            (",a", None),
            (",,a,b", None),
            ("a,b", None),
            ("max,may", None),
        ];
        for (header, places) in cases {
            assert_eq!(named(header, false), places, "{header}");
        }
        assert_eq!(named("Time,x,y", true), Some((1, 2, Some(0))));
        assert_eq!(named("Time,x,y", false), Some((1, 2, None)));
        assert_eq!(named("x,y", true), Some((0, 1, None)));
        let chosen: Columns = "1,2".parse().unwrap();
        assert_eq!(chosen.named_in(["y", "x"].into_iter()), None);
    }

    #[test]
    fn names_are_looked_up() {
        let header = |name: &str| ["id", "lon", "lat"].iter().position(|known| *known == name);
        let columns: Columns = "lon,lat,1".parse().unwrap();
        assert_eq!(columns.places(), None);
        assert_eq!(columns.find(header), Ok(Places { x: 1, y: 2, time: Some(0) }));
        let columns: Columns = "lon,alt".parse().unwrap();
        assert_eq!(columns.find(header), Err("alt"));
    }
}
