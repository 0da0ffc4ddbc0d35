"""The messages about streams of points in R^d, of version 4 of the protocol (section 13 of the specification).

In: field values. Out: `Metric`, the classes of the messages, and names for a message of either kind of stream.
Invariants: as in `messages`, where these classes are registered too. The rows of `vertices` and `vertices_added` are
whole points, or the message is refused with `ResyncNeeded`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Optional, Union

from .codec import F64, U32, U64, AnyF64, Cases, Choice, DeathF64, Packed
from .errors import ResyncNeeded
from .messages import Diff, Dots, Message, Opened, Snapshot, Tracks
from .shared import Cause, Edge, FrameHeader, Window
from .tracks import Happening, TrackCycle

#: (a, b, birth, death). The death of an edge whose cycle is never filled is infinite.
SpaceCritical = tuple[U64, U64, F64, DeathF64]


class Metric(Choice):
    """How the distance of two points is measured."""

    CASES: ClassVar[Cases] = {"Euclidean": (), "Manhattan": (), "Chebyshev": (), "Angular": (), "Haversine": ()}

    @classmethod
    def of(cls, name: Union[str, Metric]) -> Metric:
        """From its name, in any case: "euclidean", "manhattan", "chebyshev", "angular", "haversine"."""
        if isinstance(name, Metric):
            return name
        if name.capitalize() not in cls.CASES:
            raise ValueError(f"a metric is one of {', '.join(cls.CASES).lower()}, not {name!r}")
        return cls(name.capitalize())


@dataclass(frozen=True)
class ListSpaces(Message, type=0x000B, since=4):
    """Asks which streams have points in R^d."""


@dataclass(frozen=True)
class SpaceInfo:
    """The space of a stream. `dimension` is none until the first point has come."""

    stream: U32
    metric: Metric
    dimension: Optional[U32]


@dataclass(frozen=True)
class Spaces(Message, type=0x000C, since=4):
    """The answer to `ListSpaces`, by number."""

    streams: list[SpaceInfo]


@dataclass(frozen=True)
class OpenSpace(Message, type=0x010D, since=4):
    """Joins or creates a stream of points in R^d."""

    name: str
    window: Optional[Window]
    resolution: Optional[F64]
    metric: Optional[Metric]
    dimension: Optional[U32]


@dataclass(frozen=True)
class SpaceOpened(Message, type=0x010E, since=4):
    """The answer to `OpenSpace`."""

    opened: Opened
    metric: Metric
    dimension: Optional[U32]
    max_vertices: U64


@dataclass(frozen=True)
class SpaceBatch(Message, type=0x010F, since=4):
    """Adds points. The lists of `f64` may be given in their encoded form, as `Packed`."""

    sequence: U64
    dimension: U32
    coordinates: Union[list[AnyF64], Packed]
    times: Union[list[AnyF64], Packed]
    tags: list[U64]


@dataclass(frozen=True)
class SpaceRetract(Message, type=0x0110, since=4):
    """Retracts points."""

    sequence: U64
    dimension: U32
    coordinates: Union[list[AnyF64], Packed]


@dataclass(frozen=True)
class SpaceSnapshot(Message, type=0x0210, since=4):
    """A complete view. `dimension` is 0 if no point has come yet."""

    stream: U32
    cause: Cause
    frame: FrameHeader
    metric: Metric
    dimension: U32
    ids: list[U64]
    coordinates: list[F64]
    edges: list[Edge]
    critical: list[SpaceCritical]
    checksum: U64

    @property
    def vertices(self) -> list[tuple[Any, ...]]:
        """(id, x1, …, xd) of each vertex."""
        return _rows(self.ids, self.coordinates, self.dimension)


@dataclass(frozen=True)
class SpaceDiff(Message, type=0x0211, since=4):
    """The changes of a view between two frames."""

    stream: U32
    from_: U64
    frame: FrameHeader
    dimension: U32
    ids_added: list[U64]
    coordinates_added: list[F64]
    vertices_removed: list[U64]
    edges_added: list[Edge]
    edges_removed: list[Edge]
    critical_set: list[SpaceCritical]
    critical_removed: list[Edge]
    checksum: U64

    @property
    def vertices_added(self) -> list[tuple[Any, ...]]:
        """(id, x1, …, xd) of each new vertex."""
        return _rows(self.ids_added, self.coordinates_added, self.dimension)


@dataclass(frozen=True)
class SpaceDot:
    """A dot of the persistence diagram. Without `death` its cycle is never filled."""

    edge: Edge
    birth: F64
    death: Optional[F64]
    death_edge: Optional[Edge]


@dataclass(frozen=True)
class SpaceDots(Message, type=0x0212, since=4):
    """The dots asked for, the most persistent first, of `total`."""

    stream: U32
    frame: U64
    total: U64
    dots: list[SpaceDot]


@dataclass(frozen=True)
class SpaceTrack:
    """A persistent cycle in its last reported state.

    Without `death` its cycle is never filled. `center` is the mean of its vertices, `radius` half the largest distance
    of two of them. `velocity` is the movement of the centre in one frame.
    """

    id: U64
    age: U64
    birth: F64
    death: Optional[F64]
    center: list[F64]
    radius: F64
    velocity: list[F64]
    selected: bool

    @property
    def persistence(self) -> float:
        """Death minus birth."""
        return math.inf if self.death is None else self.death - self.birth


@dataclass(frozen=True)
class SpaceTrackEvent:
    """An event of a track. `track` is the state after the event."""

    frame: U64
    time: Optional[F64]
    happening: Happening
    track: SpaceTrack


@dataclass(frozen=True)
class SpaceTracks(Message, type=0x0213, since=4):
    """The events of tracks between two frames. From 0: a list of all living tracks."""

    stream: U32
    from_: U64
    frame: U64
    time: Optional[F64]
    events: list[SpaceTrackEvent]
    alive: Optional[list[SpaceTrack]]
    cycles: list[TrackCycle]


#: A message of either kind of stream.
AnySnapshot = Union[Snapshot, SpaceSnapshot]
AnyDiff = Union[Diff, SpaceDiff]
AnyDots = Union[Dots, SpaceDots]
AnyTracks = Union[Tracks, SpaceTracks]

SNAPSHOTS = (Snapshot, SpaceSnapshot)
DIFFS = (Diff, SpaceDiff)
DOTS = (Dots, SpaceDots)
TRACKS = (Tracks, SpaceTracks)


def _rows(ids: Sequence[int], coordinates: Sequence[float], dimension: int) -> list[tuple[Any, ...]]:
    """The id and the coordinates of each vertex."""
    if len(coordinates) != len(ids) * dimension or (ids and not dimension):
        raise ResyncNeeded(f"{len(coordinates)} coordinates came for {len(ids)} vertices of {dimension} each")
    # In dimension 0 there is no vertex.
    return [(id, *coordinates[at * dimension : (at + 1) * dimension]) for at, id in enumerate(ids)]
