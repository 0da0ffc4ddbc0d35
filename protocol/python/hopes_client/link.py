"""A connection to a daemon that can be renewed.

In: a function that connects. Out: `Link.current`, and `Link.renew`. Invariant: no connection is made after the link was
closed.
"""

from __future__ import annotations

from typing import Callable

from .connection import Connection
from .errors import ConnectionLost


class Link:
    """The connection that the producers and subscriptions of a `Daemon` share."""

    def __init__(self, dial: Callable[[], Connection]) -> None:
        self._dial: Callable[[], Connection] | None = dial
        self.current = dial()

    def renew(self) -> Connection:
        """The connection if it is alive, else a new one."""
        if not self.current.is_alive:
            if self._dial is None:
                raise ConnectionLost("this connection was closed")
            self.current = self._dial()
        return self.current

    @property
    def is_closed(self) -> bool:
        """Whether this side has closed it."""
        return self._dial is None

    def close(self, reason: str) -> None:
        """Closes the connection. It cannot be renewed."""
        self._dial = None
        self.current.close(reason)
