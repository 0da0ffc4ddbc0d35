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
use super::similarity::Motion;
use crate::topology::skeleton::Hole;

/// So many of the most persistent tracks are moved to try a motion.
const MOST_TRIED: usize = 64;

/// So many of them say how they may have moved.
const MOST_VOTERS: usize = 6;

/// So many ways each of them may have moved, the nearest ones.
const MOST_VOTES: usize = 8;

/// So many tracks that a motion leads to no detection are looked for by their regions.
const MOST_BY_REGION: usize = 8;

/// The largest distance that a hole moves in a frame, in radii.
const REACH: f64 = 4.0;

/// The least ratio of the radii and of the persistences of one hole in two frames, where a motion is tried.
const ALIKE: f64 = 0.6;

/// What a region that contains the centre is worth, where a hole in its place is worth 1.
const HELD: f64 = 0.5;

/// No motion is tried if the identity explains this share of what can be explained.
const ENOUGH: f64 = 0.9;

/// The identity stays, if it explains this share of what a motion explains.
const AS_GOOD: f64 = 0.8;

/// The least share of what could be explained that a motion has to explain.
const LEAST: f64 = 0.5;

/// How often a motion is fitted to what it explains.
const FITS: usize = 3;

/// So many tracks have to agree on a shift, and so many on a turn or a change of scale.
const AGREE_ON_SHIFT: usize = 2;
const AGREE_ON_TURN: usize = 4;

/// So many tracks have to agree on a small motion, which has to leave no more than this share of their distances.
const AGREE_ON_SLOW: usize = 3;
const NEARER: f64 = 0.5;

/// The most that a camera turns in a frame, in radians, or changes the scale by, as a share.
const MOST_TURN: f64 = 0.3;

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
    let at_rest = trial.score(Motion::IDENTITY);
    if tried.len() < AGREE_ON_SHIFT || at_rest >= ENOUGH * possible {
        return trial.slow_motion();
    }
    let (mut best, mut most) = (Motion::IDENTITY, 0.0);
    for shift in trial.votes() {
        let (motion, score) = trial.fitted(Motion { shift, ..Motion::IDENTITY });
        if score > most {
            (best, most) = (motion, score);
        }
    }
    let is_better = most >= LEAST * possible && at_rest < AS_GOOD * most;
    if is_better { best } else { trial.slow_motion() }
}

/// The similarity that leads from some points to others with the least sum of weighted squares. A shift, if the
/// points are few, or if the similarity is none that a camera makes in a frame.
fn fit(pairs: &[Explained]) -> Motion {
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
    let turn = if is_turn { turn } else { Motion::IDENTITY.turn };
    let unshifted = Motion { turn, shift: [0.0; 2] }.apply(from);
    Motion { turn, shift: [to[0] - unshifted[0], to[1] - unshifted[1]] }
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

    /// A motion, fitted to what it explains as long as it explains more, and how much it explains: nothing, if it is
    /// that of one track.
    fn fitted(&self, mut motion: Motion) -> (Motion, f64) {
        let mut explained = self.explained(motion);
        for _ in 0..FITS {
            let next = fit(&explained);
            let again = self.explained(next);
            if weight(&again) <= weight(&explained) {
                break;
            }
            (motion, explained) = (next, again);
        }
        let held = self.held(motion, &explained);
        let agree = explained.len() + held.len();
        let score = weight(&explained) + held.iter().sum::<f64>();
        (motion, if agree >= AGREE_ON_SHIFT { score } else { 0.0 })
    }

    /// A small motion, if it leads much nearer to all that the identity explains.
    fn slow_motion(&self) -> Motion {
        let at_rest = self.explained(Motion::IDENTITY);
        let motion = fit(&at_rest);
        let error = |motion: &Motion| -> f64 {
            let apart = |pair: &Explained| pair.weight * distance(motion.apply(pair.from), pair.to);
            at_rest.iter().map(apart).sum()
        };
        let is_common = at_rest.len() >= AGREE_ON_SLOW && error(&motion) <= NEARER * error(&Motion::IDENTITY);
        if is_common { motion } else { Motion::IDENTITY }
    }

    /// How much a motion explains.
    fn score(&self, motion: Motion) -> f64 {
        let explained = self.explained(motion);
        weight(&explained) + self.held(motion, &explained).iter().sum::<f64>()
    }

    /// What is explained of tracks whose regions a motion leads to where the centre of a detection is. Their centres
    /// may have jumped; tracks that are explained by these are left out.
    fn held(&self, motion: Motion, explained: &[Explained]) -> Vec<f64> {
        let is_explained = |known: &LastSeen<'_, R>| explained.iter().any(|pair| pair.from == known.hole.center);
        let others = self.tried.iter().filter(|known| !is_explained(known)).take(MOST_BY_REGION);
        // A centre may be anywhere in a region, so this proves less than a centre in its place.
        let is_held = |known: &&&LastSeen<'_, R>| {
            let center = |found: &Detection| motion.undo(found.hole.center);
            self.by_x.iter().any(|found| known.is_much_alike(found, ALIKE) && known.holds(center(found)))
        };
        others.filter(is_held).map(|known| HELD * known.persistence).collect()
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
