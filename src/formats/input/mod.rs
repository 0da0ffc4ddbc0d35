//! Input: from bytes to the parsed lines of a point stream.
//!
//! In: any [`std::io::Read`], a [`Format`], the [`Columns`] of a table and the [`Limits`].
//! Out: one [`Record`] a line, from a [`Reader`]: points, retractions, commits, blank lines, headers and comments,
//! and lines that cannot be read, each with a message that names the line, the field and the remedy. For other
//! files of lines than points: [`Lines`] and [`Excerpt`].
//! Invariants: a bad line never stops the rest; memory is bounded by the longest line allowed; how the source cuts
//! its bytes into reads changes nothing in what comes out; a line is handed on as soon as its line end has arrived.
//! Must not know: what is done with the points. It does not refuse `nan`, close frames, count bad lines or print.
//!
//! Tables are read here and not by the crate `csv`: the separator (comma, semicolon, tab, blanks) is decided by the
//! first lines and may be any run of blanks; a bad field is reported with its line, its column and what would help,
//! and the rest of the file goes on; numbers are parsed from the bytes in place, without a record of strings in
//! between. JSON lines are parsed by `serde_json`, numbers included (its feature `float_roundtrip` gives the
//! nearest double); only the visitors are ours, so that points go straight into the caller's buffer and errors
//! quote no long string.
//!
//! Layers, each knowing only those before it: `excerpt` and `error` (how to say what is wrong), `format` and
//! `columns` (what to expect), `lines` (bytes to lines), `separator`, `numbers` and `text` (a table's line to numbers),
//! `json_literals`, `json_values` and `jsonl` (a JSON line to numbers), `decoding` and `foreign` (compressed files and
//! those of other programs), `reader` (all of it together). They are generic over what columns make, by the traits
//! `PointColumns` and `JsonPoint`: points of the plane, or of any dimension. The latter are in `space`, with distances.

mod columns;
mod decoding;
mod error;
mod excerpt;
mod foreign;
mod format;
mod json_literals;
mod json_values;
mod jsonl;
mod lines;
mod numbers;
mod reader;
mod record;
mod separator;
pub mod space;
mod text;

#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;

pub use columns::{Columns, ColumnsError};
pub use error::ReadError;
pub use excerpt::Excerpt;
pub use format::{Format, opened};
pub use lines::{Line, Lines};
pub use reader::{Limits, Reader};
pub use record::Record;
pub use text::Choice;
