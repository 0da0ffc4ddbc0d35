//! Views of a skeleton: full, reduced at a scale, derived by gaps.
//!
//! In: a [`Skeleton`] and a [`ViewSpec`].
//! Out: a [`View`]: the tree edges and dots that it shows.
//! Invariants: a view is a subgraph of HoPeS(C) on all its vertices. Tree edges are in order, dots in the skeleton's
//! order. A critical edge of a view never joins two components, since the tree path between its ends consists of edges
//! no longer than itself.
//! Must not know: frames, formats.
//!
//! V. Kurlin 2015, Definitions 8 (reduced) and 14 (derived).

use std::num::NonZeroU32;

use super::gaps::{Selection, TOLERANCE, select_dots};
use super::hopes::{Edge, Skeleton};
use crate::topology::base::compensated_sum;

/// Selects a part of a skeleton. Scales are radii.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ViewSpec {
    /// HoPeS(C): everything.
    Full,
    /// HoPeS(C; alpha): without edges longer than 2 alpha and without critical edges with death <= alpha.
    Reduced {
        /// The scale.
        alpha: f64,
    },
    /// HoPeS_{k,l}(C): by the k-th diagonal and the l-th vertical gap.
    Derived {
        /// Rank of the diagonal gap.
        k: NonZeroU32,
        /// Rank of the vertical gap.
        l: NonZeroU32,
    },
}

impl Default for ViewSpec {
    fn default() -> Self {
        Self::Derived { k: NonZeroU32::MIN, l: NonZeroU32::MIN }
    }
}

/// A part of a skeleton.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// The specification that it was cut by.
    pub spec: ViewSpec,
    /// The selection by gaps, in a derived view.
    pub selection: Option<Selection>,
    /// The tree edges of the view.
    pub tree: Vec<Edge>,
    /// Dots whose critical edges are in the view: places in [`Skeleton::dots`].
    pub critical: Vec<u32>,
    /// The number of connected components, including single vertices.
    pub components: usize,
    /// The number of independent cycles.
    pub cycles: usize,
}

impl View {
    /// Cuts a view out of a skeleton.
    pub fn new(skeleton: &Skeleton, spec: ViewSpec) -> Self {
        let all = 0..skeleton.unsorted_dots().len() as u32;
        match spec {
            ViewSpec::Full => Self::cut(skeleton, spec, None, f64::INFINITY, all),
            ViewSpec::Reduced { alpha } => {
                let shown = |&index: &u32| {
                    let dot = &skeleton.dots()[index as usize];
                    dot.birth <= up_to(alpha) && dot.death > alpha
                };
                Self::cut(skeleton, spec, None, alpha, all.filter(shown))
            }
            ViewSpec::Derived { k, l } => {
                let (selection, dots) = select_dots(skeleton, k, l);
                let vs = selection.vs;
                let lives = |&index: &u32| dots[index as usize].death > vs;
                let critical: Vec<u32> = selection.vs_dots.iter().copied().filter(lives).collect();
                Self::cut(skeleton, spec, Some(selection), vs, critical.into_iter())
            }
        }
    }

    fn cut(
        skeleton: &Skeleton,
        spec: ViewSpec,
        selection: Option<Selection>,
        alpha: f64,
        critical: impl Iterator<Item = u32>,
    ) -> Self {
        let limit = up_to(alpha);
        let short = |(edge, half_length): (Edge, f64)| (half_length <= limit).then_some(edge);
        let tree: Vec<Edge> = skeleton.scaled_tree().filter_map(short).collect();
        let critical: Vec<u32> = critical.collect();
        Self {
            spec,
            selection,
            components: skeleton.vertices().len() - tree.len(),
            cycles: critical.len(),
            tree,
            critical,
        }
    }

    /// The scale of the cut: alpha or vs; infinite for the full view.
    pub fn scale(&self) -> f64 {
        match (self.spec, &self.selection) {
            (ViewSpec::Reduced { alpha }, _) => alpha,
            (_, selection) => selection.as_ref().map_or(f64::INFINITY, |selection| selection.vs),
        }
    }

    /// The total length of its edges.
    pub fn length(&self, skeleton: &Skeleton) -> f64 {
        let edges = self.tree.iter().copied().chain(self.critical_edges(skeleton));
        compensated_sum(edges.map(|edge| skeleton.length(edge)))
    }

    /// Its critical edges, in the order of the dots.
    pub fn critical_edges<'a>(&'a self, skeleton: &'a Skeleton) -> impl Iterator<Item = Edge> + 'a {
        self.critical.iter().map(|&index| skeleton.dots()[index as usize].edge)
    }
}

/// The largest half-length that does not count as longer than `alpha`.
pub fn up_to(alpha: f64) -> f64 {
    alpha * (1.0 + TOLERANCE)
}
