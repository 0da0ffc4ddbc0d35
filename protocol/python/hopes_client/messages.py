"""The messages of protocol versions 1 to 3 as dataclasses whose fields have the order of the wire. Version 4: `spaces`.

In: field values. Out: the classes, their `TYPE` and `SINCE`, `encode` and `decode`. Invariants: only type hints define
encodings. A Python keyword as a field ends in `_` (`Diff.from_`). `decode(TYPE, encode(message)) == message`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Optional, Union

from .admin import Peer, StreamMemory
from .codec import F64, U16, U32, U64, AnyF64, Packed, decode_body, encode_body
from .errors import BodyError
from .shared import Cause, Critical, DotsWanted, Edge, FrameHeader, Policy, Vertex, View, Window
from .tracks import Track, TrackCycle, TrackEvent, TracksWanted
from .wire import HIGHEST_VERSION, LOWEST_VERSION

#: The message classes by type number.
BY_TYPE: dict[int, type[Message]] = {}


@dataclass(frozen=True)
class Message:
    """A message. `TYPE` is the number of its type, `SINCE` the first version that has it."""

    TYPE: ClassVar[int]
    SINCE: ClassVar[int]

    def __init_subclass__(cls, type: int, since: int = LOWEST_VERSION) -> None:
        cls.TYPE = type
        cls.SINCE = since
        BY_TYPE[type] = cls


def encode(message: Message) -> bytearray:
    """Encodes the body. `ValueError` if a field has an invalid value."""
    return encode_body(message)


def decode(type: int, body: bytes, version: int = HIGHEST_VERSION) -> Any:
    """Decodes the body of a message of a type, as a version defines it. Raises only `BodyError`."""
    if type not in BY_TYPE or version < BY_TYPE[type].SINCE:
        raise BodyError(f"the message type {type:#06x} is not known in version {version} of the protocol")
    return decode_body(BY_TYPE[type], body)


# The connection.


@dataclass(frozen=True)
class Hello(Message, type=0x0001):
    """The client's first message."""

    software: str
    capabilities: list[str]


@dataclass(frozen=True)
class Welcome(Message, type=0x0002):
    """The daemon's answer to `Hello`."""

    software: str
    capabilities: list[str]
    epoch: U64
    largest_frame: U32
    largest_batch: U32
    heartbeat_ms: U32
    timeout_ms: U32


@dataclass(frozen=True)
class Ping(Message, type=0x0003):
    """Asks for a `Pong` with the same token."""

    token: U64


@dataclass(frozen=True)
class Pong(Message, type=0x0004):
    """The answer to `Ping`."""

    token: U64


@dataclass(frozen=True)
class Goodbye(Message, type=0x0005):
    """The last message of either side. The daemon's has (name, last frame) of each stream."""

    reason: str
    streams: list[tuple[str, U64]]


@dataclass(frozen=True)
class Error(Message, type=0x0006):
    """The daemon could not handle a message."""

    code: U16
    answers: U16
    text: str


@dataclass(frozen=True)
class ListStreams(Message, type=0x0007):
    """Asks for the streams whose names match."""

    pattern: str


@dataclass(frozen=True)
class StreamInfo:
    """A stream in the daemon's list."""

    stream: U32
    name: str
    epoch: U64
    window: Window
    resolution: Optional[F64]
    frame: U64
    points: U64
    vertices: U64
    producers: U32
    consumers: U32


@dataclass(frozen=True)
class Streams(Message, type=0x0008):
    """The answer to `ListStreams`."""

    streams: list[StreamInfo]


@dataclass(frozen=True)
class GetStatus(Message, type=0x0009):
    """Asks for the state of the daemon."""


@dataclass(frozen=True)
class StreamStatus:
    """A stream in the daemon's status."""

    info: StreamInfo
    computed: U64
    accepted: U64
    refused: U64
    dropped: U64
    waiting: U64
    lagged: U64
    memory: U64


@dataclass(frozen=True)
class Status(Message, type=0x000A):
    """The answer to `GetStatus`."""

    software: str
    uptime_ms: U64
    epoch: U64
    connections: U32
    refused_messages: U64
    memory: U64
    memory_limit: U64
    streams: list[StreamStatus]


@dataclass(frozen=True)
class Elapsed(Message, type=0x0F01):
    """The time since a recording began. Only in files."""

    nanoseconds: U64


# Producers.


@dataclass(frozen=True)
class Open(Message, type=0x0101):
    """Joins or creates a stream."""

    name: str
    window: Optional[Window]
    resolution: Optional[F64]


@dataclass(frozen=True)
class Opened(Message, type=0x0102):
    """The answer to `Open`."""

    stream: U32
    epoch: U64
    created: bool
    window: Window
    resolution: Optional[F64]
    frame: U64
    largest_batch: U32


@dataclass(frozen=True)
class Batch(Message, type=0x0103):
    """Adds points. The lists of `f64` may be given in their encoded form, as `Packed`."""

    sequence: U64
    points: Union[list[tuple[AnyF64, AnyF64]], Packed]
    times: Union[list[AnyF64], Packed]
    tags: list[U64]


@dataclass(frozen=True)
class Retract(Message, type=0x0104):
    """Retracts points."""

    sequence: U64
    points: Union[list[tuple[AnyF64, AnyF64]], Packed]


@dataclass(frozen=True)
class Commit(Message, type=0x0105):
    """Closes a frame."""

    sequence: U64
    time: Optional[F64]


@dataclass(frozen=True)
class Close(Message, type=0x0106):
    """Ends the channel, and with `end` the stream."""

    end: bool


@dataclass(frozen=True)
class Closed(Message, type=0x0107):
    """The answer to `Close`."""

    frame: U64


