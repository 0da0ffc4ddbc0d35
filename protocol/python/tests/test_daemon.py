"""The client with a real daemon.

In: the environment variable `HOPES_BIN`, the daemon's program. Without it these tests are skipped. Invariant: every
daemon is stopped, and its sockets are in a folder that is removed with it.
"""

from __future__ import annotations

import contextlib
import math
import os
import random
import signal
import socket
import subprocess
import tempfile
import time
import unittest
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import hopes_client as hopes
from hopes_client import messages as m

HOPES_BIN = os.environ.get("HOPES_BIN", "")
# The longest time for one step. A daemon starts and stops in less.
TIMEOUT = 10.0

SQUARE = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)]


class Process:
    """A daemon in its own folder, with a Unix and a TCP socket."""

    def __init__(self, folder: Path, *options: str) -> None:
        self._options = options
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
        self.unix = f"unix:{folder / 'socket'}"
        self.tcp = f"tcp:127.0.0.1:{port}"
        self._log = folder / "log"
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        """Starts it and waits until it listens."""
        with self._log.open("ab") as log:
            command = [HOPES_BIN, "serve", "--listen", self.unix, "--listen", self.tcp, *self._options]
            self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        deadline = time.monotonic() + TIMEOUT
        while True:
            try:
                for address in (self.unix, self.tcp):
                    hopes.connect(address).close()
                return
            except (OSError, hopes.HopesError):
                if self._process.poll() is not None or time.monotonic() > deadline:
                    self.stop()
                    raise AssertionError(f"the daemon does not listen: {self._log.read_text()}") from None
                time.sleep(0.02)

    def terminate(self) -> None:
        """Sends it SIGTERM."""
        assert self._process is not None
        self._process.send_signal(signal.SIGTERM)

    def wait(self) -> int:
        """Waits until it has ended. Returns its exit code."""
        assert self._process is not None
        return self._process.wait(TIMEOUT)

    def stop(self) -> None:
        """Kills it in any state."""
        if self._process is None or self._process.poll() is not None:
            return
        self.terminate()
        try:
            self.wait()
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


@contextlib.contextmanager
def started(*options: str) -> Iterator[Process]:
    """A daemon of the test's own."""
    with tempfile.TemporaryDirectory() as folder:
        process = Process(Path(folder), *options)
        process.start()
        try:
            yield process
        finally:
            process.stop()


def connect(address: str) -> hopes.Daemon:
    return hopes.connect(address, timeout=TIMEOUT)


def circle(seed: int, count: int = 60) -> list[tuple[float, float]]:
    """Points near a circle of radius 10."""
    source = random.Random(seed)
    angles = [2 * math.pi * i / count for i in range(count)]
    radii = [10 + source.uniform(-0.05, 0.05) for _ in angles]
    return [(radius * math.cos(angle), radius * math.sin(angle)) for radius, angle in zip(radii, angles)]


@unittest.skipUnless(HOPES_BIN, "HOPES_BIN is not set: there is no daemon to test against")
class WithDaemon(unittest.TestCase):
    """One daemon for all tests of a class. Each test uses a stream with its own name."""

    process: Process
    _folder: tempfile.TemporaryDirectory[str]

    @classmethod
    def setUpClass(cls) -> None:
        cls._folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls._folder.cleanup)
        cls.process = Process(Path(cls._folder.name))
        cls.addClassCleanup(cls.process.stop)
        cls.process.start()

    def setUp(self) -> None:
        self.name = self.id().rsplit(".", 1)[-1]
        self.daemon = self.another_connection()

    def another_connection(self, address: str = "") -> hopes.Daemon:
        daemon = connect(address or self.process.unix)
        self.addCleanup(daemon.close)
        return daemon

    def follow(self, pattern: str = "", daemon: hopes.Daemon | None = None, **options: Any) -> hopes.Subscription:
        return (daemon or self.daemon).follow(pattern or self.name, timeout=TIMEOUT, **options)

    def push(self, stream: hopes.Producer, points: list[tuple[float, float]]) -> int:
        """Sends a frame with these additional points."""
        answer = stream.send(points)
        frame = stream.commit()
        self.assertEqual(answer.accepted, len(points))
        return frame

    def frames_until(self, subscription: hopes.Subscription, last: int) -> list[hopes.Frame]:
        """Returns the frames up to this number. Each must follow the previous one and be complete."""
        frames: list[hopes.Frame] = []
        while not frames or frames[-1].number < last:
            frame = next(subscription)
            self.assertTrue(not frames or frame.number > frames[-1].number or frame.kind == "dots")
            subscription.mirrors()[frame.stream].verify()
            frames.append(frame)
        self.assertEqual(frames[-1].number, last)
        return frames


