"""The mirror: snapshots, diffs, their checksum, and frames."""

from __future__ import annotations

import dataclasses
import unittest
from typing import Any

from hopes_client import checksum as hashes
from hopes_client import messages as m
from hopes_client.errors import ResyncNeeded, StaleFrame
from hopes_client.mirror import Mirror
from hopes_client.shared import Cause, Cut, Simplify, View
from hopes_client.tracker import Tracker, more_of

from .samples import (
    SIMPLE,
    SQUARE,
    SQUARE_CRITICAL,
    SQUARE_EDGES,
    checksum,
    diff,
    dots,
    header,
    opened,
    snapshot,
)


def held(mirror: Mirror) -> tuple[Any, ...]:
    """A copy of a mirror's content."""
    return (mirror.header, dict(mirror.vertices), set(mirror.edges), dict(mirror.critical), mirror.checksum)


class Checksum(unittest.TestCase):
    def test_it_is_that_of_the_specification(self) -> None:
        total = hashes.of_vertices(SQUARE) + hashes.of_edges(SQUARE_EDGES) + hashes.of_critical(SQUARE_CRITICAL)
        self.assertEqual(total & hashes.MASK, checksum(SQUARE, SQUARE_EDGES, SQUARE_CRITICAL))

    def test_nothing_and_zeros(self) -> None:
        self.assertEqual(hashes.of_vertices([]), 0)
        self.assertNotEqual(hashes.of_vertices([(0, 0.0, 0.0)]), hashes.of_vertices([(0, 0.0, -0.0)]))


