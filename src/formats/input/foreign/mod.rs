//! Files of other programs: what they are, and the points in those that are read.
//!
//! In: the first bytes of a source; then all of them.
//! Out: what the source is; points, entries and faults, in the order of the file.
//! Invariants: points are found as soon as their bytes have arrived. Memory grows with the bytes that are there, never
//! with what a header claims. What is missing at the end, and what stands after it, is reported.
//! Must not know: what becomes of the points.
//!
//! Layers: `refusal` and `error` (what is said), `signature` and `json_start` (what a file is); `parts` (what formats
//! share); `npy`, `ply`, `pcd`, `geojson` and `elements` (one format each).

use std::io::Read;

mod elements;
pub(super) mod error;
mod geojson;
mod json_start;
mod npy;
mod parts;
mod pcd;
mod ply;
mod refusal;
pub(super) mod signature;

#[cfg(test)]
mod tests;

use self::elements::Elements;
use self::error::ForeignError;
use self::geojson::GeoJson;
use self::npy::Npy;
use self::parts::found::{Found, Queue};
use self::pcd::Pcd;
use self::ply::Ply;
use super::columns::PointColumns;
use super::decoding::Damage;
use super::lines::Lines;
use super::record::Parsed;
use super::text::Choice;

/// A format that is read here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Readable {
    /// Arrays of numpy.
    Npy,
    /// Polygons and point clouds.
    Ply,
    /// Point clouds of PCL.
    Pcd,
    /// Geometries in degrees.
    GeoJson,
    /// JSON documents of points.
    Elements,
}

/// Reads a foreign file.
#[derive(Debug)]
pub(super) struct Foreign<C: PointColumns> {
    machine: Machine<C>,
    queue: Queue<C::Point>,
    /// The number of the last point or element, counted from 1.
    number: u64,
    has_choice: bool,
    has_ended: bool,
}

/// What finds points in bytes.
#[derive(Debug)]
enum Machine<C> {
    Npy(Box<Npy<C>>),
    Ply(Box<Ply<C>>),
    Pcd(Box<Pcd<C>>),
    GeoJson(Box<GeoJson>),
    Elements(Box<Elements>),
}

impl<C: PointColumns> Foreign<C> {
    /// Reads a format. No line, element or single value has more bytes than the limit.
    pub(super) fn new(format: Readable, columns: C, limit: usize) -> Self {
        let machine = match format {
            Readable::Npy => Machine::Npy(Box::new(Npy::new(columns))),
            Readable::Ply => Machine::Ply(Box::new(Ply::new(columns, limit))),
            Readable::Pcd => Machine::Pcd(Box::new(Pcd::new(columns, limit))),
            Readable::GeoJson => Machine::GeoJson(Box::new(GeoJson::new(limit))),
            Readable::Elements => Machine::Elements(Box::new(Elements::new(columns.wants_times(), limit))),
        };
        Self { machine, queue: Queue::new(), number: 0, has_choice: true, has_ended: false }
    }

    /// What comes next; none at the end. Points are put into `points`.
    pub(super) fn next<R: Read>(
        &mut self,
        source: &mut Lines<R>,
        points: &mut Vec<C::Point>,
    ) -> Result<Option<Parsed>, ForeignError> {
        loop {
            if let Some(found) = self.queue.pop_front() {
                return Ok(Some(self.parsed(found, points)));
            }
            if self.has_ended {
                return Ok(None);
            }
            self.read(source)?;
        }
    }

    /// Whether what comes next is said of a point of the element before.
    pub(super) fn has_fault(&self) -> bool {
        matches!(self.queue.front(), Some(Found::Part(_)))
    }

    /// Whether something was found that was not handed out.
    pub(super) fn is_ready(&self) -> bool {
        !self.queue.is_empty()
    }

    /// The number of the last point or element.
    pub(super) fn number(&self) -> u64 {
        self.number
    }

    /// What is counted.
    pub(super) fn unit(&self) -> &'static str {
        if matches!(self.machine, Machine::Elements(_)) { "element" } else { "point" }
    }

    /// What is read as x and y, for people; once, after it is known.
    pub(super) fn take_choice(&mut self) -> Option<Choice> {
        let choice = match &mut self.machine {
            Machine::Npy(npy) => npy.choice.take(),
            Machine::Ply(ply) => ply.choice.take(),
            Machine::Pcd(pcd) => pcd.choice.take(),
            Machine::GeoJson(geojson) if self.has_choice && self.number > 0 => Some(geojson.choice()),
            Machine::GeoJson(_) | Machine::Elements(_) => None,
        };
        self.has_choice &= choice.is_none();
        let is_degrees = matches!(&self.machine, Machine::GeoJson(geojson) if geojson.is_degrees());
        let names = if is_degrees { ["longitude", "latitude"].map(str::to_owned).to_vec() } else { Vec::new() };
        choice.map(|text| Choice { text, names })
    }

    fn read<R: Read>(&mut self, source: &mut Lines<R>) -> Result<(), ForeignError> {
        let bytes = match source.take_bytes() {
            Ok(bytes) => bytes,
            Err(error) => match Damage::of(&error) {
                Some(damage) => {
                    self.queue.push_back(Found::Missed(damage.to_string()));
                    return self.finish();
                }
                None => return Err(ForeignError::Io { unit: self.unit(), number: self.number, source: error }),
            },
        };
        if bytes.is_empty() {
            return self.finish();
        }
        let found = &mut self.queue;
        match &mut self.machine {
            Machine::Npy(npy) => npy.push(bytes, found),
            Machine::Ply(ply) => ply.push(bytes, found),
            Machine::Pcd(pcd) => pcd.push(bytes, found),
            Machine::GeoJson(geojson) => {
                geojson.push(bytes, found);
                Ok(())
            }
            Machine::Elements(elements) => {
                elements.push(bytes, found);
                Ok(())
            }
        }
    }

    fn finish(&mut self) -> Result<(), ForeignError> {
        self.has_ended = true;
        let found = &mut self.queue;
        let missing = match &mut self.machine {
            Machine::Npy(npy) => npy.finish()?,
            Machine::Ply(ply) => ply.finish(found)?,
            Machine::Pcd(pcd) => pcd.finish(found)?,
            Machine::GeoJson(geojson) => {
                geojson.finish(found);
                None
            }
            Machine::Elements(elements) => elements.finish(found),
        };
        self.queue.extend(missing.map(Found::Missed));
        Ok(())
    }

    fn parsed(&mut self, found: Found<C::Point>, points: &mut Vec<C::Point>) -> Parsed {
        self.number += u64::from(!matches!(found, Found::Missed(_) | Found::Part(_)));
        match found {
            Found::Point(point, time) => {
                points.push(point);
                Parsed::Points { time }
            }
            Found::Entry(parsed, own) => {
                points.extend(own);
                parsed
            }
            Found::Bad(reason) | Found::Part(reason) => {
                Parsed::Missed(format!("{} {}: {reason}", self.unit(), self.number))
            }
            Found::Missed(reason) => Parsed::Missed(reason),
        }
    }
}