class Connections(WithDaemon):
    def test_welcome(self) -> None:
        over_tcp = self.another_connection(self.process.tcp)
        for daemon in (self.daemon, over_tcp):
            self.assertGreater(daemon.welcome.largest_batch, 0)
            self.assertGreater(daemon.welcome.largest_frame, 0)
            self.assertTrue(daemon.welcome.software)
        self.assertEqual(self.daemon.welcome.epoch, over_tcp.welcome.epoch)

    def test_ping(self) -> None:
        self.daemon.connection.send(0, m.Ping(1))
        self.assertIsNotNone(self.daemon.status())

    def test_list_and_status(self) -> None:
        stream = self.daemon.producer(self.name, window=hopes.Window.frames(2))
        self.push(stream, SQUARE)
        for info in (self.daemon.list_streams(self.name)[0], self.daemon.list_streams("*_and_stat*")[0]):
            self.assertEqual((info.name, info.window, info.frame), (self.name, hopes.Window.frames(2), 1))
            self.assertEqual((info.points, info.vertices, info.producers, info.consumers), (4, 4, 1, 0))
            self.assertEqual((info.stream, info.epoch), (stream.opened.stream, stream.opened.epoch))
        self.assertEqual(self.daemon.list_streams("no such stream"), [])
        status = self.daemon.status()
        self.assertEqual(status.epoch, self.daemon.welcome.epoch)
        self.assertGreaterEqual(status.connections, 1)
        mine = next(state for state in status.streams if state.info.name == self.name)
        self.assertEqual((mine.accepted, mine.refused, mine.dropped), (4, 0, 0))

    def test_errors(self) -> None:
        self.daemon.producer(self.name, window=hopes.Window.frames(1))
        with self.assertRaises(hopes.DaemonError) as caught:
            self.daemon.producer(self.name, window=hopes.Window.frames(2))
        self.assertEqual(caught.exception.code, 6)
        for name in ("", "with*star", "x" * 201, "a\nb"):
            with self.subTest(name=name), self.assertRaises(hopes.DaemonError) as caught:
                self.daemon.producer(name)
            self.assertEqual((caught.exception.code, caught.exception.answers), (5, m.Open.TYPE))
        # The connection is still usable.
        self.assertEqual(len(self.daemon.list_streams(self.name)), 1)

    def test_missing_options_match_any(self) -> None:
        first = self.daemon.producer(self.name, window=hopes.Window.frames(3))
        second = self.daemon.producer(self.name)
        self.assertEqual((first.opened.created, second.opened.created), (True, False))
        self.assertEqual(second.opened.window, hopes.Window.frames(3))


