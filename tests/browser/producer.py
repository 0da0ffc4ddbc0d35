"""Produces a stream at a steady rate, as a sensor would, in a process of its own.

In: an address, a stream, a scene and a rate on the command line; with `--rate 0`, a line on stdin for each frame.
Out: points to the daemon; the number of each frame in a line on stdout, as soon as the daemon has committed it.
Invariants: the same seed gives the same points. Frames are due at fixed times, and a late frame delays the later ones
instead of hurrying them. The process ends with the daemon, or with stdin at a rate of 0.
Must not know: browsers, tests.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import random
import sys
import time
from collections.abc import Iterator

import hopes_client as hopes

Point = tuple[float, ...]
# The distance between the centres of neighbouring rings, and their radius.
PITCH = 100.0
RADIUS = 30.0


def near_ring(source: random.Random, ring: int, turn: float, columns: int, noise: float, size: float = 1.0) -> Point:
    """A point of a noisy ring, at a fraction of its turn."""
    radius = size * RADIUS * (1.0 + source.uniform(-noise, noise))
    angle = 2.0 * math.pi * turn
    x = PITCH * (ring % columns) + radius * math.cos(angle)
    return x, PITCH * (ring // columns) + radius * math.sin(angle)


def sweep(seed: int, points: int, changed: int, rings: int, _: float) -> Iterator[list[Point]]:
    """A scanner that goes round noisy rings, one after the other.

    The first frame has all points; each later one has `changed` points, all in one region. In a window of `points`
    points they replace the oldest ones, which are just ahead of the scanner.
    """
    source = random.Random(seed)
    columns = math.ceil(math.sqrt(rings))

    def at(step: int) -> Point:
        ring, turn = divmod(step % points * rings / points, 1.0)
        return near_ring(source, int(ring), turn, columns, 0.2)

    yield [at(step) for step in range(points)]
    step = 0
    while True:
        yield [at(step + i) for i in range(changed)]
        step += changed


def rings(seed: int, points: int, changed: int, rings: int, shrink: float) -> Iterator[list[Point]]:
    """Random points on fixed rings, each of them `shrink` times as large as the one before."""
    source = random.Random(seed)
    columns = math.ceil(math.sqrt(rings))

    def point(ring: int) -> Point:
        return near_ring(source, ring, source.random(), columns, 0.08, shrink**ring)

    def some(count: int) -> list[Point]:
        return [point(i % rings) for i in range(count)]

    yield some(points)
    while True:
        yield some(changed)


def links(seed: int, points: int, changed: int, dimension: int, _: float) -> Iterator[list[Point]]:
    """Random points on two noisy rings in R^d that are linked like those of a chain."""
    source = random.Random(seed)

    def point(ring: int) -> Point:
        angle = 2.0 * math.pi * source.random()
        position = [0.05 * source.uniform(-1.0, 1.0) for _ in range(dimension)]
        position[0] += math.cos(angle) + ring
        position[1 + ring] += math.sin(angle)
        return tuple(position)

    def some(count: int) -> list[Point]:
        return [point(i % 2) for i in range(count)]

    yield some(points)
    while True:
        yield some(changed)


def fine(_seed: int, points: int, _changed: int, _rings: int, _shrink: float) -> Iterator[list[Point]]:
    """A ring of close points, whose hole is filled at scale 1, and a square of side 3, which is closed at 1.5."""
    square = [(10.0 + x, y) for x in (0.0, 3.0) for y in (0.0, 3.0)]
    angles = [2.0 * math.pi * turn / (points - 4) for turn in range(points - 4)]
    yield square + [(math.cos(angle), math.sin(angle)) for angle in angles]
    while True:
        yield []


SCENES = {"sweep": sweep, "rings": rings, "links": links, "fine": fine}


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Produces a stream at a steady rate.")
    parser.add_argument("address")
    parser.add_argument("--stream", default="scan")
    parser.add_argument("--scene", choices=SCENES, default="rings")
    parser.add_argument("--points", type=int, default=400, help="in the cloud")
    parser.add_argument("--changed", type=int, default=20, help="points replaced in a frame")
    parser.add_argument("--rings", type=int, default=4, help="with the scene links, the dimension")
    parser.add_argument("--metric", help="the stream is in a space with this metric, not of the plane")
    parser.add_argument("--shrink", type=float, default=1.0, help="the size of each ring relative to the one before")
    parser.add_argument("--rate", type=float, default=30.0, help="frames per second; 0: one for each line on stdin")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--commit", type=int, default=1, help="0: no frame is ever closed")
    return parser.parse_args()


def times(rate: float) -> Iterator[float]:
    """Waits until each frame is due. Yields the times since the first one."""
    if rate == 0.0:
        yield from (float(count) for count, _ in enumerate(sys.stdin))
        return
    start = due = time.monotonic()
    while True:
        time.sleep(max(0.0, due - time.monotonic()))
        yield due - start
        due = max(due + 1.0 / rate, time.monotonic() - 1.0 / rate)


def produce(options: argparse.Namespace, daemon: hopes.Daemon) -> None:
    """Produces as long as frames are due."""
    frame = 0
    stream = daemon.producer(options.stream, window=hopes.Window.points(options.points), metric=options.metric)
    scene = SCENES[options.scene](options.seed, options.points, options.changed, options.rings, options.shrink)
    for now, points in zip(times(options.rate), scene):
        stream.send(points)
        if options.commit:
            frame = stream.commit(time=now)
        else:
            stream.flush()
            frame += 1
        print(frame, flush=True)


def main() -> None:
    options = arguments()
    # The tests notice by themselves that the daemon is gone.
    with contextlib.suppress(hopes.ConnectionLost), hopes.connect(options.address) as daemon:
        produce(options, daemon)


if __name__ == "__main__":
    main()
