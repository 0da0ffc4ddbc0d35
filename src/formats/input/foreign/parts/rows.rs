//! Points in binary data of a known layout: row after row, or column after column.
//!
//! In: the layout, and bytes in any pieces.
//! Out: points.
//! Invariants: memory grows with the bytes that have arrived, never with a count that a header claims; row after row it
//! is bounded by one row. Bytes after the last row are left.
//! Must not know: headers.

use super::found::{Found, Queue, counted};
use super::number::Number;
use crate::formats::input::columns::FieldPlaces;
use crate::formats::input::record::Point;

/// A number in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Where in the row it begins.
    pub offset: usize,
    pub number: Number,
    pub is_big_endian: bool,
}

impl Cell {
    #[inline]
    fn read(self, row: &[u8]) -> f64 {
        self.number.read(self.is_big_endian, &row[self.offset..])
    }
}

/// Where the numbers of a point stand.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cells {
    point: Vec<Cell>,
    time: Option<Cell>,
}

impl Cells {
    /// Those at the places; none if one of them holds no number.
    pub fn of(places: &FieldPlaces, cell: impl Fn(usize) -> Option<Cell>) -> Option<Self> {
        let point = places.coordinates.iter().map(|&place| cell(place)).collect::<Option<_>>()?;
        let time = places.time.map_or(Some(None), |place| cell(place).map(Some))?;
        Some(Self { point, time })
    }
}

/// The longest row, in bytes.
pub const LONGEST_ROW: u64 = 1 << 24;

/// Row after row.
#[derive(Debug)]
pub struct Rows {
    cells: Cells,
    /// The length of a row, which holds all cells.
    row: usize,
    total: u64,
    left: u64,
    /// The beginning of the present row.
    partial: Vec<u8>,
}

impl Rows {
    pub fn new(cells: Cells, row: usize, total: u64) -> Self {
        Self { cells, row, total, left: total, partial: Vec::new() }
    }

    /// Takes what belongs to rows from the front of `bytes`.
    pub fn take<P: Point>(&mut self, bytes: &mut &[u8], found: &mut Queue<P>) {
        while self.left > 0 && !bytes.is_empty() {
            let missing = self.row - self.partial.len();
            let (own, rest) = bytes.split_at(missing.min(bytes.len()));
            *bytes = rest;
            if own.len() == self.row {
                found.push_back(self.point(own));
            } else {
                self.partial.extend_from_slice(own);
                if own.len() < missing {
                    return;
                }
                found.push_back(self.point(&self.partial));
                self.partial.clear();
            }
            self.left -= 1;
        }
    }

    #[inline]
    fn point<P: Point>(&self, row: &[u8]) -> Found<P> {
        let Cells { point, time } = &self.cells;
        Found::Point(P::of(point.len(), |axis| point[axis].read(row)), time.map(|time| time.read(row)))
    }

    /// What is missing at the end of the file.
    pub fn missing(&self) -> Option<String> {
        missing(self.left, self.total)
    }
}

fn missing(left: u64, total: u64) -> Option<String> {
    let read = total - left;
    (left > 0).then(|| format!("the file is cut short: {left} of {total} points are missing, after point {read}"))
}

/// One column of data that come column after column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stripe {
    /// The bytes of one value; the number is at its beginning.
    pub size: u64,
    pub number: Option<Number>,
    pub is_big_endian: bool,
}

/// The most bytes of columns that are kept until the others come.
pub const LARGEST_COLUMNS: u64 = 1 << 30;

/// Column after column.
#[derive(Debug)]
pub struct Stripes {
    stripes: Vec<Stripe>,
    /// Values in a column.
    total: u64,
    /// The present column.
    at: usize,
    /// How many of its bytes are still to come.
    left: u64,
    /// The bytes of the present value.
    value: Vec<u8>,
    /// Of each column, where its values go; none if they are not read. Coordinates come in their order, then the time.
    slots: Vec<Option<usize>>,
    /// The values of the columns before, by slot.
    kept: Vec<Vec<f64>>,
    /// How many of the slots are coordinates.
    dimension: usize,
    /// The slot whose values complete points.
    last: Option<usize>,
    points: u64,
}

impl Stripes {
    /// None if there is more to keep than is allowed.
    pub fn new(stripes: Vec<Stripe>, places: &FieldPlaces, total: u64) -> Option<Self> {
        let mut slots = vec![None; stripes.len()];
        for (slot, place) in places.all().enumerate() {
            // A column that is read twice, as a coordinate and as the time, is the coordinate.
            slots.get_mut(place)?.get_or_insert(slot);
        }
        let last = slots.iter().rev().find_map(|&slot| slot);
        let kept = vec![Vec::new(); places.all().count()];
        let room = total.checked_mul((kept.len().saturating_sub(1) * size_of::<f64>()) as u64)?;
        let left = stripes.first().map_or(Some(0), |stripe| stripe.size.checked_mul(total))?;
        stripes.iter().try_fold(0_u64, |sum, stripe| sum.checked_add(stripe.size.checked_mul(total)?))?;
        let (dimension, value) = (places.coordinates.len(), Vec::new());
        let this = Self { stripes, total, at: 0, left, value, slots, kept, dimension, last, points: 0 };
        (room <= LARGEST_COLUMNS).then_some(this)
    }

    /// Takes what belongs to columns from the front of `bytes`.
    pub fn take<P: Point>(&mut self, bytes: &mut &[u8], found: &mut Queue<P>) {
        while self.next_column() && !bytes.is_empty() {
            let stripe = self.stripes[self.at];
            let length = usize::try_from(self.left).unwrap_or(usize::MAX).min(bytes.len());
            let (own, rest) = bytes.split_at(length);
            *bytes = rest;
            self.left -= length as u64;
            if let (Some(slot), Some(number)) = (self.slots[self.at], stripe.number) {
                own.iter().for_each(|&byte| self.byte(byte, stripe, slot, number, found));
            }
        }
    }

    /// Goes to the column that the next byte belongs to. Whether there is one.
    fn next_column(&mut self) -> bool {
        while self.left == 0 {
            self.at += 1;
            let Some(stripe) = self.stripes.get(self.at) else {
                self.at = self.stripes.len();
                return false;
            };
            self.left = stripe.size * self.total;
        }
        true
    }

    fn byte<P: Point>(&mut self, byte: u8, stripe: Stripe, slot: usize, number: Number, found: &mut Queue<P>) {
        self.value.push(byte);
        if self.value.len() as u64 == stripe.size {
            let value = number.read(stripe.is_big_endian, &self.value);
            self.value.clear();
            match self.last == Some(slot) {
                true => self.point(slot, value, found),
                false => self.kept[slot].push(value),
            }
        }
    }

    /// The value of the last column completes a point. It comes with the others of its row, and is not kept.
    fn point<P: Point>(&mut self, last: usize, own: f64, found: &mut Queue<P>) {
        let index = usize::try_from(self.points).unwrap_or(usize::MAX);
        let value = |slot: usize| if slot == last { Some(own) } else { self.kept[slot].get(index).copied() };
        let point = P::of(self.dimension, |slot| value(slot).unwrap_or(f64::NAN));
        let time = if self.kept.len() > self.dimension { value(self.dimension) } else { None };
        found.push_back(Found::Point(point, time));
        self.points += 1;
    }

    /// What is missing at the end of the file.
    pub fn missing(&mut self) -> Option<String> {
        if !self.next_column() {
            return None;
        }
        let whole = missing(self.total - self.points, self.total);
        whole.or_else(|| Some(format!("the file is cut short: {} of it are missing", counted(self.left, "byte"))))
    }
}
