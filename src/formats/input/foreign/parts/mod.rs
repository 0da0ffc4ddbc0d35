//! Pieces that several foreign formats share: what is found, lines, numbers, rows of binary data, compression.
//!
//! In: bytes, in any pieces.
//! Out: what they hold.
//! Must not know: a format.

pub mod found;
pub mod literals;
pub mod lzf;
pub mod number;
pub mod rows;
pub mod tail;
pub mod text_lines;
