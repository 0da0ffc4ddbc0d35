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

/// The scores of runs with several seeds, 5% of the points new in each frame.
fn scores(kind: SpaceKind, points: u32, seeds: impl IntoIterator<Item = u64>, frames: usize) -> Vec<(Score, Run)> {
    let run = |seed| {
        let options = SpaceOptions { points, seed, churn: 0.05, ..SpaceOptions::default() };
        let run = run(kind, options, TrackRule::Above, frames);
        (score(&run), run)
    };
    seeds.into_iter().map(run).collect()
}

#[test]
fn separate_holes_keep_their_ids() {
    let scenes =
        [(SpaceKind::Rings, 200), (SpaceKind::Links, 200), (SpaceKind::Trefoil, 300), (SpaceKind::Circle, 100)];
    for (kind, points) in scenes {
        for (score, run) in scores(kind, points, 1..4, 150) {
            assert!(
                score.idf1() >= 0.98 && score.switches == 0,
                "{kind:?}: {} {score:?} {:?}",
                score.idf1(),
                news(&run)
            );
        }
    }
}

#[test]
fn the_holes_of_a_torus_keep_their_ids() {
    // The first cycles of 1, 3 and 5 wind around both holes, those of 9 and 12 around the outside.
    for (score, run) in scores(SpaceKind::Torus, 500, [1, 2, 3, 5, 9, 10, 12, 40], 120) {
        assert!(score.idf1() >= 0.98 && score.switches == 0, "{} {score:?} {:?}", score.idf1(), news(&run));
    }
}

#[test]
fn a_ring_that_pinches_and_opens_is_told_so() {
    for (score, run) in scores(SpaceKind::Pinch, 200, 1..4, 700) {
        assert!(score.idf1() >= 0.98, "{} {score:?} {:?} {:?}", score.idf1(), run.true_events, news(&run));
        let told = news(&run);
        for (frame, event) in &run.true_events {
            let is_told = |kind: &EventKind| match event {
                TrueEvent::Split { .. } => matches!(kind, EventKind::Split { .. }),
                TrueEvent::Merged { .. } => matches!(kind, EventKind::Merged { .. }),
                TrueEvent::Born { .. } | TrueEvent::Died { .. } => true,
            };
            // The waist opens slowly.
            let in_time = |&&(at, ..): &&(u64, u64, EventKind)| at >= *frame && at <= frame + 30;
            let is_told = told.iter().filter(in_time).any(|(.., kind)| is_told(kind));
            assert!(is_told, "{event:?} in {frame}: {told:?}");
        }
    }
}

/// The last values of a series as a point, each some steps after the one before.
fn delayed(series: &[f64], dimension: usize, lag: usize) -> Option<Vec<f64>> {
    let first = series.len().checked_sub((dimension - 1) * lag + 1)?;
    Some((0..dimension).map(|number| series[first + number * lag]).collect())
}

#[test]
fn the_period_of_a_noisy_sine_is_found_and_lost() {
    let mut signal = Signal::new(SignalKind::Sine, SignalOptions { samples: 6, ..SignalOptions::default() }).unwrap();
    let window = Window::Points(NonZeroU64::new(120).unwrap());
    let mut pipeline = SpacePipeline::new(Stream { window, ..Stream::default() }).unwrap();
    let mut tracker = SpaceTracker::new(TrackOptions::new(TrackRule::Above(0.3)));
    let (mut series, mut runs, mut alive) = (Vec::new(), Vec::new(), Vec::new());
    // Two runs of 80 frames and the rests of 40 frames after them.
    for _ in 0..240 {
        let frame = signal.next_frame();
        for [value] in frame.points {
            series.push(value);
            if let Some(point) = delayed(&series, 4, 5) {
                pipeline.feed_point(&point, None).unwrap();
            }
        }
        pipeline.commit(None);
        pipeline.poll_tracks(&mut tracker).unwrap();
        runs.push(!frame.holes.is_empty());
        alive.push(tracker.alive().map(|track| track.id.0).collect::<Vec<u64>>());
    }
    // The window has two periods, and is filled or emptied in 20 frames.
    for (frame, run) in runs.iter().enumerate() {
        let is_settled = frame >= 30 && runs[frame - 30..frame].iter().all(|before| before == run);
        let expected: Vec<u64> = if *run { vec![1 + u64::from(frame > 120)] } else { Vec::new() };
        assert!(!is_settled || alive[frame] == expected, "frame {}: {:?}", frame + 1, alive[frame]);
    }
}
