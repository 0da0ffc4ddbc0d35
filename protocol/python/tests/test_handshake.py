"""Connections: banner, handshake, pings, timeouts, goodbye, and errors of the other side."""

from __future__ import annotations

import dataclasses
import gc
import socket
import struct
import tempfile
import threading
import time
import unittest
import warnings
from pathlib import Path

import hopes_client as hopes
from hopes_client import messages as m
from hopes_client.connection import Connection, Options, open_socket
from hopes_client.tracks import TracksWanted
from hopes_client.wire import Banner, pack_frame

from .fake import WELCOME, Fake, Stage, connection, daemon

# Short enough for a quick test, long enough for a busy machine.
SHORT_TIMEOUT = dataclasses.replace(WELCOME, timeout_ms=400)


def idle(fake: Fake) -> None:
    """Sends nothing and waits for `Goodbye`."""
    fake.serve_goodbye()


class Handshake(unittest.TestCase):
    def failing(self, script: object, error: type[Exception], **options: object) -> Exception:
        """The error with which the handshake fails."""
        stage = Stage(script)  # type: ignore[arg-type]
        with self.assertRaises(error) as caught:
            Connection(stage.dial(), Options(**{"connect_timeout": 5.0, **options}))  # type: ignore[arg-type]
        stage.join()
        return caught.exception

    def test_it_works(self) -> None:
        def script(fake: Fake) -> None:
            self.assertEqual(fake.read_banner(), Banner(1, 4))
            fake.socket.sendall(Banner(1, 7).encode())
            hello = fake.receive(0, m.Hello)
            self.assertIn("hopes-client", hello.software)
            self.assertEqual(hello.capabilities, [])
            fake.send(0, dataclasses.replace(WELCOME, capabilities=["unheard-of"]))
            goodbye = fake.receive(0, m.Goodbye)
            self.assertEqual(goodbye.streams, [])

        with connection(script) as made:
            self.assertEqual((made.welcome.epoch, made.version), (77, 4))
            self.assertTrue(made.is_alive)
        self.assertFalse(made.is_alive)

    def test_hello_waits_for_the_banner(self) -> None:
        def script(fake: Fake) -> None:
            fake.read_banner()
            fake.socket.settimeout(0.1)
            with self.assertRaises(socket.timeout):
                fake.next()
            fake.socket.settimeout(5.0)
            fake.socket.sendall(Banner().encode())
            fake.receive(0, m.Hello)
            fake.send(0, WELCOME)
            fake.serve_goodbye()

        with connection(script):
            pass

    def test_everything_byte_by_byte(self) -> None:
        def script(fake: Fake) -> None:
            fake.read_banner()
            welcome = pack_frame(WELCOME.TYPE, 0, m.encode(WELCOME))
            for byte in Banner().encode() + welcome:
                fake.socket.sendall(bytes([byte]))
            fake.receive(0, m.Hello)
            fake.serve_goodbye()

        with connection(script) as made:
            self.assertEqual(made.welcome, WELCOME)

    def test_no_common_version(self) -> None:
        def script(fake: Fake) -> None:
            fake.read_banner()
            fake.socket.sendall(Banner(5, 6).encode())
            self.assertEqual(fake.socket.recv(100), b"")

        error = self.failing(script, hopes.VersionMismatch)
        self.assertIn("5 to 6", str(error))

    def test_a_peer_that_is_no_daemon(self) -> None:
        self.failing(lambda fake: fake.socket.sendall(b"HTTP/1.1 400 Bad Request\r\n"), hopes.Malformed)

    def test_no_answer(self) -> None:
        finished = threading.Event()
        started = time.monotonic()
        self.failing(lambda fake: finished.wait(0.3), hopes.TimedOut, connect_timeout=0.1)
        self.assertLess(time.monotonic() - started, 2.0)

    def test_no_welcome(self) -> None:
        def script(fake: Fake) -> None:
            fake.read_banner()
            fake.socket.sendall(Banner().encode())
            fake.receive(0, m.Hello)
            with self.assertRaises(EOFError):
                fake.next()

        self.failing(script, hopes.TimedOut, connect_timeout=0.1)

    def test_the_daemon_refuses(self) -> None:
        def script(fake: Fake) -> None:
            fake.read_banner()
            fake.socket.sendall(Banner().encode())
            fake.send(0, m.Error(13, 0, "too many connections"))

        error = self.failing(script, hopes.DaemonError)
        assert isinstance(error, hopes.DaemonError)
        self.assertEqual(error.code, 13)

    def test_the_daemon_refuses_before_it_has_read_our_banner(self) -> None:
        def script(fake: Fake) -> None:
            error = m.Error(13, 0, "too many connections")
            fake.socket.sendall(Banner(1, 2).encode() + pack_frame(error.TYPE, 0, m.encode(error), version=1))
            fake.read_banner()

        error = self.failing(script, hopes.DaemonError)
        assert isinstance(error, hopes.DaemonError)
        self.assertEqual(error.code, 13)

    def test_other_messages_in_another_version_are_errors(self) -> None:
        def script(fake: Fake) -> None:
            fake.read_banner()
            fake.socket.sendall(Banner().encode())
            fake.receive(0, m.Hello)
            fake.socket.sendall(pack_frame(WELCOME.TYPE, 0, m.encode(WELCOME), version=1))

        self.failing(script, hopes.UnsupportedVersion)

    def test_errors_in_another_version_after_welcome_are_errors(self) -> None:
        def script(fake: Fake) -> None:
            fake.shake_hands()
            error = m.Error(14, 0, "too slow")
            fake.socket.sendall(pack_frame(error.TYPE, 0, m.encode(error), version=1))

        with connection(script) as made, self.assertRaises(hopes.UnsupportedVersion):
            made.receive(made.open_channel())

    def test_the_version_of_an_older_daemon_is_used(self) -> None:
        def script(fake: Fake) -> None:
            fake.version = 1
            fake.shake_hands()
            # A `Fake` reads only frames of its version.
            fake.receive(1, m.ListStreams)
            fake.send(1, m.Streams([]))
            fake.receive(0, m.Goodbye)

        with connection(script) as made:
            self.assertEqual(made.version, 1)
            self.assertEqual(made.ask(made.open_channel(), m.ListStreams("*"), m.Streams), m.Streams([]))

    def test_messages_that_an_older_daemon_does_not_have_are_not_sent(self) -> None:
        def script(fake: Fake) -> None:
            fake.version = 1
            fake.shake_hands()
            fake.receive(0, m.Goodbye)

        with connection(script) as made, self.assertRaisesRegex(hopes.DaemonTooOld, "version 2 .* than 1: update it"):
            made.send(made.open_channel(), m.WantTracks(TracksWanted.of("events")))

    def test_a_message_of_a_later_version_is_not_known(self) -> None:
        def script(fake: Fake) -> None:
            fake.version = 1
            fake.shake_hands()
            fake.receive(1, m.ListStreams)
            fake.send(1, m.Tracks(1, 0, 1, None, [], [], []))
            fake.receive(0, m.Goodbye)

        with connection(script) as made, self.assertRaisesRegex(hopes.BodyError, "not known in version 1"):
            made.ask(made.open_channel(), m.ListStreams("*"), m.Streams)

    def test_the_daemon_closes(self) -> None:
        self.failing(lambda fake: None, hopes.ConnectionLost)

    def test_an_error_before_the_handshake_closes_the_socket(self) -> None:
        ours, theirs = socket.socketpair()
        with theirs:
            theirs.sendall(b"x" * 20)
            with self.assertRaises(hopes.Malformed):
                Connection(ours, Options())
            self.assertEqual(ours.fileno(), -1)


