"""A connection to a daemon: banner, handshake, channels, pings, goodbye.

In: a connected socket; messages to send, each on a channel. Out: the messages that came, by channel.
Invariants:
* one thread at a time uses a connection; only the keepalive thread runs beside it, and does nothing but send `Ping`;
* bytes are read while sending has to wait, so that two sides that both want to write never wait for each other;
* a message that was taken by `send` goes out whole and in order; bodies wait undecoded, and not more than
  `inbox_limit` bytes of them (and what a single read brings);
* all frames, both ways, are in the version agreed on (but for an `Error` that ends the handshake);
* once the connection has ended, what had come before is still given out, and then the reason is raised, every time.
"""

from __future__ import annotations

import contextlib
import selectors
import socket
import threading
import time
from collections import deque
from dataclasses import dataclass
from typing import Any, Callable, TypeVar

from .errors import (
    ConnectionLost,
    DaemonClosed,
    DaemonError,
    DaemonTooOld,
    HopesError,
    InboxFull,
    PeerSilent,
    ProtocolError,
    TimedOut,
    UnsupportedVersion,
)
from .keepalive import Keepalive
from .messages import Error, Goodbye, Hello, Message, Ping, Pong, Unsubscribe, Welcome, decode, encode
from .patience import Deadline, Patience
from .version import VERSION
from .wire import BANNER_SIZE, LARGEST_FRAME, LOWEST_VERSION, Banner, FrameBuffer, RawFrame, pack_frame

Expected = TypeVar("Expected", bound=Message)

_READ_SIZE = 1 << 18
_MOST_ANSWERS = 64


@dataclass(frozen=True)
class Options:
    """How a connection behaves; all times are in seconds.

    `timeout` is how long a call waits for its answer unless it is told otherwise (none: as long as the daemon lives),
    `connect_timeout` how long connecting and the handshake may take. `largest_frame` caps the bodies that are read,
    `inbox_limit` the bytes that wait for subscriptions that nobody reads. `daemon_timeout` is used in place of the
    `timeout_ms` of the daemon to find out that it is silent. With `keepalive` a thread pings the daemon when nobody
    uses the connection, so that the daemon does not cut it off.
    """

    timeout: float | None = None
    connect_timeout: float = 10.0
    largest_frame: int = LARGEST_FRAME
    inbox_limit: int = 1 << 28
    daemon_timeout: float | None = None
    keepalive: bool = True
    software: str = f"hopes-client (Python) {VERSION}"


def open_socket(address: str, timeout: float) -> socket.socket:
    """A socket connected to `unix:PATH` or `tcp:HOST:PORT`."""
    kind, _, place = address.partition(":")
    host, _, port = place.rpartition(":")
    if kind == "unix" and place:
        connected = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        connected.settimeout(timeout)
        try:
            connected.connect(place)
        except BaseException:
            connected.close()
            raise
        return connected
    if kind == "tcp" and host and port.isdigit():
        connected = socket.create_connection((host.strip("[]"), int(port)), timeout)
        connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return connected
    raise ValueError(f"{address!r} is neither unix:PATH nor tcp:HOST:PORT")


def as_exception(error: Error) -> DaemonError:
    """The exception for an `Error` message."""
    return DaemonError(error.code, error.answers, error.text)


