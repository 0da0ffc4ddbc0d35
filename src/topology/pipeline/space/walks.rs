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
//! A cycle is not only found, but made shorter: within its class by [`Shortening`], and by other loops through one of
//! its vertices ([`loops`]) that are shorter and die with the same dot. So two holes that were one get each its own
//! cycle, and a cycle that winds around two holes becomes one around the hole that lives longer.

use std::collections::HashMap;

use super::loops::{LoopSearch, loops};
use super::shortening::Shortening;
use crate::topology::cloud::{VertexId, Vertices};
use crate::topology::metric::rips::ClosedWalk;
use crate::topology::metric::space::{Distances, Points};
use crate::topology::skeleton::{EdgeId, Skeleton};
use crate::topology::tracks::{TrackWalk, WalkAnswer};

/// What dies before this share of the time of another one does so in the next frame too.
const CLEARLY_EARLIER: f64 = 0.9;

/// The steps of cycles as a share of the length at which they are asked for.
const STEP: f64 = 0.7;

/// How often each vertex of a cycle is moved.
const MOVES: usize = 4;

/// A cycle of so few vertices is short: most of those in noise.
const SHORT: usize = 6;

/// Another loop is taken if it is at most this share of the cycle.
const SHORTER: f64 = 0.97;

/// Through so many vertices of a new cycle other loops are looked for.
const PLACES: usize = 3;

/// What is asked of a frame: the classes of some walks.
#[derive(Debug, Default)]
pub struct Asked {
    /// The cycles of the tracks, then the loops.
    pub walks: Vec<ClosedWalk>,
    /// The tracks whose cycles the loops may be instead, each with its loops from the shortest on.
    of: Vec<usize>,
}

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

    /// Cycles in the space, made shorter, and other loops for those of them that are new, and for one more: `turn` says
    /// which one, and through which of its vertices.
    pub fn ask(&mut self, tracks: &[TrackWalk], turn: u64) -> Asked {
        let mut shortening = Shortening::new(self.points);
        let mut asked = Asked { walks: tracks.iter().map(|track| self.walk(track)).collect(), of: Vec::new() };
        let cycles = asked.walks.iter_mut().zip(tracks);
        cycles.for_each(|(walk, track)| self.shorten(&mut shortening, walk, track));
        for (of, through) in searched(tracks, &asked.walks, turn) {
            let mut found = self.loops(&mut shortening, &asked.walks[of], &through, &tracks[of]);
            asked.of.extend(found.iter().map(|_| of));
            asked.walks.append(&mut found);
        }
        asked
    }

    fn shorten(&self, shortening: &mut Shortening<'_>, walk: &mut ClosedWalk, track: &TrackWalk) {
        let step = self.step(track);
        shortening.divide(walk, step);
        if is_long(walk) {
            shortening.shorten(walk, walk.length, MOVES);
            shortening.divide(walk, step);
            shortening.shorten(walk, step, 1);
        }
        walk.length = walk.length.max(shortening.longest_step(walk));
    }

    /// Loops through some vertices of a track's cycle that are shorter than that, the shortest first.
    fn loops(
        &self,
        shortening: &mut Shortening<'_>,
        cycle: &ClosedWalk,
        through: &[u32],
        track: &TrackWalk,
    ) -> Vec<ClosedWalk> {
        let longest = SHORTER * shortening.extent(cycle);
        let wanted = LoopSearch { step: self.step(track), apart: cycle.length, longest };
        let mut found = Vec::new();
        for vertices in through.iter().flat_map(|&vertex| loops(self.points, vertex, wanted)) {
            let mut walk = ClosedWalk { vertices, length: cycle.length };
            self.shorten(shortening, &mut walk, track);
            // Else it is filled.
            if walk.vertices.len() > 3 {
                found.push((shortening.extent(&walk), walk));
            }
        }
        found.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        found.into_iter().map(|(_, walk)| walk).collect()
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

/// The tracks whose cycles are compared with other loops, and the vertices that these go through. Those that are not
/// known to be their dots' own are searched thoroughly, and of the others one.
fn searched(tracks: &[TrackWalk], walks: &[ClosedWalk], turn: u64) -> Vec<(usize, Vec<u32>)> {
    let long: Vec<usize> = (0..tracks.len()).filter(|&track| is_long(&walks[track])).collect();
    let (own, new): (Vec<usize>, Vec<usize>) = long.into_iter().partition(|&track| tracks[track].is_own);
    let one = own.get((turn % own.len().max(1) as u64) as usize);
    let through = |track: usize, places: usize| {
        let vertices = &walks[track].vertices;
        let first = spread(turn, vertices.len());
        let vertex = |number| vertices[(first + number * vertices.len() / places) % vertices.len()];
        (track, (0..places).map(vertex).collect())
    };
    new.into_iter().map(|track| through(track, PLACES)).chain(one.map(|&track| through(track, 1))).collect()
}

/// A number less than `count`. Those of successive turns are spread (Fibonacci hashing).
fn spread(turn: u64, count: usize) -> usize {
    let part = turn.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
    (part * count as u64 >> 32) as usize
}

/// Answers in the names of a space, from what was asked and the classes of that.
pub fn answers(
    names: &Vertices,
    asked: Asked,
    mut classes: Vec<Option<Vec<EdgeId>>>,
    skeleton: &Skeleton,
) -> Vec<WalkAnswer> {
    let Asked { mut walks, of } = asked;
    let loops = walks.split_off(walks.len() - of.len());
    let of_loops = classes.split_off(walks.len());
    let deaths: HashMap<EdgeId, f64> = match of[..] {
        [] => HashMap::new(),
        _ => skeleton.unsorted_dots().iter().map(|dot| (skeleton.edge_id(dot.edge), dot.death)).collect(),
    };
    // The shortest loop comes last, and stays.
    for ((track, walk), class) in of.into_iter().zip(loops).zip(of_loops).rev() {
        if let (Some(own), Some(other)) = (&classes[track], &class)
            && die_with_one_dot(own, other, &deaths)
        {
            walks[track] = walk;
            classes[track] = class;
        }
    }
    let answer = |(walk, dots): (ClosedWalk, _)| {
        let vertices = walk.vertices.into_iter().map(|vertex| names.id(vertex)).collect();
        WalkAnswer { vertices, dots }
    };
    walks.into_iter().zip(classes).map(answer).collect()
}

/// Whether another class differs from one by dots alone that die clearly earlier than that.
fn die_with_one_dot(own: &[EdgeId], other: &[EdgeId], deaths: &HashMap<EdgeId, f64>) -> bool {
    // What is no dot dies as it is born.
    let death = |dot: &EdgeId| deaths.get(dot).copied().unwrap_or(0.0);
    let last = CLEARLY_EARLIER * own.iter().map(death).fold(0.0, f64::max);
    let differs = own.iter().filter(|dot| !other.contains(dot)).chain(other.iter().filter(|dot| !own.contains(dot)));
    differs.map(death).all(|death| death <= last && death.is_finite())
}
