#!/usr/bin/env python3
"""Measures how well hopes tracks holes, against the ground truth of seeded scenes and beside a baseline.

Each run is a scene with a seed and a noise: `hopes scene` makes its points and its truth, `hopes serve --track RULE`
follows them, and scoring.py counts how often a true hole kept its id, and whether each true split and merger was
reported once and within three frames. The baseline carries ids along by matching the persistence diagrams of the same
frames (dots above P) alone. RULE is a selection: `above` is above:P (P is in the truth); `top` is top:M, M four times the
largest number of true holes and at least 8; `view` is the view with the fewest gaps that show every true hole.

In: this repository, a Rust toolchain and Python 3.11. Everything else (requirements.txt, in a virtual environment) is
installed under benches/.tracks/ on first use.

Out: a Markdown table for each noise (and selection, churn and camera, if there are several) on standard output, one row
for each scene over all its seeds; with --wide or several selections a summary; progress on standard error; with --csv a
row for each run. A switch is a true hole that continues with another id. `in time` are the true splits and mergers that
were reported within three frames (`top` and `view` may tell a split earlier, and a merger later, while the smaller part
is below P: at most 8 frames more), `false` the reports without a true event, or of one that was reported before.

--wide is every scene in the plane, three selections, a churn of 0.05 and of 1, one seed; and some scenes with cameras.

Exit code: 0 done, 1 a bound of --require is not met, 2 something is missing or failed. The bounds, for runs with at
least 12 points per radius and a noise of at most 0.1: IDF1 at least 0.99 and no switch in 97% of them, IDF1 at least
0.95 in each, every split and merger reported in time and once.

    python3 benches/tracks/evaluate.py --quick
    python3 benches/tracks/evaluate.py --require --csv tracks.csv
    python3 benches/tracks/evaluate.py --wide --require --csv wide.csv
    python3 benches/tracks/evaluate.py --selections top --cameras pan:1,shake:0.5 --noises 0.1 --clutter 0.05 --declutter
"""

from __future__ import annotations

import argparse
import itertools
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tables import said, share_of_good, tables, write_csv

if TYPE_CHECKING:
    from scoring import Score, Tracks

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
VENV = HERE.parent / ".tracks" / "venv"
VENV_PYTHON = VENV / "bin" / "python"
REQUIREMENTS = HERE / "requirements.txt"
HOPES = ROOT / "target" / "release" / "hopes"

SEEDS = 3
EXTRA = ("mixed", SEEDS + 1)  # one more run
NOISES = (0.0, 0.05, 0.1, 0.2, 0.3)
QUICK = {"scenes": ["drift", "pinch", "fuse", "occlusion"], "noises": [0.0, 0.1], "seeds": 1, "frames": 120}

WIDE: dict[str, Any] = {"selections": ["above", "top", "view"], "churns": [0.05, 1.0], "seeds": 1}
CAMERA_SCENES = ("drift", "concentric", "mixed", "ellipses", "cells")  # of --wide, at the first of its churns
CAMERAS = ("pan:1", "turn:0.5", "zoom:0.5", "shake:0.5")
SELECTIONS = ("above", "top", "view")
SPARE = 4  # times as many dots as holes in top:M
LEAST_TOP = 8
SLACK = 8  # frames in which the smaller part of a pair or of two cells grows from nothing to P

# Runs to which --require applies its bounds
DENSE = 12
CALM = 0.1
GOOD_IDF1 = 0.99
LEAST_IDF1 = 0.95
GOOD_SHARE = 0.97


class Missing(Exception):
    """A prerequisite of this evaluation is missing or failed."""


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


# Tools


