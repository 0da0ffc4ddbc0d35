//! The tree of tiles: the reduction of a cloud, kept so that a change costs what it touches.
//!
//! In: a [`Cloud`], its [`Delaunay`] triangulation, and what changed in both. Out: a [`Difference`] of the minimum spanning tree and of the dots.
//! The plane is cut into tiles, a binary k-d tree over the vertices: each leaf has about as many, and holds their [`Stars`]. Each leaf and each tile of
//! every second level is reduced, by a [`Workshop`]; it keeps what it resolved and what it leaves to the one above. A change reads the stars it has touched anew,
//! reduces their leaves, and climbs as far as borders change.
//!
//! ```text
//!  change ──▶ dirty vertices ──▶ stars ──▶ leaves ──▶ tiles above, deepest first ──▶ root
//!             (watcher)          (read)    (split, merged,    │ stops where a border
//!                                           rebuilt)          ▼ stays as it was
//!                                                      resolved, old and new ──▶ difference
//! ```
//!
//! Invariants: the skeleton found is that of one pass over everything, bit for bit, whatever the tiles and whatever the number of threads;
//! no tile is deeper than a few times the logarithm of the number of vertices, wherever they lie. Must not know: ids, views.

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
pub use touched::{Guide, Touched};
pub use tree::{LEAF, Tiles};
