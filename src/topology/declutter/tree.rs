//! A tree over the points: it finds neighbours of a point, and points whose neighbourhoods a change is in.
//!
//! In: positions with their slots, which come and go.
//! Out: leaves of entries, and nodes with the bounds of what is below them.
//! Invariants: every point is in one leaf. Node 0 is the root. No answer depends on the shape of the tree. Bounds are
//! right after a [`refresh`](Tree::refresh).
//! Must not know: which points are clutter.
//!
//! A node is halved at the median of its points along its longer side, in a total order (one coordinate, then the
//! other). So any cloud can be halved: collinear, clustered or far-flung. A leaf that exceeds its capacity is halved.
//! A node with few points becomes a leaf. One in whose larger half a point comes is built anew if that has most of its
//! points; it takes as many changes to get there, so a change takes logarithmic time on average, on any cloud. The
//! depth is logarithmic in the largest number of points that there were.

use crate::topology::cloud::{Position, Slot};

/// The most points of a leaf.
pub(super) const LEAF: usize = 16;

/// The place of a node.
pub type NodeId = u32;

/// The node of all points.
pub(super) const ROOT: NodeId = 0;

const NONE: u32 = u32::MAX;

/// A point.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Where it is.
    pub position: Position,
    /// Its slot in the cloud.
    pub slot: Slot,
    /// Whether it is near points that are much closer together.
    pub is_contrasted: bool,
    /// The squared distance of its K-th nearest neighbour; infinite without so many, no number until it is found.
    pub reach: f64,
}

/// Bounds of what is below a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub low: [f64; 2],
    pub high: [f64; 2],
    /// The least reach.
    pub least: f64,
    /// The largest reach.
    pub most: f64,
    /// The largest reach of a point that passes.
    pub passing: f64,
}

const NOTHING: Bounds = Bounds {
    low: [f64::INFINITY; 2],
    high: [f64::NEG_INFINITY; 2],
    least: f64::INFINITY,
    most: f64::NEG_INFINITY,
    passing: 0.0,
};

#[derive(Clone, Copy, Debug)]
pub(super) enum Body {
    /// The place of its entries.
    Leaf { chunk: u32 },
    /// Points before a position, in the order of an axis, and the others.
    Halves { axis: usize, at: [f64; 2], halves: [NodeId; 2] },
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub bounds: Bounds,
    pub body: Body,
    /// The number of points.
    count: u32,
    parent: NodeId,
    /// Whether its bounds have to be found anew.
    is_stale: bool,
}

/// The points.
#[derive(Clone, Debug)]
pub struct Tree {
    pub(super) nodes: Vec<Node>,
    free_nodes: Vec<NodeId>,
    chunks: Vec<Vec<Entry>>,
    free_chunks: Vec<u32>,
    /// The leaf of each slot.
    leaves: Vec<NodeId>,
}

impl Default for Tree {
    fn default() -> Self {
        Self::new(Vec::new())
    }
}

impl Tree {
    /// A tree of entries.
    pub fn new(mut entries: Vec<Entry>) -> Self {
        let mut tree = Self {
            nodes: Vec::with_capacity(entries.len() / 4 + 1),
            free_nodes: Vec::new(),
            chunks: Vec::with_capacity(entries.len() / 8 + 1),
            free_chunks: Vec::new(),
            leaves: Vec::new(),
        };
        let root = tree.new_node(NONE);
        tree.build(root, &mut entries);
        tree
    }

    /// The number of points.
    pub fn len(&self) -> usize {
        self.nodes[ROOT as usize].count as usize
    }

    /// The bounding box, as its least and its greatest coordinates, after a refresh.
    pub fn bounds(&self) -> [[f64; 2]; 2] {
        let bounds = &self.nodes[ROOT as usize].bounds;
        [bounds.low, bounds.high]
    }

    /// The largest reach of a point that passes, after a refresh.
    pub fn largest_passing(&self) -> f64 {
        self.nodes[ROOT as usize].bounds.passing
    }

