//! Which columns of a table, or fields of a file, are the coordinates of points of any dimension.
//!
//! In: a choice such as `2,3,4` or `x,y,z`, or none; the names in a header.
//! Out: [`SpaceColumns`], which make a point of every line.
//! Invariants: without a choice all columns of a table are coordinates, but an index without a name, and the event time
//! where one is wanted and the header names it. Empty fields at the end of a line say nothing. No column is read twice.
//! Must not know: how many coordinates the other points have.

use std::str::FromStr;

use super::super::columns::{
    Column, ColumnsError, FieldPlaces, PointColumns, TIMES, begins_with_index, column as column_of, plain,
};
use super::super::error::{BadLineReason, Fault, Field};
use super::super::numbers;
use super::super::record::Point;
use super::super::separator::{Fields, Separator};
use super::super::text::{Choice, Row, TableColumns, value_at};
use crate::formats::input::excerpt::Excerpt;

/// The names of coordinates among the fields of a file.
const AXES: [&str; 3] = ["x", "y", "z"];

/// How many names are told.
const TOLD: usize = 8;

/// The columns that are coordinates: those that were chosen, in this order, else all.
///
/// Parsed from numbers, counted from 1, and names, separated by commas. In double quotes an entry is always a name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SpaceColumns {
    chosen: Option<Vec<Column>>,
    wants_time: bool,
    /// The most columns of an array, and what they are.
    most: Most,
}

/// How many columns an array may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Most {
    Coordinates(usize),
    Distances(usize),
}

/// Where the coordinates are in a table, counted from 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SpacePlaces {
    /// In their order; if there is no choice, none.
    chosen: Option<Vec<usize>>,
    has_index: bool,
    time: Option<usize>,
}

impl SpaceColumns {
    /// All columns, of which an array may have so many.
    pub(super) fn all(most: Most) -> Self {
        Self { chosen: None, wants_time: false, most }
    }

    /// The same, with event times where the header names them.
    pub(super) fn with(self, wants_time: bool, most: Most) -> Self {
        Self { wants_time, most, ..self }
    }

    /// Of columns that were found in this order, the coordinates and the time.
    fn sorted(&self, found: Vec<usize>) -> SpacePlaces {
        let is_time = |column: &Column| matches!(column, Column::Name(name) if TIMES.contains(&plain(name).as_str()));
        let chosen = self.chosen.iter().flatten();
        let time = chosen.zip(&found).find(|(column, _)| self.wants_time && found.len() > 1 && is_time(column));
        let time = time.map(|(_, &place)| place);
        let coordinates = found.into_iter().filter(|&place| Some(place) != time).collect();
        SpacePlaces { chosen: Some(coordinates), has_index: false, time }
    }
}

impl FromStr for SpaceColumns {
    type Err = ColumnsError;

    fn from_str(choice: &str) -> Result<Self, ColumnsError> {
        let chosen = choice.split(',').zip(1..).map(|(text, entry)| column_of(text, entry));
        let chosen: Vec<Column> = chosen.collect::<Result<_, _>>()?;
        let mut known = std::collections::HashSet::new();
        if let Some(column) = chosen.iter().find(|column| !known.insert(*column)) {
            return Err(ColumnsError::Twice { column: column.to_string() });
        }
        Ok(Self { chosen: Some(chosen), ..Self::default() })
    }
}

impl Default for SpaceColumns {
    fn default() -> Self {
        Self::all(Most::Coordinates(super::MOST_COORDINATES))
    }
}

impl Point for Vec<f64> {
    fn of(dimension: usize, coordinate: impl Fn(usize) -> f64) -> Self {
        (0..dimension).map(coordinate).collect()
    }
}

impl PointColumns for SpaceColumns {
    type Point = Vec<f64>;
    type Places = SpacePlaces;

    fn wants_times(&self) -> bool {
        self.wants_time
    }

    fn places(&self) -> Option<SpacePlaces> {
        self.find(|_| None).ok()
    }

