//! The filter: which points of a cloud pass, from frame to frame.
//!
//! In: the cloud, and what changed in it.
//! Out: what changed among the points that pass and among the outliers; a report.
//! Invariants: whether a point passes depends on the positions alone. A change is followed at the cost of the points
//! whose neighbours it changes; a large one, or one that moves R, is computed anew, with the same result.
//! Must not know: triangulations, frames.

use super::contrast::{self, Event};
use super::ladder::{Rungs, square};
use super::occupancy::Occupancy;
use super::report::Decluttered;
use super::rule::Declutter;
use super::search::{Extent, Workspace, square_distance};
use super::tree::{Entry, NodeId, ROOT, Tree};
use crate::topology::base::in_parts;
use crate::topology::cloud::{Cloud, CloudChange, Position, Slot};

/// R is at least so many rungs above the median distance: twice as large.
const ABOVE_MEDIAN: i32 = 4;

/// Changes of more than this share of the points are computed anew.
const LARGE_CHANGE: usize = 4;

/// A cloud that has shrunk by this factor is computed anew: its tree is too deep by now.
const SHRUNK: usize = 2;

/// What changed among the points that pass, and among the others. A point that changes sides is in both.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sides {
    /// The points that pass.
    pub passing: CloudChange,
    /// The outliers.
    pub outliers: CloudChange,
}

/// What every point is compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bar {
    /// The square of R.
    square: f64,
    /// Whether contrasted points are outliers.
    is_contrast_asked: bool,
    /// How many lone clutter points are expected to pass.
    expected: f64,
}

const OPEN: Bar = Bar { square: f64::INFINITY, is_contrast_asked: false, expected: 0.0 };

/// Tells points from outliers.
#[derive(Clone, Debug)]
pub struct Filter {
    rule: Declutter,
    tree: Tree,
    occupancy: Occupancy,
    rungs: Rungs,
    bar: Bar,
    /// The number of points when all was last computed anew.
    loaded: usize,
    /// By slot: whether it is in use and passes.
    passes: Vec<bool>,
    outliers: usize,
    /// By slot: whether it is in a list that is made.
    is_listed: Vec<bool>,
    work: Workspace,
}

impl Filter {
    /// A filter of no points.
    pub fn new(rule: Declutter) -> Self {
        Self {
            rule,
            tree: Tree::default(),
            occupancy: Occupancy::default(),
            rungs: Rungs::default(),
            bar: OPEN,
            loaded: 0,
            passes: Vec::new(),
            outliers: 0,
            is_listed: Vec::new(),
            work: Workspace::default(),
        }
    }

    /// What it does.
    pub fn report(&self) -> Decluttered {
        Decluttered {
            filtered: self.outliers,
            neighbours: self.rule.neighbours(),
            radius: self.rule.radius().unwrap_or_else(|| self.bar.square.sqrt()),
            rho: self.tree.largest_passing().sqrt(),
            expected: self.bar.expected,
            is_certified: self.rule.is_certified(self.bar.expected),
        }
    }

    /// The slots of all outliers.
    pub fn outliers(&self) -> Vec<Slot> {
        let slots = self.tree.entries().map(|entry| entry.slot);
        slots.filter(|&slot| !self.passes[slot as usize]).collect()
    }

    /// About how many bytes it takes.
    pub fn bytes(&self) -> usize {
        self.tree.bytes() + self.occupancy.bytes() + self.passes.capacity() + self.is_listed.capacity()
    }

    /// Panics when the filter is inconsistent. For tests.
    #[cfg(test)]
    pub fn check(&self) {
        self.tree.check();
        assert!(!self.is_listed.contains(&true));
        assert_eq!(self.passes.iter().filter(|passes| **passes).count() + self.outliers, self.tree.len());
    }

