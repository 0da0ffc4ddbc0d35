//! The textbook: all triangles, boundary reduction over Z/2, in the same total order. For small spaces, in tests.
//!
//! In: a space.
//! Out: tree and critical edges; whether a cycle is a boundary.
//! Must not know: lunes, anything of the sweep but its order.

use std::collections::{BTreeMap, BTreeSet};

use super::forest::Forest;
use super::{Pair, Persistence};
use crate::topology::metric::space::Distances;

/// All pairs up to a length, in order.
fn edges(space: &dyn Distances, limit: f64) -> Vec<Pair> {
    let all = (0..space.count() as u32).flat_map(|b| (0..b).map(move |a| (a, b)));
    let mut edges: Vec<Pair> = all.map(|(a, b)| Pair::new(space.length(a, b), a, b)).collect();
    edges.retain(|edge| edge.length <= limit && edge.length < f64::INFINITY);
    edges.sort_by(Pair::order);
    edges
}

/// The filtration up to a length.
pub fn persistence(space: &dyn Distances, limit: f64) -> Persistence {
    let count = space.count();
    let edges = edges(space, limit);
    let mut rank = vec![None; count * count];
    for (number, edge) in edges.iter().enumerate() {
        rank[edge.a as usize * count + edge.b as usize] = Some(number);
    }
    let mut forest = Forest::new(count);
    let is_tree: Vec<bool> = edges.iter().map(|edge| forest.join(edge.a, edge.b)).collect();
    let mut triangles: Vec<BTreeSet<usize>> = Vec::new();
    for a in 0..count {
        for b in a + 1..count {
            for c in b + 1..count {
                let sides = [rank[a * count + b], rank[a * count + c], rank[b * count + c]];
                if let [Some(ab), Some(ac), Some(bc)] = sides {
                    triangles.push([ab, ac, bc].into());
                }
            }
        }
    }
    triangles.sort_by_key(|triangle| triangle.iter().rev().copied().collect::<Vec<_>>());
    let mut reduced: Vec<Option<BTreeSet<usize>>> = vec![None; edges.len()];
    let mut deaths: Vec<Option<Pair>> = vec![None; edges.len()];
    for triangle in triangles {
        let last = triangle.last().copied().unwrap_or_default();
        let mut column = triangle;
        while let Some(&youngest) = column.last() {
            if let Some(other) = &reduced[youngest] {
                column = column.symmetric_difference(other).copied().collect();
            } else {
                deaths[youngest] = Some(edges[last]);
                reduced[youngest] = Some(column);
                break;
            }
        }
    }
    let births = edges.iter().zip(&is_tree).zip(&deaths).filter(|((_, is_tree), _)| !**is_tree);
    let critical = births.map(|((birth, _), death)| (*birth, *death));
    let lives = |&(birth, death): &(Pair, Option<Pair>)| death.is_none_or(|death| death.length > birth.length);
    Persistence {
        critical: critical.filter(lives).collect(),
        tree: edges.iter().zip(&is_tree).filter(|(_, is_tree)| **is_tree).map(|(edge, _)| *edge).collect(),
    }
}

/// Whether edges, given by their ends, bound a sum of triangles of at most this length.
pub fn is_boundary(space: &dyn Distances, length: f64, cycle: BTreeSet<[u32; 2]>) -> bool {
    let count = space.count() as u32;
    let is_edge = |a, b| space.length(a, b) <= length;
    let mut reduced: BTreeMap<[u32; 2], BTreeSet<[u32; 2]>> = BTreeMap::new();
    let reduce = |reduced: &BTreeMap<[u32; 2], BTreeSet<[u32; 2]>>, mut column: BTreeSet<[u32; 2]>| {
        while let Some(other) = column.last().and_then(|last| reduced.get(last)) {
            column = column.symmetric_difference(other).copied().collect();
        }
        column
    };
    for a in 0..count {
        for b in (a + 1..count).filter(|&b| is_edge(a, b)) {
            for c in (b + 1..count).filter(|&c| is_edge(a, c) && is_edge(b, c)) {
                let column = reduce(&reduced, [[a, b], [a, c], [b, c]].into());
                if let Some(&last) = column.last() {
                    reduced.insert(last, column);
                }
            }
        }
    }
    reduce(&reduced, cycle).is_empty()
}
