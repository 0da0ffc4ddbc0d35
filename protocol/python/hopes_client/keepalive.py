"""Keeps an idle connection alive.

In: an object with `keep_alive()` and the seconds between two calls. Out: a background thread that makes these calls.
Invariant: the thread holds no reference to the object between calls. It ends when it is stopped or when the object is
gone.
"""

from __future__ import annotations

import threading
import weakref
from typing import Protocol


class Alive(Protocol):
    """An object that the thread can call."""

    def keep_alive(self) -> None:
        """Sends something if nothing was sent for some time."""


class Keepalive:
    """The thread of one connection."""

    def __init__(self, kept: Alive, interval: float) -> None:
        self._kept = weakref.ref(kept)
        self._interval = interval
        self._stopped = threading.Event()
        threading.Thread(target=self._run, name="hopes keepalive", daemon=True).start()

    def stop(self) -> None:
        """Ends the thread. A running call may still finish."""
        self._stopped.set()

    def _run(self) -> None:
        while not self._stopped.wait(self._interval):
            kept = self._kept()
            if kept is None:
                return
            kept.keep_alive()
            del kept
