//! Layouts: places in two or three dimensions for the vertices of a space that has more of them, or none.
//!
//! In: vertices, and the metric of their coordinates or the distances between them; perhaps the layout of the frame
//! before.
//! Out: a [`Layout`].
//! Invariants: the same input has the same places, to the last bit, on any number of threads. Points with no more
//! coordinates than there are axes stay where they are. Points of R^d are projected on their principal components, so
//! their places do not depend on their order; where only distances are given, places are those of classical
//! multidimensional scaling. A layout that follows another one is turned onto it, so that a picture does not jump.
//! Must not know: pictures, files, frames.
//!
//! Missing distances are those of shortest paths. What no path joins is laid out by itself, and stands beside the rest.
//! Directions, which the metric `angular` compares, are points of the unit sphere.

mod beside;
mod eigen;
mod mds;
mod paths;
mod pca;
mod procrustes;

use std::borrow::Cow;
use std::collections::HashMap;

use hopes::topology::spaces::{Metric, Space};
use hopes::topology::{Positions, VertexId, Vertices};

use mds::Scaling;
use paths::Paths;
use pca::Principal;
use procrustes::Motion;

/// At most so many landmarks place all others.
const LANDMARKS: usize = 128;
/// At most so many landmarks in all parts together, unless there are very many parts.
const ALL_LANDMARKS: usize = 1024;
/// About so many distances are read for shortest paths in a matrix.
const STEPS: usize = 1 << 31;

/// What a space is given by.
#[derive(Clone, Copy, Debug)]
pub enum Shape<'a> {
    /// Coordinates, and how distances are taken of them.
    Points(Metric),
    /// Distances of the vertices, in their order.
    Distances(&'a Space),
}

/// Places of vertices along `K` axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout<const K: usize> {
    ids: Vec<VertexId>,
    places: Vec<[f64; K]>,
    kind: Kind<K>,
    metric: Option<Metric>,
    motion: Option<Motion<K>>,
}

/// How places were found.
#[derive(Clone, Debug, PartialEq)]
enum Kind<const K: usize> {
    /// They are the coordinates; those that are lacking are 0.
    Coordinates,
    /// By principal components.
    Principal(Principal<K>),
    /// By distances: what the axes hold of them, from 0 to 1, and in how many parts.
    Scaling { share: f64, parts: usize },
}

/// How places were found, for people.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Account<'a> {
    /// They are the coordinates.
    Coordinates,
    /// By principal components: what each holds of the variance, from 0 to 1.
    Principal(&'a [f64]),
    /// By classical multidimensional scaling.
    Scaling {
        /// What the axes hold of the squared distances from the mean, from 0 to 1.
        share: f64,
        /// Parts that no path joins.
        parts: usize,
    },
}

impl<const K: usize> Layout<K> {
    /// Places vertices, as near as possible to where those of them that were there were before. The ids of vertices
    /// are all different.
    pub fn new(vertices: &Vertices, shape: Shape<'_>, before: Option<&Self>) -> Self {
        let ids = vertices.ids().to_vec();
        let mut layout = match shape {
            Shape::Points(metric) => Self::of_points(ids, vertices, metric),
            Shape::Distances(space) => Self::of_distances(ids, space),
        };
        if let Some(before) = before {
            layout.turn_onto(before);
        }
        layout
    }

    fn of_points(ids: Vec<VertexId>, vertices: &Vertices, metric: Metric) -> Self {
        let points = vertices.iter().map(|(_, point)| embedded(metric, point));
        let kind = if vertices.dimension() <= K {
            Kind::Coordinates
        } else if metric == Metric::Angular {
            let points: Vec<Cow<'_, [f64]>> = points.clone().collect();
            Kind::Principal(Principal::new(&ids.iter().copied().zip(points.iter().map(AsRef::as_ref)).collect()))
        } else {
            Kind::Principal(Principal::new(vertices))
        };
        let places = points.map(|point| kind.place(&point)).collect();
        Self { ids, places, kind, metric: Some(metric), motion: None }
    }

