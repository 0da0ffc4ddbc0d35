//! The ground truth of a scene: its true holes, their ids, and their events.
//!
//! In: the holes of the ideal shape, frame by frame. Out: those with at least a given persistence, with lasting ids,
//! and events.
//!
//! Invariants: a hole is born or splits off once, exists in every frame from then on, and dies or is merged once. An id
//! is never used again. The larger hole of a pair keeps its id.
//!
//! Must not know: points, noise, how shapes move.

use super::shape::IdealHole;

/// A true hole in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueHole {
    /// The same as long as the hole exists.
    pub id: u64,
    /// Its centre.
    pub center: [f64; 2],
    /// The radius of its largest empty disc.
    pub radius: f64,
    /// The distance from the centre to the centres of its largest empty discs. It is 0 unless the hole is an annulus.
    pub orbit: f64,
    /// Half of the segment around the centre on which the centres of its largest empty discs lie, and of those that are
    /// at least 0.8 times as large. It is 0 unless the hole is slender.
    pub ridge: [f64; 2],
}

impl TrueHole {
    /// The distance of a position from the centres of its largest empty discs.
    pub fn distance(&self, [x, y]: [f64; 2]) -> f64 {
        let [along, across] = self.ridge;
        let squared = along * along + across * across;
        let (dx, dy) = (x - self.center[0], y - self.center[1]);
        // Where along the ridge the position is: -1 is one end, 1 is the other.
        let at = if squared > 0.0 { ((dx * along + dy * across) / squared).clamp(-1.0, 1.0) } else { 0.0 };
        let (dx, dy) = (dx - at * along, dy - at * across);
        ((dx * dx + dy * dy).sqrt() - self.orbit).abs()
    }
}

/// An event of a true hole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrueEvent {
    /// The hole begins.
    Born {
        /// The hole.
        id: u64,
        /// Its id before, if it never vanished since then, but was less persistent than a true hole.
        was: Option<u64>,
    },
    /// The hole begins and was a part of another hole.
    Split {
        /// The hole.
        id: u64,
        /// The other hole, which goes on.
        from: u64,
    },
    /// The hole ends and becomes a part of another hole.
    Merged {
        /// The hole.
        id: u64,
        /// The other hole, which goes on.
        into: u64,
    },
    /// The hole ends.
    Died {
        /// The hole.
        id: u64,
    },
}

/// A hole of an ideal shape, whatever space it is in.
pub trait Ideal {
    /// What is told of it while it is a true hole.
    type Hole;
    /// Death minus birth. 0 if the hole does not exist.
    fn persistence(&self) -> f64;
    /// How many places before this hole in the list its partner is: the hole that it splits off from, or merges into.
    fn partner(&self) -> Option<usize>;
    /// The true hole with this id.
    fn named(&self, id: u64) -> Self::Hole;
}

impl Ideal for IdealHole {
    type Hole = TrueHole;

    fn persistence(&self) -> f64 {
        self.persistence
    }

    fn partner(&self) -> Option<usize> {
        self.partner
    }

    fn named(&self, id: u64) -> TrueHole {
        TrueHole { id, center: self.center, radius: self.radius, orbit: self.orbit, ridge: self.ridge }
    }
}

/// Assigns lasting ids to holes.
#[derive(Clone, Debug)]
pub struct TruthTracker {
    above: f64,
    /// The id of each ideal hole that exists.
    ids: Vec<Option<u64>>,
    /// The last id of each ideal hole that died but has not vanished.
    faint: Vec<Option<u64>>,
    last: u64,
}

impl TruthTracker {
    /// Holes with at least the persistence `above` exist.
    pub fn new(above: f64) -> Self {
        Self { above, ids: Vec::new(), faint: Vec::new(), last: 0 }
    }

