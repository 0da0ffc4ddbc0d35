"""Bytes: CRC, banner, frames and bodies, and their errors."""

from __future__ import annotations

import dataclasses
import math
import struct
import unittest

from hopes_client import messages as m
from hopes_client import spaces as s
from hopes_client.codec import F64, U16, U32, U64, Packed, codec_of
from hopes_client.crc import crc32c, pure_crc32c
from hopes_client.errors import (
    BodyError,
    Incomplete,
    Malformed,
    TooLarge,
    UnsupportedVersion,
    VersionMismatch,
)
from hopes_client.shared import Cut, DotsWanted, Simplify, View, Window
from hopes_client.wire import HEADER_SIZE, HIGHEST_VERSION, Banner, FrameBuffer, pack_frame, parse_frame

from .samples import MESSAGES


def slow_crc32c(data: bytes) -> int:
    """CRC-32C, bit by bit."""
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc >> 1) ^ (0x82F63B78 if crc & 1 else 0)
    return crc ^ 0xFFFFFFFF


class Crc(unittest.TestCase):
    def test_check_value(self) -> None:
        self.assertEqual(crc32c(b"123456789"), 0xE3069283)
        self.assertEqual(pure_crc32c(b"123456789"), 0xE3069283)

    def test_nothing(self) -> None:
        self.assertEqual(crc32c(b""), 0)

    def test_every_way_and_length_gives_the_same(self) -> None:
        data = bytes((7 * i * i + 3) % 256 for i in range(5000))
        for length in [*range(40), *range(250, 270), *range(505, 530), 1023, 1024, 1025, 4099, 5000]:
            expected = slow_crc32c(data[:length])
            self.assertEqual(pure_crc32c(data[:length]), expected, length)
            self.assertEqual(pure_crc32c(memoryview(data)[:length]), expected, length)
            self.assertEqual(crc32c(data[:length]), expected, length)


class TheBanner(unittest.TestCase):
    def test_bytes(self) -> None:
        head = bytes.fromhex("484f5045530d0a1a 0100 0100 00000000")
        self.assertEqual(Banner(1, 1).encode(), head + struct.pack("<I", slow_crc32c(head)))

    def test_round_trip(self) -> None:
        self.assertEqual(Banner.decode(Banner(2, 70).encode()), Banner(2, 70))

    def test_reserved_bytes_are_ignored(self) -> None:
        head = bytes.fromhex("484f5045530d0a1a 0100 0300 deadbeef")
        self.assertEqual(Banner.decode(head + struct.pack("<I", crc32c(head))), Banner(1, 3))

    def test_errors_are_distinguished(self) -> None:
        good = Banner().encode()
        for length in range(len(good)):
            with self.assertRaises(Incomplete) as caught:
                Banner.decode(good[:length])
            self.assertEqual(caught.exception.needed, len(good) - length)
        for at in range(len(good)):
            broken = bytearray(good)
            broken[at] ^= 1
            with self.assertRaises(Malformed):
                Banner.decode(broken)

    def test_agreement(self) -> None:
        self.assertEqual(Banner(1, 4).agree(Banner(2, 3)), 3)
        self.assertEqual(Banner(1, 1).agree(Banner(1, 9)), 1)
        for other in (Banner(2, 3), Banner(0, 0), Banner(5, 1)):
            with self.assertRaises(VersionMismatch):
                Banner(1, 1).agree(other)


