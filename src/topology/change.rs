//! What turned one frame's skeleton into the next one's.
//!
//! In: the [`Difference`] that the tiles found, or two skeletons. Out: a [`Change`], by ids, from which every view's diff follows.
//! Invariants: it holds what changed and nothing else; it starts from one frame and leads to one. Must not know: views, formats.

use std::cmp::Ordering;

use super::cloud::{Cloud, CloudChange, Vertex};
use super::diff::{Critical, EdgeId};
use super::skeleton::{Edge, Skeleton};
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
    /// Which dots have changed; not told of after one pass, where asking for those that are shown is quicker.
    pub dots: Option<DotChange>,
}

/// Which dots have changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DotChange {
    /// Dots that are new or have a new label, in no order.
    pub added: Vec<Critical>,
    /// Dots that are gone or had another label, in no order.
    pub removed: Vec<Critical>,
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
        let dots = |dots: &[TileDot]| dots.iter().map(|dot| critical(cloud, dot)).collect();
        self.dots = Some(DotChange { added: dots(&difference.dots_added), removed: dots(&difference.dots_removed) });
        self
    }

    /// Adds edges that are in one of two trees alone.
    pub fn with_trees(mut self, old: &Tree<'_>, new: &Tree<'_>) -> Self {
        let (mut old, mut new) = (old.iter().peekable(), new.iter().peekable());
        loop {
            let order = match (old.peek(), new.peek()) {
                (None, None) => return self,
                (Some(_), None) => Ordering::Less,
                (None, Some(_)) => Ordering::Greater,
                (Some(a), Some(b)) => a.edge.cmp(&b.edge),
            };
            let gone = if order.is_le() { old.next() } else { None };
            let come = if order.is_ge() { new.next() } else { None };
            if order.is_ne() {
                self.tree_removed.extend(gone.map(Entry::with_scale));
                self.tree_added.extend(come.map(Entry::with_scale));
            }
        }
    }
}

/// The tree of a skeleton that is held, in order.
pub enum Tree<'a> {
    /// There was none.
    Empty,
    /// Of a whole skeleton.
    Whole(&'a Skeleton),
    /// Gathered from tiles.
    Gathered(Vec<TreeEdgeId>),
}

/// An edge of such a tree. Its scale is computed where it is asked for: most edges do not change.
struct Entry<'a> {
    edge: EdgeId,
    scale: Scale<'a>,
}

enum Scale<'a> {
    Known(f64),
    Of(&'a Skeleton, Edge),
}

impl Entry<'_> {
    fn with_scale(self) -> TreeEdgeId {
        let scale = match self.scale {
            Scale::Known(scale) => scale,
            Scale::Of(skeleton, edge) => skeleton.half_length(edge),
        };
        TreeEdgeId { edge: self.edge, scale }
    }
}

impl<'a> Tree<'a> {
    /// Of the skeleton that tiles hold.
    pub fn of_tiles(cloud: &Cloud, tiles: &Tiles) -> Self {
        let mut tree: Vec<TreeEdgeId> = tiles.tree().map(|edge| tree_edge(cloud, edge)).collect();
        tree.sort_unstable_by_key(|edge| edge.edge);
        Self::Gathered(tree)
    }

    fn iter(&'a self) -> Box<dyn Iterator<Item = Entry<'a>> + 'a> {
        match self {
            Self::Empty => Box::new(std::iter::empty()),
            Self::Whole(skeleton) => {
                let id = |vertex: u32| skeleton.vertices()[vertex as usize].id;
                let entry = move |&edge: &Edge| Entry { edge: edge.map(id), scale: Scale::Of(skeleton, edge) };
                Box::new(skeleton.tree().iter().map(entry))
            }
            Self::Gathered(tree) => {
                Box::new(tree.iter().map(|edge| Entry { edge: edge.edge, scale: Scale::Known(edge.scale) }))
            }
        }
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
