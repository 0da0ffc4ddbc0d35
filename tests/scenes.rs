//! Scenes against the engine: the true holes are those of the skeleton of the points, and the events are consistent.

use std::collections::{BTreeMap, BTreeSet};

use hopes::scene::{Frame, Kind, OptionError, Options, Scene, TrueEvent, TrueHole};
use hopes::topology::{Options as Stream, Pipeline, RankedDot, Window};

/// Around an event that takes time, so many frames may show the number of holes before or after it.
fn transition(kind: Kind) -> u64 {
    match kind {
        Kind::Pinch | Kind::Fuse | Kind::Open | Kind::Mixed | Kind::CShapes | Kind::Cells => 4,
        _ => 0,
    }
}

/// The largest distance of a hole's centre from the true one, as a share of its radius.
const NEAR: f64 = 0.35;

fn scene(kind: Kind, options: Options) -> Scene {
    Scene::new(kind, options).unwrap()
}

fn play(kind: Kind, options: Options, count: usize) -> Vec<Frame> {
    let mut scene = scene(kind, options);
    (0..count).map(|_| scene.next_frame()).collect()
}

/// The dots of a cloud that are as persistent as a true hole.
fn dots(points: &[[f64; 2]], above: f64) -> Vec<RankedDot> {
    let mut pipeline = Pipeline::new(Stream { window: Window::All, ..Stream::default() });
    assert_eq!(pipeline.feed_points(points, None), []);
    pipeline.commit(None);
    let mut dots = pipeline.poll_dots(400).dots;
    dots.retain(|dot| dot.critical.death - dot.critical.birth >= above);
    dots
}

/// Whether one of the dots is this hole.
fn is_seen(hole: &TrueHole, dots: &[RankedDot]) -> bool {
    dots.iter().filter_map(|dot| dot.hole).any(|found| hole.distance(found.center) <= NEAR * hole.radius)
}

/// Counts of a comparison.
#[derive(Debug, Default)]
struct Tally {
    /// All compared frames, and those away from events.
    frames: u32,
    calm: u32,
    /// Frames with another number of dots than holes.
    differing: u32,
    /// Those among the frames away from events.
    differing_calm: u32,
    /// True holes in frames away from events, and those without a dot at their position.
    holes: u32,
    unseen: u32,
    /// The first wrong frame away from events.
    first: Option<u64>,
}

/// Compares every n-th frame of a scene with its truth.
fn compare(kind: Kind, options: Options, count: usize, every: usize, transition: u64) -> Tally {
    let above = scene(kind, options).above();
    let frames = play(kind, options, count + transition as usize);
    let events: Vec<u64> = frames.iter().filter(|frame| !frame.events.is_empty()).map(|frame| frame.number).collect();
    let is_at_once = |event| event == 1 || transition == 0;
    let mut tally = Tally::default();
    for frame in frames.iter().take(count).skip(every / 2).step_by(every) {
        let dots = dots(&frame.points, above);
        let is_calm = events.iter().all(|event| frame.number.abs_diff(*event) > transition || is_at_once(*event));
        let differs = dots.len() != frame.holes.len();
        tally.frames += 1;
        tally.differing += u32::from(differs);
        if is_calm {
            let unseen = frame.holes.iter().filter(|hole| !is_seen(hole, &dots)).count() as u32;
            tally.calm += 1;
            tally.differing_calm += u32::from(differs);
            tally.holes += frame.holes.len() as u32;
            tally.unseen += unseen;
            tally.first = tally.first.or((differs || unseen > 0).then_some(frame.number));
        }
    }
    tally
}

/// All options with which the skeleton must show the truth.
fn option_sets() -> impl Iterator<Item = Options> {
    let noises = [0.0, 0.1].into_iter();
    noises.flat_map(|noise| {
        [12, 16].into_iter().flat_map(move |points_per_radius| {
            [0.1, 1.0].map(|churn| Options { noise, points_per_radius, churn, ..Options::default() })
        })
    })
}

#[test]
fn the_truth_is_what_the_skeleton_shows() {
    for kind in Kind::ALL {
        for (number, options) in option_sets().enumerate() {
            // Different frames for each set of options, so that together they cover most of the scene.
            let tally = compare(kind, Options { seed: number as u64, ..options }, 400, 41 + number, transition(kind));
            let fault = (tally.differing_calm, tally.unseen);
            assert_eq!(fault, (0, 0), "{} {options:?}: {tally:?}", kind.name());
            assert!(tally.calm > 0, "{} has no calm frame", kind.name());
        }
    }
}