class Contract(unittest.TestCase):
    def setUp(self) -> None:
        self.mirror = Mirror("lidar", 77)
        self.mirror.apply_snapshot(snapshot())

    def refuse(self, change: m.Diff) -> None:
        """Checks that the diff is refused and changes nothing."""
        before = held(self.mirror)
        with self.assertRaises(ResyncNeeded):
            self.mirror.apply_diff(change)
        self.assertEqual(held(self.mirror), before)

    def changed(self, **fields: Any) -> m.Diff:
        return dataclasses.replace(diff(), **fields)

    def test_snapshot(self) -> None:
        self.assertEqual(self.mirror.vertices, {0: (0.0, 0.0), 1: (2.0, 0.0), 2: (2.0, 2.0), 3: (0.0, 2.0)})
        self.assertEqual(self.mirror.edges, set(SQUARE_EDGES))
        self.assertEqual(self.mirror.critical, {(2, 3): SQUARE_CRITICAL[0][2:]})
        self.assertEqual(self.mirror.number, 1)
        self.mirror.verify()

    def test_diff(self) -> None:
        self.mirror.apply_diff(diff())
        self.assertEqual(self.mirror.vertices, {0: (0.0, 0.0), 2: (2.5, 2.0), 3: (0.0, 2.0), 4: (3.0, 0.0)})
        self.assertEqual(self.mirror.edges, {(0, 3), (0, 4), (2, 4)})
        self.assertEqual(self.mirror.critical, {(2, 3): (1.25, 1.5)})
        self.assertEqual(self.mirror.number, 2)
        self.mirror.verify()

    def test_a_snapshot_replaces_everything(self) -> None:
        self.mirror.apply_diff(diff())
        self.mirror.apply_snapshot(snapshot(number=5))
        self.assertEqual(self.mirror.vertices.keys(), {0, 1, 2, 3})
        self.assertEqual(self.mirror.number, 5)
        self.mirror.verify()

    def test_a_diff_from_nothing(self) -> None:
        empty = Mirror()
        first = m.Diff(9, 0, header(1), SQUARE, [], SQUARE_EDGES, [], SQUARE_CRITICAL, [], snapshot().checksum)
        empty.apply_diff(first)
        self.assertEqual(held(empty)[1:], held(self.mirror)[1:])

    def test_a_diff_over_several_frames(self) -> None:
        self.mirror.apply_diff(self.changed(frame=header(40)))
        self.assertEqual(self.mirror.number, 40)

    def test_a_critical_edge_that_goes(self) -> None:
        total = checksum(SQUARE, SQUARE_EDGES, [])
        self.mirror.apply_diff(m.Diff(9, 1, header(2), [], [], [], [], [], [(2, 3)], total))
        self.assertEqual(self.mirror.critical, {})
        self.mirror.verify()

    def test_a_simplified_view(self) -> None:
        mirror = Mirror()
        edges = [(0, 1), (0, 2), (1, 2)]
        corners = SQUARE[:3]
        start = m.Snapshot(9, Cause("Start"), header(1, SIMPLE), corners, edges, [], checksum(corners, edges, []))
        mirror.apply_snapshot(start)
        moved = [(0, 0.0, 0.0), (1, 9.0, 0.0), (2, 2.0, 2.0)]
        total = checksum(moved, edges, [])
        mirror.apply_diff(m.Diff(9, 1, header(2, SIMPLE), [(1, 9.0, 0.0)], [1], [], [], [], [], total))
        self.assertEqual(mirror.vertices[1], (9.0, 0.0))
        mirror.verify()

    def test_wrong_start(self) -> None:
        self.refuse(self.changed(from_=2, frame=header(3)))
        self.refuse(self.changed(from_=0))
        self.refuse(self.changed(frame=header(1)))

    def test_another_view(self) -> None:
        self.refuse(self.changed(frame=header(2, View(Cut.reduced(1.0), Simplify.no()))))

    def test_wrong_checksum(self) -> None:
        self.refuse(self.changed(checksum=diff().checksum ^ 1))
        with self.assertRaises(ResyncNeeded):
            self.mirror.apply_snapshot(dataclasses.replace(snapshot(3), checksum=0))
        self.assertEqual(self.mirror.number, 1)

    def test_removed_but_not_there(self) -> None:
        self.refuse(self.changed(vertices_removed=[1, 2, 8]))
        self.refuse(self.changed(edges_removed=[(0, 1), (1, 2), (1, 3)]))
        self.refuse(self.changed(critical_removed=[(0, 2)]))

    def test_added_but_there(self) -> None:
        self.refuse(self.changed(vertices_added=[(0, 0.0, 0.0), (2, 2.5, 2.0), (4, 3.0, 0.0)]))
        self.refuse(self.changed(edges_added=[(0, 3), (0, 4), (2, 4)]))

    def test_repetitions(self) -> None:
        self.refuse(self.changed(vertices_removed=[1, 1, 2]))
        self.refuse(self.changed(vertices_added=[(2, 2.5, 2.0), (4, 3.0, 0.0), (4, 3.0, 0.0)]))
        self.refuse(self.changed(edges_added=[(0, 4), (0, 4), (2, 4)]))
        self.refuse(self.changed(critical_set=[(2, 3, 1.25, 1.5), (2, 3, 1.25, 1.5)]))
        with self.assertRaises(ResyncNeeded):
            self.mirror.apply_snapshot(dataclasses.replace(snapshot(), edges=[(0, 1), (0, 1)]))

    def test_a_change_from_outside_is_detected(self) -> None:
        self.mirror.vertices[0] = (1.0, 0.0)
        with self.assertRaises(ResyncNeeded):
            self.mirror.verify()


