//! Tests of streams in R^d: random scripts against a model of the window and skeletons from scratch.

use std::num::{NonZeroU32, NonZeroU64};

use proptest::prelude::*;
use proptest::sample::Index;

use super::*;
use crate::topology::frames::Snapshot;
use crate::topology::skeleton::{Edge, Killer, View, ViewSpec};

#[derive(Clone, Debug)]
enum Action {
    /// A point, and how far its event time is from that of the point before.
    Feed(Vec<f64>, f64),
    /// Points that wait for one commit, without times.
    Stage(Vec<Vec<f64>>),
    /// One of the points that are there.
    Retract(Index),
    RetractAll,
    Time(f64),
    Commit,
}

/// Few different points: lattices, lines, and a few in general position.
fn points(dimension: usize) -> impl Strategy<Value = Vec<f64>> {
    let lattice = prop::collection::vec((0..3).prop_map(f64::from), dimension);
    let line = (-4..5).prop_map(move |t| (1..=dimension).map(|axis| f64::from(t) * axis as f64 * 0.5).collect());
    let scattered = (0..40_u32).prop_map(move |seed| {
        (1..=dimension as u32).map(|axis| f64::from((seed * seed * 37 + seed * axis * 11) % 101) / 25.0).collect()
    });
    prop_oneof![4 => lattice, 2 => line, 4 => scattered]
}

fn actions(dimension: usize) -> impl Strategy<Value = Vec<Action>> {
    let points = move || points(dimension);
    let action = prop_oneof![
        30 => (points(), -0.5..1.0).prop_map(|(point, time)| Action::Feed(point, time)),
        3 => prop::collection::vec(points(), 1..9).prop_map(Action::Stage),
        8 => any::<Index>().prop_map(Action::Retract),
        1 => Just(Action::RetractAll),
        2 => (0.0..3.0).prop_map(Action::Time),
        8 => Just(Action::Commit),
    ];
    prop::collection::vec(action, 1..90)
}

fn windows() -> impl Strategy<Value = Window> {
    let of = |count| NonZeroU64::new(count).expect("counts are from 1");
    prop_oneof![
        Just(Window::All),
        (1..25_u64).prop_map(move |count| Window::Points(of(count))),
        (1..4_u64).prop_map(move |count| Window::Frames(of(count))),
        (0.5..8.0).prop_map(Window::Time),
    ]
}

fn metrics() -> impl Strategy<Value = Metric> {
    prop::sample::select(vec![Metric::Euclidean, Metric::Manhattan, Metric::Chebyshev, Metric::Angular])
}

/// What a window should hold: points with their frames or event times, in order of arrival.
struct Model {
    window: Window,
    points: Vec<(Vec<f64>, f64)>,
    frame: u64,
    newest: f64,
}

impl Model {
    fn feed(&mut self, point: Vec<f64>, time: f64) {
        let key = if let Window::Time(_) = self.window { time } else { self.frame as f64 };
        self.newest = self.newest.max(time);
        self.points.push((point, key));
        self.expire();
    }

    fn expire(&mut self) {
        match self.window {
            Window::Points(most) => drop(self.points.drain(..self.points.len().saturating_sub(most.get() as usize))),
            Window::Time(length) => self.points.retain(|(_, time)| *time >= self.newest - length),
            Window::All | Window::Frames(_) => {}
        }
    }

    fn retract(&mut self, point: &[f64]) {
        let at_it = self.points.iter().enumerate().filter(|(_, (other, _))| other == point);
        let oldest = at_it.min_by(|(_, (_, a)), (_, (_, b))| a.total_cmp(b)).map(|(place, _)| place);
        self.points.remove(oldest.expect("only points that are there are retracted"));
    }

    fn commit(&mut self) {
        if let Window::Frames(frames) = self.window {
            let first = (self.frame + 1).saturating_sub(frames.get()) as f64;
            self.points.retain(|(_, frame)| *frame >= first);
        }
        self.frame += 1;
    }
}