    /// Follows a change of the cloud.
    pub fn follow(&mut self, cloud: &Cloud, change: &CloudChange) -> Sides {
        self.passes.resize(cloud.slot_count(), false);
        self.is_listed.resize(cloud.slot_count(), false);
        let changed = change.appeared.len() + change.vanished.len();
        let mut sides = Sides::default();
        for &slot in &change.vanished {
            let passed = std::mem::take(&mut self.passes[slot as usize]);
            self.outliers -= usize::from(!passed);
            if passed { &mut sides.passing } else { &mut sides.outliers }.vanished.push(slot);
        }
        // New points count as outliers until they are judged.
        self.outliers += change.appeared.len();
        let is_large = changed * LARGE_CHANGE > self.tree.len();
        let judged = if is_large || self.tree.len() * SHRUNK < self.loaded {
            self.load(cloud, change);
            None
        } else {
            Some(self.follow_small(cloud, change))
        };
        self.judge(cloud, change, judged, &mut sides);
        sides
    }

    /// Computes all distances and contrasts anew.
    fn load(&mut self, cloud: &Cloud, change: &CloudChange) {
        change.vanished.iter().for_each(|&slot| self.is_listed[slot as usize] = true);
        let old = self.tree.entries().filter(|entry| !self.is_listed[entry.slot as usize]).copied();
        let entries = old.chain(change.appeared.iter().map(|&slot| new_entry(cloud, slot))).collect();
        change.vanished.iter().for_each(|&slot| self.is_listed[slot as usize] = false);
        // The old tree makes way for the new one.
        self.tree = Tree::default();
        self.tree = Tree::new(entries);
        self.loaded = self.tree.len();
        self.tree.refresh(f64::INFINITY, true);
        let neighbours = self.rule.neighbours() as usize;
        let reaches = of_all(&self.tree, |tree, leaves| {
            let mut work = Workspace::default();
            let reaches = |&leaf| tree.reaches(leaf, tree.leaf_entries(leaf), neighbours, &mut work).to_vec();
            leaves.iter().flat_map(reaches).collect()
        });
        self.rungs = Rungs::default();
        reaches.iter().for_each(|&reach| self.rungs.add(reach));
        set_all(&mut self.tree, reaches, |entry, reach| entry.reach = reach);
        self.tree.refresh(f64::INFINITY, true);
        let wanted = self.rule.witnesses();
        let contrasts = of_all(&self.tree, |tree, leaves| {
            let mut contrasts = Vec::new();
            for &leaf in leaves {
                contrast::judge_group(tree, tree.leaf_entries(leaf), wanted, |_, is| contrasts.push(is));
            }
            contrasts
        });
        set_all(&mut self.tree, contrasts, |entry, is| entry.is_contrasted = is);
        self.occupancy = Occupancy::default();
        self.count_cells(cloud, &CloudChange::default());
    }

    /// Follows a small change. Returns the slots that may have changed sides.
    fn follow_small(&mut self, cloud: &Cloud, change: &CloudChange) -> Vec<Slot> {
        let near = self.slots_near(cloud, change);
        let mut events = Vec::with_capacity(change.vanished.len() + change.appeared.len() + near.len());
        for &slot in &change.vanished {
            let Entry { position, reach, .. } = self.tree.remove(slot);
            self.rungs.remove(reach);
            events.push(Event { leaf: ROOT, position, reach });
        }
        for &slot in &change.appeared {
            self.tree.insert(new_entry(cloud, slot));
            self.rungs.add(f64::NAN);
        }
        // Leaves may have been split and merged until now.
        events.iter_mut().for_each(|event| event.leaf = self.tree.leaf_of(event.position));
        self.refresh();
        let asked = [near, change.appeared.clone()].concat();
        let mut judged = self.set_reaches(&asked, &mut events);
        self.refresh();
        judged.iter().for_each(|&slot| self.is_listed[slot as usize] = true);
        contrast::near_events(&self.tree, events, |slot| {
            if !std::mem::replace(&mut self.is_listed[slot as usize], true) {
                judged.push(slot);
            }
        });
        judged.iter().for_each(|&slot| self.is_listed[slot as usize] = false);
        self.set_contrasts(&judged);
        self.count_cells(cloud, change);
        judged
    }

