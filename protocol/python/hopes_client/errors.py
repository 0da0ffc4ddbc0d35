"""Exceptions: one class for each case that a caller may want to distinguish.

In: nothing. Out: exception classes, all below `HopesError`. Invariant: an error that ends a connection is raised again
by every later use of it. After any other error the connection is usable.
"""

from __future__ import annotations


class HopesError(Exception):
    """The base class of this package's errors, except `ValueError` and `TypeError` for invalid arguments."""


class ProtocolError(HopesError):
    """The other side sent bytes that the protocol does not allow."""


class Incomplete(ProtocolError):
    """The bytes end too early. At least `needed` more are needed."""

    def __init__(self, needed: int) -> None:
        super().__init__(f"{needed} more bytes are needed")
        self.needed = needed


class Malformed(ProtocolError):
    """The magic bytes or a checksum (CRC) of a banner or an outer frame are wrong."""


class UnsupportedVersion(ProtocolError):
    """A frame (or a file) has another version than the one agreed on."""


class TooLarge(ProtocolError):
    """A frame announces a body above the limit."""


class BodyError(ProtocolError):
    """A frame is valid, but its body cannot be read, or its type is unknown."""


class VersionMismatch(HopesError):
    """Both sides have no protocol version in common."""


class DaemonTooOld(VersionMismatch):
    """The agreed protocol version, the highest of the daemon, does not have this feature."""


class ConnectionLost(HopesError, ConnectionError):
    """The connection has ended. Nothing more can be sent or received."""


class DaemonClosed(ConnectionLost):
    """The daemon sent `Goodbye`: `reason`, and the last frame of each stream in `streams`."""

    def __init__(self, reason: str, streams: dict[str, int]) -> None:
        super().__init__(f"the daemon said goodbye: {reason}")
        self.reason = reason
        self.streams = streams


class PeerSilent(ConnectionLost):
    """The daemon sent nothing, or no complete frame, for longer than its `timeout_ms`."""


class InboxFull(ConnectionLost):
    """Too many bytes arrived for subscriptions that are not read, during another wait."""


class TimedOut(HopesError, TimeoutError):
    """The awaited message did not arrive in time. The connection is usable and the call may be repeated.

    `sent` is the number of points that were sent before, if the call sends points.
    """

    sent = 0


class DaemonError(HopesError):
    """The daemon answered with `Error`: `code`, the message type it `answers` (0 if none) and a `text` for people."""

    def __init__(self, code: int, answers: int, text: str) -> None:
        super().__init__(f"{text} (code {code})")
        self.code = code
        self.answers = answers
        self.text = text


class ResyncNeeded(HopesError):
    """A snapshot or diff does not fit the mirror. The stream must be subscribed to again."""


class StreamEnded(HopesError):
    """The stream of this producer was ended. `frame` was its last frame."""

    def __init__(self, name: str, frame: int) -> None:
        super().__init__(f"the stream {name!r} was ended at frame {frame}")
        self.frame = frame


class StaleFrame(HopesError):
    """The graph of a frame was accessed after a later frame had replaced it (see `Frame.copy`)."""
