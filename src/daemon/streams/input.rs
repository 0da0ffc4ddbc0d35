//! What a source sends to a stream: points, retractions, commits, its end.
//!
//! In: values that a reader has parsed. Out: the same, for the queue of a stream.
//!
//! Invariants: times, tags and lines of a batch are empty or one for each point.
//!
//! Must not know: queues, threads, the text that they were parsed from.

use std::ops::Range;

/// Points of stdin that are handed on together, at most.
pub const BATCH: usize = 4096;

/// Positions of points, one after the other.
#[derive(Clone, Debug, PartialEq)]
pub enum Positions {
    /// In the plane.
    Plane(Vec<(f64, f64)>),
    /// Of so many coordinates each, which is at least one.
    Space {
        /// How many.
        dimension: usize,
        /// Of all points; whole points.
        coordinates: Vec<f64>,
    },
}

impl Default for Positions {
    fn default() -> Self {
        Self::Plane(Vec::new())
    }
}

impl Positions {
    /// How many points there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Plane(points) => points.len(),
            Self::Space { dimension, coordinates } => coordinates.len() / dimension,
        }
    }

    /// How many coordinates each has; none if there are no points.
    pub fn dimension(&self) -> Option<u32> {
        let dimension = match self {
            Self::Plane(_) => 2,
            Self::Space { dimension, .. } => *dimension as u32,
        };
        (!self.is_empty()).then_some(dimension)
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A point.
    pub fn get(&self, index: usize) -> Point<'_> {
        match self {
            Self::Plane(points) => Point::Plane(points[index].0, points[index].1),
            Self::Space { dimension, coordinates } => Point::Space(&coordinates[index * dimension..][..*dimension]),
        }
    }

    /// Whether a point may come after those that are there: all are in one space.
    pub fn takes(&self, point: Point) -> bool {
        match (self, point) {
            _ if self.is_empty() => true,
            (Self::Plane(_), Point::Plane(..)) => true,
            (Self::Space { dimension, .. }, Point::Space(coordinates)) => *dimension == coordinates.len(),
            _ => false,
        }
    }

    /// Appends a point that they take.
    pub fn push(&mut self, point: Point) {
        match (&mut *self, point) {
            (Self::Plane(points), Point::Plane(x, y)) => points.push((x, y)),
            (Self::Space { dimension, coordinates }, Point::Space(point)) if *dimension == point.len() => {
                coordinates.extend_from_slice(point);
            }
            (_, Point::Plane(x, y)) => *self = Self::Plane(vec![(x, y)]),
            (_, Point::Space(point)) => {
                *self = Self::Space { dimension: point.len().max(1), coordinates: point.to_vec() };
            }
        }
    }

    /// Some of the points.
    pub fn some(&self, range: Range<usize>) -> Self {
        match self {
            Self::Plane(points) => Self::Plane(points[range].to_vec()),
            Self::Space { dimension, coordinates } => Self::Space {
                dimension: *dimension,
                coordinates: coordinates[range.start * dimension..range.end * dimension].to_vec(),
            },
        }
    }

    fn bytes(&self) -> usize {
        match self {
            Self::Plane(points) => size_of_val(points.as_slice()),
            Self::Space { coordinates, .. } => size_of_val(coordinates.as_slice()),
        }
    }
}

/// A point of any space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Point<'a> {
    /// In the plane.
    Plane(f64, f64),
    /// Of as many coordinates as there are.
    Space(&'a [f64]),
}

impl Point<'_> {
    /// What `work` makes of its coordinates.
    pub fn with_coordinates<T>(self, work: impl FnOnce(&[f64]) -> T) -> T {
        match self {
            Self::Plane(x, y) => work(&[x, y]),
            Self::Space(coordinates) => work(coordinates),
        }
    }
}

/// Points to insert or to take back.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// Their positions.
    pub positions: Positions,
    /// Their event times: none, or one for each point.
    pub times: Vec<f64>,
    /// The producer's own numbers: none, or one for each point.
    pub tags: Vec<u64>,
    /// The lines of the input that they stand on: none, or one for each point.
    pub lines: Vec<u64>,
    /// What these count: lines, unless the input has none.
    pub place: &'static str,
}

impl Default for Batch {
    fn default() -> Self {
        Self { positions: Positions::default(), times: Vec::new(), tags: Vec::new(), lines: Vec::new(), place: "line" }
    }
}

/// One thing that a source sends.
#[derive(Clone, Debug)]
pub enum Input {
    /// Points to insert.
    Points(Batch),
    /// Points to take back.
    Retract(Batch),
    /// The end of a frame, with the time it shall carry.
    Commit(Option<f64>),
    /// The source sends nothing more.
    Close {
        /// Whether the stream ends too.
        end: bool,
    },
    /// The source is gone without a word: what it has not committed is left out.
    Abandon,
    /// Something that could not be read, with where and why.
    Unreadable(String),
    /// The source has failed and sends nothing more.
    Failed(String),
}

/// An item takes the room of so many points besides its own, so that a queue of commits is bounded.
pub const ROOM_OF_AN_ITEM: usize = 16;

impl Input {
    /// The room that it takes in a queue, in points.
    pub fn room(&self) -> usize {
        self.points() + ROOM_OF_AN_ITEM
    }

    /// Its points.
    pub fn points(&self) -> usize {
        match self {
            Self::Points(batch) | Self::Retract(batch) => batch.positions.len(),
            _ => 0,
        }
    }

    /// About how many bytes it takes.
    pub fn bytes(&self) -> usize {
        let of_items = match self {
            Self::Points(Batch { positions, times, tags, lines, .. })
            | Self::Retract(Batch { positions, times, tags, lines, .. }) => {
                positions.bytes()
                    + size_of_val(times.as_slice())
                    + size_of_val(tags.as_slice())
                    + size_of_val(lines.as_slice())
            }
            Self::Unreadable(text) | Self::Failed(text) => text.len(),
            Self::Commit(_) | Self::Close { .. } | Self::Abandon => 0,
        };
        size_of::<Self>() + of_items
    }

    /// Whether a full queue may drop it.
    pub fn may_be_dropped(&self) -> bool {
        matches!(self, Self::Points(_) | Self::Retract(_))
    }
}
