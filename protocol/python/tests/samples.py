"""Messages of every type, and small frames that fit together.

In: nothing. Out: `MESSAGES`, `snapshot`, `diff`, `header`, `checksum`, `track`, `tracks`, `event`, and those of a
space. Invariant: `checksum` is a literal copy of the specification's function, not the function under test.
"""

from __future__ import annotations

import math
import struct
from typing import Any

from hopes_client import messages as m
from hopes_client import spaces as s
from hopes_client.admin import Peer, StreamMemory
from hopes_client.shared import Cause, Cut, DotsWanted, FrameHeader, Policy, Simplify, View, Window
from hopes_client.tracks import Happening, Track, TrackChanges, TrackCycle, TrackEvent, TracksWanted

FULL = View(Cut.full(), Simplify.no())
SIMPLE = View(Cut.derived(1, 1), Simplify.at_scale())

SQUARE = [(0, 0.0, 0.0), (1, 2.0, 0.0), (2, 2.0, 2.0), (3, 0.0, 2.0)]
SQUARE_EDGES = [(0, 1), (0, 3), (1, 2)]
SQUARE_CRITICAL = [(2, 3, 1.0, math.sqrt(2))]
DOT = m.Dot((2, 3), 1.0, math.sqrt(2), (1.0, 1.0), math.sqrt(2))


def bits(value: float) -> int:
    return int(struct.unpack("<Q", struct.pack("<d", value))[0])


def h(*words: int) -> int:
    hash = 0
    for word in words:
        z = ((hash ^ word) + 0x9E3779B97F4A7C15) % 2**64
        z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 % 2**64
        z = (z ^ z >> 27) * 0x94D049BB133111EB % 2**64
        hash = z ^ z >> 31
    return hash


def checksum(
    vertices: list[tuple[int, float, float]],
    edges: list[tuple[int, int]],
    critical: list[tuple[int, int, float, float]],
) -> int:
    return (
        sum(h(1, id, bits(x), bits(y)) for id, x, y in vertices)
        + sum(h(2, a, b) for a, b in edges)
        + sum(h(3, a, b, bits(birth), bits(death)) for a, b, birth, death in critical)
    ) % 2**64


def header(number: int, view: View = FULL) -> FrameHeader:
    return FrameHeader(number, number / 2, 4, 4, 0, view, None, None, 1, 1)


def snapshot(number: int = 1, stream: int = 9, cause: str = "Start", view: View = FULL) -> m.Snapshot:
    """The corners of a square."""
    total = checksum(SQUARE, SQUARE_EDGES, SQUARE_CRITICAL)
    return m.Snapshot(stream, Cause(cause), header(number, view), SQUARE, SQUARE_EDGES, SQUARE_CRITICAL, total)


def diff(number: int = 2, stream: int = 9, view: View = FULL) -> m.Diff:
    """From `snapshot(number - 1)`: removes corner 1, adds corner 4, moves corner 2, changes the critical edge's
    label.
    """
    vertices = [(0, 0.0, 0.0), (2, 2.5, 2.0), (3, 0.0, 2.0), (4, 3.0, 0.0)]
    edges = [(0, 3), (0, 4), (2, 4)]
    critical = [(2, 3, 1.25, 1.5)]
    return m.Diff(
        stream=stream,
        from_=number - 1,
        frame=header(number, view),
        vertices_added=[(2, 2.5, 2.0), (4, 3.0, 0.0)],
        vertices_removed=[1, 2],
        edges_added=[(0, 4), (2, 4)],
        edges_removed=[(0, 1), (1, 2)],
        critical_set=[(2, 3, 1.25, 1.5)],
        critical_removed=[],
        checksum=checksum(vertices, edges, critical),
    )


def dots(frame: int, stream: int = 9) -> m.Dots:
    return m.Dots(stream, frame, 1, [DOT])


def opened(stream: int = 9, name: str = "lidar", epoch: int = 77, frame: int = 0) -> m.StreamOpened:
    return m.StreamOpened(stream, name, epoch, Window.all(), None, frame)


def track(id: int, selected: bool = True, age: int = 1) -> Track:
    return Track(id, age, 1.0, math.sqrt(2), (1.0, 1.0), math.sqrt(2), 4.0, (0.0, -0.5), selected)


