"""A scripted daemon in a thread.

In: a script: a function of a `Fake`. Out: a `Connection` or `Daemon` that is connected to it. Invariants: an error in a
script fails its test. No wait is longer than `TIMEOUT` seconds.
"""

from __future__ import annotations

import contextlib
import socket
import threading
from collections.abc import Iterator
from typing import Any, Callable

from hopes_client import messages as m
from hopes_client.connection import Connection, Options
from hopes_client.daemon import Daemon
from hopes_client.wire import BANNER_SIZE, HIGHEST_VERSION, Banner, FrameBuffer, pack_frame

TIMEOUT = 5.0
WELCOME = m.Welcome("fake", [], 77, 1 << 20, 100, 1000, 60_000)


class Fake:
    """One connection, seen from a daemon that supports `version` and all before."""

    def __init__(self, connected: socket.socket, version: int = HIGHEST_VERSION) -> None:
        self.version = version
        self.socket = connected
        self.socket.settimeout(TIMEOUT)
        self._buffer = FrameBuffer()

    def read_banner(self) -> Banner:
        while len(self._buffer) < BANNER_SIZE:
            self._read()
        banner = self._buffer.next_banner()
        assert banner is not None
        return banner

    def shake_hands(self, welcome: m.Welcome = WELCOME) -> m.Hello:
        self.read_banner()
        self.socket.sendall(Banner(1, self.version).encode())
        hello: m.Hello = self.receive(0, m.Hello)
        self.send(0, welcome)
        return hello

    def send(self, channel: int, message: m.Message) -> None:
        self.socket.sendall(pack_frame(message.TYPE, channel, m.encode(message), self.version))

    def next(self) -> tuple[int, Any]:
        """The next message and its channel."""
        while True:
            frame = self._buffer.next_frame(self.version)
            if frame is not None:
                return frame.channel, m.decode(frame.type, frame.body, frame.version)
            self._read()

    def receive(self, channel: int, kind: type) -> Any:
        """The next message, which must be of this type."""
        its_channel, message = self.next()
        assert isinstance(message, kind), message
        assert its_channel == channel, its_channel
        return message

    def serve_goodbye(self) -> None:
        """Waits for `Goodbye`. Other messages before it are ignored."""
        while not isinstance(self.next()[1], m.Goodbye):
            pass

    def _read(self) -> None:
        data = self.socket.recv(1 << 16)
        if not data:
            raise EOFError("the client closed the connection")
        self._buffer.feed(data)


Script = Callable[[Fake], None]


class Stage:
    """Runs a script for each connection that is made."""

    def __init__(self, *scripts: Script, version: int = HIGHEST_VERSION) -> None:
        self._version = version
        self._scripts = list(scripts)
        self._threads: list[threading.Thread] = []
        self.failures: list[Exception] = []

    def dial(self) -> socket.socket:
        """A socket that is connected to the next script."""
        if not self._scripts:
            raise ConnectionRefusedError("there is no script for this connection")
        script = self._scripts.pop(0)
        ours, theirs = socket.socketpair()
        thread = threading.Thread(target=self._play, args=(script, theirs), daemon=True)
        thread.start()
        self._threads.append(thread)
        return ours

    def join(self) -> None:
        """Waits for the scripts and raises their errors."""
        for thread in self._threads:
            thread.join(TIMEOUT)
            if thread.is_alive():
                raise AssertionError("a script did not end")
        if self.failures:
            raise self.failures[0]

    def _play(self, script: Script, connected: socket.socket) -> None:
        with connected:
            try:
                script(Fake(connected, self._version))
            except Exception as error:  # noqa: BLE001 (the test raises it)
                self.failures.append(error)


@contextlib.contextmanager
def connection(script: Script, **options: Any) -> Iterator[Connection]:
    """A connection to a script that does the handshake itself."""
    stage = Stage(script)
    made = Connection(stage.dial(), Options(timeout=TIMEOUT, **options))
    try:
        yield made
    finally:
        made.close(linger=0.2)
    stage.join()


@contextlib.contextmanager
def daemon(*scripts: Script, version: int = HIGHEST_VERSION, **options: Any) -> Iterator[Daemon]:
    """A `Daemon` on scripts that begin after the handshake, one for each connection."""

    def with_handshake(script: Script) -> Script:
        def play(fake: Fake) -> None:
            fake.shake_hands()
            script(fake)

        return play

    stage = Stage(*map(with_handshake, scripts), version=version)
    settings = Options(timeout=TIMEOUT, **options)
    made = Daemon(lambda: Connection(stage.dial(), settings))
    try:
        yield made
    finally:
        made.connection.close(linger=0.2)
    stage.join()
