//! What consumers receive: every kind of view, frame by frame, compared with the library on the same points. Each frame
//! is computed once for all consumers.

use std::num::{NonZeroU32, NonZeroU64};
use std::sync::Arc;

use hopes::topology::{self, Options, Pipeline, RankedDot, ViewSpec, simplify};
use hopes_protocol::*;

use crate::common::peers::{Consumer, DERIVED, Daemon, FULL, Point, Producer, open, points, subscribe};
use crate::common::random::Random;

const fn plain(cut: Cut) -> View {
    View { cut, simplify: Simplify::No }
}

const VIEWS: [View; 9] = [
    FULL,
    DERIVED,
    plain(Cut::Derived(2, 3)),
    plain(Cut::Reduced(0.05)),
    plain(Cut::Reduced(0.0)),
    View { cut: Cut::Full, simplify: Simplify::Below(0.03) },
    View { cut: Cut::Reduced(0.05), simplify: Simplify::AtScale },
    View { cut: Cut::Derived(1, 1), simplify: Simplify::AtScale },
    View { cut: Cut::Derived(2, 1), simplify: Simplify::Below(0.02) },
];

/// The library's result for the points that a daemon was sent, frame by frame.
struct Reference {
    pipeline: Pipeline,
    /// The newest frame.
    frame: Option<Arc<topology::Frame>>,
}

impl Reference {
    fn new(window: u64) -> Self {
        let window = topology::Window::Points(NonZeroU64::new(window).unwrap());
        Self { pipeline: Pipeline::new(Options { window, ..Options::default() }), frame: None }
    }

    fn commit(&mut self, points: &[Point]) {
        for &(x, y) in points {
            self.pipeline.feed_point(x, y, None).unwrap();
        }
        self.pipeline.commit(None);
        self.frame = self.pipeline.poll_frame();
    }

    fn frame(&self) -> &topology::Frame {
        self.frame.as_ref().expect("a frame was committed")
    }

    fn snapshot(&self, view: View) -> (topology::Snapshot, topology::View) {
        let shown = self.frame().view(spec(view.cut));
        let skeleton = &self.frame().skeleton;
        let simplified =
            |threshold| topology::Snapshot::of_simplified(skeleton, &simplify(skeleton, &shown, threshold));
        let snapshot = match view.simplify {
            Simplify::No => topology::Snapshot::new(skeleton, &shown),
            Simplify::AtScale => simplified(shown.scale()),
            Simplify::Below(threshold) => simplified(threshold),
        };
        (snapshot, shown)
    }

    #[track_caller]
    fn check_consumer(&self, mirror: &Mirror) {
        let frame = mirror.frame().expect("there is a frame");
        let (snapshot, shown) = self.snapshot(frame.view);
        let vertices =
            snapshot.vertices.ids().iter().zip(snapshot.vertices.positions()).map(|(id, at)| (id.0, at.into()));
        assert!(mirror.vertices().iter().map(|(&id, &at)| (id, at)).eq(vertices), "{frame:?}");
        let edges = snapshot.tree.iter().map(|[a, b]| (a.0, b.0));
        assert!(mirror.edges().iter().copied().eq(edges), "{frame:?}");
        let critical = snapshot.critical.iter().map(|dot| ((dot.edge[0].0, dot.edge[1].0), (dot.birth, dot.death)));
        assert!(mirror.critical().iter().map(|(&edge, &label)| (edge, label)).eq(critical), "{frame:?}");
        assert_eq!(mirror.checksum(), snapshot.checksum().0, "{frame:?}");
        let selection = shown.selection.as_ref();
        let expected = FrameInfo {
            number: self.frame().number,
            time: None,
            points: self.frame().points,
            vertices: self.frame().skeleton.vertices().len() as u64,
            rejected: 0,
            view: frame.view,
            ds: selection.and_then(|selection| selection.ds),
            vs: selection.map(|selection| selection.vs).filter(|vs| vs.is_finite()),
            components: shown.components as u64,
            cycles: shown.cycles as u64,
        };
        assert_eq!(*frame, expected);
    }

