"""Reads recordings: the messages of one subscription in a file (section 8 of the specification).

In: a path, or a binary file. Out: an iterator of frames, of the same type as from a daemon. Invariants: every returned
frame was verified by its checksum. A file that ends within a frame gives all frames before, and then `truncated` is
true. A file that ends without the end of a recording was cut off between two frames, or is older than that: then
`end` is none.
"""

from __future__ import annotations

import os
from types import TracebackType
from typing import BinaryIO

from .errors import HopesError, Malformed, ProtocolError, ResyncNeeded
from .frame import Frame
from .messages import Elapsed, Goodbye, Message, decode
from .tracker import Tracker, more_of
from .wire import LARGEST_FRAME, Banner, FrameBuffer

_READ_SIZE = 1 << 20


class Recording:
    """An iterator of the frames of a recording. The file is closed at its end, by `close`, or by a `with` block."""

    def __init__(self, file: BinaryIO, largest_frame: int = LARGEST_FRAME) -> None:
        #: Whether the file ended within a frame. Known when the iteration has ended.
        self.truncated = False
        #: Why the recording ended, if it has an end: else it was cut off. Known when the iteration has ended.
        self.end: str | None = None
        self._file = file
        self._buffer = FrameBuffer(largest_frame)
        # A daemon that writes its stream to stdout does not announce it.
        self._tracker = Tracker(announced=False)
        self._following: Message | None = None
        self._elapsed: float | None = None
        self._broken: HopesError | None = None
        self._version = self._read_banner()

    def close(self) -> None:
        """Closes the file."""
        self._file.close()

    def __iter__(self) -> Recording:
        return self

    def __next__(self) -> Frame:
        if self._broken is not None:
            raise self._broken
        while not self._file.closed:
            message, self._following = self._following or self._next_message(), None
            if message is None:
                break
            frame = self._tracker.take(message, self._elapsed)
            if frame is not None:
                self._complete(frame, message)
                return frame
        self.close()
        raise StopIteration

    def __enter__(self) -> Recording:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _read_more(self) -> bool:
        data = self._file.read(_READ_SIZE)
        self._buffer.feed(data)
        return len(data) > 0

    def _read_banner(self) -> int:
        """The version of the frames."""
        banner = None
        while banner is None:
            if not self._read_more():
                raise Malformed("the file is too short for a banner")
            banner = self._buffer.next_banner()
        if banner.lowest != banner.highest:
            raise Malformed(f"the file is in versions {banner.lowest} to {banner.highest}, which should be one")
        return Banner().agree(banner)

    def _next_message(self) -> Message | None:
        """The next message of the subscription. None at the end of the file."""
        while True:
            frame = self._buffer.next_frame(self._version)
            if frame is not None:
                message = decode(frame.type, frame.body, frame.version)
                if self.end is not None:
                    raise ProtocolError(f"a {type(message).__name__} follows the end of the recording")
                if isinstance(message, Elapsed):
                    self._elapsed = message.nanoseconds / 1e9
                elif isinstance(message, Goodbye):
                    self.end = message.reason
                else:
                    assert isinstance(message, Message)
                    return message
            elif not self._read_more():
                self.truncated = len(self._buffer) > 0
                return None

    def _complete(self, frame: Frame, message: Message) -> None:
        """Adds dots and tracks of a frame if they follow directly."""
        try:
            while True:
                self._following = self._next_message()
                more = more_of(message, self._following)
                if more is None:
                    return
                self._tracker.complete(frame, more)
        except (ProtocolError, ResyncNeeded) as error:
            # The frames before are valid. The error is raised when the next one is requested.
            self._broken = error


def read_recording(path: str | os.PathLike[str], largest_frame: int = LARGEST_FRAME) -> Recording:
    """The frames of a recording."""
    file = open(path, "rb")  # noqa: SIM115 (the recording closes it)
    try:
        return Recording(file, largest_frame)
    except BaseException:
        file.close()
        raise
