"""How well tracks follow the true holes of a scene.

In: the truth of a scene (as `hopes scene --truth` writes it), the frames of `hopes serve --track RULE --track-list`,
both as lines. Out: counts that add up over runs: of the CLEAR MOT and identity measures (by motmetrics), of splits and
mergers; the same for a rival that follows the dots of the persistence diagram alone.

A reported hole may be a true one if its centre is off by at most `NEAR` of the true radius; centres are compared by
where the largest empty discs of the true hole lie (its orbit, its ridge). Nothing here runs a program or opens a file.

A selection that holds more dots than there are holes follows noise too. So whatever it is, a track counts in a frame
if its dot there is a hole by the measure of the truth (persistence P or more). This hides no jump of an identity: the
hole's dot is such a dot, whatever track it is given to, so another id on it is a switch; and an id that went to a
noise dot is missing from its hole. A hole whose dot falls below P by noise is missed in that frame, by any selection.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, fields, replace
from typing import Any

import motmetrics
import numpy as np
from scipy.optimize import linear_sum_assignment

NEAR = 0.5  # a pair of a true and a reported hole farther apart than this part of the true radius is no pair
IN_TIME = 3  # frames that a report of a split or merger may be off
LATE = 30  # frames after which a report is no longer about that split or merger
IN_PLACE = 1.0  # how far off its centre may be, in radii of a hole that took part

KINDS = ("split", "merged")
OTHER = {"split": "from", "merged": "into"}


# What is true


@dataclass(frozen=True)
class Hole:
    x: float
    y: float
    radius: float
    orbit: float
    ridge: tuple[float, float] = (0.0, 0.0)  # half of a segment around the centre

    def distance(self, x: float, y: float) -> float:
        """The distance of a reported centre, in radii."""
        (along, across), (dx, dy) = self.ridge, (x - self.x, y - self.y)
        squared = along * along + across * across
        at = max(-1.0, min(1.0, (dx * along + dy * across) / squared)) if squared else 0.0
        return abs(math.hypot(dx - at * along, dy - at * across) - self.orbit) / self.radius


@dataclass(frozen=True)
class Happening:
    """A split or merger, true or reported."""

    kind: str
    frame: int
    id: int
    other: int
    x: float = math.nan
    y: float = math.nan


@dataclass
class Truth:
    header: dict[str, Any]
    holes: dict[int, dict[int, Hole]] = field(default_factory=dict)  # by frame, by id
    happenings: list[Happening] = field(default_factory=list)
    was: dict[int, int] = field(default_factory=dict)  # ids before, of holes that were fainter than P for a time

    @property
    def above(self) -> float:
        return self.header["above"]

    @property
    def most(self) -> int:
        """The largest number of holes of a frame."""
        return max((len(holes) for holes in self.holes.values()), default=0)


def read_truth(lines: Iterable[str]) -> Truth:
    values = (json.loads(line) for line in lines if line.strip())
    truth = Truth(next(values))
    for value in values:
        frame = value["frame"]
        truth.holes[frame] = {
            hole["id"]: Hole(hole["x"], hole["y"], hole["radius"], hole["orbit"], tuple(hole.get("ridge", (0.0, 0.0))))
            for hole in value["holes"]
        }
        truth.happenings += happenings(frame, value["events"])
        truth.was |= {event["id"]: event["was"] for event in value["events"] if "was" in event}
    return truth


def happenings(frame: int, events: Iterable[dict[str, Any]]) -> Iterator[Happening]:
    for event in events:
        if (kind := event["event"]) in KINDS:
            x, y = event.get("center") or (None, None)
            yield Happening(kind, frame, event["id"], event[OTHER[kind]], number(x), number(y))


# What was reported


@dataclass(frozen=True)
class Dot:
    id: int
    x: float
    y: float
    birth: float
    death: float

    @property
    def persistence(self) -> float:
        return self.death - self.birth


@dataclass
class Tracks:
    alive: dict[int, list[Dot]] = field(default_factory=dict)  # by frame
    happenings: list[Happening] = field(default_factory=list)

    def is_hole(self, id: int, frame: int, above: float) -> bool:
        """Whether a track has a dot of this persistence within three frames."""
        near = (self.alive.get(each, []) for each in range(frame - IN_TIME, frame + IN_TIME + 1))
        return any(dot.id == id and dot.persistence >= above for dots in near for dot in dots)


def read_tracks(lines: Iterable[str]) -> Tracks:
    tracks = Tracks()
    for line in lines:
        frame, alive = member(line, "frame"), member(line, "alive")
        tracks.alive[frame] = [Dot(id, number(x), number(y), number(b), number(d)) for id, x, y, _, b, d in alive]
        tracks.happenings += happenings(frame, member(line, "tracks"))
    return tracks


DECODER = json.JSONDecoder()


def member(line: str, key: str) -> Any:
    """The member of an object on one line whose key comes first there.

    The rest of the line, all points of a frame, would take longer to parse than the frame took to compute. That no
    name or text on the line has a quoted key in it is known of lines of the stream `default`.
    """
    at = line.find(f'"{key}":')
    if at < 0:
        raise ValueError(f'a frame without "{key}": it must come from hopes serve --track above:P --track-list')
    at += len(key) + 3
    while line[at] == " ":
        at += 1
    return DECODER.raw_decode(line, at)[0]


def number(value: float | None) -> float:
    return math.nan if value is None else value


# Identity


@dataclass
class Identity:
    """Counts of the MOT measures. Those of several runs are added."""

    frames: int = 0
    objects: int = 0
    switches: int = 0
    misses: int = 0
    false: int = 0
    idtp: int = 0
    idfp: int = 0
    idfn: int = 0

    def __add__(self, other: Identity) -> Identity:
        return Identity(*(getattr(self, each.name) + getattr(other, each.name) for each in fields(self)))

    @property
    def idf1(self) -> float:
        return ratio(2 * self.idtp, 2 * self.idtp + self.idfp + self.idfn)

    @property
    def mota(self) -> float:
        return 1 - (self.misses + self.false + self.switches) / max(self.objects, 1)

    @property
    def switches_per_1000(self) -> float:
        return 1000 * self.switches / max(self.frames, 1)


def ratio(part: float, whole: float) -> float:
    """The share, or 1 if there was nothing to find and nothing was reported."""
    return part / whole if whole else 1.0


COUNTS = {
    "num_frames": "frames",
    "num_objects": "objects",
    "num_switches": "switches",
    "num_misses": "misses",
    "num_false_positives": "false",
    "idtp": "idtp",
    "idfp": "idfp",
    "idfn": "idfn",
}


def identity(truth: Truth, alive: dict[int, list[Dot]]) -> Identity:
    accumulator = motmetrics.MOTAccumulator()
    truth = joined(truth, alive)
    for frame, holes in truth.holes.items():
        dots = alive.get(frame, [])
        accumulator.update(list(holes), [dot.id for dot in dots], distances(holes, dots), frameid=frame)
    if accumulator.events.empty:
        return Identity(frames=len(truth.holes))
    measures = motmetrics.metrics.create().compute(accumulator, metrics=list(COUNTS), return_dataframe=False)
    counts = {name: int(measures[key]) for key, name in COUNTS.items()}
    # Frames without holes and without reports count too.
    return Identity(**counts | {"frames": len(truth.holes)})


def joined(truth: Truth, alive: dict[int, list[Dot]]) -> Truth:
    """The truth in which a hole that fell below P, but never vanished, is one hole where it has been one track.

    A selection without a bound follows such a hole all the time; above:P ends it and begins another. Both are right.
    """
    seen: dict[int, list[int]] = {}  # for each hole the ids of its tracks, frame by frame
    for frame, holes in truth.holes.items():
        for id, hole in holes.items():
            near = [(hole.distance(dot.x, dot.y), dot.id) for dot in alive.get(frame, [])]
            if near and min(near)[0] <= NEAR:
                seen.setdefault(id, []).append(min(near)[1])
    one = {id: id for id in seen}
    for id, before in sorted(truth.was.items()):
        if id in seen and before in seen and seen[before][-1] == seen[id][0]:
            one[id] = one[before]
    holes = {frame: {one.get(id, id): hole for id, hole in holes.items()} for frame, holes in truth.holes.items()}
    return replace(truth, holes=holes)


def distances(holes: dict[int, Hole], dots: list[Dot]) -> np.ndarray:
    """Distances of true holes and reported ones. NaN where the two cannot be the same hole."""
    matrix = np.full((len(holes), len(dots)), np.nan)
    for row, hole in enumerate(holes.values()):
        for column, dot in enumerate(dots):
            distance = hole.distance(dot.x, dot.y)
            if distance <= NEAR:
                matrix[row, column] = distance
    return matrix


# Splits and mergers


NOISE = 1e3  # frames: worse than any delay


@dataclass
class Reported:
    """Counts of one kind of event. Those of several runs are added."""

    true: int = 0
    in_time: int = 0
    late: int = 0
    missed: int = 0
    false: int = 0
    again: int = 0  # those of the false ones that tell a true event once more

    def __add__(self, other: Reported) -> Reported:
        return Reported(*(getattr(self, each.name) + getattr(other, each.name) for each in fields(self)))


def reported(
    truth: Truth,
    happenings: list[Happening],
    kind: str,
    slack: int = 0,
    counts: Callable[[Happening], bool] = lambda report: True,
) -> Reported:
    """Matches each true event with at most one report and vice versa, as close in time as possible.

    A selection without a bound sees the smaller part before a split, and after a merger, while its persistence is
    below that of the truth: for at most `slack` frames, in which its report is in time too. A report that belongs to no
    event is false if it `counts`, and is taken for an event only if no report that counts tells it.
    """
    true = [each for each in truth.happenings if each.kind == kind]
    said = [each for each in happenings if each.kind == kind]
    earliest, latest = (-IN_TIME - slack, IN_TIME) if kind == "split" else (-IN_TIME, IN_TIME + slack)
    impossible = 1e6
    costs = np.full((len(true), len(said)), impossible)
    for row, event in enumerate(true):
        for column, report in enumerate(said):
            if earliest <= report.frame - event.frame <= LATE and is_in_place(truth, event, report):
                costs[row, column] = abs(report.frame - event.frame) + (0 if counts(report) else NOISE)
    pairs = [pair for pair in zip(*linear_sum_assignment(costs), strict=True) if costs[pair] < impossible]
    in_time = sum(said[column].frame - true[row].frame <= latest for row, column in pairs)
    matched = {column for _, column in pairs}
    false = [column for column, report in enumerate(said) if column not in matched and counts(report)]
    again = sum(bool((costs[:, column] <= max(-earliest, latest)).any()) for column in false)
    return Reported(len(true), in_time, len(pairs) - in_time, len(true) - len(pairs), len(false), again)


def is_in_place(truth: Truth, event: Happening, report: Happening) -> bool:
    """Whether the report's centre is in one of the holes of the event, in the event's frame or in the report's frame."""
    frames = {event.frame - 1, event.frame, report.frame - 1, report.frame}
    took_part = (truth.holes.get(frame, {}).get(id) for frame in frames for id in (event.id, event.other))
    return any(hole.distance(report.x, report.y) <= IN_PLACE for hole in took_part if hole)


