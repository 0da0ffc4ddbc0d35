#!/usr/bin/env python3
"""Compares hopes with other programs for Vietoris-Rips skeletons on the same clouds, and checks that all dots agree.

Contenders, each in a fresh process, on one thread. They take turns round by round, so that a busy machine slows all of
them alike:

    ours      the process `hopes compute FILE --metric euclidean --format dots`, from reading points (NPY) to writing
              dots; of a matrix `--metric matrix`, from Ripser's binary form
    ripser    ripser_pass.cpp: the C++ code of Ripser that PyPI's `ripser` ships, over Z/2, from the same binary form
    pypi      PyPI's `ripser` as it is: its call alone, on a matrix of distances that is in memory (--with pypi)
    giotto    giotto-ph (PyPI): its call alone, on the same matrix, without the collapse of edges
    gudhi     GUDHI's Rips complex (PyPI): its calls alone, with its collapse of edges (--with gudhi)

Times are processor time, medians of the rounds: of whole processes for `ours` and `ripser`, and of calls for the
others. Memory is the peak of whole processes, and for the others what the call adds to Python, its libraries and the
matrix. Both favour the others. RedZeD has no package, so it does not compete. For `ours` and `ripser` the system counts
no less memory than this script's own (about 20 MiB).

Clouds are seeded. Distances for the others are floats of four bytes, as Ripser keeps them.

In: this repository, a Rust toolchain, g++, Python with venv, Linux. The rest is made under target/rips on first use.

Out: a Markdown table on standard output, progress on standard error. Scales of hopes are radii, those of the others
twice that. Dots agree if they are the same multisets up to 2e-5 of their scales; a dot with less persistence than 1e-5
of its death is dropped on both sides.

Exit code: 0 all agree, 1 some disagree or, with --require, a target is missed; 2 something is missing or failed.

    python3 benches/rips.py --quick
"""

from __future__ import annotations

import argparse
import bisect
import csv
import json
import math
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from peers import BENCHES, MIB, ROOT, Missing, markdown, positive, run, say
from rips_clouds import CLOUDS, QUICK, WORK, Cloud, write_cloud

VENV_PYTHON = WORK / "venv" / "bin" / "python"
HOPES = ROOT / "target" / "release" / "hopes"
RIPSER_SOURCE = BENCHES / "ripser_pass.cpp"
RIPSER = WORK / "ripser_pass"
PACKAGES = ("numpy", "scipy", "ripser", "giotto-ph", "gudhi")

TOLERANCE = 2e-5
ON_DIAGONAL = 1e-5

Dots = list[tuple[float, float]]

# What is promised: Ripser's time over ours, and megabytes.
LEAST_RATIO = 5
HARD = {("circle", 1000), ("trefoil", 1000), ("torus", 2000), ("hops", 1000), ("hamming:16", 1000)}
LEAST_OF_HARD = 50
MOST_MEMORY = {2000: 64, 16000: 200}


# Contenders: tasks in the virtual environment


def by_pypi(square: Any) -> Any:
    import ripser

    return lambda: ripser.ripser(square, maxdim=1, distance_matrix=True)["dgms"][1]


def by_giotto(square: Any) -> Any:
    import gph

    return lambda: gph.ripser_parallel(square, metric="precomputed", maxdim=1, n_threads=1)["dgms"][1]


def by_gudhi(square: Any) -> Any:
    import gudhi

    def dots() -> Any:
        tree = gudhi.RipsComplex(distance_matrix=square).create_simplex_tree(max_dimension=1)
        tree.collapse_edges()
        tree.expansion(2)
        tree.compute_persistence(homology_coeff_field=2, min_persistence=0)
        return tree.persistence_intervals_in_dimension(1)

    return dots


CALLS = {"pypi": by_pypi, "giotto": by_giotto, "gudhi": by_gudhi}
RIVALS = ("ripser", *CALLS)


def memory(key: str) -> int:
    """What the system says of this process: VmRSS, now, or VmHWM, at most."""
    status = Path("/proc/self/status").read_text()
    line = next(line for line in status.splitlines() if line.startswith(key))
    return int(line.split()[1]) * 1024


def call(name: str, file: str) -> None:
    """Prints what one call took, and its dots as radii."""
    import numpy as np

    dots_of = CALLS[name](np.load(file))
    Path("/proc/self/clear_refs").write_text("5")  # the peak begins anew
    before = memory("VmRSS")
    start = time.process_time()
    dots = dots_of()
    seconds = time.process_time() - start
    added = max(0, memory("VmHWM") - before)
    halves = [[float(birth) / 2, float(death) / 2] for birth, death in dots]
    print(json.dumps({"seconds": seconds, "peak_bytes": added, "dots": halves}))


