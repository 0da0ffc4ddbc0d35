#!/usr/bin/env python3
"""Tests of clutter.py, on a stand-in for hopes.

    benches/.tracks/venv/bin/python -m unittest discover --start-directory benches/tracks
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import textwrap
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import clutter  # noqa: E402
from clutter import Case, Count, Filter, Skeleton  # noqa: E402
from scoring import Hole  # noqa: E402

# A program whose scenes have one true hole, in a ring of 3 points, and one stray point, which halves its persistence.
STAND_IN = """
    #!{python}
    import json, sys
    words = sys.argv[1:]
    value = lambda key: words[words.index(key) + 1]
    ring, stray = [[1.0, 0.0], [-1.0, 0.5], [-1.0, -0.5]], [0.125, 0.0]
    if words[0] == "scene":
        points = ring + [stray] * ("--clutter" in words)
        frames = int(value("--frames"))
        hole = dict(id=1, x=0.0, y=0.0, radius=1.0, orbit=0.0)
        lines = [dict(above=0.4)] + [dict(frame=at, holes=[hole], events=[], clutter=len(points) - 3)
                                     for at in range(1, frames + 1)]
        open(value("--truth"), "w").writelines(json.dumps(line) + "\\n" for line in lines)
        open(value("-o"), "w").write(("".join(f"{{x}},{{y}}\\n" for x, y in points) + "\\n") * frames)
    else:
        points = [list(map(float, line.split(","))) for line in sys.stdin]
        kept = [point for point in points if point != stray or "--declutter=3" not in words]
        death = 0.5 if stray in kept else 1.0
        dot = dict(birth=0.0, death=death, hole=dict(center=[0.0, 0.1]))
        far = dict(birth=0.0, death=9.0, hole=dict(center=[7.0, 0.0]))
        edges = [[points.index(a), points.index(b)] for a, b in zip(kept, kept[1:])]
        print(json.dumps(dict(vertices=points, dots=[far, dot], mst=dict(edges=edges))))
"""


class ClutterTest(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.hopes = str(Path(folder.name, "hopes"))
        Path(self.hopes).write_text(textwrap.dedent(STAND_IN).strip().format(python=sys.executable))
        os.chmod(self.hopes, 0o755)

    def measured(self, share: float, *filters: Filter) -> list[Count]:
        return clutter.measure(self.hopes, Case("static", 1, share, False, (1, 3)), list(filters))

    def test_a_stray_point_takes_a_hole_and_a_filter_keeps_it(self) -> None:
        none, ours = self.measured(0.05, Filter(), Filter("ours", options=("--declutter=3",)))
        self.assertEqual((none.holes, none.kept, none.points, none.removed, none.strays, none.left), (2, 0, 6, 0, 2, 2))
        self.assertEqual((ours.holes, ours.kept, ours.removed, ours.strays, ours.left), (2, 2, 0, 2, 0))
        self.assertEqual(none.share_kept, 0)

    def test_a_program_may_filter(self) -> None:
        program = (sys.executable, "-c", "import sys; sys.stdout.writelines(list(sys.stdin)[1:])")
        (found,) = self.measured(0.0, Filter("tail", command=program))
        self.assertEqual((found.points, found.removed, found.most_removed), (6, 2, 1 / 3))

    def test_holes_that_gain_too_much_are_not_kept(self) -> None:
        hole = Hole(0.0, 0.0, 1.0, 0.0)
        for level, kept in ((0.79, 0), (0.8, 1), (1.25, 1), (1.26, 0)):
            found = Skeleton([(0.4, 0.0, level), (0.6, 0.0, 1.0)], set())
            self.assertEqual(clutter.compared({hole: 1.0}, [], [], found).kept, kept, level)

    def test_bounds_are_of_filters_and_leave_the_hard_scene_out(self) -> None:
        ours = Filter("ours")
        results = {
            (ours, "static", 0.05, False): Count(holes=1000, kept=950),
            (ours, "cells", 0.05, False): Count(holes=100, kept=83),
            (ours, "uneven", 0.05, False): Count(holes=100, kept=0),
            (ours, "densities", 0.1, False): Count(holes=100, kept=85),
            (ours, "static", 0.1, True): Count(holes=100, kept=0),
            (ours, "static", 0.0, False): Count(points=1000, removed=1),
            (ours, "densities", 0.0, False): Count(points=1000, removed=5),
            (ours, "uneven", 0.0, False): Count(points=1000, removed=6),
        }
        found = list(clutter.complaints(results))
        self.assertEqual(len(found), 3, found)
        self.assertIn("ours: 0.890 of the holes are kept at 5%", found[0])
        self.assertIn("0.0010 of the true points of static", found[1])
        self.assertIn("0.0060 of the true points of uneven", found[2])

    def run_all(self, *words: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, str(HERE / "clutter.py"), "--hopes", self.hopes, *words]
        return subprocess.run(command, text=True, capture_output=True)

    def test_tables_are_of_each_filter(self) -> None:
        done = self.run_all("--quick", "--declutter=3", "--require")
        self.assertEqual(done.returncode, 0, done.stderr)
        none, ours = done.stdout.split("Filter: ")[1:]
        self.assertTrue(none.startswith("none. ") and ours.startswith("--declutter=3. "))
        self.assertIn("| static | 1.00 | 0.00 | 0.00 | 0.0000 | 0.0000 | 1.00 |", none)
        self.assertIn("| static | 1.00 | 1.00 | 1.00 | 0.0000 | 0.0000 | 0.00 |", ours)
        self.assertIn("| **all but uneven** | 1.00 | 1.00 | 1.00 |", ours)

    def test_a_filter_that_does_nothing_meets_no_bound(self) -> None:
        done = self.run_all("--quick", "--filter", "cat", "--require")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("BOUND NOT MET cat: 0.000 of the holes are kept at 5%: not 0.9", done.stderr)
        done = self.run_all("--quick", "--filter", "/nowhere/filter")
        self.assertEqual(done.returncode, 2)
        self.assertIn("/nowhere/filter cannot be run", done.stderr)


if __name__ == "__main__":
    unittest.main()
