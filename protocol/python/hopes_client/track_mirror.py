"""A track mirror: a consumer's copy of the tracks of one stream.

In: `Tracks` or `SpaceTracks` messages of one stream, in the order of arrival. Out: the living tracks by id, and their cycles.
Invariants: a message is applied as a whole, or refused as a whole with `ResyncNeeded`, which changes nothing. Living
tracks are the same whether they come from events alone or from lists in every frame. Returned mappings never change:
each message makes new ones.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Union

from .errors import ResyncNeeded
from .spaces import AnyTracks, SpaceTrack, SpaceTrackEvent
from .tracks import Track, TrackEvent

AnyTrack = Union[Track, SpaceTrack]
AnyEvent = Union[TrackEvent, SpaceTrackEvent]
#: Closed walks along vertices.
Walks = list[list[int]]


class TrackMirror:
    """The tracks of a stream at the frame `number`. 0: no message yet."""

    def __init__(self) -> None:
        self.number = 0
        self.time: float | None = None
        self.alive: Mapping[int, AnyTrack] = {}
        self.cycles: Mapping[int, Walks] = {}

    def apply(self, message: AnyTracks) -> None:
        """Applies a message."""
        number, starts = message.frame, message.from_ == 0
        if number <= message.from_ or not (starts or message.from_ == self.number):
            raise ResyncNeeded(f"tracks from frame {message.from_} to {number} do not follow frame {self.number}")
        _check_order(message)
        _check_coordinates(message, {} if starts else self.alive)
        if starts:
            if message.alive is None or message.events:
                raise ResyncNeeded(f"the tracks of frame {number} start anew, but are not a list of living tracks")
            alive: dict[int, AnyTrack] = {track.id: track for track in message.alive}
        else:
            alive = _after(self.alive, message.events)
            if message.alive is not None:
                alive = _compared(alive, message.alive, number)
        changed = {cycle.id: cycle.walks for cycle in message.cycles}
        if not changed.keys() <= alive.keys():
            raise ResyncNeeded(f"frame {number} has cycles of tracks that are not alive")
        ended = {event.track.id for event in message.events if event.happening.ends}
        kept = {} if starts else {id: walks for id, walks in self.cycles.items() if id not in ended}
        self.number, self.time, self.alive, self.cycles = number, message.time, alive, {**kept, **changed}


def _after(alive: Mapping[int, AnyTrack], events: Iterable[AnyEvent]) -> dict[int, AnyTrack]:
    """The tracks that are alive after these events."""
    after = dict(alive)
    for event in events:
        happening, id = event.happening, event.track.id
        if happening.begins == (id in after):
            what = "begins, but is alive already" if happening.begins else "is told of, but is not alive"
            raise ResyncNeeded(f"in frame {event.frame} track {id} {what}")
        if happening.ends:
            del after[id]
        # The other track goes on, so it must be alive after this event. It also cannot be the track itself.
        if happening.other is not None and happening.other not in after:
            raise ResyncNeeded(f"in frame {event.frame} track {happening.other} is named, but is not alive")
        if not happening.ends:
            after[id] = event.track
    return after


def _compared(alive: Mapping[int, AnyTrack], listed: Iterable[AnyTrack], number: int) -> dict[int, AnyTrack]:
    """The listed tracks. They must be the tracks that are alive, with the same selection."""
    found = {track.id: track for track in listed}
    known = {id: track.selected for id, track in alive.items()}
    if known != {id: track.selected for id, track in found.items()}:
        raise ResyncNeeded(f"the living tracks of frame {number} are not those that events lead to")
    return found


def _check_order(message: AnyTracks) -> None:
    """Raises unless events are sorted and of the right frames, and lists are sorted without duplicates."""
    places = [(event.frame, event.track.id) for event in message.events]
    inside = all(message.from_ < frame <= message.frame for frame, _ in places)
    lists = [[track.id for track in message.alive or []], [cycle.id for cycle in message.cycles]]
    if not inside or places != sorted(places) or any(ids != sorted(set(ids)) for ids in lists):
        raise ResyncNeeded(f"the tracks of frame {message.frame} are told of out of order")


def _check_coordinates(message: AnyTracks, alive: Mapping[int, AnyTrack]) -> None:
    """Raises unless all centres and velocities have the same number of coordinates, that of living tracks."""
    tracks = [*(event.track for event in message.events), *(message.alive or []), *list(alive.values())[:1]]
    widths = {len(values) for track in tracks for values in (track.center, track.velocity)}
    if len(widths) > 1:
        raise ResyncNeeded(f"the tracks of frame {message.frame} are of {sorted(widths)} dimensions")
