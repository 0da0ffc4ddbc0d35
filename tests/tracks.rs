//! Tracks in the plane that hold though the selection has far more dots than there are holes, though all points are
//! drawn anew in every frame, and though the whole picture moves.

use std::collections::BTreeMap;
use std::num::{NonZeroU32, NonZeroU64};

use hopes::scene::{Kind, Options as SceneOptions, Scene, TrueHole};
use hopes::topology::{Options, Pipeline, Track, TrackId, TrackOptions, TrackRule, TrackStep, Tracker, Window};

type Points = Vec<[f64; 2]>;

/// A stream whose frames replace each other, and its tracker.
struct Stream {
    pipeline: Pipeline,
    tracker: Tracker,
}

impl Stream {
    fn new(rule: TrackRule) -> Self {
        let window = Window::Frames(NonZeroU64::MIN);
        let pipeline = Pipeline::new(Options { window, ..Options::default() });
        Self { pipeline, tracker: Tracker::new(TrackOptions::new(rule)) }
    }

    fn show(&mut self, points: &[[f64; 2]]) -> TrackStep {
        assert_eq!(self.pipeline.feed_points(points, None), []);
        self.pipeline.commit(None);
        self.pipeline.poll_tracks(&mut self.tracker).expect("a frame was committed")
    }
}

fn top(most: u32) -> TrackRule {
    TrackRule::Top(NonZeroU32::new(most).unwrap())
}

fn ring(count: u32, radius: f64, [x, y]: [f64; 2]) -> Points {
    let turn = std::f64::consts::TAU / f64::from(count);
    let at = |place: u32| (f64::from(place) * turn).sin_cos();
    (0..count).map(at).map(|(sin, cos)| [x + radius * cos, y + radius * sin]).collect()
}

/// The tracks of at least this persistence, by id.
fn persistent(step: &TrackStep, least: f64) -> Vec<(TrackId, Track)> {
    step.alive.iter().filter(|track| track.persistence() >= least).map(|track| (track.id, *track)).collect()
}

/// Rings move by more than their radius, each time elsewhere: the shifts of a camera that shakes.
const SHAKES: [[f64; 2]; 8] =
    [[0.0, 0.0], [1.2, 0.5], [-0.9, 1.1], [0.3, -1.3], [1.4, 0.2], [-1.0, -1.0], [0.8, 1.2], [-1.3, 0.4]];

#[test]
fn a_ring_keeps_its_track_though_noise_is_tracked_too() {
    let text = include_str!("data/track_jump.txt");
    let frames = text.split("\n\n").map(|frame| {
        let number = |word: &str| word.parse::<f64>().unwrap();
        let point = |line: &str| line.split_once(' ').map(|(x, y)| [number(x), number(y)]).unwrap();
        frame.lines().filter(|line| !line.is_empty()).map(point).collect::<Points>()
    });
    let mut stream = Stream::new(top(4));
    let rings: Vec<Vec<TrackId>> =
        frames.map(|points| persistent(&stream.show(&points), 0.3).into_iter().map(|(id, _)| id).collect()).collect();
    assert_eq!(rings.len(), 5);
    assert!(rings[1..].iter().all(|ids| ids.len() == 1 && *ids == rings[1]), "{rings:?}");
}

#[test]
fn rings_keep_their_tracks_when_the_camera_shakes_or_begins_to_pan() {
    let places = [[0.0, 0.0], [2.6, 0.2], [5.0, -0.4], [0.3, 2.7], [2.8, 3.0], [5.5, 2.4]];
    let pans = (1..8).map(|frame| [1.3 * f64::from(frame), 0.4 * f64::from(frame)]);
    let shifts = SHAKES.iter().copied().chain(std::iter::repeat_n([0.0; 2], 3)).chain(pans);
    for rule in [top(30), TrackRule::Above(0.5)] {
        let mut stream = Stream::new(rule);
        let mut tracks: BTreeMap<TrackId, [f64; 2]> = BTreeMap::new();
        for (number, [dx, dy]) in shifts.clone().enumerate() {
            let count = |place: usize| 20 + (7 * place + 3 * number) as u32 % 6;
            let rings = places.iter().enumerate();
            let points: Points = rings.flat_map(|(place, [x, y])| ring(count(place), 1.0, [x + dx, y + dy])).collect();
            let step = stream.show(&points);
            let seen = persistent(&step, 0.5);
            assert_eq!(seen.len(), if number == 0 { 0 } else { places.len() }, "{rule:?}, frame {number}");
            for (id, track) in seen {
                let place = [track.hole.center[0] - dx, track.hole.center[1] - dy];
                let [x, y] = *tracks.entry(id).or_insert(place);
                assert!((x - place[0]).hypot(y - place[1]) < 0.5, "{rule:?}, frame {number}: {id:?} is at {place:?}");
            }
        }
        assert_eq!(tracks.len(), places.len());
    }
}