#[test]
fn the_truth_moves_with_the_camera() {
    for camera in ["pan:2", "turn:1", "zoom:0.5", "shake:3"] {
        let options = Options { camera: Some(camera.parse().unwrap()), ..Options::default() };
        for kind in [Kind::Concentric, Kind::Ellipses, Kind::CShapes, Kind::Cells, Kind::Open] {
            let tally = compare(kind, options, 400, 41, transition(kind));
            assert_eq!((tally.differing_calm, tally.unseen), (0, 0), "{} {camera}: {tally:?}", kind.name());
            let (moving, resting) = (play(kind, options, 50), play(kind, Options { camera: None, ..options }, 50));
            assert!(moving.iter().zip(&resting).all(|(a, b)| a.points.len() == b.points.len() && a.points != b.points));
        }
    }
}

#[test]
fn a_zooming_camera_makes_the_smallest_hole_smaller() {
    let camera = Some("zoom:1".parse().unwrap());
    let [zooming, resting] = [camera, None].map(|camera| Options { camera, ..Options::default() });
    let smallest = 0.75 * scene(Kind::Static, resting).smallest_radius();
    assert_eq!(scene(Kind::Static, zooming).smallest_radius(), smallest);
    let radii = play(Kind::Static, zooming, 300).into_iter().flat_map(|frame| frame.holes).map(|hole| hole.radius);
    let least = radii.fold(f64::INFINITY, f64::min);
    assert!(least >= smallest && least < 1.01 * smallest, "{least}, {smallest}");
}

#[test]
fn dense_points_without_noise_show_events_in_their_frames() {
    let options = Options { noise: 0.0, points_per_radius: 60, churn: 1.0, ..Options::default() };
    for kind in [Kind::Pinch, Kind::Fuse, Kind::Open] {
        let tally = compare(kind, options, 420, 1, 1);
        assert_eq!((tally.differing_calm, tally.unseen), (0, 0), "{}: {tally:?}", kind.name());
        assert!(tally.calm < 410, "{} has events: {tally:?}", kind.name());
    }
}

/// Every frame, for the table: `cargo test --release --test scenes -- --ignored --nocapture`.
#[test]
#[ignore = "takes minutes"]
fn the_truth_is_what_the_skeleton_shows_in_every_frame() {
    println!("scene noise points churn: frames, other number; calm frames, other number; holes, unseen; first fault");
    let mut faults = 0;
    for kind in Kind::ALL {
        for options in option_sets() {
            let tally = compare(kind, options, 600, 1, transition(kind));
            let Options { noise, points_per_radius, churn, .. } = options;
            let Tally { frames, calm, differing, differing_calm, holes, unseen, first } = tally;
            println!(
                "{:<10} {noise} {points_per_radius} {churn}: {frames}, {differing}; {calm}, {differing_calm}; {holes}, {unseen}; {first:?}",
                kind.name()
            );
            faults += differing_calm + unseen;
        }
    }
    assert_eq!(faults, 0);
}

// ---- events

/// The hole of an event.
fn id(event: &TrueEvent) -> u64 {
    match *event {
        TrueEvent::Born { id, .. }
        | TrueEvent::Split { id, .. }
        | TrueEvent::Merged { id, .. }
        | TrueEvent::Died { id } => id,
    }
}

/// The holes of the previous frame, and the ids used so far.
#[derive(Default)]
struct EventChecker {
    holes: BTreeMap<u64, TrueHole>,
    given: BTreeSet<u64>,
}