class Addresses(unittest.TestCase):
    def test_neither_unix_nor_tcp(self) -> None:
        for address in ("", "lidar", "unix:", "tcp:", "tcp:host", "tcp::1", "tcp:host:port", "udp:host:1"):
            with self.subTest(address=address), self.assertRaises(ValueError):
                open_socket(address, 1.0)

    def test_no_listener(self) -> None:
        with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
            warnings.simplefilter("error", ResourceWarning)
            with self.assertRaises(OSError):
                hopes.connect(f"unix:{Path(folder) / 'none'}")
            gc.collect()

    def test_unix_and_tcp(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "socket")
            with socket.socket(socket.AF_UNIX) as listening:
                listening.bind(path)
                listening.listen()
                open_socket(f"unix:{path}", 1.0).close()
        with socket.create_server(("127.0.0.1", 0)) as listening:
            open_socket(f"tcp:127.0.0.1:{listening.getsockname()[1]}", 1.0).close()


class Pings(unittest.TestCase):
    def test_a_ping_is_answered(self) -> None:
        def script(fake: Fake) -> None:
            fake.send(0, m.Ping(12345))
            self.assertEqual(fake.receive(0, m.Pong), m.Pong(12345))
            fake.send(1, m.Streams([]))
            fake.serve_goodbye()

        def with_question(fake: Fake) -> None:
            fake.receive(1, m.ListStreams)
            script(fake)

        with daemon(with_question) as made:
            self.assertEqual(made.list_streams(), [])

    def test_a_silent_daemon_is_pinged_once_and_then_disconnected(self) -> None:
        pings: list[m.Message] = []

        def script(fake: Fake) -> None:
            fake.shake_hands(SHORT_TIMEOUT)
            fake.receive(1, m.ListStreams)
            with self.assertRaises(EOFError):
                while True:
                    pings.append(fake.receive(0, m.Ping))

        started = time.monotonic()
        with connection(script, keepalive=False) as made, self.assertRaises(hopes.PeerSilent):
            made.ask(made.open_channel(), m.ListStreams("*"), m.Streams)
        self.assertLess(0.35, time.monotonic() - started)
        self.assertEqual(len(pings), 1)

    def test_a_daemon_that_answers_pings_stays_connected(self) -> None:
        def script(fake: Fake) -> None:
            fake.shake_hands(SHORT_TIMEOUT)
            fake.receive(1, m.ListStreams)
            for _ in range(3):
                fake.send(0, m.Pong(fake.receive(0, m.Ping).token))
            fake.send(1, m.Streams([]))
            fake.serve_goodbye()

        with connection(script, keepalive=False) as made:
            made.ask(made.open_channel(), m.ListStreams("*"), m.Streams)

    def test_a_frame_that_takes_too_long(self) -> None:
        def script(fake: Fake) -> None:
            fake.shake_hands(SHORT_TIMEOUT)
            frame = pack_frame(m.Streams.TYPE, 1, bytes(1000))
            with self.assertRaises(OSError):
                for byte in frame:
                    fake.socket.sendall(bytes([byte]))
                    time.sleep(0.02)

        with connection(script) as made, self.assertRaises(hopes.PeerSilent):
            made.receive(made.open_channel())

    def test_pings_are_sent_while_the_connection_is_idle(self) -> None:
        heard = threading.Event()

        def script(fake: Fake) -> None:
            fake.shake_hands(SHORT_TIMEOUT)
            started = time.monotonic()
            for _ in range(3):
                fake.receive(0, m.Ping)
                self.assertLess(time.monotonic() - started, 0.39)
                started = time.monotonic()
            heard.set()
            fake.serve_goodbye()

        with connection(script):
            self.assertTrue(heard.wait(5.0))

    def test_a_dropped_connection_ends_its_thread(self) -> None:
        def script(fake: Fake) -> None:
            fake.shake_hands(dataclasses.replace(WELCOME, timeout_ms=80))
            with self.assertRaises(OSError):
                while True:
                    fake.next()

        stage = Stage(script)
        made = Connection(stage.dial(), Options())
        assert made._keepalive is not None
        before = {thread.name for thread in threading.enumerate()}
        self.assertIn("hopes keepalive", before)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ResourceWarning)
            del made
            gc.collect()
        deadline = time.monotonic() + 5.0
        while any(thread.name == "hopes keepalive" for thread in threading.enumerate()):
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.01)


