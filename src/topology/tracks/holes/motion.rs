//! The motion that the holes of a picture have in common, as when a camera pans, turns or shakes.
//!
//! In: where tracks were seen last, and the detections of a frame.
//! Out: a [`Motion`]: a shift, a turn and a change of scale that together explain the frame best.
//! Invariant: it depends on positions alone. It is the identity unless that explains much less: by places, or by
//! regions that contain the new centres.
//! Must not know: which detection continues which track.

use super::detection::Detection;
use super::hole_region::HoleRegion;
use super::last_seen::{LastSeen, NEAR, distance, remoteness};
use crate::topology::skeleton::Hole;

/// So many of the most persistent tracks are moved to try a motion.
const MOST_TRIED: usize = 64;

/// So many of them say how they may have moved.
const MOST_VOTERS: usize = 8;

/// So many ways each of them may have moved, the nearest ones.
const MOST_VOTES: usize = 16;

/// The largest distance that a hole moves in a frame, in radii.
const REACH: f64 = 4.0;

/// The least ratio of the radii and of the persistences of one hole in two frames, where a motion is tried.
const ALIKE: f64 = 0.6;

/// The identity stays, if it explains this share of what a motion can explain.
const ENOUGH: f64 = 0.7;

/// The least share of what could be explained that a motion has to explain.
const LEAST: f64 = 0.5;

/// How often a motion is fitted to what it explains.
const FITS: usize = 3;

/// So many tracks have to agree on a shift, and so many on a turn or a change of scale.
const AGREE_ON_SHIFT: usize = 2;
const AGREE_ON_TURN: usize = 4;

/// The most that a camera turns in a frame, in radians, or changes the scale by, as a share.
const MOST_TURN: f64 = 0.3;

/// A similarity of the plane: `point` goes to `turn * point + shift`, as complex numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    turn: [f64; 2],
    shift: [f64; 2],
}

impl Motion {
    /// No motion.
    pub const IDENTITY: Self = Self { turn: [1.0, 0.0], shift: [0.0; 2] };

    /// Where a point is after it.
    pub fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let ([c, s], [dx, dy]) = (self.turn, self.shift);
        [c * x - s * y + dx, s * x + c * y + dy]
    }

    /// Where a point was before it.
    pub fn undo(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let ([c, s], [dx, dy]) = (self.turn, self.shift);
        let ([x, y], size) = ([x - dx, y - dy], c * c + s * s);
        [(c * x + s * y) / size, (c * y - s * x) / size]
    }

    /// The similarity that leads from some points to others with the least sum of weighted squares. A shift, if the
    /// points are few, or if the similarity is none that a camera makes in a frame.
    fn fit(pairs: &[Explained]) -> Self {
        let total: f64 = pairs.iter().map(|pair| pair.weight).sum();
        let mean = |side: fn(&Explained) -> [f64; 2]| {
            [0, 1].map(|axis| pairs.iter().map(|pair| pair.weight * side(pair)[axis]).sum::<f64>() / total)
        };
        let [from, to] = [mean(|pair| pair.from), mean(|pair| pair.to)];
        let (mut along, mut across, mut size) = (0.0, 0.0, 0.0);
        for pair in pairs {
            let ([ax, ay], [bx, by]) = ([0, 1].map(|i| pair.from[i] - from[i]), [0, 1].map(|i| pair.to[i] - to[i]));
            along += pair.weight * (ax * bx + ay * by);
            across += pair.weight * (ax * by - ay * bx);
            size += pair.weight * (ax * ax + ay * ay);
        }
        let turn = [along / size, across / size];
        let is_turn = pairs.len() >= AGREE_ON_TURN && (turn[0] - 1.0).hypot(turn[1]) <= MOST_TURN;
        let turn = if is_turn { turn } else { Self::IDENTITY.turn };
        let unshifted = Self { turn, shift: [0.0; 2] }.apply(from);
        Self { turn, shift: [to[0] - unshifted[0], to[1] - unshifted[1]] }
    }
}

/// A track that a motion leads to a detection.
#[derive(Clone, Copy, Debug)]
struct Explained {
    from: [f64; 2],
    to: [f64; 2],
    /// How well, and how much it matters.
    weight: f64,
}

