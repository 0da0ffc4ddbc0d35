"""Tracks: the track mirror, and frames with tracks, with a scripted daemon."""

from __future__ import annotations

import dataclasses
import io
import random
import time
import unittest
from typing import Any
from unittest import mock

import hopes_client as hopes
from hopes_client import messages as m
from hopes_client.connection import Connection
from hopes_client.errors import ResyncNeeded
from hopes_client.track_mirror import TrackMirror
from hopes_client.tracks import Happening, Track, TrackChanges, TrackCycle, TrackEvent, TracksWanted
from hopes_client.wire import Banner, pack_frame

from .fake import TIMEOUT, Fake, Script, Stage, daemon
from .samples import diff, dots, event, header, opened, snapshot, track, tracks

EVENTS, ALIVE, CYCLES = (TracksWanted.of(word) for word in ("events", "alive", "cycles"))
START = tracks(0, 1, alive=[track(1), track(2)], cycles={1: [[0, 1, 2]]})


def held(mirror: TrackMirror) -> tuple[Any, ...]:
    """The content of a mirror."""
    return mirror.number, mirror.time, dict(mirror.alive), dict(mirror.cycles)


class Contract(unittest.TestCase):
    def setUp(self) -> None:
        self.mirror = TrackMirror()
        self.mirror.apply(START)

    def refuse(self, message: m.Tracks, why: str) -> None:
        """Checks that the message is refused and changes nothing."""
        before = held(self.mirror)
        with self.assertRaisesRegex(ResyncNeeded, why):
            self.mirror.apply(message)
        self.assertEqual(held(self.mirror), before)

    def test_a_start_replaces_everything(self) -> None:
        self.assertEqual(held(self.mirror), (1, 0.5, {1: track(1), 2: track(2)}, {1: [[0, 1, 2]]}))
        self.mirror.apply(tracks(0, 1, alive=[track(7)]))
        self.assertEqual(held(self.mirror), (1, 0.5, {7: track(7)}, {}))

    def test_events(self) -> None:
        before = self.mirror.alive
        happened = (
            event(2, 2, "Unselected", selected=False),
            event(2, 3, "Split", 1),
            event(3, 1, "Merged", 3),
            event(3, 2, "Updated", TrackChanges(True, False, False), selected=False),
            event(4, 3, "Died"),
            event(4, 4, "Born"),
        )
        self.mirror.apply(tracks(1, 5, happened, cycles={2: [[4, 5, 6]]}))
        alive = {2: track(2, selected=False), 4: track(4)}
        self.assertEqual(held(self.mirror), (5, 2.5, alive, {2: [[4, 5, 6]]}))
        self.assertEqual(before.keys(), {1, 2}, "what was given out before is not changed")

    def test_a_list_of_living_tracks(self) -> None:
        older = [track(1, age=2), track(2, age=2)]
        self.mirror.apply(tracks(1, 2, alive=older))
        self.assertEqual(self.mirror.alive, {1: older[0], 2: older[1]})
        self.assertEqual(self.mirror.cycles, {1: [[0, 1, 2]]})

    def test_wrong_start(self) -> None:
        for from_, frame in ((2, 3), (1, 1), (1, 0), (0, 0)):
            self.refuse(tracks(from_, frame, alive=[]), "do not follow frame 1")
        self.refuse(tracks(0, 2), "not a list of living tracks")
        self.refuse(tracks(0, 2, (event(2, 1, "Died"),), alive=[]), "not a list of living tracks")
        with self.assertRaises(ResyncNeeded):
            TrackMirror().apply(tracks(1, 2))

    def test_invalid_events(self) -> None:
        changes = TrackChanges(True, False, False)
        for happened, why in (
            (event(2, 1, "Born"), "frame 2 track 1 begins, but is alive"),
            (event(2, 1, "Split", 2), "begins, but is alive"),
            (event(2, 9, "Updated", changes), "track 9 is told of, but is not alive"),
            (event(2, 9, "Unselected"), "is told of"),
            (event(2, 9, "Reselected"), "is told of"),
            (event(2, 9, "Died"), "is told of"),
            (event(2, 9, "Merged", 1), "is told of"),
            (event(2, 1, "Merged", 9), "track 9 is named"),
            (event(2, 1, "Merged", 1), "track 1 is named"),
            (event(2, 9, "Split", 8), "track 8 is named"),
            (event(2, 9, "Split", 9), "track 9 is named"),
        ):
            with self.subTest(happened=happened):
                self.refuse(tracks(1, 2, (happened,)), why)

    def test_lists_that_contradict_events(self) -> None:
        for alive in (
            [track(1)],
            [track(1), track(2), track(3)],
            [track(1), track(3)],
            [track(1), track(2, selected=False)],
        ):
            with self.subTest(alive=alive):
                self.refuse(tracks(1, 2, alive=alive), "not those that events lead to")
        self.refuse(tracks(1, 2, cycles={3: []}), "cycles of tracks that are not alive")
        self.refuse(tracks(1, 2, (event(2, 1, "Died"),), cycles={1: []}), "cycles of tracks that are not alive")

    def test_order(self) -> None:
        why = "out of order"
        for happened in (
            (event(3, 1, "Reselected"), event(2, 2, "Reselected")),
            (event(2, 2, "Reselected"), event(2, 1, "Reselected")),
            (event(1, 1, "Reselected"),),
            (event(4, 1, "Reselected"),),
        ):
            self.refuse(tracks(1, 3, happened), why)
        for ids in ((2, 1), (1, 1)):
            self.refuse(tracks(1, 3, alive=[track(id) for id in ids]), why)
            cycles = [TrackCycle(id, []) for id in ids]
            self.refuse(dataclasses.replace(tracks(1, 3), cycles=cycles), why)
        self.mirror.apply(tracks(1, 3, (event(2, 1, "Unselected", selected=False), event(2, 1, "Reselected"))))

    def test_events_alone_lead_to_the_list_of_living_tracks(self) -> None:
        for seed in range(200):
            source = random.Random(seed)
            by_events, by_lists = TrackMirror(), TrackMirror()
            alive: dict[int, Track] = {}
            by_events.apply(tracks(0, 1, alive=[]))
            by_lists.apply(tracks(0, 1, alive=[]))
            waiting: list[TrackEvent] = []
            next_id = 1
            for frame in range(2, 30):
                happened, next_id = random_events(source, frame, alive, next_id)
                by_lists.apply(tracks(frame - 1, frame, tuple(happened), alive=[alive[id] for id in sorted(alive)]))
                waiting += happened
                # A slow consumer, or one that skips frames without events, gets several frames in one message.
                if waiting and source.random() < 0.5:
                    by_events.apply(tracks(by_events.number, frame, tuple(waiting)))
                    waiting = []
                    self.assertEqual(by_events.alive, by_lists.alive)
                    self.assertEqual(by_lists.alive, alive)


