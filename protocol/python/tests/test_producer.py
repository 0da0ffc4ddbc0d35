"""Producers: batches, pipelining, answers, refusals."""

from __future__ import annotations

import struct
import sys
import threading
import unittest
from array import array
from unittest import mock

import hopes_client as hopes
from hopes_client import messages as m
from hopes_client.points import list_tags, pack_numbers, pack_points
from hopes_client.producer import MOST_UNANSWERED
from hopes_client.shared import Policy

from .fake import Fake, Script, daemon

OPENED = m.Opened(9, 77, True, hopes.Window.all(), None, 4, 10)
CORNERS = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)]


def opening(script: Script) -> Script:
    """Answers `Open` before the script begins."""

    def play(fake: Fake) -> None:
        fake.receive(1, m.Open)
        fake.send(1, OPENED)
        script(fake)

    return play


def closing(fake: Fake, frame: int = 4) -> None:
    """Answers `Close` and waits for `Goodbye`."""
    fake.receive(1, m.Close)
    fake.send(1, m.Closed(frame))
    fake.serve_goodbye()


class Packing(unittest.TestCase):
    def test_lists(self) -> None:
        packed = pack_points([(1, 2.5), [3.0, 4]])
        self.assertEqual((packed.count, bytes(packed.data)), (2, struct.pack("<4d", 1, 2.5, 3, 4)))
        self.assertEqual(pack_points(iter(CORNERS)).count, 4)
        self.assertEqual(pack_points([]).count, 0)
        self.assertEqual(bytes(pack_numbers(array("d", [1.0])).data), struct.pack("<d", 1.0))
        self.assertEqual(list_tags(range(3)), [0, 1, 2])

    def test_invalid_pairs(self) -> None:
        for points in ([(1.0,)], [(1.0, 2.0, 3.0)], [(1.0,), (1.0, 2.0, 3.0)]):
            with self.assertRaises(ValueError):
                pack_points(points)
        with self.assertRaises(TypeError):
            pack_points([1.0, 2.0])

    def test_numpy_is_not_imported(self) -> None:
        if "numpy" in sys.modules:
            self.skipTest("something else has imported numpy")
        pack_points(CORNERS)
        self.assertNotIn("numpy", sys.modules)


class Arrays(unittest.TestCase):
    def setUp(self) -> None:
        try:
            import numpy
        except ImportError:
            self.skipTest("numpy is not installed")
        self.numpy = numpy

    def test_any_layout_gives_the_bytes_of_the_list(self) -> None:
        expected = bytes(pack_points(CORNERS).data)
        points = self.numpy.array(CORNERS)
        transposed = self.numpy.asfortranarray(points)
        for array_ in (points, transposed, points.astype(">f8"), points.astype("f4"), points.astype(int)):
            packed = pack_points(array_)
            self.assertEqual((packed.count, bytes(packed.data)), (4, expected))

    def test_shapes(self) -> None:
        self.assertEqual(pack_points(self.numpy.zeros((0, 2))).count, 0)
        for shape in ((4,), (4, 3), (2, 2, 2)):
            with self.assertRaises(ValueError):
                pack_points(self.numpy.zeros(shape))
        with self.assertRaises(ValueError):
            pack_numbers(self.numpy.zeros((4, 2)))

    def test_tags(self) -> None:
        tags = list_tags(self.numpy.array([1, 2**63], dtype="u8"))
        self.assertEqual(tags, [1, 2**63])
        self.assertIs(type(tags[0]), int)