impl EventChecker {
    /// Checks a frame against the rules.
    fn follow(&mut self, frame: &Frame) {
        let number = frame.number;
        let now: BTreeMap<u64, TrueHole> = frame.holes.iter().map(|&hole| (hole.id, hole)).collect();
        assert!(frame.holes.is_sorted_by(|a, b| a.id < b.id), "frame {number}: holes are in order, each once");
        let mut there: BTreeSet<u64> = self.holes.keys().copied().collect();
        for event in &frame.events {
            let id = id(event);
            match *event {
                TrueEvent::Born { .. } | TrueEvent::Split { .. } => {
                    assert!(self.given.insert(id) && there.insert(id), "frame {number}: {id} is new");
                }
                TrueEvent::Died { .. } | TrueEvent::Merged { .. } => {
                    assert!(there.remove(&id), "frame {number}: {id} was there");
                }
            }
            let (other, lesser) = match *event {
                TrueEvent::Split { from, .. } => (from, &now),
                TrueEvent::Merged { into, .. } => (into, &self.holes),
                TrueEvent::Born { .. } | TrueEvent::Died { .. } => continue,
            };
            let lives_on = self.holes.contains_key(&other) && now.contains_key(&other);
            assert!(lives_on, "frame {number}: {other} was there and stays");
            assert!(now[&other].radius > lesser[&id].radius, "frame {number}: the larger keeps its id");
        }
        assert!(there.iter().eq(now.keys()), "frame {number}: who is there follows from the events");
        self.holes = now;
    }
}

#[test]
fn the_events_are_consistent() {
    for kind in Kind::ALL {
        for seed in 0..4 {
            let options = Options { seed, points_per_radius: 2, ..Options::default() };
            let smallest = scene(kind, options).smallest_radius();
            let mut story = EventChecker::default();
            let mut least = f64::INFINITY;
            for frame in play(kind, options, 2000) {
                story.follow(&frame);
                least = frame.holes.iter().map(|hole| hole.radius).fold(least, f64::min);
            }
            assert!(least >= smallest && least < 1.01 * smallest, "{}: {least}, {smallest}", kind.name());
        }
    }
}

#[test]
fn holes_move_slowly() {
    for kind in Kind::ALL {
        let frames = play(kind, Options { points_per_radius: 2, ..Options::default() }, 1200);
        let mut fastest: f64 = 0.0;
        for pair in frames.windows(2) {
            for hole in &pair[1].holes {
                let before = pair[0].holes.iter().find(|before| before.id == hole.id);
                // An annulus has the same centre as the disc in it.
                let way = before.map_or(0.0, |before| TrueHole { orbit: 0.0, ..*before }.distance(hole.center));
                fastest = fastest.max(way / hole.radius);
            }
        }
        // While pairs part or meet, their smaller discs are faster. So is the centre of a cell whose wall opens.
        let limit = if matches!(kind, Kind::Pinch | Kind::Fuse | Kind::Mixed | Kind::Cells) { 0.14 } else { 0.06 };
        assert!(fastest <= limit, "{}: {fastest}", kind.name());
        assert_eq!(
            fastest > 0.0,
            !matches!(
                kind,
                Kind::Static
                    | Kind::Open
                    | Kind::Vanish
                    | Kind::Polygons
                    | Kind::Occlusion
                    | Kind::Breathe
                    | Kind::Uneven
            ),
            "{}",
            kind.name()
        );
    }
}

#[test]
fn each_scene_has_the_events_of_its_name() {
    for kind in Kind::ALL {
        let frames = play(kind, Options { points_per_radius: 2, ..Options::default() }, 1200);
        let events = frames.iter().skip(1).flat_map(|frame| &frame.events);
        let mut counts = [0; 4];
        for event in events {
            let which = match event {
                TrueEvent::Born { .. } => 0,
                TrueEvent::Split { .. } => 1,
                TrueEvent::Merged { .. } => 2,
                TrueEvent::Died { .. } => 3,
            };
            counts[which] += 1;
        }
        let happens = counts.map(|count| count >= 4);
        assert_eq!(happens, counts.map(|count| count > 0), "{}: {counts:?}", kind.name());
        let expected = match kind {
            Kind::Pinch => [true, true, false, true],
            Kind::Fuse => [true, false, true, true],
            Kind::Cells => [false, true, true, false],
            Kind::Open | Kind::Vanish | Kind::Crowd | Kind::CShapes => [true, false, false, true],
            Kind::Mixed => [true; 4],
            _ => [false; 4],
        };
        assert_eq!(happens, expected, "{}: {counts:?}", kind.name());
    }
}

// ---- the points

/// The points of a cloud, sorted.
fn sorted(points: &[[f64; 2]]) -> Vec<[u64; 2]> {
    let mut bits: Vec<[u64; 2]> = points.iter().map(|point| point.map(f64::to_bits)).collect();
    bits.sort_unstable();
    bits
}

