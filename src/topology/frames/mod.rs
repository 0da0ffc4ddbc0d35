//! From one frame to the next: what changed in the skeleton, and what that changes in a view.
//!
//! In: skeletons, or changes of one that is stored elsewhere ([`HeldSkeleton`]).
//! Out: steps with diffs and checksums.
//! Must not know: triangulations, how skeletons are found, formats.

mod change;
mod diagram;
mod diff;
mod follow;
mod frame;
mod held;
mod merge;
mod simplified;
mod step;
mod view_rule;

pub use change::{Change, DotChange, Tree};
pub use diagram::{Diagram, NamedDot, Persistent};
pub use diff::{ApplyError, Checksum, Diff, Presence, Snapshot};
pub use follow::Follower;
pub use frame::Frame;
pub use held::HeldSkeleton;
pub use simplified::SimplifiedFollower;
pub use step::Step;
pub use view_rule::ViewRule;
