//! Tracking in one stream: from its pipeline to frames of the track log.
//!
//! In: the stream's pipeline, once per frame in which a consumer wants tracks. Out: [`AnyTrackFrame`]s.
//!
//! Invariants: cycles are found only if a consumer wants them; unchanged ones are shared with the frame before.
//!
//! Must not know: the log, consumers, how tracks are found.

use std::collections::HashMap;
use std::fmt::Debug;
use std::sync::Arc;

use hopes::topology::{Region, SpaceTracker, TrackOptions, Tracker};
use hopes_protocol::{self as wire, TrackState};

use super::any_tracks::AnyTrackFrame;
use super::track_log::{Living, TrackFrame};
use crate::daemon::memory::Account;
use crate::daemon::streams::convert::{self, TrackKind};
use crate::daemon::streams::pipeline::AnyPipeline;

/// Follows the tracks of a stream.
#[derive(Debug)]
pub enum Tracking {
    /// Of the plane.
    Plane(Followed<Tracker>),
    /// In a space.
    Space(Followed<SpaceTracker>),
}

impl Tracking {
    /// No frame was seen yet, of a stream of the plane or in a space.
    pub fn new(options: TrackOptions, is_of_space: bool, account: Arc<Account>) -> Self {
        if is_of_space {
            Self::Space(Followed::new(SpaceTracker::new(options), account))
        } else {
            Self::Plane(Followed::new(Tracker::new(options), account))
        }
    }

    /// What has happened up to the newest frame, unless that was asked before.
    pub fn poll(&mut self, pipeline: &mut AnyPipeline, with_cycles: bool) -> Option<AnyTrackFrame> {
        match self {
            Self::Plane(followed) => followed.poll(pipeline, with_cycles).map(AnyTrackFrame::Plane),
            Self::Space(followed) => followed.poll(pipeline, with_cycles).map(AnyTrackFrame::Space),
        }
    }

    /// The newest frame again, with cycles, if it has none.
    pub fn with_cycles(&mut self, pipeline: &mut AnyPipeline, newest: AnyTrackFrame) -> Option<AnyTrackFrame> {
        match (self, newest) {
            (Self::Plane(followed), AnyTrackFrame::Plane(newest)) => {
                followed.with_cycles(pipeline, &newest).map(AnyTrackFrame::Plane)
            }
            (Self::Space(followed), AnyTrackFrame::Space(newest)) => {
                followed.with_cycles(pipeline, &newest).map(AnyTrackFrame::Space)
            }
            _ => None,
        }
    }
}

/// The events of a frame as they are on the wire.
pub struct Polled<K: TrackKind> {
    number: u64,
    time: Option<f64>,
    events: Vec<K::Event>,
    left_out: usize,
}

/// A tracker of one kind.
pub trait Follows: Debug {
    /// The kind of its tracks.
    type Kind: TrackKind;

    /// What has happened up to the newest frame, unless that was asked before.
    fn poll(&mut self, pipeline: &mut AnyPipeline) -> Option<Polled<Self::Kind>>;

    /// All that are alive, by id.
    fn living(&self) -> Vec<<Self::Kind as TrackKind>::Track>;

    /// The walks around the holes of those that are seen in the newest frame.
    fn walks(&self, pipeline: &mut AnyPipeline) -> HashMap<u64, Vec<Vec<u64>>>;
}

impl Follows for Tracker {
    type Kind = wire::Tracks;

    fn poll(&mut self, pipeline: &mut AnyPipeline) -> Option<Polled<wire::Tracks>> {
        let step = pipeline.poll_tracks(self)?;
        let events = step.events.iter().map(convert::track_event).collect();
        Some(Polled { number: step.number, time: step.time, events, left_out: step.left_out })
    }

    fn living(&self) -> Vec<wire::Track> {
        self.alive().map(convert::track).collect()
    }

    fn walks(&self, pipeline: &mut AnyPipeline) -> HashMap<u64, Vec<Vec<u64>>> {
        let walks = |region: &Region| {
            region.boundary().iter().map(|walk| walk.iter().map(|(vertex, _)| vertex.0).collect()).collect()
        };
        pipeline.track_regions(self).into_iter().map(|(id, region)| (id.0, walks(&region))).collect()
    }
}

impl Follows for SpaceTracker {
    type Kind = wire::SpaceTracks;

