#!/usr/bin/env python3
"""Tests of scoring.py and evaluate.py, on hand-written truths and tracks and on a stand-in for hopes.

    benches/.tracks/venv/bin/python -m unittest discover --start-directory benches/tracks
"""

from __future__ import annotations

import contextlib
import csv
import io
import json
import os
import subprocess
import sys
import tempfile
import textwrap
import unittest
from collections.abc import Callable
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import evaluate  # noqa: E402
import scoring  # noqa: E402
from scoring import Dot, Identity, Reported  # noqa: E402

FRAMES = 40
ABOVE = 0.4


def hole(id: int, x: float, y: float = 0.0, radius: float = 1.0, orbit: float = 0.0) -> dict[str, Any]:
    return {"id": id, "x": x, "y": y, "radius": radius, "orbit": orbit}


def truth_lines(
    holes: Callable[[int], list[dict[str, Any]]], events: dict[int, list[dict[str, Any]]] | None = None
) -> list[str]:
    header = {"scene": "made", "seed": 1, "frames": FRAMES, "noise": 0, "points_per_radius": 16, "above": ABOVE}
    frames = [
        {"frame": frame, "holes": holes(frame), "events": (events or {}).get(frame, [])}
        for frame in range(1, FRAMES + 1)
    ]
    return [json.dumps(line) + "\n" for line in (header, *frames)]


def track_lines(
    alive: Callable[[int], list[list[Any]]], events: dict[int, list[dict[str, Any]]] | None = None
) -> list[str]:
    head = {"stream": "default", "vertices": {}}
    frames = [
        {**head, "frame": frame, "tracks": (events or {}).get(frame, []), "alive": alive(frame)}
        for frame in range(1, FRAMES + 1)
    ]
    return [json.dumps(line, separators=(",", ":")) + "\n" for line in frames]


def row(id: int, x: float, y: float = 0.0, birth: float = 0.2, death: float = 1.0) -> list[Any]:
    return [id, x, y, death, birth, death]


def two_holes(frame: int) -> list[dict[str, Any]]:
    """Two holes that move past each other."""
    return [hole(1, 0.1 * frame, 2.0), hole(2, -0.1 * frame, -2.0)]


def truth(*parts: Any) -> scoring.Truth:
    return scoring.read_truth(truth_lines(*parts))


def tracks(*parts: Any) -> scoring.Tracks:
    return scoring.read_tracks(track_lines(*parts))


class IdentityTest(unittest.TestCase):
    def of(self, alive: Callable[[int], list[list[Any]]]) -> Identity:
        return scoring.identity(truth(two_holes), tracks(alive).alive)

    def test_a_perfect_tracker_is_perfect(self) -> None:
        found = self.of(lambda frame: [row(7, 0.1 * frame, 2.3), row(9, -0.1 * frame, -2.0)])
        self.assertEqual((found.idf1, found.mota, found.switches), (1, 1, 0))
        self.assertEqual((found.frames, found.objects), (FRAMES, 2 * FRAMES))

    def test_swapped_ids_are_switches(self) -> None:
        def swaps(frame: int) -> list[list[Any]]:
            ids = (7, 9) if frame <= FRAMES / 2 else (9, 7)
            return [row(ids[0], 0.1 * frame, 2.0), row(ids[1], -0.1 * frame, -2.0)]

        found = self.of(swaps)
        self.assertEqual((found.switches, found.misses, found.false), (2, 0, 0))
        self.assertEqual((found.idf1, found.mota), (0.5, 1 - 2 / (2 * FRAMES)))
        self.assertEqual(found.switches_per_1000, 2000 / FRAMES)

    def test_what_is_missed_and_what_is_not_there_count(self) -> None:
        found = self.of(lambda frame: [row(7, 0.1 * frame, 2.0), row(9, 100.0)] if frame > 10 else [])
        self.assertEqual((found.misses, found.false), (FRAMES + 10, FRAMES - 10))
        kept = FRAMES - 10
        self.assertAlmostEqual(found.idf1, 2 * kept / (2 * FRAMES + 2 * kept))

    def test_a_centre_farther_off_than_half_the_radius_is_another(self) -> None:
        for off, misses in ((0.49, 0), (0.51, FRAMES)):
            found = self.of(lambda frame, off=off: [row(7, 0.1 * frame + off, 2.0), row(9, -0.1 * frame, -2.0)])
            self.assertEqual((found.misses, found.false), (misses, misses))

    def test_nothing_is_followed_perfectly_by_nothing(self) -> None:
        found = scoring.identity(truth(lambda frame: []), tracks(lambda frame: []).alive)
        self.assertEqual((found.idf1, found.mota, found.frames), (1, 1, FRAMES))

    def test_the_centre_of_an_annulus_lies_on_its_orbit(self) -> None:
        annulus = scoring.Hole(1.0, 1.0, 0.5, 2.0)
        self.assertEqual(annulus.distance(1.0, 3.0), 0)
        self.assertEqual(annulus.distance(1.0, 1.0), 4)
        self.assertEqual(annulus.distance(3.25, 1.0), 0.5)

    def test_a_slender_hole_is_anywhere_on_its_ridge(self) -> None:
        slender = scoring.Hole(1.0, 0.0, 0.5, 0.0, (0.0, 2.0))
        self.assertEqual([slender.distance(*at) for at in ((1, 1.5), (2, -1), (1, 3))], [0, 2, 2])
        (read,) = truth(lambda frame: [{**hole(3, 1.0), "ridge": [0.0, 2.0]}]).holes[1].values()
        self.assertEqual(read.ridge, (0.0, 2.0))

    def test_runs_add_up(self) -> None:
        both = Identity(1, 2, 3, 4, 5, 6, 7, 8) + Identity(10, 20, 30, 40, 50, 60, 70, 80)
        self.assertEqual(both, Identity(11, 22, 33, 44, 55, 66, 77, 88))


