//! The reduction on random graphs: compared with a plain union-find with the elder rule, in one pass and tile by tile.

mod common;

use std::cmp::Ordering;

use common::clouds::cases;
use hopes::topology::stages::{Elders, Link, Pair, TotalOrder, reduce};
use proptest::prelude::*;

/// The result of a reduction as lists.
#[derive(Clone, Debug, Default, PartialEq)]
struct Outcome {
    pairs: Vec<Pair>,
    tree: Vec<u32>,
    left: Vec<Link>,
}

/// A dual graph: nodes on a grid, and the outer node 0, which may be next to any of them.
#[derive(Clone, Debug)]
struct Graph {
    /// The weight of the outer node is infinite.
    weights: Vec<f64>,
    /// They order nodes of equal weights. All are different.
    node_ranks: Vec<u32>,
    /// Named by their indices here.
    links: Vec<Link>,
    /// They order links of equal scales. All are different.
    link_ranks: Vec<u32>,
    /// The tile of each node, except of the outer node, which is in all tiles.
    tiles: Vec<u32>,
}

const OUTER: u32 = 0;

impl Graph {
    fn node_count(&self) -> usize {
        self.weights.len()
    }

    /// Whether a link is in one tile of `4 >> level`. Two or four tiles make one of the next level.
    fn is_inside(&self, link: &Link, tile: u32, level: u32) -> bool {
        link.ends.iter().all(|&node| node == OUTER || self.tiles[node as usize] >> level == tile)
            // A loop at the outer node belongs to the first tile.
            && (link.ends != [OUTER; 2] || tile == 0)
    }

    /// Nodes with links outside of this set.
    fn open_nodes(&self, is_seen: impl Fn(&Link) -> bool) -> Vec<bool> {
        let mut open = vec![false; self.node_count()];
        for node in self.links.iter().filter(|link| !is_seen(link)).flat_map(|link| link.ends) {
            open[node as usize] = true;
        }
        open
    }

    fn reduce(&self, open: Vec<bool>, links: &[Link]) -> Outcome {
        let reduction = reduce(&Order { graph: self, open: &open }, self.node_count(), links);
        let (pairs, tree) = (reduction.pairs().collect(), reduction.tree().collect());
        let reduction = Outcome { pairs, tree, left: reduction.left };
        assert_shared_out(links, &reduction);
        if !open.contains(&true) {
            assert_eq!(reduction.left, [], "without open nodes nothing is left");
        }
        reduction
    }

    fn in_one_pass(&self) -> Outcome {
        sorted(self.reduce(vec![false; self.node_count()], &self.links))
    }

    /// Four tiles, then two, then one. The rest of each level, and the links that are inside now, make the graph of the
    /// next level.
    fn tile_by_tile(&self) -> Outcome {
        let mut whole = Outcome::default();
        let mut left: Vec<Vec<Link>> = vec![Vec::new(); 8];
        for level in 0..3 {
            let children = left;
            left = Vec::new();
            for tile in 0..4 >> level {
                let is_new = |link: &&Link| {
                    let was_inside = |child| level > 0 && self.is_inside(link, child, level - 1);
                    self.is_inside(link, tile, level) && !(0..8).any(was_inside)
                };
                let mut links: Vec<Link> = self.links.iter().filter(is_new).copied().collect();
                links.extend(children[2 * tile as usize..][..2].iter().flatten());
                let open = self.open_nodes(|link| self.is_inside(link, tile, level));
                let reduction = self.reduce(open, &links);
                whole.pairs.extend(reduction.pairs);
                whole.tree.extend(reduction.tree);
                left.push(reduction.left);
            }
            left.resize(8, Vec::new());
        }
        assert!(left.concat().is_empty(), "nothing is open at the top");
        sorted(whole)
    }

    /// The rule itself: by decreasing scale, every merge ends the younger maximum.
    fn by_the_rule(&self) -> Outcome {
        let mut links = self.links.clone();
        let link_rank = |link: &Link| self.link_ranks[link.edge as usize];
        links.sort_by(|a, b| b.scale.total_cmp(&a.scale).then(link_rank(b).cmp(&link_rank(a))));
        let age = |node: u32| (self.weights[node as usize], self.node_ranks[node as usize]);
        let mut elder_of: Vec<u32> = (0..self.node_count() as u32).collect();
        let mut result = Outcome::default();
        for link in links {
            let [a, b] = link.ends.map(|node| elder_of[node as usize]);
            if a == b {
                result.tree.push(link.edge);
                continue;
            }
            let (younger, elder) = if age(a) < age(b) { (a, b) } else { (b, a) };
            result.pairs.push(Pair { scale: link.scale, edge: link.edge, death: younger });
            elder_of.iter_mut().filter(|node| **node == younger).for_each(|node| *node = elder);
        }
        sorted(result)
    }
}

/// Each input link is in exactly one of the three lists.
fn assert_shared_out(links: &[Link], reduction: &Outcome) {
    let mut handed_in: Vec<u32> = links.iter().map(|link| link.edge).collect();
    let mut given: Vec<u32> = reduction.pairs.iter().map(|pair| pair.edge).collect();
    given.extend(&reduction.tree);
    given.extend(reduction.left.iter().map(|link| link.edge));
    handed_in.sort_unstable();
    given.sort_unstable();
    assert_eq!(given, handed_in, "each link in exactly one list");
}

fn sorted(mut reduction: Outcome) -> Outcome {
    reduction.pairs.sort_unstable_by_key(|pair| pair.edge);
    reduction.tree.sort_unstable();
    reduction
}

struct Order<'a> {
    graph: &'a Graph,
    open: &'a [bool],
}