    /// All points; those of a leaf together.
    pub fn entries(&self) -> impl Iterator<Item = &Entry> {
        self.chunks.iter().flatten()
    }

    /// All leaves.
    pub fn leaves(&self) -> Vec<NodeId> {
        let mut leaves = Vec::with_capacity(self.chunks.len());
        let mut todo = vec![ROOT];
        while let Some(id) = todo.pop() {
            match self.nodes[id as usize].body {
                Body::Leaf { .. } => leaves.push(id),
                Body::Halves { halves: [before, after], .. } => todo.extend([after, before]),
            }
        }
        leaves
    }

    /// The points of a leaf.
    pub fn leaf_entries(&self, leaf: NodeId) -> &[Entry] {
        let Body::Leaf { chunk } = self.nodes[leaf as usize].body else { unreachable!("it is a leaf") };
        &self.chunks[chunk as usize]
    }

    /// The points of a leaf, to change their reach or contrast.
    pub fn leaf_entries_mut(&mut self, leaf: NodeId) -> &mut [Entry] {
        self.spoil(leaf);
        let Body::Leaf { chunk } = self.nodes[leaf as usize].body else { unreachable!("it is a leaf") };
        &mut self.chunks[chunk as usize]
    }

    /// About how many bytes it takes.
    pub fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>()
            + self.chunks.len() * (size_of::<Vec<Entry>>() + LEAF * size_of::<Entry>())
            + self.leaves.capacity() * size_of::<NodeId>()
    }

    /// The leaf in which a position is, or would be.
    pub fn leaf_of(&self, position: Position) -> NodeId {
        let mut id = ROOT;
        while let Body::Halves { axis, at, halves } = self.nodes[id as usize].body {
            id = halves[half(axis, at, position)];
        }
        id
    }

    /// The leaf of a slot in use.
    pub fn leaf(&self, slot: Slot) -> NodeId {
        self.leaves[slot as usize]
    }

    /// The point in a slot in use.
    pub fn entry(&self, slot: Slot) -> &Entry {
        let entry = self.leaf_entries(self.leaf(slot)).iter().find(|entry| entry.slot == slot);
        entry.expect("a slot in use is in its leaf")
    }

    /// The point in a slot in use, to change its reach or contrast.
    pub fn entry_mut(&mut self, slot: Slot) -> &mut Entry {
        let leaf = self.leaf(slot);
        let entry = self.leaf_entries_mut(leaf).iter_mut().find(|entry| entry.slot == slot);
        entry.expect("a slot in use is in its leaf")
    }

    /// Marks the bounds of a node and of all above it as stale.
    fn spoil(&mut self, mut id: NodeId) {
        while id != NONE && !self.nodes[id as usize].is_stale {
            self.nodes[id as usize].is_stale = true;
            id = self.nodes[id as usize].parent;
        }
    }

    /// Adds a point.
    pub fn insert(&mut self, entry: Entry) {
        let (mut id, mut lopsided) = (ROOT, None);
        loop {
            let node = &mut self.nodes[id as usize];
            node.count += 1;
            node.is_stale = true;
            let count = node.count;
            let Body::Halves { axis, at, halves } = node.body else { break };
            let child = halves[half(axis, at, entry.position)];
            if lopsided.is_none() && is_lopsided(self.nodes[child as usize].count + 1, count) {
                lopsided = Some(id);
            }
            id = child;
        }
        let Body::Leaf { chunk } = self.nodes[id as usize].body else { unreachable!("the walk ends in a leaf") };
        self.chunks[chunk as usize].push(entry);
        self.set_leaf(entry.slot, id);
        let is_full = self.chunks[chunk as usize].len() > LEAF;
        if let Some(id) = lopsided.or(is_full.then_some(id)) {
            self.rebuild(id);
        }
    }

    /// Removes the point in a slot in use.
    pub fn remove(&mut self, slot: Slot) -> Entry {
        let leaf = self.leaf(slot);
        let entry = *self.entry(slot);
        let Body::Leaf { chunk } = self.nodes[leaf as usize].body else { unreachable!("points are in leaves") };
        self.chunks[chunk as usize].retain(|other| other.slot != slot);
        let (mut id, mut small) = (leaf, None);
        while id != NONE {
            let node = &mut self.nodes[id as usize];
            node.count -= 1;
            node.is_stale = true;
            if node.count as usize <= LEAF / 2 && matches!(node.body, Body::Halves { .. }) {
                small = Some(id);
            }
            id = node.parent;
        }
        if let Some(id) = small {
            self.rebuild(id);
        }
        entry
    }

    fn set_leaf(&mut self, slot: Slot, leaf: NodeId) {
        if self.leaves.len() <= slot as usize {
            self.leaves.resize(slot as usize + 1, NONE);
        }
        self.leaves[slot as usize] = leaf;
    }

    fn new_node(&mut self, parent: NodeId) -> NodeId {
        let chunk = self.free_chunks.pop().unwrap_or_else(|| {
            self.chunks.push(Vec::with_capacity(LEAF + 1));
            (self.chunks.len() - 1) as u32
        });
        let node = Node { bounds: NOTHING, body: Body::Leaf { chunk }, count: 0, parent, is_stale: true };
        match self.free_nodes.pop() {
            Some(id) => {
                self.nodes[id as usize] = node;
                id
            }
            None => {
                self.nodes.push(node);
                (self.nodes.len() - 1) as NodeId
            }
        }
    }

    /// Builds what is below a node anew.
    fn rebuild(&mut self, id: NodeId) {
        let mut entries = Vec::with_capacity(self.nodes[id as usize].count as usize);
        let mut todo = vec![id];
        while let Some(below) = todo.pop() {
            match self.nodes[below as usize].body {
                Body::Leaf { chunk } => {
                    entries.append(&mut self.chunks[chunk as usize]);
                    self.free_chunks.push(chunk);
                }
                Body::Halves { halves, .. } => todo.extend(halves),
            }
            if below != id {
                self.free_nodes.push(below);
            }
        }
        let chunk = self.free_chunks.pop().expect("there is a leaf below every node");
        self.nodes[id as usize].body = Body::Leaf { chunk };
        self.spoil(id);
        self.build(id, &mut entries);
    }

    /// Builds what is below a node, which is an empty leaf so far.
    fn build(&mut self, id: NodeId, entries: &mut [Entry]) {
        let mut todo = vec![(id, entries)];
        while let Some((id, entries)) = todo.pop() {
            self.nodes[id as usize].count = entries.len() as u32;
            let Body::Leaf { chunk } = self.nodes[id as usize].body else { unreachable!("it is a leaf so far") };
            if entries.len() <= LEAF {
                entries.iter().for_each(|entry| self.set_leaf(entry.slot, id));
                self.chunks[chunk as usize].extend_from_slice(entries);
                continue;
            }
            let axis = longer_side(entries);
            let middle = entries.len() / 2;
            entries.select_nth_unstable_by(middle, |a, b| {
                let [a, b] = [a, b].map(|entry| key(axis, entry.position));
                a[0].total_cmp(&b[0]).then_with(|| a[1].total_cmp(&b[1]))
            });
            let at = key(axis, entries[middle].position);
            self.free_chunks.push(chunk);
            let halves = [self.new_node(id), self.new_node(id)];
            self.nodes[id as usize].body = Body::Halves { axis, at, halves };
            let (before, after) = entries.split_at_mut(middle);
            todo.extend([(halves[1], after), (halves[0], before)]);
        }
    }

    /// Finds stale bounds anew. Points pass whose reach is at most `limit`, and those that are contrasted only if
    /// `with_contrasted`.
    pub fn refresh(&mut self, limit: f64, with_contrasted: bool) {
        self.refresh_node(ROOT, limit, with_contrasted);
    }

    fn refresh_node(&mut self, id: NodeId, limit: f64, with_contrasted: bool) -> Bounds {
        let node = self.nodes[id as usize];
        if !node.is_stale {
            return node.bounds;
        }
        let bounds = match node.body {
            Body::Leaf { chunk } => self.chunks[chunk as usize].iter().fold(NOTHING, |bounds, entry| {
                let passes = entry.reach <= limit && (with_contrasted || !entry.is_contrasted);
                let (xy, reach) = (entry.position.xy(), entry.reach);
                let passing = if passes { reach } else { 0.0 };
                bounds.with(&Bounds { low: xy, high: xy, least: reach, most: reach, passing })
            }),
            Body::Halves { halves, .. } => {
                let [a, b] = halves.map(|half| self.refresh_node(half, limit, with_contrasted));
                a.with(&b)
            }
        };
        let node = &mut self.nodes[id as usize];
        (node.bounds, node.is_stale) = (bounds, false);
        bounds
    }

    /// Marks all bounds as stale.
    pub fn spoil_all(&mut self) {
        self.nodes.iter_mut().for_each(|node| node.is_stale = true);
    }

    /// Panics when the tree is inconsistent. For tests.
    #[cfg(test)]
    pub fn check(&self) {
        let mut todo = vec![(ROOT, NONE, 0)];
        let (mut nodes, mut points) = (0, 0);
        while let Some((id, parent, depth)) = todo.pop() {
            nodes += 1;
            let node = &self.nodes[id as usize];
            assert_eq!(node.parent, parent);
            assert!(f64::from(depth) <= 14.0 + 2.5 * f64::from(self.nodes[ROOT as usize].count.max(1)).log2());
            match node.body {
                Body::Leaf { chunk } => {
                    assert_eq!(node.count as usize, self.chunks[chunk as usize].len());
                    assert!(node.count as usize <= LEAF);
                    points += self.chunks[chunk as usize].len();
                    self.chunks[chunk as usize].iter().for_each(|entry| assert_eq!(self.leaf_of(entry.position), id));
                    self.chunks[chunk as usize].iter().for_each(|entry| assert_eq!(self.leaf(entry.slot), id));
                }
                Body::Halves { halves, .. } => {
                    assert_eq!(node.count, halves.map(|half| self.nodes[half as usize].count).iter().sum::<u32>());
                    todo.extend(halves.map(|half| (half, id, depth + 1)));
                }
            }
        }
        assert_eq!(nodes + self.free_nodes.len(), self.nodes.len());
        assert_eq!(points, self.entries().count());
    }
}

