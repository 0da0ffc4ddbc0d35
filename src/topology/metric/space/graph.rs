//! A sparse graph of distances: all pairs that are not named are never joined.
//!
//! In: edges with lengths.
//! Out: a [`Graph`].
//! Invariants: each vertex has its neighbours in order. Memory is proportional to the edges.
//! Must not know: what the distances are of.

use super::Distances;
use super::error::{SpaceError, distance};

/// Distances of some pairs.
#[derive(Clone, Debug, PartialEq)]
pub struct Graph {
    /// Where the neighbours of each vertex begin, and where the last ones end.
    starts: Vec<usize>,
    neighbours: Vec<(u32, f64)>,
}

impl Graph {
    /// From pairs with their distance. A pair may be named more than once, with the same distance.
    ///
    /// # Errors
    /// [`SpaceError`] if a distance is negative or NaN, if a pair has two, if a vertex is beyond the count, or if one
    /// has a distance from itself.
    pub fn new(count: usize, edges: &[(u32, u32, f64)]) -> Result<Self, SpaceError> {
        let mut both: Vec<(u32, u32, f64)> = Vec::with_capacity(2 * edges.len());
        for &(a, b, value) in edges {
            let (i, j) = (a as usize, b as usize);
            if i.max(j) >= count {
                return Err(SpaceError::NoSuchPoint { point: i.max(j), count });
            }
            let value = distance(i, j, value)?;
            if i == j && value != 0.0 {
                return Err(SpaceError::Diagonal { point: i, value });
            }
            if i != j {
                both.extend([(a, b, value), (b, a, value)]);
            }
        }
        both.sort_unstable_by(|x, y| (x.0, x.1).cmp(&(y.0, y.1)).then(x.2.total_cmp(&y.2)));
        both.dedup();
        if let Some(twice) = both.windows(2).find(|pair| (pair[0].0, pair[0].1) == (pair[1].0, pair[1].1)) {
            let (a, b) = (twice[0].0 as usize, twice[0].1 as usize);
            return Err(SpaceError::Asymmetric { a, b, there: twice[0].2, back: twice[1].2 });
        }
        let mut starts = vec![0; count + 1];
        for &(a, _, _) in &both {
            starts[a as usize + 1] += 1;
        }
        for vertex in 0..count {
            starts[vertex + 1] += starts[vertex];
        }
        Ok(Self { starts, neighbours: both.into_iter().map(|(_, b, value)| (b, value)).collect() })
    }

    /// These vertices alone; they must be in increasing order.
    pub fn subset(&self, chosen: &[u32]) -> Self {
        let mut starts = vec![0];
        let mut neighbours = Vec::new();
        for &vertex in chosen {
            let kept = self.neighbours(vertex).iter();
            neighbours.extend(kept.filter_map(|&(b, value)| {
                let place = chosen.binary_search(&b).ok()?;
                Some((place as u32, value))
            }));
            starts.push(neighbours.len());
        }
        Self { starts, neighbours }
    }

    /// The neighbours of a vertex in order, with their distances.
    pub fn neighbours(&self, vertex: u32) -> &[(u32, f64)] {
        &self.neighbours[self.starts[vertex as usize]..self.starts[vertex as usize + 1]]
    }
}

impl Distances for Graph {
    fn count(&self) -> usize {
        self.starts.len() - 1
    }

    fn length(&self, a: u32, b: u32) -> f64 {
        if a == b {
            return 0.0;
        }
        let neighbours = self.neighbours(a);
        neighbours.binary_search_by_key(&b, |&(b, _)| b).map_or(f64::INFINITY, |at| neighbours[at].1)
    }

    fn lengths(&self, a: u32, first: u32, out: &mut [f64]) {
        out.fill(f64::INFINITY);
        let neighbours = self.neighbours(a);
        let from = neighbours.partition_point(|&(b, _)| b < first);
        for &(b, value) in &neighbours[from..] {
            let Some(out) = out.get_mut((b - first) as usize) else { break };
            *out = value;
        }
        if let Some(own) = a.checked_sub(first).and_then(|place| out.get_mut(place as usize)) {
            *own = 0.0;
        }
    }

    fn radius(&self, length: f64) -> f64 {
        0.5 * length
    }
}