@dataclass(frozen=True)
class Accepted(Message, type=0x0108):
    """All points of a batch were accepted. `placed` has (tag, vertex)."""

    sequence: U64
    points: U32
    placed: list[tuple[U64, U64]]


@dataclass(frozen=True)
class Refusal:
    """Why the point at `index` of a batch was refused."""

    index: U32
    code: U16
    text: str


@dataclass(frozen=True)
class Refused(Message, type=0x0109):
    """Some points of a batch were refused."""

    sequence: U64
    accepted: U32
    refused: U32
    reasons: list[Refusal]
    placed: list[tuple[U64, U64]]


@dataclass(frozen=True)
class Committed(Message, type=0x010A):
    """The answer to `Commit`."""

    sequence: U64
    frame: U64


@dataclass(frozen=True)
class Overloaded(Message, type=0x010B):
    """The daemon dropped a batch, since the engine did not keep up."""

    sequence: U64
    points: U32
    total: U64
    policy: Policy


# Consumers.


@dataclass(frozen=True)
class Resume:
    """The position at which a consumer resumes."""

    epoch: U64
    frame: U64


@dataclass(frozen=True)
class Subscribe(Message, type=0x0201):
    """Subscribes to the streams whose names match."""

    pattern: str
    view: View
    dots: DotsWanted
    resume: Optional[Resume]


@dataclass(frozen=True)
class ChangeView(Message, type=0x0202):
    """Asks for another view."""

    view: View
    dots: DotsWanted


@dataclass(frozen=True)
class Unsubscribe(Message, type=0x0203):
    """Ends the subscription."""


@dataclass(frozen=True)
class StreamOpened(Message, type=0x0204):
    """A stream that the subscription follows."""

    stream: U32
    name: str
    epoch: U64
    window: Window
    resolution: Optional[F64]
    frame: U64


@dataclass(frozen=True)
class StreamClosed(Message, type=0x0205):
    """A stream has ended."""

    stream: U32
    frame: U64
    reason: str


@dataclass(frozen=True)
class Snapshot(Message, type=0x0206):
    """A complete view."""

    stream: U32
    cause: Cause
    frame: FrameHeader
    vertices: list[Vertex]
    edges: list[Edge]
    critical: list[Critical]
    checksum: U64


@dataclass(frozen=True)
class Diff(Message, type=0x0207):
    """The changes of a view between two frames."""

    stream: U32
    from_: U64
    frame: FrameHeader
    vertices_added: list[Vertex]
    vertices_removed: list[U64]
    edges_added: list[Edge]
    edges_removed: list[Edge]
    critical_set: list[Critical]
    critical_removed: list[Edge]
    checksum: U64


@dataclass(frozen=True)
class Dot:
    """A dot of the persistence diagram: a hole, and the critical edge that closes it."""

    edge: Edge
    birth: F64
    death: F64
    center: tuple[F64, F64]
    radius: F64


@dataclass(frozen=True)
class Dots(Message, type=0x0208):
    """The dots asked for, the most persistent first, of `total`."""

    stream: U32
    frame: U64
    total: U64
    dots: list[Dot]


@dataclass(frozen=True)
class Heartbeat(Message, type=0x0209):
    """Nothing has changed since this frame. Shows that the daemon is alive."""

    stream: U32
    frame: U64


@dataclass(frozen=True)
class Lagged(Message, type=0x020A):
    """The first and the last frame of a range that is not sent frame by frame."""

    stream: U32
    first: U64
    last: U64


@dataclass(frozen=True)
class Resumed(Message, type=0x020B):
    """The subscription resumes at `frame`."""

    stream: U32
    frame: U64


@dataclass(frozen=True)
class Unsubscribed(Message, type=0x020C):
    """The answer to `Unsubscribe`."""


# Tracks.


@dataclass(frozen=True)
class WantTracks(Message, type=0x020D, since=2):
    """Sets what is sent of the tracks from now on."""

    tracks: TracksWanted


@dataclass(frozen=True)
class Tracks(Message, type=0x020E, since=2):
    """The events of tracks between two frames. From 0: a list of all living tracks."""

    stream: U32
    from_: U64
    frame: U64
    time: Optional[F64]
    events: list[TrackEvent]
    alive: Optional[list[Track]]
    cycles: list[TrackCycle]


# Administration.


@dataclass(frozen=True)
class ListPeers(Message, type=0x0301, since=3):
    """Asks for the daemon's peers."""


@dataclass(frozen=True)
class Peers(Message, type=0x0302, since=3):
    """The answer to `ListPeers`, by number."""

    peers: list[Peer]


@dataclass(frozen=True)
class StopStream(Message, type=0x0303, since=3):
    """Ends a stream, for all its peers."""

    name: str


@dataclass(frozen=True)
class StreamStopped(Message, type=0x0304, since=3):
    """The answer to `StopStream`, with the stream's last frame."""

    name: str
    frame: U64


@dataclass(frozen=True)
class Disconnect(Message, type=0x0305, since=3):
    """Ends the connection of a peer."""

    peer: U64


@dataclass(frozen=True)
class Disconnected(Message, type=0x0306, since=3):
    """The answer to `Disconnect`."""

    peer: U64


@dataclass(frozen=True)
class GetMemory(Message, type=0x0307, since=3):
    """Asks what the daemon's memory is used for."""


@dataclass(frozen=True)
class Memory(Message, type=0x0308, since=3):
    """The answer to `GetMemory`, in bytes. `limit` is 0 if there is none. `peers` is the part of `held` for peers."""

    limit: U64
    held: U64
    peers: U64
    streams: list[StreamMemory]
