"""Consumers: frames, dots, timeouts, resuming and reconnecting, with a scripted daemon."""

from __future__ import annotations

import dataclasses
import gc
import time
import unittest
from typing import Any
from unittest import mock

import hopes_client as hopes
from hopes_client import messages as m
from hopes_client.shared import Cause

from .fake import Fake, Script, daemon
from .samples import FULL, SIMPLE, diff, dots, header, opened, snapshot


def sending(*messages: m.Message) -> Script:
    """Waits for a subscription, sends these messages, and serves an unsubscription."""

    def play(fake: Fake) -> None:
        fake.receive(1, m.Subscribe)
        for message in messages:
            fake.send(1, message)
        serve_unsubscribe(fake)

    return play


def serve_unsubscribe(fake: Fake) -> None:
    channel, message = fake.next()
    if isinstance(message, m.Unsubscribe):
        fake.send(channel, m.Unsubscribed())
        fake.serve_goodbye()


class Subscribing(unittest.TestCase):
    def asked_for(self, **options: Any) -> m.Subscribe:
        """The message that `follow` sends."""
        asked: list[m.Subscribe] = []

        def script(fake: Fake) -> None:
            asked.append(fake.receive(1, m.Subscribe))
            fake.serve_goodbye()

        with daemon(script) as made:
            made.follow("lidar", **options)
        return asked[0]

    def test_views(self) -> None:
        cut, simplify = hopes.Cut, hopes.Simplify
        for options, view in (
            ({}, FULL),
            ({"full": True}, FULL),
            ({"full": True, "simplify": 2}, hopes.View(cut.full(), simplify.below(2.0))),
            ({"alpha": 1.5}, hopes.View(cut.reduced(1.5), simplify.no())),
            ({"alpha": 1.5, "simplify": True}, hopes.View(cut.reduced(1.5), simplify.at_scale())),
            ({"k": 2}, hopes.View(cut.derived(2, 1), simplify.no())),
            ({"l": 3}, hopes.View(cut.derived(1, 3), simplify.no())),
            ({"k": 1, "l": 1, "simplify": True}, SIMPLE),
        ):
            with self.subTest(options=options):
                self.assertEqual(self.asked_for(**options), m.Subscribe("lidar", view, hopes.Dots.no(), None))

    def test_dots(self) -> None:
        self.assertEqual(self.asked_for(dots=hopes.Dots.top(10)).dots, hopes.Dots.top(10))

    def test_invalid_views(self) -> None:
        for options in ({"full": True, "k": 1}, {"alpha": 1.0, "l": 1}, {"simplify": True}, {"k": 0}):
            with self.subTest(options=options), self.assertRaises(ValueError):
                hopes.View.of(**options)


