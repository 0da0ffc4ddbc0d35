//! What a source sends to a stream: points, retractions, commits, its end.
//!
//! In: values that a reader has parsed. Out: the same, for the queue of a stream.
//!
//! Invariants: times, tags and lines of a batch are empty or one for each point.
//!
//! Must not know: queues, threads, the text that they were parsed from.

/// Points of stdin that are handed on together, at most.
pub const BATCH: usize = 4096;

/// Points to insert or to take back.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// Their positions.
    pub positions: Vec<(f64, f64)>,
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
        Self { positions: Vec::new(), times: Vec::new(), tags: Vec::new(), lines: Vec::new(), place: "line" }
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
                size_of_val(positions.as_slice())
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
