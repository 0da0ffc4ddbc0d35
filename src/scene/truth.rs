//! The truth of a scene: which holes there are, under which ids, and what happens to them.
//!
//! In: the holes of the ideal shape, frame by frame. Out: those of persistence at least a threshold, with ids that
//! last, and events. Invariants: a hole is born or splits off once, then is there in every frame until it dies or is
//! merged, once; an id is never used again; the larger of two keeps its id. Must not know: points, noise, how shapes
//! move.

use super::actor::Ideal;

/// A hole that is there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueHole {
    /// Lasts as long as the hole does.
    pub id: u64,
    /// Its centre.
    pub center: [f64; 2],
    /// Radius of the largest empty disc in it.
    pub radius: f64,
    /// How far from the centre the middles of its largest empty discs lie: 0 unless it is an annulus.
    pub orbit: f64,
}

impl TrueHole {
    /// How far a place is from where its largest empty discs lie.
    pub fn distance(&self, [x, y]: [f64; 2]) -> f64 {
        let (dx, dy) = (x - self.center[0], y - self.center[1]);
        ((dx * dx + dy * dy).sqrt() - self.orbit).abs()
    }
}

/// What happens to a hole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrueEvent {
    /// It is there from now on.
    Born {
        /// The hole.
        id: u64,
    },
    /// It is there from now on, and was part of another one.
    Split {
        /// The hole.
        id: u64,
        /// The other one, which stays.
        from: u64,
    },
    /// It is not there any more, and has become part of another one.
    Merged {
        /// The hole.
        id: u64,
        /// The other one, which stays.
        into: u64,
    },
    /// It is not there any more.
    Died {
        /// The hole.
        id: u64,
    },
}

/// Gives out ids.
#[derive(Clone, Debug)]
pub struct Chronicle {
    above: f64,
    /// The id of each ideal hole that is there.
    ids: Vec<Option<u64>>,
    last: u64,
}

impl Chronicle {
    /// Holes count from this persistence on.
    pub fn new(above: f64) -> Self {
        Self { above, ids: Vec::new(), last: 0 }
    }

    /// The next frame: its holes by id, and its events. There are as many ideal holes in every frame.
    pub fn write(&mut self, ideals: &[Ideal]) -> (Vec<TrueHole>, Vec<TrueEvent>) {
        self.ids.resize(ideals.len(), None);
        let before = self.ids.clone();
        let mut events = Vec::new();
        for (slot, ideal) in ideals.iter().enumerate() {
            let is_there = ideal.persistence >= self.above;
            // The mate stands before it in the list, so its id is known. Only one that was there and stays can be split
            // from, or merged into.
            let mate = ideal.mate.map(|back| slot - back);
            let mate = mate.and_then(|mate| before[mate].filter(|_| self.ids[mate] == before[mate]));
            match (before[slot], is_there) {
                (None, true) => {
                    self.last += 1;
                    let id = self.last;
                    self.ids[slot] = Some(id);
                    events.push(mate.map_or(TrueEvent::Born { id }, |from| TrueEvent::Split { id, from }));
                }
                (Some(id), false) => {
                    self.ids[slot] = None;
                    events.push(mate.map_or(TrueEvent::Died { id }, |into| TrueEvent::Merged { id, into }));
                }
                _ => {}
            }
        }
        let hole = |(ideal, id): (&Ideal, &Option<u64>)| {
            id.map(|id| TrueHole { id, center: ideal.center, radius: ideal.radius, orbit: ideal.orbit })
        };
        let mut holes: Vec<TrueHole> = ideals.iter().zip(&self.ids).filter_map(hole).collect();
        holes.sort_unstable_by_key(|hole| hole.id);
        (holes, events)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn events(frames: &[[f64; 2]]) -> Vec<Vec<TrueEvent>> {
        let mut chronicle = Chronicle::new(0.5);
        let ideal = |persistence, mate| Ideal { center: [0.0; 2], radius: 1.0, orbit: 0.0, persistence, mate };
        let write = |&[first, second]: &[f64; 2]| chronicle.write(&[ideal(first, None), ideal(second, Some(1))]).1;
        frames.iter().map(write).collect()
    }

    #[test]
    fn the_lesser_of_a_pair_splits_off_and_is_merged() {
        use TrueEvent::*;
        let told = events(&[[1.0, 0.0], [1.0, 0.5], [1.0, 0.4], [1.0, 0.6], [0.0, 0.0]]);
        let split = |id| vec![Split { id, from: 1 }];
        let ended = vec![Died { id: 1 }, Died { id: 3 }];
        assert_eq!(told, [vec![Born { id: 1 }], split(2), vec![Merged { id: 2, into: 1 }], split(3), ended]);
    }

    #[test]
    fn who_begins_or_ends_with_the_other_was_never_part_of_it() {
        use TrueEvent::*;
        let told = events(&[[1.0, 1.0], [0.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
        let both = vec![Born { id: 1 }, Born { id: 2 }];
        assert_eq!(told, [both, vec![Died { id: 1 }], vec![Born { id: 3 }, Died { id: 2 }], vec![Died { id: 3 }]]);
    }

    #[test]
    fn distances_to_an_annulus_count_from_its_middle() {
        let hole = TrueHole { id: 1, center: [1.0, 0.0], radius: 1.0, orbit: 2.0 };
        assert_eq!([[1.0, 0.0], [3.0, 0.0], [1.0, 5.0]].map(|place| hole.distance(place)), [2.0, 0.0, 3.0]);
    }
}