class Following(unittest.TestCase):
    def test_frames(self) -> None:
        with daemon(sending(opened(), snapshot(), m.Heartbeat(9, 1), diff())) as made:
            numbers = []
            for frame in made.follow("lidar"):
                numbers.append((frame.number, frame.kind, sorted(frame.vertices)))
                if frame.number == 2:
                    break
        self.assertEqual(numbers, [(1, "snapshot", [0, 1, 2, 3]), (2, "diff", [0, 2, 3, 4])])

    def test_a_single_stream_ends_the_iteration_when_it_is_closed(self) -> None:
        with daemon(sending(opened(), snapshot(), m.StreamClosed(9, 1, "ended"))) as made:
            subscription = made.follow("lidar")
            self.assertEqual([frame.number for frame in subscription], [1])
            self.assertEqual(list(subscription), [])
            assert subscription.closed_stream is not None
            self.assertEqual(subscription.closed_stream.reason, "ended")

    def test_a_pattern_goes_on(self) -> None:
        script = sending(
            opened(),
            snapshot(),
            m.StreamClosed(9, 1, "ended"),
            opened(stream=10, name="radar"),
            snapshot(stream=10),
            opened(stream=11, epoch=78),
            snapshot(number=3, stream=11),
        )
        with daemon(script) as made:
            subscription = made.follow("*")
            frames = [next(subscription) for _ in range(3)]
            self.assertEqual(
                [(frame.stream, frame.epoch) for frame in frames], [("lidar", 77), ("radar", 77), ("lidar", 78)]
            )
            self.assertEqual(set(subscription.mirrors()), {"lidar", "radar"})
            self.assertEqual(frames[1].vertices, frames[2].vertices)

    def test_timeout(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.Subscribe)
            fake.send(1, opened())
            fake.receive(2, m.ListStreams)
            fake.send(1, snapshot())
            fake.send(2, m.Streams([]))
            serve_unsubscribe(fake)

        with daemon(script) as made:
            subscription = made.follow("lidar", timeout=0.05)
            for _ in range(2):
                with self.assertRaises(hopes.TimedOut):
                    next(subscription)
            made.list_streams()
            self.assertEqual(next(subscription).number, 1)
            with self.assertRaises(TimeoutError):
                subscription.next_frame(timeout=0)

    def test_errors(self) -> None:
        with daemon(sending(m.Error(5, m.Subscribe.TYPE, "bad pattern"))) as made:
            subscription = made.follow("lidar")
            with self.assertRaises(hopes.DaemonError) as caught:
                next(subscription)
            self.assertEqual(caught.exception.code, 5)
            self.assertEqual(list(subscription), [])

    def test_change_of_view(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.Subscribe)
            fake.send(1, opened())
            fake.send(1, snapshot())
            self.assertEqual(fake.receive(1, m.ChangeView), m.ChangeView(SIMPLE, hopes.Dots.all()))
            fake.send(1, diff())
            fake.send(1, m.Snapshot(9, Cause("ViewChanged"), header(2, SIMPLE), [], [], [], 0))
            self.assertEqual(fake.receive(1, m.ChangeView), m.ChangeView(FULL, hopes.Dots.all()))
            fake.send(1, m.Error(9, m.ChangeView.TYPE, "not now"))
            fake.send(1, m.Diff(9, 2, header(3, SIMPLE), [], [], [], [], [], [], 0))
            serve_unsubscribe(fake)

        with daemon(script) as made:
            subscription = made.follow("lidar", dots_wait=0.0)
            self.assertEqual(next(subscription).view, FULL)
            subscription.change_view(k=1, l=1, simplify=True, dots=hopes.Dots.all())
            self.assertEqual((next(subscription).number, next(subscription).cause), (2, "ViewChanged"))
            subscription.change_view()
            with self.assertRaises(hopes.DaemonError):
                next(subscription)
            self.assertEqual(next(subscription).number, 3)

    def test_unsubscribe(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.Subscribe)
            fake.receive(1, m.Unsubscribe)
            fake.send(1, opened())
            fake.send(1, snapshot())
            fake.send(1, m.Unsubscribed())
            fake.receive(2, m.ListStreams)
            fake.send(2, m.Streams([]))
            fake.serve_goodbye()

        with daemon(script) as made:
            with made.follow("lidar") as subscription:
                pass
            subscription.close()
            self.assertIsNone(subscription.next_frame())
            self.assertEqual(made.list_streams(), [])

    def test_a_subscription_that_is_dropped_is_unsubscribed(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.Subscribe)
            fake.send(1, opened())
            fake.send(1, snapshot())
            fake.send(1, diff())
            fake.receive(1, m.Unsubscribe)
            fake.receive(2, m.ListStreams)
            fake.send(1, m.Unsubscribed())
            fake.send(2, m.Streams([]))
            fake.serve_goodbye()

        with daemon(script) as made:
            for _ in made.follow("lidar"):
                break
            gc.collect()
            self.assertEqual(made.list_streams(), [])
            self.assertEqual(made.connection._waiting_bytes, 0)


