//! Images and video: from files and bytes to gray pictures, and to the edges in them.
//!
//! In: files, or bytes of a pipe.
//! Out: edge pixels of each picture and frame.
//! Invariants: memory is bounded by the largest picture allowed.
//! Must not know: where edges go, arguments.

mod decode;
pub mod files;
pub mod finder;
mod image;
mod orientation;
pub mod photo;
pub mod video;
