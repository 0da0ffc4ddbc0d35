//! Mirrors: a consumer's verified copies of what a stream sends.
//!
//! In: messages of one stream, in the order of arrival. Out: its newest frame and its living tracks.
//!
//! Invariants: after an error a mirror reports that its content is not valid, and accepts only a new start.
//!
//! Must not know: where messages come from.

mod any;
mod checksum;
mod position;
mod skeleton;
mod track_message;
mod tracks;

pub use any::AnyMirror;
pub use checksum::{Checksum, Element};
pub use position::{Coordinates, Place, Position};
pub use skeleton::{ElementId, Mirror, MirrorError, SpaceMirror};
pub use track_message::{TrackMessage, TrackState, TrackStep};
pub use tracks::{SpaceTrackMirror, TrackMirror, TrackMirrorError};
