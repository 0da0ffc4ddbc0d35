//! The cycle that is born with a dot, by ids: its critical edge, closed by the shortest path in the tree and in the
//! critical edges that come before it.
//!
//! In: a skeleton, and where its vertices stand in the order of positions; dots by their ids.
//! Out: closed walks by ids.
//! Invariants: ties are decided by the places of vertices in the order of positions, as [`SkeletonGraph`] says. So a
//! cycle depends on positions alone, unlike that of [`ShortestCycles`](crate::topology::ShortestCycles), which needs no
//! positions.
//! Must not know: tracks.

use crate::topology::cloud::VertexId;
use crate::topology::skeleton::{Critical, Skeleton, SkeletonGraph};

/// The graph of a skeleton.
#[derive(Debug)]
pub struct Closing<'a> {
    /// The vertices by id, each with its place in the order of positions.
    places: &'a [(VertexId, u32)],
    /// The id at each place.
    ids: Vec<VertexId>,
    /// Vertices are numbered by their places.
    graph: SkeletonGraph,
}

impl<'a> Closing<'a> {
    /// Reads the graph of a skeleton whose vertices are among these, each with its place in the order of positions.
    pub fn new(skeleton: &Skeleton, places: &'a [(VertexId, u32)]) -> Self {
        let mut ids = vec![VertexId(0); places.len()];
        places.iter().for_each(|&(id, place)| ids[place as usize] = id);
        let vertices = skeleton.vertices();
        let graph = SkeletonGraph::new(skeleton, places.len(), |vertex| place_of(places, vertices.id(vertex)));
        Self { places, ids, graph }
    }

    /// The cycle of a dot of the skeleton.
    pub fn cycle(&self, dot: &Critical) -> Vec<VertexId> {
        let edge = dot.edge.map(|end| place_of(self.places, end));
        self.graph.cycle(edge, dot.birth).into_iter().map(|place| self.ids[place as usize]).collect()
    }
}

/// The place of a vertex in the order of positions.
fn place_of(places: &[(VertexId, u32)], id: VertexId) -> u32 {
    places[places.partition_point(|&(other, _)| other < id)].1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::cloud::Vertices;
    use crate::topology::metric::rips::Workspace;
    use crate::topology::metric::space::{Metric, Points};

    #[test]
    fn a_cycle_goes_over_the_tree_and_earlier_critical_edges_alone() {
        // A square of side 1, and a longer rectangle to its right that is born later.
        let cloud = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0], [2.25, 0.0], [2.25, 1.0]];
        let points = Points::new(Metric::Euclidean, 2, cloud.as_flattened()).unwrap();
        let names: Vertices =
            points.rows().iter().map(|&row| (VertexId(row.into()), &cloud[row as usize][..])).collect();
        let skeleton = Skeleton::of_space(&points, &names, None, &mut Workspace::default());
        let places: Vec<(VertexId, u32)> = names.ids().iter().copied().zip(0..).collect();
        let closing = Closing::new(&skeleton, &places);
        let cycle = |birth: f64| {
            let dot = skeleton.dots().iter().find(|dot| dot.birth == birth).unwrap();
            let mut cycle: Vec<u64> = closing.cycle(&skeleton.critical(dot)).iter().map(|id| id.0).collect();
            cycle.sort_unstable();
            cycle
        };
        assert_eq!(skeleton.dots().len(), 2);
        assert_eq!(cycle(0.5), [0, 1, 2, 3]);
        // By the tree alone it would go around both.
        assert_eq!(cycle(0.625), [2, 3, 4, 5]);
    }
}
