"""A mirror: a consumer's verified copy of one stream. It applies snapshots and diffs.

In: `Snapshot`, `Diff` and `Dots` messages of one stream, or those of a space, in the order of arrival. Out: vertices, edges and critical
edges of the newest frame, verified by the checksum. Invariants: a message is applied as a whole, or refused as a whole
with `ResyncNeeded`, which changes nothing. After each applied message `checksum` is that of the content. `revision`
grows with each message that changes the graph. Tracks are in `tracks`; they have their own frame numbers and errors.
Simplified views work in the same way: their vertices are those of the simplified graph, and no edge is critical.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

from . import checksum as hashes
from .errors import ResyncNeeded
from .messages import Dot
from .shared import FrameHeader, View
from .spaces import AnyDiff, AnyDots, AnySnapshot, Metric, SpaceDiff, SpaceDot, SpaceSnapshot
from .track_mirror import TrackMirror

Key = TypeVar("Key")


class Mirror:
    """The newest frame of the stream `name` in the epoch `epoch`."""

    def __init__(self, name: str = "", epoch: int = 0) -> None:
        self.name = name
        self.epoch = epoch
        self.header: FrameHeader | None = None
        #: The metric of a stream in R^d, once a snapshot has named it. None in the plane.
        self.metric: Metric | None = None
        #: The number of coordinates of a vertex. 0: not known yet.
        self.dimension = 0
        self.vertices: dict[int, tuple[float, ...]] = {}
        self.edges: set[tuple[int, int]] = set()
        self.critical: dict[tuple[int, int], tuple[float, float]] = {}
        self.checksum = 0
        self.revision = 0
        self.dots: tuple[Dot | SpaceDot, ...] = ()
        self.dots_total = 0
        self.tracks = TrackMirror()

    @property
    def number(self) -> int:
        """The number of the frame. 0: none yet."""
        return self.header.number if self.header else 0

    @property
    def view(self) -> View | None:
        """The view of the frame."""
        return self.header.view if self.header else None

    def apply_snapshot(self, snapshot: AnySnapshot) -> None:
        """Replaces the content."""
        rows = snapshot.vertices
        vertices = {row[0]: row[1:] for row in rows}
        edges = set(snapshot.edges)
        critical = {(a, b): (birth, death) for a, b, birth, death in snapshot.critical}
        held = len(vertices) + len(edges) + len(critical)
        if held != len(rows) + len(snapshot.edges) + len(snapshot.critical):
            raise ResyncNeeded("the snapshot holds something twice")
        total = hashes.of_vertices(rows)
        total += hashes.of_edges(snapshot.edges) + hashes.of_critical(snapshot.critical)
        self._prove(total, snapshot.checksum, snapshot.frame)
        self.vertices, self.edges, self.critical = vertices, edges, critical
        self.metric = snapshot.metric if isinstance(snapshot, SpaceSnapshot) else None
        self.dimension = snapshot.dimension if isinstance(snapshot, SpaceSnapshot) else 2
        if snapshot.cause.case in ("Start", "CannotResume"):
            # The daemon sends the dots again after a snapshot, if there are any.
            self.dots, self.dots_total = (), 0

    def apply_diff(self, diff: AnyDiff) -> None:
        """Applies a diff to the frame that the mirror holds."""
        dimension = self._check_start(diff)
        rows = diff.vertices_added
        total = self.checksum
        total += self._vertices_change(diff, rows) + self._edges_change(diff) + self._critical_change(diff)
        self._prove(total, diff.checksum, diff.frame)
        for id in diff.vertices_removed:
            del self.vertices[id]
        self.vertices.update({row[0]: row[1:] for row in rows})
        self.dimension = dimension
        self.edges.difference_update(diff.edges_removed)
        self.edges.update(diff.edges_added)
        for edge in diff.critical_removed:
            del self.critical[edge]
        self.critical.update({(a, b): (birth, death) for a, b, birth, death in diff.critical_set})

    def apply_dots(self, dots: AnyDots) -> None:
        """Replaces the dots."""
        self.dots, self.dots_total = tuple(dots.dots), dots.total

    def verify(self) -> None:
        """Computes the checksum from the content. `ResyncNeeded` if the content was changed from outside."""
        total = hashes.of_vertices((id, *position) for id, position in self.vertices.items())
        total += hashes.of_edges(self.edges)
        total += hashes.of_critical((a, b, birth, death) for (a, b), (birth, death) in self.critical.items())
        if total & hashes.MASK != self.checksum:
            raise ResyncNeeded("what is held was changed from outside")

    def _prove(self, total: int, checksum: int, header: FrameHeader) -> None:
        """Sets the new frame's header if the checksum is right. All checks come before, all changes after this."""
        if total & hashes.MASK != checksum:
            raise ResyncNeeded(f"the checksum of frame {header.number} is wrong")
        self.checksum = checksum
        self.header = header
        self.revision += 1

    def _check_start(self, diff: AnyDiff) -> int:
        """The dimension after the diff. Raises if the diff does not follow, or lies in another space."""
        if diff.from_ != self.number or diff.frame.number <= self.number:
            raise ResyncNeeded(
                f"a diff from frame {diff.from_} to {diff.frame.number} does not follow frame {self.number}"
            )
        if self.header and diff.frame.view != self.header.view:
            raise ResyncNeeded("a diff of another view does not follow")
        dimension = diff.dimension if isinstance(diff, SpaceDiff) else 2
        if self.dimension not in (0, dimension):
            raise ResyncNeeded(f"a diff in {dimension} dimensions does not follow a frame in {self.dimension}")
        return dimension

    def _vertices_change(self, diff: AnyDiff, rows: list[hashes.VertexRow]) -> int:
        """The change of the checksum by the diff's vertices. Raises if they do not fit."""
        removed = _distinct(diff.vertices_removed)
        added = _distinct(row[0] for row in rows)
        _check(removed <= self.vertices.keys(), not (added & self.vertices.keys()) - removed, "vertex")
        gone = hashes.of_vertices((id, *self.vertices[id]) for id in removed)
        return hashes.of_vertices(rows) - gone

    def _edges_change(self, diff: AnyDiff) -> int:
        """The change of the checksum by the diff's edges. Raises if they do not fit."""
        removed = _distinct(diff.edges_removed)
        added = _distinct(diff.edges_added)
        _check(removed <= self.edges, not (added & self.edges) - removed, "edge")
        return hashes.of_edges(added) - hashes.of_edges(removed)

    def _critical_change(self, diff: AnyDiff) -> int:
        """The change of the checksum by the diff's critical edges. Raises if they do not fit."""
        removed = _distinct(diff.critical_removed)
        changed = _distinct((a, b) for a, b, _, _ in diff.critical_set)
        _check(removed <= self.critical.keys(), True, "critical edge")
        gone = hashes.of_critical((*edge, *self.critical[edge]) for edge in removed | (changed & self.critical.keys()))
        return hashes.of_critical(diff.critical_set) - gone


def _distinct(items: Iterable[Key]) -> set[Key]:
    """The items as a set. Raises if there is a duplicate."""
    listed = list(items)
    distinct = set(listed)
    if len(distinct) != len(listed):
        raise ResyncNeeded("the diff names something twice")
    return distinct


def _check(removed_held: bool, added_new: bool, what: str) -> None:
    if not removed_held:
        raise ResyncNeeded(f"the diff removes a {what} that is not held")
    if not added_new:
        raise ResyncNeeded(f"the diff adds a {what} that is held already")
