"""The types of which `WantTracks` and `Tracks` are made (section 9 of the specification).

In: numbers. Out: `TracksWanted`, `Track`, `TrackChanges`, `Happening`, `TrackEvent`, `TrackCycle`. Invariant: fields
have the order of the wire, and their hints are the only definition of their encoding.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Optional

from .codec import F64, U64, Cases, Choice


class TracksWanted(Choice):
    """What is sent of the tracks."""

    CASES: ClassVar[Cases] = {"No": (), "Events": (), "Alive": (), "Cycles": ()}

    @classmethod
    def of(cls, tracks: Optional[str]) -> TracksWanted:
        """From the words of `Daemon.follow`: "events", "alive", "cycles", or none."""
        cases = {None: "No", "events": "Events", "alive": "Alive", "cycles": "Cycles"}
        if tracks not in cases:
            raise ValueError(f"tracks is 'events', 'alive', 'cycles' or None, not {tracks!r}")
        return cls(cases[tracks])


@dataclass(frozen=True)
class Track:
    """A persistent cycle in its last reported state.

    `age` counts the frames from the first to the last in which it was seen. `center` and `radius` are those of its
    hole. `area` is the hole's area at birth, without islands. `velocity` is the movement of the centre in one frame.
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
    """Which values of a track have changed by more than the daemon's reporting threshold."""

    center: bool
    birth: bool
    death: bool

    def __str__(self) -> str:
        changed = {"center": self.center, "birth": self.birth, "death": self.death}
        return ", ".join(what for what, has in changed.items() if has)


class Happening(Choice):
    """The kind of an event of a track."""

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
        """Whether the track begins with this event."""
        return self.case in ("Born", "Split")

    @property
    def ends(self) -> bool:
        """Whether the track ends with this event."""
        return self.case in ("Merged", "Died")

    @property
    def other(self) -> int | None:
        """The track from which this one split, or into which it merged, if any."""
        return self.values[0] if self.case in ("Split", "Merged") else None


@dataclass(frozen=True)
class TrackEvent:
    """An event of a track. `track` is the state after the event."""

    frame: U64
    time: Optional[F64]
    happening: Happening
    track: Track


@dataclass(frozen=True)
class TrackCycle:
    """Closed walks along vertices around a track's hole: the outer one, then those around islands in the hole."""

    id: U64
    walks: list[list[U64]]