/// A skeleton by coordinates, whatever its ids.
type Named = (Vec<[Vec<u64>; 2]>, Vec<([Vec<u64>; 2], Option<[Vec<u64>; 2]>, u64, u64)>);

fn named(skeleton: &Skeleton) -> Named {
    let bits = |end: u32| skeleton.vertices().coordinates(end).iter().map(|value| value.to_bits()).collect();
    let name = |edge: Edge| {
        let mut ends = edge.map(bits);
        ends.sort_unstable();
        ends
    };
    let killer = |killer| if let Killer::Edge(edge) = killer { Some(name(edge)) } else { None };
    let mut tree: Vec<_> = skeleton.tree().iter().map(|&edge| name(edge)).collect();
    let dots = skeleton.dots().iter();
    let mut dots: Vec<_> =
        dots.map(|dot| (name(dot.edge), killer(dot.killer), dot.birth.to_bits(), dot.death.to_bits())).collect();
    tree.sort_unstable();
    dots.sort_unstable();
    (tree, dots)
}

/// A follower with what its consumer has.
struct Consumer {
    follower: Follower,
    held: Snapshot,
}

impl Consumer {
    fn new(spec: ViewSpec) -> Self {
        Self { follower: Follower::new(spec), held: Snapshot::default() }
    }

    /// Polls a step, and compares with the view of a skeleton from scratch.
    fn follow(&mut self, pipeline: &mut SpacePipeline) -> Result<(), TestCaseError> {
        let step = pipeline.poll_step(&mut self.follower).expect("a frame was committed");
        prop_assert!(pipeline.poll_step(&mut self.follower).is_none());
        let held = if step.from == 0 { &Snapshot::default() } else { &self.held };
        self.held = held.apply(&step.diff).map_err(|error| TestCaseError::fail(error.to_string()))?;
        let (points, names) = pipeline.space();
        let reference = Skeleton::of_space(&points, &names, pipeline.threshold, &mut Workspace::default());
        let wanted = Snapshot::new(&reference, &View::new(&reference, step.spec));
        prop_assert_eq!(&self.held, &wanted);
        prop_assert_eq!(step.checksum, wanted.checksum());
        pipeline.check(&self.follower).map_err(|contradiction| TestCaseError::fail(contradiction.to_string()))
    }
}

fn play(options: SpaceOptions, script: Vec<Action>) -> Result<(), TestCaseError> {
    let mut pipeline = SpacePipeline::new(options).expect("the options suit each other");
    let mut model = Model { window: options.window, points: Vec::new(), frame: 1, newest: f64::NEG_INFINITY };
    let rank = NonZeroU32::MIN;
    let specs = [ViewSpec::Full, ViewSpec::Reduced { alpha: 0.6 }, ViewSpec::Derived { k: rank, l: rank }];
    let mut consumers = specs.map(Consumer::new);
    let (mut now, mut commits) = (0.0, 0);
    for action in script {
        match action {
            Action::Feed(point, later) => {
                now += later;
                match pipeline.feed_point(&point, Some(now)) {
                    Ok(_) => model.feed(point, now),
                    Err(refusal) => {
                        prop_assert!(
                            matches!(refusal, Refusal::TooLate { .. } | Refusal::Point(PointError::NoDirection)),
                            "{}",
                            refusal
                        );
                        now -= later;
                    }
                }
            }
            Action::Stage(points) => {
                let mut staging = Staging::default();
                let points: Vec<_> = points
                    .into_iter()
                    .filter(|point| pipeline.stage_point(&mut staging, point, None).is_ok())
                    .collect();
                // A time beyond the window would not be believed at once.
                now = now.max(model.newest);
                let mut refused = 0;
                pipeline.feed_staged(&mut staging, Some(now), &mut |_, _| refused += 1);
                prop_assert_eq!(refused, 0);
                points.into_iter().for_each(|point| model.feed(point, now));
            }
            Action::Retract(index) if !model.points.is_empty() => {
                let point = index.get(&model.points).0.clone();
                prop_assert_eq!(pipeline.feed_retraction(&point), Ok(()));
                model.retract(&point);
            }
            Action::Retract(_) => {
                let point = vec![7.0; options.dimension.unwrap_or(1)];
                prop_assert!(matches!(pipeline.feed_retraction(&point), Err(Refusal::Absent(_))));
            }
            Action::RetractAll => {
                for (point, _) in std::mem::take(&mut model.points) {
                    prop_assert_eq!(pipeline.feed_retraction(&point), Ok(()));
                }
            }
            Action::Time(later) => {
                now = now.max(model.newest) + later;
                prop_assert_eq!(pipeline.feed_time(now), Ok(()));
                model.newest = now;
                model.expire();
            }
            Action::Commit => {
                model.commit();
                commits += 1;
                prop_assert_eq!(pipeline.commit(Some(now)), commits);
                pipeline.check_invariants();
                prop_assert_eq!(pipeline.point_count(), model.points.len() as u64);
                // One consumer misses every third frame.
                let awake = if commits % 3 == 0 { 2 } else { 3 };
                for consumer in &mut consumers[..awake] {
                    consumer.follow(&mut pipeline)?;
                }
                prop_assert_eq!(pipeline.computed(), commits);
                from_scratch(&mut pipeline, options, &model)?;
            }
        }
    }
    Ok(())
}