class Connection:
    """One connection, from the banner to the goodbye."""

    def __init__(self, connected: socket.socket, options: Options) -> None:
        """Shakes hands over a connected socket, which is closed if that fails."""
        self.options = options
        self._socket = connected
        self._socket.setblocking(False)
        self._selector = selectors.DefaultSelector()
        self._selector.register(connected, selectors.EVENT_READ)
        self._buffer = FrameBuffer(options.largest_frame)
        self._version: int | None = None
        self._welcome: Welcome | None = None
        self._inbox: dict[int, deque[RawFrame]] = {}
        self._waiting_bytes = 0
        self._last_channel = 0
        # Channels whose subscriptions were forgotten, noted by finalizers, which may run at any time.
        self._abandoned: deque[int] = deque()
        self._outbox: deque[memoryview] = deque()
        self._lock = threading.Lock()
        self._last_sent = time.monotonic()
        self._patience = Patience(None)
        self._keepalive: Keepalive | None = None
        self._end: HopesError | None = None
        try:
            self.welcome = self._shake_hands(Deadline(options.connect_timeout))
        except BaseException as error:
            self._finish(ConnectionLost(f"the handshake failed: {error}"))
            raise
        self._start_timers()

    @property
    def is_alive(self) -> bool:
        """Whether the connection has not ended, as far as is known."""
        return self._end is None

    @property
    def version(self) -> int:
        """The protocol version that was agreed on."""
        assert self._version is not None
        return self._version

    def check_speaks(self, kind: type[Message]) -> None:
        """`DaemonTooOld` if the version that was agreed on has no such messages."""
        if kind.SINCE > self.version:
            raise DaemonTooOld(
                f"{kind.__name__} needs version {kind.SINCE} of the protocol, "
                f"but the daemon speaks no higher one than {self.version}: update it"
            )

    def allowed(self, timeout: float | None) -> float | None:
        """How long a call may take that was told to take this long, or was not told."""
        return self.options.timeout if timeout is None else timeout

    def open_channel(self) -> int:
        """The number of a channel that was never used before."""
        self._last_channel += 1
        self._inbox[self._last_channel] = deque()
        return self._last_channel

    def close_channel(self, channel: int) -> None:
        """Forgets a channel: what still comes on it is dropped."""
        for frame in self._inbox.pop(channel, ()):
            self._waiting_bytes -= len(frame.body)

    def abandon(self, channel: int) -> None:
        """Unsubscribes and forgets a channel, later; may be called at any time and in any thread."""
        self._abandoned.append(channel)

    def send(self, channel: int, message: Message, timeout: float | None = None) -> None:
        """Sends a message; waits while the daemon takes no more.

        `TimedOut` means that the message was not sent and will not be.
        """
        self.check_speaks(type(message))
        body = encode(message)
        if self._welcome and len(body) > self._welcome.largest_frame:
            raise ValueError(f"{len(body)} bytes are more than the {self._welcome.largest_frame} that the daemon reads")
        deadline = Deadline(timeout)
        self._forget_abandoned()
        self._wait(self._all_sent, deadline)
        self._put(channel, message, body)
        with contextlib.suppress(TimedOut):
            # The message has its place in the line: the calls that follow send what is left of it.
            self._wait(self._all_sent, deadline)

    def receive(self, channel: int, timeout: float | None = None) -> Any:
        """The next message on a channel."""
        self._forget_abandoned()
        inbox = self._inbox[channel]
        self._wait(lambda: len(inbox) > 0, Deadline(timeout))
        frame = inbox.popleft()
        self._waiting_bytes -= len(frame.body)
        return decode(frame.type, frame.body, frame.version)

    def ask(self, channel: int, question: Message, expected: type[Expected], timeout: float | None = None) -> Expected:
        """Sends a message and gives its answer; `DaemonError` if that is an error."""
        deadline = Deadline(timeout)
        self.send(channel, question, deadline.left())
        answer = self.receive(channel, deadline.left())
        if isinstance(answer, Error):
            raise as_exception(answer)
        if not isinstance(answer, expected):
            raise ProtocolError(f"{type(question).__name__} was answered with {type(answer).__name__}")
        return answer

    def receive_waiting(self, channel: int) -> Any:
        """The next message on a channel if it has come already, else none."""
        try:
            return self.receive(channel, timeout=0)
        except TimedOut:
            return None

    def close(self, reason: str = "the client is done", linger: float = 2.0) -> None:
        """Says goodbye and closes; gives the daemon `linger` seconds to read what was sent. Does nothing if closed."""
        if self._end is not None:
            return
        deadline = Deadline(linger)
        try:
            self._wait(self._all_sent, deadline)
            self._put(0, Goodbye(reason, []))
            self._wait(self._all_sent, deadline)
            self._await_end(deadline)
        except (HopesError, OSError) as error:
            # There is nobody, or nobody in time, to say goodbye to: a reason to close all the same.
            self._finish(ConnectionLost(f"this connection was closed: {error}"))
        finally:
            self._finish(ConnectionLost("this connection was closed"))

    def keep_alive(self) -> None:
        """Sends a `Ping` if nothing was sent for a while. For the keepalive thread."""
        if self._outbox or time.monotonic() - self._last_sent < self.welcome.timeout_ms / 4000:
            return
        self._line_up(0, Ping(0))
        with contextlib.suppress(OSError):
            # Whoever uses the connection next finds out if it broke.
            self._send_waiting()

    # The handshake.

    def _shake_hands(self, deadline: Deadline) -> Welcome:
        ours = Banner()
        with self._lock:
            self._outbox.append(memoryview(ours.encode()))
        self._version = ours.agree(self._await_banner(deadline))
        # A daemon that wants no more connections says so at once, and closes.
        self._take_frames()
        self._put(0, Hello(self.options.software, []))
        self._wait(lambda: self._welcome is not None, deadline)
        assert self._welcome is not None
        return self._welcome

    def _await_banner(self, deadline: Deadline) -> Banner:
        self._wait(lambda: len(self._buffer) >= BANNER_SIZE, deadline)
        banner = self._buffer.next_banner()
        assert banner is not None
        return banner

    def _start_timers(self) -> None:
        timeout = self.welcome.timeout_ms / 1000
        if timeout > 0 and self.options.keepalive and self._end is None:
            self._keepalive = Keepalive(self, timeout / 8)
        self._patience = Patience(self.options.daemon_timeout or timeout or None)

    # The loop in which everything waits.

    def _all_sent(self) -> bool:
        return self._end is None and not self._outbox

    def _wait(self, ready: Callable[[], bool], deadline: Deadline) -> None:
        """Reads and writes until `ready`; raises if the deadline passes or the connection ends before.

        Looks once at what has come even if the deadline has passed already.
        """
        self._flush()
        looked = False
        while not ready():
            if self._end is not None:
                raise self._end.with_traceback(None)
            if looked and deadline.passed():
                raise TimedOut("the daemon did not answer in time")
            self._turn(deadline.left())
            looked = True

    def _turn(self, longest: float | None) -> None:
        """Waits for the socket once, and reads and writes what it allows."""
        if self._waiting_bytes > self.options.inbox_limit:
            self._finish(
                InboxFull("too much has come for subscriptions that nobody reads: give them their own connection")
            )
            return
        limits = [limit for limit in (longest, self._patience.next_check()) if limit is not None]
        writing = selectors.EVENT_WRITE if self._outbox else 0
        self._selector.modify(self._socket, selectors.EVENT_READ | writing)
        started = time.monotonic()
        events = self._selector.select(min(limits, default=None))
        self._patience.waited(time.monotonic() - started, within_frame=len(self._buffer) > 0)
        if any(mask & selectors.EVENT_READ for _, mask in events):
            self._read()
        self._flush()
        self._mind_silence()

    def _mind_silence(self) -> None:
        """Asks a daemon that is silent whether it is there, and gives it up if it is silent for too long."""
        if self._end is None and self._patience.is_over():
            self._finish(PeerSilent(f"the daemon was silent for {self._patience.limit} seconds"))
        elif self._end is None and self._patience.should_ask():
            self._put(0, Ping(0))

    # Writing.

    def _line_up(self, channel: int, message: Message, body: bytearray | None = None) -> None:
        """Gives a message its place in the line."""
        frame = pack_frame(message.TYPE, channel, encode(message) if body is None else body, self.version)
        with self._lock:
            self._outbox.append(memoryview(frame))

    def _put(self, channel: int, message: Message, body: bytearray | None = None) -> None:
        """Gives a message its place in the line, and sends what can be sent at once."""
        self._line_up(channel, message, body)
        self._flush()

    def _send_waiting(self) -> None:
        """Sends what the socket takes without waiting."""
        with self._lock:
            while self._outbox:
                head = self._outbox[0]
                try:
                    sent = self._socket.send(head)
                except BlockingIOError:
                    return
                self._last_sent = time.monotonic()
                if sent == len(head):
                    self._outbox.popleft()
                else:
                    self._outbox[0] = head[sent:]

    def _flush(self) -> None:
        if self._end is not None:
            return
        try:
            self._send_waiting()
        except OSError as error:
            # The daemon has closed; its last words may still be here to be read.
            while self._end is None and self._waiting_bytes <= self.options.inbox_limit and self._read():
                pass
            self._finish(ConnectionLost(f"the daemon closed the connection: {error}"))

    def _forget_abandoned(self) -> None:
        while self._abandoned:
            channel = self._abandoned.popleft()
            if channel in self._inbox and self._end is None:
                self._put(channel, Unsubscribe())
            self.close_channel(channel)

    # Reading.

    def _read(self) -> bool:
        """Takes what the socket has; false if it has nothing."""
        try:
            data = self._socket.recv(_READ_SIZE)
        except BlockingIOError:
            return False
        except OSError as error:
            self._finish(ConnectionLost(f"the connection broke: {error}"))
            return False
        if not data:
            where = "in the midst of a frame" if len(self._buffer) else "without a goodbye"
            self._finish(ConnectionLost(f"the daemon closed the connection {where}"))
            return False
        self._patience.heard()
        self._buffer.feed(data)
        self._take_frames()
        return True

    def _take_frames(self) -> None:
        """Takes all whole frames from what was read, once the version is known."""
        while self._version is not None and self._end is None:
            try:
                frame = self._next_frame()
                if frame is None:
                    return
                self._patience.finished_frame()
                self._sort(frame)
            except ProtocolError as error:
                self._finish(error)

    def _next_frame(self) -> RawFrame | None:
        try:
            return self._buffer.next_frame(self.version)
        except UnsupportedVersion:
            if self._welcome is not None:
                raise
            # A daemon that refuses us before it has read our banner does so in the lowest version.
            frame = self._buffer.next_frame(LOWEST_VERSION)
            if frame is not None and frame.type != Error.TYPE:
                raise
            return frame

    def _sort(self, frame: RawFrame) -> None:
        """Puts a frame where it belongs; those of channels that are closed belong nowhere."""
        if frame.channel == 0:
            self._handle(decode(frame.type, frame.body, frame.version))
        elif frame.channel in self._inbox:
            self._inbox[frame.channel].append(frame)
            self._waiting_bytes += len(frame.body)

    def _handle(self, message: Message) -> None:
        """Deals with a message about the connection itself."""
        if isinstance(message, Welcome) and self._welcome is None:
            self._welcome = message
        elif isinstance(message, Ping):
            # A daemon that asks and asks but does not read must not fill the memory with answers.
            if len(self._outbox) < _MOST_ANSWERS:
                self._put(0, Pong(message.token))
        elif isinstance(message, Goodbye):
            self._finish(DaemonClosed(message.reason, dict(message.streams)))
        elif isinstance(message, Error):
            self._finish(as_exception(message))
        elif not isinstance(message, Pong):
            self._finish(ProtocolError(f"{type(message).__name__} came on channel 0"))

    # The end.

    def _await_end(self, deadline: Deadline) -> None:
        """Reads, and drops, until the daemon closes: to close with bytes unread could destroy what was sent last."""
        self._socket.shutdown(socket.SHUT_WR)
        self._selector.modify(self._socket, selectors.EVENT_READ)
        while not deadline.passed():
            if self._selector.select(deadline.left()) and not self._socket.recv(_READ_SIZE):
                return

    def _finish(self, reason: HopesError) -> None:
        """Closes for good; the first reason stays."""
        if self._end is not None:
            return
        self._end = reason
        if self._keepalive is not None:
            self._keepalive.stop()
        self._selector.close()
        with self._lock:
            self._outbox.clear()
            self._socket.close()