SPLIT = 20


def pinched(frame: int) -> list[dict[str, Any]]:
    if frame < SPLIT:
        return [hole(1, 0.5, radius=1.5)]
    return [hole(1, 0.0), hole(2, 1.8, radius=0.8)]


def split(id: int = 2, x: float = 1.8, y: float = 0.0) -> dict[str, Any]:
    return {"id": id, "event": "split", "age": 1, "center": [x, y], "from": 1}


class ReportedTest(unittest.TestCase):
    def of(self, events: dict[int, list[dict[str, Any]]], kind: str = "split") -> Reported:
        true = truth(pinched, {SPLIT: [{"event": "split", "id": 2, "from": 1}]})
        return scoring.reported(true, tracks(lambda frame: [], events).happenings, kind)

    def test_a_split_is_found_in_time_late_or_not(self) -> None:
        in_time, late, missed = Reported(1, 1, 0, 0, 0), Reported(1, 0, 1, 0, 0), Reported(1, 0, 0, 1, 1)
        for frame, expected in ((20, in_time), (23, in_time), (17, in_time), (24, late), (39, late), (16, missed)):
            self.assertEqual(self.of({frame: [split()]}), expected, frame)
        self.assertEqual(self.of({}), Reported(1, 0, 0, 1, 0))

    def test_a_second_report_is_false(self) -> None:
        self.assertEqual(self.of({21: [split()], 22: [split(id=5)]}), Reported(1, 1, 0, 0, 1, 1))
        self.assertEqual(self.of({21: [split()], 30: [split(id=5)]}), Reported(1, 1, 0, 0, 1, 0))

    def test_a_split_elsewhere_is_another(self) -> None:
        self.assertEqual(self.of({20: [split(y=3.0)]}), Reported(1, 0, 0, 1, 1))
        self.assertEqual(self.of({20: [split(x=0.0)]}), Reported(1, 1, 0, 0, 0), "the other part may be the new one")

    def test_kinds_are_told_apart(self) -> None:
        merged = {"id": 2, "event": "merged", "center": [1.8, 0.0], "into": 1}
        self.assertEqual(self.of({20: [merged]}), Reported(1, 0, 0, 1, 0))
        self.assertEqual(self.of({20: [merged]}, "merged"), Reported(0, 0, 0, 0, 1))

    def test_a_centre_that_is_not_told_is_in_no_place(self) -> None:
        event = {**split(), "center": [None, None]}
        self.assertEqual(self.of({20: [event]}), Reported(1, 0, 0, 1, 1))

    def test_two_near_in_time_are_matched_by_place(self) -> None:
        def pairs(frame: int) -> list[dict[str, Any]]:
            return [*pinched(frame), *({**each, "id": each["id"] + 2, "y": 50.0} for each in pinched(frame))]

        true = truth(pairs, {SPLIT: [{"event": "split", "id": id, "from": id - 1} for id in (2, 4)]})
        said = {21: [split(y=50.0)], 22: [split(id=9)]}
        self.assertEqual(scoring.reported(true, tracks(lambda frame: [], said).happenings, "split"), Reported(2, 2))


    def test_a_selection_without_a_bound_sees_the_smaller_part_longer(self) -> None:
        true = truth(pinched, {SPLIT: [{"event": kind, "id": 2, OTHER: 1} for kind, OTHER in scoring.OTHER.items()]})

        def of(kind: str, frame: int) -> Reported:
            event = {**split(), "event": kind, scoring.OTHER[kind]: 1}
            return scoring.reported(true, tracks(lambda frame: [], {frame: [event]}).happenings, kind, slack=8)

        in_time, late, missed = Reported(1, 1), Reported(1, 0, 1), Reported(1, 0, 0, 1, 1)
        for frame, expected in ((9, in_time), (8, missed), (23, in_time), (24, late)):
            self.assertEqual(of("split", frame), expected, frame)
        for frame, expected in ((17, in_time), (16, missed), (31, in_time), (32, late)):
            self.assertEqual(of("merged", frame), expected, frame)


