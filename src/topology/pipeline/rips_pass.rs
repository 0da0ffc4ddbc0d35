//! The skeleton of a metric space, in one pass.
//!
//! In: a space, what its vertices are called, how far the filtration goes; closed walks.
//! Out: a [`Skeleton`]; for each walk, the dots that it is the sum of.
//! Invariants: it depends on the space alone. Vertices that are one point under two names are one. A dot is left out
//! where its persistence is at most 1e-12 of its death, as in the plane.
//! Must not know: frames, streams, how lengths are computed.

use crate::topology::cloud::{VertexId, Vertices};
use crate::topology::metric::rips::{self, Class, ClosedWalk, Pair, Persistence, Workspace};
use crate::topology::metric::space::Distances;
use crate::topology::metric::twins::representatives;
use crate::topology::plane::elements::DIAGONAL;
use crate::topology::skeleton::{Dot, Edge, EdgeId, Killer, Skeleton};

impl Skeleton {
    /// The skeleton of a finite metric space by its Vietoris-Rips filtration (Kurlin 2015, section 2), up to the scale
    /// `threshold`, a radius. Cycles that are alive there never die.
    ///
    /// `names` has the vertices in the order of the space, with any ids; without coordinates where there are none.
    /// Those of one point under two names are represented by the first. The workspace may be that of the frame before.
    ///
    /// # Panics
    /// If there are not as many names as vertices, or more than [`MAX_VERTICES`](rips::MAX_VERTICES).
    pub fn of_space(
        space: &dyn Distances,
        names: &Vertices,
        threshold: Option<f64>,
        workspace: &mut Workspace,
    ) -> Self {
        Self::with_classes(space, names, threshold, &[], workspace).0
    }

    /// The same, and the critical edges of the dots that closed walks are the sums of, found in the same sweep; none
    /// where a step of a walk is no edge.
    pub(super) fn with_classes(
        space: &dyn Distances,
        names: &Vertices,
        threshold: Option<f64>,
        walks: &[ClosedWalk],
        workspace: &mut Workspace,
    ) -> (Self, Vec<Option<Vec<EdgeId>>>) {
        assert_eq!(space.count(), names.len(), "each vertex has a name");
        let limit = threshold.map_or(f64::MAX, |radius| space.longest(radius));
        let (persistence, classes) = rips::persistence_and_classes(space, limit, walks, workspace);
        let places = Places::new(names, &representatives(space, &persistence));
        let skeleton = places.skeleton(space, names, &persistence);
        let id = |pair: Pair| skeleton.edge_id(places.edge(pair));
        let dots = |class: Class| class.dots.into_iter().map(id).collect();
        let classes = classes.into_iter().map(|class| class.map(dots)).collect();
        (skeleton, classes)
    }
}

/// Where the vertices of a space stand in its skeleton.
struct Places {
    /// The vertices that stand for themselves, by id.
    kept: Vec<u32>,
    /// The place of each vertex among them; of another one, that of its representative.
    place: Vec<u32>,
}

impl Places {
    fn new(names: &Vertices, representatives: &[u32]) -> Self {
        let mut kept: Vec<u32> = (0..names.len() as u32).filter(|&v| representatives[v as usize] == v).collect();
        kept.sort_unstable_by_key(|&vertex| names.id(vertex));
        let mut place = vec![0; names.len()];
        for (at, &vertex) in kept.iter().enumerate() {
            place[vertex as usize] = at as u32;
        }
        for (vertex, &first) in representatives.iter().enumerate() {
            place[vertex] = place[first as usize];
        }
        Self { kept, place }
    }

    fn skeleton(&self, space: &dyn Distances, names: &Vertices, persistence: &Persistence) -> Skeleton {
        let mut vertices = Vertices::with_capacity(names.dimension(), self.kept.len());
        for &vertex in &self.kept {
            vertices.push(names.id(vertex), names.coordinates(vertex));
        }
        let tree = persistence.tree.iter().map(|&pair| (self.edge(pair), space.radius(pair.length)));
        let tree = tree.filter(|&([a, b], _)| a != b).collect();
        let dots = persistence.critical.iter().filter_map(|&(birth, death)| self.dot(space, birth, death));
        Skeleton::with_lengths(vertices, tree, dots.collect())
    }

    fn dot(&self, space: &dyn Distances, birth: Pair, death: Option<Pair>) -> Option<Dot> {
        let killer = death.map_or(Killer::None, |pair| Killer::Edge(self.edge(pair)));
        let edge = self.edge(birth);
        let birth = space.radius(birth.length);
        let death = death.map_or(f64::INFINITY, |pair| space.radius(pair.length));
        // Infinite deaths are above any diagonal: there both sides are infinite.
        let is_on_diagonal = death.is_finite() && death - birth <= DIAGONAL * death;
        (!is_on_diagonal).then_some(Dot { birth, death, edge, killer })
    }

    fn edge(&self, pair: Pair) -> Edge {
        let [a, b] = pair.ends().map(|end| self.place[end as usize]);
        [a.min(b), a.max(b)]
    }
}

