"""Time: how long a caller waits, and how long the daemon may be silent.

In: seconds. Out: `Deadline` for the first, `Patience` for the second.
Invariant: only time spent waiting for the daemon counts against it, not time in which this side did something else and
did not look whether anything had come.
"""

from __future__ import annotations

import time


class Deadline:
    """A point in time, some seconds from now, or never."""

    def __init__(self, seconds: float | None) -> None:
        self._end = None if seconds is None else time.monotonic() + seconds

    def left(self) -> float | None:
        """Seconds until then, at least 0; none if there is no end."""
        return None if self._end is None else max(0.0, self._end - time.monotonic())

    def passed(self) -> bool:
        """Whether it is over."""
        return self._end is not None and time.monotonic() >= self._end


class Patience:
    """Whether the daemon has been silent, or busy with one frame, for too long.

    `limit` is the time after which it is given up, in seconds; none if it may take any time.
    """

    def __init__(self, limit: float | None) -> None:
        self.limit = limit
        self._silent = 0.0
        self._unfinished = 0.0
        self._asked = False

    def heard(self) -> None:
        """Bytes have come."""
        self._silent = 0.0
        self._asked = False

    def finished_frame(self) -> None:
        """The last byte of a frame has come."""
        self._unfinished = 0.0

    def waited(self, seconds: float, within_frame: bool) -> None:
        """That long was waited, perhaps for the rest of a frame."""
        self._silent += seconds
        if within_frame:
            self._unfinished += seconds

    def should_ask(self) -> bool:
        """Whether it is time to send a `Ping`: true once for each silence."""
        if self.limit is None or self._asked or self._silent < self.limit / 2:
            return False
        self._asked = True
        return True

    def is_over(self) -> bool:
        """Whether the daemon has to be given up."""
        return self.limit is not None and max(self._silent, self._unfinished) >= self.limit

    def next_check(self) -> float | None:
        """Seconds of waiting until `should_ask` or `is_over` may change."""
        if self.limit is None:
            return None
        silence_ends = self.limit if self._asked else self.limit / 2
        return max(0.0, min(silence_ends - self._silent, self.limit - self._unfinished))
