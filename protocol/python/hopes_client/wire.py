"""Banners and frames: the part that is the same for every message.

In: bytes, in pieces of any size. Out: `Banner`, `RawFrame` (with an encoded body), and both as bytes. Invariants: only
received bytes are stored. A length is compared with the limit before its body is waited for. Incomplete, malformed,
unsupported and too large are different errors.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from .crc import Buffer, crc32c
from .errors import Incomplete, Malformed, TooLarge, UnsupportedVersion, VersionMismatch

#: The lowest and the highest protocol version that this package speaks.
LOWEST_VERSION = 1
HIGHEST_VERSION = 4
#: The largest body that is read unless something else is asked for.
LARGEST_FRAME = 1 << 30

BANNER_SIZE = 20
HEADER_SIZE = 20
_CRC_SIZE = 4

_BANNER_MAGIC = b"HOPES\r\n\x1a"
_FRAME_MAGIC = b"hopF"
_BANNER = struct.Struct("<8sHHI")
_HEADER = struct.Struct("<4sHHII")
_CRC = struct.Struct("<I")


def _sealed(data: Buffer) -> bytes:
    """The data and its CRC."""
    return bytes(data) + _CRC.pack(crc32c(data))


@dataclass(frozen=True)
class Banner:
    """The lowest and the highest protocol version of a side."""

    lowest: int = LOWEST_VERSION
    highest: int = HIGHEST_VERSION

    def encode(self) -> bytes:
        """The 20 bytes of the banner."""
        return _sealed(_BANNER.pack(_BANNER_MAGIC, self.lowest, self.highest, 0))

    @classmethod
    def decode(cls, data: Buffer) -> Banner:
        """Reads the banner at the beginning of `data`. Raises `Incomplete` or `Malformed`."""
        if len(data) < BANNER_SIZE:
            raise Incomplete(BANNER_SIZE - len(data))
        head = bytes(data[: _BANNER.size])
        magic, lowest, highest, _ = _BANNER.unpack(head)
        if magic != _BANNER_MAGIC:
            raise Malformed("this is no hopes banner")
        if _CRC.unpack_from(data, _BANNER.size)[0] != crc32c(head):
            raise Malformed("the CRC of the banner is wrong")
        return cls(lowest, highest)

    def agree(self, other: Banner) -> int:
        """The highest version that both sides support. Raises `VersionMismatch` if there is none."""
        version = min(self.highest, other.highest)
        if version < max(self.lowest, other.lowest):
            raise VersionMismatch(
                f"this side speaks versions {self.lowest} to {self.highest} of the protocol, "
                f"the other side {other.lowest} to {other.highest}"
            )
        return version


@dataclass(frozen=True)
class RawFrame:
    """A frame with correct CRCs."""

    version: int
    type: int
    channel: int
    body: bytes


def pack_frame(type: int, channel: int, body: Buffer, version: int = HIGHEST_VERSION) -> bytes:
    """A whole frame."""
    header = _sealed(_HEADER.pack(_FRAME_MAGIC, version, type, channel, len(body)))
    return b"".join((header, body, _CRC.pack(crc32c(body))))


def parse_frame(data: Buffer, version: int = HIGHEST_VERSION, largest: int = LARGEST_FRAME) -> tuple[RawFrame, int]:
    """Reads the frame at the beginning of `data`. Returns it and its length.

    Raises `Incomplete`, `Malformed`, `UnsupportedVersion` or `TooLarge`.
    """
    if len(data) < HEADER_SIZE:
        raise Incomplete(HEADER_SIZE - len(data))
    head = bytes(data[: _HEADER.size])
    if _CRC.unpack_from(data, _HEADER.size)[0] != crc32c(head):
        raise Malformed("the CRC of a frame's header is wrong")
    magic, its_version, type, channel, length = _HEADER.unpack(head)
    if magic != _FRAME_MAGIC:
        raise Malformed("the magic bytes of a frame are wrong")
    if its_version != version:
        raise UnsupportedVersion(f"a frame is in version {its_version} of the protocol, not {version}")
    if length > largest:
        raise TooLarge(f"a body of {length} bytes is above the cap of {largest}")
    size = HEADER_SIZE + length + _CRC_SIZE
    if len(data) < size:
        raise Incomplete(size - len(data))
    body = bytes(data[HEADER_SIZE : HEADER_SIZE + length])
    if _CRC.unpack_from(data, HEADER_SIZE + length)[0] != crc32c(body):
        raise Malformed("the CRC of a body is wrong")
    return RawFrame(its_version, type, channel, body), size


class FrameBuffer:
    """Finds banners and frames in a stream of bytes."""

    def __init__(self, largest: int = LARGEST_FRAME) -> None:
        self._largest = largest
        self._data = bytearray()
        # With fewer bytes than this nothing can be complete.
        self._needed = 0

    def __len__(self) -> int:
        """The number of bytes that are not decoded yet."""
        return len(self._data)

    def feed(self, data: Buffer) -> None:
        """Appends received bytes."""
        self._data += data

    def next_banner(self) -> Banner | None:
        """The banner, if it is complete."""
        try:
            banner = Banner.decode(self._data)
        except Incomplete:
            return None
        del self._data[:BANNER_SIZE]
        return banner

    def next_frame(self, version: int) -> RawFrame | None:
        """The next frame, if it is complete."""
        if len(self._data) < self._needed:
            return None
        try:
            frame, size = parse_frame(self._data, version, self._largest)
        except Incomplete as incomplete:
            self._needed = len(self._data) + incomplete.needed
            return None
        self._needed = 0
        del self._data[:size]
        return frame
