//! The reduction: persistent pairs and the minimum spanning tree out of a weighted dual graph, by the elder rule.
//!
//! In: nodes with weights (some of them open: they have links that this call does not see) and links with scales, under one
//! total order. Out: a [`Reduction`]. Taking links by DEcreasing scale, a link that joins two components ends the one with
//! the smaller maximum (the younger); a link inside one component is an edge of the minimum spanning tree. Invariants, for every
//! link handed in: it is in exactly one of `pairs`, `tree` and `left`; without open nodes `left` is empty; for any cut of a
//! graph into parts, reducing the parts and then the union of what they leave gives the pairs and the tree of the whole.
//! Must not know: what nodes and links stand for.

use std::cmp::Ordering;

use crate::topology::base::{in_order, ordinal};

/// A link of the dual graph: an edge of the triangulation between two faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link<E = u32> {
    /// Its scale, in any monotone measure.
    pub scale: f64,
    /// The nodes it joins.
    pub ends: [u32; 2],
    /// What it stands for; the caller's own name.
    pub edge: E,
}

/// The order of nodes.
pub trait Elders {
    /// A node's weight: the elder of two nodes has the larger one.
    fn weight(&self, node: u32) -> f64;
    /// Compares two nodes of equal weight; `Greater` when `a` is the elder. Never `Equal` for different ones.
    fn break_node_tie(&self, a: u32, b: u32) -> Ordering;
}

/// The total order, but for the links' scales.
pub trait TotalOrder: Elders {
    /// Whether a node has links that are not handed in.
    fn is_open(&self, node: u32) -> bool;
    /// A link's place among those of equal scale; never the same for different ones.
    fn break_link_tie(&self, edge: u32) -> u64;
}

/// A merge whose younger side is closed: for good, whatever lies outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// The scale of the link that gives birth.
    pub scale: f64,
    /// That link.
    pub edge: u32,
    /// The node whose filling is the death: the maximum of the younger side.
    pub death: u32,
}

/// What a reduction of some links gives.
#[derive(Clone, Debug)]
pub struct Reduction<'a> {
    links: &'a [Link],
    nodes: Vec<Node>,
    fates: Vec<Fate>,
    /// The reduced graph, in the order: merges whose younger side is open, each between the maxima of its two sides.
    pub left: Vec<Link>,
}

impl Reduction<'_> {
    /// Resolved pairs, in order of their deaths' numbers.
    pub fn pairs(&self) -> impl Iterator<Item = Pair> {
        let ended = self.nodes.iter().zip(0..).filter(|(node, _)| node.ended_by != NONE);
        ended.map(|(node, death)| {
            let link = &self.links[node.ended_by as usize];
            Pair { scale: link.scale, edge: link.edge, death }
        })
    }

    /// Edges of the minimum spanning tree, in order of the links handed in.
    pub fn tree(&self) -> impl Iterator<Item = u32> {
        let loops = self.links.iter().zip(&self.fates).filter(|(_, fate)| **fate == Fate::Loop);
        loops.map(|(link, _)| link.edge)
    }
}

/// The name of no link.
const NONE: u32 = u32::MAX;

/// So many links are fetched together: what lies all over the memory is then waited for once, not once a link.
const BLOCK: usize = 32;

