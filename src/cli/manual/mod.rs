//! What shells and `man` are told of this program.
//!
//! In: the command line's description.
//! Out: scripts that complete words, pages of the manual.
//! Must not know: what commands do.

pub mod completions;
pub mod man;
