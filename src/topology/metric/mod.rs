//! From distances to tree and dots, in any finite metric space.
//!
//! In: points of R^d, matrices, sparse graphs.
//! Out: the Vietoris-Rips filtration's minimum spanning tree and critical edges.
//! Invariants: see [`rips`].
//! Must not know: the plane, skeletons, streams.
//!
//! | room | what it is for |
//! | --- | --- |
//! | `space` | lengths of pairs: metrics of R^d, matrices, graphs, landmarks |
//! | `rips` | the sweep over pairs in order of length |
//! | `twins` | vertices at distance zero |

pub mod rips;
pub mod space;
pub mod twins;
