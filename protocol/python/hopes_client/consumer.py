"""Subscriptions.

In: a pattern, a view, and what is requested of the persistence diagram and of tracks. Out: an iterator of frames.
Invariants: every returned frame was verified by its checksum. A subscription that may reconnect resumes from its
mirrors if the daemon can. It never returns a frame that does not follow the previous one. Pauses between attempts are
bounded.
"""

from __future__ import annotations

import time
import weakref
from dataclasses import dataclass
from types import TracebackType
from typing import Any

from .connection import as_exception
from .errors import HopesError, ProtocolError, ResyncNeeded, TimedOut, VersionMismatch
from .frame import Frame
from .link import Link
from .messages import (
    ChangeView,
    Error,
    Message,
    Resume,
    StreamClosed,
    Subscribe,
    Unsubscribe,
    Unsubscribed,
    WantTracks,
)
from .mirror import Mirror
from .shared import DotsWanted, View
from .spaces import DOTS
from .timing import Deadline
from .tracker import Tracker, more_of
from .tracks import TracksWanted

_SHORTEST_PAUSE = 0.1
_LONGEST_PAUSE = 5.0
_NOTHING_KEPT: dict[str, Mirror] = {}
_NO_TRACKS = TracksWanted.of(None)
# The code of an error that leaves out one stream: the subscription goes on without it.
_TOO_MANY_VIEWS = 15


@dataclass(frozen=True)
class FollowOptions:
    """Options of a subscription.

    `timeout` is how long it waits for a frame (none: as long as the daemon is alive). With `reconnect` it connects and
    subscribes again when the connection is lost or a message does not fit.

    The daemon sends no message if the dots do not change or if there are no events of tracks. So a frame is held back
    for `dots_wait` seconds until its dots and tracks, or another message, arrive. Later ones make a frame of their own,
    of kind "dots" or "tracks".

    With `stop_when_closed` the iteration ends when a stream is closed.
    """

    timeout: float | None = None
    reconnect: bool = False
    dots_wait: float = 0.05
    stop_when_closed: bool = False


