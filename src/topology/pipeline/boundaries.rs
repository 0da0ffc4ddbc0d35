//! The boundaries of the holes of a frame's dots, by places in its skeleton.
//!
//! In: dots of the newest frame that was given.
//! Out: closed walks.
//! Invariant: dots of another frame have none.
//! Must not know: tracks.

use std::collections::HashMap;
use std::sync::Arc;

use super::Pipeline;
use crate::topology::cloud::{Located, Slot, VertexId};
use crate::topology::frames::Frame;
use crate::topology::plane::holes::boundary;
use crate::topology::skeleton::{Dot, Killer};

impl Pipeline {
    /// The boundaries at birth of the holes of some dots of the newest frame that was given: closed walks along edges
    /// of the alpha complex at that scale.
    ///
    /// A walk is a list of places in [`Skeleton::vertices`](crate::topology::Skeleton::vertices), without its first
    /// vertex at the end. The first walk is the outer one and runs counter-clockwise; the others run clockwise around
    /// islands in the hole. A walk begins at its smallest vertex by position. It passes a vertex more than once where
    /// the boundary touches itself. Takes linear time once, then time in proportion to the holes. Dots of another frame
    /// have no walks.
    pub fn hole_boundaries(&self, dots: &[Dot]) -> Vec<Vec<Vec<u32>>> {
        let is_newest = |frame: &&Arc<Frame>| frame.number == self.progress.reached && self.progress.is_reached();
        let Some(frame) = self.progress.given().filter(is_newest) else {
            return vec![Vec::new(); dots.len()];
        };
        let slots: HashMap<VertexId, Slot> = self.cloud.vertices().map(|(slot, vertex)| (vertex.id, slot)).collect();
        let vertices = frame.skeleton.vertices();
        let mut rank = vec![0; self.cloud.slot_count()];
        for (id, place) in vertices.ids().iter().zip(0..) {
            rank[slots[id] as usize] = place;
        }
        let site = |place: u32| {
            let slot = slots[vertices.ids().get(place as usize)?];
            Some((self.cloud.position(slot), slot))
        };
        let walks = |dot: &Dot| {
            let Killer::Triangle(triangle) = dot.killer else { return None };
            let [Some(a), Some(b), Some(c)] = triangle.map(site) else { return None };
            let [Some(from), Some(to)] = dot.edge.map(site) else { return None };
            boundary(&self.delaunay, [a, b, c], [from.0, to.0])
        };
        let ranks = |walk: Vec<Located<Slot>>| walk.into_iter().map(|(_, slot)| rank[slot as usize]).collect();
        dots.iter().map(|dot| walks(dot).unwrap_or_default().into_iter().map(ranks).collect()).collect()
    }
}