/// The motion from the last centres of tracks to those of detections.
pub fn common_motion<R: HoleRegion>(known: &[LastSeen<'_, R>], detections: &[Detection]) -> Motion {
    let mut tried: Vec<&LastSeen<'_, R>> = known.iter().filter(|known| !known.is_remembered).collect();
    tried.sort_by(|a, b| b.persistence.total_cmp(&a.persistence).then_with(|| by_place(a, b)));
    tried.truncate(MOST_TRIED);
    let trial = Trial::new(&tried, detections);
    let possible: f64 = tried.iter().map(|known| known.persistence).sum();
    let at_rest = trial.at_rest();
    if tried.len() < AGREE_ON_SHIFT || at_rest >= ENOUGH * possible {
        return Motion::IDENTITY;
    }
    let (mut best, mut most) = (Motion::IDENTITY, Vec::new());
    for shift in trial.votes() {
        let mut motion = Motion { shift, ..Motion::IDENTITY };
        let mut explained = trial.explained(motion);
        for _ in 0..FITS {
            let next = Motion::fit(&explained);
            let again = trial.explained(next);
            if weight(&again) <= weight(&explained) {
                break;
            }
            (motion, explained) = (next, again);
        }
        if explained.len() >= AGREE_ON_SHIFT && weight(&explained) > weight(&most) {
            (best, most) = (motion, explained);
        }
    }
    let is_better = weight(&most) >= LEAST * possible && at_rest < ENOUGH * weight(&most);
    if is_better { best } else { Motion::IDENTITY }
}

fn weight(explained: &[Explained]) -> f64 {
    explained.iter().map(|pair| pair.weight).sum()
}

fn by_place<R>(a: &LastSeen<'_, R>, b: &LastSeen<'_, R>) -> std::cmp::Ordering {
    let key = |known: &LastSeen<'_, R>| [known.hole.center[0], known.hole.center[1], known.hole.radius];
    let (a, b) = (key(a), key(b));
    a.iter().zip(&b).map(|(x, y)| x.total_cmp(y)).find(|order| order.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
}

/// Tracks that are moved to try motions, and the detections, by the x of their centres.
struct Trial<'a, R> {
    tried: &'a [&'a LastSeen<'a, R>],
    by_x: Vec<&'a Detection>,
}

impl<'a, R: HoleRegion> Trial<'a, R> {
    fn new(tried: &'a [&'a LastSeen<'a, R>], detections: &'a [Detection]) -> Self {
        let mut by_x: Vec<&Detection> = detections.iter().collect();
        by_x.sort_by(|a, b| a.hole.center[0].total_cmp(&b.hole.center[0]));
        Self { tried, by_x }
    }

    /// The detections like a track whose centres are at most so far from a point.
    fn near(
        &self,
        known: &'a LastSeen<'a, R>,
        point: [f64; 2],
        reach: f64,
    ) -> impl Iterator<Item = &'a Detection> + '_ {
        let first = self.by_x.partition_point(|detection| detection.hole.center[0] < point[0] - reach);
        let near = self.by_x[first..].iter().take_while(move |found| found.hole.center[0] <= point[0] + reach);
        near.copied().filter(move |detection| {
            known.is_much_alike(detection, ALIKE) && distance(point, detection.hole.center) <= reach
        })
    }

    /// How much is explained without a motion.
    fn at_rest(&self) -> f64 {
        let by_place = self.explained(Motion::IDENTITY);
        let is_explained = |known: &LastSeen<'_, R>| by_place.iter().any(|pair| pair.from == known.hole.center);
        let others = self.tried.iter().filter(|known| !is_explained(known));
        let is_held = |known: &&&LastSeen<'_, R>| {
            let holds = |found: &&&Detection| known.is_much_alike(found, ALIKE) && known.holds(found.hole.center);
            self.by_x.iter().any(|found| holds(&found))
        };
        weight(&by_place) + others.filter(is_held).map(|known| known.persistence).sum::<f64>()
    }

    /// How the most persistent tracks may have moved.
    fn votes(&self) -> Vec<[f64; 2]> {
        let voters = self.tried.iter().take(MOST_VOTERS);
        let shifts = voters.flat_map(|known| {
            let Hole { center, radius } = known.hole;
            let to = self.near(known, center, REACH * radius).map(|detection| detection.hole.center);
            let mut shifts: Vec<[f64; 2]> = to.map(|to| [to[0] - center[0], to[1] - center[1]]).collect();
            shifts.sort_by(|a, b| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1])));
            shifts.truncate(MOST_VOTES);
            shifts
        });
        shifts.collect()
    }

    /// The tracks that a motion leads to detections, each with the nearest one.
    fn explained(&self, motion: Motion) -> Vec<Explained> {
        let explained = self.tried.iter().filter_map(|known| {
            let Hole { center: from, radius } = known.hole;
            let moved = Hole { center: motion.apply(from), radius };
            let near = self.near(known, moved.center, NEAR * radius / ALIKE);
            let remote = near.map(|detection| (remoteness(moved, detection.hole), detection));
            let (remote, detection) = remote.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|&(remote, _)| remote <= 1.0)?;
            Some(Explained { from, to: detection.hole.center, weight: known.gain(detection, remote) })
        });
        explained.collect()
    }
}
