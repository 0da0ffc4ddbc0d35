"""The types of which `Peers` and `Memory` are made (section 12 of the specification).

In: numbers and texts. Out: `Peer`, `StreamMemory`. Invariant: fields have the order of the wire, and their hints are
the only definition of their encoding.
"""

from __future__ import annotations

from dataclasses import dataclass

from .codec import U32, U64


@dataclass(frozen=True)
class Peer:
    """The other end of one of the daemon's connections.

    `place` is the daemon's address to which it has connected. `software` is empty before its `Hello`. `connected_ms` is
    the time since it has connected, `silent_ms` since it has sent something. `producers` and `consumers` are channels.
    `held` is what the daemon holds for it, `received` and `sent` what went over the connection, in bytes. `lagged`
    counts the frames that it was not sent one by one.
    """

    peer: U64
    place: str
    software: str
    connected_ms: U64
    silent_ms: U64
    producers: U32
    consumers: U32
    held: U64
    received: U64
    sent: U64
    lagged: U64


@dataclass(frozen=True)
class StreamMemory:
    """What a stream's memory is used for, in bytes.

    `points` are for points, positions and triangulation, `views` for the views that are followed and their history,
    `queue` for what waits for the engine.
    """

    name: str
    points: U64
    views: U64
    queue: U64
