//! What turned one frame's skeleton into the next one's.
//!
//! In: the [`Difference`] that the tiles found, or two skeletons. Out: a [`Change`], by ids, from which every view's diff follows.
//! Invariants: it holds what changed and nothing else; it starts from one frame and leads to one. Must not know: views, formats.

use super::cloud::{Cloud, CloudChange, Vertex};
use super::diff::{Critical, EdgeId, merge};
use super::skeleton::Skeleton;
use super::tiles::{Difference, TileDot, Tiles, TreeEdge};

/// An edge of the minimum spanning tree and the scale at which it enters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeEdgeId {
    /// Its ends.
    pub edge: EdgeId,
    /// Half its length.
    pub scale: f64,
}

/// What turned one skeleton into another.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Change {
    /// Number of the frame it starts from; 0 for the empty skeleton.
    pub from: u64,
    /// Vertices that are new, by id.
    pub vertices_added: Vec<Vertex>,
    /// Vertices that are gone, by id.
    pub vertices_removed: Vec<Vertex>,
    /// Tree edges that are new, in no order.
    pub tree_added: Vec<TreeEdgeId>,
    /// Tree edges that are gone, in no order.
    pub tree_removed: Vec<TreeEdgeId>,
    /// Dots that are new or have a new label, in no order.
    pub dots_added: Vec<Critical>,
    /// Dots that are gone or had another label, in no order.
    pub dots_removed: Vec<Critical>,
}

impl Change {
    /// By vertices alone.
    pub fn of_cloud(from: u64, cloud: &Cloud, change: &CloudChange) -> Self {
        // A slot that was emptied in this change still says what it held.
        let vertices = |slots: &[u32]| slots.iter().map(|&slot| cloud.vertex(slot)).collect();
        Self {
            from,
            vertices_added: vertices(&change.appeared),
            vertices_removed: vertices(&change.vanished),
            ..Self::default()
        }
    }

    /// Adds what the tiles found.
    pub fn with_difference(mut self, cloud: &Cloud, difference: &Difference) -> Self {
        self.tree_added.extend(difference.tree_added.iter().map(|edge| tree_edge(cloud, edge)));
        self.tree_removed.extend(difference.tree_removed.iter().map(|edge| tree_edge(cloud, edge)));
        self.dots_added.extend(difference.dots_added.iter().map(|dot| critical(cloud, dot)));
        self.dots_removed.extend(difference.dots_removed.iter().map(|dot| critical(cloud, dot)));
        self
    }

    /// Adds what is in one of two parts alone.
    pub fn with_parts(mut self, old: &Parts, new: &Parts) -> Self {
        merge(
            &old.tree,
            &new.tree,
            |edge| edge.edge,
            |pair| match pair {
                (Some(old), None) => self.tree_removed.push(*old),
                (None, Some(new)) => self.tree_added.push(*new),
                _ => {}
            },
        );
        merge(
            &old.dots,
            &new.dots,
            |dot| dot.edge,
            |pair| {
                if pair.0 != pair.1 {
                    self.dots_removed.extend(pair.0);
                    self.dots_added.extend(pair.1);
                }
            },
        );
        self
    }
}

/// All edges and dots of a skeleton, in order of their edges.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parts {
    tree: Vec<TreeEdgeId>,
    dots: Vec<Critical>,
}

impl Parts {
    /// Of a skeleton at hand.
    pub fn of_skeleton(skeleton: &Skeleton) -> Self {
        let tree = tree_of(skeleton).collect();
        let mut dots: Vec<Critical> = dots_of(skeleton).collect();
        dots.sort_unstable_by_key(|dot| dot.edge);
        Self { tree, dots }
    }

    /// Of the skeleton that tiles hold.
    pub fn of_tiles(cloud: &Cloud, tiles: &Tiles) -> Self {
        let mut tree: Vec<TreeEdgeId> = tiles.tree().map(|edge| tree_edge(cloud, edge)).collect();
        tree.sort_unstable_by_key(|edge| edge.edge);
        let mut dots: Vec<Critical> = tiles.dots().map(|dot| critical(cloud, dot)).collect();
        dots.sort_unstable_by_key(|dot| dot.edge);
        Self { tree, dots }
    }
}

/// A skeleton's tree, in order.
pub fn tree_of(skeleton: &Skeleton) -> impl Iterator<Item = TreeEdgeId> + '_ {
    let id = |vertex: u32| skeleton.vertices()[vertex as usize].id;
    skeleton.tree().iter().map(move |&edge| TreeEdgeId { edge: edge.map(id), scale: skeleton.half_length(edge) })
}

/// A skeleton's dots, in no order.
pub fn dots_of(skeleton: &Skeleton) -> impl Iterator<Item = Critical> + '_ {
    let id = |vertex: u32| skeleton.vertices()[vertex as usize].id;
    skeleton.found().iter().map(move |dot| Critical { edge: dot.edge.map(id), birth: dot.birth, death: dot.death })
}

/// A tile's edge, by ids.
pub fn tree_edge(cloud: &Cloud, edge: &TreeEdge) -> TreeEdgeId {
    TreeEdgeId { edge: edge_id(cloud, edge.ends), scale: edge.scale.sqrt() }
}

/// A tile's dot, by ids.
pub fn critical(cloud: &Cloud, dot: &TileDot) -> Critical {
    Critical { edge: edge_id(cloud, dot.edge), birth: dot.birth, death: dot.death }
}

fn edge_id(cloud: &Cloud, slots: [u32; 2]) -> EdgeId {
    let [a, b] = slots.map(|slot| cloud.id(slot));
    [a.min(b), a.max(b)]
}