class WideTest(unittest.TestCase):
    """Selections that hold more dots than there are holes."""

    def score(self, alive: Callable[[int], list[list[Any]]], *parts: Any) -> scoring.Score:
        followed = tracks(alive, *parts[1:])
        return scoring.score(truth(parts[0] if parts else two_holes), followed, followed, 8)

    def test_tracks_of_noise_are_not_false(self) -> None:
        noise = {5: [{"id": 50, "event": "split", "center": [0, 2], "from": 7}]}
        holes = [lambda frame: row(7, 0.1 * frame, 2.0), lambda frame: row(9, -0.1 * frame, -2.0)]
        dust = [row(50, 0.5, 2.0, 0.2, 0.5), row(51, 90.0, 0.0, 0.2, 0.3)]
        found = self.score(lambda frame: [each(frame) for each in holes] + dust, two_holes, noise)
        self.assertEqual((found.ours.idf1, found.ours.false, found.splits.false), (1, 0, 0))

    def test_an_id_that_goes_to_noise_is_a_switch(self) -> None:
        def jumps(frame: int) -> list[list[Any]]:
            ring, dust = (7, 50) if frame <= 20 else (50, 7)
            return [row(ring, 0.1 * frame, 2.0), row(dust, 0.1 * frame, 2.2, 0.2, 0.5), row(9, -0.1 * frame, -2.0)]

        found = self.score(jumps).ours
        self.assertEqual((found.switches, found.idf1), (1, 0.75))

    def test_a_report_about_a_hole_counts(self) -> None:
        said = {5: [{"id": 7, "event": "split", "center": [0.5, 2], "from": 9}]}
        found = self.score(lambda frame: [row(7, 0.1 * frame, 2.0), row(9, -0.1 * frame, -2.0)], two_holes, said)
        self.assertEqual((found.splits.false, found.splits.again), (1, 0))

    def test_a_faint_hole_may_be_one_track_or_two(self) -> None:
        def faint(frame: int) -> list[dict[str, Any]]:
            return [hole(1 if frame < 15 else 2, 0.0)] if not 15 <= frame < 25 else []

        true = truth(faint, {25: [{"event": "born", "id": 2, "was": 1}]})
        self.assertEqual(true.was, {2: 1})

        def of(first: int, second: int, true: scoring.Truth) -> Identity:
            ids = {True: first, False: second}
            alive = tracks(lambda frame: [row(ids[frame < 15], 0.0)] if not 15 <= frame < 25 else []).alive
            return scoring.identity(true, alive)

        for first, second in ((1, 1), (1, 2)):
            found = of(first, second, true)
            self.assertEqual((found.idf1, found.switches), (1, 0))
        apart = truth(faint, {25: [{"event": "born", "id": 2}]})
        self.assertLess(of(1, 1, apart).idf1, 1)

    def test_a_view_shows_all_holes_with_enough_gaps(self) -> None:
        def dot(level: float, x: float = 50.0) -> Dot:
            return Dot(1, x, 0.0, 0.0, level)

        holes = {1: scoring.Hole(0.0, 0.0, 1.0, 0.0), 2: scoring.Hole(9.0, 0.0, 1.0, 0.0)}
        # Gaps: 2 to 5 is the widest, then 1.2 to 2, then 0.5 to 1.2.
        dots = [dot(5.0, 0.0), dot(2.0, 9.0), dot(1.2), dot(0.5)]
        self.assertEqual(scoring.gaps_of_frame(holes, dots), 2)
        self.assertEqual(scoring.gaps_of_frame({1: holes[1]}, dots), 1)
        self.assertEqual(scoring.gaps_of_frame({}, dots), 1)
        self.assertEqual(scoring.gaps_of_frame(holes, [dot(5.0, 0.0), dot(2.0), dot(0.5, 9.0)]), 3)


