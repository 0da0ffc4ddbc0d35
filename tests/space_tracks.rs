//! Tracks in R^d against the truth of scenes: holes keep their ids, splits and mergers are told, periods are found and
//! lost.

use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroU64;

use hopes::scene::TrueEvent;
use hopes::scene::signal::{Signal, SignalKind, SignalOptions};
use hopes::scene::space::{SpaceKind, SpaceOptions, SpaceScene, TrueCycle};
use hopes::topology::{
    EventKind, SpaceOptions as Stream, SpacePipeline, SpaceTrack, SpaceTrackStep, SpaceTracker, TrackOptions,
    TrackRule, Window,
};
use pathfinding::kuhn_munkres::kuhn_munkres;
use pathfinding::matrix::Matrix;

/// A true and a reported hole farther apart than this part of the true radius are no pair.
const NEAR: f64 = 0.5;

/// A scene, what is true of it, and what was reported.
struct Run {
    above: f64,
    truth: Vec<Vec<TrueCycle>>,
    true_events: Vec<(u64, TrueEvent)>,
    steps: Vec<SpaceTrackStep>,
}

/// How well tracks follow true holes: the identity measures of multi-object tracking.
#[derive(Debug, Default)]
struct Score {
    /// All true and all reported holes of all frames, and those of them that an optimal bijection of ids pairs.
    truth: usize,
    reported: usize,
    paired: usize,
    /// How often a true hole goes on under another id.
    switches: usize,
}

impl Score {
    fn idf1(&self) -> f64 {
        2.0 * self.paired as f64 / (self.truth + self.reported) as f64
    }
}

fn run(kind: SpaceKind, options: SpaceOptions, rule: impl Fn(f64) -> TrackRule, frames: usize) -> Run {
    let mut scene = SpaceScene::new(kind, options).unwrap();
    let above = scene.above().unwrap();
    let mut pipeline = SpacePipeline::new(Stream { window: Window::All, ..Stream::default() }).unwrap();
    let mut tracker = SpaceTracker::new(TrackOptions::new(rule(above)));
    let mut run = Run { above, truth: Vec::new(), true_events: Vec::new(), steps: Vec::new() };
    for _ in 0..frames {
        let frame = scene.next_frame();
        frame.gone.iter().for_each(|point| pipeline.feed_retraction(point).unwrap());
        assert_eq!(pipeline.feed_points(&frame.come, None), []);
        pipeline.commit(None);
        run.steps.push(pipeline.poll_tracks(&mut tracker).unwrap());
        run.true_events.extend(frame.events.into_iter().map(|event| (frame.number, event)));
        run.truth.push(frame.holes);
    }
    run
}

/// Whether a track is where a true hole is.
fn is_at(track: &SpaceTrack, hole: &TrueCycle) -> bool {
    let away = track.center.iter().zip(&hole.center).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    (away - hole.orbit).abs() <= NEAR * hole.radius
}

fn score(run: &Run) -> Score {
    let mut score = Score::default();
    let mut common: BTreeMap<(u64, u64), i64> = BTreeMap::new();
    let mut last: BTreeMap<u64, u64> = BTreeMap::new();
    for (holes, step) in run.truth.iter().zip(&run.steps) {
        // A track goes on for some frames below what is a hole by the measure of the truth.
        let tracks: Vec<&SpaceTrack> = step.alive.iter().filter(|track| track.persistence() >= run.above).collect();
        score.truth += holes.len();
        score.reported += tracks.len();
        for hole in holes {
            let here: Vec<u64> = tracks.iter().filter(|track| is_at(track, hole)).map(|track| track.id.0).collect();
            here.iter().for_each(|&id| *common.entry((hole.id, id)).or_default() += 1);
            let before = last.get(&hole.id).copied();
            if let Some(&now) = here.iter().find(|&&id| Some(id) == before).or(here.first()) {
                score.switches += usize::from(before.is_some_and(|before| before != now));
                last.insert(hole.id, now);
            }
        }
    }
    let ids = |of: fn(&(u64, u64)) -> u64| common.keys().map(of).collect::<BTreeSet<u64>>();
    let (holes, tracks) = (ids(|pair| pair.0), ids(|pair| pair.1));
    let side = holes.len().max(tracks.len());
    let count = |row, column| {
        let pair = (holes.iter().nth(row)?, tracks.iter().nth(column)?);
        common.get(&(*pair.0, *pair.1)).copied()
    };
    let places = (0..side).flat_map(|row| (0..side).map(move |column| (row, column)));
    let gains = Matrix::from_vec(side, side, places.map(|(row, column)| count(row, column).unwrap_or(0)).collect());
    score.paired = kuhn_munkres(&gains.unwrap()).0 as usize;
    score
}

fn news(run: &Run) -> Vec<(u64, u64, EventKind)> {
    let events = run.steps.iter().flat_map(|step| &step.events);
    let news = events.filter(|event| !matches!(event.kind, EventKind::Updated(_)));
    news.map(|event| (event.frame, event.track.id.0, event.kind)).collect()
}

#[test]
fn experiment() {
    for (kind, points) in [
        (SpaceKind::Torus, 500),
        (SpaceKind::Trefoil, 300),
        (SpaceKind::Rings, 200),
        (SpaceKind::Links, 200),
        (SpaceKind::Pinch, 200),
        (SpaceKind::Circle, 100),
    ] {
        for (noise, seed) in [(0.05, 1), (0.1, 2), (0.1, 3), (0.1, 4), (0.1, 5), (0.1, 6)] {
            let options = SpaceOptions { points, noise, seed, churn: 0.05, ..SpaceOptions::default() };
            let start = std::time::Instant::now();
            let run = run(kind, options, TrackRule::Above, 250);
            let score = score(&run);
            println!("{kind:?} {noise}: {:.4} {score:?} {:?}", score.idf1(), start.elapsed());
            if score.idf1() < 0.985 || kind == SpaceKind::Pinch {
                println!("   {:?}\n   {:?}", run.true_events, news(&run));
            }
        }
    }
}