class Misbehaviour(unittest.TestCase):
    def ends_with(self, raw: bytes, error: type[Exception], **options: object) -> None:
        def script(fake: Fake) -> None:
            fake.shake_hands()
            fake.socket.sendall(raw)
            with self.assertRaises((EOFError, ConnectionError)):
                while True:
                    fake.next()

        with connection(script, **options) as made:
            channel = made.open_channel()
            for _ in range(2):
                with self.assertRaises(error):
                    made.receive(channel)
            self.assertFalse(made.is_alive)

    def test_invalid_frames(self) -> None:
        self.ends_with(b"\0" * 20, hopes.Malformed)
        self.ends_with(pack_frame(3, 0, b"\1")[:-1] + b"\0", hopes.Malformed)
        self.ends_with(pack_frame(3, 0, b"\1", version=1), hopes.UnsupportedVersion)
        self.ends_with(pack_frame(3, 1, bytes(101)), hopes.TooLarge, largest_frame=100)

    def test_unexpected_messages_on_channel_0(self) -> None:
        self.ends_with(pack_frame(m.Streams.TYPE, 0, b"\0"), hopes.ProtocolError)
        self.ends_with(pack_frame(0x7777, 0, b""), hopes.BodyError)
        self.ends_with(pack_frame(m.Ping.TYPE, 0, b""), hopes.BodyError)

    def test_errors_that_end_the_connection(self) -> None:
        self.ends_with(pack_frame(m.Error.TYPE, 0, m.encode(m.Error(14, 0, "too slow"))), hopes.DaemonError)

    def test_a_bad_body_on_a_channel_leaves_the_connection(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.ListStreams)
            fake.socket.sendall(pack_frame(m.Streams.TYPE, 1, b"\xff"))
            fake.receive(2, m.ListStreams)
            fake.socket.sendall(pack_frame(m.Committed.TYPE, 2, b"\1\1"))
            fake.receive(3, m.ListStreams)
            fake.send(2, m.Streams([]))
            fake.send(3, m.Streams([]))
            fake.serve_goodbye()

        with daemon(script) as made:
            for _ in range(2):
                with self.assertRaises(hopes.ProtocolError):
                    made.list_streams()
            self.assertEqual(made.list_streams(), [])

    def test_a_flood_on_an_unread_channel(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(2, m.ListStreams)
            with self.assertRaises(OSError):
                while True:
                    fake.send(1, m.Hello("x" * 10_000, []))

        with daemon(script, inbox_limit=100_000) as made:
            made.connection.open_channel()
            with self.assertRaises(hopes.InboxFull):
                made.list_streams()

    def test_a_flood_of_pings_that_reads_no_answers(self) -> None:
        done = threading.Event()

        def script(fake: Fake) -> None:
            fake.receive(1, m.ListStreams)
            ping = pack_frame(m.Ping.TYPE, 0, b"\1")
            for _ in range(300):
                fake.socket.sendall(ping * 100)
            fake.send(1, m.Streams([]))
            done.wait(5.0)

        with daemon(script) as made:
            made.connection._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
            made.list_streams()
            self.assertLess(len(made.connection._outbox), 100)
            done.set()

    def test_both_sides_write_at_once(self) -> None:
        amount = 4_000_000

        def script(fake: Fake) -> None:
            fake.shake_hands(dataclasses.replace(WELCOME, largest_frame=1 << 30))
            # It writes its whole answer before it reads anything.
            fake.send(1, m.Hello("x" * amount, []))
            self.assertEqual(len(fake.receive(1, m.ListStreams).pattern), amount)
            fake.serve_goodbye()

        with connection(script) as made:
            made.send(made.open_channel(), m.ListStreams("y" * amount))
            self.assertEqual(len(made.receive(1).software), amount)

    def test_a_message_that_is_larger_than_the_daemon_reads(self) -> None:
        with daemon(idle) as made, self.assertRaises(ValueError):
            made.list_streams("x" * (1 << 20))


class Timeouts(unittest.TestCase):
    def test_an_answer_that_does_not_arrive(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.GetStatus)
            fake.receive(2, m.ListStreams)
            # The answer to the first question arrives after the caller has stopped waiting.
            fake.send(1, m.Streams([]))
            fake.send(2, m.Streams([]))
            fake.serve_goodbye()

        with daemon(script) as made:
            with self.assertRaises(hopes.TimedOut):
                made.status(timeout=0.05)
            self.assertEqual(made.list_streams(timeout=5.0), [])

    def test_a_daemon_that_reads_nothing(self) -> None:
        done = threading.Event()
        amount = 4_000_000

        def script(fake: Fake) -> None:
            fake.shake_hands(dataclasses.replace(WELCOME, largest_frame=1 << 30))
            self.assertTrue(done.wait(5.0))
            self.assertEqual(len(fake.receive(1, m.ListStreams).pattern), amount)
            fake.receive(1, m.GetStatus)
            fake.serve_goodbye()

        with connection(script) as made:
            channel = made.open_channel()
            # The message is queued, though only a part of it is sent.
            made.send(channel, m.ListStreams("x" * amount), timeout=0.05)
            with self.assertRaises(hopes.TimedOut):
                made.send(channel, m.ListStreams("not sent"), timeout=0.05)
            done.set()
            made.send(channel, m.GetStatus(), timeout=5.0)


class Ends(unittest.TestCase):
    def test_goodbye_of_the_daemon(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.ListStreams)
            fake.send(0, m.Goodbye("shutting down", [("lidar", 12)]))

        with daemon(script) as made:
            for _ in range(2):
                with self.assertRaises(hopes.DaemonClosed) as caught:
                    made.list_streams()
            self.assertEqual(caught.exception.reason, "shutting down")
            self.assertEqual(caught.exception.streams, {"lidar": 12})

    def test_messages_before_the_goodbye_are_returned(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.ListStreams)
            fake.send(1, m.Streams([]))
            fake.send(0, m.Goodbye("shutting down", []))

        with daemon(script) as made:
            self.assertEqual(made.list_streams(), [])
            with self.assertRaises(hopes.DaemonClosed):
                made.list_streams()

    def test_the_goodbye_is_found_when_sending_fails(self) -> None:
        closed = threading.Event()

        def script(fake: Fake) -> None:
            fake.send(0, m.Goodbye("shutting down", []))
            fake.socket.close()
            closed.set()

        with daemon(script) as made:
            self.assertTrue(closed.wait(5.0))
            with self.assertRaises(hopes.DaemonClosed):
                made.list_streams()

    def test_the_daemon_vanishes(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.ListStreams)
            fake.socket.sendall(struct.pack("<I", 0))

        with daemon(script) as made, self.assertRaisesRegex(hopes.ConnectionLost, "in the midst of a frame"):
            made.list_streams()

    def test_goodbye_of_the_client(self) -> None:
        reasons: list[str] = []

        def script(fake: Fake) -> None:
            # Unread data on the client's side must not destroy its goodbye.
            for _ in range(100):
                fake.send(1, m.Streams([]))
            reasons.append(fake.receive(0, m.Goodbye).reason)
            self.assertEqual(fake.socket.recv(1), b"")

        with daemon(script) as made:
            made.close("that is all")
            made.close("again")
            with self.assertRaises(hopes.ConnectionLost):
                made.list_streams()
        self.assertEqual(reasons, ["that is all"])

    def test_a_failing_program_sends_goodbye_too(self) -> None:
        reasons: list[str] = []

        def script(fake: Fake) -> None:
            reasons.append(fake.receive(0, m.Goodbye).reason)

        with daemon(script) as made, self.assertRaises(ZeroDivisionError), made:
            raise ZeroDivisionError
        self.assertIn("ZeroDivisionError", reasons[0])

    def test_closing_does_not_wait_long_for_a_daemon(self) -> None:
        done = threading.Event()

        def script(fake: Fake) -> None:
            fake.shake_hands()
            fake.receive(0, m.Goodbye)
            done.wait(5.0)

        with connection(script) as made:
            started = time.monotonic()
            made.close(linger=0.1)
            self.assertLess(time.monotonic() - started, 2.0)
            done.set()