    fn dots(&mut self, most: usize) -> (u64, Vec<Dot>) {
        let ranking = self.pipeline.poll_dots(most);
        let dot = |RankedDot { critical, hole, .. }: &RankedDot| {
            let hole = hole.expect("a hole of the plane has a centre");
            Dot {
                edge: (critical.edge[0].0, critical.edge[1].0),
                birth: critical.birth,
                death: critical.death,
                center: hole.center.into(),
                radius: hole.radius,
            }
        };
        (ranking.total as u64, ranking.dots.iter().map(dot).collect())
    }
}

fn spec(cut: Cut) -> ViewSpec {
    let number = |number| NonZeroU32::new(number).unwrap();
    match cut {
        Cut::Full => ViewSpec::Full,
        Cut::Reduced(alpha) => ViewSpec::Reduced { alpha },
        Cut::Derived(k, l) => ViewSpec::Derived { k: number(k), l: number(l) },
    }
}

fn windowed(daemon: &Daemon, points: u64) -> Producer {
    Producer::open(daemon.client(), Open { window: Some(Window::Points(points)), ..open("cam") })
}

/// Two rings that turn, and some noise.
fn cloud(random: &mut Random, count: usize, frame: u32) -> Vec<Point> {
    let ring = |random: &mut Random| {
        let (angle, x) = (random.unit() * 6.3, if random.unit() < 0.5 { 0.0 } else { 0.8 + f64::from(frame) * 0.01 });
        (x + 0.3 * angle.cos() + 0.02 * random.unit(), 0.3 * angle.sin() + 0.02 * random.unit())
    };
    (0..count).map(|at| if at % 8 == 0 { random.point().into() } else { ring(random) }).collect()
}

#[test]
fn every_kind_of_view_equals_the_librarys_in_every_frame() {
    let daemon = Daemon::start("");
    let mut random = Random::new(20);
    let mut reference = Reference::new(400);
    let mut producer = windowed(&daemon, 400);
    let mut consumers: Vec<Consumer> = VIEWS.iter().map(|&view| daemon.consumer("cam", view)).collect();
    for frame in 1..=25 {
        // Small and large changes: computed in tiles, and in one pass.
        let cloud = cloud(&mut random, if frame % 10 == 1 { 400 } else { 12 }, frame);
        reference.commit(&cloud);
        assert_eq!(producer.frame(&cloud), u64::from(frame));
        for consumer in &mut consumers {
            if frame == 1 {
                consumer.expect_snapshot(Cause::Start);
            } else {
                consumer.expect_diff(frame.into());
            }
            reference.check_consumer(&consumer.mirror);
        }
    }
    let stream = daemon.stream("cam");
    assert_eq!((stream.computed, stream.info.frame, stream.lagged), (25, 25, 0));
    daemon.stop();
}

#[test]
fn a_frame_is_computed_once_for_all_consumers_and_never_without_one() {
    let daemon = Daemon::start("");
    let mut random = Random::new(21);
    let mut producer = windowed(&daemon, 300);
    for _ in 0..10 {
        producer.frame(&points(&mut random, 50));
    }
    assert_eq!(daemon.stream("cam").computed, 0, "nobody looks");
    let mut consumers: Vec<Consumer> = (0..20).map(|number| daemon.consumer("cam", VIEWS[number % 5])).collect();
    for consumer in &mut consumers {
        consumer.expect_snapshot(Cause::Start);
    }
    for _ in 0..10 {
        let frame = producer.frame(&points(&mut random, 20));
        for consumer in &mut consumers {
            consumer.expect_diff(frame);
        }
    }
    let stream = daemon.stream("cam");
    assert_eq!((stream.computed, stream.info.frame, stream.info.consumers), (11, 20, 20));
    daemon.stop();
}