def random_events(
    source: random.Random, frame: int, alive: dict[int, Track], next_id: int
) -> tuple[list[TrackEvent], int]:
    """The events of a frame in order. `alive` is updated."""
    events: list[TrackEvent] = []
    for id in sorted(alive):
        others = [other for other in sorted(alive) if other != id]
        choice = source.randrange(8)
        if choice == 0:
            # The other track must still be alive after this frame. That is certain for tracks that are done.
            into = [other for other in others if other < id]
            happening = Happening("Merged", (into[0],)) if into else Happening("Died")
            events.append(TrackEvent(frame, None, happening, alive.pop(id)))
        elif choice == 1:
            alive[id] = dataclasses.replace(alive[id], selected=not alive[id].selected)
            events.append(
                TrackEvent(frame, None, Happening("Reselected" if alive[id].selected else "Unselected"), alive[id])
            )
        elif choice == 2:
            alive[id] = dataclasses.replace(alive[id], age=frame)
            events.append(TrackEvent(frame, None, Happening("Updated", (TrackChanges(True, False, True),)), alive[id]))
    for _ in range(source.randrange(3)):
        parents = sorted(alive)
        happening = Happening("Split", (parents[0],)) if parents and source.random() < 0.5 else Happening("Born")
        alive[next_id] = track(next_id)
        events.append(TrackEvent(frame, None, happening, alive[next_id]))
        next_id += 1
    return events, next_id