    fn refresh(&mut self) {
        self.tree.refresh(self.bar.square, !self.bar.is_contrast_asked);
    }

    /// Finds the K-th neighbours of points anew. Adds an event for each whose distance has changed, and returns them.
    fn set_reaches(&mut self, slots: &[Slot], events: &mut Vec<Event>) -> Vec<Slot> {
        let Self { tree, rungs, rule, work, .. } = self;
        let neighbours = rule.neighbours() as usize;
        let mut changed = Vec::with_capacity(slots.len());
        for (leaf, group) in groups(tree, slots) {
            for (entry, &reach) in group.iter().zip(tree.reaches(leaf, &group, neighbours, work)) {
                if entry.reach != reach {
                    changed.push((entry.slot, reach));
                    events.push(Event { leaf, position: entry.position, reach: reach.min(entry.reach) });
                }
            }
        }
        let slots = changed.iter().map(|&(slot, reach)| {
            let entry = tree.entry_mut(slot);
            rungs.remove(entry.reach);
            rungs.add(reach);
            entry.reach = reach;
            slot
        });
        slots.collect()
    }

    fn set_contrasts(&mut self, slots: &[Slot]) {
        let wanted = self.rule.witnesses();
        let mut changed = Vec::new();
        for (_, group) in groups(&self.tree, slots) {
            contrast::judge_group(&self.tree, &group, wanted, |entry, is_contrasted| {
                changed.extend((entry.is_contrasted != is_contrasted).then_some(entry.slot));
            });
        }
        for slot in changed {
            let entry = self.tree.entry_mut(slot);
            entry.is_contrasted = !entry.is_contrasted;
        }
    }

    /// Points that stay and whose K-th neighbour a change may change.
    fn slots_near(&mut self, cloud: &Cloud, change: &CloudChange) -> Vec<Slot> {
        let Self { tree, is_listed, .. } = self;
        let mut places: Vec<(u32, Slot)> = change.vanished.iter().map(|&slot| (tree.leaf(slot), slot)).collect();
        places.extend(change.appeared.iter().map(|&slot| (tree.leaf_of(cloud.position(slot)), slot)));
        places.sort_unstable();
        change.vanished.iter().for_each(|&slot| is_listed[slot as usize] = true);
        let (mut near, mut positions) = (Vec::new(), Vec::new());
        for group in places.chunk_by(|a, b| a.0 == b.0) {
            positions.clear();
            positions.extend(group.iter().map(|&(_, slot)| cloud.position(slot)));
            tree.around(Extent::of(positions.iter().copied()), 1.0, f64::NEG_INFINITY, &mut |entry| {
                // A neighbour that leaves may be the K-th itself.
                let is_in_reach = |&other: &Position| square_distance(entry.position, other) <= entry.reach;
                if !is_listed[entry.slot as usize] && positions.iter().any(is_in_reach) {
                    is_listed[entry.slot as usize] = true;
                    near.push(entry.slot);
                }
            });
        }
        change.vanished.iter().chain(&near).for_each(|&slot| is_listed[slot as usize] = false);
        near
    }

    fn count_cells(&mut self, cloud: &Cloud, change: &CloudChange) {
        let positions = |slots: &[Slot]| -> Vec<Position> { slots.iter().map(|&slot| cloud.position(slot)).collect() };
        let changed = [positions(&change.vanished), positions(&change.appeared)];
        let all = || self.tree.entries().map(|entry| entry.position);
        self.occupancy.follow(self.tree.bounds(), self.tree.len(), changed.each_ref().map(Vec::as_slice), all);
    }

    /// What every point is compared with now.
    fn bar(&self) -> Bar {
        let neighbours = self.rule.neighbours();
        let clutter = self.occupancy.clutter();
        if let Some(radius) = self.rule.radius() {
            let square = radius * radius;
            let expected = clutter.map_or(0.0, |clutter| clutter.passing_square(neighbours, square));
            return Bar { square, is_contrast_asked: true, expected };
        }
        let Some(clutter) = clutter else { return OPEN };
        let lone = clutter.rung(neighbours, self.rule.expected());
        let rung = lone.zip(self.rungs.median()).map(|(lone, median)| lone.max(median + ABOVE_MEDIAN));
        Bar {
            square: rung.map_or(f64::INFINITY, square),
            is_contrast_asked: true,
            expected: clutter.passing(neighbours, rung),
        }
    }

