//! The reduction: persistent pairs and the minimum spanning tree out of a weighted dual graph, by the elder rule.
//!
//! In: nodes with weights (some of them open: they have links that this call does not see) and links with scales, under one
//! total order. Out: a [`Reduction`]. Taking links by DEcreasing scale, a link that joins two components ends the one with
//! the smaller maximum (the younger); a link inside one component is an edge of the minimum spanning tree. Invariants, for every
//! link handed in: it is in exactly one of `pairs`, `tree` and `links`; without open nodes `links` is empty; for any cut of a
//! graph into parts, reducing the parts and then the union of what they leave gives the pairs and the tree of the whole.
//! Must not know: what nodes and links stand for.
//!
//! Before it sorts anything, the pass takes the links that are pairs at sight, as Ripser takes its apparent pairs: the last link
//! of a closed node, in the order, ends that node there, if it leads to an elder one. Each round of that is linear and takes away a good half of
//! the nodes; only what is left is sorted. See design notes in the README, "How a frame is computed".

use std::cmp::Ordering;

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
    /// Compares two links of equal scale; never `Equal` for different ones.
    fn break_link_tie(&self, a: u32, b: u32) -> Ordering;
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
    /// Resolved pairs.
    pub pairs: Vec<Pair>,
    /// Edges of the minimum spanning tree.
    pub tree: Vec<u32>,
    /// The reduced graph: merges whose younger side is open, each between the maxima of its two sides.
    pub links: Vec<Link>,
}

/// While a round takes away at least one in so many links, another one costs less than sorting would.
const WORTHWHILE: usize = 16;

/// Below so many links, sorting is at once as good.
const FEW: usize = 64;

/// Reduces a graph of `node_count` nodes.
///
/// `links` is consumed as working space.
pub fn reduce(order: &impl TotalOrder, node_count: usize, mut links: Vec<Link>) -> Reduction {
    let mut state = State::new(order, node_count, links.len());
    state.contract(&mut links);
    loop {
        let before = links.len();
        state.take_apparent(&mut links);
        state.contract(&mut links);
        if links.len() < FEW || (before - links.len()) * WORTHWHILE < before {
            break;
        }
    }
    links.sort_unstable_by(|a, b| compare_links(order, b, a));
    for link in links {
        state.take(link);
    }
    state.result
}

/// The name of no link.
const NONE: u32 = u32::MAX;

/// By value; numbers that are no NaN are totally ordered so.
#[inline]
fn compare(a: f64, b: f64) -> Ordering {
    (a > b).cmp(&(a < b))
}

#[inline]
fn compare_links(order: &impl TotalOrder, a: &Link, b: &Link) -> Ordering {
    compare(a.scale, b.scale).then_with(|| order.break_link_tie(a.edge, b.edge))
}

/// A node in the union-find, with what a round looks up of it beside it in memory.
#[derive(Clone, Copy)]
struct Node {
    /// An elder node of its component; itself, if it is the component's maximum.
    elder: u32,
    /// In a round, of a root: the last of its links in the order, and that link's scale.
    last: u32,
    last_scale: f64,
}

/// A union-find whose roots are the maxima of their components.
struct State<'a, O> {
    order: &'a O,
    nodes: Vec<Node>,
    weights: Vec<f64>,
    /// Of a root: whether its component has an open node.
    open: Vec<bool>,
    result: Reduction,
}

impl<'a, O: TotalOrder> State<'a, O> {
    fn new(order: &'a O, node_count: usize, link_count: usize) -> Self {
        let nodes = 0..node_count as u32;
        let alone = |node| Node { elder: node, last: NONE, last_scale: f64::NEG_INFINITY };
        let result = Reduction {
            pairs: Vec::with_capacity(node_count),
            tree: Vec::with_capacity((link_count + 1).saturating_sub(node_count)),
            links: Vec::new(),
        };
        Self {
            order,
            nodes: nodes.clone().map(alone).collect(),
            weights: nodes.clone().map(|node| order.weight(node)).collect(),
            open: nodes.map(|node| order.is_open(node)).collect(),
            result,
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
        let by_weight = compare(self.weights[a as usize], self.weights[b as usize]);
        by_weight.then_with(|| self.order.break_node_tie(a, b)) == Ordering::Less
    }

    /// One link, in the order: the elder rule.
    fn take(&mut self, link: Link) {
        let [a, b] = link.ends.map(|node| self.root(node));
        if a == b {
            return self.result.tree.push(link.edge);
        }
        let (younger, elder) = if self.is_younger(a, b) { (a, b) } else { (b, a) };
        if self.open[younger as usize] {
            self.result.links.push(Link { ends: [younger, elder], ..link });
            self.open[elder as usize] = true;
            self.nodes[younger as usize].elder = elder;
        } else {
            self.end(younger, elder, &link);
        }
    }

    /// A closed component ends in an elder one.
    #[inline]
    fn end(&mut self, younger: u32, elder: u32, link: &Link) {
        self.result.pairs.push(Pair { scale: link.scale, edge: link.edge, death: younger });
        self.nodes[younger as usize].elder = elder;
    }

    /// Moves links to the roots of their ends, takes out those that are used up and the loops, which are edges of the tree, and finds the
    /// last link of every root.
    fn contract(&mut self, links: &mut Vec<Link>) {
        links.retain_mut(|link| {
            if link.edge == NONE {
                return false;
            }
            link.ends = link.ends.map(|node| self.root(node));
            let [a, b] = link.ends;
            if a == b {
                self.result.tree.push(link.edge);
                return false;
            }
            self.note_last(a, link);
            self.note_last(b, link);
            true
        });
    }

    #[inline]
    fn note_last(&mut self, root: u32, link: &Link) {
        let node = self.nodes[root as usize];
        let is_later = if link.scale == node.last_scale {
            self.order.break_link_tie(node.last, link.edge) == Ordering::Less
        } else {
            link.scale > node.last_scale
        };
        // A selection rather than a branch: which is later is anybody's guess.
        let (last, last_scale) = if is_later { (link.edge, link.scale) } else { (node.last, node.last_scale) };
        self.nodes[root as usize] = Node { last, last_scale, ..node };
    }

    /// Takes, of links contracted just now, the pairs that need no sorting.
    ///
    /// The last link of a closed component in the order is where it meets its first neighbour, all of it; if the neighbour's maximum is
    /// elder, then so is that of whatever the neighbour has become by then. Every such component can go at once.
    fn take_apparent(&mut self, links: &mut [Link]) {
        for link in links {
            let [a, b] = link.ends;
            let is_last = [a, b].map(|root| self.nodes[root as usize].last == link.edge);
            for (root, other, is_last) in [(a, b, is_last[0]), (b, a, is_last[1])] {
                if is_last {
                    let node = &mut self.nodes[root as usize];
                    (node.last, node.last_scale) = (NONE, f64::NEG_INFINITY);
                    if !self.open[root as usize] && self.is_younger(root, other) {
                        self.end(root, other, link);
                        link.edge = NONE;
                    }
                }
            }
        }
    }
}
