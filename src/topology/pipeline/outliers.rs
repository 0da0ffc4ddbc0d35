//! The outliers of a pipeline: told apart when a frame is computed, and set aside in the cloud.
//!
//! In: the change of the cloud.
//! Out: the change of the points that pass; the outliers, whole or from frame to frame.
//! Invariants: outliers keep their slots and ids, so a point that comes back from among them is the vertex that it was.
//! Nothing is computed for a frame that nobody asks for.
//! Must not know: how outliers are told apart, triangulations.

use super::Pipeline;
use super::check::Contradiction;
use crate::topology::cloud::{Cloud, CloudChange, Slot, VertexId, Vertices};
use crate::topology::declutter::{Declutter, Decluttered, Filter};

/// The outliers of a stream.
#[derive(Clone, Debug)]
pub(super) struct Outliers {
    rule: Declutter,
    filter: Filter,
    /// Their change from the frame computed before.
    change: OutlierStep,
}

/// What changed among the outliers between two frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OutlierStep {
    /// The number of the frame it leads to.
    pub number: u64,
    /// The number of the frame it starts from; 0 if all outliers are new.
    pub from: u64,
    /// New outliers, by id.
    pub added: Vertices,
    /// Outliers that are gone, or pass now.
    pub removed: Vec<VertexId>,
}

impl Outliers {
    pub fn boxed(rule: Declutter) -> Box<Self> {
        Box::new(Self { rule, filter: Filter::new(rule), change: OutlierStep::default() })
    }

    /// Follows a change of the cloud between two frames. Returns the change of the points that pass.
    pub fn follow(&mut self, cloud: &mut Cloud, change: &CloudChange, [from, number]: [u64; 2]) -> CloudChange {
        let sides = self.filter.follow(cloud, change);
        // What has vanished from the window has left its place in the cloud by itself.
        sides.passing.appeared.iter().for_each(|&slot| cloud.set_aside(slot, false));
        sides.outliers.appeared.iter().for_each(|&slot| cloud.set_aside(slot, true));
        let removed = sides.outliers.vanished.iter().map(|&slot| cloud.id(slot)).collect();
        self.change = OutlierStep { number, from, added: vertices(cloud, &sides.outliers.appeared), removed };
        sides.passing
    }

    pub fn report(&self) -> Decluttered {
        self.filter.report()
    }

    pub fn bytes(&self) -> usize {
        self.filter.bytes()
    }

    /// Their slots, by id.
    fn slots(&self, cloud: &Cloud) -> Vec<Slot> {
        let mut slots = self.filter.outliers();
        slots.sort_unstable_by_key(|&slot| cloud.id(slot));
        slots
    }

    /// Compares them with those of a filter that knows nothing of earlier frames.
    pub fn check(&self, cloud: &Cloud, frame: u64) -> Result<(), Contradiction> {
        let mut filter = Filter::new(self.rule);
        let all = CloudChange { appeared: cloud.all_vertices().map(|(slot, _)| slot).collect(), ..Default::default() };
        let wanted = filter.follow(cloud, &all);
        let (told, report) = (self.slots(cloud), self.report());
        if (&told, report) == (&wanted.outliers.appeared, filter.report()) {
            return Ok(());
        }
        let what = format!(
            "it has {} outliers, by {report:?}, and should have {}, by {:?}",
            told.len(),
            wanted.outliers.appeared.len(),
            filter.report()
        );
        Err(Contradiction { frame, what })
    }
}

impl Pipeline {
    /// What changed among the outliers from a frame to the newest one. If `from` is not the frame that was computed
    /// before it, all of its outliers are new. Takes time in proportion to the answer; of all outliers, in proportion
    /// to the cloud.
    ///
    /// ```
    /// use hopes::topology::{Declutter, Options, Pipeline};
    ///
    /// let mut pipeline = Pipeline::new(Options { declutter: Some(Declutter::default()), ..Options::default() });
    /// let ring = |i: u32| [(f64::from(i) * 0.1).cos(), (f64::from(i) * 0.1).sin()];
    /// pipeline.feed_points(&(0..63).map(ring).collect::<Vec<_>>(), None);
    /// pipeline.feed_point(0.1, 0.2, None)?;
    /// pipeline.commit(None);
    /// let frame = pipeline.poll_frame().expect("a frame was committed");
    /// assert_eq!((frame.points, frame.skeleton.vertices().len()), (64, 63));
    /// assert_eq!(frame.decluttered.map(|report| report.filtered), Some(1));
    /// assert_eq!(pipeline.poll_outliers(0).added.xy(0), [0.1, 0.2]);
    /// # Ok::<(), hopes::topology::Refusal>(())
    /// ```
    pub fn poll_outliers(&mut self, from: u64) -> OutlierStep {
        self.reach();
        let number = self.progress.reached;
        let Some(outliers) = self.outliers.as_deref().filter(|_| from < number) else {
            return OutlierStep { number, from, ..OutlierStep::default() };
        };
        if (outliers.change.from, outliers.change.number) == (from, number) {
            return outliers.change.clone();
        }
        let added = vertices(&self.cloud, &outliers.slots(&self.cloud));
        OutlierStep { number, from: 0, added, removed: Vec::new() }
    }
}

