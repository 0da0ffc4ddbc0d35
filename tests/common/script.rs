//! A script: a list of steps that is run on the engine and on the plain [`Model`], which are compared at every poll.
//!
//! A script prints itself as a test. The output of `{:?}` compiles with `use common::script::{Script, Step::*, run}`
//! and `use common::model::Kept`.

use std::collections::BTreeMap;
use std::fmt;
use std::num::NonZeroU32;
use std::sync::Arc;

use hopes::topology::{
    Critical, Follower, Frame, Options, Pipeline, Refusal, SimplifiedFollower, Snapshot, Step as FrameStep, VertexId,
    ViewSpec, simplify,
};

use super::by_position::ByPosition;
use super::clouds::Point;
use super::model::{Kept, Model};
use super::skeleton_of;

/// A step of a script.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// Inserts a batch of points. They have one event time, or none.
    Insert(Option<f64>, Vec<Point>),
    /// Retracts points one by one. Some may not be there.
    Retract(Vec<Point>),
    /// Advances the event time.
    Time(f64),
    /// Commits a frame.
    Commit,
    /// Polls a frame.
    Poll,
}

use Step::*;

/// The options of a stream and its steps.
#[derive(Clone, PartialEq)]
pub struct Script {
    pub kept: Kept,
    pub resolution: Option<f64>,
    pub steps: Vec<Step>,
}

impl Script {
    pub fn options(&self) -> Options {
        Options { window: self.kept.window(), resolution: self.resolution, ..Options::default() }
    }
}

/// Runs a script. Returns the polled frames. Panics where the engine and the model differ.
pub fn run(script: &Script) -> Vec<Arc<Frame>> {
    let mut stage = Harness {
        pipeline: Pipeline::new(script.options()).with_leaf(3),
        model: Model::new(script.kept, script.resolution),
        times: Vec::new(),
        polled: 0,
        ids: BTreeMap::new(),
        frames: Vec::new(),
        followers: followed().map(|spec| (Follower::new(spec), Snapshot::default())).collect(),
        simplified: (SimplifiedFollower::new(ViewSpec::default(), None), Snapshot::default()),
    };
    for step in &script.steps {
        stage.act(step);
        stage.pipeline.check_invariants();
    }
    stage.frames
}

/// An engine and its model.
struct Harness {
    pipeline: Pipeline,
    model: Model,
    /// The times of the commits.
    times: Vec<Option<f64>>,
    /// The number of the last polled frame.
    polled: u64,
    /// The id of each lifetime that a frame has shown.
    ids: BTreeMap<usize, VertexId>,
    frames: Vec<Arc<Frame>>,
    /// Followers of views, and their content. The last one is polled for every other frame only.
    followers: Vec<(Follower, Snapshot)>,
    /// The same for a simplified view.
    simplified: (SimplifiedFollower, Snapshot),
}

/// Views of every kind.
fn followed() -> impl Iterator<Item = ViewSpec> {
    let derived = |k, l| ViewSpec::Derived { k: NonZeroU32::new(k).unwrap(), l: NonZeroU32::new(l).unwrap() };
    [ViewSpec::Full, ViewSpec::Reduced { alpha: 0.3 }, derived(1, 1), derived(2, 2), derived(5, 3), derived(1, 2)]
        .into_iter()
}

impl Harness {
    fn act(&mut self, step: &Step) {
        match step {
            Insert(time, points) => {
                let refused = self.pipeline.feed_points(points, *time).into_iter().map(|(index, _)| index);
                let model = &mut self.model;
                let want = (0..points.len()).filter(|&index| !model.insert(points[index], *time));
                assert_eq!(refused.collect::<Vec<_>>(), want.collect::<Vec<_>>(), "places of refused points");
            }
            Retract(points) => {
                for &[x, y] in points {
                    let retracted = self.pipeline.feed_retraction(x, y);
                    if self.model.retract([x, y]) {
                        assert_eq!(retracted, Ok(()));
                    } else {
                        assert_eq!(retracted, Err(Refusal::NotThere { x, y }));
                    }
                }
            }
            Time(time) => {
                assert_eq!(self.pipeline.feed_time(*time), Ok(()));
                self.model.advance_time(*time);
            }
            Commit => {
                self.model.commit();
                self.times.push(self.model.newest());
                assert_eq!(self.pipeline.commit(self.model.newest()), self.model.commits(), "frame number");
            }
            Poll => self.poll(),
        }
        assert_eq!(self.pipeline.point_count(), self.model.points().len() as u64, "points in the window");
    }

    fn poll(&mut self) {
        let computed = self.pipeline.computed();
        // Now the followers compute the frame, now the plain poll does.
        let steps = if self.model.commits().is_multiple_of(3) { Vec::new() } else { self.follow() };
        let frame = self.pipeline.poll_frame();
        assert_eq!(frame.is_some(), self.polled < self.model.commits(), "whether there is a frame");
        let Some(frame) = frame else { return };
        self.polled = self.model.commits();
        assert_eq!(frame.number, self.polled);
        assert_eq!(frame.time, *self.times.last().expect("a frame has a commit"));
        assert_eq!(frame.points, self.model.committed_points() as u64, "points of the frame");
        assert_eq!(self.pipeline.computed(), computed + 1, "a frame is computed once");
        self.check_ids(&frame);
        let positions: Vec<Point> = self.model.committed().iter().map(|life| life.at).collect();
        ByPosition::of(&frame.skeleton).assert_same(&ByPosition::of(&skeleton_of(&positions)));
        let steps = if steps.is_empty() { self.follow() } else { steps };
        self.check_steps(&frame, steps);
        for (follower, _) in &self.followers {
            assert_eq!(self.pipeline.check(follower), Ok(()));
        }
        self.check_simplified(&frame);
        self.check_ranking(&frame);
        self.frames.push(frame);
    }

