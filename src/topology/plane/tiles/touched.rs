//! What a change of the triangulation has touched, as the tiles want to know it.
//!
//! In: word of every vertex that comes or goes, and its surroundings. Out: vertices whose stars have to be read anew, and leaves of those that have come; in turn, where
//! the search for a new vertex best begins. Invariants: every vertex with a changed star is noted, and so is the owner of every
//! maximum with a changed circle, if its star has not changed. Must not know: reductions.

use super::star_reader::StarReader;
use super::tree::{NONE, TileId, Tiles};
use crate::topology::cloud::{Position, Slot};
use crate::topology::plane::cocircular::on_one_circle;
use crate::topology::plane::delaunay::{HalfEdge, HalfEdges, Watcher};

/// Notes which stars a change of the triangulation concerns.
#[derive(Clone, Debug, Default)]
pub struct Touched {
    reader: StarReader,
    around: Vec<Slot>,
    /// Vertices that have come, and the leaves that they are in.
    pub(super) homes: Vec<(Slot, TileId)>,
}

/// Watches a triangulation change, and knows where in the plane its vertices were.
#[derive(Debug)]
pub struct Guide<'a> {
    tiles: Option<&'a Tiles>,
    touched: &'a mut Touched,
    /// The leaf of the last position asked for.
    leaf: TileId,
}

impl<'a> Guide<'a> {
    /// Knows the tiles as of before, if there were any, and notes down what comes.
    pub fn new(tiles: Option<&'a Tiles>, touched: &'a mut Touched) -> Self {
        Self { tiles, touched, leaf: NONE }
    }
}

impl Watcher for Guide<'_> {
    fn has_come(&mut self, plane: HalfEdges<'_>, out: HalfEdge) -> usize {
        self.touched.note_new(plane, out)
    }

    fn will_go(&mut self, plane: HalfEdges<'_>, out: HalfEdge) -> usize {
        self.touched.note_going(plane, out)
    }

    fn has_new_neighbours(&mut self, slot: Slot) {
        self.touched.around.push(slot);
    }

    fn near(&mut self, position: Position, slot: Slot) -> Option<Slot> {
        let tiles = self.tiles?;
        let leaf = tiles.leaf_of(position);
        self.touched.homes.push((slot, leaf));
        // Positions come along a curve: in one leaf, the last one is as near as any.
        let is_new = std::mem::replace(&mut self.leaf, leaf) != leaf;
        if is_new { tiles.near(leaf, position) } else { None }
    }
}

impl Touched {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.around.clear();
        self.homes.clear();
        self.reader.concerned.clear();
    }

    /// Notes a vertex that has come. Gives the number of its neighbours.
    fn note_new(&mut self, plane: HalfEdges<'_>, out: HalfEdge) -> usize {
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

    /// Notes a vertex that is about to go. Gives the number of its neighbours.
    fn note_going(&mut self, plane: HalfEdges<'_>, out: HalfEdge) -> usize {
        let before = self.around.len();
        let (position, slot) = plane.origin(out);
        let mut edge = out;
        let mut at = plane.origin(plane.twin(edge));
        loop {
            self.around.push(at.1);
            let turned = plane.turn(edge);
            let next = plane.origin(plane.twin(turned));
            if !plane.is_outer(edge) {
                // A circle that the vertex shares with triangles that stay loses a site.
                let link = plane.next(edge);
                let far = plane.across(link);
                if far.is_some_and(|far| on_one_circle(at.0, next.0, position, far.0)) {
                    self.reader.concern(plane, plane.twin(link), slot);
                }
            }
            if turned == out {
                return self.around.len() - before;
            }
            (edge, at) = (turned, next);
        }
    }

    /// All slots noted, some more than once, some of vertices that are gone.
    pub(super) fn slots(&self) -> impl Iterator<Item = Slot> + '_ {
        self.around.iter().chain(&self.reader.concerned).copied()
    }
}
