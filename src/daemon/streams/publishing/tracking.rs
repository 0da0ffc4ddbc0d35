//! Tracking in one stream: from its pipeline to frames of the track log.
//!
//! In: the stream's pipeline, once per frame in which a consumer wants tracks. Out: [`TrackFrame`]s.
//!
//! Invariants: cycles are found only if a consumer wants them; unchanged ones are shared with the frame before.
//!
//! Must not know: the log, consumers, how tracks are found.

use std::collections::HashMap;
use std::sync::Arc;

use hopes::topology::{Region, TrackOptions, Tracker};
use hopes_protocol as wire;

use super::track_log::{Living, TrackFrame};
use crate::daemon::memory::Account;
use crate::daemon::streams::convert;
use crate::daemon::streams::pipeline::AnyPipeline;

/// Follows the tracks of a stream.
#[derive(Debug)]
pub struct Tracking {
    tracker: Tracker,
    cycles: HashMap<u64, Arc<wire::TrackCycle>>,
    /// Whether a warning says that there are too many dots.
    has_warned: bool,
    /// Pays for frames.
    account: Arc<Account>,
}

impl Tracking {
    /// No frame was seen yet.
    pub fn new(options: TrackOptions, account: Arc<Account>) -> Self {
        Self { tracker: Tracker::new(options), cycles: HashMap::new(), has_warned: false, account }
    }

    /// What has happened up to the newest frame, unless that was asked before.
    pub fn poll(&mut self, pipeline: &mut AnyPipeline, with_cycles: bool) -> Option<TrackFrame> {
        let step = pipeline.poll_tracks(&mut self.tracker)?;
        if step.left_out > 0 && !self.has_warned {
            tracing::warn!(
                "frame {}: the {} least persistent of the cycles to be tracked are left out: choose fewer with --track",
                step.number,
                step.left_out
            );
        }
        self.has_warned = step.left_out > 0;
        let events: Vec<wire::TrackEvent> = step.events.iter().map(convert::track_event).collect();
        Some(self.frame(pipeline, step.number, step.time, events, with_cycles))
    }

    /// The newest frame again, with cycles.
    pub fn with_cycles(&mut self, pipeline: &mut AnyPipeline, before: &TrackFrame) -> TrackFrame {
        self.frame(pipeline, before.frame, before.time, before.events.clone(), true)
    }

    fn frame(
        &mut self,
        pipeline: &mut AnyPipeline,
        frame: u64,
        time: Option<f64>,
        events: Vec<wire::TrackEvent>,
        with_cycles: bool,
    ) -> TrackFrame {
        let mut bytes = size_of::<TrackFrame>() + size_of_val(events.as_slice());
        if with_cycles {
            bytes += self.update_cycles(pipeline);
        } else {
            self.cycles.clear();
        }
        let living = |track| {
            let track = convert::track(track);
            Living { track, cycle: self.cycles.get(&track.id).cloned() }
        };
        let living: Vec<Living> = self.tracker.alive().map(living).collect();
        bytes += size_of_val(living.as_slice());
        TrackFrame::new((frame, time), events, living, bytes, &self.account)
    }

    /// Finds the cycles of all living tracks. A track that is missing in the frame has none. Returns the memory that
    /// new cycles take.
    fn update_cycles(&mut self, pipeline: &mut AnyPipeline) -> usize {
        let mut bytes = 0;
        let regions: HashMap<u64, Region> =
            pipeline.track_regions(&self.tracker).into_iter().map(|(id, region)| (id.0, region)).collect();
        let cycles = self.tracker.alive().map(|track| {
            let id = track.id.0;
            let now = wire::TrackCycle { id, walks: regions.get(&id).map_or(Vec::new(), walks) };
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

fn walks(region: &Region) -> Vec<Vec<u64>> {
    region.boundary().iter().map(|walk| walk.iter().map(|(vertex, _)| vertex.0).collect()).collect()
}