    fn poll(&mut self, pipeline: &mut AnyPipeline) -> Option<Polled<wire::SpaceTracks>> {
        let step = pipeline.poll_space_tracks(self)?;
        let events = step.events.iter().map(convert::space_track_event).collect();
        Some(Polled { number: step.number, time: step.time, events, left_out: step.left_out })
    }

    fn living(&self) -> Vec<wire::SpaceTrack> {
        self.alive().map(convert::space_track).collect()
    }

    fn walks(&self, pipeline: &mut AnyPipeline) -> HashMap<u64, Vec<Vec<u64>>> {
        let cycles = pipeline.track_cycles(self).into_iter();
        cycles.map(|(id, cycle)| (id.0, vec![cycle.iter().map(|vertex| vertex.0).collect()])).collect()
    }
}

/// Follows the tracks of a stream of one kind.
#[derive(Debug)]
pub struct Followed<T> {
    tracker: T,
    cycles: HashMap<u64, Arc<wire::TrackCycle>>,
    /// Whether a warning says that there are too many dots.
    has_warned: bool,
    /// Pays for frames.
    account: Arc<Account>,
}

/// A frame, shared.
type Shared<T> = Arc<TrackFrame<<T as Follows>::Kind>>;

impl<T: Follows> Followed<T> {
    fn new(tracker: T, account: Arc<Account>) -> Self {
        Self { tracker, cycles: HashMap::new(), has_warned: false, account }
    }

    fn poll(&mut self, pipeline: &mut AnyPipeline, with_cycles: bool) -> Option<Shared<T>> {
        let Polled { number, time, events, left_out } = self.tracker.poll(pipeline)?;
        if left_out > 0 && !self.has_warned {
            tracing::warn!(
                "frame {number}: the {left_out} least persistent of the cycles to be tracked are left out: choose \
                 fewer with --track"
            );
        }
        self.has_warned = left_out > 0;
        Some(self.frame(pipeline, (number, time), events, with_cycles))
    }

    fn with_cycles(&mut self, pipeline: &mut AnyPipeline, newest: &TrackFrame<T::Kind>) -> Option<Shared<T>> {
        let at = (newest.frame, newest.time);
        (!newest.has_cycles()).then(|| self.frame(pipeline, at, newest.events.clone(), true))
    }

    fn frame(
        &mut self,
        pipeline: &mut AnyPipeline,
        at: (u64, Option<f64>),
        events: Vec<<T::Kind as TrackKind>::Event>,
        with_cycles: bool,
    ) -> Shared<T> {
        let mut bytes = size_of::<TrackFrame<T::Kind>>() + size_of_val(events.as_slice());
        let tracks = self.tracker.living();
        if with_cycles {
            bytes += self.update_cycles(pipeline, &tracks);
        } else {
            self.cycles.clear();
        }
        // Centre and velocity, where they are not part of the track itself.
        let coordinates: usize = tracks.iter().filter_map(TrackState::dimension).sum();
        bytes += 2 * size_of::<f64>() * coordinates;
        let living = |track: <T::Kind as TrackKind>::Track| {
            let cycle = self.cycles.get(&track.id()).cloned();
            Living { track, cycle }
        };
        let living: Vec<Living<T::Kind>> = tracks.into_iter().map(living).collect();
        bytes += size_of_val(living.as_slice());
        Arc::new(TrackFrame::new(at, events, living, bytes, &self.account))
    }

    /// Finds the cycles of all living tracks. A track that is missing in the frame has none. Returns the memory that
    /// new cycles take.
    fn update_cycles(&mut self, pipeline: &mut AnyPipeline, tracks: &[<T::Kind as TrackKind>::Track]) -> usize {
        let mut bytes = 0;
        let mut walks = self.tracker.walks(pipeline);
        let cycles = tracks.iter().map(|track| {
            let id = track.id();
            let now = wire::TrackCycle { id, walks: walks.remove(&id).unwrap_or_default() };
            let known = self.cycles.get(&id).filter(|known| ***known == now).cloned();
            let cycle = known.unwrap_or_else(|| {
                bytes += 8 * now.walks.iter().map(Vec::len).sum::<usize>();
                Arc::new(now)
            });
            (id, cycle)
        });
        self.cycles = cycles.collect();
        bytes
    }
}