class Producing(WithDaemon):
    def test_two_producers(self) -> None:
        first = self.daemon.producer(self.name)
        second = self.another_connection(self.process.tcp).producer(self.name)
        subscription = self.follow()
        first.send(SQUARE[:2]).wait()
        second.send(SQUARE[2:]).wait()
        self.assertEqual(first.commit(), 1)
        self.assertEqual(second.commit(), 2)
        frame = self.frames_until(subscription, 2)[-1]
        self.assertEqual((frame.points, sorted(frame.vertices.values())), (4, sorted(SQUARE)))

    def test_many_batches(self) -> None:
        stream = self.daemon.producer(self.name)
        for start in range(200):
            stream.send([(float(start), float(i)) for i in range(5)])
        self.assertEqual(stream.commit(), 1)
        self.assertEqual((stream.accepted, stream.dropped, stream.refused_count), (1000, 0, 0))

    def test_refused_points(self) -> None:
        stream = self.daemon.producer(self.name)
        points = [(5.0, 5.0), (math.nan, 0.0), (1.0, math.inf), (5.0, 5.0), (6.0, 5.0)]
        answer = stream.send(points, tags=[10, 11, 12, 13, 14]).wait()
        self.assertEqual((answer.accepted, answer.refused_count), (3, 2))
        self.assertEqual([(refusal.index, refusal.code) for refusal in answer.refused], [(1, 1), (2, 1)])
        self.assertEqual(answer.placed.keys(), {10, 13, 14})
        self.assertEqual(answer.placed[10], answer.placed[13])
        self.assertEqual(list(stream.refused), answer.refused)
        stream.commit()
        frame = next(self.follow())
        self.assertEqual((frame.points, frame.positions, frame.rejected), (3, 2, 2))
        self.assertEqual(frame.vertices[answer.placed[10]], (5.0, 5.0))
        self.assertEqual(frame.vertices[answer.placed[14]], (6.0, 5.0))

    def test_retract(self) -> None:
        stream = self.daemon.producer(self.name)
        self.push(stream, SQUARE)
        answer = stream.retract([SQUARE[0], (9.0, 9.0)]).wait()
        self.assertEqual(
            (answer.accepted, [(refusal.index, refusal.code) for refusal in answer.refused]), (1, [(1, 5)])
        )
        stream.commit()
        self.assertEqual(sorted(next(self.follow()).vertices.values()), sorted(SQUARE[1:]))

    def test_time_window(self) -> None:
        stream = self.daemon.producer(self.name, window=hopes.Window.time(10.0))
        answer = stream.send(SQUARE[:2], times=[100.0, math.nan]).wait()
        self.assertEqual((answer.accepted, answer.refused[0].code), (1, 3))
        stream.send(SQUARE[2:3], times=[110.0]).wait()
        self.assertEqual([refusal.code for refusal in stream.send(SQUARE[:1], times=[99.0]).wait().refused], [4])
        # A point without a time is of the newest time known.
        stream.send(SQUARE[3:]).wait()
        stream.commit()
        stream.send([(9.0, 9.0)], times=[115.0]).wait()
        stream.commit()
        frame = next(self.follow())
        self.assertEqual((frame.time, list(frame.vertices.values())), (115.0, [*SQUARE[2:], (9.0, 9.0)]))

    def test_a_commit_dates_points_that_have_no_time(self) -> None:
        stream = self.daemon.producer(self.name, window=hopes.Window.time(2.5))
        for number in range(1, 6):
            self.assertEqual(stream.send([(x, number) for x in range(20)]).wait().accepted, 20)
            stream.commit(time=number)
            frame = next(self.follow())
            rows = sorted({y for _, y in frame.vertices.values()})
            self.assertEqual((frame.time, rows), (number, list(range(max(1, number - 2), number + 1))))
            self.assertEqual((frame.points, frame.rejected), (20 * len(rows), 0))

    def test_what_is_missing_is_refused_and_counted(self) -> None:
        stream = self.daemon.producer(self.name)
        answer = stream.send([(0.0, 0.0), (None, 1.0), (2.0, None), (3.0, 3.0)]).wait()
        self.assertEqual((answer.accepted, answer.refused_count), (2, 2))
        self.assertEqual([(refusal.index, refusal.code) for refusal in answer.refused], [(1, 1), (2, 1)])
        answer = stream.send([(4.0, 4.0), (5.0, 5.0)], times=[None, 1.0]).wait()
        self.assertEqual([(refusal.index, refusal.code) for refusal in answer.refused], [(0, 3)])
        stream.commit()
        frame = next(self.follow())
        self.assertEqual((frame.rejected, frame.points), (3, 3))

    def test_a_masked_array(self) -> None:
        try:
            import numpy
        except ImportError as error:
            self.skipTest(str(error))
        stream = self.daemon.producer(self.name)
        points = numpy.ma.array([[1.0, 1.0], [7.0, 7.0], [3.0, 3.0]], mask=[[False, False], [True, True], [False, False]])
        answer = stream.send(points).wait()
        self.assertEqual((answer.accepted, [refusal.index for refusal in answer.refused]), (2, [1]))
        stream.commit()
        self.assertEqual(list(next(self.follow()).vertices.values()), [(1.0, 1.0), (3.0, 3.0)])

    def test_frame_window(self) -> None:
        stream = self.daemon.producer(self.name, window=hopes.Window.frames(1))
        self.push(stream, SQUARE)
        stream.send([(7.0, 7.0)])
        stream.commit(time=2.5)
        frame = next(self.follow())
        self.assertEqual((frame.number, frame.time, list(frame.vertices.values())), (2, 2.5, [(7.0, 7.0)]))

    def test_end(self) -> None:
        first = self.daemon.producer(self.name)
        second = self.another_connection().producer(self.name)
        subscription = self.follow()
        self.push(first, SQUARE)
        self.assertEqual(first.close(end=True), 1)
        self.assertEqual([frame.number for frame in subscription], [1])
        with self.assertRaises(hopes.StreamEnded):
            second.send(SQUARE)
            second.commit()
        self.assertEqual(self.daemon.list_streams(self.name), [])

    def test_a_stream_stays_when_its_producers_leave(self) -> None:
        with self.daemon.producer(self.name) as stream:
            self.push(stream, SQUARE)
        again = self.daemon.producer(self.name)
        self.assertEqual((again.opened.created, again.opened.frame), (False, 1))


