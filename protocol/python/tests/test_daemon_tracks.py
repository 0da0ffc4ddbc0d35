"""The client with a real daemon that follows tracks.

In: the environment variable `HOPES_BIN`, the daemon's program. These tests are skipped without it, or if its protocol
versions have no tracks. Invariants: as in `test_daemon`.
"""

from __future__ import annotations

import contextlib
import math
import unittest
from collections.abc import Iterator
from unittest import mock

import hopes_client as hopes
from hopes_client import messages as m
from hopes_client.connection import Connection
from hopes_client.tracks import TracksWanted
from hopes_client.wire import Banner

from .test_daemon import HOPES_BIN, SQUARE, TIMEOUT, Process, circle, connect, started

RING = circle(1)
# A ring of radius 10 becomes a track after two frames, and ends after three frames without it.
OPTIONS = ("--track", "above:0.5", "--track-confirm", "2", "--track-miss", "3")


@contextlib.contextmanager
def spoken_to_in_version_1(process: Process) -> Iterator[hopes.Daemon]:
    """A connection of a client whose highest version is lower."""
    with mock.patch("hopes_client.connection.Banner", lambda: Banner(1, 1)), connect(process.unix) as daemon:
        yield daemon


@unittest.skipUnless(HOPES_BIN, "HOPES_BIN is not set: there is no daemon to test against")
class Tracks(unittest.TestCase):
    process: Process

    @classmethod
    def setUpClass(cls) -> None:
        with started() as plain, connect(plain.unix) as daemon:
            version = daemon.connection.version
        if version < m.Tracks.SINCE:
            raise unittest.SkipTest(f"the daemon speaks version {version} of the protocol, which has no tracks")
        stack = contextlib.ExitStack()
        cls.addClassCleanup(stack.close)
        cls.process = stack.enter_context(started(*OPTIONS))

    def setUp(self) -> None:
        self.name = self.id().rsplit(".", 1)[-1]
        self.daemon = connect(self.process.unix)
        self.addCleanup(self.daemon.close)
        self.stream = self.daemon.producer(self.name)

    def follow(self, tracks: str) -> hopes.Subscription:
        daemon = connect(self.process.tcp)
        self.addCleanup(daemon.close)
        return daemon.follow(self.name, tracks=tracks, timeout=TIMEOUT)

    def tracks_of(self, subscription: hopes.Subscription, number: int) -> tuple[hopes.Frame, list[hopes.TrackEvent]]:
        """The first frame with this number and all tracks, and the events up to it."""
        events: list[hopes.TrackEvent] = []
        while True:
            frame = next(subscription)
            events += frame.track_events
            if subscription.mirrors()[self.name].tracks.number == number:
                self.assertEqual(frame.number, number)
                return frame, events

    def show(self) -> None:
        """A frame with the ring."""
        self.stream.send(RING)
        self.stream.commit()

    def test_a_track_from_birth_to_death(self) -> None:
        subscription = self.follow("cycles")
        self.show()
        frame, events = self.tracks_of(subscription, 1)
        self.assertEqual((events, frame.tracks), ([], {}))
        self.assertEqual(self.stream.commit(time=2.5), 2)
        frame, events = self.tracks_of(subscription, 2)
        self.assertEqual([(event.frame, event.time, event.happening.case) for event in events], [(2, 2.5, "Born")])
        (track,) = frame.tracks.values()
        self.assertEqual((track, track.age, track.selected), (events[0].track, 2, True))
        self.assertLess(math.hypot(*track.center), 0.5)
        self.assertLess(abs(track.death - 10), 0.5)
        self.assertLess(abs(track.area - 100 * math.pi), 10)
        (outer,) = frame.track_cycles[track.id]
        self.assertEqual(len(outer), len(set(outer)))
        self.assertGreater(len(outer), 40)
        corners = [frame.vertices[id] for id in outer]
        twice = sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(corners, corners[1:] + corners[:1]))
        self.assertAlmostEqual(twice / 2, track.area, places=6, msg="it goes round counter-clockwise")
        self.assertEqual(self.stream.retract(RING).wait().accepted, len(RING))
        for number in (3, 4, 5):
            self.stream.commit()
            frame, events = self.tracks_of(subscription, number)
            happened = [(event.frame, event.happening.case, event.track.id) for event in events]
            self.assertEqual(happened, [(5, "Died", track.id)] if number == 5 else [])
        self.assertEqual((frame.tracks, frame.track_cycles), ({}, {}))

    def test_events_alone_and_late_ones(self) -> None:
        early, alive = self.follow("events"), self.follow("alive")
        for number in (1, 2):
            self.show() if number == 1 else self.stream.commit()
            self.tracks_of(alive, number)
        late = self.follow("events")
        frame, events = self.tracks_of(late, 2)
        self.assertEqual((events, [track.age for track in frame.tracks.values()]), ([], [2]))
        self.stream.retract(RING).wait()
        for number in (3, 4, 5):
            self.stream.commit()
            self.tracks_of(alive, number)
        for subscription, expected in ((early, ["Born", "Died"]), (late, ["Died"])):
            _, events = self.tracks_of(subscription, 5)
            self.assertEqual([event.happening.case for event in events], expected)
            self.assertEqual(subscription.mirrors()[self.name].tracks.alive, {})

    def test_another_request(self) -> None:
        subscription = self.follow("alive")
        self.show()
        self.tracks_of(subscription, 1)
        self.stream.commit()
        frame, _ = self.tracks_of(subscription, 2)
        self.assertEqual((len(frame.tracks), frame.track_cycles), (1, {}))
        subscription.want_tracks("cycles")
        self.stream.commit()
        frame, _ = self.tracks_of(subscription, 3)
        self.assertEqual((len(frame.tracks), frame.tracks.keys()), (1, frame.track_cycles.keys()))
        subscription.want_tracks(None)
        self.stream.commit()
        while frame.number < 4:
            frame = next(subscription)
        self.assertEqual((frame.tracks, frame.track_events), ({}, ()))

    def test_another_view(self) -> None:
        subscription = self.follow("alive")
        self.show()
        self.tracks_of(subscription, 1)
        self.stream.commit()
        self.tracks_of(subscription, 2)
        subscription.change_view(k=1, l=1, simplify=True)
        self.stream.commit()
        frame, events = self.tracks_of(subscription, 3)
        self.assertEqual((events, [track.age for track in frame.tracks.values()]), ([], [3]))
        self.assertEqual(frame.view, hopes.View.of(k=1, l=1, simplify=True))

    def test_without_a_subscription(self) -> None:
        connection = self.daemon.connection
        with self.assertRaises(hopes.DaemonError) as caught:
            connection.ask(connection.open_channel(), m.WantTracks(TracksWanted.of("alive")), m.Tracks, TIMEOUT)
        self.assertEqual((caught.exception.code, caught.exception.answers), (3, m.WantTracks.TYPE))

    def test_a_client_of_version_1(self) -> None:
        self.show()
        self.stream.commit()
        with spoken_to_in_version_1(self.process) as older:
            self.assertEqual(older.connection.version, 1)
            with self.assertRaises(hopes.DaemonTooOld):
                older.follow(self.name, tracks="alive")
            subscription = older.follow(self.name, timeout=TIMEOUT)
            frame = next(subscription)
            self.assertEqual((frame.number, len(frame.vertices)), (2, len(RING)))
            self.stream.commit()
            self.assertEqual(next(subscription).number, 3)
            connection = older.connection
            with mock.patch.object(Connection, "check_speaks"), self.assertRaises(hopes.DaemonError) as caught:
                connection.ask(connection.open_channel(), m.WantTracks(TracksWanted.of("alive")), m.Tracks, TIMEOUT)
            self.assertEqual((caught.exception.code, caught.exception.answers), (2, m.WantTracks.TYPE))

    def test_a_daemon_that_follows_none(self) -> None:
        with started() as plain, connect(plain.unix) as daemon:
            stream = daemon.producer(self.name)
            subscription = daemon.follow(self.name, tracks="alive", timeout=TIMEOUT)
            with self.assertRaisesRegex(hopes.DaemonError, "--track") as caught:
                next(subscription)
            self.assertEqual((caught.exception.code, caught.exception.answers), (9, m.WantTracks.TYPE))
            stream.send(SQUARE)
            stream.commit()
            self.assertEqual(next(subscription).number, 1)
