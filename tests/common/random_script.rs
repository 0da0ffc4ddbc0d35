//! Random scripts: a base of some size, then small steps, so that most frames are updated vertex by vertex, and some
//! large steps that need a rebuild.

use proptest::prelude::*;
use proptest::sample::Index;

use super::clouds::{Placement, Point};
use super::model::{Kept, Model};
use super::script::{Script, Step};

/// A change, relative to the current points.
#[derive(Clone, Debug)]
enum Change {
    /// Inserts points.
    Insert(Vec<Point>),
    /// Inserts points, some of them with invalid coordinates.
    InsertInvalid(Vec<Point>),
    /// Inserts points of another kind of place. A line is no longer a line.
    Stray(Vec<Point>),
    /// Removes all strays. The rest may be a line again.
    RemoveStrays,
    /// Inserts points at positions that are in use.
    Duplicate(Vec<Index>),
    /// Removes points.
    Remove(Vec<Index>),
    /// Inserts points at positions that were left.
    Restore(Vec<Index>),
    /// Removes points and inserts them again, in the same frame or after a commit.
    RemoveAndRestore { which: Vec<Index>, committed: bool },
    /// Retracts a point that is not there.
    RetractMissing(Point),
    /// Replaces all points.
    Replace(Vec<Point>),
    /// Removes all points.
    RemoveAll,
    /// Advances the event time by a number of halves.
    AdvanceTime(u8),
}

use Change::*;

/// What follows a change.
#[derive(Clone, Copy, Debug)]
enum Then {
    Poll,
    Commit,
    Nothing,
}

fn change(placement: Placement) -> impl Strategy<Value = Change> {
    let few = || prop::collection::vec(any::<Index>(), 1..5);
    prop_oneof![
        8 => placement.points(1..7).prop_map(Insert),
        1 => placement.points(1..5).prop_map(InsertInvalid),
        2 => Placement::any().prop_flat_map(|other| other.points(1..4)).prop_map(Stray),
        2 => Just(RemoveStrays),
        3 => few().prop_map(Duplicate),
        6 => few().prop_map(Remove),
        2 => few().prop_map(Restore),
        3 => (few(), any::<bool>()).prop_map(|(which, committed)| RemoveAndRestore { which, committed }),
        1 => placement.point().prop_map(RetractMissing),
        1 => placement.points(1..80).prop_map(Replace),
        1 => Just(RemoveAll),
        2 => (0..6_u8).prop_map(AdvanceTime),
    ]
}

fn then() -> impl Strategy<Value = Then> {
    prop_oneof![6 => Just(Then::Poll), 2 => Just(Then::Commit), 2 => Just(Then::Nothing)]
}

fn kept() -> impl Strategy<Value = Kept> {
    prop_oneof![
        3 => Just(Kept::All),
        2 => (1..200_u64).prop_map(Kept::Points),
        2 => (1..16_u64).prop_map(Kept::Frames),
        2 => (0..16_u8).prop_map(|halves| Kept::Time(f64::from(halves) / 2.0)),
    ]
}

/// Random scripts of any kind.
pub fn scripts() -> impl Strategy<Value = Script> {
    Placement::any().prop_flat_map(scripts_on)
}

/// Random scripts on one kind of place.
pub fn scripts_on(placement: Placement) -> impl Strategy<Value = Script> {
    let resolution = prop_oneof![4 => Just(None), 1 => Just(Some(0.25)), 1 => Just(Some(0.3))];
    let base = prop_oneof![1 => placement.points(0..30), 9 => placement.points(30..200)];
    let actions = prop::collection::vec((change(placement), then(), event_time()), 1..14);
    (kept(), resolution, base, 1..12_usize, actions).prop_map(|(kept, resolution, base, batches, actions)| {
        let mut writer = Writer::new(kept, resolution);
        writer.insert_base(&base, batches);
        for (change, then, time) in actions {
            writer.write(change, time);
            writer.close(then);
        }
        writer.close(Then::Poll);
        writer.script
    })
}

