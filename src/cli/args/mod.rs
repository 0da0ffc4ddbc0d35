//! Arguments that several subcommands share, or that fill a file of their own.
//!
//! In: words of the command line.
//! Out: options of the core, of the daemon, of the client and of formats.
//! Invariants: a value that cannot be used is refused here, with what it may be; every scale is a radius.
//! Must not know: input and output.

mod declutter;
mod detection;
mod embedding;
mod forms;
mod metric;
mod peers;
mod place;
mod places;
mod sockets;
mod stream_space;
mod suffix;
mod tracks;
mod values;
mod view;

pub use declutter::DeclutterArgs;
pub use detection::DetectionArgs;
pub use metric::{MetricArgs, SpaceKind, SpaceOptions, coordinates};
pub use peers::{Connect, FollowArgs, To, name};
pub use place::{Place, USUAL};
pub use places::{ProjectArgs, chosen};
pub use sockets::{PLACES, SocketArgs};
pub use stream_space::{StreamSpace, StreamSpaceArgs, form};
pub use suffix::by_suffix;
pub use tracks::TrackArgs;
pub use values::{
    duration, from_one, host_and_port, host_name, many, number, origin, rank, rate, resolution, scene, whole, window,
    within,
};
pub use view::{SimplifiedViewArgs, Threshold, ViewArgs};