/// The frame is that of the model's points, fed in another order.
fn from_scratch(pipeline: &mut SpacePipeline, options: SpaceOptions, model: &Model) -> Result<(), TestCaseError> {
    let frame = pipeline.poll_frame().expect("a frame was committed");
    let mut fresh = SpacePipeline::new(SpaceOptions { window: Window::All, ..options }).expect("as before");
    let mut points: Vec<&[f64]> = model.points.iter().map(|(point, _)| &point[..]).collect();
    points.sort_by(|a, b| b.iter().rev().partial_cmp(a.iter().rev()).expect("coordinates are finite"));
    prop_assert_eq!(fresh.feed_points(&points, None), []);
    fresh.commit(None);
    let wanted = fresh.poll_frame().expect("a frame was committed");
    prop_assert_eq!(named(&frame.skeleton), named(&wanted.skeleton));
    prop_assert_eq!(frame.points, wanted.points);
    Ok(())
}

fn scripts() -> impl Strategy<Value = (SpaceOptions, Vec<Action>)> {
    let threshold = prop_oneof![3 => Just(None), 1 => (0.3..1.5).prop_map(Some)];
    let dimension = prop::sample::select(vec![1_usize, 3]);
    (metrics(), windows(), threshold, dimension).prop_flat_map(|(metric, window, threshold, dimension)| {
        let options = SpaceOptions { metric, window, threshold, dimension: Some(dimension), ..Default::default() };
        (Just(options), actions(dimension))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn steps_lead_to_what_is_computed_from_scratch((options, script) in scripts()) {
        play(options, script)?;
    }
}

#[test]
fn a_stream_has_the_dimension_of_its_first_point() {
    let mut pipeline = SpacePipeline::new(SpaceOptions::default()).unwrap();
    assert!(matches!(
        pipeline.feed_point(&[1.0, f64::NAN], None),
        Err(Refusal::Point(PointError::Coordinate { number: 2, .. }))
    ));
    assert_eq!(pipeline.dimension(), None);
    pipeline.feed_point(&[1.0, 2.0, 3.0], None).unwrap();
    let other = Err(PointError::OtherDimension { found: 2, expected: 3 }.into());
    assert_eq!(pipeline.feed_point(&[1.0, 2.0], None), other);
    assert_eq!(pipeline.stage_point(&mut Staging::default(), &[1.0, 2.0], None), other);
    assert_eq!((pipeline.dimension(), pipeline.point_count()), (Some(3), 1));
}

#[test]
fn points_without_distances_are_refused() {
    let of = |metric| SpaceOptions { metric, resolution: Some(1.0), ..Default::default() };
    let mut sphere = SpacePipeline::new(of(Metric::Haversine)).unwrap();
    assert_eq!(sphere.feed_point(&[10.0, 91.0], None), Err(PointError::Latitude(91.0).into()));
    assert_eq!(sphere.feed_point(&[10.0], None), Err(PointError::OtherDimension { found: 1, expected: 2 }.into()));
    let mut angles = SpacePipeline::new(of(Metric::Angular)).unwrap();
    assert_eq!(angles.feed_point(&[0.25, -0.25], None), Err(PointError::NoDirection.into()));
    let wrong = |metric, dimension| SpacePipeline::new(SpaceOptions { dimension: Some(dimension), ..of(metric) }).err();
    assert_eq!(wrong(Metric::Haversine, 3), Some(SpaceError::NotOnTheSphere(3)));
    assert_eq!(wrong(Metric::Euclidean, 4097), Some(SpaceError::Dimension(4097)));
}

#[test]
fn points_beyond_the_most_vertices_are_refused() {
    let mut pipeline = SpacePipeline::new(SpaceOptions { max_vertices: 2, ..Default::default() }).unwrap();
    let refused = pipeline.feed_points(&[[1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [1.0, 0.0]], None);
    assert_eq!(refused, [(2, Refusal::TooMany(2))]);
    assert!(refused[0].1.to_string().contains("raise max-vertices"));
    pipeline.commit(None);
    let frame = pipeline.poll_frame().unwrap();
    assert_eq!((frame.skeleton.vertices().len(), frame.points), (2, 3));
}

#[test]
fn frames_are_computed_once_and_memory_is_counted() {
    let mut pipeline = SpacePipeline::new(SpaceOptions::default()).unwrap();
    assert!(pipeline.poll_frame().is_none() && pipeline.poll_dots(5).dots.is_empty());
    let circle = (0..40).map(|i| f64::from(i).to_radians() * 9.0).map(|angle| [angle.cos(), angle.sin(), 1.0]);
    assert_eq!(pipeline.feed_points(&circle.collect::<Vec<_>>(), None), []);
    pipeline.commit(Some(7.0));
    assert_eq!(pipeline.computed(), 0);
    let before = (pipeline.bytes(), pipeline.bytes_to_compute());
    let ranking = pipeline.poll_dots(5);
    assert_eq!(ranking.dots.len(), 1);
    let mut simplified = SimplifiedFollower::new(ViewSpec::Full, Some(0.2));
    let step = pipeline.poll_simplified(&mut simplified).unwrap();
    assert_eq!((step.cycles, step.time, step.points), (1, Some(7.0), 40));
    assert!(pipeline.poll_simplified(&mut simplified).is_none());
    let frame = pipeline.poll_frame().unwrap();
    assert!(Arc::ptr_eq(&frame, pipeline.newest().unwrap()) && pipeline.poll_frame().is_none());
    assert_eq!((pipeline.computed(), pipeline.committed(), pipeline.vertex_count()), (1, 1, 40));
    assert_eq!(pipeline.bytes_to_compute(), 0);
    assert!(before.1 > 0 && pipeline.bytes() > before.0);
}

#[test]
fn one_place_under_two_names_is_one_vertex() {
    let mut sphere = SpacePipeline::new(SpaceOptions { metric: Metric::Haversine, ..Default::default() }).unwrap();
    assert_eq!(sphere.feed_points(&[[-180.0, 0.0], [180.0, 0.0], [0.0, 0.0]], None), []);
    sphere.commit(None);
    let mut consumer = Consumer::new(ViewSpec::Full);
    consumer.follow(&mut sphere).unwrap();
    assert_eq!(consumer.held.vertices.ids(), [0, 2].map(VertexId));
    sphere.feed_retraction(&[-180.0, 0.0]).unwrap();
    sphere.commit(None);
    consumer.follow(&mut sphere).unwrap();
    assert_eq!(consumer.held.vertices.ids(), [1, 2].map(VertexId));
    assert_eq!(consumer.held.tree, [[1, 2].map(VertexId)]);
}
