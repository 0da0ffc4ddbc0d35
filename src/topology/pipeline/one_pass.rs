//! The skeleton of a whole mesh, in one pass.
//!
//! In: a cloud, its mesh, the basins and the links between them.
//! Out: a [`Skeleton`].
//! Invariant: it depends on the cloud alone.
//! Must not know: frames, tiles.

use crate::topology::base::{both, pair_key, sort_by_key};
use crate::topology::cloud::{Cloud, Vertices};
use crate::topology::plane::DualOrder;
use crate::topology::plane::basins::Basins;
use crate::topology::plane::elements::label;
use crate::topology::plane::mesh::Mesh;
use crate::topology::plane::reduction::{Link, reduce};
use crate::topology::skeleton::{Dot, Killer, Ranking, Skeleton};

impl Skeleton {
    /// The skeleton of a cloud as of its last commit, whose vertices are the sites of the mesh, from the links between
    /// its basins.
    pub fn new(cloud: &Cloud, mesh: &Mesh, basins: &Basins, links: Vec<Link>) -> Self {
        let (reduction, (vertices, rank)) = both(
            links.len(),
            || reduce(&DualOrder::new(mesh, basins), basins.count(), &links),
            || ranked_vertices(cloud, mesh),
        );
        let edge_of = |edge: u32| {
            let [a, b] = mesh.edges()[edge as usize].ends.map(|site| rank[site as usize]);
            [a.min(b), a.max(b)]
        };
        let sorted_tree = || {
            let mut tree = Vec::with_capacity(vertices.len());
            tree.extend(reduction.tree().map(edge_of));
            sort_by_key(&mut tree, |&edge| pair_key(edge, vertices.len()));
            tree
        };
        let dots = || {
            let mut found = Vec::with_capacity(basins.count());
            found.extend(reduction.pairs().filter_map(|pair| {
                let (birth, death) = label(pair.scale, basins.weight(pair.death))?;
                let triangle = basins.triangle(pair.death).map(|site| rank[site as usize]);
                Some(Dot { birth, death, edge: edge_of(pair.edge), killer: Killer::Triangle(triangle) })
            }));
            found
        };
        let (tree, found) = both(links.len(), sorted_tree, dots);
        Self::from_sorted(vertices, tree, found)
    }
}

/// The most persistent dots of a whole skeleton.
pub(super) fn ranking(number: u64, skeleton: &Skeleton, most: usize) -> Ranking {
    let dots: Vec<&Dot> = skeleton.unsorted_dots().iter().collect();
    let death_edge = |dot: &Dot| match dot.killer {
        Killer::Edge(edge) => Some(skeleton.edge_id(edge)),
        Killer::Triangle(_) | Killer::None => None,
    };
    let filling = |dot: &&Dot| (skeleton.hole(dot), death_edge(dot));
    Ranking::new(number, dots, most, |dot| dot.persistence(), |dot| skeleton.critical(dot), filling)
}

/// The vertices by id, and the place among them of each site of the mesh.
fn ranked_vertices(cloud: &Cloud, mesh: &Mesh) -> (Vertices, Vec<u32>) {
    let (vertices, rank) = ranks(cloud);
    (vertices, mesh.slots().iter().map(|&slot| rank[slot as usize]).collect())
}

/// The vertices by id, and the place among them of each slot's vertex.
pub(super) fn ranks(cloud: &Cloud) -> (Vertices, Vec<u32>) {
    let mut vertices = Vertices::with_capacity(2, cloud.vertex_count());
    let mut rank_of_slot = vec![0; cloud.slot_count()];
    for (slot, vertex) in cloud.vertices() {
        rank_of_slot[slot as usize] = vertices.len() as u32;
        vertices.push(vertex.id, &vertex.position.xy());
    }
    (vertices, rank_of_slot)
}
