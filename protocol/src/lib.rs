//! The wire protocol of `hopes`: what a producer or a consumer of a daemon needs to encode and decode messages.
//!
//! `SPEC.md` beside this crate defines every byte. There is no I/O here. The caller reads bytes from a socket, a pipe
//! or a file, pushes them into a [`Decoder`] and takes [`Message`]s out of it; it writes the bytes that [`encode`]
//! returns. A [`Mirror`] is a consumer's verified copy of a view of a stream; a [`TrackMirror`] is a copy of the
//! stream's tracks.
//!
//! ```text
//! bytes ──▶ Decoder ──▶ (channel, Message) ──▶ Mirror, TrackMirror
//! bytes ◀── encode  ◀── (channel, Message)
//! ```
//!
//! The crate supports versions 1 to 4. Frames carry the version that both sides
//! agreed on. A message that this version does not have is neither read nor written.
//!
//! Must not know: sockets, threads, clocks, geometry.
//!
//! ```
//! use hopes_protocol::{Banner, Batch, Decoder, LARGEST_FRAME, Message, VERSION, encode};
//!
//! // A client and a daemon agree on a version...
//! let mut wire = Banner::OURS.encode().to_vec();
//! let version = Banner::OURS.agree(Banner { lowest: 1, highest: 7 }).expect("both speak version 4");
//! assert_eq!(version, VERSION);
//!
//! // ...and the client sends points, which arrive in two pieces.
//! let batch = Batch { sequence: 1, points: vec![(0.0, 0.0), (1.0, 2.0)], times: vec![], tags: vec![] };
//! wire.extend(encode(version, 1, &Message::from(batch.clone()))?);
//! let mut decoder = Decoder::new(LARGEST_FRAME);
//! decoder.push(&wire[..25]);
//! let banner = decoder.banner()?.expect("the banner is complete");
//! decoder.set_version(Banner::OURS.agree(banner)?);
//! assert!(decoder.frame()?.is_none(), "the frame has only begun");
//! decoder.push(&wire[25..]);
//! let frame = decoder.frame()?.expect("the frame is complete");
//! assert_eq!((frame.channel, frame.message()?), (1, Message::Batch(batch)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod admin;
mod banner;
mod codec;
mod consumer;
mod daemon;
mod decoder;
mod fields;
mod frame;
mod message;
mod mirror;
mod producer;
mod space;
mod tracks;
mod types;

pub use admin::{
    Disconnect, Disconnected, GetMemory, ListPeers, Memory, Peer, Peers, StopStream, StreamMemory, StreamStopped,
};
pub use banner::{Banner, FILE_VERSION, NoCommonVersion, SPACE_FILE_VERSION, VERSION};
pub use codec::{BodyError, Shared};
pub use consumer::{
    Cause, ChangeView, Diff, Dots, Heartbeat, Lagged, Resume, Resumed, Snapshot, StreamClosed, StreamOpened, Subscribe,
    Unsubscribe, Unsubscribed,
};
pub use daemon::{
    Elapsed, ErrorCode, Goodbye, Hello, ListStreams, Ping, Pong, Report, Status, StatusWanted, StreamInfo,
    StreamStatus, Streams, Welcome,
};
pub use decoder::{Decoder, Frame};
pub use frame::{FrameError, HEADER, LARGEST_FRAME, header};
pub use message::{Message, encode, encode_shared};
pub use mirror::{
    AnyMirror, Checksum, Coordinates, Element, ElementId, Mirror, MirrorError, Place, Position, SpaceMirror,
    SpaceTrackMirror, TrackMessage, TrackMirror, TrackMirrorError, TrackState, TrackStep,
};
pub use producer::{
    Accepted, Batch, Close, Closed, Commit, Committed, LISTED_REFUSALS, Open, Opened, Overloaded, Policy, Refusal,
    RefusalCode, Refused, Retract,
};
pub use space::{
    ListSpaces, Metric, OpenSpace, SpaceBatch, SpaceDiff, SpaceDot, SpaceDots, SpaceInfo, SpaceOpened, SpaceRetract,
    SpaceSnapshot, SpaceTrack, SpaceTrackEvent, SpaceTracks, Spaces,
};
pub use tracks::{Happening, Track, TrackChanges, TrackCycle, TrackEvent, Tracks, TracksWanted, WantTracks};
pub use types::{
    Critical, Cut, Dot, DotsWanted, Edge, FrameInfo, LONGEST_NAME, Simplify, Vertex, View, Window, is_name, is_pattern,
};
