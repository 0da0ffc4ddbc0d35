"""A frame of a consumer.

In: a mirror directly after it has applied a message. Out: `Frame`. Invariant: a frame has the graph of its own number.
The graph is a view of the mirror and costs nothing; accessing it after the mirror has changed raises `StaleFrame`.
`Frame.copy` returns a frame that may be kept.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping
from collections.abc import Set as AbstractSet
from typing import Any

from .errors import StaleFrame
from .mirror import Mirror
from .shared import FrameHeader, View
from .spaces import AnyDiff, Metric
from .track_mirror import AnyEvent, Walks


class Frame:
    """One frame of a stream.

    `kind` is "snapshot" or "diff". It is "dots" or "tracks" if only those are new, and the number is that of the
    previous frame.

    `tracks` are the living tracks by id in their last reported state, `track_cycles` their cycles as walks along
    vertices, and `track_events` the events since the previous frame. All are empty unless they were requested. In the
    plane these are made of `Dot`, `Track` and `TrackEvent`, in R^d of `SpaceDot`, `SpaceTrack` and `SpaceTrackEvent`.

    `diff` is the message of this frame (only with "diff"), `cause` the reason of a snapshot (only with "snapshot").
    `lagged` is the first and the last of the frames before this one that were not sent, if there are any. `elapsed` is
    the time in seconds since a recording began.
    """

    def __init__(
        self,
        mirror: Mirror,
        header: FrameHeader,
        kind: str,
        *,
        diff: AnyDiff | None = None,
        cause: str | None = None,
        lagged: tuple[int, int] | None = None,
        track_events: Iterable[AnyEvent] = (),
        elapsed: float | None = None,
    ) -> None:
        self._mirror = mirror
        self._revision = mirror.revision
        self.header = header
        self.kind = kind
        self.diff = diff
        self.cause = cause
        self.lagged = lagged
        self.elapsed = elapsed
        self.track_events: tuple[Any, ...] = ()
        self.renew(track_events)

    def renew(self, track_events: Iterable[AnyEvent]) -> None:
        """Copies dots and tracks from the mirror, and sets these events. For the code that makes frames."""
        self.dots: tuple[Any, ...] = self._mirror.dots
        self.dots_total = self._mirror.dots_total
        self.tracks: Mapping[int, Any] = self._mirror.tracks.alive
        self.track_cycles: Mapping[int, Walks] = self._mirror.tracks.cycles
        self.track_events += tuple(track_events)

    @property
    def stream(self) -> str:
        """The name of the stream."""
        return self._mirror.name

    @property
    def epoch(self) -> int:
        """The epoch of the stream. Together with `number` it is the position at which a consumer resumes."""
        return self._mirror.epoch

    @property
    def number(self) -> int:
        """The number of the commit, from 1."""
        return self.header.number

    @property
    def time(self) -> float | None:
        """The time of the commit. Without one, the newest event time."""
        return self.header.time

    @property
    def points(self) -> int:
        """The number of points in the window."""
        return self.header.points

    @property
    def positions(self) -> int:
        """The number of distinct positions (`vertices` of the header)."""
        return self.header.vertices

    @property
    def rejected(self) -> int:
        """The number of points refused since the previous frame."""
        return self.header.rejected

    @property
    def view(self) -> View:
        """The view of the graph."""
        return self.header.view

    @property
    def ds(self) -> float | None:
        """The scale ds of a derived view, unless it is infinite."""
        return self.header.ds

    @property
    def vs(self) -> float | None:
        """The scale vs of a derived view, unless it is infinite."""
        return self.header.vs

    @property
    def components(self) -> int:
        """The number of connected components of the view."""
        return self.header.components

    @property
    def cycles(self) -> int:
        """The number of independent cycles of the view."""
        return self.header.cycles

    @property
    def metric(self) -> Metric | None:
        """The metric of a stream in R^d. None in the plane, or if a recording starts without a snapshot."""
        return self._mirror.metric

    @property
    def dimension(self) -> int:
        """The number of coordinates of a vertex: 2 in the plane. 0: no point has come yet."""
        return self._mirror.dimension

    @property
    def vertices(self) -> Mapping[int, tuple[float, ...]]:
        """The coordinates of each vertex by its id: (x, y) in the plane."""
        return self._current().vertices

    @property
    def edges(self) -> AbstractSet[tuple[int, int]]:
        """The tree edges; in a simplified view all edges."""
        return self._current().edges

    @property
    def critical(self) -> Mapping[tuple[int, int], tuple[float, float]]:
        """(birth, death) of each critical edge."""
        return self._current().critical

    def copy(self) -> Frame:
        """This frame with its own copy of the graph, which stays valid when the stream goes on."""
        source = self._current()
        kept = copy.copy(source)
        kept.vertices = dict(source.vertices)
        kept.edges = set(source.edges)
        kept.critical = dict(source.critical)
        frame = copy.copy(self)
        frame._mirror = kept
        return frame

    def __repr__(self) -> str:
        what = f"{self.components} components, {self.cycles} cycles"
        return f"<Frame {self.number} of {self.stream!r} ({self.kind}): {what}>"

    def _current(self) -> Mirror:
        if self._mirror.revision != self._revision:
            raise StaleFrame(f"frame {self.number} was replaced by {self._mirror.number}; keep a copy() of it")
        return self._mirror
