"""The types that several messages share (section 4 of the specification).

In: numbers. Out: `Window`, `Cut`, `Simplify`, `View`, `DotsWanted`, `Cause`, `Policy`, the tuples `Vertex`, `Edge` and
`Critical`, and `FrameHeader`. Invariant: every value is valid in the protocol. The constructors raise `ValueError` for
invalid ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Optional, Union

from .codec import F64, U32, U64, Cases, Choice

#: (id, x, y)
Vertex = tuple[U64, F64, F64]
#: (a, b): the ids of its ends, a < b
Edge = tuple[U64, U64]
#: (a, b, birth, death)
Critical = tuple[U64, U64, F64, F64]


class Window(Choice):
    """Which points of a stream are kept."""

    CASES: ClassVar[Cases] = {"All": (), "Points": (U64,), "Frames": (U64,), "Time": (F64,)}

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.values and not self.values[0] > 0:
            raise ValueError("the size of a window is above 0")

    @classmethod
    def all(cls) -> Window:
        """All points."""
        return cls("All")

    @classmethod
    def points(cls, count: int) -> Window:
        """The newest points, at most `count`."""
        return cls("Points", (count,))

    @classmethod
    def frames(cls, count: int) -> Window:
        """The points of the last `count` frames."""
        return cls("Frames", (count,))

    @classmethod
    def time(cls, span: float) -> Window:
        """The points of the last `span` of event time."""
        return cls("Time", (float(span),))


class Cut(Choice):
    """A part of the skeleton."""

    CASES: ClassVar[Cases] = {"Full": (), "Reduced": (F64,), "Derived": (U32, U32)}

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.case == "Derived" and min(self.values) < 1:
            raise ValueError("k and l begin at 1")

    @classmethod
    def full(cls) -> Cut:
        """HoPeS(C)."""
        return cls("Full")

    @classmethod
    def reduced(cls, alpha: float) -> Cut:
        """HoPeS(C; alpha)."""
        return cls("Reduced", (float(alpha),))

    @classmethod
    def derived(cls, k: int, l: int) -> Cut:
        """HoPeS_{k,l}(C)."""
        return cls("Derived", (k, l))


class Simplify(Choice):
    """Whether the skeleton is simplified, and at which scale."""

    CASES: ClassVar[Cases] = {"No": (), "AtScale": (), "Below": (F64,)}

    @classmethod
    def no(cls) -> Simplify:
        """Not simplified."""
        return cls("No")

    @classmethod
    def at_scale(cls) -> Simplify:
        """At the cut's own scale (alpha, or vs). Not for the full skeleton."""
        return cls("AtScale")

    @classmethod
    def below(cls, threshold: float) -> Simplify:
        """At this scale."""
        return cls("Below", (float(threshold),))


@dataclass(frozen=True)
class View:
    """What a consumer sees of a stream's skeleton."""

    cut: Cut
    simplify: Simplify

    def __post_init__(self) -> None:
        if self.cut.case == "Full" and self.simplify.case == "AtScale":
            raise ValueError("the full skeleton has no scale of its own to simplify at: give a threshold")

    @classmethod
    def of(
        cls,
        full: bool = False,
        alpha: Optional[float] = None,
        k: Optional[int] = None,
        l: Optional[int] = None,
        simplify: Union[bool, float] = False,
    ) -> View:
        """The view from the words of `Daemon.follow`: one of `full` (the default), `alpha`, or `k` and `l`.

        `simplify` is true for the cut's own scale, or a threshold. If only one of `k` and `l` is given, the other is 1.
        """
        derived = k is not None or l is not None
        if full + (alpha is not None) + derived > 1:
            raise ValueError("only one of full, alpha, and k with l can be asked for")
        cut = Cut.full()
        if alpha is not None:
            cut = Cut.reduced(alpha)
        elif derived:
            cut = Cut.derived(1 if k is None else k, 1 if l is None else l)
        if isinstance(simplify, bool):
            return cls(cut, Simplify.at_scale() if simplify else Simplify.no())
        return cls(cut, Simplify.below(simplify))


class DotsWanted(Choice):
    """How many dots of the persistence diagram are sent."""

    CASES: ClassVar[Cases] = {"No": (), "Top": (U32,), "All": ()}

    @classmethod
    def no(cls) -> DotsWanted:
        """None."""
        return cls("No")

    @classmethod
    def top(cls, count: int) -> DotsWanted:
        """The `count` most persistent dots."""
        return cls("Top", (count,))

    @classmethod
    def all(cls) -> DotsWanted:
        """All dots."""
        return cls("All")


class Cause(Choice):
    """Why a snapshot is sent."""

    CASES: ClassVar[Cases] = {"Start": (), "ViewChanged": (), "Lagged": (), "CannotResume": ()}


class Policy(Choice):
    """Which message a daemon drops if the engine does not keep up."""

    CASES: ClassVar[Cases] = {"DropOldest": (), "DropNewest": ()}


@dataclass(frozen=True)
class FrameHeader:
    """The data of a frame besides its graph (`Frame` in the specification)."""

    number: U64
    time: Optional[F64]
    points: U64
    vertices: U64
    rejected: U64
    view: View
    ds: Optional[F64]
    vs: Optional[F64]
    components: U64
    cycles: U64
