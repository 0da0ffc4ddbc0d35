//! The working memory of one thread that works on tiles.
//!
//! In: nothing.
//! Out: a [`Worker`].
//! Invariant: results do not depend on what a worker did before.
//! Must not know: the tree of tiles.

use super::difference::Difference;
use super::star::Stars;
use super::star_reader::StarReader;
use super::tile_reduction::TileReduction;
use crate::topology::cloud::{Located, Slot};

/// What to do with a star in a round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StarUpdate {
    /// It is valid.
    Keep,
    /// It is read again.
    Read,
    /// Its vertex is gone.
    Drop,
}

/// Working memory and results.
#[derive(Clone, Debug, Default)]
pub struct Worker {
    pub reader: StarReader,
    /// Vertices whose stars are read.
    pub to_read: Vec<Located<Slot>>,
    /// What to do with each star of the leaf.
    pub updates: Vec<StarUpdate>,
    pub stars: Stars,
    pub reduction: TileReduction,
    pub difference: Difference,
}
