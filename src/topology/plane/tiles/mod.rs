//! Tiles: the reduction of a cloud, stored so that a change costs what it touches.
//!
//! In: a [`Cloud`](crate::topology::Cloud), its triangulation, and the changes of both.
//! Out: a [`Difference`] of the minimum spanning tree and of the dots, by slots.
//! Invariants: the skeleton equals that of one pass over everything, bit for bit, whatever the tiles and the number of
//! threads. The depth of the tree is at most a few times the logarithm of the number of vertices, wherever they lie.
//! Must not know: ids, views.
//!
//! The plane is cut into tiles, a binary k-d tree over the vertices. A leaf has about as many vertices as any other,
//! and stores their stars. Each leaf, and each tile of every second level, is reduced. It stores the tree edges and
//! dots that it resolved, and its border: what it leaves to the tile above. A change reads the touched stars again,
//! reduces their leaves, and goes up as far as borders change.
//!
//! ```text
//!  change ──▶ touched vertices ──▶ stars ──▶ leaves ──▶ tiles above, deepest first ──▶ root
//!             (observer)           (read)    (split,    │ stops where a border
//!                                            merged,    ▼ does not change
//!                                            rebuilt)  resolved, old and new ──▶ difference
//! ```

mod border;
mod cost_model;
mod difference;
mod faces;
mod resolved;
mod rounds;
mod split;
mod star;
mod star_reader;
mod tile_reduction;
mod touched;
mod tree;
mod tree_shape;
mod worker;

pub use difference::Difference;
pub use touched::{TouchObserver, Touched};
pub use tree::{LEAF, Tiles};
