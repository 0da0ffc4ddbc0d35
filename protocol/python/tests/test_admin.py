"""Administration with a scripted daemon: what is asked, and what comes of each answer."""

from __future__ import annotations

import unittest
from typing import Any, Callable

import hopes_client as hopes
from hopes_client import messages as m

from .fake import Fake, daemon
from .samples import MEMORY, PEER, opened, snapshot

#: Each method with its request and its answer, and what it gives.
CALLS: tuple[tuple[Callable[[hopes.Daemon], Any], m.Message, m.Message, Any], ...] = (
    (lambda made: made.peers(), m.ListPeers(), m.Peers([PEER]), [PEER]),
    (lambda made: made.peers(), m.ListPeers(), m.Peers([]), []),
    (lambda made: made.memory(), m.GetMemory(), MEMORY, MEMORY),
    (lambda made: made.stop_stream("lidar"), m.StopStream("lidar"), m.StreamStopped("lidar", 12), 12),
    (lambda made: made.disconnect(7), m.Disconnect(7), m.Disconnected(7), None),
)


class Administration(unittest.TestCase):
    def test_requests_and_answers(self) -> None:
        def script(fake: Fake) -> None:
            for channel, (_, request, answer, _) in enumerate(CALLS, 1):
                self.assertEqual(fake.next(), (channel, request))
                fake.send(channel, answer)
            fake.serve_goodbye()

        with daemon(script) as made:
            for call, _, _, result in CALLS:
                self.assertEqual(call(made), result)

    def test_what_the_daemon_refuses(self) -> None:
        def script(fake: Fake) -> None:
            for channel, (_, request, _, _) in enumerate(CALLS, 1):
                fake.receive(channel, type(request))
                fake.send(channel, m.Error(16 + channel, request.TYPE, "it cannot be done"))
            fake.receive(len(CALLS) + 1, m.ListStreams)
            fake.send(len(CALLS) + 1, m.Streams([]))
            fake.serve_goodbye()

        with daemon(script) as made:
            for channel, (call, request, _, _) in enumerate(CALLS, 1):
                with self.assertRaisesRegex(hopes.DaemonError, "it cannot be done") as caught:
                    call(made)
                self.assertEqual((caught.exception.code, caught.exception.answers), (16 + channel, request.TYPE))
            self.assertEqual(made.list_streams(), [], "the connection goes on")

    def test_an_answer_to_another_request(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.StopStream)
            fake.send(1, m.Disconnected(1))
            fake.serve_goodbye()

        with daemon(script) as made, self.assertRaisesRegex(hopes.ProtocolError, "Disconnected"):
            made.stop_stream("lidar")

    def test_a_daemon_that_is_too_old(self) -> None:
        for version in (1, 2):

            def script(fake: Fake) -> None:
                # Nothing unknown is sent.
                fake.receive(len(CALLS) + 1, m.GetStatus)
                fake.send(len(CALLS) + 1, m.Status("older", 1, 2, 3, 4, 5, 6, []))
                fake.receive(0, m.Goodbye)

            with self.subTest(version=version), daemon(script, version=version) as made:
                for call, _, _, _ in CALLS:
                    with self.assertRaisesRegex(hopes.DaemonTooOld, f"needs version 3 .* than {version}: update it"):
                        call(made)
                self.assertEqual(made.status().software, "older")

    def test_the_end_of_ones_own_connection(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.Disconnect)
            fake.send(1, m.Disconnected(7))
            fake.send(0, m.Goodbye("you were disconnected", []))

        with daemon(script) as made:
            made.disconnect(7)
            with self.assertRaisesRegex(hopes.DaemonClosed, "you were disconnected"):
                made.peers()


class TooManyViews(unittest.TestCase):
    """A subscription goes on without the stream that the daemon leaves out."""

    def test_one_of_several_streams(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.Subscribe)
            for message in (
                opened(8, "camera"),
                m.Error(15, m.Subscribe.TYPE, "too many views of camera"),
                m.StreamClosed(8, 0, "too many views"),
                opened(),
                snapshot(),
            ):
                fake.send(1, message)
            fake.serve_goodbye()

        with daemon(script) as made:
            subscription = made.follow("*")
            with self.assertRaisesRegex(hopes.DaemonError, "too many views of camera") as caught:
                next(subscription)
            self.assertEqual(caught.exception.code, 15)
            frame = next(subscription)
            self.assertEqual((frame.stream, frame.number), ("lidar", 1))

    def test_the_only_stream(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.Subscribe)
            fake.send(1, opened())
            fake.send(1, m.Error(15, m.Subscribe.TYPE, "too many views"))
            fake.send(1, m.StreamClosed(9, 0, "too many views"))
            fake.receive(1, m.Unsubscribe)
            fake.send(1, m.Unsubscribed())
            fake.serve_goodbye()

        with daemon(script) as made:
            subscription = made.follow("lidar")
            with self.assertRaises(hopes.DaemonError):
                next(subscription)
            self.assertEqual(list(subscription), [])

    def test_a_view_that_is_refused(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.Subscribe)
            fake.send(1, opened())
            fake.send(1, snapshot())
            fake.receive(1, m.ChangeView)
            fake.send(1, m.Error(15, m.ChangeView.TYPE, "too many views"))
            fake.send(1, snapshot(2, cause="Lagged"))
            fake.serve_goodbye()

        with daemon(script) as made:
            subscription = made.follow("lidar")
            before = next(subscription).view
            subscription.change_view(k=1, l=1)
            with self.assertRaises(hopes.DaemonError):
                next(subscription)
            frame = next(subscription)
            self.assertEqual((frame.number, frame.view), (2, before))
