//! Scenes against the real thing: the truth that they tell is what the skeleton of their points shows, and it is one story from beginning to end.

use hopes::scene::{Frame, Kind, Options, Scene, TrueHole};
use hopes::topology::{Options as Stream, Pipeline, RankedDot, Window};

/// So near to an event the number of holes may be the one before or after it, where what happens takes time.
fn transition(kind: Kind) -> u64 {
    match kind {
        Kind::Pinch | Kind::Fuse | Kind::Open | Kind::Mixed => 4,
        _ => 0,
    }
}

/// As far as a hole's centre may be from the true one: a share of its radius.
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
    let mut pipeline = Pipeline::new(Stream { window: Window::All, resolution: None });
    assert_eq!(pipeline.feed_points(points, None), []);
    pipeline.commit(None);
    let mut dots = pipeline.poll_dots(100).dots;
    dots.retain(|dot| dot.critical.death - dot.critical.birth >= above);
    dots
}

/// Whether a hole is one of those.
fn is_seen(hole: &TrueHole, dots: &[RankedDot]) -> bool {
    dots.iter().any(|dot| hole.distance(dot.hole.center) <= NEAR * hole.radius)
}

/// What was looked at.
#[derive(Debug, Default)]
struct Tally {
    /// Frames, and those away from events.
    frames: u32,
    calm: u32,
    /// Of all of them: those with another number of dots than holes.
    differing: u32,
    /// Of the calm ones.
    differing_calm: u32,
    /// True holes in calm frames, and those without a dot at their place.
    holes: u32,
    unseen: u32,
    /// The first calm frame at fault.
    first: Option<u64>,
}

/// Compares every so manieth frame of a scene with its truth.
fn compare(kind: Kind, options: Options, count: usize, every: usize) -> Tally {
    let above = scene(kind, options).above();
    let frames = play(kind, options, count + transition(kind) as usize);
    let events: Vec<u64> = frames.iter().filter(|frame| !frame.events.is_empty()).map(|frame| frame.number).collect();
    let is_at_once = |event| event == 1 || transition(kind) == 0;
    let mut tally = Tally::default();
    for frame in frames.iter().take(count).skip(every / 2).step_by(every) {
        let dots = dots(&frame.points, above);
        let is_calm = events.iter().all(|event| frame.number.abs_diff(*event) > transition(kind) || is_at_once(*event));
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

/// All ways to make points of which the truth must be seen.
fn ways() -> impl Iterator<Item = Options> {
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
        for (number, options) in ways().enumerate() {
            // Other frames in each way, so that all together see most of the scene.
            let tally = compare(kind, Options { seed: number as u64, ..options }, 400, 41 + number);
            let fault = (tally.differing_calm, tally.unseen);
            assert_eq!(fault, (0, 0), "{} {options:?}: {tally:?}", kind.name());
            assert!(tally.calm > 0, "{} has no calm frame", kind.name());
        }
    }
}

/// Every frame, for the table: `cargo test --release --test scenes -- --ignored --nocapture`.
#[test]
#[ignore = "takes minutes"]
fn the_truth_is_what_the_skeleton_shows_in_every_frame() {
    println!("scene noise points churn: frames, other number; calm frames, other number; holes, unseen; first fault");
    let mut faults = 0;
    for kind in Kind::ALL {
        for options in ways() {
            let tally = compare(kind, options, 600, 1);
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