class TheDots(unittest.TestCase):
    def follow(self, *messages: m.Message, count: int) -> list[hopes.Frame]:
        with daemon(sending(*messages)) as made:
            subscription = made.follow("lidar", dots=hopes.Dots.top(1))
            return [next(subscription) for _ in range(count)]

    def test_they_belong_to_the_frame_before(self) -> None:
        frames = self.follow(opened(), snapshot(), dots(1), diff(), count=2)
        self.assertEqual([(frame.kind, len(frame.dots)) for frame in frames], [("snapshot", 1), ("diff", 1)])
        self.assertEqual(frames[0].dots[0].center, (1.0, 1.0))

    def test_dots_of_the_last_frame_are_not_waited_for_long(self) -> None:
        started = time.monotonic()
        self.assertEqual(self.follow(opened(), snapshot(), count=1)[0].dots, ())
        self.assertLess(time.monotonic() - started, 2.0)

    def test_late_ones_make_a_frame(self) -> None:
        frames = self.follow(opened(), snapshot(), m.Heartbeat(9, 1), dots(1), count=2)
        self.assertEqual([(frame.kind, len(frame.dots)) for frame in frames], [("snapshot", 0), ("dots", 1)])

    def test_a_frame_before_a_lost_connection_is_returned(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.Subscribe)
            fake.send(1, opened())
            fake.send(1, snapshot())

        with daemon(script) as made:
            subscription = made.follow("lidar", dots=hopes.Dots.all())
            self.assertEqual(next(subscription).number, 1)
            with self.assertRaises(hopes.ConnectionLost):
                next(subscription)


class Resuming(unittest.TestCase):
    def mirror(self) -> hopes.Mirror:
        """The mirror of a subscription whose connection has ended."""
        with daemon(sending(opened(), snapshot())) as made:
            subscription = made.follow("lidar")
            next(subscription)
            return subscription.mirrors()["lidar"]

    def test_it_goes_on(self) -> None:
        def script(fake: Fake) -> None:
            self.assertEqual(fake.receive(1, m.Subscribe).resume, m.Resume(77, 1))
            for message in (opened(stream=3), m.Resumed(3, 1), diff(stream=3)):
                fake.send(1, message)
            serve_unsubscribe(fake)

        mirror = self.mirror()
        with daemon(script) as made:
            frame = next(made.follow("lidar", resume=mirror))
            self.assertEqual((frame.kind, frame.number), ("diff", 2))
            self.assertEqual(mirror.number, 2)

    def test_it_cannot(self) -> None:
        script = sending(opened(epoch=78), snapshot(cause="CannotResume"))
        mirror = self.mirror()
        with daemon(script) as made:
            frame = next(made.follow("lidar", resume=mirror))
            self.assertEqual((frame.cause, frame.epoch), ("CannotResume", 78))

    def test_only_the_same_stream_in_the_same_view(self) -> None:
        mirror = self.mirror()
        with daemon(lambda fake: fake.serve_goodbye()) as made:
            with self.assertRaises(ValueError):
                made.follow("radar", resume=mirror)
            with self.assertRaises(ValueError):
                made.follow("lidar", alpha=1.0, resume=mirror)


