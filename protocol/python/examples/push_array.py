"""Pushes a numpy array to a hopes daemon as a stream of frames.

In: the daemon's address, the stream's name, and optionally a file with an array of shape (frames, points, 2), as
`numpy.save` writes it. Without a file: a noisy circle that grows. Out: a line for each frame. Needs numpy.
"""

import argparse

import numpy

import hopes_client as hopes


def growing_circle(frames: int, points: int) -> "numpy.ndarray":
    """Frames of noisy points on a circle whose radius grows from 1 to 2."""
    random = numpy.random.default_rng(0)
    angle = random.uniform(0.0, 2.0 * numpy.pi, (frames, points))
    radius = numpy.linspace(1.0, 2.0, frames)[:, None] + random.normal(0.0, 0.05, (frames, points))
    return numpy.stack((radius * numpy.cos(angle), radius * numpy.sin(angle)), axis=2)


def main() -> None:
    parser = argparse.ArgumentParser(description="Push a numpy array to a hopes daemon, a frame at a time.")
    parser.add_argument("address", help="unix:PATH or tcp:HOST:PORT")
    parser.add_argument("stream", nargs="?", default="circle")
    parser.add_argument("file", nargs="?", help="array of shape (frames, points, 2), saved by numpy.save")
    arguments = parser.parse_args()
    array = numpy.load(arguments.file) if arguments.file else growing_circle(frames=20, points=500)

    with hopes.connect(arguments.address) as daemon:
        stream = daemon.producer(arguments.stream, window=hopes.Window.frames(1))
        for time, points in enumerate(array):
            answer = stream.send(points)
            frame = stream.commit(time=float(time))
            print(f"frame {frame}: {answer.accepted} points accepted, {answer.refused_count} refused", flush=True)


if __name__ == "__main__":
    main()
