//! The lives of tracks: read from lines of `serve --track`, written as a table or a chart.
//!
//! In: JSON lines.
//! Out: a table, CSV, JSON or a barcode picture.
//! Invariants: memory grows with tracks, not with frames.
//! Must not know: how tracks are made, where bytes come from and go to.
//!
//! Data flows from `reader` (lines) through `frame` (a line) to `lives`, then to `table` and, through `order`, to
//! `chart`.

pub mod chart;
pub mod frame;
pub mod lives;
mod order;
pub mod reader;
pub mod table;