def visible(dots: list[Dot], above: float) -> list[Dot]:
    """The reports that are holes by the measure of the truth. A track continues for some frames below it."""
    return [dot for dot in dots if dot.persistence >= above]


# The rival


def follow_diagrams(alive: dict[int, list[Dot]], above: float) -> dict[int, list[Dot]]:
    """The baseline: dots above a persistence, whose ids are carried from frame to frame by the diagrams alone.

    Diagrams of consecutive frames are matched as for their Wasserstein distance of order 1: (birth, death) in the
    maximum norm, each dot with one of the other frame or with the diagonal, at least cost in all.
    """
    followed: dict[int, list[Dot]] = {}
    before: list[Dot] = []
    fresh = 1
    for frame in sorted(alive):
        dots = visible(alive[frame], above)
        ids = dict(matched_dots(before, dots))
        now = []
        for index, dot in enumerate(dots):
            if index in ids:
                id = ids[index]
            else:
                id, fresh = fresh, fresh + 1
            now.append(Dot(id, dot.x, dot.y, dot.birth, dot.death))
        followed[frame] = before = now
    return followed


def matched_dots(before: list[Dot], now: list[Dot]) -> Iterator[tuple[int, int]]:
    """Indices of `now` with the ids that they have from `before`."""
    old, new = len(before), len(now)
    costs = np.zeros((old + new, old + new))
    for row, was in enumerate(before):
        for column, dot in enumerate(now):
            costs[row, column] = max(abs(was.birth - dot.birth), abs(was.death - dot.death))
    # Every dot may also be matched with the diagonal. Two places on the diagonal cost nothing.
    costs[:old, new:] = np.array([dot.persistence / 2 for dot in before])[:, None]
    costs[old:, :new] = np.array([dot.persistence / 2 for dot in now])[None, :]
    for row, column in zip(*linear_sum_assignment(costs), strict=True):
        if row < old and column < new:
            yield int(column), before[row].id


