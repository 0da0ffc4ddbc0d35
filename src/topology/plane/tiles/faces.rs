//! A hash table of triangles that belong to two leaves or more. It is cleared and filled for each tile.
//!
//! In: triangles by a key, each with a node.
//! Out: the node that another leaf's part of the triangle was added with.
//! Must not know: what nodes are.

use crate::topology::cloud::Slot;

/// The key of a triangle: its half-edge, with the triangle on the left, between its smallest and its middle corner.
pub type FaceKey = u64;

/// Triangles of which one end or both were added.
#[derive(Clone, Debug, Default)]
pub struct Faces {
    list: Vec<Face>,
    /// Places in the list plus one, by hash; 0 is empty.
    table: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Face {
    key: FaceKey,
    node: u32,
    is_met: bool,
}

impl Faces {
    /// Removes all triangles and makes room for `count`.
    pub fn make_room(&mut self, count: usize) {
        self.list.clear();
        self.table.clear();
        // More places than triangles, so that every search ends.
        self.table.resize((count + 1).next_power_of_two(), 0);
    }

    /// Adds one end of a triangle. Returns the node that the other end was added with; else `node`.
    #[inline]
    pub fn meet(&mut self, key: FaceKey, node: u32) -> u32 {
        let mask = self.table.len() - 1;
        let mut place = key.wrapping_mul(0x9E37_79B9_7F4A_7C15) as usize >> 32 & mask;
        loop {
            match self.table[place] {
                0 => {
                    self.list.push(Face { key, node, is_met: false });
                    self.table[place] = self.list.len() as u32;
                    return node;
                }
                index if self.list[index as usize - 1].key == key => {
                    let face = &mut self.list[index as usize - 1];
                    face.is_met = true;
                    return face.node;
                }
                _ => place = (place + 1) & mask,
            }
        }
    }

    /// Triangles of which only one end was added.
    pub fn unmet(&self) -> impl Iterator<Item = (FaceKey, u32)> + '_ {
        self.list.iter().filter(|face| !face.is_met).map(|face| (face.key, face.node))
    }
}

/// The key of the triangle on the left of a half-edge.
#[inline]
pub fn face_key(from: Slot, to: Slot) -> FaceKey {
    u64::from(from) << 32 | u64::from(to)
}