    fn named_in<'a>(&self, header: impl Iterator<Item = &'a str>) -> Option<SpacePlaces> {
        if self.chosen.is_some() {
            return None;
        }
        let names: Vec<String> = header.map(plain).collect();
        let has_index = begins_with_index(&names);
        let time = names.iter().position(|name| self.wants_time && TIMES.contains(&name.as_str()));
        let left = names.len() - usize::from(has_index) - usize::from(time.is_some());
        // What names neither says nothing that is not so without it.
        (left > 0 && left < names.len()).then_some(SpacePlaces { chosen: None, has_index, time })
    }

    fn find(&self, mut header: impl FnMut(&str) -> Option<usize>) -> Result<SpacePlaces, &str> {
        match &self.chosen {
            None => Ok(SpacePlaces { chosen: None, has_index: false, time: None }),
            Some(chosen) => {
                let found = chosen.iter().map(|column| column.find(&mut header)).collect::<Result<_, _>>()?;
                Ok(self.sorted(found))
            }
        }
    }

    fn among<'a>(&self, names: impl Iterator<Item = &'a str> + Clone) -> Option<FieldPlaces> {
        if self.chosen.is_some() {
            let SpacePlaces { chosen, time, .. } =
                self.find(|name| names.clone().position(|known| known == name)).ok()?;
            return Some(FieldPlaces { coordinates: chosen?, time });
        }
        let names: Vec<String> = names.map(plain).collect();
        let place = |wanted: &&str| names.iter().position(|name| name == wanted);
        let coordinates: Vec<usize> = AXES.iter().map_while(place).collect();
        let time = TIMES.iter().find_map(place).filter(|_| self.wants_time);
        (!coordinates.is_empty()).then_some(FieldPlaces { coordinates, time })
    }

    fn in_array(&self, shape: &[u64]) -> Result<FieldPlaces, String> {
        let width = match *shape {
            [_] => 1,
            [_, width] => width,
            _ => return Err("points are rows: save a.reshape(len(a), -1)".to_owned()),
        };
        if let Some(chosen) = &self.chosen {
            let unnamed = |_| format!("its columns have no names: choose {} by number", words(chosen.iter()));
            let SpacePlaces { chosen, time, .. } = self.find(|_| None).map_err(unnamed)?;
            return Ok(FieldPlaces { coordinates: chosen.unwrap_or_default(), time });
        }
        let width = usize::try_from(width).unwrap_or(usize::MAX);
        match self.most {
            _ if width == 0 => Err("a row has no numbers: save what has some".to_owned()),
            Most::Coordinates(most) if width > most => {
                Err(format!("a point has at most {most} coordinates: take fewer columns, or reduce them, as by PCA"))
            }
            Most::Distances(most) if width > most => {
                Err(format!("a matrix is of at most {most} points: take a smaller sample"))
            }
            _ => Ok(FieldPlaces { coordinates: (0..width).collect(), time: None }),
        }
    }

    fn told(names: impl ExactSizeIterator<Item = String>) -> String {
        let dimension = names.len();
        format!("{dimension} coordinate(s), {}", words(names))
    }
}

/// The first of many things, in words.
fn words<T: ToString>(all: impl ExactSizeIterator<Item = T>) -> String {
    let more = if all.len() > TOLD { ", ..." } else { "" };
    let first: Vec<String> = all.take(TOLD).map(|one| one.to_string()).collect();
    format!("{}{more}", first.join(", "))
}

impl SpacePlaces {
    fn is_index(&self, place: usize) -> bool {
        self.has_index && place == 0
    }

    /// Of a line whose columns all are coordinates, but index and time.
    fn whole_row(&self, fields: &mut Fields<'_>, separator: Separator) -> Result<Values, Fault> {
        let mut values = Values::default();
        // An empty field says nothing if no other comes after it.
        let mut empty = None;
        for (place, field) in fields.enumerate() {
            if field.is_empty() {
                empty = empty.or_else(|| (!self.is_index(place)).then_some(place));
                continue;
            }
            if let Some(place) = empty {
                return Err(Fault::at(Field::Column(place + 1), BadLineReason::EmptyColumn));
            }
            values.seen = place + 1;
            let value = |read: fn(&str, Separator) -> Result<f64, BadLineReason>| {
                value_at(place, Some(field), separator, read, || BadLineReason::EmptyColumn)
            };
            if self.time == Some(place) {
                values.time = Some(value(numbers::time)?);
            } else if !self.is_index(place) {
                values.point.push(value(numbers::number)?);
            }
        }
        let columns = values.seen;
        match self.time.filter(|_| values.time.is_none()) {
            Some(time) => {
                let reason = BadLineReason::MissingColumn { columns, separator };
                Err(Fault::at(Field::Column(time + 1), reason))
            }
            None if values.point.is_empty() => {
                let first = usize::from(self.has_index);
                Err(Fault::at(Field::Column(first + 1), BadLineReason::EmptyColumn))
            }
            None => Ok(values),
        }
    }

    /// Of a line of which these columns are read.
    fn chosen_row(&self, chosen: &[usize], fields: &mut Fields<'_>, separator: Separator) -> Result<Values, Fault> {
        let last = chosen.iter().copied().chain(self.time).max().unwrap_or(0);
        let fields: Vec<&str> = fields.take(last + 1).collect();
        let missing = || BadLineReason::MissingColumn { columns: fields.len(), separator };
        let number = |&place: &usize| value_at(place, fields.get(place).copied(), separator, numbers::number, missing);
        let point = chosen.iter().map(number).collect::<Result<_, _>>()?;
        let time = |place: usize| value_at(place, fields.get(place).copied(), separator, numbers::time, missing);
        Ok(Values { point, time: self.time.map(time).transpose()?, seen: fields.len() })
    }
}

