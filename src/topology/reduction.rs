//! The reduction: persistent pairs and the minimum spanning tree out of a weighted dual graph, by the elder rule.
//!
//! In: nodes with weights (some of them open: they have links that this call does not see) and links with scales, under one
//! total order. Out: a [`Reduction`]. Taking links by DEcreasing scale, a link that joins two components ends the one with
//! the smaller maximum (the younger); a link inside one component is an edge of the minimum spanning tree. Invariants, for every
//! link handed in: it is in exactly one of `pairs`, `tree` and `links`; without open nodes `links` is empty; for any cut of a
//! graph into parts, reducing the parts and then the union of what they leave gives the pairs and the tree of the whole.
//! Must not know: what nodes and links stand for.

use std::cmp::Ordering;

use super::sorting::{in_order, in_order_by, ordinal};

/// A link of the dual graph: an edge of the triangulation between two faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// Its scale, in any monotone measure.
    pub scale: f64,
    /// The nodes it joins.
    pub ends: [u32; 2],
    /// What it stands for; the caller's own name.
    pub edge: u32,
}

/// The total order, but for the links' scales.
pub trait TotalOrder {
    /// A node's weight: the elder of two nodes has the larger one.
    fn weight(&self, node: u32) -> f64;
    /// Compares two nodes of equal weight; `Greater` when `a` is the elder. Never `Equal` for different ones.
    fn break_node_tie(&self, a: u32, b: u32) -> Ordering;
    /// A link's place among those of equal scale; never the same for different ones.
    fn break_link_tie(&self, edge: u32) -> u64;
    /// Whether a node has links that are not handed in.
    fn is_open(&self, node: u32) -> bool;
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

/// What a reduction gives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reduction {
    /// Resolved pairs, in order of their deaths' numbers.
    pub pairs: Vec<Pair>,
    /// Edges of the minimum spanning tree, in order of the links handed in.
    pub tree: Vec<u32>,
    /// The reduced graph, in the order: merges whose younger side is open, each between the maxima of its two sides.
    pub links: Vec<Link>,
}

/// The name of no link.
const NONE: u32 = u32::MAX;

/// So many links are fetched together: what lies all over the memory is then waited for once, not once a link.
const BLOCK: usize = 32;

/// Reduces a graph of `node_count` nodes.
pub fn reduce(order: &impl TotalOrder, node_count: usize, links: &[Link]) -> Reduction {
    let mut state = State::new(order, node_count, links.len());
    for block in decreasing(order, links).chunks(BLOCK) {
        let mut ends = [[0; 2]; BLOCK];
        for (ends, &link) in ends.iter_mut().zip(block) {
            *ends = links[link as usize].ends;
        }
        for ends in &mut ends[..block.len()] {
            *ends = ends.map(|node| state.nodes[node as usize].elder);
        }
        for (&link, ends) in block.iter().zip(ends) {
            state.take(link, ends, links);
        }
    }
    state.finish(links)
}

/// Places of links, in decreasing order.
fn decreasing(order: &impl TotalOrder, links: &[Link]) -> Vec<u32> {
    let scale = |place: u32| links[place as usize].scale;
    in_order(links.iter().map(|link| !ordinal(link.scale)), |run| {
        run.sort_unstable_by(|&a, &b| scale(b).total_cmp(&scale(a)));
        for tied in run.chunk_by_mut(|&a, &b| scale(a) == scale(b)).filter(|tied| tied.len() > 1) {
            // What decides is looked up once a link: on a lattice all links are of two or three scales.
            let ties: Vec<u64> = tied.iter().map(|&place| !order.break_link_tie(links[place as usize].edge)).collect();
            let sorted = in_order_by(ties.iter().copied(), |a, b| ties[a as usize].cmp(&ties[b as usize]));
            let places: Vec<u32> = sorted.into_iter().map(|tie| tied[tie as usize]).collect();
            tied.copy_from_slice(&places);
        }
    })
}

/// A node in the union-find.
#[derive(Clone, Copy)]
struct Node {
    weight: f64,
    /// An elder node of its component; itself, if it is the component's maximum.
    elder: u32,
    /// The link that ends it, once it has ended for good.
    ended_by: u32,
}

/// What has become of a link.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fate {
    Loop,
    Merge,
}

/// A union-find whose roots are the maxima of their components.
struct State<'a, O> {
    order: &'a O,
    nodes: Vec<Node>,
    /// Of a root: whether its component has an open node.
    open: Vec<bool>,
    fates: Vec<Fate>,
    /// The reduced graph.
    left: Vec<Link>,
}

impl<'a, O: TotalOrder> State<'a, O> {
    fn new(order: &'a O, node_count: usize, link_count: usize) -> Self {
        let nodes = 0..node_count as u32;
        let alone = |node| Node { weight: order.weight(node), elder: node, ended_by: NONE };
        Self {
            order,
            nodes: nodes.clone().map(alone).collect(),
            open: nodes.map(|node| order.is_open(node)).collect(),
            fates: vec![Fate::Loop; link_count],
            left: Vec::new(),
        }
    }

    #[inline]
    fn root(&mut self, mut node: u32) -> u32 {
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

    #[inline]
    fn is_younger(&self, a: u32, b: u32) -> bool {
        let [by_weight, other] = [a, b].map(|node| self.nodes[node as usize].weight);
        by_weight < other || by_weight == other && self.order.break_node_tie(a, b) == Ordering::Less
    }

    /// One link, `links[link]`, between the components of two nodes: the elder rule.
    #[inline]
    fn take(&mut self, link: u32, between: [u32; 2], links: &[Link]) {
        let [a, b] = between.map(|node| self.root(node));
        if a == b {
            return;
        }
        self.fates[link as usize] = Fate::Merge;
        let (younger, elder) = if self.is_younger(a, b) { (a, b) } else { (b, a) };
        if self.open[younger as usize] {
            self.left.push(Link { ends: [younger, elder], ..links[link as usize] });
            self.open[elder as usize] = true;
        } else {
            self.nodes[younger as usize].ended_by = link;
        }
        self.nodes[younger as usize].elder = elder;
    }

    fn finish(self, links: &[Link]) -> Reduction {
        let ended = self.nodes.iter().zip(0..).filter(|(node, _)| node.ended_by != NONE);
        let pair = |(node, death): (&Node, u32)| {
            let link = &links[node.ended_by as usize];
            Pair { scale: link.scale, edge: link.edge, death }
        };
        let mut pairs = Vec::with_capacity(self.nodes.len());
        pairs.extend(ended.map(pair));
        let mut tree = Vec::with_capacity(links.len() - pairs.len() - self.left.len());
        tree.extend(links.iter().zip(&self.fates).filter(|(_, fate)| **fate == Fate::Loop).map(|(link, _)| link.edge));
        Reduction { pairs, tree, links: self.left }
    }
}