class Words(unittest.TestCase):
    def test_kinds_of_events(self) -> None:
        for case, values, begins, ends, other in (
            ("Born", (), True, False, None),
            ("Split", (3,), True, False, 3),
            ("Updated", (TrackChanges(True, False, True),), False, False, None),
            ("Merged", (4,), False, True, 4),
            ("Died", (), False, True, None),
        ):
            happening = Happening(case, values)
            self.assertEqual((happening.begins, happening.ends, happening.other), (begins, ends, other))
        self.assertEqual(str(Happening("Updated", (TrackChanges(True, False, True),))), "Updated(center, death)")

    def test_words_for_tracks(self) -> None:
        self.assertEqual([TracksWanted.of(word).case for word in (None, "events")], ["No", "Events"])
        for word in ("all", "", "Events"):
            with self.assertRaises(ValueError):
                TracksWanted.of(word)


def telling(wanted: TracksWanted, *messages: m.Message) -> Script:
    """Waits for a subscription that asks for this much, sends these messages, and serves an unsubscription."""

    def play(fake: Fake) -> None:
        fake.receive(1, m.Subscribe)
        assert fake.receive(1, m.WantTracks).tracks == wanted
        send(fake, *messages)
        serve_unsubscribe(fake)

    return play


def send(fake: Fake, *messages: m.Message) -> None:
    for message in messages:
        fake.send(1, message)


def serve_unsubscribe(fake: Fake) -> None:
    channel, message = fake.next()
    if isinstance(message, m.Unsubscribe):
        fake.send(channel, m.Unsubscribed())
        fake.serve_goodbye()


