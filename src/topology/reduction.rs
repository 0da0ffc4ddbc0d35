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

/// What decides between equals: the rest of the one total order.
pub trait TotalOrder {
    /// Compares two links of equal scale; never `Equal` for different ones.
    fn break_tie(&self, a: u32, b: u32) -> Ordering;
    /// The elder rule's order of nodes; `Greater` when `a` is the elder. Never `Equal` for different nodes.
    fn compare_nodes(&self, a: u32, b: u32) -> Ordering;
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
    let mut state = State {
        order,
        elder: (0..node_count as u32).collect(),
        open: (0..node_count as u32).map(|node| order.is_open(node)).collect(),
        result: Reduction {
            pairs: Vec::with_capacity(node_count),
            tree: Vec::with_capacity((links.len() + 1).saturating_sub(node_count)),
            links: Vec::new(),
        },
    };
    let mut latest = vec![Latest::default(); node_count];
    state.contract(&mut links, &mut latest);
    loop {
        let before = links.len();
        state.take_apparent(&mut links, &mut latest);
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

const NONE: u32 = u32::MAX;

/// The last link of a node, in the order: its place among the links, and its scale once more, to spare a look there.
#[derive(Clone, Copy)]
struct Latest {
    scale: f64,
    link: u32,
}

impl Default for Latest {
    fn default() -> Self {
        Self { scale: f64::NEG_INFINITY, link: NONE }
    }
}

#[inline]
fn compare_links(order: &impl TotalOrder, a: &Link, b: &Link) -> Ordering {
    // Scales are no NaN: plain comparisons are a total order.
    match (a.scale > b.scale).cmp(&(a.scale < b.scale)) {
        Ordering::Equal => order.break_tie(a.edge, b.edge),
        decided => decided,
    }
}

/// A union-find whose roots are the maxima of their components.
struct State<'a, O> {
    order: &'a O,
    elder: Vec<u32>,
    /// Of a root: whether its component has an open node.
    open: Vec<bool>,
    result: Reduction,
}

impl<O: TotalOrder> State<'_, O> {
    #[inline]
    fn root(&mut self, mut node: u32) -> u32 {
        loop {
            let parent = self.elder[node as usize];
            let grandparent = self.elder[parent as usize];
            if parent == grandparent {
                return parent;
            }
            self.elder[node as usize] = grandparent;
            node = grandparent;
        }
    }

    /// One link, in the order: the elder rule.
    fn take(&mut self, link: Link) {
        let [a, b] = link.ends.map(|node| self.root(node));
        if a == b {
            return self.result.tree.push(link.edge);
        }
        let (younger, elder) = match self.order.compare_nodes(a, b) {
            Ordering::Less => (a, b),
            _ => (b, a),
        };
        if self.open[younger as usize] {
            self.result.links.push(Link { ends: [younger, elder], ..link });
            self.open[elder as usize] = true;
        } else {
            self.result.pairs.push(Pair { scale: link.scale, edge: link.edge, death: younger });
        }
        self.elder[younger as usize] = elder;
    }

    /// A round over all links between roots: takes the pairs that need no sorting, and what has become a loop by them.
    ///
    /// The last link of a closed component in the order is where it meets its first neighbour, all of it; if the neighbour's maximum is
    /// elder, then so is that of whatever the neighbour has become by then. Every such component can go at once.
    fn take_apparent(&mut self, links: &mut Vec<Link>, latest: &mut [Latest]) {
        for (index, link) in links.iter().enumerate() {
            for node in link.ends {
                let best = latest[node as usize];
                let is_later = if link.scale == best.scale {
                    self.order.break_tie(links[best.link as usize].edge, link.edge) == Ordering::Less
                } else {
                    link.scale > best.scale
                };
                // A selection rather than a branch: which is later is anybody's guess.
                latest[node as usize] = if is_later { Latest { scale: link.scale, link: index as u32 } } else { best };
            }
        }
        for (index, link) in links.iter_mut().enumerate() {
            let [a, b] = link.ends;
            for (younger, elder) in [(a, b), (b, a)] {
                if latest[younger as usize].link == index as u32
                    && !self.open[younger as usize]
                    && self.order.compare_nodes(younger, elder) == Ordering::Less
                {
                    self.result.pairs.push(Pair { scale: link.scale, edge: link.edge, death: younger });
                    self.elder[younger as usize] = elder;
                    link.edge = NONE;
                    break;
                }
            }
        }
        self.contract(links, latest);
    }

    /// Moves links to the roots of their ends and drops loops, which are edges of the tree.
    fn contract(&mut self, links: &mut Vec<Link>, latest: &mut [Latest]) {
        links.retain_mut(|link| {
            for node in link.ends {
                latest[node as usize] = Latest::default();
            }
            if link.edge == NONE {
                return false;
            }
            link.ends = link.ends.map(|node| self.root(node));
            let loops = link.ends[0] == link.ends[1];
            if loops {
                self.result.tree.push(link.edge);
            }
            !loops
        });
    }
}