class Sending(unittest.TestCase):
    def test_open_send_commit_close(self) -> None:
        def script(fake: Fake) -> None:
            opening_message = fake.receive(1, m.Open)
            self.assertEqual(opening_message, m.Open("lidar", hopes.Window.frames(1), 0.5))
            fake.send(1, OPENED)
            batch = fake.receive(1, m.Batch)
            self.assertEqual(batch, m.Batch(1, CORNERS, [1.0, 2.0, 3.0, 4.0], [10, 11, 12, 13]))
            fake.send(1, m.Accepted(1, 4, [(10, 0), (11, 1), (12, 2), (13, 3)]))
            self.assertEqual(fake.receive(1, m.Retract), m.Retract(2, CORNERS[:1]))
            fake.send(1, m.Accepted(2, 1, []))
            self.assertEqual(fake.receive(1, m.Commit), m.Commit(3, 1.5))
            fake.send(1, m.Committed(3, 5))
            self.assertEqual(fake.receive(1, m.Close), m.Close(False))
            fake.send(1, m.Closed(6))
            fake.serve_goodbye()

        with daemon(script) as made:
            with made.producer("lidar", window=hopes.Window.frames(1), resolution=0.5) as stream:
                self.assertEqual(stream.frame, 4)
                answer = stream.send(CORNERS, times=[1, 2, 3, 4], tags=[10, 11, 12, 13])
                self.assertFalse(answer.done)
                stream.retract(CORNERS[:1])
                self.assertEqual(stream.commit(time=1.5), 5)
                self.assertTrue(answer.done)
                self.assertEqual((answer.accepted, answer.placed), (4, {10: 0, 11: 1, 12: 2, 13: 3}))
                self.assertEqual((stream.accepted, stream.unanswered), (5, 0))
            self.assertEqual(stream.close(), 6)
            with self.assertRaisesRegex(hopes.HopesError, "was closed"):
                stream.send(CORNERS)

    def test_large_batches_are_split(self) -> None:
        points = [(float(i), 0.0) for i in range(25)]

        def script(fake: Fake) -> None:
            batches = [fake.receive(1, m.Batch) for _ in range(3)]
            self.assertEqual([point for batch in batches for point in batch.points], points)
            self.assertEqual([tag for batch in batches for tag in batch.tags], list(range(25)))
            self.assertEqual([time for batch in batches for time in batch.times], [0.5] * 25)
            self.assertEqual([len(batch.points) for batch in batches], [10, 10, 5])
            fake.send(1, m.Accepted(1, 10, [(0, 5)]))
            fake.send(1, m.Refused(2, 8, 2, [m.Refusal(0, 1, "no"), m.Refusal(9, 4, "late")], []))
            fake.send(1, m.Overloaded(3, 5, 5, Policy("DropOldest")))
            closing(fake)

        with daemon(opening(script)) as made:
            stream = made.producer("lidar")
            answer = stream.send(points, times=[0.5] * 25, tags=range(25)).wait()
            self.assertEqual((answer.points, answer.accepted, answer.refused_count, answer.dropped), (25, 18, 2, 5))
            self.assertEqual([(refusal.index, refusal.code) for refusal in answer.refused], [(10, 1), (19, 4)])
            self.assertEqual(list(stream.refused), answer.refused)
            self.assertEqual((stream.accepted, stream.refused_count, stream.dropped), (18, 2, 5))
            made.close()

    def test_nothing_to_send(self) -> None:
        with daemon(opening(closing)) as made:
            stream = made.producer("lidar")
            self.assertTrue(stream.send([]).wait().done)
            made.close()

    def test_wrong_arguments(self) -> None:
        with daemon(opening(closing)) as made:
            stream = made.producer("lidar")
            with self.assertRaises(ValueError):
                stream.send(CORNERS, times=[1.0])
            with self.assertRaises(ValueError):
                stream.send(CORNERS, tags=[1])
            with self.assertRaises(ValueError):
                stream.commit(time=float("nan"))
            self.assertEqual(stream.unanswered, 0)
            made.close()

    def test_the_number_of_unanswered_messages_is_limited(self) -> None:
        first_answer = threading.Event()

        def script(fake: Fake) -> None:
            for sequence in range(1, MOST_UNANSWERED + 1):
                self.assertEqual(fake.receive(1, m.Batch).sequence, sequence)
            self.assertTrue(first_answer.wait(5.0))
            fake.send(1, m.Accepted(1, 1, []))
            self.assertEqual(fake.receive(1, m.Batch).sequence, MOST_UNANSWERED + 2)
            for sequence in range(2, MOST_UNANSWERED + 3):
                if sequence != MOST_UNANSWERED + 1:
                    fake.send(1, m.Accepted(sequence, 1, []))
            closing(fake)

        with daemon(opening(script)) as made:
            stream = made.producer("lidar")
            for _ in range(MOST_UNANSWERED):
                stream.send(CORNERS[:1])
            self.assertEqual(stream.unanswered, MOST_UNANSWERED)
            with self.assertRaises(hopes.TimedOut) as caught:
                stream.send(CORNERS[:1], timeout=0.05)
            self.assertEqual(caught.exception.sent, 0)
            first_answer.set()
            stream.send(CORNERS[:1])
            self.assertLessEqual(stream.unanswered, MOST_UNANSWERED)
            stream.flush()
            self.assertEqual(stream.accepted, MOST_UNANSWERED + 1)
            made.close()

    def test_answers_are_read_as_they_arrive(self) -> None:
        def script(fake: Fake) -> None:
            for _ in range(1000):
                fake.send(1, m.Accepted(fake.receive(1, m.Batch).sequence, 4, []))
            closing(fake)

        with daemon(opening(script)) as made:
            stream = made.producer("lidar")
            for _ in range(1000):
                stream.send(CORNERS)
                self.assertLessEqual(stream.unanswered, MOST_UNANSWERED)
            made.close()
            self.assertEqual(stream.accepted, 4000)

    def test_the_number_of_kept_refusals_is_bounded(self) -> None:
        def script(fake: Fake) -> None:
            for sequence in range(1, 4):
                fake.receive(1, m.Batch)
                fake.send(1, m.Refused(sequence, 0, 1, [m.Refusal(0, sequence, "no")], []))
            closing(fake)

        with mock.patch("hopes_client.producer.MOST_REFUSALS", 2), daemon(opening(script)) as made:
            stream = made.producer("lidar")
            for _ in range(3):
                stream.send(CORNERS[:1]).wait()
            self.assertEqual([refusal.code for refusal in stream.refused], [2, 3])
            self.assertEqual(stream.refused_count, 3)
            made.close()


