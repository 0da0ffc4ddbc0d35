"""A frame as a consumer sees it.

In: a mirror right after it took a message. Out: `Frame`.
Invariant: the graph of a frame is that of its own number: it is a view of the mirror, free of cost, and asking for it
after the mirror has gone on raises `StaleFrame`. `Frame.copy` gives one that may be kept.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping
from collections.abc import Set as AbstractSet

from .errors import StaleFrame
from .messages import Diff, Dot
from .mirror import Mirror
from .shared import FrameHeader, View
from .track_mirror import Walks
from .tracks import Track, TrackEvent


class Frame:
    """One frame of a stream.

    `kind` is "snapshot", "diff", or "dots" or "tracks" if nothing else is new since the frame before, which had the
    same number. `tracks` are the living tracks by id, each as it was last told of, `track_cycles` their cycles, as walks
    along vertices, and `track_events` what has happened to tracks since the frame before; all are empty unless they were
    asked for. `diff` is the message that led here (none but with "diff"), `cause` why a snapshot came (none but with
    "snapshot"). `lagged` is the first and the last frame that were not sent singly before this one, if there are such.
    `elapsed` is the time in seconds since the recording began, if this is one.
    """

    def __init__(
        self,
        mirror: Mirror,
        header: FrameHeader,
        kind: str,
        *,
        diff: Diff | None = None,
        cause: str | None = None,
        lagged: tuple[int, int] | None = None,
        track_events: Iterable[TrackEvent] = (),
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
        self.track_events: tuple[TrackEvent, ...] = ()
        self.renew(track_events)

    def renew(self, track_events: Iterable[TrackEvent]) -> None:
        """Takes dots and tracks as the mirror has them now, and these events. For whoever makes frames."""
        self.dots: tuple[Dot, ...] = self._mirror.dots
        self.dots_total = self._mirror.dots_total
        self.tracks: Mapping[int, Track] = self._mirror.tracks.alive
        self.track_cycles: Mapping[int, Walks] = self._mirror.tracks.cycles
        self.track_events += tuple(track_events)

    @property
    def stream(self) -> str:
        """The name of the stream."""
        return self._mirror.name

    @property
    def epoch(self) -> int:
        """The life of the stream: with `number`, what a consumer resumes from."""
        return self._mirror.epoch

    @property
    def number(self) -> int:
        """The number of the commit, from 1."""
        return self.header.number

    @property
    def time(self) -> float | None:
        """The time of the commit, else the newest event time."""
        return self.header.time

    @property
    def points(self) -> int:
        """How many points the window holds."""
        return self.header.points

    @property
    def positions(self) -> int:
        """How many distinct positions these points have (`vertices` of the header)."""
        return self.header.vertices

    @property
    def rejected(self) -> int:
        """How many points were refused since the frame before."""
        return self.header.rejected

    @property
    def view(self) -> View:
        """The view that the graph is in."""
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
        """How many connected components the view has."""
        return self.header.components

    @property
    def cycles(self) -> int:
        """How many independent cycles the view has."""
        return self.header.cycles

    @property
    def vertices(self) -> Mapping[int, tuple[float, float]]:
        """(x, y) of each vertex by its id."""
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
        """This frame with a graph of its own, which stays when the stream goes on."""
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