def enter_venv() -> None:
    """Restarts in the virtual environment, which is made if it is missing or has other versions."""
    if Path(sys.prefix) == VENV:
        return
    mark = VENV / "requirements.txt"
    if not mark.exists() or mark.read_text() != REQUIREMENTS.read_text():
        say("installing requirements.txt into a virtual environment")
        run([sys.executable, "-m", "venv", VENV])
        run([VENV_PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r", REQUIREMENTS])
        mark.write_text(REQUIREMENTS.read_text())  # last: its presence says that all is there
    os.execv(VENV_PYTHON, [str(VENV_PYTHON), *sys.argv])


def run(command: list[Any]) -> str:
    """The standard output of a command that must succeed."""
    line = [str(part) for part in command]
    try:
        done = subprocess.run(line, cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    except OSError as error:
        raise Missing(f"{line[0]} cannot be run: {error.strerror}") from None
    if done.returncode:
        raise Missing(f"{' '.join(line)} failed with exit code {done.returncode}: {done.stderr.strip()[-500:]}")
    return done.stdout


# Runs


@dataclass(frozen=True)
class Run:
    scene: str
    seed: int
    noise: float
    churn: float | None = None
    camera: str | None = None

    def __str__(self) -> str:
        return f"{self.scene} seed {self.seed} noise {self.noise:g}{said(self.churn, self.camera)}"

    def options(self) -> list[str]:
        """Of the scene."""
        return given({"--churn": self.churn, "--camera": self.camera})


@dataclass(frozen=True)
class Settings:
    """The settings of all runs. For None the default of hopes is used."""

    hopes: str
    frames: int | None = None
    points_per_radius: int | None = None
    clutter: float | None = None
    clumps: bool = False
    declutter: str | None = None
    confirm: int | None = None
    miss: int | None = None
    selections: tuple[str, ...] = ("above",)

    def options(self) -> list[str]:
        """Of the scene."""
        wanted = {"--frames": self.frames, "--points-per-radius": self.points_per_radius, "--clutter": self.clutter}
        return given(wanted) + ["--clumps"] * self.clumps

    def patience(self) -> list[str]:
        """Of the tracker."""
        return given({"--track-confirm": self.confirm, "--track-miss": self.miss})

    def filter(self) -> list[str]:
        """Of serve, before the skeleton."""
        return [] if self.declutter is None else ["--declutter" + (f"={self.declutter}" if self.declutter else "")]


def given(wanted: dict[str, Any]) -> list[str]:
    return [word for key, value in wanted.items() if value is not None for word in (key, str(value))]


@dataclass
class Result:
    run: Run
    selection: str
    rule: list[str]
    points_per_radius: float
    score: Score

    def __str__(self) -> str:
        return str(self.run) if self.selection == "above" else f"{self.run} {' '.join(self.rule)}"

    @property
    def is_bound(self) -> bool:
        """Whether the bounds of --require hold for it."""
        return self.points_per_radius >= DENSE and self.run.noise <= CALM

    def faults(self) -> list[str]:
        """Why it is not among the good runs."""
        ours = self.score.ours
        low = [f"IDF1 is {ours.idf1:.4f}"] if ours.idf1 < GOOD_IDF1 else []
        return low + ([f"switches: {ours.switches}"] if ours.switches else [])

    def complaints(self) -> list[str]:
        """What must not be in any run."""
        found = []
        if self.score.ours.idf1 < LEAST_IDF1:
            found.append(f"IDF1 is {self.score.ours.idf1:.4f}")
        for name, kind in (("splits", self.score.splits), ("mergers", self.score.mergers)):
            if kind.in_time < kind.true:
                found.append(f"{name} in time: {kind.in_time} of {kind.true}")
            if kind.again:
                found.append(f"{name} reported again: {kind.again}")
        return found


def scene_command(settings: Settings, run: Run, points: str, truth: str) -> list[str]:
    chosen = [run.scene, "--seed", str(run.seed), "--noise", str(run.noise), *run.options(), *settings.options()]
    return [settings.hopes, "scene", *chosen, "--truth", truth, "-o", points]


def evaluate(settings: Settings, this: Run) -> list[Result]:
    """A result for each selection. Runs in its own process."""
    import scoring

    with tempfile.TemporaryDirectory(prefix="hopes-tracks-") as folder:
        points, truth_file = Path(folder, "points.txt"), Path(folder, "truth.jsonl")
        run(scene_command(settings, this, str(points), str(truth_file)))
        with truth_file.open() as lines:
            truth = scoring.read_truth(lines)
        above = ["--track", f"above:{truth.above!r}"]
        top = ["--track", f"top:{max(SPARE * truth.most, LEAST_TOP)}"]
        # Tracks of the dots of one frame only.
        dots = follow(settings, points, *(above if settings.selections == ("above",) else top), *ONE_FRAME)
        results = []
        for selection in settings.selections:
            rule = above if selection == "above" else top
            if selection == "view":
                rule = ["--track", "view", "-k", str(scoring.gaps_to_show(truth, dots))]
            tracks = follow(settings, points, *rule, *settings.patience())
            if tracks.alive.keys() != truth.holes.keys():
                raise Missing(f"{this}: {len(truth.holes)} frames are true, {len(tracks.alive)} were followed")
            score = scoring.score(truth, tracks, dots, 0 if selection == "above" else SLACK)
            results.append(Result(this, selection, rule[1:], truth.header["points_per_radius"], score))
    return results


ONE_FRAME = ("--track-confirm", "1", "--track-miss", "1")


def follow(settings: Settings, points: Path, *options: str) -> Tracks:
    import scoring

    command = [settings.hopes, "serve", "--window", "frames:1", "--track-list", *settings.filter(), *options]
    with points.open() as source, tempfile.TemporaryFile("w+") as log:
        with subprocess.Popen(command, stdin=source, stdout=subprocess.PIPE, stderr=log, text=True) as child:
            try:
                tracks = scoring.read_tracks(child.stdout or ())
            except ValueError as error:
                child.kill()
                raise Missing(f"{' '.join(command)}: {error}") from None
        if child.returncode:
            log.seek(0)
            raise Missing(f"{' '.join(command)} failed: {log.read().strip()[-500:]}")
    return tracks


# Command line


def runs(
    scenes: list[str], seeds: int, noises: Iterable[float], churns: Iterable[float | None], cameras: Iterable[str | None]
) -> list[Run]:
    chosen = list(itertools.product(scenes, range(1, seeds + 1)))
    if seeds == SEEDS and EXTRA[0] in scenes:
        chosen.append(EXTRA)
    choices = itertools.product(noises, churns, cameras, chosen)
    return [Run(scene, seed, noise, churn, camera) for noise, churn, camera, (scene, seed) in choices]


def all_scenes(hopes: str) -> list[str]:
    """Those in the plane: the first block of the list."""
    block, _, _ = run([hopes, "scene", "--list"]).partition("\n\n")
    return [line.split()[0] for line in block.splitlines()]


def list_of(kind: Callable[[str], Any]) -> Any:
    def parse(text: str) -> list[Any]:
        try:
            return [kind(word) for word in text.split(",")]
        except ValueError:
            raise argparse.ArgumentTypeError(f"{text!r} is no list of {kind.__name__}") from None

    return parse


def selection(text: str) -> str:
    if text not in SELECTIONS:
        raise ValueError(text)
    return text


def positive(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is no positive number")
    return int(text)


def writable(text: str) -> Path:
    """Checks the arguments before the measurements start."""
    if not Path(text).absolute().parent.is_dir():
        raise argparse.ArgumentTypeError(f"{text!r} is in no existing folder")
    return Path(text).absolute()


def arguments(words: list[str] | None = None) -> argparse.Namespace:
    description, _, example = (__doc__ or "").rstrip().rpartition("\n\n")
    parser = argparse.ArgumentParser(
        description=description,
        epilog=f"examples:\n{example}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    option("--scenes", type=list_of(str), help="names of scenes (default: all that hopes scene --list has)")
    option("--seeds", type=positive, help=f"runs of each scene (default: {SEEDS}, and one more of {EXTRA[0]})")
    option("--noises", type=list_of(float), help="shares of the radius (default: 0,0.05,0.1,0.2,0.3)")
    option("--frames", type=positive, help="frames of a run (default: that of hopes scene)")
    option("--points-per-radius", type=positive, help="density (default: that of hopes scene)")
    option("--churns", type=list_of(float), help="shares of the points that are new in a frame (default: that of hopes scene)")
    option("--cameras", type=list_of(str), help="such as none,pan:1,shake:0.5 (default: none)")
    option("--selections", type=list_of(selection), help="of above, top and view (default: above)")
    option("--clutter", type=float, help="stray points for each point of a wall (default: none)")
    option("--clumps", action="store_true", help="stray points come in clumps")
    option("--declutter", nargs="?", const="", metavar="K:R", help="serve's --declutter")
    option("--confirm", type=positive, help="serve's --track-confirm (default: that of hopes serve)")
    option("--miss", type=positive, help="serve's --track-miss (default: that of hopes serve)")
    option("--wide", action="store_true", help="all selections, two churns, some cameras; one seed unless --seeds is given")
    option("--quick", action="store_true", help="a few short runs")
    option("--require", action="store_true", help="fail where the bounds are not met")
    option("--csv", type=writable, metavar="FILE", help="write all counts of every run to FILE")
    option("--jobs", type=positive, default=2, help="runs at a time (default: %(default)s)")
    option("--hopes", metavar="FILE", help="the program (default: build it)")
    return parser.parse_args(words)


def chosen_runs(options: argparse.Namespace, hopes: str) -> list[Run]:
    quick: dict[str, Any] = QUICK if options.quick else {}
    wide: dict[str, Any] = WIDE if options.wide else {}
    scenes = options.scenes or quick.get("scenes") or all_scenes(hopes)
    noises = options.noises or quick.get("noises") or NOISES
    seeds = options.seeds or quick.get("seeds") or wide.get("seeds") or SEEDS
    churns = options.churns or wide.get("churns") or [None]
    cameras = [None if name == "none" else name for name in options.cameras or ["none"]]
    chosen = runs(scenes, seeds, noises, churns, cameras)
    if options.wide and not options.cameras:
        moving = [scene for scene in scenes if scene in CAMERA_SCENES]
        chosen += runs(moving, 1, [noise for noise in noises if noise == CALM], churns[:1], CAMERAS)
    return chosen


def contest(options: argparse.Namespace) -> int:
    if not options.hopes:
        say("building hopes")
        run(["cargo", "build", "--release", "--locked"])
    hopes = str(Path(options.hopes).absolute()) if options.hopes else str(HOPES)
    frames = options.frames or (QUICK["frames"] if options.quick else None)
    selections = tuple(options.selections or (WIDE["selections"] if options.wide else ["above"]))
    density, clutter = options.points_per_radius, (options.clutter, options.clumps, options.declutter)
    settings = Settings(hopes, frames, density, *clutter, options.confirm, options.miss, selections)
    chosen = chosen_runs(options, hopes)
    results: list[Result] = []
    with ProcessPoolExecutor(options.jobs) as pool:
        waiting = [pool.submit(evaluate, settings, each) for each in chosen]
        try:
            for number, future in enumerate(waiting, start=1):
                for result in future.result():
                    results.append(result)
                    ours, rival = result.score.ours, result.score.rival
                    found = f"IDF1 {ours.idf1:.4f}, switches {ours.switches}, rival {rival.idf1:.4f}"
                    say(f"{number} of {len(chosen)}: {result}: {found}")
        finally:
            pool.shutdown(cancel_futures=True)
    print(tables(results), end="")
    if options.csv:
        write_csv(options.csv, results)
    is_met = bounds_are_met(settings, [result for result in results if result.is_bound])
    return 1 if options.require and not is_met else 0


def bounds_are_met(settings: Settings, results: list[Result]) -> bool:
    """Says which are not."""
    share = share_of_good(results)
    are_few = bool(results) and share < GOOD_SHARE
    is_met = not are_few
    for result in results:
        complaints = list(dict.fromkeys(result.complaints() + (result.faults() if are_few else [])))
        is_met = is_met and not complaints
        for what in complaints:
            command = " ".join(scene_command(settings, result.run, "POINTS", "TRUTH"))
            say(f"BOUND NOT MET {result}: {what} ({command})")
    if are_few:
        say(f"BOUND NOT MET {share:.3f} of {len(results)} runs have an IDF1 of {GOOD_IDF1} and no switch: not {GOOD_SHARE}")
    return is_met


def main() -> int:
    options = arguments()
    try:
        enter_venv()
        return contest(options)
    except Missing as reason:
        say(f"evaluate.py: {reason}")
        return 2


if __name__ == "__main__":
    sys.exit(main())
