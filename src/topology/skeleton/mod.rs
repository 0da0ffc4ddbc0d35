//! What a skeleton is, whatever space it came from: dots, tree, gaps, views, cycles, simplification, ranking.
//!
//! In: vertices, tree edges and dots.
//! Out: skeletons, and what is derived from one skeleton alone.
//! Must not know: triangulations, how skeletons are found, frames.

mod cycle;
pub mod gaps;
mod graph;
mod hopes;
mod named;
mod place;
mod ranking;
mod shortest_cycle;
mod simplify;
mod view;

pub use cycle::Cycles;
pub use gaps::{Gap, Margins, Selection, diagonal_gaps, select, vertical_gaps};
pub use graph::SkeletonGraph;
pub use hopes::{Dot, Edge, Filtration, Hole, Killer, Skeleton};
pub use named::{Critical, EdgeId, TreeEdgeId};
pub use place::Positions;
pub use ranking::{RankedDot, Ranking};
pub use shortest_cycle::ShortestCycles;
pub use simplify::{Simplified, simplify};
pub use view::{View, ViewSpec, up_to};