class Failing(unittest.TestCase):
    def test_open_is_refused(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.Open)
            fake.send(1, m.Error(6, m.Open.TYPE, "the window is another"))
            fake.receive(2, m.ListStreams)
            fake.send(2, m.Streams([]))
            fake.serve_goodbye()

        with daemon(script) as made:
            with self.assertRaises(hopes.DaemonError) as caught:
                made.producer("lidar")
            self.assertEqual((caught.exception.code, caught.exception.answers), (6, 0x0101))
            self.assertEqual(made.list_streams(), [])

    def test_the_stream_fails(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.Batch)
            fake.send(1, m.Error(11, m.Batch.TYPE, "the stream has failed"))
            fake.serve_goodbye()

        with daemon(opening(script)) as made:
            stream = made.producer("lidar")
            answer = stream.send(CORNERS)
            for call in (answer.wait, stream.flush, stream.close, lambda: stream.send(CORNERS)):
                with self.assertRaises(hopes.DaemonError):
                    call()

    def test_another_producer_ends_the_stream(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.Batch)
            fake.send(1, m.Accepted(1, 4, []))
            fake.receive(1, m.Commit)
            fake.send(1, m.Closed(8))
            fake.serve_goodbye()

        with daemon(opening(script)) as made:
            stream = made.producer("lidar")
            stream.send(CORNERS)
            with self.assertRaises(hopes.StreamEnded) as caught:
                stream.commit()
            self.assertEqual((caught.exception.frame, stream.frame), (8, 8))
            with self.assertRaises(hopes.StreamEnded):
                stream.send(CORNERS)

    def test_closing_an_ended_stream_without_unanswered_messages_is_no_error(self) -> None:
        def script(fake: Fake) -> None:
            fake.send(1, m.Closed(8))
            fake.receive(2, m.ListStreams)
            fake.send(2, m.Streams([]))
            fake.receive(1, m.Close)
            fake.serve_goodbye()

        with daemon(opening(script)) as made:
            stream = made.producer("lidar")
            made.list_streams()
            self.assertEqual(stream.close(), 8)
            made.close()

    def test_an_answer_without_a_message(self) -> None:
        for answer in (m.Accepted(7, 1, []), m.Committed(7, 1), m.Streams([]), m.Accepted(1, 1, [])):

            def script(fake: Fake, answer: m.Message = answer) -> None:
                fake.receive(1, m.Commit)
                fake.send(1, answer)
                fake.serve_goodbye()

            with self.subTest(answer=answer), daemon(opening(script)) as made:
                stream = made.producer("lidar")
                with self.assertRaises(hopes.ProtocolError):
                    stream.commit()

    def test_closing_with_answers_missing_is_an_error(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.Batch)

        with daemon(opening(script)) as made, self.assertRaises(hopes.ConnectionLost), made:
            made.producer("lidar").send(CORNERS)

    def test_closing_without_answers_missing_is_no_error(self) -> None:
        def script(fake: Fake) -> None:
            fake.send(0, m.Goodbye("done", []))

        with daemon(opening(script)) as made, made:
            made.producer("lidar")