# Measuring


@dataclass
class Measured:
    """One contender on one cloud."""

    seconds: list[float] = field(default_factory=list)
    peak_bytes: int = 0
    dots: Dots = field(default_factory=list)


def measure_process(measured: Measured, *command: str | Path) -> str:
    """Runs a command on one thread. Returns what it prints."""
    environment = {**os.environ, "RAYON_NUM_THREADS": "1"}
    out, err = subprocess.PIPE, subprocess.DEVNULL
    with subprocess.Popen(command, env=environment, stdout=out, stderr=err, text=True) as child:
        printed = child.stdout.read() if child.stdout else ""
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        raise Missing(f"{' '.join(map(str, command))} failed with exit code {child.returncode}")
    measured.seconds.append(usage.ru_utime + usage.ru_stime)
    measured.peak_bytes = max(measured.peak_bytes, usage.ru_maxrss * 1024)
    return printed


def measure_ours(measured: Measured, cloud: Cloud) -> None:
    metric = "matrix" if cloud.is_matrix else "euclidean"
    table = measure_process(measured, HOPES, "compute", cloud.ours, "--metric", metric, "--format", "dots")
    rows = csv.DictReader(table.splitlines())
    measured.dots = [(float(row["birth"]), float(row["death"] or "inf")) for row in rows]


def measure_ripser(measured: Measured, cloud: Cloud) -> None:
    dots = json.loads(measure_process(measured, RIPSER, cloud.lower))
    measured.dots = [(birth / 2, death / 2) for birth, death in dots]


def measure_call(measured: Measured, name: str, cloud: Cloud) -> None:
    answer = json.loads(run(VENV_PYTHON, __file__, "--task", "call", name, cloud.square))
    measured.seconds.append(answer["seconds"])
    measured.peak_bytes = max(measured.peak_bytes, answer["peak_bytes"])
    measured.dots = [(birth, death) for birth, death in answer["dots"]]


def measure(name: str, measured: Measured, cloud: Cloud) -> None:
    match name:
        case "ours":
            measure_ours(measured, cloud)
        case "ripser":
            measure_ripser(measured, cloud)
        case _:
            measure_call(measured, name, cloud)


def compare(cloud: Cloud, names: Iterable[str], rounds: int) -> dict[str, Measured]:
    contenders = {name: Measured() for name in names if name == "ours" or not cloud.is_alone}
    for number in range(1, rounds + 1):
        for name, measured in contenders.items():
            measure(name, measured, cloud)
            say(f"{cloud.name} round {number}: {name} {measured.seconds[-1]:.3g} s")
    return contenders


# Agreement


def clear(dots: Dots) -> Dots:
    return sorted((birth, death) for birth, death in dots if death - birth > ON_DIAGONAL * death)


def near(one: float, other: float) -> bool:
    return one == other or abs(one - other) <= TOLERANCE * max(abs(one), abs(other))


def disagreement(ours: Dots, theirs: Dots) -> str | None:
    """What is wrong if these are not the same multisets: each of ours takes the nearest of theirs that is left."""
    left = clear(theirs)
    for birth, death in clear(ours):
        first = bisect.bisect_left(left, (birth * (1 - 2 * TOLERANCE), -math.inf))
        last = bisect.bisect_right(left, (birth * (1 + 2 * TOLERANCE), math.inf))
        fitting = [dot for dot in left[first:last] if near(dot[0], birth) and near(dot[1], death)]
        if not fitting:
            return f"they have no dot ({birth!r}, {death!r})"
        distance = lambda dot: abs(dot[0] - birth) + (abs(dot[1] - death) if math.isfinite(death) else 0)
        left.remove(min(fitting, key=distance))
    return f"we have no dot {left[0]!r}" if left else None


def missed(cloud: Cloud, contenders: dict[str, Measured]) -> Iterator[str]:
    """The targets that are missed."""
    ours = contenders["ours"]
    most = MOST_MEMORY.get(cloud.points)
    if most and ours.peak_bytes > most * MIB:
        yield f"{ours.peak_bytes / MIB:.0f} MB instead of {most}"
    if cloud.points >= 500 and "ripser" in contenders:
        least = LEAST_OF_HARD if (cloud.shape, cloud.points) in HARD else LEAST_RATIO
        found = ratio(contenders)
        if found < least:
            yield f"{found:.1f} times as fast as Ripser instead of {least}"


# Reporting


def ratio(contenders: dict[str, Measured]) -> float:
    ours = max(statistics.median(contenders["ours"].seconds), 0.001)  # the clock of the system is no finer
    return statistics.median(contenders["ripser"].seconds) / ours


