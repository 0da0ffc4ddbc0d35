"""Streams of points in R^d: packing, producers, mirrors, frames."""

from __future__ import annotations

import dataclasses
import io
import math
import random
import struct
import unittest
from typing import Any

import hopes_client as hopes
from hopes_client import checksum as hashes
from hopes_client import messages as m
from hopes_client import spaces as s
from hopes_client.errors import BodyError, DaemonTooOld, ResyncNeeded
from hopes_client.mirror import Mirror
from hopes_client.points import pack_points_of
from hopes_client.shared import Cause
from hopes_client.track_mirror import TrackMirror
from hopes_client.wire import Banner, pack_frame

from .fake import Fake, Script, daemon
from .samples import (
    CUBE,
    EUCLIDEAN,
    FULL,
    flat,
    header,
    opened,
    snapshot,
    space_checksum,
    space_diff,
    space_dots,
    space_snapshot,
    space_track,
    space_tracks,
)

OPENED = s.SpaceOpened(m.Opened(9, 77, True, hopes.Window.all(), None, 4, 2), EUCLIDEAN, None, 4096)
POINTS = [(0.0, 0.5, 1.0), (2.0, -0.0, 3.0), (4.0, 5.0, 6.0)]
ALL = [number for point in POINTS for number in point]


def opening(script: Script, answer: s.SpaceOpened = OPENED) -> Script:
    """Answers `OpenSpace` before the script begins."""

    def play(fake: Fake) -> None:
        fake.receive(1, s.OpenSpace)
        fake.send(1, answer)
        script(fake)

    return play


def closing(fake: Fake) -> None:
    """Answers `Close` and waits for `Goodbye`."""
    fake.receive(1, m.Close)
    fake.send(1, m.Closed(4))
    fake.serve_goodbye()


class Metrics(unittest.TestCase):
    def test_names(self) -> None:
        for name in ("euclidean", "Euclidean", "EUCLIDEAN", EUCLIDEAN):
            self.assertEqual(s.Metric.of(name), EUCLIDEAN)
        for name in ("plane", "", "matrix"):
            with self.assertRaisesRegex(ValueError, "euclidean, manhattan, chebyshev, angular, haversine"):
                s.Metric.of(name)


class Packing(unittest.TestCase):
    def test_lists(self) -> None:
        packed = pack_points_of([[1, 2.5, 3], (4.0, None, 6)])
        self.assertEqual(packed.count, 2)
        self.assertEqual(struct.unpack("<4d", bytes(packed.data)[:32]), (1, 2.5, 3, 4))
        self.assertTrue(math.isnan(struct.unpack_from("<d", packed.data, 32)[0]), "the daemon refuses and counts it")
        self.assertEqual(pack_points_of([]).count, 0)

    def test_points_of_different_dimensions(self) -> None:
        for points in ([(1.0, 2.0), (1.0,)], [(1.0,), (1.0, 2.0)], [()], [(1.0,), ()]):
            with self.assertRaisesRegex(ValueError, "coordinates"):
                pack_points_of(points)

    def test_arrays(self) -> None:
        try:
            import numpy
        except ImportError:
            self.skipTest("numpy is not installed")
        expected = bytes(pack_points_of(POINTS).data)
        array = numpy.array(POINTS)
        for same in (array, numpy.asfortranarray(array), array.astype(">f8")):
            packed = pack_points_of(same)
            self.assertEqual((packed.count, bytes(packed.data)), (3, expected))
        self.assertEqual(pack_points_of(numpy.zeros((0, 3))).count, 0)
        for shape in ((4,), (4, 0), (2, 2, 2)):
            with self.assertRaisesRegex(ValueError, "not \\(n, d\\)"):
                pack_points_of(numpy.zeros(shape))