/// The frame of the next message, a heartbeat.
fn heartbeat(consumer: &mut Consumer) -> u64 {
    match consumer.client.next() {
        Some((Consumer::CHANNEL, Message::Heartbeat(heartbeat))) => heartbeat.frame,
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_most_persistent_dots_are_sent_when_they_change() {
    let daemon = Daemon::start("");
    let mut random = Random::new(22);
    let mut reference = Reference::new(300);
    let mut producer = windowed(&daemon, 300);
    let consumer = |dots| Consumer::subscribe(daemon.client(), Subscribe { dots, ..subscribe("cam", DERIVED) });
    let mut consumers = [(3, consumer(DotsWanted::Top(3))), (usize::MAX, consumer(DotsWanted::All))];
    let mut sent = 0;
    for frame in 1..=15 {
        let cloud = cloud(&mut random, if frame == 1 { 300 } else { 8 }, frame);
        reference.commit(&cloud);
        producer.frame(&cloud);
        for (most, consumer) in &mut consumers {
            consumer.follow_to(frame.into());
            let expected = reference.dots(*most);
            let has = |consumer: &Consumer| consumer.dots.as_ref().map(|dots| (dots.total, dots.dots.clone()));
            if has(consumer).as_ref() != Some(&expected) {
                assert!(matches!(consumer.next(), Message::Dots(_)), "dots have changed");
                sent += 1;
            }
            assert_eq!(has(consumer), Some(expected));
        }
    }
    assert!(sent > 15, "{sent}");
    // Without a change a heartbeat says so. If other dots are asked for, they come after the snapshot.
    producer.frame(&[]);
    for (most, mut consumer) in consumers {
        consumer.expect_diff(16);
        assert_eq!(heartbeat(&mut consumer), 16);
        assert_eq!(consumer.client.drain(), []);
        let (view, dots) = (FULL, if most == 3 { DotsWanted::Top(1) } else { DotsWanted::No });
        consumer.client.send(Consumer::CHANNEL, ChangeView { view, dots });
        consumer.expect_snapshot(Cause::ViewChanged);
        if most == 3 {
            assert!(matches!(consumer.next(), Message::Dots(dots) if dots.dots == reference.dots(1).1));
        }
        assert_eq!(consumer.client.drain(), []);
    }
    daemon.stop();
}

#[test]
fn dots_are_sent_once_even_if_there_are_none() {
    let daemon = Daemon::start("");
    let mut producer = daemon.producer("cam");
    let wanted = Subscribe { dots: DotsWanted::All, ..subscribe("cam", FULL) };
    let mut consumer = Consumer::subscribe(daemon.client(), wanted);
    producer.frame(&[(0.0, 0.0)]);
    consumer.expect_snapshot(Cause::Start);
    assert!(matches!(consumer.next(), Message::Dots(dots) if dots.total == 0 && dots.frame == 1));
    producer.frame(&[(1.0, 0.0)]);
    consumer.expect_diff(2);
    assert_eq!(heartbeat(&mut consumer), 2);
    assert_eq!(consumer.client.drain(), []);
    daemon.stop();
}

#[test]
fn invalid_views_are_refused() {
    let daemon = Daemon::start("--stream cam");
    let mut consumer = daemon.consumer("cam", FULL);
    let simplified = |cut, simplify| View { cut, simplify };
    for view in [
        plain(Cut::Reduced(-1.0)),
        plain(Cut::Reduced(f64::NAN)),
        plain(Cut::Reduced(f64::INFINITY)),
        plain(Cut::Derived(0, 1)),
        plain(Cut::Derived(1, 0)),
        simplified(Cut::Full, Simplify::AtScale),
        simplified(Cut::Full, Simplify::Below(-0.5)),
        simplified(Cut::Full, Simplify::Below(f64::NAN)),
    ] {
        assert_eq!(consumer.client.is_refused(9, subscribe("cam", view)), ErrorCode::BadOptions as u16, "{view:?}");
        let change = ChangeView { view, dots: DotsWanted::No };
        assert_eq!(consumer.client.is_refused(Consumer::CHANNEL, change), ErrorCode::BadOptions as u16, "{view:?}");
    }
    daemon.producer("cam").frame(&[(0.0, 0.0)]);
    assert_eq!(consumer.expect_snapshot(Cause::Start), 1, "the subscription goes on");
    daemon.stop();
}
