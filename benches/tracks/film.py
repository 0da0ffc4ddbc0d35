#!/usr/bin/env python3
"""Draws frames of a film with their living tracks: edges in gray, holes as circles in a colour for each id.

In: a file of points with a commit after each frame (JSON lines, as `hopes serve --input jsonl` reads them), and the
numbers of the frames to draw. Out: an SVG on standard output. It needs only Python and the program.

    python3 benches/tracks/film.py tests/data/bunny.jsonl --frames 3,7,10,15,20,25 > tests/data/film.svg
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HOPES = ROOT / "target/release/hopes"
COLUMNS = 3
GAP = 8
# Colours that colour-blind people can distinguish (Okabe and Ito).
COLOURS = ("#D55E00", "#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#B8A800")

Pixel = tuple[int, int]


def points_of(path: Path) -> list[list[Pixel]]:
    frames: list[list[Pixel]] = [[]]
    for line in path.read_text().splitlines():
        value = json.loads(line)
        if "commit" in value:
            frames.append([])
        else:
            frames[-1].extend((int(x), int(y)) for x, y in value["points"])
    return frames[:-1]


def alive_in(path: Path, above: float) -> list[list[list[float]]]:
    command = [HOPES, "serve", "--input", "jsonl", "--window", "frames:1", "--track", f"above:{above}", "--track-list"]
    with path.open() as points:
        told = subprocess.run(command, stdin=points, stdout=subprocess.PIPE, check=True, text=True).stdout
    return [json.loads(line)["alive"] for line in told.splitlines()]


def runs(pixels: Iterable[Pixel], height: int) -> Iterator[str]:
    """Neighbouring pixels of a row become one stroke."""
    begun: Pixel | None = None
    last: Pixel | None = None
    for x, y in sorted(pixels, key=lambda pixel: (pixel[1], pixel[0])):
        if last is None or begun is None or (last[0] + 1, last[1]) != (x, y):
            if begun and last:
                yield stroke(begun, last, height)
            begun = (x, y)
        last = (x, y)
    if begun and last:
        yield stroke(begun, last, height)


def stroke(begun: Pixel, last: Pixel, height: int) -> str:
    return f"M{begun[0]} {height - 1 - begun[1]}h{last[0] - begun[0] + 1}"


def drawn(number: int, pixels: list[Pixel], alive: list[list[float]], height: int) -> Iterator[str]:
    yield f'<path d="{"".join(runs(pixels, height))}" stroke="#777"/>'
    for id, x, y, radius, *_ in sorted(alive, key=lambda track: -track[3]):
        colour, x, y = COLOURS[(int(id) - 1) % len(COLOURS)], round(x, 1), round(height - 1 - y, 1)
        yield f'<circle cx="{x}" cy="{y}" r="{round(radius, 1)}" fill="{colour}" fill-opacity=".3" stroke="{colour}" stroke-width="2"/>'
        yield f'<text x="{x}" y="{y + 11}" font-size="32" text-anchor="middle" fill="{colour}">{int(id)}</text>'
    yield f'<text x="6" y="{height - 8}" font-size="22" fill="#000">frame {number}</text>'


def picture(path: Path, numbers: list[int], above: float) -> Iterator[str]:
    frames, alive = points_of(path), alive_in(path, above)
    width, height = (1 + max(pixel[axis] for frame in frames for pixel in frame) for axis in (0, 1))
    rows = -(-len(numbers) // COLUMNS)
    box = (COLUMNS * (width + GAP) - GAP, rows * (height + GAP) - GAP)
    yield f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {box[0]} {box[1]}" width="{box[0] // 2}" height="{box[1] // 2}" font-family="sans-serif" font-weight="bold">'
    for place, number in enumerate(numbers):
        column, row = place % COLUMNS, place // COLUMNS
        yield f'<g transform="translate({column * (width + GAP)} {row * (height + GAP)})">'
        yield f'<rect width="{width}" height="{height}" fill="#fff" stroke="#bbb"/>'
        yield from drawn(number, frames[number - 1], alive[number - 1], height)
        yield "</g>"
    yield "</svg>"


def main() -> int:
    description, _, example = (__doc__ or "").rstrip().rpartition("\n\n")
    parser = argparse.ArgumentParser(
        description=description,
        epilog=f"example:\n{example}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("points", type=Path, metavar="FILE")
    parser.add_argument("--frames", required=True, type=lambda word: [int(part) for part in word.split(",")])
    parser.add_argument("--above", type=float, default=8.0, help="track holes of this persistence (default: %(default)s)")
    options = parser.parse_args()
    subprocess.run(["cargo", "build", "--release", "--locked", "--quiet"], cwd=ROOT, check=True)
    sys.stdout.writelines(f"{line}\n" for line in picture(options.points, options.frames, options.above))
    return 0


if __name__ == "__main__":
    sys.exit(main())
