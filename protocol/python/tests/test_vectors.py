"""The vectors of protocol version 1: every message as bytes and as JSON, and bytes that are wrong.

In: the files of `protocol/vectors/v1`. A folder without vectors is a failure.
"""

from __future__ import annotations

import json
import unittest
from pathlib import Path

from hopes_client import messages as m
from hopes_client.codec import codec_of
from hopes_client.errors import BodyError, Incomplete, Malformed, ProtocolError, TooLarge, UnsupportedVersion
from hopes_client.mirror import Mirror
from hopes_client.wire import Banner, pack_frame, parse_frame

from .vector_json import from_json, read_hex, to_json

VECTORS = Path(__file__).resolve().parents[2] / "vectors" / "v1"
ERRORS = {
    "incomplete": Incomplete,
    "malformed": Malformed,
    "unsupported version": UnsupportedVersion,
    "too large": TooLarge,
    "body": BodyError,
}


def vectors(folder: Path) -> list[tuple[str, bytes, dict[str, object]]]:
    """Name, bytes and JSON of each vector in a folder."""
    return [
        (path.stem, read_hex(path), json.loads(path.with_suffix(".json").read_text()))
        for path in sorted(folder.glob("*.hex"))
    ]


class Vectors(unittest.TestCase):
    def test_there_are_vectors_of_every_message(self) -> None:
        types = {expected["type"] for _, _, expected in vectors(VECTORS)}
        self.assertEqual(types, {"Banner", *(kind.__name__ for kind in m.BY_TYPE.values())})

    def test_every_vector_both_ways(self) -> None:
        for name, raw, expected in vectors(VECTORS):
            with self.subTest(vector=name):
                if expected["type"] == "Banner":
                    self.check_banner(raw, expected)
                else:
                    self.check_message(raw, expected)

    def test_every_wrong_vector(self) -> None:
        for name, raw, expected in vectors(VECTORS / "bad"):
            with self.subTest(vector=name, why=expected["why"]):
                error: type[ProtocolError] = ERRORS[str(expected["error"])]
                with self.assertRaises(error):
                    frame, _ = parse_frame(raw)
                    m.decode(frame.type, frame.body)

    def test_the_checksums_of_snapshots_and_of_diffs_that_follow(self) -> None:
        messages = {name: raw for name, raw, _ in vectors(VECTORS)}
        snapshots = [(name,) for name in messages if name.startswith("snapshot")]
        for chain in (*snapshots, ("snapshot", "diff", "diff_onwards"), ("diff_from_nothing", "diff_merged")):
            with self.subTest(chain=chain):
                mirror = Mirror()
                for name in chain:
                    frame, _ = parse_frame(messages[name])
                    message = m.decode(frame.type, frame.body)
                    apply = mirror.apply_snapshot if isinstance(message, m.Snapshot) else mirror.apply_diff
                    apply(message)
                mirror.verify()

    def check_banner(self, raw: bytes, expected: dict[str, object]) -> None:
        banner = Banner.decode(raw)
        self.assertEqual({"type": "Banner", "lowest": banner.lowest, "highest": banner.highest}, expected)
        self.assertEqual(banner.encode(), raw)

    def check_message(self, raw: bytes, expected: dict[str, object]) -> None:
        frame, size = parse_frame(raw)
        self.assertEqual(size, len(raw))
        kind = m.BY_TYPE[frame.type]
        codec = codec_of(kind)
        body = to_json(codec, m.decode(frame.type, frame.body))
        decoded = {"type": kind.__name__, "number": frame.type, "channel": frame.channel, "body": body}
        self.assertEqual(decoded, expected)
        message = from_json(codec, expected["body"])
        self.assertEqual(pack_frame(frame.type, frame.channel, m.encode(message)), raw)