/// The event time of a batch in halves after the newest one. None: a batch without time.
fn event_time() -> impl Strategy<Value = Option<i8>> {
    prop_oneof![1 => Just(None), 6 => (-4..4_i8).prop_map(Some)]
}

/// Turns changes into steps. A model says which points are there.
struct Writer {
    script: Script,
    model: Model,
    strays: Vec<Point>,
    gone: Vec<Point>,
}

impl Writer {
    fn new(kept: Kept, resolution: Option<f64>) -> Self {
        Self {
            script: Script { kept, resolution, steps: Vec::new() },
            model: Model::new(kept, resolution),
            strays: Vec::new(),
            gone: Vec::new(),
        }
    }

    /// Inserts the base in several batches, so that not all of it leaves a window at once.
    fn insert_base(&mut self, base: &[Point], batches: usize) {
        for batch in base.chunks(base.len().div_ceil(batches).max(1)) {
            self.insert(batch.to_vec(), Some(1));
            self.close(if let Kept::Frames(_) = self.script.kept { Then::Commit } else { Then::Nothing });
        }
        self.close(Then::Poll);
    }

    fn write(&mut self, change: Change, time: Option<i8>) {
        match change {
            Insert(points) => self.insert(points, time),
            InsertInvalid(mut points) => {
                let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
                let invalid = bad.iter().enumerate().map(|(axis, &v)| if axis == 0 { [v, 0.0] } else { [0.0, v] });
                points.splice(1..1, invalid);
                self.insert(points, time);
            }
            Stray(points) => {
                self.strays.extend(&points);
                self.insert(points, time);
            }
            RemoveStrays => {
                let strays = std::mem::take(&mut self.strays);
                self.retract(strays);
            }
            Duplicate(which) => {
                let points = self.pick(&which);
                self.insert(points, time);
            }
            Remove(which) => {
                let points = self.pick(&which);
                self.retract(points);
            }
            Restore(which) => {
                if !self.gone.is_empty() {
                    let points = which.iter().map(|index| *index.get(&self.gone)).collect();
                    self.insert(points, time);
                }
            }
            RemoveAndRestore { which, committed } => {
                let points = self.pick(&which);
                self.retract(points.clone());
                self.close(if committed { Then::Commit } else { Then::Nothing });
                self.insert(points, time);
            }
            RetractMissing(point) => self.retract(vec![point]),
            Replace(points) => {
                self.retract(self.model.points());
                self.insert(points, time);
            }
            RemoveAll => self.retract(self.model.points()),
            AdvanceTime(halves) => {
                let time = self.model.newest().unwrap_or(0.0) + f64::from(halves) / 2.0;
                self.model.advance_time(time);
                self.script.steps.push(Step::Time(time));
            }
        }
    }

    fn pick(&self, which: &[Index]) -> Vec<Point> {
        let points = self.model.points();
        if points.is_empty() { Vec::new() } else { which.iter().map(|index| *index.get(&points)).collect() }
    }

    fn insert(&mut self, points: Vec<Point>, halves_later: Option<i8>) {
        let newest = self.model.newest().unwrap_or(0.0);
        let time = halves_later.map(|halves| newest + f64::from(halves) / 2.0);
        for &point in &points {
            self.model.insert(point, time);
        }
        self.script.steps.push(Step::Insert(time, points));
    }

    fn retract(&mut self, points: Vec<Point>) {
        for &point in &points {
            self.model.retract(point);
        }
        self.gone.extend(&points);
        self.script.steps.push(Step::Retract(points));
    }

    fn close(&mut self, then: Then) {
        if !matches!(then, Then::Nothing) {
            self.model.commit();
            self.script.steps.push(Step::Commit);
        }
        if matches!(then, Then::Poll) {
            self.script.steps.push(Step::Poll);
        }
    }
}