class Subscription:
    """An iterator of the frames of all streams whose names match. Leaving a `with` block unsubscribes."""

    def __init__(
        self,
        link: Link,
        pattern: str,
        view: View,
        dots: DotsWanted,
        options: FollowOptions,
        resume: Mirror | None = None,
        tracks: TracksWanted = _NO_TRACKS,
    ) -> None:
        self.pattern = pattern
        self.view = view
        self.dots = dots
        self.tracks = tracks
        self.options = options
        #: The stream that was closed last.
        self.closed_stream: StreamClosed | None = None
        self._link = link
        self._ended = False
        self._pause = _SHORTEST_PAUSE
        self._subscribe({resume.name: resume} if resume else _NOTHING_KEPT)

    def mirrors(self) -> dict[str, Mirror]:
        """The mirror of each stream, by name. For `resume` of another subscription after this one has ended."""
        return self._tracker.mirrors()

    def next_frame(self, timeout: float | None = None) -> Frame | None:
        """The next frame. None if the subscription has ended. After `TimedOut` it may be called again."""
        deadline = Deadline(self.options.timeout if timeout is None else timeout)
        while not self._ended:
            try:
                frame = self._next_here(deadline)
            except HopesError as error:
                if not self._may_start_again(error):
                    raise
                self._start_again(error, deadline)
            else:
                self._pause = _SHORTEST_PAUSE
                return frame
        return None

    def change_view(
        self,
        *,
        full: bool = False,
        alpha: float | None = None,
        k: int | None = None,
        l: int | None = None,
        simplify: bool | float = False,
        dots: DotsWanted | None = None,
    ) -> None:
        """Changes the view, and the dots if they are given.

        Frames of the previous view may still arrive. The first one of the new view is a snapshot with the cause
        "ViewChanged".
        """
        view = View.of(full, alpha, k, l, simplify)
        wanted = self.dots if dots is None else dots
        self._connection.send(self._channel, ChangeView(view, wanted), self._connection.options.timeout)
        self.view, self.dots = view, wanted

    def want_tracks(self, tracks: str | None) -> None:
        """Requests "events", "alive", "cycles" or nothing of the tracks from now on.

        Frames have no tracks until the daemon has listed all of them again.
        """
        wanted = TracksWanted.of(tracks)
        self._connection.send(self._channel, WantTracks(wanted), self._connection.options.timeout)
        self.tracks = wanted
        self._tracker.forget_tracks(wanted != _NO_TRACKS)

    def close(self, timeout: float | None = None) -> None:
        """Unsubscribes, and waits for the answer. Does nothing if that was done before."""
        if self._ended:
            return
        self._ended = True
        self._finalizer.detach()
        try:
            self._unsubscribe(Deadline(self._connection.allowed(timeout)))
        except HopesError:
            # If the connection is lost, the subscription has ended too.
            if self._connection.is_alive:
                raise
        finally:
            self._connection.close_channel(self._channel)

    def __iter__(self) -> Subscription:
        return self

    def __next__(self) -> Frame:
        frame = self.next_frame()
        if frame is None:
            raise StopIteration
        return frame

    def __enter__(self) -> Subscription:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()
        else:
            self._ended = True
            self._finalizer()

    def _unsubscribe(self, deadline: Deadline) -> None:
        self._connection.send(self._channel, Unsubscribe(), deadline.left())
        message: Any = None
        while not isinstance(message, (Unsubscribed, Error)):
            message = self._connection.receive(self._channel, deadline.left())

    def _subscribe(self, kept: dict[str, Mirror]) -> None:
        """Subscribes on the link's connection, and resumes from the kept mirrors if possible."""
        connection = self._link.renew()
        if self.tracks != _NO_TRACKS:
            connection.check_speaks(WantTracks)
        self._connection = connection
        self._channel = self._connection.open_channel()
        # A subscription that is dropped during an iteration must not fill the inbox for ever.
        self._finalizer = weakref.finalize(self, self._connection.abandon, self._channel)
        self._finalizer.atexit = False
        self._tracker = Tracker(kept.values())
        self._following: Message | None = None
        mirror = kept.get(self.pattern)
        resume = None
        if mirror is not None and mirror.number > 0 and mirror.view == self.view and "*" not in self.pattern:
            resume = Resume(mirror.epoch, mirror.number)
        message = Subscribe(self.pattern, self.view, self.dots, resume)
        self._connection.send(self._channel, message, self._connection.options.timeout)
        if self.tracks != _NO_TRACKS:
            self._connection.send(self._channel, WantTracks(self.tracks), self._connection.options.timeout)

    def _may_start_again(self, error: HopesError) -> bool:
        """Whether subscribing again is allowed and may help."""
        if not self.options.reconnect or self._link.is_closed or isinstance(error, TimedOut):
            return False
        return isinstance(error, (ProtocolError, ResyncNeeded)) or not self._connection.is_alive

    def _start_again(self, error: HopesError, deadline: Deadline) -> None:
        """Subscribes again, with growing pauses, until that works or the deadline has passed."""
        kept = _NOTHING_KEPT if isinstance(error, ResyncNeeded) else self._tracker.mirrors()
        reason: Exception = error
        while True:
            self._wait_a_while(deadline, reason)
            self._finalizer()
            try:
                self._subscribe(kept)
                return
            except VersionMismatch:
                # Trying again would not help.
                self._ended = True
                raise
            except (HopesError, OSError) as again:
                reason = again

    def _wait_a_while(self, deadline: Deadline, reason: Exception) -> None:
        left = deadline.left()
        time.sleep(self._pause if left is None else min(self._pause, left))
        if deadline.passed():
            raise TimedOut(f"the connection could not be made again in time: {reason}") from reason
        self._pause = min(2 * self._pause, _LONGEST_PAUSE)

    def _next_here(self, deadline: Deadline) -> Frame | None:
        """The next frame on this channel. None if the subscription has ended."""
        while True:
            message = self._next_message(deadline)
            if isinstance(message, Error):
                if message.answers == Subscribe.TYPE and message.code != _TOO_MANY_VIEWS:
                    self._ended = True
                    self._finalizer.detach()
                    self._connection.close_channel(self._channel)
                elif message.answers == WantTracks.TYPE:
                    # Tracks that the daemon does not send are not waited for.
                    self.tracks = _NO_TRACKS
                raise as_exception(message)
            frame = self._tracker.take(message)
            if frame is not None:
                self._complete(frame, message, deadline)
                return frame
            if isinstance(message, StreamClosed):
                self.closed_stream = message
                if self.options.stop_when_closed:
                    self.close()
                    return None

    def _next_message(self, deadline: Deadline) -> Any:
        message, self._following = self._following, None
        return message or self._connection.receive(self._channel, deadline.left())

    def _complete(self, frame: Frame, message: Message, deadline: Deadline) -> None:
        """Adds dots and tracks of a frame if they follow directly."""
        due = {"dots"} if self.dots.case != "No" else set()
        due |= {"tracks"} if self.tracks != _NO_TRACKS else set()
        left = deadline.left()
        deadline = Deadline(self.options.dots_wait if left is None else min(left, self.options.dots_wait))
        while due and frame.kind in ("snapshot", "diff"):
            following = self._next_in(deadline)
            more = more_of(message, following)
            if more is None:
                self._following = following
                return
            try:
                self._tracker.complete(frame, more)
            except ResyncNeeded:
                # The frame is valid. The error is raised with the next one.
                self._following = more
                return
            due.discard("dots" if isinstance(more, DOTS) else "tracks")

    def _next_in(self, deadline: Deadline) -> Any:
        """The next message, if one arrives in time."""
        try:
            return self._connection.receive(self._channel, deadline.left())
        except TimedOut:
            return None
        except HopesError:
            if self._connection.is_alive:
                raise
            # The previous frame is valid. The lost connection is raised with the next one.
            return None
