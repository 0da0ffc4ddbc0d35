//! Random scripts: a base of some size in one kind of place, then small steps, so that most frames are brought up to date vertex by
//! vertex, and the great steps in between that need a rebuild.

use proptest::prelude::*;
use proptest::sample::Index;

use super::clouds::{Ground, Point};
use super::model::{Kept, Model};
use super::script::{Script, Step};

/// What shall happen, in terms of what is there by then.
#[derive(Clone, Debug)]
enum Action {
    /// New points.
    Come(Vec<Point>),
    /// New points, some with coordinates that no cloud takes.
    ComeSpoilt(Vec<Point>),
    /// Points from another kind of place: they leave a line.
    Stray(Vec<Point>),
    /// All strays go: a line is found again.
    StraysGo,
    /// Points on positions that are taken already.
    Double(Vec<Index>),
    /// Points that are there go.
    Go(Vec<Index>),
    /// Positions that were left are taken again.
    Return(Vec<Index>),
    /// Points that are there go, and come again: in the same frame, or `committed` in between.
    GoAndReturn { which: Vec<Index>, committed: bool },
    /// A retraction where no point is.
    Miss(Point),
    /// Everything is replaced.
    Replace(Vec<Point>),
    /// Everything goes.
    Empty,
    /// Event time moves on by so many halves.
    Wait(u8),
}

use Action::*;

/// What follows an action.
#[derive(Clone, Copy, Debug)]
enum Then {
    Poll,
    Commit,
    Nothing,
}

fn action(ground: Ground) -> impl Strategy<Value = Action> {
    let few = || prop::collection::vec(any::<Index>(), 1..5);
    prop_oneof![
        8 => ground.points(1..7).prop_map(Come),
        1 => ground.points(1..5).prop_map(ComeSpoilt),
        2 => Ground::any().prop_flat_map(|other| other.points(1..4)).prop_map(Stray),
        2 => Just(StraysGo),
        3 => few().prop_map(Double),
        6 => few().prop_map(Go),
        2 => few().prop_map(Return),
        3 => (few(), any::<bool>()).prop_map(|(which, committed)| GoAndReturn { which, committed }),
        1 => ground.point().prop_map(Miss),
        1 => ground.points(1..80).prop_map(Replace),
        1 => Just(Empty),
        2 => (0..6_u8).prop_map(Wait),
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
    Ground::any().prop_flat_map(scripts_on)
}

/// Random scripts in one kind of place.
pub fn scripts_on(ground: Ground) -> impl Strategy<Value = Script> {
    let resolution = prop_oneof![4 => Just(None), 1 => Just(Some(0.25)), 1 => Just(Some(0.3))];
    let base = prop_oneof![1 => ground.points(0..30), 9 => ground.points(30..200)];
    let actions = prop::collection::vec((action(ground), then(), event_time()), 1..14);
    (kept(), resolution, base, 1..12_usize, actions).prop_map(|(kept, resolution, base, batches, actions)| {
        let mut writer = Writer::new(kept, resolution);
        writer.lay_base(&base, batches);
        for (action, then, time) in actions {
            writer.write(action, time);
            writer.close(then);
        }
        writer.close(Then::Poll);
        writer.script
    })
}

/// How much later than the newest one, in halves, a batch's event time is; none for a batch without time.
fn event_time() -> impl Strategy<Value = Option<i8>> {
    prop_oneof![1 => Just(None), 6 => (-4..4_i8).prop_map(Some)]
}

/// Turns actions into steps, following the model to know what is there.
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

    /// In several batches, so that not all leaves a window at once.
    fn lay_base(&mut self, base: &[Point], batches: usize) {
        for batch in base.chunks(base.len().div_ceil(batches).max(1)) {
            self.insert(batch.to_vec(), Some(1));
            self.close(if let Kept::Frames(_) = self.script.kept { Then::Commit } else { Then::Nothing });
        }
        self.close(Then::Poll);
    }

    fn write(&mut self, action: Action, time: Option<i8>) {
        match action {
            Come(points) => self.insert(points, time),
            ComeSpoilt(mut points) => {
                let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
                let spoilt = bad.iter().enumerate().map(|(axis, &v)| if axis == 0 { [v, 0.0] } else { [0.0, v] });
                points.splice(1..1, spoilt);
                self.insert(points, time);
            }
            Stray(points) => {
                self.strays.extend(&points);
                self.insert(points, time);
            }
            StraysGo => {
                let strays = std::mem::take(&mut self.strays);
                self.retract(strays);
            }
            Double(which) => {
                let points = self.pick(&which);
                self.insert(points, time);
            }
            Go(which) => {
                let points = self.pick(&which);
                self.retract(points);
            }
            Return(which) => {
                if !self.gone.is_empty() {
                    let points = which.iter().map(|index| *index.get(&self.gone)).collect();
                    self.insert(points, time);
                }
            }
            GoAndReturn { which, committed } => {
                let points = self.pick(&which);
                self.retract(points.clone());
                self.close(if committed { Then::Commit } else { Then::Nothing });
                self.insert(points, time);
            }
            Miss(point) => self.retract(vec![point]),
            Replace(points) => {
                self.retract(self.model.points());
                self.insert(points, time);
            }
            Empty => self.retract(self.model.points()),
            Wait(halves) => {
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
