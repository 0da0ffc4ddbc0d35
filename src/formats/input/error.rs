//! What can be wrong with the input, and how it is said.
//!
//! In: the place and the kind of a fault.
//! Out: messages that name the line and the field and say what to do.
//!
//! Invariant: whatever of the input appears in a message has gone through [`Excerpt`], so that messages are short
//! and printable.
//!
//! Must not know: how lines are parsed, or what a caller does about a bad one.

use std::fmt;
use std::io;

use super::excerpt::Excerpt;
use super::foreign::error::ForeignError;
use super::separator::Separator;

/// The input cannot be read any further.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The source failed. Lines that had arrived whole have been handed on before.
    #[error("line {line}: reading failed: {source}")]
    Io {
        /// The line that was being read.
        line: u64,
        /// What the source said.
        source: io::Error,
    },
    /// A column was chosen by a name that the header does not have.
    #[error(
        "line {line}: no column is called \"{name}\" in the header {header}: \
         choose names that are there, or number the columns from 1"
    )]
    UnknownColumn {
        /// The line taken as the header: the first that is neither blank nor a comment.
        line: u64,
        /// The name that was asked for.
        name: String,
        /// The beginning of that line.
        header: Excerpt,
    },
    /// It is a file of another program.
    #[error(transparent)]
    Foreign(#[from] ForeignError),
}

/// A line that could not be read, and why. The lines after it are not affected.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BadLine {
    /// The number of the line, counted from 1.
    pub line: u64,
    /// Where on the line the fault is, if it is not the line as a whole.
    pub field: Option<Field>,
    /// What is wrong.
    pub reason: BadLineReason,
}

impl fmt::Display for BadLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.field {
            Some(field) => write!(f, "line {}, {field}: {}", self.line, self.reason),
            None => write!(f, "line {}: {}", self.line, self.reason),
        }
    }
}

impl std::error::Error for BadLine {}

/// A place on a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Field {
    /// A column of a table, counted from 1.
    Column(usize),
    /// A byte of the line, counted from 1.
    Byte(usize),
    /// A coordinate, counted from 1.
    Coordinate(usize),
    /// A member of a JSON object, or the element of `[x,y,t]` of that meaning.
    Member(Member),
    /// A point of a JSON list of points.
    Listed {
        /// The list: `points` or `retract`.
        list: Member,
        /// The point, counted from 1.
        point: usize,
        /// Its coordinate, unless the fault is in the point as a whole.
        coordinate: Option<Coordinate>,
    },
}

/// A coordinate of a listed point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coordinate {
    /// In the plane it has a name.
    Member(Member),
    /// Elsewhere it has a number, counted from 1.
    Number(usize),
}

impl fmt::Display for Coordinate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Member(member) => member.fmt(f),
            Self::Number(number) => write!(f, "coordinate {number}"),
        }
    }
}

impl fmt::Display for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Column(number) => write!(f, "column {number}"),
            Self::Byte(number) => write!(f, "byte {number}"),
            Self::Coordinate(number) => write!(f, "coordinate {number}"),
            Self::Member(member) => member.fmt(f),
            Self::Listed { list, point, coordinate } => {
                write!(f, "{list}, point {point}")?;
                coordinate.map_or(Ok(()), |coordinate| write!(f, ", {coordinate}"))
            }
        }
    }
}

/// A member that a JSON line may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Member {
    /// The first coordinate of a point.
    X,
    /// The second coordinate of a point.
    Y,
    /// The third coordinate of a point that is not of the plane.
    Z,
    /// The event time of points.
    T,
    /// A list of points to add.
    Points,
    /// A list of points to take back.
    Retract,
    /// The end of a frame.
    Commit,
    /// The time of a commit; that of points if the window wants times and there is no `t`.
    Time,
    /// As `time`, of points only.
    Stamp,
    /// As `time`, of points only.
    Timestamp,
}

impl Member {
    /// Every member, in the order of the variants.
    pub(super) const ALL: [Self; 10] = [
        Self::X,
        Self::Y,
        Self::Z,
        Self::T,
        Self::Points,
        Self::Retract,
        Self::Commit,
        Self::Time,
        Self::Stamp,
        Self::Timestamp,
    ];

    /// Its name in a JSON object.
    pub const fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::T => "t",
            Self::Points => "points",
            Self::Retract => "retract",
            Self::Commit => "commit",
            Self::Time => "time",
            Self::Stamp => "stamp",
            Self::Timestamp => "timestamp",
        }
    }

    /// The member of that name.
    pub(super) fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|member| member.name() == name)
    }
}

