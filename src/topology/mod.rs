//! wip
#![allow(missing_docs)]
pub mod basins;
pub mod cloud;
pub mod delaunay;
pub mod filtration;
pub mod gaps;
pub mod geometry;
pub mod pipeline;
pub mod view;
pub mod mesh;
pub mod position;
pub mod reduction;
pub mod skeleton;
pub mod window;
pub use cloud::*; pub use pipeline::*; pub use view::*; pub use skeleton::*; pub use window::Window;
pub mod stages { pub use super::{basins::Basins, delaunay::Delaunay, filtration::Filtration}; }
