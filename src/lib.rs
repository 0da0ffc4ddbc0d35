//! wip
pub mod topology;
