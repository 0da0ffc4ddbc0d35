#!/usr/bin/env python3
"""Measures how well hopes tracks holes, against the ground truth of seeded scenes and beside a baseline.

Each run is a scene with a seed and a noise: `hopes scene` makes its points and its truth, `hopes serve --track above:P`
follows them (P is in the truth), and scoring.py counts how often a true hole kept its id, and whether each true split
and merger was reported once and within three frames. The baseline carries ids along
by matching the persistence diagrams of the same frames (dots above P) alone.

In: this repository, a Rust toolchain and Python 3.11. Everything else (requirements.txt, in a virtual environment) is
installed under benches/.tracks/ on first use.

Out: a Markdown table for each noise on standard output, one row for each scene over all its seeds; progress on standard
error; with --csv a row for each run. A switch is a true hole that continues with another id. `in time` are the true
splits and mergers that were reported within three frames, `false` the reports without a true event, or of one that was
reported before.

Exit code: 0 done, 1 a bound of --require is not met, 2 something is missing or failed. The bounds, for every run with
at least 12 points per radius and a noise of at most 0.1: IDF1 at least 0.99, no switch, every split and merger in time.

    python3 benches/tracks/evaluate.py --quick
    python3 benches/tracks/evaluate.py --require --csv tracks.csv
"""

from __future__ import annotations

import argparse
import csv
import itertools
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from scoring import Reported, Score, Tracks

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
VENV = HERE.parent / ".tracks" / "venv"
VENV_PYTHON = VENV / "bin" / "python"
REQUIREMENTS = HERE / "requirements.txt"
HOPES = ROOT / "target" / "release" / "hopes"

SEEDS = 3
EXTRA = ("mixed", SEEDS + 1)  # one more run: with it, 13 scenes make 40
NOISES = (0.0, 0.05, 0.1, 0.2, 0.3)
QUICK = {"scenes": ["drift", "pinch", "fuse", "occlusion"], "noises": [0.0, 0.1], "seeds": 1, "frames": 120}

# Runs to which --require applies its bounds
DENSE = 12
CALM = 0.1
LEAST_IDF1 = 0.99


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

    def __str__(self) -> str:
        return f"{self.scene} seed {self.seed} noise {self.noise:g}"


@dataclass(frozen=True)
class Settings:
    """The settings of all runs. For None the default of hopes is used."""

    hopes: str
    frames: int | None = None
    points_per_radius: int | None = None
    churn: float | None = None
    confirm: int | None = None
    miss: int | None = None

    def options(self) -> list[str]:
        """Of the scene."""
        return given({"--frames": self.frames, "--points-per-radius": self.points_per_radius, "--churn": self.churn})

    def patience(self) -> list[str]:
        """Of the tracker."""
        return given({"--track-confirm": self.confirm, "--track-miss": self.miss})


def given(wanted: dict[str, float | None]) -> list[str]:
    return [word for key, value in wanted.items() if value is not None for word in (key, str(value))]


@dataclass
class Result:
    run: Run
    points_per_radius: float
    score: Score

    def complaints(self) -> list[str]:
        """The bounds of --require that are not met."""
        if self.points_per_radius < DENSE or self.run.noise > CALM:
            return []
        ours = self.score.ours
        found = []
        if ours.idf1 < LEAST_IDF1:
            found.append(f"IDF1 is {ours.idf1:.4f}")
        if ours.switches:
            found.append(f"switches: {ours.switches}")
        for name, kind in (("splits", self.score.splits), ("mergers", self.score.mergers)):
            if kind.in_time < kind.true:
                found.append(f"{name} in time: {kind.in_time} of {kind.true}")
        return found


def scene_command(settings: Settings, run: Run, points: str, truth: str) -> list[str]:
    chosen = [run.scene, "--seed", str(run.seed), "--noise", str(run.noise), *settings.options()]
    return [settings.hopes, "scene", *chosen, "--truth", truth, "-o", points]


def evaluate(settings: Settings, this: Run) -> Result:
    """Runs in its own process."""
    import scoring

    with tempfile.TemporaryDirectory(prefix="hopes-tracks-") as folder:
        points, truth_file = Path(folder, "points.txt"), Path(folder, "truth.jsonl")
        run(scene_command(settings, this, str(points), str(truth_file)))
        with truth_file.open() as lines:
            truth = scoring.read_truth(lines)
        tracks = follow(settings, points, truth.above, *settings.patience())
        # Tracks of the dots of one frame only.
        dots = follow(settings, points, truth.above, "--track-confirm", "1", "--track-miss", "1")
    if tracks.alive.keys() != truth.holes.keys():
        raise Missing(f"{this}: {len(truth.holes)} frames are true, {len(tracks.alive)} were followed")
    return Result(this, truth.header["points_per_radius"], scoring.score(truth, tracks, dots))


def follow(settings: Settings, points: Path, above: float, *options: str) -> Tracks:
    import scoring

    command = [settings.hopes, "serve", "--window", "frames:1", "--track", f"above:{above!r}", "--track-list", *options]
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


# Reporting


