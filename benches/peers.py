#!/usr/bin/env python3
"""Compares hopes with other programs on the same clouds in the same run, and checks that all of them agree.

Contenders, each in a fresh process. They take turns round by round, so that a busy machine slows all of them alike:

    gudhi     GUDHI's alpha complex (precision 'fast') and persistence over Z/2, from a NumPy array in memory
    dual      cgal_pass.cpp --plain, C++ on CGAL's triangulation: sort all edges, one dual union-find (--cgal)
    cgal      cgal_pass.cpp, the same with our contraction and a radix sort: the strongest rival (--cgal)
    library   the example library_pass: points in memory -> dots, MST and skeletons, one thread
    compute   the process `hopes compute FILE.csv -o OUT.json`, from reading the text to writing the answer

Clouds are seeded, so they are the same on every machine: `uniform` in the unit square, `circle` (radius 1, radial noise
of up to 0.1) and `pixel` (a random quarter of the positions of a square integer grid, full of cocircular points).

In: this repository, a Rust toolchain and, for `dual` and `cgal`, g++. Everything else (a virtual environment with gudhi
and numpy, the CGAL headers where apt-get may install them, clouds as CSV and binary files) is made under
benches/.peers/ on first use.

Out: a Markdown table on standard output, progress on standard error, and with --json all measurements. Times are
medians of the rounds with their range. Contenders agree if the number of dots whose persistence exceeds 1e-9 of their
death is the same and the sum of persistence and the MST length are within 1e-6. Peaks are of resident memory; for
`compute` the system counts no less than this script's own (about 15 MiB).

Exit code: 0 all agree, 1 some disagree, 2 something is missing or failed.

    python3 benches/peers.py --cgal --sizes 1e4,1e5 --json peers.json
"""

from __future__ import annotations

import argparse
import array
import itertools
import json
import math
import os
import platform
import random
import resource
import shutil
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

BENCHES = Path(__file__).resolve().parent
ROOT = BENCHES.parent
WORK = BENCHES / ".peers"
CLOUDS = WORK / "clouds"
VENV_PYTHON = WORK / "venv" / "bin" / "python"
CGAL_SOURCE = BENCHES / "cgal_pass.cpp"
CGAL_PASS = WORK / "cgal_pass"
RELEASE = ROOT / "target" / "release"

CONTENDERS = ("gudhi", "dual", "cgal", "library", "compute")
PIXEL_DENSITY = 0.25
RADIAL_NOISE = 0.1
CLEAR = 1e-9  # a dot with more persistence than this part of its death is beyond anyone's rounding
ON_DIAGONAL = 1e-12  # and one with less than this is rounding by hopes' own definition
TOLERANCE = 1e-6
MIB = 1 << 20

ANSWER_KEYS = ("dots", "clear_dots", "persistence_sum", "mst_length")

Point = tuple[float, float]
Answer = dict[str, float]


class Missing(Exception):
    """A prerequisite of this comparison is missing or failed."""


# Clouds


@dataclass(frozen=True)
class Cloud:
    kind: str
    points: int

    @property
    def name(self) -> str:
        return f"{self.kind}-{self.points}"

    @property
    def csv(self) -> Path:
        return CLOUDS / f"{self.name}.csv"

    @property
    def binary(self) -> Path:
        return CLOUDS / f"{self.name}.f64"


def uniform(chance: random.Random, count: int) -> Iterator[Point]:
    return ((chance.random(), chance.random()) for _ in range(count))


def circle(chance: random.Random, count: int) -> Iterator[Point]:
    for _ in range(count):
        radius = 1 + chance.uniform(-RADIAL_NOISE, RADIAL_NOISE)
        angle = chance.uniform(0, math.tau)
        yield radius * math.cos(angle), radius * math.sin(angle)