#[test]
fn changes_lead_from_one_cloud_to_the_next() {
    for kind in Kind::ALL {
        let usual = Options::default();
        let clutter = Options { clutter: 0.1, ..usual };
        let shaken = Options { camera: Some("shake:1".parse().unwrap()), ..clutter };
        for options in [usual, Options { shuffle: true, ..clutter }, Options { clumps: true, ..clutter }, shaken] {
            let mut cloud: BTreeMap<[u64; 2], u32> = BTreeMap::new();
            for frame in play(kind, options, 60) {
                for point in sorted(&frame.gone) {
                    let count = cloud.get_mut(&point).unwrap_or_else(|| panic!("frame {}: {point:?}", frame.number));
                    *count -= 1;
                }
                cloud.retain(|_, count| *count > 0);
                for point in sorted(&frame.come) {
                    *cloud.entry(point).or_default() += 1;
                }
                let held: Vec<[u64; 2]> =
                    cloud.iter().flat_map(|(&point, &count)| (0..count).map(move |_| point)).collect();
                assert_eq!(held, sorted(&frame.points), "{} frame {}", kind.name(), frame.number);
            }
        }
    }
}

#[test]
fn churn_is_the_share_that_is_drawn_anew() {
    for churn in [0.01, 0.1, 0.37, 1.0] {
        let frames = play(Kind::Static, Options { churn, ..Options::default() }, 101);
        let count = frames[0].points.len() as f64;
        let changed: usize = frames[1..].iter().map(|frame| frame.gone.len()).sum();
        // At most one point of each of the 8 rings is still due.
        assert!((changed as f64 - 100.0 * churn * count).abs() <= 8.0, "{churn}: {changed} of {count}");
        assert!(frames[1..].iter().all(|frame| frame.come.len() == frame.gone.len()));
    }
}

#[test]
fn stray_points_come_last_and_change_nothing_else() {
    for kind in [Kind::Mixed, Kind::Rates, Kind::Occlusion] {
        for clumps in [false, true] {
            let options = Options { churn: 0.2, ..Options::default() };
            let clean = play(kind, options, 120);
            let cluttered = play(kind, Options { clutter: 0.05, clumps, ..options }, 120);
            for (clean, cluttered) in clean.iter().zip(&cluttered) {
                let count = clean.points.len();
                assert_eq!((&clean.holes, &clean.events), (&cluttered.holes, &cluttered.events));
                assert_eq!(clean.points, cluttered.points[..count], "{} frame {}", kind.name(), clean.number);
                assert_eq!((clean.clutter, cluttered.clutter), (0, cluttered.points.len() - count));
                let share = cluttered.clutter as f64 / count as f64;
                let off = if clumps { 0.02 } else { 1.0 / count as f64 };
                assert!((share - 0.05).abs() < off, "{} frame {}: {share}", kind.name(), clean.number);
            }
            let changed: usize = cluttered[1..].iter().map(|frame| frame.come.len()).sum();
            let changed_clean: usize = clean[1..].iter().map(|frame| frame.come.len()).sum();
            let strays: usize = cluttered[1..].iter().map(|frame| frame.clutter).sum();
            // A moving scene takes its stray points along, so all of them change.
            let share = (changed - changed_clean) as f64 / strays as f64;
            let expected = if kind == Kind::Occlusion { 0.2..0.3 } else { 0.2..1.01 };
            assert!(expected.contains(&share), "{} {clumps}: {share}", kind.name());
        }
    }
}

#[test]
fn shuffled_points_are_the_same_in_another_order() {
    let options = Options { churn: 0.3, ..Options::default() };
    let in_order = play(Kind::Mixed, options, 30);
    let shuffled = play(Kind::Mixed, Options { shuffle: true, ..options }, 30);
    for (a, b) in in_order.iter().zip(&shuffled) {
        assert_eq!((&a.holes, &a.events, a.time), (&b.holes, &b.events, b.time));
        for (a, b) in [(&a.points, &b.points), (&a.come, &b.come), (&a.gone, &b.gone)] {
            assert_eq!(sorted(a), sorted(b));
            assert!(a != b || a.is_empty());
        }
    }
}