    /// Decides which of some points pass; of all, if R has moved or nothing is known of them.
    fn judge(&mut self, cloud: &Cloud, change: &CloudChange, judged: Option<Vec<Slot>>, sides: &mut Sides) {
        let bar = self.bar();
        let is_same = (bar.square, bar.is_contrast_asked) == (self.bar.square, self.bar.is_contrast_asked);
        self.bar = bar;
        change.appeared.iter().for_each(|&slot| self.is_listed[slot as usize] = true);
        let Self { tree, passes, is_listed, outliers, .. } = self;
        let mut side_of = |entry: &Entry| {
            let slot = entry.slot as usize;
            let is = entry.reach <= bar.square && !(bar.is_contrast_asked && entry.is_contrasted);
            let was = std::mem::replace(&mut passes[slot], is);
            let is_new = is_listed[slot];
            if was != is {
                *outliers = if is { *outliers - 1 } else { *outliers + 1 };
                let (to, from) = if is {
                    (&mut sides.passing, &mut sides.outliers)
                } else {
                    (&mut sides.outliers, &mut sides.passing)
                };
                to.appeared.push(entry.slot);
                from.vanished.extend((!is_new).then_some(entry.slot));
            } else if is_new {
                sides.outliers.appeared.push(entry.slot);
            }
        };
        match judged {
            Some(judged) if is_same => judged.iter().for_each(|&slot| side_of(tree.entry(slot))),
            _ => {
                tree.entries().for_each(side_of);
                tree.spoil_all();
            }
        }
        change.appeared.iter().for_each(|&slot| is_listed[slot as usize] = false);
        self.refresh();
        for side in [&mut sides.passing, &mut sides.outliers] {
            for slots in [&mut side.appeared, &mut side.vanished] {
                slots.sort_unstable_by_key(|&slot| (cloud.id(slot), slot));
            }
        }
    }
}

fn new_entry(cloud: &Cloud, slot: Slot) -> Entry {
    Entry { position: cloud.position(slot), slot, is_contrasted: false, reach: f64::NAN }
}

/// The results of `work` on the points of all leaves, in their order.
fn of_all<T: Send>(tree: &Tree, work: impl Fn(&Tree, &[NodeId]) -> Vec<T> + Sync) -> Vec<T> {
    let leaves = tree.leaves();
    // Parts are of points; leaves are shared in proportion.
    let points = tree.len();
    let place = |point: usize| (point as u64 * leaves.len() as u64 / points.max(1) as u64) as usize;
    in_parts(points, |part| work(tree, &leaves[place(part.start)..place(part.end)])).into_iter().flatten().collect()
}

/// Sets something of the points of all leaves, in their order.
fn set_all<T>(tree: &mut Tree, values: Vec<T>, set: impl Fn(&mut Entry, T)) {
    let mut values = values.into_iter();
    for leaf in tree.leaves() {
        tree.leaf_entries_mut(leaf).iter_mut().zip(&mut values).for_each(|(entry, value)| set(entry, value));
    }
}

/// The points of slots, those of a leaf together.
fn groups(tree: &Tree, slots: &[Slot]) -> Vec<(NodeId, Vec<Entry>)> {
    let mut places: Vec<(NodeId, Slot)> = slots.iter().map(|&slot| (tree.leaf(slot), slot)).collect();
    places.sort_unstable();
    let group = |group: &[(NodeId, Slot)]| {
        let mut entries = Vec::with_capacity(group.len());
        entries.extend(group.iter().map(|&(_, slot)| *tree.entry(slot)));
        (group[0].0, entries)
    };
    places.chunk_by(|a, b| a.0 == b.0).map(group).collect()
}