class RivalTest(unittest.TestCase):
    def test_clear_dots_keep_their_ids(self) -> None:
        dots = tracks(lambda frame: [row(frame, 0.1 * frame, 2.0, death=1.5), row(-frame, -0.1 * frame, -2.0)]).alive
        found = scoring.identity(truth(two_holes), scoring.follow_diagrams(dots, ABOVE))
        self.assertEqual((found.idf1, found.switches), (1, 0))

    def test_holes_whose_dots_change_places_are_confused(self) -> None:
        def crossing(frame: int) -> list[list[Any]]:
            grows, shrinks = 1 + 0.1 * frame, 1 + 0.1 * (FRAMES + 1 - frame)
            return [row(1, 0.1 * frame, 2.0, death=grows), row(2, -0.1 * frame, -2.0, death=shrinks)]

        found = scoring.identity(truth(two_holes), scoring.follow_diagrams(tracks(crossing).alive, ABOVE))
        self.assertEqual((found.switches, found.misses), (2, 0))

    def test_a_dot_goes_to_the_diagonal_rather_than_far(self) -> None:
        dots = {1: [Dot(1, 0, 0, 0.0, 1.0)], 2: [Dot(1, 0, 0, 5.0, 6.0)], 3: [Dot(1, 0, 0, 5.1, 6.0)]}
        ids = [[dot.id for dot in frame] for frame in scoring.follow_diagrams(dots, 0.5).values()]
        self.assertEqual(ids, [[1], [2], [2]])

    def test_the_whole_is_cheapest_not_each_dot(self) -> None:
        before = [Dot(1, 0, 0, 0.0, 3.0), Dot(2, 0, 0, 0.0, 4.0)]
        now = [Dot(0, 0, 0, 0.0, 3.9), Dot(0, 0, 0, 0.0, 4.8)]
        self.assertEqual(sorted(scoring.matched_dots(before, now)), [(0, 1), (1, 2)])

    def test_dots_below_are_none(self) -> None:
        dots = {1: [Dot(1, 0, 0, 0.0, 1.0), Dot(2, 0, 0, 0.0, 0.3)], 2: []}
        self.assertEqual([len(frame) for frame in scoring.follow_diagrams(dots, ABOVE).values()], [1, 0])


class ReadingTest(unittest.TestCase):
    def test_lines_are_read_as_they_are_written(self) -> None:
        line = '{"stream":"default","frame": 3,"vertices":{"add":[[1,2.0,3.0]]},"tracks":[],'
        (dot,) = scoring.read_tracks([line + '"alive":[[4,1,null,2,0.5,2.5]]}\n']).alive[3]
        self.assertEqual((dot.id, dot.x, dot.persistence), (4, 1, 2))
        self.assertNotEqual(dot.y, dot.y)

    def test_frames_without_tracks_are_told(self) -> None:
        with self.assertRaisesRegex(ValueError, "--track"):
            scoring.read_tracks(['{"stream":"default","frame":3}'])


# A program that makes one pinch, and follows it perfectly or swaps ids half way.
STAND_IN = """
    #!{python}
    import json, sys
    words = sys.argv[1:]
    value = lambda key: words[words.index(key) + 1]
    if words == ["scene", "--list"]:
        print("pinch  one hole becomes two\\nmixed  all of it")
    elif words[0] == "scene":
        if words[1] not in ("pinch", "mixed"):
            sys.exit("no such scene")
        open(value("--truth"), "w").writelines({truth!r})
        open(value("-o"), "w").write("0,0\\n\\n")
    elif value("--track") in ("above:0.4", "top:8", "view") and "--track-list" in words:
        if value("--track") == "view" and value("-k") != "1":
            sys.exit("a wrong view")
        sys.stdout.writelines({tracks!r})
"""