#[test]
fn the_seed_decides_everything() {
    for kind in Kind::ALL {
        let options = |seed| Options { seed, shuffle: true, ..Options::default() };
        assert_eq!(play(kind, options(7), 20), play(kind, options(7), 20));
        assert_ne!(play(kind, options(7), 1)[0].points, play(kind, options(8), 1)[0].points);
    }
}

/// The hash FNV-1a of the points and holes of frames, bit for bit.
fn digest(frames: Vec<Frame>) -> u64 {
    let numbers = frames.into_iter().flat_map(|frame| {
        let holes = frame.holes.into_iter().map(|hole| hole.center);
        frame.points.into_iter().chain(holes).flatten().collect::<Vec<_>>()
    });
    let bytes = numbers.flat_map(|number: f64| number.to_bits().to_le_bytes());
    bytes.fold(0xCBF2_9CE4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3))
}

/// The meaning of a seed must not change in any version or on any machine.
#[test]
fn scenes_do_not_change() {
    let digest = |kind| digest(play(kind, Options::default(), 100));
    let digests: Vec<String> = Kind::ALL.map(|kind| format!("{} {:016x}", kind.name(), digest(kind))).to_vec();
    assert_eq!(digests.join("\n"), DIGESTS);
}

/// The same of cameras and of stray points.
#[test]
fn cameras_and_clutter_do_not_change() {
    let digest = |camera: &str, clumps| {
        let camera = Some(camera.parse().unwrap());
        let options = Options { points_per_radius: 4, clutter: 0.2, clumps, camera, ..Options::default() };
        digest(play(Kind::Cells, options, 50))
    };
    let digests = [("pan:0.3", false), ("turn:0.3", true), ("zoom:0.3", false), ("shake:0.3", true)]
        .map(|(camera, clumps)| format!("{camera} {:016x}", digest(camera, clumps)));
    assert_eq!(digests.join("\n"), MOVED_DIGESTS);
}

const MOVED_DIGESTS: &str = "\
pan:0.3 9f9459a6d5bfe277
turn:0.3 643d3aecabe172ba
zoom:0.3 f7d6ef0d7649b3c3
shake:0.3 ef6dcab6788ce740";

const DIGESTS: &str = "\
drift 1fc46e8fd0229589
static 933d226c2bac808f
pinch fe34eeffa0aed5e6
fuse 80b8796cc392f0e0
open 68e38389d8e3534d
pass 1e0bbae4675bdbd8
vanish 5151c6763fea032b
concentric 60e02933debade7f
polygons bb76f28b72b26746
occlusion 81ed8953dce99fe9
crowd 8e79855f1d5f39e5
breathe fdf385b68c08e0c2
mixed c48d733f7c55d740
ellipses 283de06444f937e7
stars 8e93d463b7135d4b
cshapes 1a67dc56fdc799dc
cells f406b75c907e108a
uneven 72e8d9e18fa6f460
densities cf6b98393aee1056
rates f568b01f6d1d19a2
many c50ac3f93ce7ff43
sizes be8bf734e1956ab1";

#[test]
fn options_beyond_their_range_are_refused_with_the_range() {
    let refused = |options: Options| Scene::new(Kind::Drift, options).unwrap_err();
    let usual = Options::default();
    for noise in [-0.1, 0.31, f64::NAN, f64::INFINITY] {
        let error = refused(Options { noise, ..usual });
        assert!(matches!(error, OptionError::Noise(_)) && error.to_string().contains("must be 0 to 0.3"), "{error}");
    }
    for churn in [0.0, 0.009, 1.1, f64::NAN] {
        let error = refused(Options { churn, ..usual });
        assert!(matches!(error, OptionError::Churn(_)) && error.to_string().contains("must be 0.01 to 1"), "{error}");
    }
    for clutter in [-0.01, 1.1, f64::NAN] {
        let error = refused(Options { clutter, ..usual });
        assert!(matches!(error, OptionError::Clutter(_)) && error.to_string().contains("must be 0 to 1"), "{error}");
    }
    for points_per_radius in [0, 1, 10_001, u32::MAX] {
        let error = refused(Options { points_per_radius, ..usual });
        let words = "must be 2 to 10000";
        assert!(matches!(error, OptionError::PointsPerRadius(_)) && error.to_string().contains(words), "{error}");
    }
}