    fn of_distances(ids: Vec<VertexId>, space: &Space) -> Self {
        if paths::is_whole(space) {
            let scaling = Scaling::new(space.distances(), LANDMARKS);
            return Self::scaled(ids, scaling.places, [scaling.held, scaling.total], 1);
        }
        let parts = paths::parts(space);
        let mut places = vec![[0.0; K]; ids.len()];
        let mut sums = [0.0; 2];
        let mut laid = Vec::with_capacity(parts.len());
        for part in &parts {
            let alone = space.subset(part);
            let scaling = Scaling::new(&Paths { space: &alone }, landmarks(&alone, part.len(), ids.len(), K));
            let weight = part.len() as f64;
            sums = [sums[0] + weight * scaling.held, sums[1] + weight * scaling.total];
            laid.push(scaling.places);
        }
        beside::lay_beside(&mut laid);
        for (part, laid) in parts.iter().zip(laid) {
            for (&vertex, place) in part.iter().zip(laid) {
                places[vertex as usize] = place;
            }
        }
        Self::scaled(ids, places, sums, parts.len())
    }

    fn scaled(ids: Vec<VertexId>, places: Vec<[f64; K]>, [held, total]: [f64; 2], parts: usize) -> Self {
        let share = if total > 0.0 { held / total } else { 1.0 };
        Self { ids, places, kind: Kind::Scaling { share, parts }, metric: None, motion: None }
    }

    /// Coordinates have a direction of their own; all other axes are only as good as turned ones.
    fn turn_onto(&mut self, before: &Self) {
        if self.kind == Kind::Coordinates {
            return;
        }
        let known: HashMap<VertexId, [f64; K]> =
            before.ids.iter().copied().zip(before.places.iter().copied()).collect();
        let shared = self.ids.iter().zip(&self.places);
        let pairs: Vec<_> = shared.filter_map(|(id, &place)| Some((place, *known.get(id)?))).collect();
        self.motion = Motion::fitting(&pairs);
        if let Some(motion) = &self.motion {
            self.places.iter_mut().for_each(|place| *place = motion.place(*place));
        }
    }

    /// Where each vertex is.
    pub fn places(&self) -> &[[f64; K]] {
        &self.places
    }

    /// Where the vertices of a simplified view are.
    pub fn of_positions(&self, positions: &Positions) -> Vec<[f64; K]> {
        match positions {
            Positions::Labels(labels) => labels.iter().map(|&label| self.places[label as usize]).collect(),
            Positions::Coordinates { dimension, flat } => {
                flat.chunks(*dimension).map(|point| self.of_point(point)).collect()
            }
        }
    }

    fn of_point(&self, point: &[f64]) -> [f64; K] {
        let place = self.kind.place(&embedded(self.metric.unwrap_or_default(), point));
        self.motion.as_ref().map_or(place, |motion| motion.place(place))
    }

    /// How places were found.
    pub fn account(&self) -> Account<'_> {
        match &self.kind {
            Kind::Coordinates => Account::Coordinates,
            Kind::Principal(principal) => Account::Principal(&principal.shares),
            &Kind::Scaling { share, parts } => Account::Scaling { share, parts },
        }
    }

    /// The metric of the coordinates that places are of.
    pub fn metric(&self) -> Option<Metric> {
        self.metric
    }

    /// Whether lengths between places are distances of the space, or projections of them.
    pub fn has_lengths(&self) -> bool {
        self.metric.is_none_or(|metric| metric == Metric::Euclidean)
    }
}

impl<const K: usize> Kind<K> {
    fn place(&self, point: &[f64]) -> [f64; K] {
        if let Self::Principal(principal) = self {
            return principal.place(point);
        }
        let mut place = [0.0; K];
        place.iter_mut().zip(point).for_each(|(place, x)| *place = *x);
        place
    }
}

/// The point whose place is sought: of a direction, that on the unit sphere.
fn embedded(metric: Metric, point: &[f64]) -> Cow<'_, [f64]> {
    let largest = point.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    if metric != Metric::Angular || largest == 0.0 {
        return point.into();
    }
    let norm = point.iter().map(|x| (x / largest) * (x / largest)).sum::<f64>().sqrt();
    point.iter().map(|x| x / largest / norm).collect()
}

/// How many landmarks a part may have: enough to span the axes, and not more than can be paid for.
fn landmarks(space: &Space, size: usize, of: usize, axes: usize) -> usize {
    let share = ALL_LANDMARKS * size / of.max(1);
    let affordable = if matches!(space, Space::Graph(_)) { LANDMARKS } else { STEPS / (size * size) };
    share.min(affordable).clamp(axes + 1, LANDMARKS)
}

#[cfg(test)]
mod tests;