/// Names of vertices without coordinates: their numbers in the space.
pub fn numbered(count: usize) -> Vertices {
    (0..count as u64).map(|number| (VertexId(number), &[][..])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::cloud::Vertices;
    use crate::topology::metric::space::{Matrix, Metric, Points};
    use crate::topology::skeleton::{View, ViewSpec};

    fn skeleton(space: &dyn Distances, threshold: Option<f64>) -> Skeleton {
        Skeleton::of_space(space, &numbered(space.count()), threshold, &mut Workspace::default())
    }

    /// The vertices of a cloud by its rows.
    fn of_points(dimension: usize, cloud: &[f64]) -> Skeleton {
        let points = Points::new(Metric::Euclidean, dimension, cloud).unwrap();
        let row = |&row: &u32| (VertexId(row.into()), &cloud[row as usize * dimension..][..dimension]);
        let names: Vertices = points.rows().iter().map(row).collect();
        Skeleton::of_space(&points, &names, None, &mut Workspace::default())
    }

    #[test]
    fn a_square_in_space_has_one_dot() {
        let square = of_points(3, &[1.0, 1.0, 5.0, 0.0, 0.0, 5.0, 0.0, 1.0, 5.0, 1.0, 0.0, 5.0]);
        let [dot] = square.dots() else { panic!("{:?}", square.dots()) };
        assert_eq!((dot.birth, dot.death), (0.5, 0.5 * 2_f64.sqrt()));
        // Points are called by their rows: (1,1) and (1,0) are 0 and 3, (0,0) and (1,1) are 1 and 0.
        assert_eq!((dot.edge, dot.killer), ([0, 3], Killer::Edge([0, 1])));
        assert_eq!(square.vertices().coordinates(3), [1.0, 0.0, 5.0]);
        assert_eq!(square.tree_length(), 3.0);
    }

    #[test]
    fn the_order_of_points_changes_nothing_but_names() {
        let cloud: Vec<[f64; 3]> =
            (0..60_u32).map(|i| [17, 29, 43].map(|step| f64::from(i * step % 61 * (i + step) % 13))).collect();
        let flat = |order: &[usize]| order.iter().flat_map(|&at| cloud[at]).collect::<Vec<f64>>();
        let of = |order: &[usize]| {
            let skeleton = of_points(3, &flat(order));
            let name = |end: u32| skeleton.vertices().coordinates(end).iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            let named = |edge: Edge| {
                let mut ends = edge.map(name);
                ends.sort();
                ends
            };
            let mut tree: Vec<_> = skeleton.tree().iter().map(|&edge| named(edge)).collect();
            tree.sort();
            let killer = |killer| if let Killer::Edge(edge) = killer { Some(named(edge)) } else { None };
            let mut dots: Vec<_> = skeleton
                .dots()
                .iter()
                .map(|dot| (named(dot.edge), killer(dot.killer), dot.birth.to_bits(), dot.death.to_bits()))
                .collect();
            dots.sort();
            (tree, dots)
        };
        let order: Vec<usize> = (0..60).collect();
        let mixed: Vec<usize> = (0..60).map(|at| at * 37 % 60).collect();
        assert!(!of(&order).1.is_empty());
        assert_eq!(of(&order), of(&mixed));
    }

    #[test]
    fn twins_are_one_vertex_and_edges_of_length_zero_are_gone() {
        // A square of sides 1 and diagonals 2, whose vertex 1 is named again as 4.
        let square = [1.0, 2.0, 1.0, 1.0, 2.0, 1.0, 1.0, 0.0, 1.0, 2.0];
        let skeleton = skeleton(&Matrix::from_lower(5, &square).unwrap(), None);
        assert_eq!(skeleton.vertices().ids(), [0, 1, 2, 3].map(VertexId));
        assert_eq!(skeleton.tree(), [[0, 1], [0, 3], [1, 2]]);
        let [dot] = skeleton.dots() else { panic!("{:?}", skeleton.dots()) };
        assert_eq!((dot.birth, dot.death, dot.edge), (0.5, 1.0, [2, 3]));
    }

    #[test]
    fn a_threshold_leaves_cycles_alive() {
        let square = Matrix::from_lower(4, &[1.0, 2.0, 1.0, 1.0, 2.0, 1.0]).unwrap();
        assert_eq!(skeleton(&square, Some(1.0)).dots()[0].death, 1.0);
        let stopped = skeleton(&square, Some(0.99));
        assert_eq!((stopped.dots()[0].death, stopped.dots()[0].killer), (f64::INFINITY, Killer::None));
        let view = View::new(&stopped, ViewSpec::default());
        assert_eq!((view.cycles, view.components), (1, 1));
        assert_eq!(skeleton(&square, Some(0.4)).tree(), [] as [Edge; 0]);
        assert_eq!(skeleton(&square, Some(0.0)).vertices().len(), 4);
    }

    #[test]
    fn spaces_without_points_have_empty_skeletons() {
        assert!(skeleton(&Matrix::from_lower(0, &[]).unwrap(), None).vertices().is_empty());
        assert_eq!(skeleton(&Matrix::from_lower(1, &[]).unwrap(), None).vertices().len(), 1);
        let apart = skeleton(&Matrix::from_lower(2, &[f64::INFINITY]).unwrap(), None);
        assert_eq!((apart.vertices().len(), apart.tree().len()), (2, 0));
    }
}
