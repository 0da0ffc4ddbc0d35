//! Formats: between bytes and points, skeletons, tracks and pictures.
//!
//! In: bytes of files and pipes, or values of the core and of the wire.
//! Out: the other of the two.
//! Invariants: what cannot be used is reported with its place; memory is bounded by what has arrived.
//! Must not know: sockets, threads, arguments.

pub mod aligned;
pub mod degrees;
pub mod frame_line;
pub mod frame_writer;
pub mod images;
pub mod input;
pub mod layout;
pub mod messages;
pub mod picture;
pub mod point_writer;
pub mod points;
pub mod projection;
pub mod recording;
pub mod runs;
pub mod scene;
pub mod short;
pub mod skeleton;
pub mod tracks;