def event(frame: int, id: int, case: str, *values: Any, selected: bool = True) -> TrackEvent:
    return TrackEvent(frame, None, Happening(case, values), track(id, selected))


def tracks(
    from_: int,
    frame: int,
    events: tuple[TrackEvent, ...] = (),
    alive: list[Track] | None = None,
    cycles: dict[int, list[list[int]]] | None = None,
    stream: int = 9,
) -> m.Tracks:
    listed = [TrackCycle(id, walks) for id, walks in (cycles or {}).items()]
    return m.Tracks(stream, from_, frame, frame / 2, list(events), alive, listed)


#: The metric of the streams in R^3.
EUCLIDEAN = s.Metric("Euclidean")
CUBE = [(0, 0.0, 0.0, 1.0), (1, 2.0, 0.0, 1.0), (2, 2.0, 2.0, 1.0), (3, 0.0, 2.0, -1.0)]


def space_checksum(
    vertices: list[tuple[Any, ...]], edges: list[tuple[int, int]], critical: list[tuple[int, int, float, float]]
) -> int:
    positions = sum(h(1, id, *map(bits, position)) for id, *position in vertices)
    return (positions + checksum([], edges, critical)) % 2**64


def flat(vertices: list[tuple[Any, ...]]) -> list[float]:
    return [number for _, *position in vertices for number in position]


def space_snapshot(number: int = 1, stream: int = 9, cause: str = "Start") -> s.SpaceSnapshot:
    """Four points of R^3. The critical edge never dies."""
    critical = [(2, 3, 1.0, math.inf)]
    total = space_checksum(CUBE, SQUARE_EDGES, critical)
    ids = [row[0] for row in CUBE]
    return s.SpaceSnapshot(
        stream, Cause(cause), header(number), EUCLIDEAN, 3, ids, flat(CUBE), SQUARE_EDGES, critical, total
    )


def space_diff(number: int = 2, stream: int = 9) -> s.SpaceDiff:
    """From `space_snapshot(number - 1)`: as `diff`, and the cycle is filled."""
    added: list[tuple[Any, ...]] = [(2, 2.5, 2.0, 0.5), (4, 3.0, 0.0, -0.0)]
    vertices = [CUBE[0], added[0], CUBE[3], added[1]]
    edges, critical = [(0, 3), (0, 4), (2, 4)], [(2, 3, 1.25, 1.5)]
    return s.SpaceDiff(
        stream=stream,
        from_=number - 1,
        frame=header(number),
        dimension=3,
        ids_added=[2, 4],
        coordinates_added=flat(added),
        vertices_removed=[1, 2],
        edges_added=[(0, 4), (2, 4)],
        edges_removed=[(0, 1), (1, 2)],
        critical_set=critical,
        critical_removed=[],
        checksum=space_checksum(vertices, edges, critical),
    )


def space_dots(frame: int, stream: int = 9) -> s.SpaceDots:
    endless = s.SpaceDot((2, 3), 1.0, None, None)
    return s.SpaceDots(stream, frame, 2, [endless, s.SpaceDot((0, 1), 1.0, 1.5, (1, 3))])


def space_track(id: int) -> s.SpaceTrack:
    return s.SpaceTrack(id, 1, 1.0, None, [1.0, 1.0, 0.5], 1.5, [0.0, -0.5, 0.0], True)


def space_tracks(
    from_: int,
    frame: int,
    events: tuple[s.SpaceTrackEvent, ...] = (),
    alive: list[s.SpaceTrack] | None = None,
    cycles: dict[int, list[list[int]]] | None = None,
    stream: int = 9,
) -> s.SpaceTracks:
    listed = [TrackCycle(id, walks) for id, walks in (cycles or {}).items()]
    return s.SpaceTracks(stream, from_, frame, frame / 2, list(events), alive, listed)


INFO = m.StreamInfo(9, "lidär", 77, Window.time(2.5), 0.125, 300, 70_000, 5_000_000_000, 2, 1)
BIG = 2**64 - 1
PEER = Peer(3, "tcp:127.0.0.1:7878", "sensör 1", 86_400_000, 250, 2, 70_000, 1 << 20, 251, BIG, 5)
MEMORY = m.Memory(1 << 30, 1 << 20, 251, [StreamMemory("lidär", 65_536, 250, BIG), StreamMemory("", 0, 0, 0)])