@mock.patch("hopes_client.consumer._SHORTEST_PAUSE", 0.01)
class Reconnecting(unittest.TestCase):
    def vanish(self, fake: Fake) -> None:
        """Closes the connection after a snapshot."""
        fake.receive(1, m.Subscribe)
        fake.send(1, opened())
        fake.send(1, snapshot())

    def test_it_resumes(self) -> None:
        def script(fake: Fake) -> None:
            self.assertEqual(fake.receive(1, m.Subscribe).resume, m.Resume(77, 1))
            for message in (opened(stream=3), m.Resumed(3, 1), diff(stream=3)):
                fake.send(1, message)
            serve_unsubscribe(fake)

        with daemon(self.vanish, script) as made:
            subscription = made.follow("lidar", reconnect=True)
            self.assertEqual([next(subscription).kind, next(subscription).kind], ["snapshot", "diff"])

    def test_it_outlives_its_stream(self) -> None:
        def closes(fake: Fake) -> None:
            self.vanish(fake)
            fake.send(1, m.StreamClosed(9, 1, "shutting down"))
            fake.send(0, m.Goodbye("shutting down", [("lidar", 1)]))

        def script(fake: Fake) -> None:
            # Nothing is kept of a stream that was closed.
            self.assertIsNone(fake.receive(1, m.Subscribe).resume)
            fake.send(1, opened(epoch=78))
            fake.send(1, snapshot())
            serve_unsubscribe(fake)

        with daemon(closes, script) as made:
            subscription = made.follow("lidar", reconnect=True)
            self.assertEqual([next(subscription).epoch, next(subscription).epoch], [77, 78])

    def test_it_does_not_reconnect_by_default(self) -> None:
        with daemon(self.vanish) as made:
            subscription = made.follow("lidar")
            next(subscription)
            with self.assertRaises(hopes.ConnectionLost):
                next(subscription)

    def test_a_pattern_starts_again(self) -> None:
        def script(fake: Fake) -> None:
            self.assertIsNone(fake.receive(1, m.Subscribe).resume)
            fake.send(1, opened(stream=3))
            fake.send(1, snapshot(number=6, stream=3))
            serve_unsubscribe(fake)

        with daemon(self.vanish, script) as made:
            subscription = made.follow("lid*", reconnect=True)
            self.assertEqual([next(subscription).number, next(subscription).number], [1, 6])

    def test_several_attempts(self) -> None:
        def fails(fake: Fake) -> None:
            fake.receive(1, m.Subscribe)

        def says_goodbye(fake: Fake) -> None:
            fake.receive(1, m.Subscribe)
            fake.send(0, m.Goodbye("not yet", []))

        script = sending(opened(epoch=78), snapshot(cause="CannotResume"))
        with daemon(self.vanish, fails, says_goodbye, fails, script) as made:
            subscription = made.follow("lidar", reconnect=True)
            self.assertEqual([next(subscription).epoch, next(subscription).epoch], [77, 78])

    def test_a_deadline(self) -> None:
        with daemon(self.vanish) as made:
            subscription = made.follow("lidar", reconnect=True, timeout=0.2)
            next(subscription)
            started = time.monotonic()
            with self.assertRaises(hopes.TimedOut):
                next(subscription)
            self.assertLess(time.monotonic() - started, 2.0)

    def test_a_diff_that_does_not_fit_causes_a_new_subscription(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.Subscribe)
            for message in (opened(), snapshot(), dataclasses.replace(diff(), checksum=0)):
                fake.send(1, message)
            fake.receive(1, m.Unsubscribe)
            self.assertEqual(fake.receive(2, m.Subscribe).resume, None)
            fake.send(1, m.Unsubscribed())
            fake.send(2, opened(stream=4))
            fake.send(2, snapshot(number=2, stream=4))
            serve_unsubscribe(fake)

        with daemon(script) as made:
            subscription = made.follow("lidar", reconnect=True)
            self.assertEqual([next(subscription).number, next(subscription).number], [1, 2])

    def test_a_diff_that_does_not_fit_is_an_error_by_default(self) -> None:
        with daemon(sending(opened(), snapshot(), dataclasses.replace(diff(), checksum=0))) as made:
            subscription = made.follow("lidar")
            next(subscription)
            with self.assertRaises(hopes.ResyncNeeded):
                next(subscription)

    def test_two_subscriptions_share_the_new_connection(self) -> None:
        def first(fake: Fake) -> None:
            for channel in (1, 2):
                fake.receive(channel, m.Subscribe)
            for channel in (1, 2):
                fake.send(channel, opened())
                fake.send(channel, snapshot())

        def second(fake: Fake) -> None:
            for channel in (1, 2):
                fake.receive(channel, m.Subscribe)
                for message in (opened(), m.Resumed(9, 1), diff()):
                    fake.send(channel, message)
            fake.serve_goodbye()

        with daemon(first, second) as made:
            both = [made.follow("lidar", reconnect=True) for _ in range(2)]
            for subscription in both:
                self.assertEqual(next(subscription).number, 1)
            for subscription in both:
                self.assertEqual(next(subscription).number, 2)

    def test_a_daemon_that_was_closed_stays_closed(self) -> None:
        with daemon(sending(opened(), snapshot())) as made:
            subscription = made.follow("lidar", reconnect=True)
            next(subscription)
            made.close()
            with self.assertRaises(hopes.ConnectionLost):
                next(subscription)