/// Reduces a graph of `node_count` nodes.
pub fn reduce<'a>(order: &impl TotalOrder, node_count: usize, links: &'a [Link]) -> Reduction<'a> {
    let mut forest = Forest::default();
    forest.grow(node_count, |node| order.is_open(node));
    let (mut fates, mut left) = (vec![Fate::Loop; links.len()], Vec::new());
    let descending = |link: u32| !ordinal(links[link as usize].scale);
    let tie = |link: u32| !order.break_link_tie(links[link as usize].edge);
    for block in in_order(links.len(), descending, tie).chunks(BLOCK) {
        let mut ends = [[0; 2]; BLOCK];
        for (ends, &link) in ends.iter_mut().zip(block) {
            *ends = links[link as usize].ends;
        }
        for ends in &mut ends[..block.len()] {
            *ends = ends.map(|node| forest.nodes[node as usize].elder);
        }
        for (&link, ends) in block.iter().zip(ends) {
            match forest.join(order, ends, link) {
                Join::Loop => {}
                Join::Ended(_) => fates[link as usize] = Fate::Merge,
                Join::Left(ends) => {
                    fates[link as usize] = Fate::Merge;
                    left.push(Link { ends, ..links[link as usize] });
                }
            }
        }
    }
    Reduction { links, nodes: forest.nodes, fates, left }
}

/// A node in the union-find.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// An elder node of its component; itself, if it is the component's maximum.
    elder: u32,
    /// The link that ends it, once it has ended for good.
    ended_by: u32,
}

/// What has become of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    Loop,
    Merge,
}

/// What a link does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Join {
    /// Both its ends are in one component.
    Loop,
    /// It ends this node, the maximum of the younger of its two sides, for good.
    Ended(u32),
    /// The younger side is open: the maxima of both sides, the younger first.
    Left([u32; 2]),
}

/// A union-find whose roots are the maxima of their components.
#[derive(Clone, Debug, Default)]
pub struct Forest {
    nodes: Vec<Node>,
    /// Of a root: whether its component has an open node.
    open: Vec<bool>,
}

impl Forest {
    /// Forgets all nodes.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.open.clear();
    }

    /// Adds nodes until there are so many, each a component of its own.
    pub fn grow(&mut self, count: usize, is_open: impl Fn(u32) -> bool) {
        let new = self.nodes.len() as u32..count as u32;
        self.nodes.extend(new.clone().map(|elder| Node { elder, ended_by: NONE }));
        self.open.extend(new.map(is_open));
    }

    /// Adds a node that is closed.
    #[inline]
    pub fn add(&mut self) -> u32 {
        let elder = self.nodes.len() as u32;
        self.nodes.push(Node { elder, ended_by: NONE });
        self.open.push(false);
        elder
    }

    /// Makes one node of two, the roots of their components, without asking who is the elder.
    #[inline]
    pub fn contract(&mut self, node: u32, into: u32) {
        self.nodes[node as usize].elder = into;
        self.open[into as usize] |= self.open[node as usize];
    }

    /// Says that a node's component has links that are not handed in; gives its root.
    #[inline]
    pub fn open(&mut self, node: u32) -> u32 {
        let root = self.root(node);
        self.open[root as usize] = true;
        root
    }

    /// The maximum of a node's component.
    #[inline]
    pub fn root(&mut self, mut node: u32) -> u32 {
        loop {
            let parent = self.nodes[node as usize].elder;
            let grandparent = self.nodes[parent as usize].elder;
            if parent == grandparent {
                return parent;
            }
            self.nodes[node as usize].elder = grandparent;
            node = grandparent;
        }
    }

    /// One link between two nodes, the largest one not taken yet: the elder rule.
    #[inline]
    pub fn join(&mut self, order: &impl Elders, between: [u32; 2], link: u32) -> Join {
        let [a, b] = between.map(|node| self.root(node));
        if a == b {
            return Join::Loop;
        }
        let (younger, elder) = if is_younger(order, a, b) { (a, b) } else { (b, a) };
        self.nodes[younger as usize].elder = elder;
        if self.open[younger as usize] {
            self.open[elder as usize] = true;
            Join::Left([younger, elder])
        } else {
            self.nodes[younger as usize].ended_by = link;
            Join::Ended(younger)
        }
    }
}

#[inline]
fn is_younger(order: &impl Elders, a: u32, b: u32) -> bool {
    let [weight, other] = [a, b].map(|node| order.weight(node));
    weight < other || weight == other && order.break_node_tie(a, b) == Ordering::Less
}
