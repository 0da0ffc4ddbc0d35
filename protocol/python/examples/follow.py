"""Follows streams of a hopes daemon.

In: the daemon's address and a pattern. Out: a line for each frame, with its most persistent holes.
"""

import argparse

import hopes_client as hopes


def line(frame: hopes.Frame) -> str:
    """A frame in a line."""
    holes = ", ".join(f"({dot.birth:.3g}, {dot.death:.3g})" for dot in frame.dots)
    return (
        f"{frame.stream} frame {frame.number} ({frame.kind}): {frame.points} points, {len(frame.vertices)} vertices, "
        f"{len(frame.edges) + len(frame.critical)} edges, {frame.cycles} cycles; holes: {holes or 'none'}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description="Print a line for each frame of a hopes stream.")
    parser.add_argument("address", help="unix:PATH or tcp:HOST:PORT")
    parser.add_argument("pattern", nargs="?", default="*", help="name of the stream; * stands for any characters")
    arguments = parser.parse_args()

    with hopes.connect(arguments.address) as daemon:
        view = daemon.follow(arguments.pattern, k=1, l=1, dots=hopes.Dots.top(3), reconnect=True)
        try:
            for frame in view:
                print(line(frame), flush=True)
        except KeyboardInterrupt:
            print("stopped")


if __name__ == "__main__":
    main()
