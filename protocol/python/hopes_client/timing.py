"""Time limits: of calls, and of a silent daemon.

In: seconds. Out: `Deadline` for the first, `SilenceTimer` for the second. Invariant: only time spent waiting for the
daemon counts for the second, not time in which this side did something else and did not read.
"""

from __future__ import annotations

import time


class Deadline:
    """A point in time some seconds from now, or never."""

    def __init__(self, seconds: float | None) -> None:
        self._end = None if seconds is None else time.monotonic() + seconds

    def left(self) -> float | None:
        """Seconds left, at least 0. None if there is no limit."""
        return None if self._end is None else max(0.0, self._end - time.monotonic())

    def passed(self) -> bool:
        """Whether it has passed."""
        return self._end is not None and time.monotonic() >= self._end


class SilenceTimer:
    """Measures how long the daemon has sent nothing, or no complete frame.

    `limit` is the timeout in seconds. None: no timeout.
    """

    def __init__(self, limit: float | None) -> None:
        self.limit = limit
        self._silent = 0.0
        self._unfinished = 0.0
        self._asked = False

    def heard(self) -> None:
        """Bytes were received."""
        self._silent = 0.0
        self._asked = False

    def finished_frame(self) -> None:
        """The last byte of a frame was received."""
        self._unfinished = 0.0

    def waited(self, seconds: float, within_frame: bool) -> None:
        """So many seconds were spent waiting, perhaps for the rest of a frame."""
        self._silent += seconds
        if within_frame:
            self._unfinished += seconds

    def should_ping(self) -> bool:
        """Whether to send a `Ping`: true once in each silence."""
        if self.limit is None or self._asked or self._silent < self.limit / 2:
            return False
        self._asked = True
        return True

    def is_over(self) -> bool:
        """Whether the timeout has passed."""
        return self.limit is not None and max(self._silent, self._unfinished) >= self.limit

    def next_check(self) -> float | None:
        """Seconds of waiting until `should_ping` or `is_over` may change."""
        if self.limit is None:
            return None
        silence_ends = self.limit if self._asked else self.limit / 2
        return max(0.0, min(silence_ends - self._silent, self.limit - self._unfinished))