class Frames(unittest.TestCase):
    def setUp(self) -> None:
        self.tracker = Tracker()
        self.assertIsNone(self.tracker.take(opened()))

    def take(self, message: m.Message) -> Any:
        frame = self.tracker.take(message)
        assert frame is not None
        return frame

    def test_fields(self) -> None:
        frame = self.take(snapshot())
        self.assertEqual((frame.stream, frame.epoch, frame.number, frame.time), ("lidar", 77, 1, 0.5))
        self.assertEqual((frame.kind, frame.cause, frame.diff, frame.lagged), ("snapshot", "Start", None, None))
        self.assertEqual((frame.points, frame.positions, frame.components, frame.cycles), (4, 4, 1, 1))
        self.assertEqual(set(frame.edges), set(SQUARE_EDGES))
        following = self.take(diff())
        self.assertEqual((following.kind, following.cause, following.diff), ("diff", None, diff()))

    def test_a_frame_is_stale_when_the_next_has_come(self) -> None:
        frame = self.take(snapshot())
        kept = frame.copy()
        self.take(diff())
        with self.assertRaises(StaleFrame):
            _ = frame.vertices
        with self.assertRaises(StaleFrame):
            frame.copy()
        self.assertEqual(frame.number, 1)
        self.assertEqual(kept.vertices[1], (2.0, 0.0))
        self.assertEqual(kept.critical.keys(), {(2, 3)})

    def test_lagged_belongs_to_the_next_frame(self) -> None:
        self.take(snapshot())
        self.assertIsNone(self.tracker.take(m.Lagged(9, 2, 5)))
        frame = self.take(dataclasses.replace(diff(), frame=header(5)))
        self.assertEqual(frame.lagged, (2, 5))
        self.assertIsNone(self.take(snapshot(6)).lagged)

    def test_dots(self) -> None:
        message = snapshot()
        frame = self.take(message)
        self.assertEqual(frame.dots, ())
        self.assertEqual(more_of(message, dots(1)), dots(1))
        self.assertIsNone(more_of(message, dots(2)))
        self.assertIsNone(more_of(message, dots(1, stream=8)))
        self.assertIsNone(more_of(m.Heartbeat(9, 1), dots(1)))
        self.tracker.complete(frame, dots(1))
        self.assertEqual((frame.dots[0].edge, frame.dots_total), ((2, 3), 1))
        # Dots stay until the daemon sends others.
        self.assertEqual(self.take(diff()).dots, frame.dots)
        self.assertEqual(self.take(snapshot(7, cause="Lagged")).dots, frame.dots)
        self.assertEqual(self.take(snapshot(8, cause="CannotResume")).dots, ())

    def test_late_dots_make_a_frame(self) -> None:
        self.take(snapshot())
        frame = self.take(dots(1))
        self.assertEqual((frame.kind, frame.number, len(frame.dots)), ("dots", 1, 1))
        self.assertEqual(len(frame.vertices), 4)

    def test_dots_that_do_not_fit(self) -> None:
        for message in (snapshot(stream=8), diff(stream=8), diff(), dots(1), m.Resumed(9, 1), m.Resumed(8, 1)):
            with self.subTest(message=message), self.assertRaises(ResyncNeeded):
                self.tracker.take(message)

    def test_a_closed_stream_is_forgotten(self) -> None:
        self.take(snapshot())
        self.assertIsNone(self.tracker.take(m.StreamClosed(9, 1, "ended")))
        self.assertEqual(self.tracker.mirrors(), {})
        with self.assertRaises(ResyncNeeded):
            self.tracker.take(diff())

    def test_other_messages_make_no_frame(self) -> None:
        self.assertIsNone(self.tracker.take(m.Heartbeat(9, 1)))


class Resuming(unittest.TestCase):
    def setUp(self) -> None:
        first = Tracker()
        first.take(opened())
        first.take(snapshot())
        self.kept = first.mirrors()
        self.tracker = Tracker(self.kept.values())

    def test_from_what_is_held(self) -> None:
        self.tracker.take(opened(stream=4))
        self.tracker.take(m.Resumed(4, 1))
        frame = self.tracker.take(diff(stream=4))
        assert frame is not None
        self.assertEqual(frame.number, 2)
        self.assertIs(self.tracker.mirrors()["lidar"], self.kept["lidar"])

    def test_only_if_the_daemon_says_so(self) -> None:
        self.tracker.take(opened(stream=4))
        with self.assertRaises(ResyncNeeded):
            self.tracker.take(diff(stream=4))

    def test_not_from_another_frame_or_epoch(self) -> None:
        self.tracker.take(opened(stream=4))
        with self.assertRaises(ResyncNeeded):
            self.tracker.take(m.Resumed(4, 2))
        other = Tracker(self.kept.values())
        other.take(opened(stream=4, epoch=78))
        with self.assertRaises(ResyncNeeded):
            other.take(m.Resumed(4, 1))

    def test_a_snapshot_begins_anew(self) -> None:
        self.tracker.take(opened(stream=4, epoch=78))
        frame = self.tracker.take(snapshot(3, stream=4, cause="CannotResume"))
        assert frame is not None
        self.assertEqual((frame.epoch, frame.number), (78, 3))
        self.assertIsNot(self.tracker.mirrors()["lidar"], self.kept["lidar"])