class Following(WithDaemon):
    def test_square(self) -> None:
        self.push(self.daemon.producer(self.name), SQUARE)
        frame = next(self.follow(dots=hopes.Dots.all(), dots_wait=TIMEOUT))
        self.assertEqual((frame.kind, frame.cause, frame.number), ("snapshot", "Start", 1))
        self.assertEqual((frame.points, frame.positions, frame.components, frame.cycles), (4, 4, 1, 1))
        self.assertEqual((len(frame.vertices), len(frame.edges), len(frame.critical)), (4, 3, 1))
        self.assertEqual((len(frame.dots), frame.dots_total), (1, 1))
        dot = frame.dots[0]
        self.assertEqual(frame.critical.keys(), {dot.edge})
        for birth, death in (frame.critical[dot.edge], (dot.birth, dot.death)):
            self.assertAlmostEqual(birth, 1.0)
            self.assertAlmostEqual(death, math.sqrt(2))
        self.assertAlmostEqual(dot.radius, math.sqrt(2))
        for coordinate in dot.center:
            self.assertAlmostEqual(coordinate, 1.0)

    def test_reduced_square(self) -> None:
        self.push(self.daemon.producer(self.name), SQUARE)
        for alpha, components, cycles in ((0.5, 4, 0), (1.2, 1, 1), (1.5, 1, 0)):
            with self.subTest(alpha=alpha), self.follow(alpha=alpha) as subscription:
                frame = next(subscription)
                self.assertEqual((frame.components, frame.cycles), (components, cycles))
                self.assertEqual(len(frame.vertices) - len(frame.edges), components)
                self.assertEqual(len(frame.critical), cycles)

    def test_every_kind_of_view(self) -> None:
        views: list[dict[str, Any]] = [
            {"full": True},
            {"alpha": 2.0},
            {"k": 1, "l": 1},
            {"full": True, "simplify": 1.0},
            {"alpha": 2.0, "simplify": True},
            {"k": 1, "l": 1, "simplify": True},
            {"k": 1, "l": 1, "simplify": 1.0},
        ]
        stream = self.daemon.producer(self.name, window=hopes.Window.frames(2))
        consumers = self.another_connection(self.process.tcp)
        subscriptions = [self.follow(daemon=consumers, **view) for view in views]
        for seed in range(6):
            self.push(stream, circle(seed))
        for view, subscription in zip(views, subscriptions):
            with self.subTest(view=view):
                frame = self.frames_until(subscription, 6)[-1]
                self.assertEqual(frame.view, hopes.View.of(**view))
                # The circle, and any small holes of the full skeleton.
                self.assertGreaterEqual(frame.cycles, 1)
                self.assertEqual(frame.components, 1)
                cycles = len(frame.edges) + len(frame.critical) - len(frame.vertices) + frame.components
                self.assertEqual(cycles, frame.cycles)
                if "simplify" in view:
                    self.assertFalse(frame.critical)
                # A new consumer gets in one snapshot what the others got in several diffs.
                with self.follow(daemon=consumers, **view) as fresh:
                    snapshot = next(fresh)
                    self.assertEqual(
                        (snapshot.vertices, snapshot.edges, snapshot.critical),
                        (frame.vertices, frame.edges, frame.critical),
                    )

    def test_late_joiner(self) -> None:
        stream = self.daemon.producer(self.name)
        for start in range(3):
            self.push(stream, [(float(start), 0.0), (float(start), 1.5)])
        subscription = self.follow()
        frame = next(subscription)
        self.assertEqual((frame.kind, frame.cause, frame.number), ("snapshot", "Start", 3))
        for number in (4, 5):
            self.push(stream, [(float(number), 0.0)])
            frame = next(subscription)
            self.assertEqual((frame.kind, frame.number), ("diff", number))
            assert frame.diff is not None
            self.assertEqual(frame.diff.from_, number - 1)
            subscription.mirrors()[self.name].verify()

    def test_subscribing_before_the_stream_exists(self) -> None:
        subscription = self.follow()
        with self.assertRaises(hopes.TimedOut):
            subscription.next_frame(timeout=0.05)
        stream = self.daemon.producer(self.name)
        with self.assertRaises(hopes.TimedOut):
            subscription.next_frame(timeout=0.05)
        self.push(stream, SQUARE)
        self.assertEqual((next(subscription).number), 1)

    def test_resume(self) -> None:
        stream = self.daemon.producer(self.name)
        self.push(stream, circle(1))
        consumer = self.another_connection()
        subscription = self.follow(daemon=consumer)
        self.assertEqual(next(subscription).number, 1)
        mirror = subscription.mirrors()[self.name]
        consumer.close()
        for seed in (2, 3):
            self.push(stream, circle(seed))
        again = self.follow(daemon=self.another_connection(), resume=mirror)
        frames = self.frames_until(again, 3)
        self.assertEqual({frame.kind for frame in frames}, {"diff"})
        first = frames[0].diff
        assert first is not None
        self.assertEqual(first.from_, 1)
        self.assertEqual(next(self.follow()).vertices, frames[-1].vertices)

    def test_resume_with_another_epoch(self) -> None:
        stream = self.daemon.producer(self.name)
        self.push(stream, SQUARE)
        subscription = self.follow()
        next(subscription)
        mirror = subscription.mirrors()[self.name]
        mirror.epoch ^= 1
        frame = next(self.follow(daemon=self.another_connection(), resume=mirror))
        self.assertEqual((frame.kind, frame.cause, frame.number), ("snapshot", "CannotResume", 1))

    def test_pattern(self) -> None:
        names = [f"{self.name}-{end}" for end in ("a", "b")]
        self.push(self.daemon.producer(names[0]), SQUARE)
        subscription = self.follow(f"{self.name}-*")
        self.assertEqual((next(subscription).stream), names[0])
        self.push(self.daemon.producer(f"other {self.name}"), SQUARE)
        self.push(self.daemon.producer(names[1]), SQUARE[:3])
        frame = next(subscription)
        self.assertEqual((frame.stream, len(frame.vertices)), (names[1], 3))
        self.assertEqual(sorted(subscription.mirrors()), names)

    def test_change_of_view(self) -> None:
        stream = self.daemon.producer(self.name)
        self.push(stream, SQUARE)
        subscription = self.follow()
        self.assertEqual(next(subscription).components, 1)
        subscription.change_view(alpha=0.5)
        frame = next(subscription)
        self.assertEqual((frame.kind, frame.cause, frame.components), ("snapshot", "ViewChanged", 4))
        self.push(stream, [(9.0, 9.0)])
        frame = next(subscription)
        self.assertEqual((frame.kind, frame.number, frame.components), ("diff", 2, 5))

    def test_unsubscribe(self) -> None:
        self.push(self.daemon.producer(self.name), SQUARE)
        with self.follow() as subscription:
            next(subscription)
            self.assertEqual(self.daemon.list_streams(self.name)[0].consumers, 1)
        self.assertEqual(self.daemon.list_streams(self.name)[0].consumers, 0)
        self.assertIsNone(subscription.next_frame())

    def test_dots_follow_the_frames(self) -> None:
        stream = self.daemon.producer(self.name, window=hopes.Window.frames(1))
        subscription = self.follow(dots=hopes.Dots.top(1), dots_wait=TIMEOUT)
        for size in (2.0, 3.0, 4.0):
            number = self.push(stream, [(0.0, 0.0), (size, 0.0), (size, size), (0.0, size)])
            frame = next(subscription)
            self.assertEqual((frame.number, len(frame.dots), frame.dots_total), (number, 1, 1))
            self.assertAlmostEqual(frame.dots[0].birth, size / 2)
            self.assertAlmostEqual(frame.dots[0].death, size / math.sqrt(2))

    def test_a_broken_connection_is_renewed(self) -> None:
        stream = self.daemon.producer(self.name)
        self.push(stream, SQUARE)
        consumer = self.another_connection()
        subscription = self.follow(daemon=consumer, reconnect=True)
        self.assertEqual(next(subscription).number, 1)
        consumer.connection._socket.shutdown(socket.SHUT_RDWR)
        self.push(stream, [(9.0, 9.0)])
        frame = next(subscription)
        self.assertEqual((frame.kind, frame.number, len(frame.vertices)), ("diff", 2, 5))