/// What is read of a line.
#[derive(Default)]
struct Values {
    point: Vec<f64>,
    time: Option<f64>,
    /// The fields up to the last that was read.
    seen: usize,
}

impl TableColumns for SpaceColumns {
    fn fields<'a>(places: &SpacePlaces, line: &'a str, separator: Separator) -> impl Iterator<Item = &'a str> {
        let is_read = |place: &usize| match &places.chosen {
            Some(chosen) => chosen.contains(place) || places.time == Some(*place),
            None => !places.is_index(*place),
        };
        separator.split(line).enumerate().filter(move |(place, _)| is_read(place)).map(|(_, field)| field)
    }

    fn row<'a>(places: &SpacePlaces, line: &'a str, separator: Separator) -> Result<Row<'a, Vec<f64>>, Fault> {
        let mut rest = separator.split(line);
        let Values { point, time, seen } = match &places.chosen {
            Some(chosen) => places.chosen_row(chosen, &mut rest, separator)?,
            None => places.whole_row(&mut rest, separator)?,
        };
        Ok(Row { point, time, seen, rest })
    }

    fn column(places: &SpacePlaces, coordinate: usize) -> usize {
        match &places.chosen {
            Some(chosen) => chosen.get(coordinate).copied().unwrap_or(coordinate),
            None => {
                let column = coordinate + usize::from(places.has_index);
                column + usize::from(places.time.is_some_and(|time| time <= column))
            }
        }
    }

    fn choice(places: &SpacePlaces, separator: Separator, header: &str) -> Choice {
        let name = |place| Excerpt::of(separator.split(header).nth(place).unwrap_or_default().as_bytes());
        let index = if places.has_index { ", column 1 is an index" } else { "" };
        let time = places.time.map(|place| format!(", t is column {} {}", place + 1, name(place))).unwrap_or_default();
        let text = format!("the header names columns: all are coordinates{index}{time}");
        Choice { text, names: Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(header: &str, wants_time: bool) -> Option<(bool, Option<usize>)> {
        let columns = SpaceColumns::default().with(wants_time, Most::Coordinates(9));
        columns.named_in(header.split(',')).map(|places| (places.has_index, places.time))
    }

    #[test]
    fn a_header_names_what_is_no_coordinate() {
        for (header, wants_time, found) in [
            ("x,y,z", true, None),
            (",x,y,z", false, Some((true, None))),
            (",0,1", false, Some((true, None))),
            (",value", false, Some((true, None))),
            ("t,x,y", false, None),
            ("t,x,y", true, Some((false, Some(0)))),
            (",x,Time [s]", true, Some((true, Some(2)))),
            ("t", true, None),
            (",t", true, None),
        ] {
            assert_eq!(named(header, wants_time), found, "{header}");
        }
    }

    #[test]
    fn columns_are_chosen_by_number_or_name_each_once() {
        let columns: SpaceColumns = "3,1,\"2\"".parse().unwrap();
        assert_eq!(columns.places(), None);
        let places = columns.find(|name| (name == "2").then_some(6)).unwrap();
        assert_eq!(places.chosen, Some(vec![2, 0, 6]));
        assert_eq!(columns.find(|_| None), Err("2"));
        let error = |choice: &str| choice.parse::<SpaceColumns>().unwrap_err().to_string();
        assert_eq!(error("1,2,1"), "the column 1 is chosen twice: choose each once");
        assert_eq!(error("x,\"x\""), "the column \"x\" is chosen twice: choose each once");
        assert_eq!(error("1,,2"), "entry 2 is empty: write the number or the name of a column");
        assert_eq!(error("0"), "0 is not a column: count columns from 1, or put a name in double quotes");
    }

    #[test]
    fn a_chosen_time_is_no_coordinate_where_times_are_wanted() {
        let place = |name: &str| ["a", "stamp", "b"].iter().position(|known| *known == name);
        let columns: SpaceColumns = "a,stamp,b".parse().unwrap();
        let found = columns.find(place).unwrap();
        assert_eq!((found.chosen, found.time), (Some(vec![0, 1, 2]), None));
        let columns = columns.with(true, Most::Coordinates(9));
        let found = columns.find(place).map(|found| (found.chosen, found.time));
        assert_eq!(found, Ok((Some(vec![0, 2]), Some(1))));
    }

    #[test]
    fn coordinates_are_in_columns() {
        let places = |chosen, has_index, time| SpacePlaces { chosen, has_index, time };
        let columns = |places: &SpacePlaces| [0, 1, 2].map(|coordinate| SpaceColumns::column(places, coordinate));
        assert_eq!(columns(&places(None, false, None)), [0, 1, 2]);
        assert_eq!(columns(&places(None, true, Some(2))), [1, 3, 4]);
        assert_eq!(columns(&places(None, true, Some(1))), [2, 3, 4]);
        assert_eq!(columns(&places(Some(vec![5, 3, 7]), false, None)), [5, 3, 7]);
    }
}