impl fmt::Display for Member {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What is wrong with a line, or with the field named beside it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BadLineReason {
    /// The line has more bytes than allowed; they were skipped.
    #[error("longer than {limit} bytes, the most of a line: split it into several")]
    TooLong {
        /// The limit it exceeds.
        limit: usize,
    },
    /// The line is not text.
    #[error("not UTF-8 text: convert the input, as with iconv -f LATIN1 -t UTF-8")]
    NotUtf8,
    /// A field of a table is not a number.
    #[error("{found} is not a number: write one such as 1.5 or -2e-3")]
    NotANumber {
        /// The field.
        found: Excerpt,
    },
    /// A time is neither a number nor a date.
    #[error("{found} is not a time: write seconds such as 1.5, or a date and time such as 2026-11-29T12:30:00Z")]
    NotATime {
        /// The field.
        found: Excerpt,
    },
    /// A number has a comma, where a comma separates columns.
    #[error("{found} has a comma: write {} if it is decimal, {} if it marks thousands", meant[0], meant[1])]
    Comma {
        /// The field.
        found: Excerpt,
        /// With a point in the place of the comma, and without it.
        meant: Box<[Excerpt; 2]>,
    },
    /// A number is written in groups of digits.
    #[error("{found} has marks of thousands: write {meant}")]
    Thousands {
        /// The field.
        found: Excerpt,
        /// Without the marks.
        meant: Box<Excerpt>,
    },
    /// A number has another sign than the hyphen.
    #[error("{found} has a minus sign that is no hyphen: write {meant}")]
    Minus {
        /// The field.
        found: Excerpt,
        /// With a hyphen.
        meant: Box<Excerpt>,
    },
    /// A field has a byte that no text has.
    #[error("{found} has NUL bytes: this is no text, or not in UTF-8, as with iconv -f UTF-16LE -t UTF-8")]
    Nul {
        /// The field.
        found: Excerpt,
    },
    /// A field of a table is empty.
    #[error("empty: write a number")]
    EmptyColumn,
    /// A line of a table has too few columns.
    #[error(
        "missing, split at {separator} the line has {columns} column(s): \
         complete the line, or choose other columns"
    )]
    MissingColumn {
        /// How many columns the line has.
        columns: usize,
        /// What separates them.
        separator: Separator,
    },
    /// A line of a table has more columns than its header.
    #[error("{columns} columns, and the header has {header}: complete the header, or mend the line")]
    TooManyColumns {
        /// How many columns the line has.
        columns: usize,
        /// How many the header has.
        header: usize,
    },
    /// The input ends after its header.
    #[error("this header has no rows after it: add rows, or leave it out")]
    NoRows,
    /// A coordinate, or a distance, that is none.
    #[error("{found} is not a finite number: leave the point out or mend its source")]
    NotFinite {
        /// The value.
        found: String,
    },
    /// A coordinate whose square is beyond all numbers.
    #[error("{found} is beyond 1e150: use a larger unit")]
    TooLarge {
        /// The value.
        found: String,
    },
    /// A latitude that is none.
    #[error("{found} is no latitude, which is from -90 to 90 degrees: if it is a longitude, write it first")]
    Latitude {
        /// The value.
        found: String,
    },
    /// A point of another dimension than those before it.
    #[error("{found} coordinate(s), and the points before have {expected}: give all points as many")]
    Dimension {
        /// How many it has.
        found: usize,
        /// How many those before it have.
        expected: usize,
    },
    /// Samples of a list in which one cannot be used, so that nobody knows what stood between them.
    #[error("{samples} sample(s) of a list with gaps are left out: write each on a line of its own")]
    BrokenList {
        /// How many there are.
        samples: usize,
    },
    /// A point to take back, where that is impossible.
    #[error("points cannot be taken back here: leave the line out")]
    NothingTakenBack,
    /// A JSON line is neither an array nor an object.
    #[error("{found} is neither an array nor an object: write [x,y] or {{\"x\":0,\"y\":0}}")]
    NotAnEntry {
        /// The beginning of the line.
        found: Excerpt,
    },
    /// A line is not valid JSON, or a value in it has the wrong shape.
    #[error("{message}: correct the JSON")]
    Json {
        /// What the JSON parser says.
        message: String,
    },
    /// A JSON value that must be a number is not one.
    #[error("{found} is not a number: write one such as 1.5, without quotes")]
    NotAJsonNumber {
        /// The value, or its kind.
        found: String,
    },
    /// An element of a list of points is no point.
    #[error("{found} is not a point: write [x,y]")]
    NotAPoint {
        /// The value, or its kind.
        found: String,
    },
    /// One of many points of a list that are none.
    #[error("one more of its points is none: correct it like those before")]
    OneMorePoint,
    /// A JSON array has a wrong number of elements.
    #[error("{found} element(s): write {expected}")]
    WrongLength {
        /// How many there are.
        found: usize,
        /// What is allowed.
        expected: &'static str,
    },
    /// A member of a JSON object is needed and not there.
    #[error("missing: write both x and y")]
    MissingMember,
    /// A member of a JSON object is there twice.
    #[error("written twice: write it once")]
    Repeated,
    /// `commit` has another value than `true`.
    #[error("{found} is not true: write \"commit\":true, or leave the line out")]
    NotTrue {
        /// The value, or its kind.
        found: String,
    },
    /// Members of a JSON object belong to different kinds of line.
    #[error("stands beside {other}: write each on a line of its own")]
    Conflict {
        /// The other member.
        other: Member,
    },
    /// A JSON object has no member that says what it is.
    #[error("no x and y, points, retract or commit: write one of them")]
    NothingKnown,
}

/// A fault on a line whose number the finder does not know.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    pub(super) field: Option<Field>,
    pub(super) reason: BadLineReason,
}

impl Fault {
    pub(super) fn of_line(reason: BadLineReason) -> Self {
        Self { field: None, reason }
    }

    pub(super) fn at(field: Field, reason: BadLineReason) -> Self {
        Self { field: Some(field), reason }
    }

    pub(super) fn of_member(member: Member, reason: BadLineReason) -> Self {
        Self::at(Field::Member(member), reason)
    }

    pub(super) fn on_line(self, line: u64) -> BadLine {
        BadLine { line, field: self.field, reason: self.reason }
    }
}