@unittest.skipUnless(HOPES_BIN, "HOPES_BIN is not set: there is no daemon to test against")
class Ends(unittest.TestCase):
    def push(self, daemon: hopes.Daemon, points: list[tuple[float, float]]) -> None:
        stream = daemon.producer("stream")
        stream.send(points)
        stream.commit()

    def test_goodbye(self) -> None:
        with started() as process, connect(process.unix) as producer, connect(process.tcp) as consumer:
            self.push(producer, SQUARE)
            subscription = consumer.follow("stream", timeout=TIMEOUT, stop_when_closed=False)
            self.assertEqual(next(subscription).number, 1)
            process.terminate()
            with self.assertRaises(hopes.DaemonClosed) as caught:
                next(subscription)
            self.assertEqual(caught.exception.streams, {"stream": 1})
            self.assertEqual(process.wait(), 0)

    def test_reconnect_to_a_daemon_that_was_started_again(self) -> None:
        with started() as process:
            with connect(process.unix) as producer:
                self.push(producer, SQUARE)
            with connect(process.unix) as consumer:
                subscription = consumer.follow("stream", timeout=TIMEOUT, reconnect=True)
                first = next(subscription)
                process.terminate()
                self.assertEqual(process.wait(), 0)
                process.start()
                with connect(process.unix) as producer:
                    self.push(producer, SQUARE[:3])
                    frame = next(subscription)
                self.assertEqual((frame.kind, frame.number, len(frame.vertices)), ("snapshot", 1, 3))
                self.assertNotEqual(frame.epoch, first.epoch)
