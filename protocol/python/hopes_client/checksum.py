"""The checksum that verifies a mirror.

In: vertices, edges or critical edges as tuples. Out: the sum of their hashes. Invariants: sums are modulo 2**64. The
sum over all three kinds is the `checksum` of the specification. The sum of no elements is 0, so sums are added and
subtracted as elements are added and removed.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import Any

MASK = (1 << 64) - 1

_PAIR = struct.Struct("<dd")
_BITS = struct.Struct("<QQ")

#: The id of a vertex, and its coordinates.
VertexRow = tuple[Any, ...]


def _mix(hash: int, words: tuple[int, ...]) -> int:
    """Continues `hash` with `words`."""
    for word in words:
        z = ((hash ^ word) + 0x9E3779B97F4A7C15) & MASK
        z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 & MASK
        z = (z ^ z >> 27) * 0x94D049BB133111EB & MASK
        hash = z ^ z >> 31
    return hash


# Every hash begins with the kind of the element.
_VERTEX = _mix(0, (1,))
_EDGE = _mix(0, (2,))
_CRITICAL = _mix(0, (3,))


def of_vertices(vertices: Iterable[VertexRow]) -> int:
    """The sum over (id, x, y), or over (id, x1, …, xd): all have the same number of coordinates."""
    rows = list(vertices)
    width = len(rows[0]) - 1 if rows else 0
    pack, bits = struct.Struct(f"<{width}d").pack, struct.Struct(f"<{width}Q").unpack
    return sum(_mix(_VERTEX, (row[0], *bits(pack(*row[1:])))) for row in rows) & MASK


def of_edges(edges: Iterable[tuple[int, int]]) -> int:
    """The sum over (a, b)."""
    return sum(_mix(_EDGE, edge) for edge in edges) & MASK


def of_critical(critical: Iterable[tuple[int, int, float, float]]) -> int:
    """The sum over (a, b, birth, death)."""
    pack, bits = _PAIR.pack, _BITS.unpack
    return sum(_mix(_CRITICAL, (a, b, *bits(pack(birth, death)))) for a, b, birth, death in critical) & MASK
