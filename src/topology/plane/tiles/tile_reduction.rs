//! The reduction of one tile: of a leaf from its stars, of any other tile from the borders of its parts.
//!
//! In: [`Stars`] or [`Border`]s.
//! Out: what the tile resolves for good, and its own [`Border`].
//! Invariants: what all tiles resolve together depends on the stars alone, not on how tiles are cut. A result does not
//! depend on what was reduced before. Edges and dots are in the total order, largest scale first.
//! Must not know: the tree of tiles.
//!
//! The links of the dual graph are distributed: an edge belongs to the leaf of its smaller end. The three edges of a
//! triangle are then in the leaves of its smallest and of its middle corner. If these differ, both leaves have the
//! triangle as an open node, under one [`FaceKey`]; it is closed in the tile where both meet. The outer face is open
//! everywhere but at the root. A triangle that flows is one node with the triangle it flows to. If that is in another
//! leaf, the node's maximum is unknown.

use std::cmp::Ordering;

use super::border::{Border, TileLink};
use super::faces::{FaceKey, Faces, face_key};
use super::resolved::{EdgeOrder, Resolved};
use super::star::{LocalMaximum, Marks, OUTSIDE, Spoke, Star, Stars};
use crate::topology::cloud::{Cloud, Slot};
use crate::topology::plane::elements::{TileDot, TreeEdge};
use crate::topology::plane::reduction::{Elders, Forest, Join, Link};

/// Reduces tiles; its memory is reused.
#[derive(Clone, Debug, Default)]
pub struct TileReduction {
    /// What the last tile resolved.
    pub resolved: Resolved,
    /// The border of the last tile.
    pub border: Border,
    nodes: Vec<LocalMaximum>,
    forest: Forest,
    outer: Option<u32>,
    open: Vec<(FaceKey, u32)>,
    links: Vec<TileLink>,
    /// The order of the links.
    ranks: Vec<u64>,
    faces: Faces,
    kept: Vec<u32>,
    sorted: Vec<TileLink>,
}

const NONE: u32 = u32::MAX;

impl TileReduction {
    /// Reduces a leaf.
    pub fn reduce_leaf(&mut self, cloud: &Cloud, stars: &Stars, is_root: bool) {
        self.clear();
        // A star has at most as many own triangles as edges, and two beyond.
        self.faces.make_room(stars.spoke_count() + 2 * stars.len());
        stars.iter().for_each(|star| self.take_star(star));
        self.open.extend(self.faces.unmet());
        self.sort_links(EdgeOrder { cloud });
        self.finish(EdgeOrder { cloud }, is_root);
    }

