//! The table of messages and their types, and how a message becomes bytes.
//!
//! In: a [`Message`] and its channel, or a type and a body. Out: a whole frame, or a message.
//!
//! Invariants: the number of a type is never given to another message. A version neither reads nor writes messages of a
//! later version.
//!
//! Must not know: how fields are written.

use crate::admin::*;
use crate::codec::{self, BodyError, Shared};
use crate::consumer::*;
use crate::daemon::*;
use crate::frame::header;
use crate::producer::*;
use crate::space::*;
use crate::tracks::*;
use crate::types::FrameInfo;

macro_rules! messages {
    ($($kind:literal $name:ident($body:ty) $(since $since:literal)?,)*) => {
        /// Any message.
        #[derive(Clone, Debug, PartialEq)]
        #[allow(missing_docs, reason = "each is documented as the type of its body")]
        pub enum Message {
            $($name($body),)*
        }

        impl Message {
            /// Type and name of every message.
            pub const KINDS: &[(u16, &str)] = &[$(($kind, stringify!($name)),)*];

            /// The type of this message.
            pub fn kind(&self) -> u16 {
                match self {
                    $(Self::$name(_) => $kind,)*
                }
            }

            /// The first version that has this message.
            pub fn since(&self) -> u16 {
                match self {
                    $(Self::$name(_) => first_version([$($since)?]),)*
                }
            }

            /// Reads the body of a message of a given type, as a given version defines it.
            ///
            /// # Errors
            /// [`BodyError`].
            pub fn decode(version: u16, kind: u16, body: &[u8]) -> Result<Self, BodyError> {
                match kind {
                    $($kind if version >= first_version([$($since)?]) => codec::decode(kind, body).map(Self::$name),)*
                    kind => Err(BodyError::UnknownType { kind }),
                }
            }

            fn seal(&self) -> Result<Shared, BodyError> {
                match self {
                    $(Self::$name(body) => codec::seal($kind, body),)*
                }
            }
        }

        $(impl From<$body> for Message {
            fn from(body: $body) -> Self {
                Self::$name(body)
            }
        })*
    };
}

/// The first version of a message. It is 1 where the table gives none.
fn first_version<const N: usize>(since: [u16; N]) -> u16 {
    since.first().copied().unwrap_or(1)
}

// The numbers 0x010C, 0x020F and 0x0309 stay free: bad vectors say that no message has them.
messages! {
    0x0001 Hello(Hello),
    0x0002 Welcome(Welcome),
    0x0003 Ping(Ping),
    0x0004 Pong(Pong),
    0x0005 Goodbye(Goodbye),
    0x0006 Error(Report),
    0x0007 ListStreams(ListStreams),
    0x0008 Streams(Streams),
    0x0009 GetStatus(StatusWanted),
    0x000A Status(Status),
    0x000B ListSpaces(ListSpaces) since 4,
    0x000C Spaces(Spaces) since 4,
    0x0101 Open(Open),
    0x0102 Opened(Opened),
    0x0103 Batch(Batch),
    0x0104 Retract(Retract),
    0x0105 Commit(Commit),
    0x0106 Close(Close),
    0x0107 Closed(Closed),
    0x0108 Accepted(Accepted),
    0x0109 Refused(Refused),
    0x010A Committed(Committed),
    0x010B Overloaded(Overloaded),
    0x010D OpenSpace(OpenSpace) since 4,
    0x010E SpaceOpened(SpaceOpened) since 4,
    0x010F SpaceBatch(SpaceBatch) since 4,
    0x0110 SpaceRetract(SpaceRetract) since 4,
    0x0201 Subscribe(Subscribe),
    0x0202 ChangeView(ChangeView),
    0x0203 Unsubscribe(Unsubscribe),
    0x0204 StreamOpened(StreamOpened),
    0x0205 StreamClosed(StreamClosed),
    0x0206 Snapshot(Snapshot),
    0x0207 Diff(Diff),
    0x0208 Dots(Dots),
    0x0209 Heartbeat(Heartbeat),
    0x020A Lagged(Lagged),
    0x020B Resumed(Resumed),
    0x020C Unsubscribed(Unsubscribed),
    0x020D WantTracks(WantTracks) since 2,
    0x020E Tracks(Tracks) since 2,
    0x0210 SpaceSnapshot(SpaceSnapshot) since 4,
    0x0211 SpaceDiff(SpaceDiff) since 4,
    0x0212 SpaceDots(SpaceDots) since 4,
    0x0213 SpaceTracks(SpaceTracks) since 4,
    0x0301 ListPeers(ListPeers) since 3,
    0x0302 Peers(Peers) since 3,
    0x0303 StopStream(StopStream) since 3,
    0x0304 StreamStopped(StreamStopped) since 3,
    0x0305 Disconnect(Disconnect) since 3,
    0x0306 Disconnected(Disconnected) since 3,
    0x0307 GetMemory(GetMemory) since 3,
    0x0308 Memory(Memory) since 3,
    0x0F01 Elapsed(Elapsed),
}

impl Message {
    /// The number of the stream that it tells a consumer about; none for other messages.
    pub fn stream(&self) -> Option<u32> {
        Some(match self {
            Self::StreamOpened(opened) => opened.stream,
            Self::StreamClosed(closed) => closed.stream,
            Self::Snapshot(snapshot) => snapshot.stream,
            Self::Diff(diff) => diff.stream,
            Self::Dots(dots) => dots.stream,
            Self::Tracks(tracks) => tracks.stream,
            Self::SpaceSnapshot(snapshot) => snapshot.stream,
            Self::SpaceDiff(diff) => diff.stream,
            Self::SpaceDots(dots) => dots.stream,
            Self::SpaceTracks(tracks) => tracks.stream,
            Self::Heartbeat(heartbeat) => heartbeat.stream,
            Self::Lagged(lagged) => lagged.stream,
            Self::Resumed(resumed) => resumed.stream,
            _ => return None,
        })
    }

    /// The frame of a view that it leads to; none for other messages.
    pub fn frame(&self) -> Option<&FrameInfo> {
        match self {
            Self::Snapshot(snapshot) => Some(&snapshot.frame),
            Self::Diff(diff) => Some(&diff.frame),
            Self::SpaceSnapshot(snapshot) => Some(&snapshot.frame),
            Self::SpaceDiff(diff) => Some(&diff.frame),
            _ => None,
        }
    }
}

/// Encodes a message as a whole frame.
///
/// # Errors
/// [`BodyError::UnknownType`]: the version has no such message. [`BodyError::TooLong`]: the body has more than 4 GiB.
pub fn encode(version: u16, channel: u32, message: &Message) -> Result<Vec<u8>, BodyError> {
    if version < message.since() {
        return Err(BodyError::UnknownType { kind: message.kind() });
    }
    let shared = message.seal()?;
    let header = header(version, shared.kind, channel, shared.length);
    Ok([&header, &*shared.bytes].concat())
}

/// Encodes the body of a message that is sent to many receivers.
///
/// Each receiver gets its own [`header`], with its own channel, and then these bytes. The body is the same in every
/// version that has the message; see [`Message::since`].
///
/// # Errors
/// [`BodyError::TooLong`]: the body has more than 4 GiB.
pub fn encode_shared(message: &Message) -> Result<Shared, BodyError> {
    message.seal()
}
