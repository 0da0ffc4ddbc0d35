//! Arguments that several subcommands share, or that fill a file of their own.
//!
//! In: words of the command line.
//! Out: options of the core, of the daemon, of the client and of formats.
//! Invariants: a value that cannot be used is refused here, with what it may be; every scale is a radius.
//! Must not know: input and output.

mod forms;
mod peers;
mod sockets;
mod tracks;
mod values;
mod view;

pub use peers::{Connect, FollowArgs, To, name};
pub use sockets::{PLACES, SocketArgs};
pub use tracks::TrackArgs;
pub use values::{duration, host_and_port, host_name, number, origin, rate, resolution, scene, window};
pub use view::{SimplifiedViewArgs, Threshold, ViewArgs};