    /// Reduces a tile from the borders of its parts.
    pub fn reduce_parts<'a>(&mut self, cloud: &Cloud, parts: impl Iterator<Item = &'a Border> + Clone, is_root: bool) {
        self.clear();
        self.faces.make_room(parts.clone().map(|part| part.open.len()).sum());
        for part in parts {
            let offset = self.nodes.len() as u32;
            self.nodes.extend_from_slice(&part.nodes);
            self.forest.grow(self.nodes.len(), |_| false);
            let moved = |link: &TileLink| Link { ends: link.ends.map(|node| node + offset), ..*link };
            self.links.extend(part.links.iter().map(moved));
            for &(key, node) in &part.open {
                let other = self.faces.meet(key, node + offset);
                self.unite(node + offset, other);
            }
            match (self.outer, part.outer.map(|node| node + offset)) {
                (Some(outer), Some(other)) => self.unite(outer, other),
                (None, outer) => self.outer = outer,
                (Some(_), None) => {}
            }
        }
        self.open.extend(self.faces.unmet());
        self.sort_links(EdgeOrder { cloud });
        self.finish(EdgeOrder { cloud }, is_root);
    }

    fn clear(&mut self) {
        self.resolved.tree.clear();
        self.resolved.dots.clear();
        self.border.clear();
        self.nodes.clear();
        self.forest.clear();
        self.outer = None;
        self.open.clear();
        self.links.clear();
    }

    fn add_node(&mut self, maximum: LocalMaximum) -> u32 {
        self.nodes.push(maximum);
        self.forest.add()
    }

    fn outer_node(&mut self) -> u32 {
        self.outer.unwrap_or_else(|| {
            let node = self.add_node(LocalMaximum::OUTER);
            self.outer = Some(node);
            node
        })
    }

    /// Adds the own triangles of a star as nodes and its own Gabriel edges as links. Triangles flow across the other
    /// edges.
    fn take_star(&mut self, star: Star<'_>) {
        let center = star.center;
        let mut names = star.names.iter();
        let Some(last) = star.spokes.len().checked_sub(1) else { return };
        let mut right = self.face_beyond(center.before, face_key(center.slot, center.before));
        for (place, spoke) in star.spokes.iter().enumerate() {
            let left = if place == last {
                self.face_beyond(center.after, face_key(center.after, center.slot))
            } else {
                self.own_face(center.slot, spoke, star.spokes[place + 1].to, &mut names)
            };
            if spoke.marks.has(Marks::FROM_LEFT) {
                self.forest.contract(left, right);
            } else if spoke.marks.has(Marks::FROM_RIGHT) {
                self.forest.contract(right, left);
            } else {
                self.links.push(Link { scale: spoke.scale, ends: [left, right], edge: [center.slot, spoke.to] });
            }
            right = left;
        }
    }

    /// The node of the own triangle between an edge and the next one.
    #[inline]
    fn own_face<'a>(
        &mut self,
        center: Slot,
        at: &Spoke,
        next: Slot,
        names: &mut impl Iterator<Item = &'a [Slot; 3]>,
    ) -> u32 {
        let swapped = at.marks.has(Marks::NEXT_IS_SMALLER);
        let (smaller, larger) = if swapped { (next, at.to) } else { (at.to, next) };
        let name = if at.marks.has(Marks::CIRCLE) { names.next() } else { None };
        // Without a maximum, the weight is -infinity and the triangle is not used.
        let triangle = name.copied().unwrap_or([center, smaller, larger]);
        let node = self.add_node(LocalMaximum { weight: at.weight, triangle });
        let key = if swapped { face_key(next, center) } else { face_key(center, at.to) };
        self.faces.meet(key, node)
    }

    /// The node of a triangle whose middle corner is the star's vertex, or of the outer face.
    #[inline]
    fn face_beyond(&mut self, apex: Slot, key: FaceKey) -> u32 {
        if apex == OUTSIDE {
            return self.outer_node();
        }
        // The apex is the smallest corner. If it is in this leaf, its star came before.
        let new = self.nodes.len() as u32;
        let node = self.faces.meet(key, new);
        if node == new {
            self.add_node(LocalMaximum::UNKNOWN);
        }
        node
    }

    /// Sorts the links.
    fn sort_links(&mut self, order: EdgeOrder<'_>) {
        let Self { links, ranks, sorted, .. } = self;
        ranks.clear();
        // Scales rounded to single precision are in the same order, except for ties. The bits of positive numbers are
        // in the order of the numbers.
        let rough = |link: &TileLink| !(link.scale as f32).to_bits();
        ranks.extend(links.iter().zip(0..).map(|(link, place)| u64::from(rough(link)) << 32 | place));
        ranks.sort_unstable();
        let link = |rank: u64| &links[rank as u32 as usize];
        for tied in ranks.chunk_by_mut(|a, b| a >> 32 == b >> 32).filter(|run| run.len() > 1) {
            tied.sort_unstable_by(|&a, &b| {
                let (a, b) = (link(a), link(b));
                order.of(a.scale, a.edge, b.scale, b.edge)
            });
        }
        sorted.clear();
        sorted.extend(ranks.iter().map(|&rank| *link(rank)));
        std::mem::swap(links, sorted);
    }

    /// Merges two nodes. The maximum of at most one of them is known.
    fn unite(&mut self, a: u32, b: u32) {
        let [a, b] = [a, b].map(|node| self.forest.root(node));
        if a != b {
            let weight = |node: u32| self.nodes[node as usize].weight;
            let (known, other) = if weight(a) >= weight(b) { (a, b) } else { (b, a) };
            self.forest.contract(other, known);
        }
    }

    /// Reduces what was added.
    fn finish(&mut self, order: EdgeOrder<'_>, is_root: bool) {
        debug_assert!(!is_root || self.open.is_empty(), "every triangle has both its ends in the whole");
        for (_, node) in &mut self.open {
            *node = self.forest.open(*node);
        }
        if let Some(outer) = &mut self.outer {
            *outer = if is_root { self.forest.root(*outer) } else { self.forest.open(*outer) };
        }
        let Self { resolved, border, nodes, forest, links, kept, open, .. } = self;
        kept.clear();
        kept.resize(nodes.len(), NONE);
        let mut keep = |node: u32| {
            let place = &mut kept[node as usize];
            if *place == NONE {
                *place = border.nodes.len() as u32;
                border.nodes.push(nodes[node as usize]);
            }
            *place
        };
        border.outer = self.outer.filter(|_| !is_root).map(&mut keep);
        border.open.extend(open.iter().map(|&(key, node)| (key, keep(node))));
        let elders = NodeOrder { order, nodes };
        for link in &*links {
            match forest.join(&elders, link.ends, 0) {
                Join::Loop => resolved.tree.push(TreeEdge { scale: link.scale, ends: link.edge }),
                Join::Ended(node) => {
                    let maximum = nodes[node as usize];
                    resolved.dots.extend(TileDot::new(link.scale, maximum.weight, link.edge, maximum.triangle));
                }
                Join::Left(ends) => border.links.push(Link { ends: ends.map(&mut keep), ..*link }),
            }
        }
    }
}

/// The elder rule's order of a tile's nodes.
struct NodeOrder<'a> {
    order: EdgeOrder<'a>,
    nodes: &'a [LocalMaximum],
}

impl Elders for NodeOrder<'_> {
    fn weight(&self, node: u32) -> f64 {
        self.nodes[node as usize].weight
    }

    fn break_node_tie(&self, a: u32, b: u32) -> Ordering {
        let [of_a, of_b] = [a, b].map(|node| self.nodes[node as usize]);
        if of_a.weight == f64::NEG_INFINITY {
            // Both are open. The tile in which their maxima are known decides.
            return a.cmp(&b);
        }
        self.order.positions(of_a.triangle).cmp(&self.order.positions(of_b.triangle))
    }
}
