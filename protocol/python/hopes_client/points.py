"""Converts points to the form in which they are sent.

In: lists (or other iterables) of pairs, numpy arrays, or tables that become arrays (pandas, pyarrow, polars). Out:
`Packed` lists of `f64`, and lists of tags. Invariants: numpy is imported only for objects that can become an array, so
only if it is there. Numbers are not checked: the daemon refuses invalid ones, one by one. What its container marks as
missing (masked, null, None, NA, NaT) is sent as NaN, so that the daemon refuses and counts it with its index; it is
never sent as a number.
"""

from __future__ import annotations

import math
import sys
from array import array
from collections.abc import Iterable, Sequence
from typing import Any, Union

from .codec import Packed

#: A list of (x, y), an (n, 2) array, or a table with the columns x and y.
Points = Union[Iterable[Sequence[float]], Any]
#: A list of numbers, or an array of them.
Numbers = Union[Iterable[float], Any]

#: Names of two columns, the one that is x first.
_AXES = (("x", "y"), ("lon", "lat"), ("longitude", "latitude"), ("easting", "northing"))
#: Types whose only value stands for one that is missing, by name: their module may not be there.
_MISSING = ("NoneType", "NAType", "NaTType", "MaskedConstant")


def pack_points(points: Points) -> Packed:
    """Points for a `Batch` or `Retract`."""
    if hasattr(points, "__array__"):
        return _pack_array(points, columns=2)
    try:
        flat = [number for x, y in points for number in (x, y)]
    except ValueError as error:
        raise ValueError(f"every point is a pair (x, y): {error}") from error
    return _pack_flat(_doubles(flat, width=2), len(flat) // 2)


def pack_points_of(points: Points) -> Packed:
    """Points of any number of coordinates for a `SpaceBatch` or `SpaceRetract`. An element is a point."""
    if hasattr(points, "__array__"):
        return _pack_rows(points)
    rows = [list(point) for point in points]
    width = len(rows[0]) if rows else 0
    for index, row in enumerate(rows):
        if len(row) != width or not width:
            raise ValueError(f"point {index} has {len(row)} coordinates, the first one {width}: give all as many")
    flat = [number for row in rows for number in row]
    return _pack_flat(_doubles(flat, width=width), len(rows))


def pack_numbers(numbers: Numbers) -> Packed:
    """Times for a `Batch`."""
    if hasattr(numbers, "__array__"):
        return _pack_array(numbers, columns=None)
    flat = _doubles(numbers if isinstance(numbers, array) else list(numbers), width=1)
    return _pack_flat(flat, len(flat))


def list_tags(tags: Iterable[int] | Any) -> list[int]:
    """Tags for a `Batch`."""
    return [_tag(index, tag) for index, tag in enumerate(tags.tolist() if hasattr(tags, "tolist") else tags)]


def _tag(index: int, tag: Any) -> int:
    if type(tag).__name__ in _MISSING:
        raise ValueError(f"tag {index} is missing ({tag!r}): leave its point out, or give all points a tag")
    if int(tag) != tag:
        raise ValueError(f"tag {index} is {tag!r}, not a whole number")
    return int(tag)


def _doubles(numbers: Any, width: int) -> array[float]:
    """Numbers of a list. What is missing becomes NaN."""
    try:
        return array("d", numbers)
    except TypeError:
        return array("d", [_number(index // width, value) for index, value in enumerate(numbers)])


def _number(index: int, value: Any) -> float:
    if type(value).__name__ in _MISSING:
        return math.nan
    if isinstance(value, (str, bytes)):
        raise TypeError(f"point {index} has the text {value!r} where a number should be: convert it with float()")
    try:
        return float(value)
    except TypeError as error:
        raise TypeError(f"point {index} has {value!r} where a number should be") from error


def _pack_flat(flat: array[float], count: int) -> Packed:
    if sys.byteorder == "big":
        flat.byteswap()
    return Packed(count, memoryview(flat).cast("B"))


def _pack_array(values: Any, columns: Any) -> Packed:
    import numpy

    values = _by_name(values) if columns else values
    packed = numpy.ascontiguousarray(_as_doubles(values), dtype="<f8")
    if packed.size == 0:
        return Packed(0, memoryview(b""))
    if packed.ndim != (2 if columns else 1) or (columns and packed.shape[1] != columns):
        raise ValueError(f"an array of shape {packed.shape} was given, not {'(n, 2)' if columns else '(n,)'}")
    return Packed(len(packed), memoryview(packed.tobytes()))


def _pack_rows(values: Any) -> Packed:
    import numpy

    packed = numpy.ascontiguousarray(_as_doubles(values), dtype="<f8")
    if packed.ndim != 2 or packed.shape[1] == 0:
        raise ValueError(f"an array of shape {packed.shape} was given, not (n, d)")
    return Packed(len(packed), memoryview(packed.tobytes()))


def _by_name(table: Any) -> Any:
    """The columns of a table or the fields of an array in the order x, y, if they have names that say so."""
    fields = getattr(getattr(table, "dtype", None), "names", None)
    names = fields or getattr(table, "column_names", None) or getattr(table, "columns", None)
    if names is None:
        return table
    names = list(names)
    plain = [str(name).strip().lower() for name in names]
    for axes in _AXES:
        if sorted(plain) == sorted(axes):
            ordered = [names[plain.index(axis)] for axis in axes]
            return _stacked([table[name] for name in ordered]) if fields or names != ordered else table
    if fields:
        raise ValueError(f"the array has the fields {', '.join(fields)}: choose two, as in points[['x', 'y']]")
    return table


def _stacked(columns: list[Any]) -> Any:
    import numpy

    return numpy.stack([_as_doubles(column) for column in columns], axis=-1)


def _as_doubles(values: Any) -> Any:
    """An array of doubles, with NaN where its container has nothing."""
    import numpy

    found = values if isinstance(values, numpy.ma.MaskedArray) else _as_array(values)
    kind = found.dtype.kind
    if kind == "c":
        raise TypeError(f"an array of {found.dtype} was given: numbers are real")
    if kind in "SUV":
        raise TypeError(f"an array of {found.dtype} was given, not of numbers")
    mask = numpy.ma.getmask(found)
    plain = numpy.ma.getdata(found)
    if kind == "O":
        # What is masked may be anything.
        shown = [math.nan if hidden else value for hidden, value in _pairs(mask, plain)]
        width = plain.shape[1] if plain.ndim == 2 else 1
        doubles = numpy.array([_number(index // width, value) for index, value in enumerate(shown)], dtype="f8")
        return doubles.reshape(plain.shape)
    if kind in "mM":
        # Event times, in seconds; instants since 1970. NaT becomes NaN, though it is a number inside.
        doubles = (plain - numpy.datetime64(0, "s") if kind == "M" else plain) / numpy.timedelta64(1, "s")
    else:
        doubles = plain.astype("f8")
    if mask is not numpy.ma.nomask:
        doubles[mask] = math.nan
    return doubles


def _pairs(mask: Any, plain: Any) -> Iterable[tuple[bool, Any]]:
    hidden = mask.ravel().tolist() if getattr(mask, "shape", ()) else [False] * plain.size
    return zip(hidden, plain.ravel())


def _as_array(values: Any) -> Any:
    """A numpy array of a table or an array of another library, as far as that keeps what is missing."""
    import numpy

    if not isinstance(values, numpy.ndarray) and hasattr(values, "to_numpy"):
        kind = getattr(getattr(values, "dtype", None), "kind", None)
        try:
            if kind in ("m", "M"):
                return values.to_numpy(dtype=f"{kind}8[ns]")
            # The extension types of pandas keep a mask, which plain conversion takes for an error.
            return values.to_numpy(dtype="f8", na_value=math.nan)
        except (TypeError, ValueError):
            pass
    return numpy.asarray(values)