def pixel(chance: random.Random, count: int) -> Iterator[Point]:
    side = math.ceil(math.sqrt(count / PIXEL_DENSITY))
    for position in chance.sample(range(side * side), count):
        yield float(position % side), float(position // side)


GENERATORS: dict[str, Callable[[random.Random, int], Iterator[Point]]] = {
    "uniform": uniform,
    "circle": circle,
    "pixel": pixel,
}


def write_cloud(cloud: Cloud) -> None:
    points = list(GENERATORS[cloud.kind](random.Random(cloud.name), cloud.points))
    flat = array.array("d", (coordinate for point in points for coordinate in point))
    if sys.byteorder == "big":
        flat.byteswap()
    CLOUDS.mkdir(parents=True, exist_ok=True)
    cloud.csv.write_text("".join(f"{x!r},{y!r}\n" for x, y in points))
    cloud.binary.write_bytes(flat.tobytes())  # last: its presence says that both are complete


# Answers: the results of a contender, as numbers that can be compared


def summary(births: Iterable[float], deaths: Iterable[float], mst_length: float) -> Answer:
    dots = [(death - birth, death) for birth, death in zip(births, deaths, strict=True)]
    dots = [(persistence, death) for persistence, death in dots if persistence > ON_DIAGONAL * death]
    return {
        "dots": len(dots),
        "clear_dots": sum(persistence > CLEAR * death for persistence, death in dots),
        "persistence_sum": math.fsum(persistence for persistence, _ in dots),
        "mst_length": mst_length,
    }


def gudhi_pass(file: str, repeat: int) -> dict[str, Any]:
    """Runs in the virtual environment. GUDHI's filtration values are squared radii."""
    import gudhi
    import numpy

    points = numpy.fromfile(file, dtype="<f8").reshape(-1, 2)
    total, triangulation = [], []
    tree: Any = None
    for _ in range(repeat):
        tree = None  # before the next pass, or the peak would count it twice
        start = time.perf_counter()
        alpha = gudhi.AlphaComplex(points=points, precision="fast")
        triangulated = time.perf_counter()
        tree = alpha.create_simplex_tree()
        tree.compute_persistence(homology_coeff_field=2, min_persistence=0)
        total.append(time.perf_counter() - start)
        triangulation.append(triangulated - start)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024

    births, deaths = numpy.sqrt(tree.persistence_intervals_in_dimension(1)).reshape(-1, 2).T
    merges = tree.persistence_intervals_in_dimension(0)[:, 1]
    mst_length = float(2 * numpy.sqrt(merges[numpy.isfinite(merges)]).sum())
    return {
        **summary(births.tolist(), deaths.tolist(), mst_length),
        "version": gudhi.__version__,
        "seconds": total,
        "triangulation_seconds": triangulation,
        "peak_rss_bytes": peak,
    }


def read_compute_answer(file: str) -> Answer:
    answer = json.loads(Path(file).read_text())
    dots = answer["dots"]
    return summary((dot["birth"] for dot in dots), (dot["death"] for dot in dots), answer["mst"]["length"])


def compared(one: Answer, other: Answer) -> Iterator[tuple[str, float]]:
    """The keys by which two answers are compared, with their relative tolerances. Not every answer has all keys.

    `dots` counts only if one side does not have the count of clear dots, since dots close to the diagonal depend on
    rounding.
    """
    shared = one.keys() & other.keys()
    yield ("clear_dots" if "clear_dots" in shared else "dots"), 0
    yield from ((key, TOLERANCE) for key in ("persistence_sum", "mst_length") if key in shared)


def disagreements(answers: dict[str, Answer]) -> list[str]:
    return [
        f"{key}: {name} {one[key]!r}, {other_name} {other[key]!r}"
        for (name, one), (other_name, other) in itertools.combinations(answers.items(), 2)
        for key, tolerance in compared(one, other)
        if not math.isclose(one[key], other[key], rel_tol=tolerance)
    ]


# Tools


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def run(*command: str | Path) -> str:
    """The standard output of a command that must succeed."""
    line = [str(part) for part in command]
    try:
        return subprocess.run(line, cwd=ROOT, check=True, text=True, stdout=subprocess.PIPE).stdout
    except FileNotFoundError:
        raise Missing(f"{command[0]} is not installed") from None
    except subprocess.CalledProcessError as error:
        raise Missing(f"{' '.join(error.cmd)} failed with exit code {error.returncode}") from None


def work(task: str, *arguments: str, python: str | Path = sys.executable) -> str:
    """Runs a task of `TASKS` in its own process. This one must stay small, since a child's peak starts from ours."""
    return run(python, __file__, "--task", task, *arguments)


def ensure_gudhi() -> None:
    if not VENV_PYTHON.exists():
        say("making a virtual environment")
        run(sys.executable, "-m", "venv", VENV_PYTHON.parent.parent)
    imported = subprocess.run([VENV_PYTHON, "-c", "import gudhi, numpy"], stderr=subprocess.DEVNULL)
    if imported.returncode:
        say("installing gudhi and numpy")
        run(VENV_PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "gudhi", "numpy")


def has_cgal() -> bool:
    include = "#include <CGAL/Delaunay_triangulation_2.h>"
    command = ["g++", "-std=c++17", "-E", "-x", "c++", "-", "-o", os.devnull]
    return subprocess.run(command, input=include, text=True, stderr=subprocess.DEVNULL).returncode == 0


def ensure_cgal() -> None:
    if not shutil.which("g++"):
        raise Missing("g++ is not installed")
    if not has_cgal():
        if os.geteuid() != 0 or not shutil.which("apt-get"):
            raise Missing("the CGAL headers are not installed (Debian: apt-get install libcgal-dev)")
        say("installing libcgal-dev")
        run("apt-get", "install", "-y", "-qq", "libcgal-dev")
    if CGAL_PASS.exists() and CGAL_PASS.stat().st_mtime > CGAL_SOURCE.stat().st_mtime:
        return
    say("compiling cgal_pass.cpp")
    WORK.mkdir(parents=True, exist_ok=True)
    flags = ("-std=c++17", "-O3", "-march=native", "-DNDEBUG")
    run("g++", *flags, CGAL_SOURCE, "-o", CGAL_PASS, "-lgmp", "-lmpfr")


def ensure_ours(build: bool, names: list[str]) -> None:
    binaries = {"library": RELEASE / "examples" / "library_pass", "compute": RELEASE / "hopes"}
    if build and "compute" in names:
        run("cargo", "build", "--release")
    if build and "library" in names:
        run("cargo", "build", "--release", "--example", "library_pass")
    for name in names:
        if name in binaries and not binaries[name].exists():
            raise Missing(f"{binaries[name]} is not built; run without --no-build")


def ensure_cloud(cloud: Cloud) -> None:
    if not cloud.binary.exists():
        say(f"making {cloud.name}")
        work("cloud", cloud.kind, str(cloud.points))


# Measuring


@dataclass
class Measured:
    """One contender on one cloud."""

    seconds: list[float] = field(default_factory=list)
    peak_bytes: list[int] = field(default_factory=list)
    phases: dict[str, list[float]] = field(default_factory=dict)
    answer: Answer = field(default_factory=dict)
    version: str | None = None


@dataclass
class Ended:
    output: str
    seconds: float
    peak_bytes: int


def launch(command: list[str]) -> Ended:
    start = time.perf_counter()
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as child:
        output = child.stdout.read() if child.stdout else ""
        _, status, usage = os.wait4(child.pid, 0)
        seconds = time.perf_counter() - start
        child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        raise Missing(f"{' '.join(command)} failed with exit code {child.returncode}")
    return Ended(output, seconds, usage.ru_maxrss * 1024)


def measure_pass(measured: Measured, command: list[str]) -> None:
    """A contender that measures its own time and prints one JSON line."""
    line = json.loads(launch(command).output)
    measured.seconds.append(statistics.median(line["seconds"]))
    measured.peak_bytes.append(line["peak_rss_bytes"])
    for phase in ("bulk_seconds", "triangulation_seconds", "rest_seconds"):
        if line.get(phase):
            measured.phases.setdefault(phase, []).append(statistics.median(line[phase]))
    measured.answer = {key: line[key] for key in ANSWER_KEYS if key in line}
    measured.version = line.get("version")


def measure_compute(measured: Measured, cloud: Cloud) -> None:
    answer = WORK / "answer.json"
    ended = launch([str(RELEASE / "hopes"), "compute", str(cloud.csv), "-o", str(answer)])
    measured.seconds.append(ended.seconds)
    measured.peak_bytes.append(ended.peak_bytes)
    if not measured.answer:  # the same program on the same file: reading a large answer once is enough
        measured.answer = json.loads(work("answer", str(answer)))
    answer.unlink()


def measure(name: str, measured: Measured, cloud: Cloud, repeat: int) -> None:
    on_file = [str(cloud.binary), "--repeat", str(repeat)]
    match name:
        case "gudhi":
            measure_pass(measured, [str(VENV_PYTHON), __file__, "--task", "gudhi", str(cloud.binary), str(repeat)])
        case "dual":
            measure_pass(measured, [str(CGAL_PASS), *on_file, "--plain"])
        case "cgal":
            measure_pass(measured, [str(CGAL_PASS), *on_file])
        case "library":
            measure_pass(measured, [str(RELEASE / "examples" / "library_pass"), *on_file])
        case "compute":
            measure_compute(measured, cloud)


def compare(cloud: Cloud, names: list[str], rounds: int, repeat: int) -> dict[str, Measured]:
    contenders = {name: Measured() for name in names}
    for number in range(1, rounds + 1):
        for name, measured in contenders.items():
            measure(name, measured, cloud, repeat)
            say(f"{cloud.name} round {number}: {name} {measured.seconds[-1]:.3g} s")
    return contenders


# Reporting


def spread(values: list[float]) -> str:
    return f"{statistics.median(values):.3g} ({min(values):.3g}-{max(values):.3g})"


def ratio(contenders: dict[str, Measured], rival: str, ours: str) -> str:
    if rival not in contenders or ours not in contenders:
        return ""
    return f"{statistics.median(contenders[rival].seconds) / statistics.median(contenders[ours].seconds):.2f}"


def rest_to_bulk(contenders: dict[str, Measured]) -> str:
    phases = contenders["library"].phases if "library" in contenders else {}
    if not {"rest_seconds", "bulk_seconds"} <= phases.keys():
        return ""
    return f"{statistics.median(phases['rest_seconds']) / statistics.median(phases['bulk_seconds']):.2f}"


def columns(cloud: Cloud, contenders: dict[str, Measured]) -> dict[str, str]:
    row = {"cloud": cloud.kind, "points": f"{cloud.points:,}"}
    row |= {f"{name}, s": spread(measured.seconds) for name, measured in contenders.items()}
    row["GUDHI / library"] = ratio(contenders, "gudhi", "library")
    row["GUDHI / compute"] = ratio(contenders, "gudhi", "compute")
    row["dual / library"] = ratio(contenders, "dual", "library")
    row["CGAL / library"] = ratio(contenders, "cgal", "library")
    row["GUDHI / CGAL"] = ratio(contenders, "gudhi", "cgal")
    row["rest / bulk"] = rest_to_bulk(contenders)
    row |= {f"{name}, MiB": f"{max(measured.peak_bytes) / MIB:.0f}" for name, measured in contenders.items()}
    return row


def markdown(rows: list[dict[str, str]]) -> str:
    kept = [name for name in rows[0] if any(row[name] for row in rows)]
    lines = [kept, ["---"] + ["---:"] * (len(kept) - 1), *([row[name] for name in kept] for row in rows)]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def record(cloud: Cloud, contenders: dict[str, Measured], found: list[str]) -> dict[str, Any]:
    measured = {name: asdict(each) for name, each in contenders.items()}
    return {**asdict(cloud), "disagreements": found, "contenders": measured}


def machine() -> dict[str, str | int | None]:
    return {"system": platform.platform(), "processor": processor(), "cores": os.cpu_count()}


def processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor())