class OuterFrame(unittest.TestCase):
    good = pack_frame(0x0105, 7, b"body")

    def broken(self, at: int, value: bytes, mend_header: bool = True) -> bytes:
        frame = bytearray(self.good)
        frame[at : at + len(value)] = value
        if mend_header:
            frame[16:20] = struct.pack("<I", crc32c(bytes(frame[:16])))
        return bytes(frame)

    def test_bytes(self) -> None:
        head = bytes.fromhex("686f7046 0400 0501 07000000 04000000")
        expected = head + struct.pack("<I", slow_crc32c(head)) + b"body" + struct.pack("<I", slow_crc32c(b"body"))
        self.assertEqual(self.good, expected)

    def test_round_trip(self) -> None:
        frame, size = parse_frame(self.good + b"more")
        self.assertEqual((frame.version, frame.type, frame.channel, frame.body), (4, 0x0105, 7, b"body"))
        self.assertEqual(size, len(self.good))

    def test_incomplete(self) -> None:
        for length in range(len(self.good)):
            with self.assertRaises(Incomplete) as caught:
                parse_frame(self.good[:length])
            expected = HEADER_SIZE if length < HEADER_SIZE else len(self.good)
            self.assertEqual(caught.exception.needed, expected - length)

    def test_malformed(self) -> None:
        for at in range(len(self.good)):
            with self.assertRaises(Malformed, msg=at):
                parse_frame(self.broken(at, bytes([self.good[at] ^ 0x40]), mend_header=False))
        with self.assertRaises(Malformed):
            parse_frame(self.broken(0, b"HOPF"))

    def test_unsupported_version(self) -> None:
        with self.assertRaises(UnsupportedVersion):
            parse_frame(self.broken(4, b"\x01\x00"))

    def test_the_crc_of_the_header_is_checked_first(self) -> None:
        with self.assertRaises(Malformed):
            parse_frame(self.broken(4, b"\x01\x00", mend_header=False))

    def test_too_large_is_found_before_the_body_arrives(self) -> None:
        header = self.broken(12, b"\xff\xff\xff\xff")[:HEADER_SIZE]
        with self.assertRaises(TooLarge):
            parse_frame(header, largest=1000)
        with self.assertRaises(TooLarge):
            parse_frame(self.good, largest=3)
        self.assertEqual(parse_frame(self.good, largest=4)[0].body, b"body")

    def test_bytes_come_one_by_one(self) -> None:
        buffer = FrameBuffer()
        bodies = []
        for byte in self.good + pack_frame(3, 0, b""):
            buffer.feed(bytes([byte]))
            frame = buffer.next_frame(HIGHEST_VERSION)
            bodies += [frame.body] if frame else []
        self.assertEqual(bodies, [b"body", b""])
        self.assertEqual(len(buffer), 0)

    def test_an_announced_body_takes_no_memory(self) -> None:
        buffer = FrameBuffer()
        buffer.feed(self.broken(12, struct.pack("<I", 1 << 30))[:HEADER_SIZE])
        self.assertIsNone(buffer.next_frame(HIGHEST_VERSION))
        self.assertEqual(len(buffer), HEADER_SIZE)


class Numbers(unittest.TestCase):
    def encode(self, hint: object, value: object) -> bytes:
        out = bytearray()
        codec_of(hint).write(value, out)
        return bytes(out)

    def test_forms(self) -> None:
        for value, expected in (
            (0, "00"),
            (250, "fa"),
            (251, "fbfb00"),
            (65_535, "fbffff"),
            (65_536, "fc00000100"),
            (2**32 - 1, "fcffffffff"),
            (2**32, "fd0000000001000000"),
            (2**64 - 1, "fdffffffffffffffff"),
        ):
            raw = bytes.fromhex(expected)
            self.assertEqual(self.encode(U64, value), raw)
            self.assertEqual(codec_of(U64).read(raw, 0), (value, len(raw)))

    def test_range_when_written(self) -> None:
        for hint, value in ((U16, 2**16), (U32, 2**32), (U64, 2**64), (U64, -1)):
            with self.assertRaises(ValueError):
                self.encode(hint, value)

    def test_range_when_read(self) -> None:
        for hint, raw in ((U16, "fc00000100"), (U32, "fd0000000001000000")):
            with self.assertRaises(BodyError):
                codec_of(hint).read(bytes.fromhex(raw), 0)

    def test_longer_forms_of_numbers_are_refused(self) -> None:
        for raw in ("fb0100", "fbfa00", "fcffff0000", "fdffffffff00000000"):
            with self.assertRaises(BodyError):
                codec_of(U64).read(bytes.fromhex(raw), 0)

    def test_invalid_marks_of_numbers(self) -> None:
        for raw in ("fe" + "00" * 16, "ff" + "00" * 16):
            with self.assertRaises(BodyError):
                codec_of(U64).read(bytes.fromhex(raw), 0)

    def test_floats_are_finite(self) -> None:
        for value in (math.inf, -math.inf, math.nan):
            with self.assertRaises(ValueError):
                self.encode(F64, value)
            with self.assertRaises(BodyError):
                codec_of(F64).read(struct.pack("<d", value), 0)
        self.assertEqual(self.encode(F64, -0.0), bytes.fromhex("0000000000000080"))


