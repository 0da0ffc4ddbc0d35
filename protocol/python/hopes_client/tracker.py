"""Turns the messages of one subscription, or of a recording of one, into frames.

In: messages in the order of arrival. Out: a `Frame` for each message that makes one. Invariants: each announced stream
has one mirror until it is closed. A mirror from before a lost connection is used only if the daemon sends `Resumed`;
its tracks start again. `ResyncNeeded` means that the streams must be subscribed to again.
"""

from __future__ import annotations

from collections.abc import Iterable

from .errors import ResyncNeeded
from .frame import Frame
from .messages import Lagged, Message, Resumed, StreamClosed, StreamOpened
from .mirror import Mirror
from .spaces import DIFFS, DOTS, SNAPSHOTS, TRACKS, AnyDiff, AnyDots, AnySnapshot, AnyTracks
from .track_mirror import TrackMirror


class Tracker:
    """The mirrors of the streams of one subscription.

    `kept` are mirrors that may be resumed. If streams need not be `announced`, a stream without announcement has no
    name.
    """

    def __init__(self, kept: Iterable[Mirror] = (), announced: bool = True) -> None:
        self._announced = announced
        self._kept = {mirror.name: mirror for mirror in kept}
        self._mirrors: dict[int, Mirror] = {}
        self._lagged: dict[int, tuple[int, int]] = {}
        self._takes_tracks = True

    def mirrors(self) -> dict[str, Mirror]:
        """The mirror of each stream by its name, including kept ones that are not resumed yet."""
        return {**self._kept, **{mirror.name: mirror for mirror in self._mirrors.values()}}

    def take(self, message: Message, elapsed: float | None = None) -> Frame | None:
        """The frame of a message. None if it makes none."""
        if isinstance(message, StreamOpened):
            self._mirrors[message.stream] = Mirror(message.name, message.epoch)
        elif isinstance(message, StreamClosed):
            self._mirrors.pop(message.stream, None)
            self._lagged.pop(message.stream, None)
        elif isinstance(message, Resumed):
            self._resume(message)
        elif isinstance(message, Lagged):
            self._lagged[message.stream] = (message.first, message.last)
        elif isinstance(message, (*SNAPSHOTS, *DIFFS)):
            return self._frame(message, elapsed)
        elif isinstance(message, (*DOTS, *TRACKS)):
            return self._more(message, elapsed)
        return None

    def forget_tracks(self, wanted: bool) -> None:
        """Ignores tracks until the daemon has listed all of them again, or for good if they are not requested."""
        self._takes_tracks = wanted
        for mirror in self._mirrors.values():
            mirror.tracks = TrackMirror()

    def complete(self, frame: Frame, more: AnyDots | AnyTracks) -> None:
        """Adds to a frame what followed it directly (see `more_of`)."""
        if self._take_more(more):
            frame.renew(more.events if isinstance(more, TRACKS) else [])

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
        mirror.tracks = TrackMirror()
        self._mirrors[message.stream] = mirror

    def _frame(self, message: AnySnapshot | AnyDiff, elapsed: float | None) -> Frame:
        mirror = self._mirror(message.stream)
        lagged = self._lagged.pop(message.stream, None)
        if isinstance(message, SNAPSHOTS):
            mirror.apply_snapshot(message)
            self._kept.pop(mirror.name, None)
            return Frame(mirror, message.frame, "snapshot", cause=message.cause.case, lagged=lagged, elapsed=elapsed)
        mirror.apply_diff(message)
        return Frame(mirror, message.frame, "diff", diff=message, lagged=lagged, elapsed=elapsed)

    def _more(self, message: AnyDots | AnyTracks, elapsed: float | None) -> Frame | None:
        """A frame in which only dots or tracks are new."""
        if not self._take_more(message):
            return None
        mirror = self._mirror(message.stream)
        assert mirror.header is not None
        kind, events = ("dots", []) if isinstance(message, DOTS) else ("tracks", message.events)
        return Frame(mirror, mirror.header, kind, track_events=events, elapsed=elapsed)

    def _take_more(self, message: AnyDots | AnyTracks) -> bool:
        """Whether the message is handled. Tracks are not, until all of them were listed again."""
        mirror = self._mirror(message.stream)
        if mirror.header is None or message.frame > mirror.number:
            what = "dots" if isinstance(message, DOTS) else "tracks"
            raise ResyncNeeded(f"{what} of frame {message.frame} come before that frame")
        if isinstance(message, DOTS):
            mirror.apply_dots(message)
        elif not self._takes_tracks or (mirror.tracks.number == 0 and message.from_ > 0):
            return False
        else:
            mirror.tracks.apply(message)
        return True


def more_of(message: Message, following: Message | None) -> AnyDots | AnyTracks | None:
    """`following`, if it has dots or tracks of the frame of `message`."""
    if not isinstance(message, (*SNAPSHOTS, *DIFFS)) or not isinstance(following, (*DOTS, *TRACKS)):
        return None
    same = (following.stream, following.frame) == (message.stream, message.frame.number)
    return following if same else None