def markdown(rows: list[dict[str, str]]) -> str:
    heads = list(rows[0])
    lines = [heads, ["---"] + ["---:"] * (len(heads) - 1), *([row[head] for head in heads] for row in rows)]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def row(name: str, score: Score) -> dict[str, str]:
    def in_time(kind: Reported) -> str:
        return f"{kind.in_time} / {kind.true}"

    return {
        "scene": name,
        "IDF1": f"{score.ours.idf1:.4f}",
        "MOTA": f"{score.ours.mota:.4f}",
        "switches / 1,000 frames": f"{score.ours.switches_per_1000:.2f}",
        "splits in time": in_time(score.splits),
        "mergers in time": in_time(score.mergers),
        "false": str(score.splits.false + score.mergers.false),
        "rival: IDF1": f"{score.rival.idf1:.4f}",
        "rival: switches / 1,000 frames": f"{score.rival.switches_per_1000:.2f}",
    }


def total(results: Iterable[Result]) -> Score:
    first, *rest = (result.score for result in results)
    return sum(rest, start=first)


def tables(results: list[Result]) -> str:
    parts = []
    for noise in sorted({result.run.noise for result in results}):
        of_noise = [result for result in results if result.run.noise == noise]
        names = list(dict.fromkeys(result.run.scene for result in of_noise))
        rows = [row(name, total(result for result in of_noise if result.run.scene == name)) for name in names]
        rows.append(row("**all**", total(of_noise)))
        parts.append(f"Noise {noise:g} of the radius, {len(of_noise)} runs:\n\n{markdown(rows)}\n")
    return "\n".join(parts)


def flat(result: Result) -> dict[str, Any]:
    """A row of the CSV."""
    score = result.score
    cells: dict[str, Any] = {**asdict(result.run), "points_per_radius": result.points_per_radius}
    for who, identity in (("", score.ours), ("rival_", score.rival)):
        cells |= {f"{who}idf1": f"{identity.idf1:.6f}", f"{who}mota": f"{identity.mota:.6f}"}
        cells |= {f"{who}{name}": value for name, value in asdict(identity).items()}
    for name, kind in (("splits", score.splits), ("mergers", score.mergers)):
        cells |= {f"{name}_{each}": value for each, value in asdict(kind).items()}
    return cells


def write_csv(path: Path, results: list[Result]) -> None:
    rows = [flat(result) for result in results]
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


# Command line


def runs(scenes: list[str], seeds: int, noises: Iterable[float]) -> list[Run]:
    chosen = list(itertools.product(scenes, range(1, seeds + 1)))
    if seeds == SEEDS and EXTRA[0] in scenes:
        chosen.append(EXTRA)
    return [Run(scene, seed, noise) for noise in noises for scene, seed in chosen]


def all_scenes(hopes: str) -> list[str]:
    """Those in the plane: the first block of the list."""
    block, _, _ = run([hopes, "scene", "--list"]).partition("\n\n")
    return [line.split()[0] for line in block.splitlines()]


def list_of(kind: type) -> Any:
    def parse(text: str) -> list[Any]:
        try:
            return [kind(word) for word in text.split(",")]
        except ValueError:
            raise argparse.ArgumentTypeError(f"{text!r} is no list such as 0,0.1") from None

    return parse


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
    option("--churn", type=float, help="share of the points that is new in a frame (default: that of hopes scene)")
    option("--confirm", type=positive, help="serve's --track-confirm (default: that of hopes serve)")
    option("--miss", type=positive, help="serve's --track-miss (default: that of hopes serve)")
    option("--quick", action="store_true", help="a few short runs")
    option("--require", action="store_true", help="fail where the bounds are not met")
    option("--csv", type=writable, metavar="FILE", help="write all counts of every run to FILE")
    option("--jobs", type=positive, default=2, help="runs at a time (default: %(default)s)")
    option("--hopes", metavar="FILE", help="the program (default: build it)")
    return parser.parse_args(words)


def chosen_runs(options: argparse.Namespace, hopes: str) -> list[Run]:
    quick: dict[str, Any] = QUICK if options.quick else {}
    scenes = options.scenes or quick.get("scenes") or all_scenes(hopes)
    noises = options.noises or quick.get("noises") or NOISES
    return runs(scenes, options.seeds or quick.get("seeds") or SEEDS, noises)


def contest(options: argparse.Namespace) -> int:
    if not options.hopes:
        say("building hopes")
        run(["cargo", "build", "--release", "--locked"])
    hopes = str(Path(options.hopes).absolute()) if options.hopes else str(HOPES)
    frames = options.frames or (QUICK["frames"] if options.quick else None)
    settings = Settings(hopes, frames, options.points_per_radius, options.churn, options.confirm, options.miss)
    chosen = chosen_runs(options, hopes)
    results: list[Result] = []
    with ProcessPoolExecutor(options.jobs) as pool:
        waiting = [pool.submit(evaluate, settings, each) for each in chosen]
        try:
            for number, future in enumerate(waiting, start=1):
                result = future.result()
                results.append(result)
                ours, rival = result.score.ours, result.score.rival
                say(f"{number} of {len(chosen)}: {result.run}: IDF1 {ours.idf1:.4f}, rival {rival.idf1:.4f}")
        finally:
            pool.shutdown(cancel_futures=True)
    print(tables(results), end="")
    if options.csv:
        write_csv(options.csv, results)
    complaints = [(result, what) for result in results for what in result.complaints()]
    for result, what in complaints:
        command = " ".join(scene_command(settings, result.run, "POINTS", "TRUTH"))
        say(f"BOUND NOT MET {result.run}: {what} ({command})")
    return 1 if options.require and complaints else 0


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