class Bodies(unittest.TestCase):
    def decode(self, kind: type[m.Message], raw: str) -> object:
        return m.decode(kind.TYPE, bytes.fromhex(raw))

    def test_every_type_is_among_the_samples(self) -> None:
        self.assertEqual({message.TYPE for message in MESSAGES}, set(m.BY_TYPE))
        self.assertEqual(len(m.BY_TYPE), 54)

    def test_round_trip(self) -> None:
        for message in MESSAGES:
            with self.subTest(message=message):
                self.assertEqual(m.decode(message.TYPE, bytes(m.encode(message))), message)

    def test_every_shorter_body_is_refused(self) -> None:
        for message in MESSAGES:
            body = bytes(m.encode(message))
            for length in range(len(body)):
                with self.subTest(message=message, length=length), self.assertRaises(BodyError):
                    m.decode(message.TYPE, body[:length])

    def test_every_longer_body_is_refused(self) -> None:
        for message in MESSAGES:
            with self.subTest(message=message), self.assertRaises(BodyError):
                m.decode(message.TYPE, bytes(m.encode(message)) + b"\0")

    def test_any_bytes_are_read_or_refused(self) -> None:
        for message in MESSAGES:
            body = bytes(m.encode(message))
            for at in range(len(body)):
                for value in (0, 1, 2, 127, 250, 251, 252, 253, 254, 255):
                    changed = body[:at] + bytes([value]) + body[at + 1 :]
                    try:
                        read = m.decode(message.TYPE, changed)
                    except BodyError:
                        continue
                    # There is no other encoding of the value.
                    self.assertEqual(bytes(m.encode(read)), changed)

    def test_known_bytes(self) -> None:
        batch = m.Batch(259, [(1.0, -2.0)], [], [251])
        raw = "fb0301 01 000000000000f03f 00000000000000c0 00 01 fbfb00"
        self.assertEqual(bytes(m.encode(batch)), bytes.fromhex(raw))
        self.assertEqual(self.decode(m.Batch, raw), batch)
        subscribe = m.Subscribe("a*", View(Cut.derived(2, 1), Simplify.no()), DotsWanted.top(300), m.Resume(5, 6))
        self.assertEqual(bytes(m.encode(subscribe)), bytes.fromhex("02612a 02 02 01 00 01fb2c01 01 05 06"))

    def test_unknown_type(self) -> None:
        with self.assertRaises(BodyError):
            m.decode(0x7777, b"")

    def test_a_version_does_not_have_messages_of_later_versions(self) -> None:
        of_version_3 = {
            *(m.ListPeers, m.Peers, m.StopStream, m.StreamStopped),
            *(m.Disconnect, m.Disconnected, m.GetMemory, m.Memory),
        }
        of_version_4 = {
            *(s.ListSpaces, s.Spaces, s.OpenSpace, s.SpaceOpened, s.SpaceBatch, s.SpaceRetract),
            *(s.SpaceSnapshot, s.SpaceDiff, s.SpaceDots, s.SpaceTracks),
        }
        later = {2: {m.WantTracks, m.Tracks}, 3: of_version_3, 4: of_version_4}
        for message in MESSAGES:
            body = bytes(m.encode(message))
            since = next((version for version, kinds in later.items() if type(message) in kinds), 1)
            for version in (1, 2, 3, 4):
                if version < since:
                    with self.assertRaisesRegex(BodyError, f"not known in version {version}"):
                        m.decode(message.TYPE, body, version)
                else:
                    self.assertEqual(m.decode(message.TYPE, body, version), message)
        for version, kinds in later.items():
            self.assertEqual({kind for kind in m.BY_TYPE.values() if kind.SINCE == version}, kinds)

    def test_impossible_counts(self) -> None:
        huge = "fdffffffffffffffff"
        for kind, raw in (
            (m.ListStreams, huge),
            (m.Streams, huge),
            (m.Batch, "01" + huge),
            (m.Batch, "0100" + huge),
            (m.Batch, "010000" + huge),
            (m.Accepted, "0101" + huge),
            (m.Goodbye, "00" + huge),
            (m.Hello, "00" + huge),
            (s.Spaces, huge),
            (s.SpaceBatch, "0103" + huge),
            (s.SpaceBatch, "010300" + huge),
            (s.SpaceRetract, "0103" + huge),
        ):
            with self.subTest(kind=kind), self.assertRaisesRegex(BodyError, "do not fit"):
                self.decode(kind, raw)

    def test_invalid_values(self) -> None:
        for kind, raw in (
            (m.Close, "02"),
            (m.Commit, "0102"),
            (m.Commit, "0102" + "00" * 8),
            (m.ListStreams, "02c328"),
            (m.Commit, "0101" + "000000000000f07f"),
            (m.Overloaded, "01010102"),
        ):
            with self.subTest(kind=kind, raw=raw), self.assertRaises(BodyError):
                self.decode(kind, raw)

    def test_invalid_windows_cuts_and_views(self) -> None:
        for kind, raw in (
            (m.Open, "0161 01 01 00 00"),
            (m.Open, "0161 01 03 0000000000000000 00"),
            (m.Open, "0161 01 04 00"),
            (m.ChangeView, "02 00 01 00 00"),
            (m.ChangeView, "00 01 00"),
        ):
            with self.subTest(kind=kind, raw=raw), self.assertRaises(BodyError):
                self.decode(kind, raw)
        for make in (
            lambda: Window.points(0),
            lambda: Window.time(math.nan),
            lambda: Cut.derived(0, 1),
            lambda: View(Cut.full(), Simplify.at_scale()),
            lambda: Cut("Other"),
        ):
            with self.assertRaises(ValueError):
                make()

    def test_numbers_in_lists_are_finite_unless_allowed(self) -> None:
        nan = math.nan
        batch = m.decode(m.Batch.TYPE, bytes(m.encode(m.Batch(1, [(nan, 1.0)], [math.inf], []))))
        self.assertTrue(math.isnan(batch.points[0][0]))
        snapshot = next(message for message in MESSAGES if isinstance(message, m.Snapshot))
        good = bytes(m.encode(snapshot))
        at = good.index(struct.pack("<d", 2.0))
        with self.assertRaises(BodyError):
            m.decode(snapshot.TYPE, good[:at] + struct.pack("<d", nan) + good[at + 8 :])
        with self.assertRaises(ValueError):
            m.encode(dataclasses.replace(snapshot, vertices=[(1, nan, 0.0)]))

    def test_large_finite_numbers_whose_sum_is_not_finite(self) -> None:
        snapshot = next(message for message in MESSAGES if isinstance(message, m.Snapshot))
        large = dataclasses.replace(snapshot, vertices=[(1, 1e308, 1.0), (2, 1e308, 1.0)])
        self.assertEqual(m.decode(large.TYPE, bytes(m.encode(large))), large)

    def test_keys_of_every_size(self) -> None:
        sizes = [0, 250, 251, 65_535, 65_536, 2**32 - 1, 2**32, 2**64 - 1]
        placed = [(a, b) for a in sizes for b in sizes]
        message = m.Accepted(1, 64, placed)
        self.assertEqual(m.decode(message.TYPE, bytes(m.encode(message))), message)
        for raw in ("01 01 01 fb0100 00", "01 01 01 00 fb0100", "01 01 01 ff 00", "01 01 01 00 ff", "01 01 01 00 fb"):
            with self.assertRaises(BodyError):
                self.decode(m.Accepted, raw)

    def test_packed_points_are_written_like_a_list(self) -> None:
        points = [(1.0, 2.0), (3.0, 4.0), (5.0, 6.0)]
        packed = Packed(3, memoryview(struct.pack("<6d", 1, 2, 3, 4, 5, 6)))
        self.assertEqual(m.encode(m.Retract(1, packed)), m.encode(m.Retract(1, points)))
        self.assertEqual(m.encode(m.Retract(1, packed.part(1, 9))), m.encode(m.Retract(1, points[1:])))

    def test_values_of_another_type_are_refused_when_written(self) -> None:
        for message in (
            m.Ping("one"),  # type: ignore[arg-type]
            m.Open("a", "All", None),  # type: ignore[arg-type]
            m.Goodbye("a", [("a",)]),  # type: ignore[list-item]
            m.Commit(1, "now"),  # type: ignore[arg-type]
        ):
            with self.assertRaises(ValueError):
                m.encode(message)
