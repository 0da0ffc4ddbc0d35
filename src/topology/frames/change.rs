//! The change from one frame's skeleton to the next one's.
//!
//! In: a change of the cloud, and two trees or what is known of their difference.
//! Out: a [`Change`] by ids, from which every view's diff follows.
//! Invariants: it contains what changed and nothing else. It leads from one frame to one frame.
//! Must not know: views, formats.

use std::cmp::Ordering;

use crate::topology::cloud::{Cloud, CloudChange, Slot, Vertices};
use crate::topology::skeleton::{Critical, Edge, EdgeId, Skeleton, TreeEdgeId};

/// The difference of two skeletons.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Change {
    /// The number of the frame it starts from; 0 for the empty skeleton.
    pub from: u64,
    /// Vertices that are new, by id.
    pub vertices_added: Vertices,
    /// Vertices that are gone, by id.
    pub vertices_removed: Vertices,
    /// Tree edges that are new, in no order.
    pub tree_added: Vec<TreeEdgeId>,
    /// Tree edges that are gone, in no order.
    pub tree_removed: Vec<TreeEdgeId>,
    /// Which dots have changed. None after one pass: comparing the dots of a view is faster there.
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
    /// The change from one whole skeleton to another, in which a vertex that stays has the same coordinates.
    pub fn between(from: u64, old: &Skeleton, new: &Skeleton) -> Self {
        let only_in = |one: &Skeleton, other: &Skeleton| {
            let is_there = |id| other.vertices().ids().binary_search(&id).is_ok();
            one.vertices().iter().filter(|&(id, _)| !is_there(id)).collect()
        };
        let vertices =
            Self { from, vertices_added: only_in(new, old), vertices_removed: only_in(old, new), ..Self::default() };
        vertices.with_trees(&Tree::Whole(old), &Tree::Whole(new))
    }

    /// A change of vertices only, in the plane.
    pub fn of_cloud(from: u64, cloud: &Cloud, change: &CloudChange) -> Self {
        // A slot that was emptied in this change still has its last vertex.
        let vertices = |slots: &[Slot]| slots.iter().map(|&slot| cloud.vertex(slot)).collect();
        Self {
            from,
            vertices_added: vertices(&change.appeared),
            vertices_removed: vertices(&change.vanished),
            ..Self::default()
        }
    }

    /// Adds the edges that are in one of two trees only.
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

/// A tree in order of its edges, wherever it is stored.
pub enum Tree<'a> {
    /// No tree.
    Empty,
    /// That of a whole skeleton.
    Whole(&'a Skeleton),
    /// Collected from elsewhere.
    Gathered(Vec<TreeEdgeId>),
}

/// An edge of such a tree. Its scale is computed only if the edge has changed.
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
    fn iter(&'a self) -> Box<dyn Iterator<Item = Entry<'a>> + 'a> {
        match self {
            Self::Empty => Box::new(std::iter::empty()),
            Self::Whole(skeleton) => {
                let entry =
                    move |&edge: &Edge| Entry { edge: skeleton.edge_id(edge), scale: Scale::Of(skeleton, edge) };
                Box::new(skeleton.tree().iter().map(entry))
            }
            Self::Gathered(tree) => {
                Box::new(tree.iter().map(|edge| Entry { edge: edge.edge, scale: Scale::Known(edge.scale) }))
            }
        }
    }
}
