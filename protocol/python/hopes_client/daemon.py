"""The interface of a daemon for programs.

In: an address. Out: `connect`, and `Daemon` with producers, subscriptions and requests. Invariant: if a `with` block
ends without an error, the daemon has answered everything that producers sent.
"""

from __future__ import annotations

from types import TracebackType
from typing import Any, Callable, TypeVar

from .admin import Peer
from .connection import Connection, Options, open_socket
from .consumer import FollowOptions, Subscription
from .link import Link
from .messages import (
    Disconnect,
    Disconnected,
    GetMemory,
    GetStatus,
    ListPeers,
    ListStreams,
    Memory,
    Message,
    Peers,
    Status,
    StopStream,
    StreamInfo,
    Streams,
    StreamStopped,
    Welcome,
)
from .mirror import Mirror
from .producer import Producer
from .shared import DotsWanted, View, Window
from .spaces import ListSpaces, Metric, SpaceInfo, Spaces
from .tracks import TracksWanted

Expected = TypeVar("Expected", bound=Message)


class Daemon:
    """A connection to a daemon. It, its producers and its subscriptions may be used by one thread at a time."""

    def __init__(self, dial: Callable[[], Connection]) -> None:
        """`dial` makes a connection. It is called again when a subscription reconnects."""
        self._link = Link(dial)
        self._producers: list[Producer] = []

    @property
    def connection(self) -> Connection:
        """The current connection."""
        return self._link.current

    @property
    def welcome(self) -> Welcome:
        """The daemon's `Welcome`."""
        return self._link.current.welcome

    def producer(
        self,
        name: str,
        *,
        window: Window | None = None,
        resolution: float | None = None,
        metric: str | Metric | None = None,
        dimension: int | None = None,
        timeout: float | None = None,
    ) -> Producer:
        """Joins a stream, or creates it with these options. An existing stream must have the options that are given.

        With `metric` ("euclidean", "manhattan", "chebyshev", "angular", "haversine") or `dimension` the stream is one of
        points in R^d, else of the plane. The first point fixes the dimension if nothing else has. It raises
        `DaemonTooOld` if no protocol version of the daemon has such streams.
        """
        producer = Producer(self.connection, name, window, resolution, timeout, metric, dimension)
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
        dots_wait: float = FollowOptions.dots_wait,
        stop_when_closed: bool | None = None,
    ) -> Subscription:
        """Follows every stream, now or later, whose name matches. `*` stands for any run of characters.

        The view is HoPeS(C) (`full`, the default), HoPeS(C; alpha) or HoPeS_{k,l}(C), simplified at its own scale if
        `simplify` is true, or below a threshold.

        `tracks` is "events" for the events of tracks, "alive" for a list of living tracks in every frame too, or
        "cycles" for their cycles too. It raises `DaemonTooOld` if no protocol version of the daemon has tracks. If the
        daemon was started without tracks, the iteration raises `DaemonError` with code 9, and may go on without tracks.

        `resume` is a mirror of an earlier subscription in the same view: frames continue from there if the daemon still
        can. `stop_when_closed` is true for the name of a single stream, unless `reconnect` is set. For `timeout`,
        `reconnect` and `dots_wait` see `FollowOptions`.
        """
        view = View.of(full, alpha, k, l, simplify)
        if resume is not None and (resume.name != pattern or resume.view != view):
            raise ValueError(f"a mirror of {resume.name!r} in the view {resume.view} cannot be resumed by this")
        single = "*" not in pattern and not reconnect
        stop = single if stop_when_closed is None else stop_when_closed
        options = FollowOptions(timeout, reconnect, dots_wait, stop)
        wanted = TracksWanted.of(tracks)
        return Subscription(self._link, pattern, view, dots or DotsWanted.no(), options, resume, wanted)

    def list_streams(self, pattern: str = "*", *, timeout: float | None = None) -> list[StreamInfo]:
        """The streams whose names match."""
        return self._ask(ListStreams(pattern), Streams, timeout).streams

    def list_spaces(self, *, timeout: float | None = None) -> list[SpaceInfo]:
        """The streams of points in R^d, by number. All others are of the plane. `DaemonTooOld` as with `producer`."""
        return self._ask(ListSpaces(), Spaces, timeout).streams

    def status(self, *, timeout: float | None = None) -> Status:
        """The state of the daemon."""
        return self._ask(GetStatus(), Status, timeout)

    def peers(self, *, timeout: float | None = None) -> list[Peer]:
        """The daemon's peers, this client among them, by number. `DaemonTooOld` if no version of the daemon has this;
        so with the three methods below.
        """
        return self._ask(ListPeers(), Peers, timeout).peers

    def memory(self, *, timeout: float | None = None) -> Memory:
        """What the daemon's memory is used for."""
        return self._ask(GetMemory(), Memory, timeout)

    def stop_stream(self, name: str, *, timeout: float | None = None) -> int:
        """Ends a stream for everybody, and gives its last frame. `DaemonError` with code 17 if there is none."""
        return self._ask(StopStream(name), StreamStopped, timeout).frame

    def disconnect(self, peer: int, *, timeout: float | None = None) -> None:
        """Ends the connection of a peer, by its number. `DaemonError` with code 18 if there is none."""
        self._ask(Disconnect(peer), Disconnected, timeout)

    def close(self, reason: str = "the client is done") -> None:
        """Waits until all messages of producers are answered, sends `Goodbye` and closes."""
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
        """Sends a request on its own channel."""
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
