"""Turns the messages of one subscription, or of a recording of one, into frames.

In: the messages, in the order in which they came. Out: a `Frame` for each message that makes one.
Invariants: each stream that is announced has one mirror, until it is closed; a mirror kept from before the connection
was lost is gone on with only if the daemon says `Resumed`. `ResyncNeeded` means that the streams have to be subscribed
to again.
"""

from __future__ import annotations

from collections.abc import Iterable

from .errors import ResyncNeeded
from .frame import Frame
from .messages import Diff, Dots, Lagged, Message, Resumed, Snapshot, StreamClosed, StreamOpened
from .mirror import Mirror


class Tracker:
    """The mirrors of the streams of one subscription.

    `kept` are mirrors that may be resumed. Unless all streams have to be `announced`, one that is not has no name.
    """

    def __init__(self, kept: Iterable[Mirror] = (), announced: bool = True) -> None:
        self._announced = announced
        self._kept = {mirror.name: mirror for mirror in kept}
        self._mirrors: dict[int, Mirror] = {}
        self._lagged: dict[int, tuple[int, int]] = {}

    def mirrors(self) -> dict[str, Mirror]:
        """The mirror of each stream by its name, those kept and not resumed yet among them."""
        return {**self._kept, **{mirror.name: mirror for mirror in self._mirrors.values()}}

    def take(self, message: Message, elapsed: float | None = None) -> Frame | None:
        """The frame that the message makes, if it makes one."""
        if isinstance(message, StreamOpened):
            self._mirrors[message.stream] = Mirror(message.name, message.epoch)
        elif isinstance(message, StreamClosed):
            self._mirrors.pop(message.stream, None)
            self._lagged.pop(message.stream, None)
        elif isinstance(message, Resumed):
            self._resume(message)
        elif isinstance(message, Lagged):
            self._lagged[message.stream] = (message.first, message.last)
        elif isinstance(message, (Snapshot, Diff)):
            return self._frame(message, elapsed)
        elif isinstance(message, Dots):
            return self._dots(message, elapsed)
        return None

    def _mirror(self, stream: int) -> Mirror:
        if stream not in self._mirrors:
            if self._announced:
                raise ResyncNeeded(f"the stream {stream} was not announced")
            self._mirrors[stream] = Mirror()
        return self._mirrors[stream]

    def _resume(self, message: Resumed) -> None:
        fresh = self._mirror(message.stream)
        mirror = self._kept.pop(fresh.name, None)
        if mirror is None or (mirror.epoch, mirror.number) != (fresh.epoch, message.frame):
            raise ResyncNeeded(f"frame {message.frame} is resumed from, but it is not what is held")
        self._mirrors[message.stream] = mirror

    def _frame(self, message: Snapshot | Diff, elapsed: float | None) -> Frame:
        mirror = self._mirror(message.stream)
        lagged = self._lagged.pop(message.stream, None)
        if isinstance(message, Snapshot):
            mirror.apply_snapshot(message)
            self._kept.pop(mirror.name, None)
            return Frame(mirror, message.frame, "snapshot", cause=message.cause.case, lagged=lagged, elapsed=elapsed)
        mirror.apply_diff(message)
        return Frame(mirror, message.frame, "diff", diff=message, lagged=lagged, elapsed=elapsed)

    def _dots(self, message: Dots, elapsed: float | None) -> Frame:
        mirror = self._mirror(message.stream)
        if mirror.header is None or message.frame > mirror.number:
            raise ResyncNeeded(f"dots of frame {message.frame} come before that frame")
        mirror.apply_dots(message)
        return Frame(mirror, mirror.header, "dots", elapsed=elapsed)

    def complete(self, frame: Frame, dots: Dots) -> None:
        """Gives a frame the dots that came right after it (see `dots_of`)."""
        self._mirror(dots.stream).apply_dots(dots)
        frame.dots, frame.dots_total = tuple(dots.dots), dots.total


def dots_of(message: Message, following: Message | None) -> Dots | None:
    """`following`, if it has the dots of the frame that `message` leads to."""
    if not isinstance(message, (Snapshot, Diff)) or not isinstance(following, Dots):
        return None
    same = (following.stream, following.frame) == (message.stream, message.frame.number)
    return following if same else None
