//! The relative-neighbourhood edges so far: what each of them is.
//!
//! In: edges with an empty lune, in order.
//! Out: whether one is in the tree, or which birth it is.
//! Must not know: lengths.

use std::hash::{BuildHasherDefault, Hasher};

use hashbrown::HashMap;

/// What a relative-neighbourhood edge is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Neighbour {
    /// An edge of the minimum spanning tree.
    Tree,
    /// The birth of this number.
    Birth(u32),
}

/// Relative-neighbourhood edges by their ends.
#[derive(Clone, Debug, Default)]
pub struct Neighbours(HashMap<u64, Neighbour, BuildHasherDefault<Ends>>);

impl Neighbours {
    /// Adds an edge.
    pub fn insert(&mut self, a: u32, b: u32, what: Neighbour) {
        self.0.insert(key(a, b), what);
    }

    /// What an edge is; none if its lune is not empty.
    pub fn get(&self, a: u32, b: u32) -> Option<Neighbour> {
        self.0.get(&key(a, b)).copied()
    }
}

fn key(a: u32, b: u32) -> u64 {
    u64::from(a.min(b)) << 32 | u64::from(a.max(b))
}

/// Hashes a pair of vertices: a product, whose high bits depend on all others. Nobody chooses vertices to collide.
#[derive(Clone, Copy, Debug, Default)]
struct Ends(u64);

impl Hasher for Ends {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u64(self.0 ^ u64::from(byte));
        }
    }

    fn write_u64(&mut self, ends: u64) {
        let product = ends.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 = product ^ product >> 32;
    }
}
