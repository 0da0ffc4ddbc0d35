//! Which stars a change of the triangulation touches.
//!
//! In: every insertion and removal of a vertex, with its surroundings.
//! Out: vertices whose stars have to be read again, and the leaves of new vertices. In return, hints where the search
//! for a new vertex begins.
//! Invariants: every vertex with a changed star is noted. So is the owner of every maximum with a changed circle whose
//! own star is unchanged.
//! Must not know: reductions.

use super::tree::{NONE, TileId, Tiles};
use crate::topology::cloud::{Position, Slot};
use crate::topology::plane::cocircular::on_one_circle;
use crate::topology::plane::delaunay::{HalfEdge, HalfEdges, Observer};

/// The stars that a change touches.
#[derive(Clone, Debug, Default)]
pub struct Touched {
    around: Vec<Slot>,
    /// New vertices and their leaves.
    pub(super) leaves_of_new: Vec<(Slot, TileId)>,
}

/// Observes the triangulation, and gives it hints from the tiles before the change.
#[derive(Debug)]
pub struct TouchObserver<'a> {
    tiles: Option<&'a Tiles>,
    touched: &'a mut Touched,
    /// The leaf of the last position.
    leaf: TileId,
}

impl<'a> TouchObserver<'a> {
    /// With the tiles before the change, if there are any.
    pub fn new(tiles: Option<&'a Tiles>, touched: &'a mut Touched) -> Self {
        Self { tiles, touched, leaf: NONE }
    }
}

impl Observer for TouchObserver<'_> {
    fn on_inserted(&mut self, plane: HalfEdges<'_>, out: HalfEdge) -> usize {
        self.touched.note_inserted(plane, out)
    }

    fn before_removal(&mut self, plane: HalfEdges<'_>, out: HalfEdge) -> usize {
        self.touched.note_removal(plane, out)
    }

    fn on_new_neighbours(&mut self, slot: Slot) {
        self.touched.around.push(slot);
    }

    fn hint_for(&mut self, position: Position, slot: Slot) -> Option<Slot> {
        let tiles = self.tiles?;
        let leaf = tiles.leaf_of(position);
        self.touched.leaves_of_new.push((slot, leaf));
        // Positions come in order along a curve: inside one leaf, the last one inserted is the best hint.
        let is_new = std::mem::replace(&mut self.leaf, leaf) != leaf;
        if is_new { tiles.near(leaf, position) } else { None }
    }
}

impl Touched {
    /// Removes all notes.
    pub fn clear(&mut self) {
        self.around.clear();
        self.leaves_of_new.clear();
    }

    /// Notes a vertex that was inserted. Returns the number of its neighbours.
    fn note_inserted(&mut self, plane: HalfEdges<'_>, out: HalfEdge) -> usize {
        self.around.push(plane.origin(out).1);
        let before = self.around.len();
        let mut edge = out;
        loop {
            self.around.push(plane.origin(plane.twin(edge)).1);
            edge = plane.turn(edge);
            if edge == out {
                return self.around.len() - before;
            }
        }
    }

    /// Notes a vertex that is about to be removed. Returns the number of its neighbours.
    fn note_removal(&mut self, plane: HalfEdges<'_>, out: HalfEdge) -> usize {
        let (position, _) = plane.origin(out);
        let (mut edge, mut degree) = (out, 0);
        let mut at = plane.origin(plane.twin(edge));
        loop {
            self.around.push(at.1);
            degree += 1;
            let turned = plane.turn(edge);
            let next = plane.origin(plane.twin(turned));
            if !plane.is_outer(edge) {
                // A circle of the vertex and of triangles that stay loses a site. Its owner is found from the nearest
                // of these triangles, once all changes are done: whichever corner owns that is read again.
                let far = plane.across(plane.next(edge));
                self.around.extend(far.filter(|far| on_one_circle(at.0, next.0, position, far.0)).map(|far| far.1));
            }
            if turned == out {
                return degree;
            }
            (edge, at) = (turned, next);
        }
    }

    /// All noted slots; may repeat, and some may be of vertices that are gone.
    pub(super) fn slots(&self) -> impl Iterator<Item = Slot> + '_ {
        self.around.iter().copied()
    }
}
