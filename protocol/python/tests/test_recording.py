"""Reading recordings: whole files, files that are cut off, and files that are not recordings."""

from __future__ import annotations

import io
import tempfile
import unittest
from pathlib import Path

import hopes_client as hopes
from hopes_client import messages as m
from hopes_client.wire import Banner, pack_frame

from .samples import diff, dots, header, opened, snapshot


def recorded(*messages: m.Message, channel: int = 5, version: int = 1) -> bytes:
    """The bytes of a recording."""
    frames = [
        pack_frame(message.TYPE, 0 if isinstance(message, m.Elapsed) else channel, m.encode(message), version)
        for message in messages
    ]
    return Banner(version, version).encode() + b"".join(frames)


WHOLE = (
    m.Elapsed(0),
    opened(),
    m.Elapsed(500_000_000),
    snapshot(),
    m.Elapsed(600_000_000),
    dots(1),
    m.Heartbeat(9, 1),
    m.Elapsed(1_500_000_000),
    diff(),
)


def read(data: bytes) -> hopes.Recording:
    return hopes.Recording(io.BytesIO(data))


class Reading(unittest.TestCase):
    def test_a_file(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "recording"
            path.write_bytes(recorded(*WHOLE))
            with hopes.read_recording(path) as recording:
                frames = [
                    (frame.stream, frame.number, frame.elapsed, len(frame.dots), len(frame.edges))
                    for frame in recording
                ]
        self.assertEqual(frames, [("lidar", 1, 0.5, 1, 3), ("lidar", 2, 1.5, 1, 3)])
        self.assertFalse(recording.truncated)
        self.assertEqual(list(recording), [])

    def test_without_elapsed(self) -> None:
        frames = [(frame.kind, frame.elapsed) for frame in read(recorded(opened(), snapshot(), diff()))]
        self.assertEqual(frames, [("snapshot", None), ("diff", None)])

    def test_from_nothing(self) -> None:
        start = snapshot()
        first = m.Diff(9, 0, header(1), start.vertices, [], start.edges, [], start.critical, [], start.checksum)
        frames = [frame.copy() for frame in read(recorded(opened(), first, diff()))]
        self.assertEqual([len(frame.vertices) for frame in frames], [4, 4])

    def test_a_stream_that_is_not_announced(self) -> None:
        frames = [(frame.stream, frame.number) for frame in read(recorded(snapshot(), diff()))]
        self.assertEqual(frames, [("", 1), ("", 2)])

    def test_cut_off_anywhere(self) -> None:
        ends = [len(recorded(*WHOLE[:count])) for count in range(len(WHOLE) + 1)]
        whole = recorded(*WHOLE)
        for length in range(20, len(whole), 7):
            recording = read(whole[:length])
            frames = [frame.number for frame in recording]
            self.assertEqual(recording.truncated, length not in ends)
            self.assertEqual(len(frames), (length >= ends[4]) + (length >= ends[9]))

    def test_an_end(self) -> None:
        end = (m.Elapsed(2_000_000_000), m.Goodbye("SIGTERM", [("lidar", 2)]))
        recording = read(recorded(*WHOLE, *end))
        self.assertEqual([frame.number for frame in recording], [1, 2])
        self.assertEqual((recording.end, recording.truncated), ("SIGTERM", False))
        recording = read(recorded(*WHOLE))
        self.assertEqual([frame.number for frame in recording], [1, 2])
        self.assertIsNone(recording.end)
        with self.assertRaises(hopes.ProtocolError):
            list(read(recorded(*WHOLE, *end, diff())))

    def test_frames_before_a_broken_one_are_good(self) -> None:
        data = bytearray(recorded(opened(), snapshot(), diff()))
        data[-1] ^= 1
        recording = read(bytes(data))
        self.assertEqual(next(recording).number, 1)
        for _ in range(2):
            with self.assertRaises(hopes.Malformed):
                next(recording)


class NoRecordings(unittest.TestCase):
    def test_files_that_are_not_recordings(self) -> None:
        for data, error in (
            (b"", hopes.Malformed),
            (b"HOPES", hopes.Malformed),
            (b"x" * 100, hopes.Malformed),
            (Banner(1, 2).encode(), hopes.Malformed),
            (Banner(5, 5).encode(), hopes.VersionMismatch),
        ):
            with self.subTest(data=data), self.assertRaises(error):
                read(data)

    def test_a_missing_path(self) -> None:
        with tempfile.TemporaryDirectory() as folder, self.assertRaises(FileNotFoundError):
            hopes.read_recording(Path(folder) / "none")

    def test_messages_that_do_not_fit(self) -> None:
        for messages in ((diff(),), (opened(), diff()), (opened(), m.Resumed(9, 1))):
            with self.subTest(messages=messages), self.assertRaises(hopes.ResyncNeeded):
                list(read(recorded(*messages)))
