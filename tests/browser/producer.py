"""Sends points at a steady rate from a process of its own, as a sensor would.

In: an address, a stream, a scene and a rate on the command line. With `--rate 0`, a line on stdin for each frame. Out:
points to the daemon; on stdout the number of each frame on a line of its own, as soon as the daemon has confirmed it.
Invariants: the same seed gives the same points. Frames are sent at their times, and a late one is not followed by a
burst. The process ends with the daemon, or at the end of stdin. Must not know: browsers, tests.
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

Point = tuple[float, float]
# The space of a ring on each side. Its radius is 30.
PITCH = 100.0
RADIUS = 30.0


def near_ring(source: random.Random, ring: int, turn: float, columns: int, noise: float, size: float = 1.0) -> Point:
    """A point of a noisy ring at a share of its turn."""
    radius = size * RADIUS * (1.0 + source.uniform(-noise, noise))
    angle = 2.0 * math.pi * turn
    x = PITCH * (ring % columns) + radius * math.cos(angle)
    return x, PITCH * (ring // columns) + radius * math.sin(angle)


def sweep(seed: int, points: int, changed: int, rings: int, _: float) -> Iterator[list[Point]]:
    """A scanner that goes round noisy rings, one after the other: first all of them at once, then some points a frame,
    all in one place. If the window has as many points as the rings, the removed points are just before the scanner.
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
    """Points anywhere on rings that stay. Each ring is smaller than the previous one."""
    source = random.Random(seed)
    columns = math.ceil(math.sqrt(rings))

    def some(count: int) -> list[Point]:
        return [near_ring(source, i % rings, source.random(), columns, 0.08, shrink ** (i % rings)) for i in range(count)]

    yield some(points)
    while True:
        yield some(changed)


SCENES = {"sweep": sweep, "rings": rings}


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Feeds a stream at a steady pace.")
    parser.add_argument("address")
    parser.add_argument("--stream", default="scan")
    parser.add_argument("--scene", choices=SCENES, default="rings")
    parser.add_argument("--points", type=int, default=400, help="in the cloud")
    parser.add_argument("--changed", type=int, default=20, help="points replaced in a frame")
    parser.add_argument("--rings", type=int, default=4)
    parser.add_argument("--shrink", type=float, default=1.0, help="how large each ring is beside the one before")
    parser.add_argument("--rate", type=float, default=30.0, help="frames a second; 0: one for each line on stdin")
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args()


def times(rate: float) -> Iterator[float]:
    """Waits until the next frame is due, repeatedly. Yields the times since the first."""
    if rate == 0.0:
        yield from (float(count) for count, _ in enumerate(sys.stdin))
        return
    start = due = time.monotonic()
    while True:
        time.sleep(max(0.0, due - time.monotonic()))
        yield due - start
        due = max(due + 1.0 / rate, time.monotonic() - 1.0 / rate)


def feed(asked: argparse.Namespace, daemon: hopes.Daemon) -> None:
    """Sends frames as long as they are due."""
    stream = daemon.producer(asked.stream, window=hopes.Window.points(asked.points))
    scene = SCENES[asked.scene](asked.seed, asked.points, asked.changed, asked.rings, asked.shrink)
    for now, points in zip(times(asked.rate), scene):
        stream.send(points)
        print(stream.commit(time=now), flush=True)


def main() -> None:
    asked = arguments()
    # A lost daemon is not an error here. The test notices it.
    with contextlib.suppress(hopes.ConnectionLost), hopes.connect(asked.address) as daemon:
        feed(asked, daemon)


if __name__ == "__main__":
    main()