class Following(unittest.TestCase):
    def follow(self, wanted: str, *messages: m.Message, count: int, **options: Any) -> list[hopes.Frame]:
        with daemon(telling(TracksWanted.of(wanted), *messages)) as made:
            subscription = made.follow("lidar", tracks=wanted, **options)
            return [next(subscription) for _ in range(count)]

    def test_tracks_are_not_requested_by_default(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.Subscribe)
            send(fake, opened(), snapshot())
            serve_unsubscribe(fake)

        with daemon(script) as made:
            frame = next(made.follow("lidar"))
            self.assertEqual((frame.tracks, frame.track_events, frame.track_cycles), ({}, (), {}))

    def test_they_belong_to_the_frame_before(self) -> None:
        born = event(2, 3, "Born")
        onwards = tracks(1, 2, (born,), alive=[track(1), track(2), track(3)], cycles={3: [[7, 8, 9]]})
        frames = self.follow("cycles", opened(), snapshot(), START, diff(), onwards, count=2)
        self.assertEqual(
            [(frame.kind, sorted(frame.tracks)) for frame in frames], [("snapshot", [1, 2]), ("diff", [1, 2, 3])]
        )
        self.assertEqual([frame.track_events for frame in frames], [(), (born,)])
        self.assertEqual([sorted(frame.track_cycles) for frame in frames], [[1], [1, 3]])
        self.assertEqual(frames[0].tracks[1].persistence, track(1).death - 1.0)

    def test_dots_and_tracks_of_one_frame_come_in_any_order(self) -> None:
        for rest in ((dots(1), START), (START, dots(1))):
            with self.subTest(rest=rest):
                options = {"dots": hopes.Dots.top(1), "dots_wait": 5.0}
                frames = self.follow(
                    "alive",
                    opened(),
                    snapshot(),
                    *rest,
                    diff(),
                    tracks(1, 2, alive=[track(1), track(2)]),
                    dots(2),
                    count=2,
                    **options,
                )
                shown = [(frame.kind, len(frame.dots), len(frame.tracks)) for frame in frames]
                self.assertEqual(shown, [("snapshot", 1, 2), ("diff", 1, 2)])

    def test_frames_without_events_are_not_held_back_for_long(self) -> None:
        started = time.monotonic()
        frames = self.follow("events", opened(), snapshot(), START, diff(), count=2)
        self.assertEqual([frame.track_events for frame in frames], [(), ()])
        self.assertEqual([sorted(frame.tracks) for frame in frames], [[1, 2], [1, 2]], "they live on")
        self.assertLess(time.monotonic() - started, 2.0)

    def test_late_ones_make_a_frame(self) -> None:
        died = event(2, 1, "Died")
        messages = (opened(), snapshot(), m.Heartbeat(9, 1), START, diff(), m.Heartbeat(9, 2), tracks(1, 2, (died,)))
        frames = self.follow("events", *messages, count=4)
        self.assertEqual([frame.kind for frame in frames], ["snapshot", "tracks", "diff", "tracks"])
        self.assertEqual([frame.number for frame in frames], [1, 1, 2, 2])
        self.assertEqual([frame.track_events for frame in frames], [(), (), (), (died,)])
        self.assertEqual([sorted(frame.tracks) for frame in frames], [[], [1, 2], [1, 2], [2]])

    def test_tracks_that_do_not_fit_are_an_error_after_their_frame(self) -> None:
        wrong = tracks(5, 6)
        with daemon(telling(ALIVE, opened(), snapshot(), START, diff(), dataclasses.replace(wrong, frame=2))) as made:
            subscription = made.follow("lidar", tracks="alive")
            self.assertEqual([next(subscription).number, next(subscription).number], [1, 2])
            with self.assertRaises(ResyncNeeded):
                next(subscription)

    def test_tracks_of_a_missing_frame(self) -> None:
        for messages in ((opened(), START), (opened(), snapshot(), tracks(0, 2, alive=[]))):
            with self.subTest(messages=messages), daemon(telling(ALIVE, *messages)) as made:
                subscription = made.follow("lidar", tracks="alive")
                with self.assertRaisesRegex(ResyncNeeded, "come before that frame"):
                    for _ in range(2):
                        next(subscription)

    def test_a_daemon_that_follows_no_tracks(self) -> None:
        refusal = m.Error(9, m.WantTracks.TYPE, "no tracks are followed here: start the daemon with --track")
        with daemon(telling(EVENTS, refusal, opened(), snapshot(), diff())) as made:
            subscription = made.follow("lidar", tracks="events", dots_wait=5.0)
            with self.assertRaisesRegex(hopes.DaemonError, "--track") as caught:
                next(subscription)
            self.assertEqual((caught.exception.code, caught.exception.answers), (9, m.WantTracks.TYPE))
            started = time.monotonic()
            self.assertEqual([next(subscription).number, next(subscription).number], [1, 2], "the rest goes on")
            self.assertLess(time.monotonic() - started, 2.0, "tracks are not waited for any more")

    def test_a_daemon_that_is_too_old(self) -> None:
        def script(fake: Fake) -> None:
            # No unknown message is sent, and no subscription is left behind.
            fake.receive(1, m.Subscribe)
            send(fake, opened(), snapshot())
            fake.serve_goodbye()

        with daemon(script, version=1) as made:
            with self.assertRaisesRegex(hopes.DaemonTooOld, "needs version 2"):
                made.follow("lidar", tracks="alive")
            subscription = made.follow("lidar")
            self.assertEqual(next(subscription).number, 1)
            with self.assertRaises(hopes.DaemonTooOld):
                subscription.want_tracks("alive")

    def test_unknown_words(self) -> None:
        with daemon(lambda fake: fake.serve_goodbye()) as made, self.assertRaises(ValueError):
            made.follow("lidar", tracks="all")

    def test_another_request(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.Subscribe)
            fake.receive(1, m.WantTracks)
            send(fake, opened(), snapshot(), START)
            self.assertEqual(fake.receive(1, m.WantTracks).tracks, EVENTS)
            # The first of these was in flight when the request was sent.
            send(fake, diff(), tracks(1, 2, alive=[track(1), track(2)]), tracks(0, 2, alive=[track(2)]))
            self.assertEqual(fake.receive(1, m.WantTracks).tracks, TracksWanted.of(None))
            send(fake, tracks(0, 2, alive=[track(2)]), still(3))
            serve_unsubscribe(fake)

        with daemon(script) as made:
            subscription = made.follow("lidar", tracks="alive")
            self.assertEqual(sorted(next(subscription).tracks), [1, 2])
            subscription.want_tracks("events")
            frames = [next(subscription), next(subscription)]
            self.assertEqual([(frame.kind, sorted(frame.tracks)) for frame in frames], [("diff", []), ("tracks", [2])])
            subscription.want_tracks(None)
            frame = next(subscription)
            self.assertEqual((frame.kind, frame.number, frame.tracks), ("diff", 3, {}))


