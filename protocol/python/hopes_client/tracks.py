"""What is told of tracks (section 9 of the specification): the types of which `WantTracks` and `Tracks` are made.

In: numbers. Out: `TracksWanted`, `Track`, `TrackChanges`, `Happening`, `TrackEvent`, `TrackCycle`.
Invariant: fields are declared in the order of the wire, and their hints are the only description of how they are written.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Optional

from .codec import F64, U64, Cases, Choice


class TracksWanted(Choice):
    """How much of the tracks is asked for."""

    CASES: ClassVar[Cases] = {"No": (), "Events": (), "Alive": (), "Cycles": ()}

    @classmethod
    def of(cls, tracks: Optional[str]) -> TracksWanted:
        """In the words of `Daemon.follow`: "events", "alive", "cycles", or none."""
        cases = {None: "No", "events": "Events", "alive": "Alive", "cycles": "Cycles"}
        if tracks not in cases:
            raise ValueError(f"tracks is 'events', 'alive', 'cycles' or None, not {tracks!r}")
        return cls(cases[tracks])


@dataclass(frozen=True)
class Track:
    """A persistent cycle that is followed, as it was last told of.

    `age` counts frames since it was first seen, both ends among them. `center` and `radius` are those of its hole,
    which has the `area` at birth, islands left out; `velocity` is that of the centre, a frame.
    """

    id: U64
    age: U64
    birth: F64
    death: F64
    center: tuple[F64, F64]
    radius: F64
    area: F64
    velocity: tuple[F64, F64]
    selected: bool

    @property
    def persistence(self) -> float:
        """Death minus birth."""
        return self.death - self.birth


@dataclass(frozen=True)
class TrackChanges:
    """What of a track has changed by more than the daemon was asked to tell."""

    center: bool
    birth: bool
    death: bool

    def __str__(self) -> str:
        changed = {"center": self.center, "birth": self.birth, "death": self.death}
        return ", ".join(what for what, has in changed.items() if has)


class Happening(Choice):
    """What has happened to a track."""

    CASES: ClassVar[Cases] = {
        "Born": (),
        "Split": (U64,),
        "Updated": (TrackChanges,),
        "Unselected": (),
        "Reselected": (),
        "Merged": (U64,),
        "Died": (),
    }

    @property
    def begins(self) -> bool:
        """Whether the track begins with it."""
        return self.case in ("Born", "Split")

    @property
    def ends(self) -> bool:
        """Whether the track ends with it."""
        return self.case in ("Merged", "Died")

    @property
    def other(self) -> int | None:
        """The track that this one was split from or merged into, if it was."""
        return self.values[0] if self.case in ("Split", "Merged") else None


@dataclass(frozen=True)
class TrackEvent:
    """Something that has happened to a track, in a frame; `track` is as it was then."""

    frame: U64
    time: Optional[F64]
    happening: Happening
    track: Track


@dataclass(frozen=True)
class TrackCycle:
    """Closed walks along vertices around a track's hole: the outer one, then those around islands in it."""

    id: U64
    walks: list[list[U64]]