# Command line

TASKS: dict[str, Callable[..., Any]] = {
    "cloud": lambda kind, points: write_cloud(Cloud(kind, int(points))),
    "gudhi": lambda file, repeat: print(json.dumps(gudhi_pass(file, int(repeat)))),
    "answer": lambda file: print(json.dumps(read_compute_answer(file))),
}


def names_from(known: Iterable[str]) -> Callable[[str], list[str]]:
    def parse(text: str) -> list[str]:
        chosen = text.split(",")
        for name in chosen:
            if name not in known:
                raise argparse.ArgumentTypeError(f"{name!r} is none of {', '.join(known)}")
        return chosen

    return parse


def sizes(text: str) -> list[int]:
    try:
        chosen = [int(float(size)) for size in text.split(",")]
    except (ValueError, OverflowError):
        raise argparse.ArgumentTypeError(f"{text!r} is no list of sizes such as 1e4,1e5") from None
    if min(chosen) < 3:
        raise argparse.ArgumentTypeError("a cloud needs three points")
    return chosen


def positive(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is no positive number")
    return int(text)


def writable(text: str) -> Path:
    """Checks the arguments before the measurements start."""
    if not Path(text).absolute().parent.is_dir():
        raise argparse.ArgumentTypeError(f"{text!r} is in no existing folder")
    return Path(text)


def arguments() -> argparse.Namespace:
    description, _, example = (__doc__ or "").rstrip().rpartition("\n\n")
    parser = argparse.ArgumentParser(
        description=description,
        epilog=f"example:\n{example}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    shown = "(default: %(default)s)"
    option("--sizes", type=sizes, default="1e4,1e5,1e6", help=f"points per cloud {shown}")
    option("--kinds", type=names_from(GENERATORS), default=",".join(GENERATORS), help=f"of clouds {shown}")
    option("--rounds", type=positive, default=3, help=f"fresh processes of each contender {shown}")
    option("--repeat", type=positive, default=1, help=f"passes per process, its median counts {shown}")
    option("--only", type=names_from(CONTENDERS), default="gudhi,library,compute", help=f"contenders {shown}")
    option("--cgal", action="store_true", help="let the C++ programs on CGAL compete too")
    option("--no-build", action="store_true", help="take our programs as they are")
    option("--json", type=writable, metavar="FILE", help="write everything measured to FILE")
    return parser.parse_args()


def prepare(names: list[str], build: bool) -> None:
    if "gudhi" in names:
        ensure_gudhi()
    if {"dual", "cgal"} & set(names):
        ensure_cgal()
    ensure_ours(build, names)


def contest(options: argparse.Namespace) -> int:
    chosen = {*options.only, *(["dual", "cgal"] if options.cgal else [])}
    names = [name for name in CONTENDERS if name in chosen]
    prepare(names, build=not options.no_build)
    rows, records, disagreed = [], [], []
    for cloud in (Cloud(kind, size) for kind in options.kinds for size in options.sizes):
        ensure_cloud(cloud)
        contenders = compare(cloud, names, options.rounds, options.repeat)
        found = disagreements({name: measured.answer for name, measured in contenders.items()})
        disagreed += [f"{cloud.name}: {difference}" for difference in found]
        rows.append(columns(cloud, contenders))
        records.append(record(cloud, contenders, found))
    print(markdown(rows))
    if options.json:
        measured = {"machine": machine(), "rounds": options.rounds, "repeat": options.repeat, "clouds": records}
        options.json.write_text(json.dumps(measured, indent=2) + "\n")
    for difference in disagreed:
        say(f"DISAGREEMENT {difference}")
    return 1 if disagreed else 0


def main() -> int:
    if sys.argv[1:2] == ["--task"]:
        TASKS[sys.argv[2]](*sys.argv[3:])
        return 0
    try:
        return contest(arguments())
    except Missing as reason:
        say(f"peers.py: {reason}")
        return 2


if __name__ == "__main__":
    sys.exit(main())