def still(number: int) -> m.Diff:
    """A diff without changes from the frame of `diff`, or a later one."""
    nothing: dict[str, Any] = {"vertices_added": [], "vertices_removed": [], "edges_added": [], "edges_removed": []}
    return dataclasses.replace(diff(), from_=number - 1, frame=header(number), critical_set=[], **nothing)


@mock.patch("hopes_client.consumer._SHORTEST_PAUSE", 0.01)
class Reconnecting(unittest.TestCase):
    def test_tracks_start_again(self) -> None:
        def vanishes(fake: Fake) -> None:
            fake.receive(1, m.Subscribe)
            fake.receive(1, m.WantTracks)
            send(fake, opened(), snapshot(), START)

        def resumes(fake: Fake) -> None:
            self.assertEqual(fake.receive(1, m.Subscribe).resume, m.Resume(77, 1))
            self.assertEqual(fake.receive(1, m.WantTracks).tracks, EVENTS)
            send(fake, opened(stream=3), m.Resumed(3, 1), diff(stream=3), tracks(0, 2, alive=[track(2)], stream=3))
            serve_unsubscribe(fake)

        with daemon(vanishes, resumes) as made:
            subscription = made.follow("lidar", tracks="events", reconnect=True)
            shown = [(frame.kind, sorted(frame.tracks)) for frame in (next(subscription), next(subscription))]
            self.assertEqual(shown, [("snapshot", [1, 2]), ("diff", [2])])

    def test_tracks_that_do_not_fit_cause_a_new_subscription(self) -> None:
        def script(fake: Fake) -> None:
            fake.receive(1, m.Subscribe)
            fake.receive(1, m.WantTracks)
            send(fake, opened(), snapshot(), START, diff(), tracks(1, 2, (event(2, 9, "Died"),)))
            fake.receive(1, m.Unsubscribe)
            fake.receive(2, m.Subscribe)
            fake.receive(2, m.WantTracks)
            for message in (opened(stream=4), snapshot(2, stream=4), tracks(0, 2, alive=[track(2)], stream=4)):
                fake.send(2, message)
            serve_unsubscribe(fake)

        with daemon(script) as made:
            subscription = made.follow("lidar", tracks="events", reconnect=True)
            shown = [(frame.number, sorted(frame.tracks)) for frame in (next(subscription) for _ in range(3))]
            self.assertEqual(shown, [(1, [1, 2]), (2, [1, 2]), (2, [2])])

    def test_an_older_daemon_is_not_retried_for_ever(self) -> None:
        def vanishes(fake: Fake) -> None:
            fake.shake_hands()
            fake.receive(1, m.Subscribe)
            fake.receive(1, m.WantTracks)
            send(fake, opened(), snapshot(), START)

        def older(fake: Fake) -> None:
            fake.version = 1
            fake.shake_hands()
            fake.serve_goodbye()

        stage = Stage(vanishes, older)
        made = hopes.Daemon(lambda: Connection(stage.dial(), hopes.Options(timeout=TIMEOUT)))
        subscription = made.follow("lidar", tracks="events", reconnect=True)
        next(subscription)
        with self.assertRaises(hopes.DaemonTooOld):
            next(subscription)
        self.assertEqual(list(subscription), [])
        made.close()
        stage.join()


class Recorded(unittest.TestCase):
    def read(self, *messages: m.Message) -> hopes.Recording:
        frames = [pack_frame(message.TYPE, 5, m.encode(message), 2) for message in messages]
        return hopes.Recording(io.BytesIO(Banner(2, 2).encode() + b"".join(frames)))

    def test_frames_carry_tracks(self) -> None:
        died = event(2, 1, "Died")
        recording = self.read(opened(), snapshot(), START, dots(1), diff(), tracks(1, 2, (died,)))
        frames = [(frame.kind, len(frame.dots), sorted(frame.tracks), frame.track_events) for frame in recording]
        self.assertEqual(frames, [("snapshot", 1, [1, 2], ()), ("diff", 1, [2], (died,))])

    def test_frames_before_tracks_that_do_not_fit_are_good(self) -> None:
        recording = self.read(opened(), snapshot(), START, diff(), tracks(1, 2, (event(2, 9, "Died"),)))
        self.assertEqual([next(recording).number, next(recording).number], [1, 2])
        for _ in range(2):
            with self.assertRaises(ResyncNeeded):
                next(recording)