# All of it


@dataclass
class Score:
    """All counts of a run, or of several."""

    ours: Identity = field(default_factory=Identity)
    rival: Identity = field(default_factory=Identity)
    splits: Reported = field(default_factory=Reported)
    mergers: Reported = field(default_factory=Reported)

    def __add__(self, other: Score) -> Score:
        return Score(*(getattr(self, each.name) + getattr(other, each.name) for each in fields(self)))


def score(truth: Truth, tracks: Tracks, dots: Tracks, slack: int = 0) -> Score:
    """The scores of the tracks, and of the baseline on all dots of the same frames."""

    def counts(report: Happening) -> bool:
        return tracks.is_hole(report.id, report.frame, truth.above)

    return Score(
        identity(truth, {frame: visible(dots, truth.above) for frame, dots in tracks.alive.items()}),
        identity(truth, follow_diagrams(dots.alive, truth.above)),
        reported(truth, tracks.happenings, "split", slack, counts),
        reported(truth, tracks.happenings, "merged", slack, counts),
    )


# Views


def gaps_to_show(truth: Truth, dots: Tracks) -> int:
    """The least k for which the dots above the lowest of the k widest gaps have every true hole, in every frame.

    `dots` are the most persistent ones of each frame. A hole without a dot is shown by no k.
    """
    return max((gaps_of_frame(holes, dots.alive.get(frame, [])) for frame, holes in truth.holes.items()), default=1)


def gaps_of_frame(holes: dict[int, Hole], dots: list[Dot]) -> int:
    near = ([dot.persistence for dot in dots if hole.distance(dot.x, dot.y) <= NEAR] for hole in holes.values())
    least = min((max(found) for found in near if found), default=math.inf)
    levels = sorted({0.0, *(dot.persistence for dot in dots)})
    gaps = [(above - below, above) for below, above in itertools.pairwise(levels)]
    widest = max((width for width, above in gaps if above <= least), default=0.0)
    return 1 + sum(width > widest for width, _ in gaps)