impl Bounds {
    fn with(mut self, other: &Self) -> Self {
        for axis in [0, 1] {
            self.low[axis] = self.low[axis].min(other.low[axis]);
            self.high[axis] = self.high[axis].max(other.high[axis]);
        }
        self.least = self.least.min(other.least);
        self.most = self.most.max(other.most);
        self.passing = self.passing.max(other.passing);
        self
    }
}

/// Whether one half has so much of a node that it is built anew.
fn is_lopsided(larger: u32, count: u32) -> bool {
    larger as usize > 2 * LEAF + count as usize * 3 / 4
}

/// The coordinate of an axis, then the other one.
fn key(axis: usize, position: Position) -> [f64; 2] {
    let [x, y] = position.xy();
    if axis == 0 { [x, y] } else { [y, x] }
}

/// The half that a position is in.
#[inline]
fn half(axis: usize, at: [f64; 2], position: Position) -> usize {
    usize::from(key(axis, position) >= at)
}

fn longer_side(entries: &[Entry]) -> usize {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for entry in entries {
        for (axis, v) in entry.position.xy().into_iter().enumerate() {
            (low[axis], high[axis]) = (low[axis].min(v), high[axis].max(v));
        }
    }
    usize::from(high[1] - low[1] > high[0] - low[0])
}