impl Elders for Order<'_> {
    fn weight(&self, node: u32) -> f64 {
        self.graph.weights[node as usize]
    }

    fn break_node_tie(&self, a: u32, b: u32) -> Ordering {
        self.graph.node_ranks[a as usize].cmp(&self.graph.node_ranks[b as usize])
    }
}

impl TotalOrder for Order<'_> {
    fn is_open(&self, node: u32) -> bool {
        self.open[node as usize]
    }

    fn break_link_tie(&self, edge: u32) -> u64 {
        self.graph.link_ranks[edge as usize].into()
    }
}

/// The steps to neighbours on a grid.
const STEPS: [[i32; 2]; 3] = [[1, 0], [0, 1], [1, 1]];

/// Graphs on grids, with few different weights and scales (many ties) or many; with missing and doubled links, loops
/// and links to the outer node; with scales below the weights of both ends, as in a filtration, or without such a rule;
/// with any division into tiles.
fn graphs() -> impl Strategy<Value = Graph> {
    let size = (1..9_i32, 1..9_i32, prop_oneof![Just(4_u32), Just(1000)], any::<bool>());
    size.prop_flat_map(|(width, height, values, is_filtration)| {
        let nodes = (width * height + 1) as usize;
        let slots = nodes * (STEPS.len() + 1);
        // For each possible link: its multiplicity, and a number for its scale.
        let links = prop::collection::vec((prop_oneof![1 => Just(0), 4 => Just(1), 1 => Just(2)], 0..values), slots);
        let weights = prop::collection::vec(0..values, nodes);
        let random_tiles = prop::collection::vec(0..4_u32, nodes);
        let quarters: Vec<u32> = (0..nodes as i32)
            .map(|node| {
                let (x, y) = ((node - 1).max(0) % width, (node - 1).max(0) / width);
                u32::from(2 * x > width) + 2 * u32::from(2 * y > height)
            })
            .collect();
        let tiles = prop_oneof![Just(quarters), random_tiles];
        let node_ranks = Just((0..nodes as u32).collect::<Vec<_>>()).prop_shuffle();
        let link_ranks = Just((0..2 * slots as u32).collect::<Vec<_>>()).prop_shuffle();
        (links, weights, tiles, node_ranks, link_ranks).prop_map(
            move |(links, weights, tiles, node_ranks, link_ranks)| {
                let mut weights: Vec<f64> = weights.into_iter().map(f64::from).collect();
                weights[OUTER as usize] = f64::INFINITY;
                let mut graph = Graph { weights, node_ranks, links: Vec::new(), link_ranks, tiles };
                for (slot, (times, value)) in links.into_iter().enumerate() {
                    let (from, step) = (slot / (STEPS.len() + 1), slot % (STEPS.len() + 1));
                    let to = match STEPS.get(step) {
                        Some(&[dx, dy]) if from > 0 => {
                            let (x, y) = ((from as i32 - 1) % width + dx, (from as i32 - 1) / width + dy);
                            if x < width && y < height { (1 + x + y * width) as u32 } else { OUTER }
                        }
                        Some(_) => OUTER,
                        // Sometimes a loop.
                        None if value % 4 == 0 => from as u32,
                        None => continue,
                    };
                    let ends = [from as u32, to];
                    let highest =
                        ends.map(|node| graph.weights[node as usize]).into_iter().fold(f64::INFINITY, f64::min);
                    let scale = if is_filtration { f64::from(value).min(highest) } else { f64::from(value) };
                    for _ in 0..times {
                        graph.links.push(Link { scale, ends, edge: graph.links.len() as u32 });
                    }
                }
                graph
            },
        )
    })
}

proptest! {
    #![proptest_config(cases(2000))]

    #[test]
    fn one_pass_follows_the_elder_rule(graph in graphs()) {
        prop_assert_eq!(graph.in_one_pass(), graph.by_the_rule());
    }

    #[test]
    fn four_tiles_equal_one_pass(graph in graphs()) {
        prop_assert_eq!(graph.tile_by_tile(), graph.by_the_rule());
    }

    /// One division into two tiles, anywhere.
    #[test]
    fn two_tiles_equal_one_pass(mut graph in graphs()) {
        for tile in &mut graph.tiles {
            *tile &= 1;
        }
        prop_assert_eq!(graph.tile_by_tile(), graph.by_the_rule());
    }
}

#[test]
fn no_nodes_and_no_links() {
    for nodes in 0..3 {
        let graph = Graph {
            weights: vec![f64::INFINITY; nodes],
            node_ranks: (0..nodes as u32).collect(),
            links: Vec::new(),
            link_ranks: Vec::new(),
            tiles: vec![0; nodes],
        };
        assert_eq!(graph.in_one_pass(), Outcome::default());
    }
}

/// If the younger side is open, its merge cannot be resolved. It is passed on, between the maxima of both sides.
#[test]
fn merges_of_an_open_node_are_passed_on() {
    let link = |edge: u32, scale, ends| Link { scale, ends, edge };
    let graph = Graph {
        weights: vec![f64::INFINITY, 5.0, 9.0, 7.0],
        node_ranks: vec![0, 1, 2, 3],
        links: vec![link(0, 4.0, [1, 2]), link(1, 3.0, [2, 3]), link(2, 2.0, [1, 3]), link(3, 1.0, [3, 0])],
        link_ranks: vec![0, 1, 2, 3],
        tiles: vec![0; 4],
    };
    let open = vec![false, true, false, false];
    let reduction = graph.reduce(open, &graph.links);
    assert_eq!(reduction.left, [link(0, 4.0, [1, 2]), link(3, 1.0, [2, 0])]);
    assert_eq!(reduction.pairs, [Pair { scale: 3.0, edge: 1, death: 3 }]);
    assert_eq!(reduction.tree, [2]);
}
