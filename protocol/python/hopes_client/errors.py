"""What can go wrong, one class for each thing a caller may want to tell apart.

In: nothing. Out: exception classes, all below `HopesError`.
Invariant: what ends a connection is raised again by every later use of it; all other errors leave it usable.
"""

from __future__ import annotations


class HopesError(Exception):
    """Everything that this package raises on its own account, but for `ValueError` and `TypeError` on bad arguments."""


class ProtocolError(HopesError):
    """The other side sent bytes that the protocol does not allow."""


class Incomplete(ProtocolError):
    """The bytes end too early: `needed` more are needed at least."""

    def __init__(self, needed: int) -> None:
        super().__init__(f"{needed} more bytes are needed")
        self.needed = needed


class Malformed(ProtocolError):
    """The magic bytes or a checksum (CRC) of a banner or an outer frame are wrong."""


class UnsupportedVersion(ProtocolError):
    """An outer frame (or a file) is in a version that was not agreed on."""


class TooLarge(ProtocolError):
    """An outer frame announces a body above the cap."""


class BodyError(ProtocolError):
    """A body that cannot be read, or a message type that is not known, in a sound outer frame."""


class VersionMismatch(HopesError):
    """There is no protocol version that both sides speak."""


class DaemonTooOld(VersionMismatch):
    """What is asked for is not in the protocol version that was agreed on, the highest that the daemon speaks."""


class ConnectionLost(HopesError, ConnectionError):
    """The connection has ended; nothing more can be sent or received on it."""


class DaemonClosed(ConnectionLost):
    """The daemon said goodbye: `reason`, and the last frame of each stream in `streams`."""

    def __init__(self, reason: str, streams: dict[str, int]) -> None:
        super().__init__(f"the daemon said goodbye: {reason}")
        self.reason = reason
        self.streams = streams


class PeerSilent(ConnectionLost):
    """The daemon was silent, or busy with one frame, for longer than its `timeout_ms`."""


class InboxFull(ConnectionLost):
    """Too many bytes arrived for subscriptions that nobody reads while something else was waited for."""


class TimedOut(HopesError, TimeoutError):
    """What was waited for did not come in the time given. The connection is sound and the call may be repeated.

    `sent` is how many of the points were sent before, if it was points that should be sent.
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
    """A snapshot or diff does not fit what the mirror holds: the stream has to be subscribed to again."""


class StreamEnded(HopesError):
    """Somebody ended the stream that this producer feeds; `frame` was its last frame."""

    def __init__(self, name: str, frame: int) -> None:
        super().__init__(f"the stream {name!r} was ended at frame {frame}")
        self.frame = frame


class StaleFrame(HopesError):
    """The graph of a frame was asked for after a later frame had replaced it (see `Frame.copy`)."""
