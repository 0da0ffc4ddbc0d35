//! What a tracker asks of a frame in R^d: its dots, short cycles of them, distances.
//!
//! In: the cloud and the skeleton of the frame, the metric.
//! Out: the answers of [`DetectionSource`] and [`CycleSource`].
//! Invariant: they depend on positions alone; ids only name vertices.
//! Must not know: tracks, earlier frames.

use std::sync::Arc;

use super::closing::Closing;
use crate::topology::cloud::{Cloud, Coordinates, Slot, VertexId};
use crate::topology::metric::space::Metric;
use crate::topology::pipeline::held::WholeSkeleton;
use crate::topology::skeleton::{Dot, Skeleton};
use crate::topology::tracks::{CycleDetection, CycleSource, DetectionSource, TrackedCycle, in_order};

/// The points of a cloud by their ids.
struct PointsById<'a> {
    cloud: &'a Cloud<Coordinates>,
    /// By id.
    slots: Vec<(VertexId, Slot)>,
}

impl<'a> PointsById<'a> {
    fn new(cloud: &'a Cloud<Coordinates>) -> Self {
        Self { cloud, slots: cloud.vertices().map(|(slot, vertex)| (vertex.id, slot)).collect() }
    }

    /// The point of a vertex that is there.
    fn point(&self, id: VertexId) -> Coordinates {
        let place = self.slots.partition_point(|&(other, _)| other < id);
        self.cloud.site(self.slots[place].1).clone()
    }
}

impl DetectionSource for WholeSkeleton<'_, Coordinates> {
    type Detection = CycleDetection;

    fn detections(&mut self, most: usize, least: f64) -> Vec<CycleDetection> {
        let points = PointsById::new(self.cloud);
        let detection = |dot: &Dot| {
            let critical = self.skeleton.critical(dot);
            let mut edge = dot.edge;
            edge.sort_unstable_by(|&a, &b| self.skeleton.vertices().compare(a, b));
            let ends = edge.map(|end| points.point(self.skeleton.vertices().id(end)));
            CycleDetection { critical, ends }
        };
        let mut detections: Vec<CycleDetection> = self.first_dots(most, least).into_iter().map(detection).collect();
        in_order(&mut detections);
        detections
    }
}

/// The cycles of a frame.
pub struct FrameCycles<'a> {
    metric: Metric,
    points: PointsById<'a>,
    closing: Closing<'a>,
}

impl<'a> FrameCycles<'a> {
    /// The cycles of the skeleton of a cloud. `places` has the vertices by id, each with its place in the order of
    /// positions.
    pub fn new(
        metric: Metric,
        cloud: &'a Cloud<Coordinates>,
        skeleton: &Skeleton,
        places: &'a [(VertexId, u32)],
    ) -> Self {
        Self { metric, points: PointsById::new(cloud), closing: Closing::new(skeleton, places) }
    }

    fn tracked(&self, ids: impl Iterator<Item = VertexId>) -> TrackedCycle {
        let vertices: Arc<[(VertexId, Coordinates)]> = ids.map(|id| (id, self.points.point(id))).collect();
        TrackedCycle { center: mean(&vertices), radius: self.radius(&vertices), vertices }
    }

    /// Half the largest distance between two of some vertices.
    fn radius(&self, vertices: &[(VertexId, Coordinates)]) -> f64 {
        let from = |(number, (_, a)): (usize, &(VertexId, Coordinates))| {
            let others = vertices[..number].iter();
            others.map(|(_, b)| self.distance(a.as_slice(), b.as_slice())).fold(0.0, f64::max)
        };
        0.5 * vertices.iter().enumerate().map(from).fold(0.0, f64::max)
    }
}

impl CycleSource for FrameCycles<'_> {
    fn cycle(&self, detection: &CycleDetection) -> TrackedCycle {
        self.tracked(self.closing.cycle(&detection.critical).into_iter())
    }

    fn along(&self, walk: &[VertexId]) -> TrackedCycle {
        self.tracked(walk.iter().copied())
    }

    fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        self.metric.distance(a, b).unwrap_or(f64::INFINITY)
    }
}

/// The mean of vertices, coordinate by coordinate. No sum of coordinates overflows.
fn mean(vertices: &[(VertexId, Coordinates)]) -> Vec<f64> {
    let mut mean = vec![0.0; vertices.first().map_or(0, |(_, point)| point.as_slice().len())];
    for (_, point) in vertices {
        mean.iter_mut().zip(point.as_slice()).for_each(|(sum, value)| *sum += value);
    }
    mean.iter_mut().for_each(|sum| *sum /= vertices.len() as f64);
    mean
}
