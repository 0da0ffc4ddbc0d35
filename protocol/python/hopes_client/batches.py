"""What a producer sends: its opening and its batches, for a stream of the plane or in R^d.

In: points, times and tags as the user gives them. Out: `Open`, `Batch` and `Retract`, or their forms for spaces.
Invariants: a batch has whole points. All points that a producer sends to a space have as many coordinates as the
stream's, or `ValueError` says how many: nothing is sent then.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Union

from .codec import Packed
from .messages import Batch, Message, Open, Opened, Retract
from .points import Points, pack_points, pack_points_of
from .shared import Window
from .spaces import Metric, OpenSpace, SpaceBatch, SpaceOpened, SpaceRetract

AnyBatch = Union[Batch, SpaceBatch]
AnyRetract = Union[Retract, SpaceRetract]

# The size of a coordinate, and the largest size of a time with a tag, in bytes.
_COORDINATE = 8
_TIME_AND_TAG = 8 + 9


class PlaneBatches:
    """Messages for a stream of the plane."""

    dimension = 2
    expected: type[Message] = Opened

    def question(self, name: str, window: Window | None, resolution: float | None) -> Message:
        """The message that opens the stream."""
        return Open(name, window, resolution)

    def opened(self, answer: Opened) -> Opened:
        """What the answer says about the stream."""
        return answer

    def pack(self, points: Points) -> Packed:
        """Points, encoded. An element is a point."""
        return pack_points(points)

    def batch(self, sequence: int, points: Packed, times: Packed, tags: list[int]) -> AnyBatch:
        """The message that adds points."""
        return Batch(sequence, points, times, tags)

    def retraction(self, sequence: int, points: Packed) -> AnyRetract:
        """The message that retracts points."""
        return Retract(sequence, points)


@dataclass
class SpaceBatches:
    """Messages for a stream in R^d. The first points fix `dimension` if nothing else has."""

    metric: Metric | None
    dimension: int | None
    max_vertices: int = 0

    expected = SpaceOpened

    def question(self, name: str, window: Window | None, resolution: float | None) -> Message:
        """The message that opens the stream."""
        return OpenSpace(name, window, resolution, self.metric, self.dimension)

    def opened(self, answer: SpaceOpened) -> Opened:
        """What the answer says about the stream. Its space is kept."""
        self.metric, self.dimension, self.max_vertices = answer.metric, answer.dimension, answer.max_vertices
        return answer.opened

    def pack(self, points: Points) -> Packed:
        """Points, encoded. An element is a point."""
        packed = pack_points_of(points)
        if packed.count and self.dimension not in (None, _width(packed)):
            raise ValueError(f"the points have {_width(packed)} coordinates, those of the stream {self.dimension}")
        return packed

    def batch(self, sequence: int, points: Packed, times: Packed, tags: list[int]) -> AnyBatch:
        """The message that adds points."""
        self.dimension = _width(points)
        return SpaceBatch(sequence, self.dimension, _flat(points), times, tags)

    def retraction(self, sequence: int, points: Packed) -> AnyRetract:
        """The message that retracts points."""
        return SpaceRetract(sequence, _width(points), _flat(points))


def _width(points: Packed) -> int:
    """The number of coordinates of each of at least one point."""
    return len(points.data) // (_COORDINATE * points.count)


def _flat(points: Packed) -> Packed:
    """The same with coordinates as elements."""
    return Packed(len(points.data) // _COORDINATE, points.data)


def most_points(packed: Packed, room: int) -> int:
    """How many of the points, with times and tags, fit into so many bytes. At least one."""
    return max(1, room // (_width(packed) * _COORDINATE + _TIME_AND_TAG)) if packed.count else 1


def batches_for(metric: str | Metric | None, dimension: int | None) -> PlaneBatches | SpaceBatches:
    """For a space if anything of it is given, else for the plane."""
    if metric is None and dimension is None:
        return PlaneBatches()
    return SpaceBatches(None if metric is None else Metric.of(metric), dimension)
