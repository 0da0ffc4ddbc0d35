//! What one thread needs to work on tiles, in memory that is used again.
//!
//! In: nothing. Out: a [`Worker`]. Invariant: what a worker did before does not show. Must not know: the tree of tiles.

use super::difference::Difference;
use super::star::Stars;
use super::star_reader::StarReader;
use super::tile_reduction::TileReduction;
use crate::topology::cloud::{Located, Slot};

/// What becomes of a star in a round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It stays as it is.
    Stays,
    /// It is read anew.
    IsRead,
    /// Its vertex is gone.
    Goes,
}

/// Tools to work on tiles with, and what came of it.
#[derive(Clone, Debug, Default)]
pub struct Worker {
    pub reader: StarReader,
    /// Vertices whose stars are read.
    pub to_read: Vec<Located<Slot>>,
    /// Of each star that a leaf has: what becomes of it.
    pub fates: Vec<Fate>,
    pub stars: Stars,
    pub reduction: TileReduction,
    pub difference: Difference,
}
