"""Converts points to the form in which they are sent.

In: lists (or other iterables) of pairs, or numpy arrays. Out: `Packed` lists of `f64`, and lists of tags. Invariants:
numpy is imported only for objects that can become an array, so only if it is there. Numbers are not checked: the daemon
refuses invalid ones, one by one.
"""

from __future__ import annotations

import sys
from array import array
from collections.abc import Iterable, Sequence
from typing import Any, Union

from .codec import Packed

#: A list of (x, y), or an (n, 2) numpy array.
Points = Union[Iterable[Sequence[float]], Any]
#: A list of numbers, or a numpy array of them.
Numbers = Union[Iterable[float], Any]


def pack_points(points: Points) -> Packed:
    """Points for a `Batch` or `Retract`."""
    if hasattr(points, "__array__"):
        return _pack_array(points, columns=2)
    try:
        flat: array[float] = array("d", [number for x, y in points for number in (x, y)])
    except ValueError as error:
        raise ValueError(f"every point is a pair (x, y): {error}") from error
    return _pack_flat(flat, len(flat) // 2)


def pack_numbers(numbers: Numbers) -> Packed:
    """Times for a `Batch`."""
    if hasattr(numbers, "__array__"):
        return _pack_array(numbers, columns=None)
    flat = array("d", numbers)
    return _pack_flat(flat, len(flat))


def list_tags(tags: Iterable[int] | Any) -> list[int]:
    """Tags for a `Batch`."""
    return [int(tag) for tag in (tags.tolist() if hasattr(tags, "tolist") else tags)]


def _pack_flat(flat: array[float], count: int) -> Packed:
    if sys.byteorder == "big":
        flat.byteswap()
    return Packed(count, memoryview(flat).cast("B"))


def _pack_array(values: Any, columns: Any) -> Packed:
    import numpy

    packed = numpy.ascontiguousarray(values, dtype="<f8")
    if packed.size == 0:
        return Packed(0, memoryview(b""))
    if packed.ndim != (2 if columns else 1) or (columns and packed.shape[1] != columns):
        raise ValueError(f"an array of shape {packed.shape} was given, not {'(n, 2)' if columns else '(n,)'}")
    return Packed(len(packed), memoryview(packed.tobytes()))