#[test]
fn two_lobes_that_swap_their_ranks_are_one_hole() {
    // The hole of a dumb-bell. Its wider lobe is now on one side and now on the other; the other one is a dot, too.
    let mut stream = Stream::new(top(8));
    let mut ids = Vec::new();
    for frame in 0..12 {
        let (left, right) = if frame % 2 == 0 { (1.05, 1.0) } else { (1.0, 1.05) };
        let discs = [(left, -0.8), (right, 0.8)];
        let is_outside = |point: &[f64; 2]| discs.iter().all(|(r, x)| (point[0] - x).hypot(point[1]) >= r - 1e-9);
        let points: Points = discs.iter().flat_map(|&(r, x)| ring(64, r, [x, 0.0])).filter(is_outside).collect();
        ids.push(persistent(&stream.show(&points), 0.6).into_iter().map(|(id, _)| id).collect::<Vec<_>>());
    }
    assert!(ids[1..].iter().all(|now| now.len() == 1 && *now == ids[1]), "{ids:?}");
}

/// How often a true hole goes on under another id, and in how many frames of how many none is where it is.
fn follow(kind: Kind, options: SceneOptions, frames: usize) -> (usize, usize, usize) {
    let mut scene = Scene::new(kind, options).unwrap();
    let above = scene.above();
    let first = scene.clone().next_frame();
    let mut stream = Stream::new(top(4 * first.holes.len().max(4) as u32));
    let mut names: BTreeMap<u64, TrackId> = BTreeMap::new();
    let (mut switches, mut misses, mut holes) = (0, 0, 0);
    for _ in 0..frames {
        let frame = scene.next_frame();
        let tracks = persistent(&stream.show(&frame.points), above);
        for hole in &frame.holes {
            holes += 1;
            let Some(id) = nearest(hole, &tracks) else {
                misses += 1;
                continue;
            };
            switches += usize::from(names.insert(hole.id, id).is_some_and(|before| before != id));
        }
    }
    (switches, misses, holes)
}

/// The track whose centre is nearest to that of a true hole.
fn nearest(hole: &TrueHole, tracks: &[(TrackId, Track)]) -> Option<TrackId> {
    let away = tracks.iter().map(|(id, track)| (hole.distance(track.hole.center), *id));
    away.filter(|&(away, _)| away <= 0.5 * hole.radius).min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, id)| id)
}

fn check_names(kind: Kind, options: SceneOptions) {
    let (switches, misses, holes) = follow(kind, options, 90);
    assert_eq!(switches, 0, "{kind:?} {options:?}");
    // A name is given in the second frame of a hole.
    assert!(misses * 20 <= holes, "{kind:?} {options:?}: {misses} of {holes} are not there");
}

#[test]
fn no_true_hole_changes_its_name_in_any_scene() {
    for kind in Kind::ALL {
        check_names(kind, SceneOptions { churn: 1.0, ..SceneOptions::default() });
    }
}

#[test]
fn no_true_hole_changes_its_name_when_the_camera_moves() {
    for camera in ["pan:1", "turn:1", "zoom:0.5", "shake:1"] {
        let camera = Some(camera.parse().unwrap());
        for kind in [Kind::Drift, Kind::Pinch, Kind::Fuse, Kind::Pass, Kind::Concentric, Kind::Ellipses, Kind::Cells] {
            check_names(kind, SceneOptions { churn: 0.05, camera, ..SceneOptions::default() });
        }
    }
}