MESSAGES: list[m.Message] = [
    m.Hello("test", []),
    m.Hello("test", ["a", "b" * 300]),
    m.Welcome("hopes 1", [], BIG, 1 << 26, 65_536, 1000, 10_000),
    m.Ping(251),
    m.Pong(BIG),
    m.Goodbye("done", [("lidar", 3), ("", 70_000)]),
    m.Error(9, 0x0201, "no such view"),
    m.ListStreams("*"),
    m.Streams([INFO]),
    m.GetStatus(),
    m.Status("hopes 1", 1, 2, 3, 4, 5, 6, [m.StreamStatus(INFO, 1, 2, 3, 4, 5, 6, 7)]),
    m.Open("lidar", Window.frames(1), 0.5),
    m.Open("lidar", None, None),
    m.Opened(9, 77, True, Window.points(1000), None, 0, 4096),
    m.Batch(1, [(0.0, -0.0), (math.inf, 1e300)], [1.0, 2.0], [250, 251]),
    m.Batch(2, [], [], []),
    m.Retract(65_536, [(1.0, 2.0)]),
    m.Commit(3, 1.5),
    m.Commit(4, None),
    m.Close(True),
    m.Closed(12),
    m.Accepted(1, 2, [(250, 0), (251, 70_000)]),
    m.Refused(1, 1, 1, [m.Refusal(1, 1, "not finite")], [(250, 0)]),
    m.Committed(3, 1),
    m.Overloaded(1, 100, 200, Policy("DropNewest")),
    m.Subscribe("li*", SIMPLE, DotsWanted.top(10), None),
    m.Subscribe("lidar", View(Cut.reduced(1.5), Simplify.below(2.0)), DotsWanted.all(), m.Resume(77, 5)),
    m.ChangeView(FULL, DotsWanted.no()),
    m.Unsubscribe(),
    opened(),
    m.StreamClosed(9, 5, "ended"),
    snapshot(),
    diff(),
    dots(2),
    m.Heartbeat(9, 2),
    m.Lagged(9, 2, 300),
    m.Resumed(9, 2),
    m.Unsubscribed(),
    m.WantTracks(TracksWanted.of("cycles")),
    m.WantTracks(TracksWanted.of(None)),
    tracks(0, 2, alive=[track(1), track(251, selected=False)], cycles={1: [[0, 1, 70_000], [7]], 251: [], 252: [[]]}),
    tracks(
        2,
        70_000,
        (
            event(3, 2, "Born"),
            event(4, 3, "Split", 2),
            event(5, 1, "Updated", TrackChanges(True, False, True)),
            event(5, 2, "Unselected", selected=False),
            event(6, 2, "Reselected"),
            event(70_000, 3, "Merged", 251),
            event(70_000, 251, "Died"),
        ),
    ),
    m.ListPeers(),
    m.Peers([PEER, PEER]),
    m.StopStream("lidär"),
    m.StreamStopped("lidär", 70_000),
    m.Disconnect(3),
    m.Disconnected(BIG),
    m.GetMemory(),
    MEMORY,
    m.Elapsed(1_500_000_000),
    s.ListSpaces(),
    s.Spaces([s.SpaceInfo(9, s.Metric("Angular"), None), s.SpaceInfo(70_000, s.Metric("Euclidean"), 3)]),
    s.OpenSpace("cloud", Window.frames(1), 0.5, s.Metric("Manhattan"), 4096),
    s.OpenSpace("cloud", None, None, None, None),
    s.SpaceOpened(m.Opened(9, 77, True, Window.all(), None, 0, 4096), s.Metric("Chebyshev"), None, 4096),
    s.SpaceBatch(1, 3, [0.0, -0.0, math.inf], [1.0], [250]),
    s.SpaceRetract(2, 1, []),
    space_snapshot(),
    space_diff(),
    space_dots(2),
    space_tracks(0, 2, alive=[space_track(1), space_track(251)], cycles={1: [[0, 1, 70_000]], 251: []}),
    space_tracks(2, 3, (s.SpaceTrackEvent(3, None, Happening("Born"), space_track(2)),)),
]