fn vertices(cloud: &Cloud, slots: &[Slot]) -> Vertices {
    slots.iter().map(|&slot| cloud.vertex(slot)).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::f64::consts::TAU;
    use std::num::{NonZeroU32, NonZeroU64};

    use proptest::prelude::*;

    use super::*;
    use crate::topology::base::on_threads;
    use crate::topology::cloud::Window;
    use crate::topology::frames::{Diff, Follower, Snapshot};
    use crate::topology::skeleton::{View, ViewSpec};
    use crate::topology::testing::skeleton_of;
    use crate::topology::{Options, TrackOptions, TrackRule, Tracker};

    type Point = [f64; 2];

    const SPECS: [ViewSpec; 3] = [
        ViewSpec::Full,
        ViewSpec::Reduced { alpha: 0.3 },
        ViewSpec::Derived { k: NonZeroU32::MIN, l: NonZeroU32::MIN },
    ];

    /// Points on two rings, one of them denser, clutter, and points that come again and again.
    fn points() -> impl Strategy<Value = Vec<Point>> {
        let ring = |center: f64, radius: f64| {
            (0.0..1.0, 0.97..1.03).prop_map(move |(turn, noise): (f64, f64)| {
                let (sin, cos) = (turn * TAU).sin_cos();
                [center + radius * noise * cos, radius * noise * sin]
            })
        };
        let clutter = (-2.0..7.0, -2.0..2.0).prop_map(|(x, y)| [x, y]);
        let again = (0..5, 0..5).prop_map(|(x, y)| [f64::from(x), f64::from(y) - 2.0]);
        let point = prop_oneof![8 => ring(0.0, 1.0), 4 => ring(4.0, 1.5), 2 => clutter, 1 => again];
        prop::collection::vec(point, 0..14)
    }

    /// A stream, and what its followers have.
    struct Stream {
        pipeline: Pipeline,
        views: Vec<(Follower, Snapshot)>,
        tracker: Tracker,
        outliers: BTreeMap<VertexId, Point>,
        frame: u64,
    }

    impl Stream {
        fn new(pipeline: Pipeline) -> Self {
            let tracker = Tracker::new(TrackOptions::new(TrackRule::Above(0.1)));
            let views = SPECS.map(|spec| (Follower::new(spec), Snapshot::default())).into();
            Self { pipeline, views, tracker, outliers: BTreeMap::new(), frame: 0 }
        }

        fn feed(&mut self, points: &[Point]) {
            self.pipeline.feed_points(points, None);
            self.pipeline.commit(None);
        }

        /// Follows the newest frame, and compares all with it as a whole, and with its points alone. Returns the diffs.
        fn follow(&mut self) -> Vec<Diff> {
            let mut diffs = Vec::new();
            for (follower, held) in &mut self.views {
                let step = self.pipeline.poll_step(follower).expect("there is a new frame");
                let base = if step.from == 0 { Snapshot::default() } else { std::mem::take(held) };
                *held = base.apply(&step.diff).expect("it starts from what is held");
                assert_eq!(held.checksum(), step.checksum);
                assert_eq!(self.pipeline.check(follower), Ok(()));
                diffs.push(step.diff);
            }
            self.pipeline.check_invariants();
            let frame = self.pipeline.poll_frame().expect("it was not given before");
            let vertices = frame.skeleton.vertices();
            let points: Vec<Point> = (0..vertices.len() as u32).map(|vertex| vertices.xy(vertex)).collect();
            let alone = skeleton_of(&points);
            assert_eq!((alone.tree(), alone.dots()), (frame.skeleton.tree(), frame.skeleton.dots()));
            for (follower, held) in &self.views {
                let view = View::new(&frame.skeleton, follower.spec());
                assert_eq!(*held, Snapshot::new(&frame.skeleton, &view));
            }
            self.follow_outliers();
            assert_eq!(frame.decluttered.map(|report| report.filtered), Some(self.outliers.len()));
            diffs
        }

        fn follow_outliers(&mut self) {
            let step = self.pipeline.poll_outliers(self.frame);
            if step.from == 0 {
                self.outliers.clear();
            }
            step.removed.iter().for_each(|id| assert!(self.outliers.remove(id).is_some()));
            for (place, &id) in (0..).zip(step.added.ids()) {
                assert_eq!(self.outliers.insert(id, step.added.xy(place)), None);
            }
            self.frame = step.number;
            let all = self.pipeline.poll_outliers(0);
            let told = all.added.ids().iter().zip(0..).map(|(&id, place)| (id, all.added.xy(place)));
            assert_eq!(self.outliers, told.collect());
            assert_eq!(self.pipeline.poll_outliers(self.frame).added.len(), 0, "nothing has changed since");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

        #[test]
        fn a_stream_without_outliers_is_that_of_its_other_points(
            first in prop::collection::vec(points(), 12),
            frames in prop::collection::vec(points(), 1..16),
            window in 90u64..200,
        ) {
            let window = Window::Points(NonZeroU64::new(window).unwrap());
            let options = Options { window, declutter: Some(Declutter::default()), ..Options::default() };
            let mut tiled = Stream::new(Pipeline::new(options).with_leaf(4));
            let mut late = Stream::new(Pipeline::new(options));
            let first = first.concat();
            for stream in [&mut tiled, &mut late] {
                stream.feed(&first);
            }
            on_threads(3, || tiled.follow());
            late.follow();
            let before: Vec<Snapshot> = tiled.views.iter().map(|(_, held)| held.clone()).collect();
            let mut runs = vec![Vec::new(); SPECS.len()];
            for (number, points) in frames.iter().enumerate() {
                for stream in [&mut tiled, &mut late] {
                    stream.feed(points);
                }
                let diffs = on_threads(3, || tiled.follow());
                runs.iter_mut().zip(diffs).for_each(|(run, diff)| run.push(diff));
                // The other stream skips frames of its views, and computes in one pass where that is faster.
                if number % 3 == 2 {
                    late.follow();
                    for (a, b) in tiled.views.iter().zip(&late.views) {
                        prop_assert_eq!(&a.1, &b.1);
                    }
                    prop_assert_eq!(&tiled.outliers, &late.outliers);
                }
                let [a, b] = [&mut tiled, &mut late].map(|stream| stream.pipeline.poll_tracks(&mut stream.tracker));
                prop_assert_eq!(a, b);
            }
            for ((before, run), (_, after)) in before.iter().zip(&runs).zip(&tiled.views) {
                prop_assert_eq!(&before.apply(&Diff::merged(run)).unwrap(), after);
            }
        }
    }

    #[test]
    fn a_point_that_gets_neighbours_is_the_vertex_that_it_was() {
        let ring: Vec<Point> = (0..63).map(|i| (f64::from(i) * 0.1).sin_cos().into()).collect();
        let options = Options { declutter: Some(Declutter::default()), ..Options::default() };
        let mut pipeline = Pipeline::new(options);
        pipeline.feed_points(&ring, None);
        let id = pipeline.feed_point(5.0, 0.2, None).unwrap();
        pipeline.commit(None);
        let frame = pipeline.poll_frame().unwrap();
        assert!(!frame.skeleton.vertices().ids().contains(&id));
        assert_eq!((frame.points, pipeline.vertex_count()), (64, 64), "it stays in the window");
        let neighbours: Vec<Point> = (0..63).map(|i| [5.0 + 0.01 * f64::from(i), 0.2 + 0.03 * f64::from(i)]).collect();
        pipeline.feed_points(&neighbours[1..], None);
        pipeline.commit(None);
        let frame = pipeline.poll_frame().unwrap();
        let place = frame.skeleton.vertices().ids().binary_search(&id).expect("it is back") as u32;
        assert_eq!(frame.skeleton.vertices().xy(place), [5.0, 0.2]);
        assert_eq!(pipeline.poll_outliers(1).removed, [id]);
    }

    #[test]
    fn nothing_is_filtered_before_a_frame_is_asked_for() {
        let mut pipeline = Pipeline::new(Options { declutter: Some(Declutter::default()), ..Options::default() });
        pipeline.feed_points(&[[0.0, 0.0], [1.0, 0.0]], None);
        pipeline.commit(None);
        assert_eq!(pipeline.outliers.as_ref().map(|outliers| outliers.change.number), Some(0));
        assert_eq!(pipeline.poll_outliers(0).number, 1);
        let mut plain = Pipeline::new(Options::default());
        plain.commit(None);
        assert_eq!(plain.poll_outliers(0), OutlierStep { number: 1, ..OutlierStep::default() });
        assert_eq!(plain.poll_frame().unwrap().decluttered, None);
    }
}