    /// The true holes of the next frame by id, and its events. Every frame has the same number of ideal holes.
    pub fn advance<I: Ideal>(&mut self, holes: &[I]) -> (Vec<I::Hole>, Vec<TrueEvent>) {
        self.ids.resize(holes.len(), None);
        self.faint.resize(holes.len(), None);
        let before = self.ids.clone();
        let mut events = Vec::new();
        for (slot, ideal) in holes.iter().enumerate() {
            let is_there = ideal.persistence() >= self.above;
            // The partner is before this hole in the list, so its id is known. A hole can only split from, or merge
            // into, one that exists before and after.
            let partner = ideal.partner().map(|back| slot - back);
            let partner = partner.and_then(|partner| before[partner].filter(|_| self.ids[partner] == before[partner]));
            match (before[slot], is_there) {
                (None, true) => {
                    self.last += 1;
                    let id = self.last;
                    self.ids[slot] = Some(id);
                    let was = self.faint[slot].take();
                    events.push(partner.map_or(TrueEvent::Born { id, was }, |from| TrueEvent::Split { id, from }));
                }
                (Some(id), false) => {
                    self.ids[slot] = None;
                    self.faint[slot] = Some(id);
                    events.push(partner.map_or(TrueEvent::Died { id }, |into| TrueEvent::Merged { id, into }));
                }
                _ => {}
            }
            if ideal.persistence() <= 0.0 {
                self.faint[slot] = None;
            }
        }
        let mut there: Vec<(u64, &I)> =
            self.ids.iter().zip(holes).filter_map(|(&id, ideal)| Some((id?, ideal))).collect();
        there.sort_unstable_by_key(|&(id, _)| id);
        (there.into_iter().map(|(id, ideal)| ideal.named(id)).collect(), events)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn events(frames: &[[f64; 2]]) -> Vec<Vec<TrueEvent>> {
        let mut truth = TruthTracker::new(0.5);
        let ideal = |persistence, partner| IdealHole {
            center: [0.0; 2],
            radius: 1.0,
            orbit: 0.0,
            ridge: [0.0; 2],
            persistence,
            partner,
        };
        let advance = |&[first, second]: &[f64; 2]| truth.advance(&[ideal(first, None), ideal(second, Some(1))]).1;
        frames.iter().map(advance).collect()
    }

    #[test]
    fn the_smaller_hole_of_a_pair_splits_off_and_is_merged() {
        use TrueEvent::*;
        let events = events(&[[1.0, 0.0], [1.0, 0.5], [1.0, 0.4], [1.0, 0.6], [0.0, 0.0]]);
        let split = |id| vec![Split { id, from: 1 }];
        let ended = vec![Died { id: 1 }, Died { id: 3 }];
        assert_eq!(
            events,
            [vec![Born { id: 1, was: None }], split(2), vec![Merged { id: 2, into: 1 }], split(3), ended]
        );
    }

    #[test]
    fn holes_that_begin_or_end_together_are_no_split_and_no_merge() {
        use TrueEvent::*;
        let events = events(&[[1.0, 1.0], [0.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
        let born = |id| Born { id, was: None };
        let both = vec![born(1), born(2)];
        assert_eq!(events, [both, vec![Died { id: 1 }], vec![born(3), Died { id: 2 }], vec![Died { id: 3 }]]);
    }

    #[test]
    fn a_hole_that_was_faint_tells_who_it_was() {
        use TrueEvent::*;
        let told = |faint: f64| events(&[[1.0, 0.0], [faint, 0.0], [0.1, 0.0], [1.0, 0.0]]).pop();
        assert_eq!(told(0.2), Some(vec![Born { id: 2, was: Some(1) }]));
        assert_eq!(told(0.0), Some(vec![Born { id: 2, was: None }]));
    }

    #[test]
    fn distances_to_an_annulus_are_measured_from_its_middle_circle() {
        let hole = TrueHole { id: 1, center: [1.0, 0.0], radius: 1.0, orbit: 2.0, ridge: [0.0; 2] };
        assert_eq!([[1.0, 0.0], [3.0, 0.0], [1.0, 5.0]].map(|place| hole.distance(place)), [2.0, 0.0, 3.0]);
    }

    #[test]
    fn distances_to_a_slender_hole_are_measured_from_its_ridge() {
        let hole = TrueHole { id: 1, center: [1.0, 0.0], radius: 1.0, orbit: 0.0, ridge: [0.0, 2.0] };
        let distances = [[1.0, 1.5], [1.0, -2.0], [4.0, 1.0], [1.0, 3.0]].map(|place| hole.distance(place));
        assert_eq!(distances, [0.0, 0.0, 3.0, 1.0]);
    }
}
