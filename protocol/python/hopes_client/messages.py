"""Every message of the protocol, versions 1 and 2, as a dataclass whose fields are declared in the order of the wire.

In: field values. Out: the classes, `Message.TYPE` and `Message.SINCE` of each, `encode` and `decode`.
Invariants: the type hint of a field is the only description of how it is written; a field that is named like a Python
keyword has an underscore after its name (`Diff.from_`); `decode(TYPE, encode(message)) == message`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Optional, Union

from .codec import F64, U16, U32, U64, AnyF64, Packed, decode_body, encode_body
from .errors import BodyError
from .shared import Cause, Critical, DotsWanted, Edge, FrameHeader, Policy, Vertex, View, Window
from .tracks import Track, TrackCycle, TrackEvent, TracksWanted
from .wire import HIGHEST_VERSION, LOWEST_VERSION

#: The message classes by type number.
BY_TYPE: dict[int, type[Message]] = {}


@dataclass(frozen=True)
class Message:
    """A message; `TYPE` is its type number, `SINCE` the first version that has it."""

    TYPE: ClassVar[int]
    SINCE: ClassVar[int]

    def __init_subclass__(cls, type: int, since: int = LOWEST_VERSION) -> None:
        cls.TYPE = type
        cls.SINCE = since
        BY_TYPE[type] = cls


def encode(message: Message) -> bytearray:
    """The body of the message. `ValueError` if a field holds what it may not."""
    return encode_body(message)


def decode(type: int, body: bytes, version: int = HIGHEST_VERSION) -> Any:
    """The message of that type that the body holds, as a version has it. Raises nothing but `BodyError`."""
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
    """The last message of whoever sends it; the daemon's has the (name, last frame) of each stream."""

    reason: str
    streams: list[tuple[str, U64]]


@dataclass(frozen=True)
class Error(Message, type=0x0006):
    """The daemon cannot do what it was asked for."""

    code: U16
    answers: U16
    text: str


@dataclass(frozen=True)
class ListStreams(Message, type=0x0007):
    """Asks for the streams whose names match."""

    pattern: str


@dataclass(frozen=True)
class StreamInfo:
    """A stream, as the daemon lists it."""

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
    """A stream, as the daemon's status shows it."""

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
    """Takes points back."""

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
    """The end of a producer's channel."""

    frame: U64


@dataclass(frozen=True)
class Accepted(Message, type=0x0108):
    """All points of a batch were taken; `placed` has (tag, vertex)."""

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
    """The frame that a `Commit` closed."""

    sequence: U64
    frame: U64


@dataclass(frozen=True)
class Overloaded(Message, type=0x010B):
    """The daemon dropped a batch, as it could not keep up."""

    sequence: U64
    points: U32
    total: U64
    policy: Policy


# Consumers.


@dataclass(frozen=True)
class Resume:
    """What a consumer had when it lost its connection."""

    epoch: U64
    frame: U64


@dataclass(frozen=True)
class Subscribe(Message, type=0x0201):
    """Follows the streams whose names match."""

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
    """The end of a stream."""

    stream: U32
    frame: U64
    reason: str


@dataclass(frozen=True)
class Snapshot(Message, type=0x0206):
    """All that a consumer holds of a stream."""

    stream: U32
    cause: Cause
    frame: FrameHeader
    vertices: list[Vertex]
    edges: list[Edge]
    critical: list[Critical]
    checksum: U64


@dataclass(frozen=True)
class Diff(Message, type=0x0207):
    """What has changed from one frame to another."""

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
    """The newest frame of a stream in which nothing happens."""

    stream: U32
    frame: U64


@dataclass(frozen=True)
class Lagged(Message, type=0x020A):
    """The first and last frame that are not sent singly."""

    stream: U32
    first: U64
    last: U64


@dataclass(frozen=True)
class Resumed(Message, type=0x020B):
    """The subscription goes on from `frame`."""

    stream: U32
    frame: U64


@dataclass(frozen=True)
class Unsubscribed(Message, type=0x020C):
    """The end of the subscription."""


# Tracks.


@dataclass(frozen=True)
class WantTracks(Message, type=0x020D, since=2):
    """Asks to see so much of the tracks from here on."""

    tracks: TracksWanted


@dataclass(frozen=True)
class Tracks(Message, type=0x020E, since=2):
    """What has happened to tracks from one frame to another; from 0, all that are alive."""

    stream: U32
    from_: U64
    frame: U64
    time: Optional[F64]
    events: list[TrackEvent]
    alive: Optional[list[Track]]
    cycles: list[TrackCycle]


# Files.


@dataclass(frozen=True)
class Elapsed(Message, type=0x0F01):
    """The time since a recording began."""

    nanoseconds: U64
