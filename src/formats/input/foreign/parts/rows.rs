//! Points in binary data of a known layout: row after row, or column after column.
//!
//! In: the layout, and bytes in any pieces.
//! Out: points.
//! Invariants: memory grows with the bytes that have arrived, never with a count that a header claims; row after row it
//! is bounded by one row. Bytes after the last row are left.
//! Must not know: headers.

use super::found::{Found, Queue, counted};
use super::number::Number;

/// A number in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Where in the row it begins.
    pub offset: usize,
    pub number: Number,
    pub is_big_endian: bool,
}

impl Cell {
    fn read(self, row: &[u8]) -> f64 {
        self.number.read(self.is_big_endian, &row[self.offset..])
    }
}

/// Where the numbers of a point stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cells {
    pub x: Cell,
    pub y: Cell,
    pub time: Option<Cell>,
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
    pub fn take(&mut self, bytes: &mut &[u8], found: &mut Queue) {
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

    fn point(&self, row: &[u8]) -> Found {
        let Cells { x, y, time } = self.cells;
        Found::Point([x.read(row), y.read(row)], time.map(|time| time.read(row)))
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
    pub role: Option<Role>,
}

/// What a column is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    X,
    Y,
    Time,
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
    /// The values of the columns before, by role.
    kept: [Vec<f64>; 3],
    /// The role whose values complete points.
    last: Option<Role>,
    points: u64,
}

impl Stripes {
    /// None if there is more to keep than is allowed.
    pub fn new(stripes: Vec<Stripe>, total: u64) -> Option<Self> {
        let last = stripes.iter().rev().find_map(|stripe| stripe.role);
        let kept = stripes.iter().filter(|stripe| stripe.role.is_some()).count().saturating_sub(1) as u64;
        let room = total.checked_mul(kept * size_of::<f64>() as u64)?;
        let left = stripes.first().map_or(Some(0), |stripe| stripe.size.checked_mul(total))?;
        stripes.iter().try_fold(0_u64, |sum, stripe| sum.checked_add(stripe.size.checked_mul(total)?))?;
        let kept = Default::default();
        let this = Self { stripes, total, at: 0, left, value: Vec::new(), kept, last, points: 0 };
        (room <= LARGEST_COLUMNS).then_some(this)
    }

    /// Takes what belongs to columns from the front of `bytes`.
    pub fn take(&mut self, bytes: &mut &[u8], found: &mut Queue) {
        while self.next_column() && !bytes.is_empty() {
            let stripe = self.stripes[self.at];
            let length = usize::try_from(self.left).unwrap_or(usize::MAX).min(bytes.len());
            let (own, rest) = bytes.split_at(length);
            *bytes = rest;
            self.left -= length as u64;
            if let (Some(role), Some(number)) = (stripe.role, stripe.number) {
                own.iter().for_each(|&byte| self.byte(byte, stripe, role, number, found));
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

    fn byte(&mut self, byte: u8, stripe: Stripe, role: Role, number: Number, found: &mut Queue) {
        self.value.push(byte);
        if self.value.len() as u64 == stripe.size {
            let value = number.read(stripe.is_big_endian, &self.value);
            self.value.clear();
            self.kept[role as usize].push(value);
            if self.last == Some(role) {
                self.point(found);
            }
        }
    }

    fn point(&mut self, found: &mut Queue) {
        let index = usize::try_from(self.points).unwrap_or(usize::MAX);
        // Those of the column that completes points come one by one, and are not kept.
        let mut value = |role: Role| match self.last == Some(role) {
            true => self.kept[role as usize].pop(),
            false => self.kept[role as usize].get(index).copied(),
        };
        if let (Some(x), Some(y)) = (value(Role::X), value(Role::Y)) {
            found.push_back(Found::Point([x, y], value(Role::Time)));
            self.points += 1;
        }
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
