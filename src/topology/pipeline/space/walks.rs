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

use super::loops::{Loop, LoopSearch, loops};
use super::shortening::{Shortening, extent, longest_step};
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

/// A cycle of so few vertices is short.
const SHORT: usize = 6;

/// A cycle that dies before this many times its birth may be noise: it is not worth moving.
const LASTING: f64 = 2.0;

/// Another loop is taken if it is at most this share of the cycle.
const SHORTER: f64 = 0.97;

/// A circle is this many times as long as the diameter at which it is filled, and no cycle is less than 3 times as long
/// (Adamaszek and Adams 2017). One up to a fourth longer than the circle may be as short as it can be.
const OF_A_CIRCLE: f64 = 3.63;
const SHORTEST: f64 = 1.25 * OF_A_CIRCLE;

/// Loops are looked for up to this many times that diameter: a circle, and there and back.
const LONGEST: f64 = 2.2 * OF_A_CIRCLE;

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
        let mut asked = Asked::default();
        let mut extents = Vec::new();
        for track in tracks {
            let walk = self.walk(track);
            let (walk, extent) = self.shorten(walk, track);
            extents.push(extent);
            asked.walks.push(walk);
        }
        for (of, through) in searched(tracks, &asked.walks, &extents, turn) {
            let wanted = LoopSearch {
                step: self.step(&tracks[of]),
                apart: asked.walks[of].length,
                longest: (SHORTER * extents[of]).min(LONGEST * tracks[of].death),
            };
            let mut found: Vec<Loop> = through.iter().flat_map(|&vertex| loops(self.points, vertex, wanted)).collect();
            found.sort_by(|a, b| a.extent.total_cmp(&b.extent));
            asked.of.extend(found.iter().map(|_| of));
            let length = asked.walks[of].length;
            asked.walks.extend(found.into_iter().map(|Loop { vertices, .. }| ClosedWalk { vertices, length }));
        }
        asked
    }

    /// Makes a cycle shorter. Returns its extent too.
    fn shorten(&self, walk: ClosedWalk, track: &TrackWalk) -> (ClosedWalk, f64) {
        let step = self.step(track);
        let near = self.around(&walk);
        let points = self.points.subset(&near);
        let place = |vertex: &u32| near.partition_point(|other| other < vertex) as u32;
        let mut walk = ClosedWalk { vertices: walk.vertices.iter().map(place).collect(), ..walk };
        let mut shortening = Shortening::new(&points);
        shortening.divide(&mut walk, step);
        if is_worth_moving(&walk, track) {
            let length = walk.length;
            shortening.shorten(&mut walk, length, MOVES);
            shortening.divide(&mut walk, step);
            shortening.shorten(&mut walk, step, 1);
        }
        walk.length = walk.length.max(longest_step(&points, &walk));
        let extent = extent(&points, &walk);
        walk.vertices.iter_mut().for_each(|vertex| *vertex = near[*vertex as usize]);
        (walk, extent)
    }

    /// The vertices that a cycle may be moved to.
    fn around(&self, walk: &ClosedWalk) -> Vec<u32> {
        let Some(&first) = walk.vertices.first() else { return Vec::new() };
        let mut row = vec![0.0; self.points.count()];
        self.points.lengths(first, 0, &mut row);
        // No vertex of the cycle is farther away than half of it.
        let far = 0.5 * extent(self.points, walk) + self.points.radius(walk.length);
        let is_near =
            |&vertex: &u32| self.points.radius(row[vertex as usize]) <= far || walk.vertices.contains(&vertex);
        (0..row.len() as u32).filter(is_near).collect()
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

fn is_worth_moving(walk: &ClosedWalk, track: &TrackWalk) -> bool {
    walk.vertices.len() > SHORT && track.death >= LASTING * track.birth
}

/// The tracks whose cycles are compared with other loops, and the vertices that these go through. Those that are not
/// known to be their dots' own are searched thoroughly, and of the others one.
fn searched(tracks: &[TrackWalk], walks: &[ClosedWalk], extents: &[f64], turn: u64) -> Vec<(usize, Vec<u32>)> {
    let may_be_shorter = |&track: &usize| {
        is_worth_moving(&walks[track], &tracks[track]) && extents[track] > SHORTEST * tracks[track].death
    };
    let long = (0..tracks.len()).filter(may_be_shorter);
    let (own, new): (Vec<usize>, Vec<usize>) = long.partition(|&track| tracks[track].is_own);
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
    ((part * count as u64) >> 32) as usize
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_classes_die_with_the_same_dot_or_are_others() {
        let [large, like, small, endless] = [1, 2, 3, 4].map(|id| [VertexId(id), VertexId(id + 1)]);
        let deaths = HashMap::from([(large, 1.0), (like, 0.95), (small, 0.8), (endless, f64::INFINITY)]);
        let is_same = |own: &[EdgeId], other: &[EdgeId]| die_with_one_dot(own, other, &deaths);
        assert!(is_same(&[large, small], &[large]) && is_same(&[large], &[large, small]));
        assert!(is_same(&[endless], &[endless, large]));
        // What dies at nearly the same time may die last in the next frame.
        assert!(!is_same(&[large, like], &[large]) && !is_same(&[large], &[like]));
        assert!(!is_same(&[large], &[large, endless]) && !is_same(&[large, small], &[small]));
        assert!(!is_same(&[], &[small]) && is_same(&[], &[]));
        assert!(!is_same(&[endless], &[]));
    }

    #[test]
    fn turns_reach_all_vertices() {
        let mut reached: Vec<usize> = (0..40).map(|turn| spread(turn, 13)).collect();
        reached.sort_unstable();
        reached.dedup();
        assert_eq!(reached, (0..13).collect::<Vec<usize>>());
        assert_eq!(spread(u64::MAX, 1), 0);
    }

    #[test]
    fn new_cycles_are_searched_and_one_known_one_at_a_time() {
        let track = |is_own| TrackWalk { vertices: [].into(), birth: 1.0, death: 4.0, is_own };
        let tracks = [true, false, true, true].map(track);
        let walk = |first: u32, count: u32| ClosedWalk { vertices: (first..first + count).collect(), length: 1.0 };
        let walks = [walk(0, 9), walk(20, 9), walk(40, 9), walk(60, 6)];
        let of = |extents: &[f64; 4], turn| -> Vec<(usize, usize)> {
            searched(&tracks, &walks, extents, turn).iter().map(|(track, through)| (*track, through.len())).collect()
        };
        assert_eq!((of(&[20.0; 4], 0), of(&[20.0; 4], 1)), (vec![(1, 3), (0, 1)], vec![(1, 3), (2, 1)]));
        // No cycle that dies at 4 is much shorter than 18.
        assert_eq!(of(&[20.0, 18.0, 18.0, 20.0], 1), [(0, 1)]);
    }
}
