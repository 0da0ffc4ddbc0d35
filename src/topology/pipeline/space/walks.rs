//! The cycles of tracks in a later frame, as closed walks whose classes are asked for.
//!
//! In: the cycles as they were, the space of the frame and the names of its vertices.
//! Out: closed walks, and the answers for the tracker.
//! Invariant: a walk depends on positions alone, but for which vertices of the cycle stay.
//! Must not know: how classes are found, tracks.
//!
//! Some vertices of a cycle are gone in a later frame. One is skipped if both of its neighbours stay and are joined at
//! the length that is asked for: then the triangle of the three was filled. Any other becomes the vertex that is
//! nearest to where it was. So a cycle is found again also if all points have moved a little.

use std::collections::HashMap;

use crate::topology::cloud::{VertexId, Vertices};
use crate::topology::metric::rips::ClosedWalk;
use crate::topology::metric::space::{Distances, Points};
use crate::topology::skeleton::EdgeId;
use crate::topology::tracks::{TrackWalk, WalkAnswer};

/// Finds cycles in the space of a frame.
pub struct WalkFinder<'a> {
    points: &'a Points,
    /// The vertices of the space, by id, each with its place in it.
    places: &'a [(VertexId, u32)],
    threshold: Option<f64>,
    /// The vertices that are nearest to those that are gone.
    nearest: HashMap<VertexId, Option<u32>>,
}

impl<'a> WalkFinder<'a> {
    /// Finds cycles in a space whose filtration ends at the scale `threshold`.
    pub fn new(points: &'a Points, places: &'a [(VertexId, u32)], threshold: Option<f64>) -> Self {
        Self { points, places, threshold, nearest: HashMap::new() }
    }

    /// A cycle in the space, at the geometric mean of birth and death. A death beyond the filtration is its end.
    pub fn walk(&mut self, track: &TrackWalk) -> ClosedWalk {
        let death = track.death.min(self.threshold.unwrap_or(f64::INFINITY)).max(track.birth);
        let length = self.points.longest(track.birth.sqrt() * death.sqrt());
        let stays: Vec<Option<u32>> = track.vertices.iter().map(|(id, _)| self.place(*id)).collect();
        let count = stays.len();
        let mut vertices: Vec<u32> = Vec::with_capacity(count);
        for at in 0..count {
            let neighbours = [(at + count - 1) % count, (at + 1) % count].map(|next| stays[next]);
            let vertex = match (stays[at], neighbours) {
                (None, [Some(a), Some(b)]) if self.points.length(a, b) <= length => None,
                (None, _) => self.nearest(track, at),
                (stays, _) => stays,
            };
            vertices.extend(vertex.filter(|vertex| vertices.last() != Some(vertex)));
        }
        ClosedWalk { vertices, length }
    }

    fn place(&self, id: VertexId) -> Option<u32> {
        Some(self.places[self.places.binary_search_by_key(&id, |&(id, _)| id).ok()?].1)
    }

    fn nearest(&mut self, track: &TrackWalk, at: usize) -> Option<u32> {
        let (id, coordinates) = &track.vertices[at];
        let points = self.points;
        // A point that was in the stream has distances.
        *self.nearest.entry(*id).or_insert_with(|| points.nearest(coordinates.as_slice()).ok().flatten())
    }
}

/// Answers in the names of a space, from walks and their classes.
pub fn answers(names: &Vertices, walks: Vec<ClosedWalk>, classes: Vec<Option<Vec<EdgeId>>>) -> Vec<WalkAnswer> {
    let answer = |(walk, dots): (ClosedWalk, _)| {
        let vertices = walk.vertices.into_iter().map(|vertex| names.id(vertex)).collect();
        WalkAnswer { vertices, dots }
    };
    walks.into_iter().zip(classes).map(answer).collect()
}