    /// Steps lead from one simplified view to the next.
    fn check_simplified(&mut self, frame: &Frame) {
        let (follower, held) = &mut self.simplified;
        let step = self.pipeline.poll_simplified(follower).expect("it was not polled for this frame");
        let view = frame.view(ViewSpec::default());
        let wanted = Snapshot::of_simplified(&frame.skeleton, &simplify(&frame.skeleton, &view, view.scale()));
        *held = held.apply(&step.diff).expect("it starts from what is held");
        assert_eq!((&*held, held.checksum()), (&wanted, step.checksum));
        assert_eq!(held.vertices.len() + step.cycles, held.tree.len() + step.components, "Euler's formula");
        assert!(held.vertices.ids().iter().all(|id| frame.skeleton.vertices().ids().contains(id)));
    }

    /// A ranking is the list of the most persistent dots.
    fn check_ranking(&mut self, frame: &Frame) {
        let (all, id) = (frame.skeleton.dots(), |v: u32| frame.skeleton.vertices().id(v));
        for most in [0, 1, all.len() / 2, all.len(), all.len() + 1] {
            let ranking = self.pipeline.poll_dots(most);
            assert_eq!(
                (ranking.number, ranking.total, ranking.dots.len()),
                (frame.number, all.len(), most.min(all.len()))
            );
            for (ranked, dot) in ranking.dots.iter().zip(all) {
                let critical = Critical { edge: dot.edge.map(id), birth: dot.birth, death: dot.death };
                assert_eq!((ranked.critical, ranked.hole), (critical, frame.skeleton.hole(dot)));
            }
        }
    }

    /// The steps of all followers. Some have none.
    fn follow(&mut self) -> Vec<(usize, FrameStep)> {
        let last = self.followers.len() - 1;
        let skipped = !self.model.commits().is_multiple_of(2);
        let coming = self.followers.iter_mut().enumerate().filter(|(place, _)| *place < last || !skipped);
        coming.filter_map(|(place, (follower, _))| Some((place, self.pipeline.poll_step(follower)?))).collect()
    }

    /// Steps lead from one view of the whole skeleton to the next.
    fn check_steps(&mut self, frame: &Frame, steps: Vec<(usize, FrameStep)>) {
        for (place, step) in steps {
            let (follower, held) = &mut self.followers[place];
            let view = frame.view(follower.spec());
            let snapshot = Snapshot::new(&frame.skeleton, &view);
            let base = if step.from == 0 { Snapshot::default() } else { std::mem::take(held) };
            assert_eq!(step.diff, base.diff(&snapshot), "{:?}", step.spec);
            assert_eq!(step.selection, view.selection, "{:?}", step.spec);
            assert_eq!(step.checksum, snapshot.checksum(), "{:?}", step.spec);
            assert_eq!((step.components, step.cycles), (view.components, view.cycles), "{:?}", step.spec);
            assert_eq!(
                (step.number, step.points, step.vertices),
                (frame.number, frame.points, snapshot.vertices.len())
            );
            *held = snapshot;
        }
    }

    /// An id belongs to one lifetime, is never used again, and grows in order of first appearance.
    fn check_ids(&mut self, frame: &Frame) {
        let vertices = frame.skeleton.vertices();
        let lifetimes = self.model.committed().iter();
        assert_eq!(vertices.len(), lifetimes.len(), "number of vertices");
        for ((id, at), life) in vertices.iter().zip(lifetimes) {
            assert_eq!(at, life.at, "vertices stand in order of first appearance");
            assert_eq!(*self.ids.entry(life.number).or_insert(id), id, "a vertex keeps its id");
        }
        assert!(self.ids.values().is_sorted_by(|a, b| a < b), "ids rise and are never given twice");
    }
}

impl fmt::Debug for Script {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "\n    #[test]\n    fn pasted_from_a_failure() {{")?;
        writeln!(f, "        run(&Script {{\n            kept: Kept::{:?},", self.kept)?;
        writeln!(f, "            resolution: {:?},\n            steps: vec![", self.resolution)?;
        for step in &self.steps {
            match step {
                Insert(time, points) => writeln!(f, "                Insert({time:?}, vec!{}),", Literal(points))?,
                Retract(points) => writeln!(f, "                Retract(vec!{}),", Literal(points))?,
                other => writeln!(f, "                {other:?},")?,
            }
        }
        writeln!(f, "            ],\n        }});\n    }}")
    }
}

/// Points as Rust code, including NaN and infinities.
struct Literal<'a>(&'a [Point]);

impl fmt::Display for Literal<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = |v: f64| match v {
            f64::INFINITY => "f64::INFINITY".to_owned(),
            f64::NEG_INFINITY => "-f64::INFINITY".to_owned(),
            v if v.is_nan() => "f64::NAN".to_owned(),
            v => format!("{v:?}"),
        };
        let points: Vec<String> = self.0.iter().map(|&[x, y]| format!("[{}, {}]", number(x), number(y))).collect();
        write!(f, "[{}]", points.join(", "))
    }
}
