//! Points of R^d under one of the metrics.
//!
//! In: coordinates of points, row by row.
//! Out: [`Points`]: their distinct positions, and lengths.
//! Invariants: vertices are in lexicographic order of their coordinates and all different. -0 is 0. A length does not
//! depend on where the points stand in memory.
//! Must not know: streams, ids.
//!
//! Points stand in blocks of eight, coordinate by coordinate, so that eight lengths are summed at once in any
//! dimension. Points of few coordinates also stand one by one, for single lengths.

use super::Distances;
use super::error::SpaceError;
use super::measure::{LANES, Lane, Metric};
use crate::topology::base::MAX_MAGNITUDE;

/// So many coordinates are few.
const FEW: usize = 4;

/// Distinct points of R^d.
#[derive(Clone, Debug)]
pub struct Points {
    metric: Metric,
    /// Coordinates of a block.
    width: usize,
    blocks: Vec<Lane>,
    /// Each point by itself, with zeros behind its coordinates; empty if it has more.
    singles: Vec<[f64; FEW]>,
    /// The first of the given points at each vertex.
    rows: Vec<u32>,
    /// The vertex of each given point.
    vertices: Vec<u32>,
}

impl Points {
    /// The distinct ones of points of so many coordinates each.
    ///
    /// # Errors
    /// [`SpaceError`] if a coordinate or the dimension does not suit the metric.
    pub fn new(metric: Metric, dimension: usize, coordinates: &[f64]) -> Result<Self, SpaceError> {
        check(metric, dimension, coordinates)?;
        let row = |point: u32| &coordinates[point as usize * dimension..][..dimension];
        let mut order: Vec<u32> = (0..(coordinates.len() / dimension) as u32).collect();
        order.sort_unstable_by(|&p, &q| compare(row(p), row(q)).then(p.cmp(&q)));
        let mut vertices = vec![0; order.len()];
        let mut rows: Vec<u32> = Vec::with_capacity(order.len());
        for point in order {
            if rows.last().is_none_or(|&last| row(last) != row(point)) {
                rows.push(point);
            }
            vertices[point as usize] = rows.len() as u32 - 1;
        }
        let width = metric.width(dimension);
        let mut points = Self { metric, width, blocks: Vec::new(), singles: Vec::new(), rows, vertices };
        points.fill(|point| row(point))?;
        Ok(points)
    }

    /// Copies the vertices into blocks. What is left of the last block stays zero.
    fn fill<'a>(&mut self, row: impl Fn(u32) -> &'a [f64]) -> Result<(), SpaceError> {
        self.blocks = vec![[0.0; LANES]; self.rows.len().div_ceil(LANES) * self.width];
        let mut place = vec![0.0; self.width];
        for (vertex, &point) in self.rows.iter().enumerate() {
            self.metric.place(point as usize, row(point), &mut place)?;
            let block = &mut self.blocks[vertex / LANES * self.width..][..self.width];
            for (lane, value) in block.iter_mut().zip(&place) {
                lane[vertex % LANES] = value + 0.0;
            }
        }
        self.fill_singles();
        Ok(())
    }

    fn fill_singles(&mut self) {
        if self.width > FEW {
            return;
        }
        let single = |vertex: usize| {
            let mut single = [0.0; FEW];
            for (value, lane) in single.iter_mut().zip(self.block(vertex / LANES)) {
                *value = lane[vertex % LANES];
            }
            single
        };
        self.singles = (0..self.rows.len()).map(single).collect();
    }

    /// The metric.
    pub fn metric(&self) -> Metric {
        self.metric
    }

    /// The first of the given points at each vertex, in order of vertices.
    pub fn rows(&self) -> &[u32] {
        &self.rows
    }

    /// The vertex of each given point.
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// These vertices alone; they must be in increasing order.
    pub fn subset(&self, chosen: &[u32]) -> Self {
        let mut points = Self {
            metric: self.metric,
            width: self.width,
            blocks: vec![[0.0; LANES]; chosen.len().div_ceil(LANES) * self.width],
            singles: Vec::new(),
            rows: chosen.iter().map(|&vertex| self.rows[vertex as usize]).collect(),
            vertices: Vec::new(),
        };
        for (vertex, &old) in chosen.iter().enumerate() {
            let from = self.block(old as usize / LANES);
            let to = &mut points.blocks[vertex / LANES * self.width..][..self.width];
            for (to, from) in to.iter_mut().zip(from) {
                to[vertex % LANES] = from[old as usize % LANES];
            }
        }
        points.fill_singles();
        points
    }

    /// The vertex that is nearest to a point of the same dimension; the first one of equally near ones. None without
    /// vertices.
    ///
    /// # Errors
    /// [`SpaceError`] if the point has no distances.
    pub fn nearest(&self, point: &[f64]) -> Result<Option<u32>, SpaceError> {
        let mut place = vec![0.0; self.width];
        self.metric.place(0, point, &mut place)?;
        let block: Vec<Lane> = place.into_iter().map(|value| [value; LANES]).collect();
        let lengths = |number: usize| self.metric.lengths(&block, 0, self.block(number));
        let all = (0..self.rows.len().div_ceil(LANES)).flat_map(lengths).take(self.rows.len());
        Ok(all.zip(0..).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(_, vertex)| vertex))
    }

    #[inline]
    fn block(&self, number: usize) -> &[Lane] {
        &self.blocks[number * self.width..][..self.width]
    }
}

impl Distances for Points {
    fn count(&self) -> usize {
        self.rows.len()
    }

    #[inline]
    fn length(&self, a: u32, b: u32) -> f64 {
        let (a, b) = (a as usize, b as usize);
        if let (Some(p), Some(q)) = (self.singles.get(a), self.singles.get(b)) {
            return self.metric.sum(p.iter().zip(q).map(|(p, q)| p - q));
        }
        self.metric.length(self.block(a / LANES), a % LANES, self.block(b / LANES), b % LANES)
    }

    fn lengths(&self, a: u32, first: u32, out: &mut [f64]) {
        let (from, lane) = (self.block(a as usize / LANES), a as usize % LANES);
        let mut vertex = first as usize;
        let mut rest = out;
        while !rest.is_empty() {
            let lengths = self.metric.lengths(from, lane, self.block(vertex / LANES));
            let skipped = vertex % LANES;
            let here = rest.len().min(LANES - skipped);
            let (now, later) = rest.split_at_mut(here);
            match <&mut Lane>::try_from(&mut *now) {
                Ok(whole) => *whole = lengths,
                Err(_) => now.copy_from_slice(&lengths[skipped..skipped + here]),
            }
            (rest, vertex) = (later, vertex + here);
        }
    }

    fn is_costly(&self) -> bool {
        self.width > LANES
    }

    fn radius(&self, length: f64) -> f64 {
        self.metric.radius(length)
    }
}

fn check(metric: Metric, dimension: usize, coordinates: &[f64]) -> Result<(), SpaceError> {
    metric.check_dimension(dimension)?;
    if !coordinates.len().is_multiple_of(dimension) {
        return Err(SpaceError::Ragged { values: coordinates.len(), dimension });
    }
    match coordinates.iter().position(|value| value.is_nan() || value.abs() > MAX_MAGNITUDE) {
        Some(at) => {
            Err(SpaceError::Coordinate { point: at / dimension, coordinate: at % dimension, value: coordinates[at] })
        }
        None => Ok(()),
    }
}

/// Lexicographic order of finite coordinates; 0 and -0 are equal.
fn compare(p: &[f64], q: &[f64]) -> std::cmp::Ordering {
    p.partial_cmp(q).unwrap_or(std::cmp::Ordering::Equal)
}
