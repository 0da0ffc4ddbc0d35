//! The daemon as its peers see it: a real process, real sockets, and clients whose every message is written by the
//! test.

#[path = "daemon/administration.rs"]
mod administration;
#[path = "daemon/clocks.rs"]
mod clocks;
mod common;
#[path = "daemon/ending.rs"]
mod ending;
#[path = "daemon/frozen.rs"]
mod frozen;
#[path = "daemon/handshake.rs"]
mod handshake;
#[path = "daemon/hostile.rs"]
mod hostile;
#[path = "daemon/idle.rs"]
mod idle;
#[path = "daemon/joining.rs"]
mod joining;
#[path = "daemon/limits.rs"]
mod limits;
#[path = "daemon/listening.rs"]
mod listening;
#[path = "daemon/memory.rs"]
mod memory;
#[path = "daemon/overload.rs"]
mod overload;
#[path = "daemon/refusals.rs"]
mod refusals;
#[path = "daemon/slow.rs"]
mod slow;
#[path = "daemon/spaces.rs"]
mod spaces;
#[path = "daemon/stdio.rs"]
mod stdio;
#[path = "daemon/streams.rs"]
mod streams;
#[path = "daemon/tracks.rs"]
mod tracks;
#[path = "daemon/views.rs"]
mod views;
