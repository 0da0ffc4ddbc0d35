//! The public state of a stream: its identity, its numbers, what it publishes.
//!
//! In: what the engine counts and publishes. Out: the same, to connections and metrics.
//!
//! Invariants: identity never changes; numbers are read without a lock.
//!
//! Must not know: the queue, the engine, cursors, connections.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use hopes_protocol as wire;

use super::convert::{self, Shape};
use super::frame_times::FrameTimes;
use super::pipeline::{PipelineOptions, SpaceRule};
use super::publishing::published::Published;
use crate::daemon::memory::{Account, Memory};

/// The part of a stream that is shared.
#[derive(Debug)]
pub struct StreamState {
    /// Unique as long as the daemon runs.
    pub number: u32,
    /// Its name.
    pub name: String,
    /// Differs between streams of one name.
    pub epoch: u64,
    /// Which points stay.
    pub options: PipelineOptions,
    /// The space of its points, unless that is the plane.
    pub space: Option<StreamSpace>,
    /// What it publishes beside its views.
    pub published: Published,
    /// What is counted.
    pub stats: Stats,
    /// What is held for it.
    pub accounts: Accounts,
}

/// The memory of a stream.
#[derive(Debug)]
pub struct Accounts {
    /// Points, and their triangulation.
    pub points: Arc<Account>,
    /// Views that are followed, their history and their snapshots; tracks and dots.
    pub views: Arc<Account>,
    /// Points that wait.
    pub queue: Arc<Account>,
}

impl Accounts {
    /// Parts of a daemon's memory.
    pub fn new(memory: &Memory) -> Self {
        let part = || Account::part_of(&memory.whole);
        Self { points: Account::part_of(&memory.points), views: part(), queue: part() }
    }

    /// Bytes held for the stream.
    pub fn held(&self) -> u64 {
        self.points.held() + self.views.held() + self.queue.held()
    }
}

impl StreamState {
    /// A stream without frames.
    pub fn new(number: u32, name: String, epoch: u64, options: PipelineOptions, accounts: Accounts) -> Self {
        let space = options.space.map(StreamSpace::new);
        let (published, stats) = (Published::new(shape_of(space.as_ref())), Stats::default());
        Self { number, name, epoch, options, space, published, stats, accounts }
    }

    /// Which messages its frames are.
    pub fn shape(&self) -> Shape {
        shape_of(self.space.as_ref())
    }

    /// Its entry in a list of streams in spaces, if it is one.
    pub fn space_info(&self) -> Option<wire::SpaceInfo> {
        let space = self.space.as_ref()?;
        Some(wire::SpaceInfo { stream: self.number, metric: space.metric, dimension: space.dimension() })
    }

    /// The first message of a subscription to it.
    pub fn opened(&self) -> wire::StreamOpened {
        wire::StreamOpened {
            stream: self.number,
            name: self.name.clone(),
            epoch: self.epoch,
            window: convert::wire_window(self.options.window),
            resolution: self.options.resolution,
            frame: self.stats.frame(),
        }
    }

    /// What is measured of it beyond its status.
    pub fn measured(&self) -> Measured {
        let stats = &self.stats;
        Measured {
            name: self.name.clone(),
            refused_late: stats.refused_late.load(Ordering::Relaxed),
            restarts: stats.restarts.load(Ordering::Relaxed),
            times: stats.times.clone(),
        }
    }

    /// Its entry in a list of streams.
    pub fn info(&self, producers: usize) -> wire::StreamInfo {
        let stats = &self.stats;
        wire::StreamInfo {
            stream: self.number,
            name: self.name.clone(),
            epoch: self.epoch,
            window: convert::wire_window(self.options.window),
            resolution: self.options.resolution,
            frame: stats.frame(),
            points: stats.points.load(Ordering::Relaxed),
            vertices: stats.vertices.load(Ordering::Relaxed),
            producers: producers as u32,
            consumers: stats.consumers.load(Ordering::Relaxed) as u32,
        }
    }
}

fn shape_of(space: Option<&StreamSpace>) -> Shape {
    space.map_or(Shape::Plane, |space| Shape::Space { metric: space.metric, dimension: space.dimension().unwrap_or(0) })
}

/// The space of a stream's points.
#[derive(Debug)]
pub struct StreamSpace {
    /// The metric.
    pub metric: wire::Metric,
    /// The most distinct positions.
    pub max_vertices: u64,
    /// The number of coordinates of a point; 0 before the first one.
    dimension: AtomicU32,
}

impl StreamSpace {
    fn new(rule: SpaceRule) -> Self {
        let dimension = rule.known_dimension().unwrap_or(0) as u32;
        let (metric, max_vertices) = (convert::wire_metric(rule.metric), rule.max_vertices as u64);
        Self { metric, max_vertices, dimension: AtomicU32::new(dimension) }
    }

    /// The number of coordinates of a point, once that is settled.
    pub fn dimension(&self) -> Option<u32> {
        Some(self.dimension.load(Ordering::Acquire)).filter(|&dimension| dimension > 0)
    }

    /// Settles the dimension, unless it is settled. Returns what it is from now on.
    pub fn settle(&self, dimension: u32) -> u32 {
        match self.dimension.compare_exchange(0, dimension, Ordering::AcqRel, Ordering::Acquire) {
            Ok(_) => dimension,
            Err(settled) => settled,
        }
    }
}

/// What is measured of a stream beyond its status.
#[derive(Clone, Debug, Default)]
pub struct Measured {
    /// The stream's name.
    pub name: String,
    /// Points and retractions that were accepted, and refused at their commit.
    pub refused_late: u64,
    /// How often the time window has started anew.
    pub restarts: u64,
    /// How long frames take.
    pub times: FrameTimes,
}

/// What is counted of a stream.
#[derive(Debug, Default)]
pub struct Stats {
    frame: AtomicU64,
    /// Points in the window.
    pub points: AtomicU64,
    /// Distinct positions.
    pub vertices: AtomicU64,
    /// Cursors.
    pub consumers: AtomicU64,
    /// Skeletons computed.
    pub computed: AtomicU64,
    /// Points accepted.
    pub accepted: AtomicU64,
    /// Points refused when they came.
    pub refused: AtomicU64,
    /// Points and retractions that were accepted, and refused at their commit.
    pub refused_late: AtomicU64,
    /// How often the time window has started anew.
    pub restarts: AtomicU64,
    /// Frames that a consumer got merged with others.
    pub lagged: AtomicU64,
    /// How long frames take.
    pub times: FrameTimes,
}

impl Stats {
    /// The newest frame.
    pub fn frame(&self) -> u64 {
        self.frame.load(Ordering::Acquire)
    }

    /// Another frame was closed.
    pub fn set_frame(&self, frame: u64) {
        self.frame.store(frame, Ordering::Release);
    }
}
