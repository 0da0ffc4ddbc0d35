//! Translation of what tiles store, by slots, to what the rooms above the plane use, by ids.
//!
//! In: tiles and their differences.
//! Out: skeletons, changes, rankings and names by ids.
//! Invariant: the results equal those of one pass.
//! Must not know: how tiles are reduced.

use super::holes::hole;
use super::one_pass::ranks;
use crate::topology::cloud::{Cloud, Slot};
use crate::topology::frames::{Change, DotChange, Persistent, Tree};
use crate::topology::plane::elements::{TileDot, TreeEdge};
use crate::topology::plane::tiles::{Difference, Tiles};
use crate::topology::skeleton::{Critical, Dot, EdgeId, Killer, Ranking, Skeleton, TreeEdgeId};

impl Persistent for TileDot {
    #[inline]
    fn persistence(&self) -> f64 {
        self.persistence()
    }
}

/// The skeleton of a cloud, gathered from its tiles.
pub fn skeleton(cloud: &Cloud, tiles: &Tiles) -> Skeleton {
    let (vertices, rank) = ranks(cloud);
    let edge_of = |ends: [Slot; 2]| {
        let [a, b] = ends.map(|slot| rank[slot as usize]);
        [a.min(b), a.max(b)]
    };
    let mut tree = Vec::with_capacity(vertices.len());
    tree.extend(tiles.tree().map(|edge| edge_of(edge.ends)));
    let found = tiles.dots().map(|dot| Dot {
        birth: dot.birth,
        death: dot.death,
        edge: edge_of(dot.edge),
        killer: Killer::Triangle(dot.triangle.map(|slot| rank[slot as usize])),
    });
    Skeleton::from_parts(vertices, tree, found.collect())
}

/// The tree in tiles, in order.
pub fn tree(cloud: &Cloud, tiles: &Tiles) -> Tree<'static> {
    let mut tree: Vec<TreeEdgeId> = tiles.tree().map(|edge| tree_edge(cloud, edge)).collect();
    tree.sort_unstable_by_key(|edge| edge.edge);
    Tree::Gathered(tree)
}

/// The most persistent dots in tiles.
pub fn ranking(number: u64, cloud: &Cloud, tiles: &Tiles, most: usize) -> Ranking {
    let name = |dot: &&TileDot| critical(cloud, dot);
    let filling = |dot: &&TileDot| (Some(hole(cloud, dot.triangle, dot.death)), None);
    Ranking::new(number, tiles.dots().collect(), most, |dot| dot.persistence(), name, filling)
}

/// Adds a difference of tiles to a change.
pub fn with_difference(mut change: Change, cloud: &Cloud, difference: &Difference) -> Change {
    change.tree_added.extend(difference.tree_added.iter().map(|edge| tree_edge(cloud, edge)));
    change.tree_removed.extend(difference.tree_removed.iter().map(|edge| tree_edge(cloud, edge)));
    let dots = |dots: &[TileDot]| dots.iter().map(|dot| critical(cloud, dot)).collect();
    change.dots = Some(DotChange { added: dots(&difference.dots_added), removed: dots(&difference.dots_removed) });
    change
}

/// A tree edge by ids.
pub fn tree_edge(cloud: &Cloud, edge: &TreeEdge) -> TreeEdgeId {
    TreeEdgeId { edge: edge_id(cloud, edge.ends), scale: edge.scale.sqrt() }
}

/// A dot by ids.
pub fn critical(cloud: &Cloud, dot: &TileDot) -> Critical {
    Critical { edge: edge_id(cloud, dot.edge), birth: dot.birth, death: dot.death }
}

fn edge_id(cloud: &Cloud, slots: [Slot; 2]) -> EdgeId {
    let [a, b] = slots.map(|slot| cloud.id(slot));
    [a.min(b), a.max(b)]
}
