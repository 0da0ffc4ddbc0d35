"""The vectors of each protocol version: every message as bytes and as JSON, and invalid bytes.

In: the files of `protocol/vectors`, a folder for each version. A folder without vectors is a failure.
"""

from __future__ import annotations

import json
import unittest
from pathlib import Path

from hopes_client import messages as m
from hopes_client.codec import codec_of
from hopes_client.errors import BodyError, Incomplete, Malformed, ProtocolError, TooLarge, UnsupportedVersion
from hopes_client.mirror import Mirror
from hopes_client.spaces import SpaceDiff, SpaceSnapshot, SpaceTracks
from hopes_client.track_mirror import TrackMirror
from hopes_client.wire import HIGHEST_VERSION, LOWEST_VERSION, Banner, pack_frame, parse_frame

from .vector_json import from_json, read_hex, to_json

VECTORS = Path(__file__).resolve().parents[2] / "vectors"
VERSIONS = range(LOWEST_VERSION, HIGHEST_VERSION + 1)
ERRORS = {
    "incomplete": Incomplete,
    "malformed": Malformed,
    "unsupported version": UnsupportedVersion,
    "too large": TooLarge,
    "body": BodyError,
}


def vectors(version: int, folder: str = "") -> list[tuple[str, bytes, dict[str, object]]]:
    """Name, bytes and JSON of each vector of a version."""
    return [
        (path.stem, read_hex(path), json.loads(path.with_suffix(".json").read_text()))
        for path in sorted((VECTORS / f"v{version}" / folder).glob("*.hex"))
    ]


def messages(version: int) -> dict[str, m.Message]:
    """The messages of the vectors of a version, by name."""
    frames = {name: parse_frame(raw, version)[0] for name, raw, _ in vectors(version) if name != "banner"}
    return {name: m.decode(frame.type, frame.body, version) for name, frame in frames.items()}


class Vectors(unittest.TestCase):
    def test_there_are_vectors_of_every_message(self) -> None:
        for version in VERSIONS:
            types = {expected["type"] for _, _, expected in vectors(version)}
            new = {kind.__name__ for kind in m.BY_TYPE.values() if kind.SINCE == version}
            self.assertLessEqual({"Banner", *new}, types)
            # One vector of an older version shows that its body is the same.
            self.assertLessEqual(len(types - {"Banner"} - new), version - 1)

    def test_every_vector_both_ways(self) -> None:
        for version in VERSIONS:
            for name, raw, expected in vectors(version):
                with self.subTest(version=version, vector=name):
                    if expected["type"] == "Banner":
                        self.check_banner(version, raw, expected)
                    else:
                        self.check_message(version, raw, expected)

    def test_every_wrong_vector(self) -> None:
        for version in VERSIONS:
            wrong = vectors(version, "bad")
            self.assertTrue(wrong)
            for name, raw, expected in wrong:
                with self.subTest(version=version, vector=name, why=expected["why"]):
                    error: type[ProtocolError] = ERRORS[str(expected["error"])]
                    with self.assertRaises(error):
                        frame, _ = parse_frame(raw, version)
                        m.decode(frame.type, frame.body, version)

    def test_the_checksums_of_snapshots_and_of_diffs_that_follow(self) -> None:
        all_of_them = messages(1)
        snapshots = [(name,) for name in all_of_them if name.startswith("snapshot")]
        for chain in (*snapshots, ("snapshot", "diff", "diff_onwards"), ("diff_from_nothing", "diff_merged")):
            with self.subTest(chain=chain):
                mirror = Mirror()
                for name in chain:
                    message = all_of_them[name]
                    if isinstance(message, m.Snapshot):
                        mirror.apply_snapshot(message)
                    else:
                        assert isinstance(message, m.Diff)
                        mirror.apply_diff(message)
                mirror.verify()

    def test_tracks_that_follow(self) -> None:
        all_of_them = messages(2)
        for chain, alive in (
            (("tracks_start", "tracks", "tracks_merged"), {1: True, 251: False}),
            (("tracks_start_events", "tracks_events"), {}),
        ):
            with self.subTest(chain=chain):
                mirror = TrackMirror()
                for name in chain:
                    message = all_of_them[name]
                    assert isinstance(message, m.Tracks)
                    mirror.apply(message)
                self.assertEqual({id: track.selected for id, track in mirror.alive.items()}, alive)

    def test_spaces_that_follow(self) -> None:
        all_of_them = messages(4)
        alone = [(name,) for name in all_of_them if name.startswith("space_snapshot")]
        for chain in (*alone, ("space_snapshot", "space_diff", "space_diff_onwards"), ("space_diff_borders",)):
            with self.subTest(chain=chain):
                mirror = Mirror()
                for name in chain:
                    message = all_of_them[name]
                    if isinstance(message, SpaceSnapshot):
                        mirror.apply_snapshot(message)
                    else:
                        assert isinstance(message, SpaceDiff)
                        mirror.apply_diff(message)
                mirror.verify()
        tracks = TrackMirror()
        for name in ("space_tracks_start", "space_tracks", "space_tracks_merged"):
            message = all_of_them[name]
            assert isinstance(message, SpaceTracks)
            tracks.apply(message)
        self.assertEqual(tracks.alive.keys(), {1, 251})

    def check_banner(self, version: int, raw: bytes, expected: dict[str, object]) -> None:
        banner = Banner.decode(raw)
        self.assertEqual({"type": "Banner", "lowest": banner.lowest, "highest": banner.highest}, expected)
        self.assertEqual(banner.encode(), raw)
        self.assertEqual(Banner().agree(banner), version)

    def check_message(self, version: int, raw: bytes, expected: dict[str, object]) -> None:
        frame, size = parse_frame(raw, version)
        self.assertEqual(size, len(raw))
        kind = m.BY_TYPE[frame.type]
        codec = codec_of(kind)
        body = to_json(codec, m.decode(frame.type, frame.body, version))
        decoded = {"type": kind.__name__, "number": frame.type, "channel": frame.channel, "body": body}
        self.assertEqual(decoded, expected)
        message = from_json(codec, expected["body"])
        self.assertEqual(pack_frame(frame.type, frame.channel, m.encode(message), version), raw)