class WholeTest(unittest.TestCase):
    def stand_in(self, swaps: bool) -> list[str]:
        def alive(frame: int) -> list[list[Any]]:
            first = 3 if swaps and frame > 30 else 1
            parts = [row(first, 0.0), row(2, 1.8, birth=0.1, death=0.8)]
            return parts if frame >= SPLIT else [row(1, 0.5, death=1.5)]

        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        program = Path(folder.name, "hopes")
        lines = {
            "truth": truth_lines(pinched, {SPLIT: [{"event": "split", "id": 2, "from": 1}]}),
            "tracks": track_lines(alive, {SPLIT: [split()]}),
        }
        program.write_text(textwrap.dedent(STAND_IN).strip().format(python=sys.executable, **lines))
        os.chmod(program, 0o755)
        self.csv = Path(folder.name, "all.csv")
        return [sys.executable, str(HERE / "evaluate.py"), "--hopes", str(program), "--csv", str(self.csv)]

    def ends(self, command: list[str], code: int) -> subprocess.CompletedProcess[str]:
        done = subprocess.run(command, text=True, capture_output=True)
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def test_a_perfect_tracker_meets_the_bounds(self) -> None:
        done = self.ends([*self.stand_in(swaps=False), "--require", "--noises", "0,0.3"], 0)
        self.assertIn("Noise 0 of the radius, 7 runs:", done.stdout)
        self.assertIn("Noise 0.3 of the radius, 7 runs:", done.stdout)
        self.assertIn("| pinch | 1.0000 | 1.0000 | 0.00 | 3 / 3 | 0 / 0 | 0 | 1.0000 | 0.00 |", done.stdout)
        self.assertIn("| mixed | 1.0000 | 1.0000 | 0.00 | 4 / 4 |", done.stdout)
        rows = list(csv.DictReader(self.csv.read_text().splitlines()))
        self.assertEqual((len(rows), rows[-1]["scene"], rows[-1]["noise"], rows[-1]["seed"]), (14, "mixed", "0.3", "4"))
        self.assertEqual([rows[0][key] for key in ("idf1", "rival_idf1", "splits_in_time")], ["1.000000"] * 2 + ["1"])

    def test_swapped_ids_do_not(self) -> None:
        command = [*self.stand_in(swaps=True), "--scenes", "pinch", "--seeds", "1", "--noises"]
        done = self.ends([*command, "0.1", "--require"], 1)
        self.assertIn("BOUND NOT MET pinch seed 1 noise 0.1: switches: 1", done.stderr)
        self.assertIn("scene pinch --seed 1 --noise 0.1", done.stderr)
        # Bounds are not checked without --require, and not for large noise.
        self.ends([*command, "0.1"], 0)
        self.ends([*command, "0.2", "--require"], 0)

    def test_all_selections_are_followed(self) -> None:
        command = [*self.stand_in(swaps=False), "--wide", "--scenes", "pinch", "--noises", "0.1", "--require"]
        done = self.ends(command, 0)
        for selection in ("above", "top", "view"):
            self.assertIn(f"Noise 0.1 of the radius, {selection}, churn 0.05, 1 runs:", done.stdout)
            self.assertIn(f"| {selection} | churn 1 | 0.1 | 1 | 1.000 | 1.0000 |", done.stdout)
        rows = list(csv.DictReader(self.csv.read_text().splitlines()))
        self.assertEqual([row["rule"] for row in rows[:3]], ["above:0.4", "top:8", "view -k 1"])
        done = self.ends([*command, "--cameras", "none,pan:1"], 0)
        self.assertIn("| view | churn 1 camera moves | 0.1 | 1 |", done.stdout)
        done = self.ends([*command, "--selections", "below"], 2)
        self.assertIn("'below' is no list of selection", done.stderr)

    def test_a_few_runs_in_a_hundred_may_be_less_than_good(self) -> None:
        def result(idf1: int, switches: int = 0, again: int = 0) -> evaluate.Result:
            ours = Identity(idtp=idf1, idfp=100 - idf1, idfn=100 - idf1, switches=switches)
            score = scoring.Score(ours, splits=Reported(1, 1, again=again))
            return evaluate.Result(evaluate.Run("pinch", 1, 0.1), "above", ["above:1"], 16, score)

        def is_met(*results: evaluate.Result) -> bool:
            with contextlib.redirect_stderr(io.StringIO()):
                return evaluate.bounds_are_met(evaluate.Settings("hopes"), list(results))

        good = [result(100)] * 97
        self.assertTrue(is_met(*good, result(96), result(95), result(99, switches=1)))
        self.assertFalse(is_met(*good[:96], result(96), result(95), result(99, switches=1), result(98)))
        self.assertFalse(is_met(*good, result(94)))
        self.assertFalse(is_met(*good, result(100, again=1)))

    def test_failures_are_reported(self) -> None:
        done = self.ends([*self.stand_in(swaps=False), "--scenes", "none"], 2)
        self.assertIn("no such scene", done.stderr)
        done = self.ends([sys.executable, str(HERE / "evaluate.py"), "--hopes", "/nowhere/hopes"], 2)
        self.assertIn("/nowhere/hopes cannot be run", done.stderr)


if __name__ == "__main__":
    unittest.main()