def columns(cloud: Cloud, contenders: dict[str, Measured]) -> dict[str, str]:
    row = {"cloud": cloud.shape, "points": f"{cloud.points:,}", "dots": f"{len(clear(contenders['ours'].dots)):,}"}
    for name in ("ours", *RIVALS):
        measured = contenders.get(name)
        cell = f"{statistics.median(measured.seconds):.3g} ({measured.peak_bytes / MIB:.0f})" if measured else ""
        row[f"{name}, s (MiB)"] = cell
    row["ripser / ours"] = f"{ratio(contenders):.0f}" if "ripser" in contenders else ""
    return row


# Command line


def ensure_rivals() -> None:
    if not VENV_PYTHON.exists():
        say("making a virtual environment")
        run(sys.executable, "-m", "venv", VENV_PYTHON.parent.parent)
    imports = "import gph, gudhi, numpy, ripser, scipy"
    if subprocess.run([VENV_PYTHON, "-c", imports], stderr=subprocess.DEVNULL).returncode:
        say(f"installing {', '.join(PACKAGES)}")
        run(VENV_PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *PACKAGES)


def ensure_ripser() -> None:
    if RIPSER.exists() and RIPSER.stat().st_mtime > RIPSER_SOURCE.stat().st_mtime:
        return
    say("compiling ripser_pass.cpp")
    where = "import ripser, pathlib; print(pathlib.Path(ripser.__file__).parent)"
    folder = run(VENV_PYTHON, "-c", where).strip()
    run("g++", "-std=c++17", "-O3", "-march=native", "-DNDEBUG", "-I", folder, RIPSER_SOURCE, "-o", RIPSER)


def ensure_cloud(cloud: Cloud) -> None:
    files = [cloud.ours] if cloud.is_alone else [cloud.ours, cloud.lower, cloud.square]
    if not all(file.exists() for file in files):
        say(f"making {cloud.name}")
        run(VENV_PYTHON, __file__, "--task", "cloud", cloud.shape, str(cloud.points))


def clouds(text: str) -> list[Cloud]:
    chosen = [cloud for cloud in CLOUDS if {cloud.name, cloud.shape} & set(text.split(","))]
    if not chosen:
        raise argparse.ArgumentTypeError(f"{text!r} names none of {', '.join(cloud.name for cloud in CLOUDS)}")
    return chosen


def rivals(text: str) -> list[str]:
    chosen = text.split(",")
    for name in chosen:
        if name not in RIVALS:
            raise argparse.ArgumentTypeError(f"{name!r} is none of {', '.join(RIVALS)}")
    return chosen


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False
    )
    option = parser.add_argument
    option("--quick", action="store_true", help="a few small clouds")
    option("--clouds", type=clouds, default=list(CLOUDS), help="names such as torus-2000, or shapes such as cube:3")
    option("--with", dest="rivals", type=rivals, default=["ripser", "giotto"], help=f"of {', '.join(RIVALS)}")
    option("--rounds", type=positive, default=3, help="processes of each contender (default: %(default)s)")
    option("--require", action="store_true", help="fail if a target of time or memory is missed")
    option("--no-build", action="store_true", help="take our program as it is")
    return parser.parse_args()


def contest(options: argparse.Namespace) -> int:
    ensure_rivals()
    if "ripser" in options.rivals:
        ensure_ripser()
    if not options.no_build:
        run("cargo", "build", "--release", "--bin", "hopes")
    rows, wrong = [], []
    for cloud in QUICK if options.quick else options.clouds:
        ensure_cloud(cloud)
        contenders = compare(cloud, ("ours", *options.rivals), options.rounds)
        for name, measured in contenders.items():
            difference = disagreement(contenders["ours"].dots, measured.dots)
            wrong += [f"DISAGREEMENT {cloud.name}, {name}: {difference}"] if difference else []
        if options.require:
            wrong += [f"MISSED {cloud.name}: {target}" for target in missed(cloud, contenders)]
        rows.append(columns(cloud, contenders))
    print(markdown(rows))
    for reason in wrong:
        say(reason)
    return 1 if wrong else 0


TASKS: dict[str, Callable[..., None]] = {
    "cloud": lambda shape, points: write_cloud(Cloud(shape, int(points))),
    "call": call,
}


def main() -> int:
    if sys.argv[1:2] == ["--task"]:
        TASKS[sys.argv[2]](*sys.argv[3:])
        return 0
    try:
        return contest(arguments())
    except Missing as reason:
        say(f"rips.py: {reason}")
        return 2


if __name__ == "__main__":
    sys.exit(main())
