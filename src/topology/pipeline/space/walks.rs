//! The cycles of tracks in a later frame, as closed walks whose classes are asked for.
//!
//! In: the cycles as they were, the space of the frame and the names of its vertices.
//! Out: short closed walks, and the answers for the tracker.
//! Invariant: a walk depends on positions alone, but for which vertices of the cycle stay.
//! Must not know: how classes are found, tracks.
//!
//! Some vertices of a cycle are gone in a later frame. One is skipped if both of its neighbours stay and are joined at
//! the length that is asked for: then the triangle of the three was filled. Any other becomes the vertex that is
//! nearest to where it was. So a cycle is found again also if all points have moved a little.
//!
//! A cycle is not only found, but made shorter, within its class: see [`Shortening`]. Where a shorter one is the sum of
//! it and of the cycle of a dot that dies earlier, that is taken: it is of the same dot. So two holes that were one get
//! each its own cycle.

use std::collections::HashMap;

use super::shortening::Shortening;
use crate::topology::cloud::{VertexId, Vertices};
use crate::topology::metric::rips::ClosedWalk;
use crate::topology::metric::space::{Distances, Points};
use crate::topology::skeleton::EdgeId;
use crate::topology::tracks::{TrackWalk, WalkAnswer};

/// What dies before this share of the time of another one does so in the next frame too.
const CLEARLY_EARLIER: f64 = 0.9;

/// The steps of cycles as a share of the length at which they are asked for.
const STEP: f64 = 0.7;

/// How often each vertex of a cycle is moved.
const MOVES: usize = 4;

/// How often each vertex of a sum of two cycles is moved.
const MOVES_OF_SUM: usize = 16;

/// A cycle of so few vertices is short: most of those in noise.
const SHORT: usize = 6;

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

    /// Cycles in the space, made shorter. `turn` says which sum of two of them is tried.
    pub fn walks(&mut self, tracks: &[TrackWalk], turn: u64) -> Vec<ClosedWalk> {
        let mut walks: Vec<ClosedWalk> = tracks.iter().map(|track| self.walk(track)).collect();
        let mut shortening = Shortening::new(self.points);
        if let Some((whole, sums)) = self.sums(tracks, &walks, turn) {
            // With long steps few moves lead far.
            let mut least = walks[whole].clone();
            let step = least.length;
            shortening.shorten(&mut least, step, MOVES_OF_SUM);
            for mut sum in sums {
                shortening.shorten(&mut sum, step, MOVES_OF_SUM);
                if shortening.extent(&sum) < shortening.extent(&least) {
                    least = sum;
                    walks[whole].clone_from(&least);
                }
            }
        }
        for (walk, track) in walks.iter_mut().zip(tracks) {
            let step = self.step(track);
            shortening.divide(walk, step);
            if is_long(walk) {
                shortening.shorten(walk, walk.length, MOVES);
                shortening.divide(walk, step);
                shortening.shorten(walk, step, 1);
            }
            walk.length = walk.length.max(shortening.longest_step(walk));
        }
        walks
    }

    /// The sums of one track's cycle and one of a dot that dies earlier, and the place of that track.
    fn sums(&self, tracks: &[TrackWalk], walks: &[ClosedWalk], turn: u64) -> Option<(usize, Vec<ClosedWalk>)> {
        let pairs = (0..tracks.len()).flat_map(|whole| (0..tracks.len()).map(move |part| (whole, part)));
        let possible: Vec<(usize, usize)> =
            pairs.filter(|&(whole, part)| is_part(&tracks[part], &tracks[whole]) && is_long(&walks[part])).collect();
        let &(whole, part) = possible.get((turn % possible.len().max(1) as u64) as usize)?;
        Some((whole, sums(self.points, &walks[whole], &walks[part])))
    }

    /// The scale at which a cycle is asked for: the geometric mean of birth and death. A death beyond the filtration is
    /// its end.
    fn scale(&self, track: &TrackWalk) -> f64 {
        let death = track.death.min(self.threshold.unwrap_or(f64::INFINITY)).max(track.birth);
        track.birth.sqrt() * death.sqrt()
    }

    /// The length of steps that cycles are made of: so much less than they may have that in the next frame they have it
    /// still.
    fn step(&self, track: &TrackWalk) -> f64 {
        self.points.longest(track.birth.max(STEP * self.scale(track)))
    }

    /// A cycle in the space, at its scale.
    fn walk(&mut self, track: &TrackWalk) -> ClosedWalk {
        let length = self.points.longest(self.scale(track));
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

fn is_long(walk: &ClosedWalk) -> bool {
    walk.vertices.len() > SHORT
}

/// Whether the cycle of a track may be added to that of another one. The sum dies with the other one's dot still.
fn is_part(part: &TrackWalk, whole: &TrackWalk) -> bool {
    part.is_own && whole.is_own && part.death <= CLEARLY_EARLIER * whole.death
}

/// The sum of two cycles as one closed walk, in both directions; none if they are not joined at the length of the first
/// one: around the first, along an edge to the second, around that, and back along the same edge.
fn sums(points: &Points, own: &ClosedWalk, part: &ClosedWalk) -> Vec<ClosedWalk> {
    let pairs = (0..own.vertices.len()).flat_map(|at| (0..part.vertices.len()).map(move |to| (at, to)));
    let apart = |&(at, to): &(usize, usize)| points.length(own.vertices[at], part.vertices[to]);
    let nearest = pairs.map(|pair| (apart(&pair), pair)).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let Some((_, (at, to))) = nearest.filter(|&(apart, _)| apart <= own.length) else { return Vec::new() };
    let mut around: Vec<u32> = [&part.vertices[to..], &part.vertices[..=to]].concat();
    let sum = |around: &[u32]| {
        let vertices = [&own.vertices[..=at], around, &own.vertices[at..]].concat();
        ClosedWalk { vertices, length: own.length }
    };
    let forwards = sum(&around);
    around.reverse();
    vec![forwards, sum(&around)]
}

/// Answers in the names of a space, from walks and their classes.
pub fn answers(names: &Vertices, walks: Vec<ClosedWalk>, classes: Vec<Option<Vec<EdgeId>>>) -> Vec<WalkAnswer> {
    let answer = |(walk, dots): (ClosedWalk, _)| {
        let vertices = walk.vertices.into_iter().map(|vertex| names.id(vertex)).collect();
        WalkAnswer { vertices, dots }
    };
    walks.into_iter().zip(classes).map(answer).collect()
}
