"""A connection to a daemon: banner, handshake, channels, pings, goodbye.

In: a connected socket; messages to send, each on a channel. Out: received messages, by channel. Invariants:
* One thread at a time uses a connection. Only the keepalive thread runs beside it, and it sends only `Ping`.
* While sending has to wait, bytes are read. So two sides that both want to write do not block each other.
* A message that `send` has accepted is sent as a whole and in order.
* Received bodies wait undecoded. They take at most `inbox_limit` bytes (and the bytes of a single read).
* All frames, both ways, are in the version agreed on, except an `Error` that ends the handshake.
* Once the connection has ended, messages received before are still returned. Then every use raises the reason.
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
from .timing import Deadline, SilenceTimer
from .version import VERSION
from .wire import BANNER_SIZE, LARGEST_FRAME, LOWEST_VERSION, Banner, FrameBuffer, RawFrame, pack_frame

Expected = TypeVar("Expected", bound=Message)

_READ_SIZE = 1 << 18
_MOST_ANSWERS = 64


@dataclass(frozen=True)
class Options:
    """Options of a connection. All times are in seconds.

    `timeout` is how long a call waits for its answer by default (none: as long as the daemon is alive).
    `connect_timeout` limits connecting and the handshake. `largest_frame` limits the bodies that are read,
    `inbox_limit` the bytes that wait for subscriptions that nobody reads. `daemon_timeout` replaces the `timeout_ms` of
    the daemon to detect that it is silent. With `keepalive` a thread pings the daemon while the connection is idle, so
    that the daemon does not disconnect it.
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
    """One connection, from banner to goodbye."""

    def __init__(self, connected: socket.socket, options: Options) -> None:
        """Does the handshake on a connected socket. The socket is closed if that fails."""
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
        # Channels of dropped subscriptions. Finalizers add to it, and may run at any time.
        self._abandoned: deque[int] = deque()
        self._outbox: deque[memoryview] = deque()
        self._lock = threading.Lock()
        self._last_sent = time.monotonic()
        self._silence = SilenceTimer(None)
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
        """Whether the connection has not ended yet, as far as is known."""
        return self._end is None

    @property
    def version(self) -> int:
        """The protocol version that both sides agreed on."""
        assert self._version is not None
        return self._version

    def check_speaks(self, kind: type[Message]) -> None:
        """Raises `DaemonTooOld` if the agreed version does not have such messages."""
        if kind.SINCE > self.version:
            raise DaemonTooOld(
                f"{kind.__name__} needs version {kind.SINCE} of the protocol, "
                f"but the daemon speaks no higher one than {self.version}: update it"
            )

    def allowed(self, timeout: float | None) -> float | None:
        """The time limit of a call: its own, or the default."""
        return self.options.timeout if timeout is None else timeout

    def open_channel(self) -> int:
        """A channel number that was never used before."""
        self._last_channel += 1
        self._inbox[self._last_channel] = deque()
        return self._last_channel

    def close_channel(self, channel: int) -> None:
        """Closes a channel on this side. Messages that still arrive on it are dropped."""
        for frame in self._inbox.pop(channel, ()):
            self._waiting_bytes -= len(frame.body)

    def abandon(self, channel: int) -> None:
        """Unsubscribes and closes a channel later. May be called at any time and in any thread."""
        self._abandoned.append(channel)

    def send(self, channel: int, message: Message, timeout: float | None = None) -> None:
        """Sends a message. Waits while the daemon does not read.

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
            # The message is queued. Later calls send the rest of it.
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
        """Sends a message and returns its answer. Raises `DaemonError` if that is an error."""
        deadline = Deadline(timeout)
        self.send(channel, question, deadline.left())
        answer = self.receive(channel, deadline.left())
        if isinstance(answer, Error):
            raise as_exception(answer)
        if not isinstance(answer, expected):
            raise ProtocolError(f"{type(question).__name__} was answered with {type(answer).__name__}")
        return answer

    def receive_waiting(self, channel: int) -> Any:
        """The next message on a channel if it has arrived, else none."""
        try:
            return self.receive(channel, timeout=0)
        except TimedOut:
            return None

    def close(self, reason: str = "the client is done", linger: float = 2.0) -> None:
        """Sends `Goodbye` and closes. The daemon has `linger` seconds to read what was sent. Does nothing if closed."""
        if self._end is not None:
            return
        deadline = Deadline(linger)
        try:
            self._wait(self._all_sent, deadline)
            self._put(0, Goodbye(reason, []))
            self._wait(self._all_sent, deadline)
            self._await_end(deadline)
        except (HopesError, OSError) as error:
            # The goodbye cannot be sent, or not in time. The connection is closed all the same.
            self._finish(ConnectionLost(f"this connection was closed: {error}"))
        finally:
            self._finish(ConnectionLost("this connection was closed"))

    def keep_alive(self) -> None:
        """Sends a `Ping` if nothing was sent for some time. The keepalive thread calls it."""
        if self._outbox or time.monotonic() - self._last_sent < self.welcome.timeout_ms / 4000:
            return
        self._line_up(0, Ping(0))
        with contextlib.suppress(OSError):
            # The next use of the connection raises the error.
            self._send_waiting()

    # The handshake.

    def _shake_hands(self, deadline: Deadline) -> Welcome:
        ours = Banner()
        with self._lock:
            self._outbox.append(memoryview(ours.encode()))
        self._version = ours.agree(self._await_banner(deadline))
        # A daemon at its limit of connections sends an error at once, and closes.
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
        self._silence = SilenceTimer(self.options.daemon_timeout or timeout or None)

    # The event loop.

    def _all_sent(self) -> bool:
        return self._end is None and not self._outbox

    def _wait(self, ready: Callable[[], bool], deadline: Deadline) -> None:
        """Reads and writes until `ready`. Raises if the deadline passes or the connection ends before.

        Checks the received messages once, even if the deadline has passed.
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
        limits = [limit for limit in (longest, self._silence.next_check()) if limit is not None]
        writing = selectors.EVENT_WRITE if self._outbox else 0
        self._selector.modify(self._socket, selectors.EVENT_READ | writing)
        started = time.monotonic()
        events = self._selector.select(min(limits, default=None))
        self._silence.waited(time.monotonic() - started, within_frame=len(self._buffer) > 0)
        if any(mask & selectors.EVENT_READ for _, mask in events):
            self._read()
        self._flush()
        self._mind_silence()

    def _mind_silence(self) -> None:
        """Pings a silent daemon, and ends the connection if it is silent for too long."""
        if self._end is None and self._silence.is_over():
            self._finish(PeerSilent(f"the daemon was silent for {self._silence.limit} seconds"))
        elif self._end is None and self._silence.should_ping():
            self._put(0, Ping(0))

    # Writing.

    def _line_up(self, channel: int, message: Message, body: bytearray | None = None) -> None:
        """Queues a message."""
        frame = pack_frame(message.TYPE, channel, encode(message) if body is None else body, self.version)
        with self._lock:
            self._outbox.append(memoryview(frame))

    def _put(self, channel: int, message: Message, body: bytearray | None = None) -> None:
        """Queues a message, and sends what can be sent without waiting."""
        self._line_up(channel, message, body)
        self._flush()

    def _send_waiting(self) -> None:
        """Sends what the socket accepts without waiting."""
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
            # The daemon has closed. Its last messages may still be readable.
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
        """Reads from the socket. Returns false if there is nothing."""
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
        self._silence.heard()
        self._buffer.feed(data)
        self._take_frames()
        return True

    def _take_frames(self) -> None:
        """Decodes all whole frames that were received, once the version is known."""
        while self._version is not None and self._end is None:
            try:
                frame = self._next_frame()
                if frame is None:
                    return
                self._silence.finished_frame()
                self._sort(frame)
            except ProtocolError as error:
                self._finish(error)

    def _next_frame(self) -> RawFrame | None:
        try:
            return self._buffer.next_frame(self.version)
        except UnsupportedVersion:
            if self._welcome is not None:
                raise
            # A daemon that refuses us before it has read our banner uses the lowest version.
            frame = self._buffer.next_frame(LOWEST_VERSION)
            if frame is not None and frame.type != Error.TYPE:
                raise
            return frame

    def _sort(self, frame: RawFrame) -> None:
        """Queues a frame for its channel. Frames of closed channels are dropped."""
        if frame.channel == 0:
            self._handle(decode(frame.type, frame.body, frame.version))
        elif frame.channel in self._inbox:
            self._inbox[frame.channel].append(frame)
            self._waiting_bytes += len(frame.body)

    def _handle(self, message: Message) -> None:
        """Handles a message about the connection itself."""
        if isinstance(message, Welcome) and self._welcome is None:
            self._welcome = message
        elif isinstance(message, Ping):
            # A daemon that sends pings and does not read must not fill the memory with answers.
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
        """Reads and drops until the daemon closes. To close with unread bytes could destroy what was sent last."""
        self._socket.shutdown(socket.SHUT_WR)
        self._selector.modify(self._socket, selectors.EVENT_READ)
        while not deadline.passed():
            if self._selector.select(deadline.left()) and not self._socket.recv(_READ_SIZE):
                return

    def _finish(self, reason: HopesError) -> None:
        """Ends the connection. The first reason is kept."""
        if self._end is not None:
            return
        self._end = reason
        if self._keepalive is not None:
            self._keepalive.stop()
        self._selector.close()
        with self._lock:
            self._outbox.clear()
            self._socket.close()
