"""The client with a real daemon, and streams of points in R^d.

In: the environment variable `HOPES_BIN`, the daemon's program. Without it these tests are skipped. Invariants: as in
`test_daemon`.
"""

from __future__ import annotations

import math
from unittest import mock

import hopes_client as hopes
from hopes_client.wire import Banner

from .test_daemon import WithDaemon

SQUARE = [(0.0, 0.0, 5.0), (2.0, 0.0, 5.0), (2.0, 2.0, 5.0), (0.0, 2.0, 5.0)]


class Spaces(WithDaemon):
    def test_points_and_frames(self) -> None:
        stream = self.daemon.producer(self.name, metric="euclidean", window=hopes.Window.points(4))
        self.assertEqual(stream.send(SQUARE, tags=[7, 8, 9, 10]).wait().placed, {7: 0, 8: 1, 9: 2, 10: 3})
        stream.commit(time=1.5)
        consumer = self.another_connection()
        subscription = self.follow(daemon=consumer, k=1, l=1, dots=hopes.Dots.top(3))
        frame = next(subscription)
        subscription.mirrors()[frame.stream].verify()
        self.assertEqual((frame.number, frame.time, frame.dimension), (1, 1.5, 3))
        self.assertEqual(str(frame.metric).lower().rsplit(".", 1)[-1].strip("()'\" "), "euclidean")
        self.assertEqual(frame.vertices, dict(enumerate(SQUARE)))
        self.assertEqual([label for label in frame.critical.values()], [(1.0, math.sqrt(2))])
        while not frame.dots:
            frame = next(subscription)
        dot = frame.dots[0]
        self.assertEqual((dot.birth, dot.death), (1.0, math.sqrt(2)))
        self.assertIn(dot.death_edge, [(0, 2), (1, 3)])
        stream.send([(9.0, 9.0, 9.0)])
        self.assertEqual(stream.commit(), 2)
        while frame.number < 2:
            frame = next(subscription)
        self.assertEqual((sorted(frame.vertices), len(frame.critical)), ([1, 2, 3, 4], 0))
        subscription.mirrors()[frame.stream].verify()

    def test_what_does_not_fit_is_refused_with_its_reason(self) -> None:
        stream = self.daemon.producer(self.name, metric="manhattan", dimension=3)
        answer = stream.send([(math.nan, 0.0, 0.0), (1.0, 2.0, 3.0)]).wait()
        self.assertEqual((answer.accepted, [refusal.index for refusal in answer.refused]), (1, [0]))
        for metric, dimension in [("euclidean", 3), ("manhattan", 2)]:
            with self.assertRaises(hopes.DaemonError) as raised:
                self.another_connection().producer(self.name, metric=metric, dimension=dimension)
            self.assertEqual(raised.exception.code, 6)
        with self.assertRaises(hopes.DaemonError) as raised:
            self.another_connection().producer(self.name)
        self.assertEqual(raised.exception.code, 19)
        infos = [info for info in self.daemon.list_spaces() if info.dimension == 3]
        self.assertTrue(infos)

    def test_an_older_version_is_told_why(self) -> None:
        self.daemon.producer(self.name, metric="euclidean")
        with mock.patch("hopes_client.connection.Banner", lambda: Banner(1, 3)):
            older = self.another_connection()
        with self.assertRaises(hopes.HopesError) as raised:
            next(self.follow(daemon=older))
        self.assertIn("R^d", str(raised.exception))