class Producing(unittest.TestCase):
    def test_open_send_retract_commit(self) -> None:
        def script(fake: Fake) -> None:
            question = fake.receive(1, s.OpenSpace)
            self.assertEqual(question, s.OpenSpace("cloud", hopes.Window.frames(1), 0.5, EUCLIDEAN, None))
            fake.send(1, OPENED)
            # The daemon takes two points in one message.
            self.assertEqual(fake.receive(1, s.SpaceBatch), s.SpaceBatch(1, 3, ALL[:6], [1.0, 2.0], [10, 11]))
            self.assertEqual(fake.receive(1, s.SpaceBatch), s.SpaceBatch(2, 3, ALL[6:], [3.0], [12]))
            fake.send(1, m.Accepted(1, 2, [(10, 0), (11, 1)]))
            fake.send(1, m.Refused(2, 0, 1, [m.Refusal(0, 1, "not finite")], []))
            self.assertEqual(fake.receive(1, s.SpaceRetract), s.SpaceRetract(3, 3, ALL[:3]))
            fake.send(1, m.Accepted(3, 1, []))
            self.assertEqual(fake.receive(1, m.Commit), m.Commit(4, 1.5))
            fake.send(1, m.Committed(4, 5))
            closing(fake)

        with daemon(script) as made:
            window = hopes.Window.frames(1)
            stream = made.producer("cloud", metric="euclidean", window=window, resolution=0.5)
            self.assertEqual((stream.metric, stream.dimension, stream.opened), (EUCLIDEAN, None, OPENED.opened))
            answer = stream.send(POINTS, times=[1.0, 2.0, 3.0], tags=[10, 11, 12])
            self.assertEqual(stream.dimension, 3, "the first points fix it")
            stream.retract(POINTS[:1])
            self.assertEqual(stream.commit(time=1.5), 5)
            self.assertEqual((answer.accepted, answer.placed), (2, {10: 0, 11: 1}))
            self.assertEqual([refusal.index for refusal in answer.refused], [2])
            stream.close()

    def test_another_dimension_is_not_sent(self) -> None:
        fixed = dataclasses.replace(OPENED, dimension=3)
        with daemon(opening(closing, fixed)) as made:
            stream = made.producer("cloud", dimension=3)
            for points in ([(1.0, 2.0)], [(1.0, 2.0, 3.0, 4.0)]):
                with self.assertRaisesRegex(ValueError, "those of the stream 3"):
                    stream.send(points)
                with self.assertRaisesRegex(ValueError, "those of the stream 3"):
                    stream.retract(points)
            self.assertEqual(stream.send([]).points, 0)
            stream.close()

    def test_a_message_that_is_not_sent_fixes_no_dimension(self) -> None:
        with daemon(opening(closing)) as made:
            stream = made.producer("cloud", metric=EUCLIDEAN)
            with self.assertRaises(ValueError):
                stream.send(POINTS, times=[1.0])
            self.assertIsNone(stream.dimension)
            stream.close()

    def test_batches_fit_into_the_largest_frame(self) -> None:
        wide = [[float(number)] * 4096 for number in range(40)]
        answer = dataclasses.replace(OPENED, opened=dataclasses.replace(OPENED.opened, largest_batch=65_536))
        received: list[int] = []

        def script(fake: Fake) -> None:
            while sum(received) < 40:
                batch = fake.receive(1, s.SpaceBatch)
                self.assertLessEqual(len(m.encode(batch)), 1 << 20, "the fake reads no larger frame")
                received.append(len(batch.coordinates) // 4096)
                fake.send(1, m.Accepted(batch.sequence, received[-1], []))
            closing(fake)

        with daemon(opening(script, answer)) as made:
            stream = made.producer("cloud", metric="euclidean")
            self.assertEqual(stream.send(wide).wait().accepted, 40)
            stream.close()
        self.assertGreater(len(received), 1)

    def test_an_older_daemon(self) -> None:
        with daemon(Fake.serve_goodbye, version=3) as made:
            with self.assertRaisesRegex(DaemonTooOld, "needs version 4"):
                made.producer("cloud", metric="euclidean")
            with self.assertRaises(DaemonTooOld):
                made.list_spaces()

    def test_list_spaces(self) -> None:
        spaces = [s.SpaceInfo(9, EUCLIDEAN, None)]

        def script(fake: Fake) -> None:
            fake.receive(1, s.ListSpaces)
            fake.send(1, s.Spaces(spaces))
            fake.serve_goodbye()

        with daemon(script) as made:
            self.assertEqual(made.list_spaces(), spaces)


class Following(unittest.TestCase):
    def test_frames(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.Subscribe)
            event = s.SpaceTrackEvent(2, None, hopes.Happening("Born"), space_track(2))
            messages: list[m.Message] = [
                opened(),
                space_snapshot(),
                space_dots(1),
                space_tracks(0, 1, alive=[space_track(1)], cycles={1: [[0, 1, 2]]}),
                space_diff(),
                space_dots(2),
                space_tracks(1, 2, (event,), alive=[space_track(1), space_track(2)]),
                m.StreamClosed(9, 2, "ended"),
            ]
            for message in messages:
                fake.send(1, message)
            fake.serve_goodbye()

        with daemon(script) as made:
            frames = []
            subscription = made.follow("lidar", dots=hopes.Dots.all(), tracks="cycles", stop_when_closed=False)
            for _ in range(2):
                frame = subscription.next_frame()
                assert frame is not None
                frames.append(frame.copy())
        first, second = frames
        self.assertEqual((first.kind, first.metric, first.dimension), ("snapshot", EUCLIDEAN, 3))
        self.assertEqual(first.vertices, {row[0]: row[1:] for row in CUBE})
        self.assertEqual(first.critical, {(2, 3): (1.0, math.inf)})
        self.assertEqual([(dot.birth, dot.death) for dot in first.dots], [(1.0, None), (1.0, 1.5)])
        self.assertEqual((first.tracks[1].persistence, first.track_cycles), (math.inf, {1: [[0, 1, 2]]}))
        self.assertEqual((second.kind, second.dots_total), ("diff", 2))
        self.assertEqual(second.vertices, {0: CUBE[0][1:], 2: (2.5, 2.0, 0.5), 3: CUBE[3][1:], 4: (3.0, 0.0, -0.0)})
        self.assertEqual([event.track.id for event in second.track_events], [2])

    def test_a_recording(self) -> None:
        messages: list[m.Message] = [opened(), space_snapshot(), space_diff(), m.Goodbye("done", [])]
        frames = [pack_frame(message.TYPE, 0, m.encode(message), 4) for message in messages]
        recording = hopes.Recording(io.BytesIO(Banner(4, 4).encode() + b"".join(frames)))
        self.assertEqual([(frame.number, frame.dimension) for frame in recording], [(1, 3), (2, 3)])

    def test_a_client_that_is_too_old_is_told(self) -> None:
        text = "cloud is a stream of points in R^3: it needs version 4"

        def script(fake: Fake) -> None:
            fake.receive(1, m.Subscribe)
            fake.send(1, m.Error(20, 0, text))
            fake.send(1, opened())
            fake.send(1, snapshot())
            fake.serve_goodbye()

        with daemon(script, version=3) as made:
            frames = made.follow("*")
            with self.assertRaisesRegex(hopes.DaemonError, "needs version 4"):
                next(frames)
            self.assertEqual(next(frames).stream, "lidar", "the others are followed")


class TheMirror(unittest.TestCase):
    def setUp(self) -> None:
        self.mirror = Mirror()
        self.mirror.apply_snapshot(space_snapshot())

    def refuse(self, change: s.AnyDiff) -> None:
        """Checks that the diff is refused and changes nothing."""
        before = (self.mirror.header, dict(self.mirror.vertices), self.mirror.dimension, self.mirror.checksum)
        with self.assertRaises(ResyncNeeded):
            self.mirror.apply_diff(change)
        after = (self.mirror.header, self.mirror.vertices, self.mirror.dimension, self.mirror.checksum)
        self.assertEqual(after, before)
        self.mirror.verify()

    def test_coordinates_that_are_no_whole_points(self) -> None:
        change = space_diff()
        for coordinates in (change.coordinates_added[:-1], [*change.coordinates_added, 1.0], []):
            self.refuse(dataclasses.replace(change, coordinates_added=coordinates))
        broken = dataclasses.replace(space_snapshot(), coordinates=flat(CUBE)[:-1])
        with self.assertRaises(ResyncNeeded):
            Mirror().apply_snapshot(broken)

    def test_another_dimension(self) -> None:
        change = space_diff()
        for dimension in (0, 1, 2, 6, 2**32 - 1):
            self.refuse(dataclasses.replace(change, dimension=dimension))
        # These fit but for their dimension: the checksum is right.
        held = self.mirror.checksum
        self.refuse(s.SpaceDiff(9, 1, header(2), 4, [], [], [], [], [], [], [], held))
        wider = (held + hashes.of_vertices([(9, *[1.0] * 4)])) & hashes.MASK
        self.refuse(s.SpaceDiff(9, 1, header(2), 4, [9], [1.0] * 4, [], [], [], [], [], wider))
        flatter = (held + hashes.of_vertices([(9, 1.0, 1.0)])) & hashes.MASK
        self.refuse(m.Diff(9, 1, header(2), [(9, 1.0, 1.0)], [], [], [], [], [], flatter))
        self.mirror.apply_diff(s.SpaceDiff(9, 1, header(2), 3, [], [], [], [], [], [], [], held))

    def test_numbers_that_are_not_finite(self) -> None:
        raw = bytes(m.encode(space_snapshot()))
        for odd in (math.nan, math.inf, -math.inf):
            # The first coordinate that is 2.0 is one of vertex 1.
            broken = raw.replace(struct.pack("<d", 2.0), struct.pack("<d", odd), 1)
            with self.assertRaises(BodyError):
                m.decode(s.SpaceSnapshot.TYPE, broken)
            deaths = [(2, 3, 1.0, odd)]
            if odd != math.inf:
                with self.assertRaises(ValueError):
                    m.encode(dataclasses.replace(space_snapshot(), critical=deaths))

    def test_only_a_death_may_be_infinite(self) -> None:
        raw = bytes(m.encode(space_snapshot()))
        birth_and_death = struct.pack("<dd", 1.0, math.inf)
        self.assertEqual(raw.count(birth_and_death), 1)
        for pair in ((math.inf, 1.0), (1.0, -math.inf), (1.0, math.nan), (math.inf, math.inf)):
            with self.subTest(pair=pair), self.assertRaises(BodyError):
                m.decode(s.SpaceSnapshot.TYPE, raw.replace(birth_and_death, struct.pack("<dd", *pair)))

    def test_a_stream_without_points(self) -> None:
        mirror = Mirror()
        nothing = s.SpaceSnapshot(9, Cause("Start"), header(1), EUCLIDEAN, 0, [], [], [], [], 0)
        mirror.apply_snapshot(nothing)
        self.assertEqual((mirror.metric, mirror.dimension), (EUCLIDEAN, 0))
        with self.assertRaises(ResyncNeeded):
            mirror.apply_snapshot(dataclasses.replace(nothing, ids=[1], checksum=hashes.of_vertices([(1,)])))
        total = hashes.of_vertices([(1, *[0.5] * 5)])
        first = s.SpaceDiff(9, 1, header(2), 5, [1], [0.5] * 5, [], [], [], [], [], total)
        mirror.apply_diff(first)
        self.assertEqual((mirror.dimension, mirror.vertices), (5, {1: (0.5,) * 5}))

    def test_two_coordinates_have_the_checksum_of_the_plane(self) -> None:
        plane = snapshot()
        coordinates = flat(list(plane.vertices))
        ids = [row[0] for row in plane.vertices]
        space = s.SpaceSnapshot(
            9, plane.cause, plane.frame, EUCLIDEAN, 2, ids, coordinates, plane.edges, plane.critical, plane.checksum
        )
        mirror = Mirror()
        mirror.apply_snapshot(space)
        self.assertEqual(mirror.checksum, plane.checksum)

    def test_random_diffs_in_many_dimensions(self) -> None:
        chosen = random.Random(17)
        for dimension in (1, 3, 20):
            mirror = Mirror()
            held: dict[int, tuple[float, ...]] = {}
            mirror.apply_snapshot(s.SpaceSnapshot(9, Cause("Start"), header(1), EUCLIDEAN, 0, [], [], [], [], 0))
            for number in range(2, 40):
                there = {
                    id: tuple(chosen.choice([0.0, -0.0, 1.5, 5e-324, -1e300]) for _ in range(dimension))
                    for id in chosen.sample(range(12), chosen.randrange(10))
                }
                added: list[tuple[Any, ...]] = [
                    (id, *at) for id, at in sorted(there.items()) if not same(held.get(id), at)
                ]
                removed = [id for id in sorted(held) if not same(there.get(id), held[id])]
                rows: list[tuple[Any, ...]] = [(id, *at) for id, at in there.items()]
                total = space_checksum(rows, [], [])
                ids = [row[0] for row in added]
                mirror.apply_diff(
                    s.SpaceDiff(
                        9, number - 1, header(number, FULL), dimension, ids, flat(added), removed, [], [], [], [], total
                    )
                )
                held = there
                self.assertTrue(all(same(mirror.vertices.get(id), at) for id, at in there.items()))
                self.assertEqual((mirror.vertices.keys(), mirror.dimension), (there.keys(), dimension))
                mirror.verify()


def same(one: tuple[float, ...] | None, other: tuple[float, ...] | None) -> bool:
    """Whether two positions are the same bit by bit."""
    bits = [position and struct.pack(f"{len(position)}d", *position) for position in (one, other)]
    return bits[0] is not None and bits[0] == bits[1]


class TheTrackMirror(unittest.TestCase):
    def test_centres_of_another_dimension(self) -> None:
        right = space_track(1)
        for wrong in (
            dataclasses.replace(space_track(2), center=[1.0]),
            dataclasses.replace(space_track(2), velocity=[1.0]),
            dataclasses.replace(space_track(2), center=[1.0], velocity=[1.0]),
        ):
            mirror = TrackMirror()
            with self.assertRaises(ResyncNeeded):
                mirror.apply(space_tracks(0, 1, alive=[right, wrong]))
            mirror.apply(space_tracks(0, 1, alive=[right]))
            event = s.SpaceTrackEvent(2, None, hopes.Happening("Born"), wrong)
            with self.assertRaises(ResyncNeeded):
                mirror.apply(space_tracks(1, 2, (event,)))
            self.assertEqual(mirror.alive.keys(), {1})
