//! The reduction: persistent pairs and the minimum spanning tree of a weighted dual graph, by the elder rule.
//!
//! In: nodes with weights and links with scales, under one total order. A node is open if it has links that this call
//! does not see.
//! Out: a [`Reduction`]. Links are taken in order of DEcreasing scale. A link between two components ends the one with
//! the smaller maximum (the younger). A link inside a component is an edge of the minimum spanning tree.
//! Invariants: every link is in exactly one of `pairs`, `tree` and `left`. Without open nodes `left` is empty. For any
//! cut of a graph into parts, reducing the parts and then the union of what they leave gives the pairs and the tree of
//! the whole.
//! Must not know: what nodes and links stand for.

use std::cmp::Ordering;

use crate::topology::base::{in_order, ordinal};

/// A link of the dual graph: an edge of the triangulation between two nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link<E = u32> {
    /// Its scale, in any monotone measure.
    pub scale: f64,
    /// The nodes that it joins.
    pub ends: [u32; 2],
    /// The caller's name for it.
    pub edge: E,
}

/// The order of nodes.
pub trait Elders {
    /// The weight of a node: of two nodes, the elder has the larger one.
    fn weight(&self, node: u32) -> f64;
    /// Compares two nodes of equal weight: `Greater` if `a` is the elder. Never `Equal` for different nodes.
    fn break_node_tie(&self, a: u32, b: u32) -> Ordering;
}

/// The order of links of equal scale.
pub trait TotalOrder: Elders {
    /// Whether a node has links that this call does not see.
    fn is_open(&self, node: u32) -> bool;
    /// The place of a link among those of equal scale; different for different links.
    fn break_link_tie(&self, edge: u32) -> u64;
}

/// A merge whose younger side is closed. It holds whatever lies outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// The scale of the link that gives birth to the cycle.
    pub scale: f64,
    /// That link.
    pub edge: u32,
    /// The node at which the cycle dies: the maximum of the younger side.
    pub death: u32,
}

/// The result of a reduction.
#[derive(Clone, Debug)]
pub struct Reduction<'a> {
    links: &'a [Link],
    nodes: Vec<Node>,
    kinds: Vec<LinkKind>,
    /// The reduced graph, in order: the merges whose younger side is open, each between the maxima of its sides.
    pub left: Vec<Link>,
}

impl Reduction<'_> {
    /// The pairs, in order of the numbers of their deaths.
    pub fn pairs(&self) -> impl Iterator<Item = Pair> {
        let ended = self.nodes.iter().zip(0..).filter(|(node, _)| node.ended_by != NONE);
        ended.map(|(node, death)| {
            let link = &self.links[node.ended_by as usize];
            Pair { scale: link.scale, edge: link.edge, death }
        })
    }

    /// The edges of the minimum spanning tree, in the order of the links handed in.
    pub fn tree(&self) -> impl Iterator<Item = u32> {
        let loops = self.links.iter().zip(&self.kinds).filter(|(_, kind)| **kind == LinkKind::Loop);
        loops.map(|(link, _)| link.edge)
    }
}

/// No link.
const NONE: u32 = u32::MAX;

/// The number of links whose ends are read together. The ends are scattered over the memory; reading a block lets the
/// cache misses overlap.
const BLOCK: usize = 32;

/// Reduces a graph of `node_count` nodes.
pub fn reduce<'a>(order: &impl TotalOrder, node_count: usize, links: &'a [Link]) -> Reduction<'a> {
    let mut forest = Forest::default();
    forest.grow(node_count, |node| order.is_open(node));
    let (mut kinds, mut left) = (vec![LinkKind::Loop; links.len()], Vec::new());
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
                Join::Ended(_) => kinds[link as usize] = LinkKind::Merge,
                Join::Left(ends) => {
                    kinds[link as usize] = LinkKind::Merge;
                    left.push(Link { ends, ..links[link as usize] });
                }
            }
        }
    }
    Reduction { links, nodes: forest.nodes, kinds, left }
}

/// A node of the union-find.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// An elder node of its component; itself, if it is the component's maximum.
    elder: u32,
    /// The link that ended it, if one did.
    ended_by: u32,
}

/// The role of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LinkKind {
    Loop,
    Merge,
}

/// The effect of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Join {
    /// Both its ends are in one component.
    Loop,
    /// It ends this node, the maximum of the younger side.
    Ended(u32),
    /// The younger side is open. The maxima of both sides, the younger first.
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
    /// Removes all nodes.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.open.clear();
    }

    /// Adds nodes up to this number, each a component of its own.
    pub fn grow(&mut self, count: usize, is_open: impl Fn(u32) -> bool) {
        let new = self.nodes.len() as u32..count as u32;
        self.nodes.extend(new.clone().map(|elder| Node { elder, ended_by: NONE }));
        self.open.extend(new.map(is_open));
    }

    /// Adds a closed node.
    #[inline]
    pub fn add(&mut self) -> u32 {
        let elder = self.nodes.len() as u32;
        self.nodes.push(Node { elder, ended_by: NONE });
        self.open.push(false);
        elder
    }

    /// Merges a root into another one without comparing their ages.
    #[inline]
    pub fn contract(&mut self, node: u32, into: u32) {
        self.nodes[node as usize].elder = into;
        self.open[into as usize] |= self.open[node as usize];
    }

    /// Marks the component of a node as open; returns its root.
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

    /// Applies the elder rule to a link between two nodes, the largest link that was not applied yet.
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
