"""A daemon, as programs see it.

In: an address. Out: `connect`, and `Daemon` with its producers, subscriptions and questions.
Invariant: leaving a `with` block without an error means that the daemon has answered all that producers sent.
"""

from __future__ import annotations

from types import TracebackType
from typing import Any, Callable, TypeVar

from .connection import Connection, Options, open_socket
from .consumer import Habits, Subscription
from .link import Link
from .messages import GetStatus, ListStreams, Message, Status, StreamInfo, Streams, Welcome
from .mirror import Mirror
from .producer import Producer
from .shared import DotsWanted, View, Window
from .tracks import TracksWanted

Expected = TypeVar("Expected", bound=Message)


class Daemon:
    """A connection to a daemon. One thread at a time may use it and what it gives."""

    def __init__(self, dial: Callable[[], Connection]) -> None:
        """`dial` makes a connection; it is called again when a subscription reconnects."""
        self._link = Link(dial)
        self._producers: list[Producer] = []

    @property
    def connection(self) -> Connection:
        """The connection in use."""
        return self._link.current

    @property
    def welcome(self) -> Welcome:
        """What the daemon said of itself."""
        return self._link.current.welcome

    def producer(
        self,
        name: str,
        *,
        window: Window | None = None,
        resolution: float | None = None,
        timeout: float | None = None,
    ) -> Producer:
        """Joins a stream, or creates it with these options. A stream that is there must have those that are given."""
        producer = Producer(self.connection, name, window, resolution, timeout)
        self._producers = [other for other in self._producers if other.is_open or other.unanswered] + [producer]
        return producer

    def follow(
        self,
        pattern: str,
        *,
        full: bool = False,
        alpha: float | None = None,
        k: int | None = None,
        l: int | None = None,
        simplify: bool | float = False,
        dots: DotsWanted | None = None,
        tracks: str | None = None,
        resume: Mirror | None = None,
        reconnect: bool = False,
        timeout: float | None = None,
        dots_wait: float = Habits.dots_wait,
        stop_when_closed: bool | None = None,
    ) -> Subscription:
        """Follows every stream, now or later, whose name matches; `*` stands for any run of characters.

        The view is HoPeS(C) (`full`, the default), HoPeS(C; alpha) or HoPeS_{k,l}(C), simplified at its own scale if
        `simplify` is true, or below a threshold. `tracks` is "events" to be told what happens to tracks, "alive" to be told
        of all living ones in every frame, or "cycles" to be told of their cycles too: `DaemonTooOld` if the daemon speaks
        no version of the protocol that has tracks, `DaemonError` with code 9 from the iteration, which may go on without
        tracks, if it was started to follow none. `resume` is a mirror of an earlier subscription in the same view:
        frames go on from there if the daemon still knows how. `stop_when_closed` is true for the name of a single
        stream, unless `reconnect` asks to outlive it.
        For `timeout`, `reconnect` and `dots_wait` see `Habits`.
        """
        view = View.of(full, alpha, k, l, simplify)
        if resume is not None and (resume.name != pattern or resume.view != view):
            raise ValueError(f"a mirror of {resume.name!r} in the view {resume.view} cannot be resumed by this")
        single = "*" not in pattern and not reconnect
        stop = single if stop_when_closed is None else stop_when_closed
        habits = Habits(timeout, reconnect, dots_wait, stop)
        wanted = TracksWanted.of(tracks)
        return Subscription(self._link, pattern, view, dots or DotsWanted.no(), habits, resume, wanted)

    def list_streams(self, pattern: str = "*", *, timeout: float | None = None) -> list[StreamInfo]:
        """The streams whose names match."""
        return self._ask(ListStreams(pattern), Streams, timeout).streams

    def status(self, *, timeout: float | None = None) -> Status:
        """The state of the daemon."""
        return self._ask(GetStatus(), Status, timeout)

    def close(self, reason: str = "the client is done") -> None:
        """Waits until all that producers sent is answered, says goodbye and closes."""
        producers, self._producers = self._producers, []
        try:
            for producer in producers:
                producer.finish()
        finally:
            self._link.close(reason)

    def __enter__(self) -> Daemon:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()
        else:
            self._link.close(f"the client failed: {kind.__name__}")

    def _ask(self, question: Message, expected: type[Expected], timeout: float | None) -> Expected:
        """Asks a question on a channel of its own."""
        connection = self.connection
        channel = connection.open_channel()
        try:
            return connection.ask(channel, question, expected, connection.allowed(timeout))
        finally:
            connection.close_channel(channel)


def connect(address: str, **options: Any) -> Daemon:
    """Connects to the daemon at `unix:PATH` or `tcp:HOST:PORT`. The options are the fields of `Options`."""
    settings = Options(**options)

    def dial() -> Connection:
        return Connection(open_socket(address, settings.connect_timeout), settings)

    return Daemon(dial)
