//! Publishing: from a stream's pipeline to the messages of its consumers.
//!
//! In: closed frames, requests of cursors. Out: messages.
//!
//! Invariants: a frame is encoded once per view; what is published knows no reader of it.
//!
//! Must not know: producers, connections.
//!
//! Data flows from `views` (and `tracking`) to the logs (`view_log`, `track_log`, `published`), and from these to
//! `cursor`.

pub mod any_tracks;
pub mod cursor;
pub mod published;
pub mod track_log;
pub mod tracking;
pub mod view_log;
pub mod views;
