"""Follows the tracks of a hopes stream: persistent cycles with lasting ids.

In: the address of a daemon that was started with `--track`, and a pattern. Out: a line for each event of a track.
"""

from __future__ import annotations

import argparse

import hopes_client as hopes

WORDS = {
    "Born": "is born",
    "Split": "is split from {}",
    "Updated": "has changed: {}",
    "Unselected": "is out of the selection",
    "Reselected": "is selected again",
    "Merged": "is merged into {}",
    "Died": "has died",
}


def line(stream: str, event: hopes.TrackEvent) -> str:
    """An event in a line."""
    track = event.track
    x, y = track.center
    what = WORDS[event.happening.case].format(*event.happening.values)
    return (
        f"{stream} frame {event.frame}: track {track.id} {what} "
        f"at ({x:.4g}, {y:.4g}), birth {track.birth:.3g}, death {track.death:.3g}, age {track.age}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description="Print a line for each thing that happens to a track of a hopes stream."
    )
    parser.add_argument("address", help="unix:PATH or tcp:HOST:PORT")
    parser.add_argument("pattern", nargs="?", default="*", help="name of the stream; * stands for any characters")
    parser.add_argument("--all", action="store_true", help="also tell when a track only moves or changes")
    arguments = parser.parse_args()

    with hopes.connect(arguments.address) as daemon:
        view = daemon.follow(arguments.pattern, k=1, l=1, tracks="events", reconnect=True)
        try:
            for frame in view:
                for event in frame.track_events:
                    if arguments.all or event.happening.case != "Updated":
                        print(line(frame.stream, event), flush=True)
        except KeyboardInterrupt:
            print("stopped")


if __name__ == "__main__":
    main()
