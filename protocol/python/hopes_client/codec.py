"""Bodies of messages: converts values to bytes and back, by the type hints of dataclasses.

In: a type made of the hints below (`U64`, `F64`, `bool`, `str`, `Optional[…]`, `list[…]`, `tuple[…]`, dataclasses,
`Choice`). Out: `codec_of(type)`: its `write` appends a value to a buffer, its `read` reads one from bytes. Invariants:
the bytes that are read are the only encoding of their value. Nothing is allocated for a list or string unless as many
bytes as its elements need at least are there. Reading raises only `BodyError`, `IndexError`, `struct.error` and
`ValueError`; `decode_body` turns the last three into the first.
"""

from __future__ import annotations

import dataclasses
import math
import struct
from collections.abc import Mapping, Sequence
from functools import cache
from operator import itemgetter
from typing import Annotated, Any, ClassVar, Union, get_args, get_origin, get_type_hints

from .errors import BodyError

# An unsigned integer is one byte below 251, else a mark and 2, 4 or 8 bytes. Its class is 0, 1, 2 or 3.
_LONG = 251
_LETTERS = "BHIQ"
_LONG_LETTERS = ("B", "xH", "xI", "xQ")
_LOWEST = (0, _LONG, 1 << 16, 1 << 32)
# The class by the first byte. 254 and 255 are not valid: their class is 4.
_CLASS = bytes([0] * _LONG + [1, 2, 3, 4, 4])
_LAYOUTS = [struct.Struct("<" + letter) for letter in _LETTERS]


class Codec:
    """Writes and reads values of one type."""

    #: The fewest bytes that a value takes.
    smallest: int

    def write(self, value: Any, out: bytearray) -> None:
        """Appends the value to `out`. Raises `ValueError`, `TypeError` or `struct.error` if it is not of this type."""
        raise NotImplementedError

    def read(self, data: bytes, at: int) -> tuple[Any, int]:
        """The value at the offset `at`, and the offset of its end."""
        raise NotImplementedError


class Unsigned(Codec):
    """`u16`, `u32`, `u64`."""

    smallest = 1

    def __init__(self, bits: int) -> None:
        self.limit = 1 << bits

    def write(self, value: Any, out: bytearray) -> None:
        if not 0 <= value < self.limit:
            raise ValueError(f"{value} is not in the range from 0 to {self.limit - 1}")
        if value < _LONG:
            out.append(value)
            return
        size = 1 if value < _LOWEST[2] else 2 if value < _LOWEST[3] else 3
        out.append(_LONG + size - 1)
        out += _LAYOUTS[size].pack(value)

    def read(self, data: bytes, at: int) -> tuple[int, int]:
        first = data[at]
        at += 1
        if first < _LONG:
            return first, at
        size = _CLASS[first]
        if size > 3:
            raise BodyError(f"{first} begins no number")
        layout = _LAYOUTS[size]
        value: int = layout.unpack_from(data, at)[0]
        if value < _LOWEST[size]:
            raise BodyError(f"{value} is not written in its shortest form")
        if value >= self.limit:
            raise BodyError(f"{value} is above {self.limit - 1}")
        return value, at + layout.size


class Float(Codec):
    """`f64`. Only finite numbers, unless allowed otherwise: all, or +infinity for what never happens (`never`)."""

    smallest = 8
    _layout = struct.Struct("<d")

    def __init__(self, finite: bool, never: bool = False) -> None:
        self.finite = finite
        self.never = never

    def allows(self, value: float) -> bool:
        """Whether the value may be sent."""
        return not self.finite or math.isfinite(value) or (self.never and value == math.inf)

    def check(self, numbers: Sequence[float]) -> None:
        """Raises if one of the numbers may not be sent."""
        # If the sum is finite, all numbers are. One addition for each is the fastest test.
        if not math.isfinite(sum(numbers)) and not all(map(self.allows, numbers)):
            raise BodyError("a number is not finite")

    def write(self, value: Any, out: bytearray) -> None:
        if not self.allows(value):
            raise ValueError(f"{value} is not finite")
        out += self._layout.pack(value)

    def read(self, data: bytes, at: int) -> tuple[float, int]:
        value: float = self._layout.unpack_from(data, at)[0]
        if not self.allows(value):
            raise BodyError(f"{value} is not finite")
        return value, at + 8


class Bool(Codec):
    """`bool`."""

    smallest = 1

    def write(self, value: Any, out: bytearray) -> None:
        out.append(1 if value else 0)

    def read(self, data: bytes, at: int) -> tuple[bool, int]:
        if data[at] > 1:
            raise BodyError(f"{data[at]} is neither true nor false")
        return data[at] == 1, at + 1


U16 = Annotated[int, Unsigned(16)]
U32 = Annotated[int, Unsigned(32)]
U64 = Annotated[int, Unsigned(64)]
F64 = Annotated[float, Float(finite=True)]
AnyF64 = Annotated[float, Float(finite=False)]
DeathF64 = Annotated[float, Float(finite=True, never=True)]

_COUNT = Unsigned(64)


def _read_count(data: bytes, at: int, smallest: int) -> tuple[int, int]:
    """A count of elements, checked against the bytes that are left."""
    count, at = _COUNT.read(data, at)
    if count * smallest > len(data) - at:
        raise BodyError(f"{count} elements do not fit into the {len(data) - at} bytes that are left")
    return count, at


class String(Codec):
    """`string`."""

    smallest = 1

    def write(self, value: Any, out: bytearray) -> None:
        raw = value.encode("utf-8")
        _COUNT.write(len(raw), out)
        out += raw

    def read(self, data: bytes, at: int) -> tuple[str, int]:
        length, at = _read_count(data, at, 1)
        return data[at : at + length].decode("utf-8"), at + length


class Option(Codec):
    """`T?`."""

    smallest = 1

    def __init__(self, some: Codec) -> None:
        self.some = some

    def write(self, value: Any, out: bytearray) -> None:
        out.append(0 if value is None else 1)
        if value is not None:
            self.some.write(value, out)

    def read(self, data: bytes, at: int) -> tuple[Any, int]:
        if data[at] > 1:
            raise BodyError(f"{data[at]} says neither that a value follows nor that none does")
        return self.some.read(data, at + 1) if data[at] else (None, at + 1)


class Tuple(Codec):
    """`(…)` as a tuple."""

    def __init__(self, parts: tuple[Codec, ...]) -> None:
        self.parts = parts
        self.smallest = sum(part.smallest for part in parts)

    def write(self, value: Any, out: bytearray) -> None:
        if len(value) != len(self.parts):
            raise ValueError(f"{len(self.parts)} values are needed, not {len(value)}")
        for part, item in zip(self.parts, value):
            part.write(item, out)

    def read(self, data: bytes, at: int) -> tuple[tuple[Any, ...], int]:
        values = []
        for part in self.parts:
            value, at = part.read(data, at)
            values.append(value)
        return tuple(values), at


class Struct(Codec):
    """`{…}` as a dataclass."""

    def __init__(self, kind: type, fields: dict[str, Codec]) -> None:
        self.kind = kind
        self.fields = fields
        self._tuple = Tuple(tuple(fields.values()))
        self.smallest = self._tuple.smallest

    def write(self, value: Any, out: bytearray) -> None:
        self._tuple.write([getattr(value, name) for name in self.fields], out)

    def read(self, data: bytes, at: int) -> tuple[Any, int]:
        values, at = self._tuple.read(data, at)
        return self.kind(*values), at


class OneOf(Codec):
    """`one of` as a `Choice`."""

    _number = Unsigned(32)

    def __init__(self, kind: type[Choice]) -> None:
        self.kind = kind
        self.cases = {case: Tuple(tuple(map(codec_of, hints))) for case, hints in kind.CASES.items()}
        self._names = tuple(self.cases)
        self.smallest = 1 + min(values.smallest for values in self.cases.values())

    def write(self, value: Any, out: bytearray) -> None:
        self._number.write(self._names.index(value.case), out)
        self.cases[value.case].write(value.values, out)

    def read(self, data: bytes, at: int) -> tuple[Choice, int]:
        number, at = self._number.read(data, at)
        if number >= len(self._names):
            raise BodyError(f"{self.kind.__name__} has no case {number}")
        case = self._names[number]
        values, at = self.cases[case].read(data, at)
        return self.kind(case, values), at


class ListOf(Codec):
    """`[T]` as a list, element by element."""

    smallest = 1

    def __init__(self, element: Codec) -> None:
        self.element = element

    def write(self, value: Any, out: bytearray) -> None:
        _COUNT.write(len(value), out)
        write = self.element.write
        for item in value:
            write(item, out)

    def read(self, data: bytes, at: int) -> tuple[list[Any], int]:
        count, at = _read_count(data, at, self.element.smallest)
        read = self.element.read
        values = []
        for _ in range(count):
            value, at = read(data, at)
            values.append(value)
        return values, at


@dataclasses.dataclass(frozen=True)
class Packed:
    """An encoded list of `f64`, or of tuples of them: `count` elements in `data`."""

    count: int
    data: memoryview

    def part(self, start: int, stop: int) -> Packed:
        """The elements from `start` up to `stop`. Nothing is copied."""
        size = len(self.data) // self.count if self.count else 0
        return Packed(min(stop, self.count) - start, self.data[start * size : stop * size])


class Floats(ListOf):
    """`[f64]` and `[(f64, …)]` in one step. Also writes a `Packed`."""

    def __init__(self, element: Float | Tuple) -> None:
        super().__init__(element)
        parts = element.parts if isinstance(element, Tuple) else (element,)
        self._flat = isinstance(element, Float)
        self._width = len(parts)
        self._parts = [part for part in parts if isinstance(part, Float)]

    def write(self, value: Any, out: bytearray) -> None:
        if isinstance(value, Packed):
            _COUNT.write(value.count, out)
            out += value.data
        else:
            super().write(value, out)

    def read(self, data: bytes, at: int) -> tuple[list[Any], int]:
        count, at = _read_count(data, at, self.element.smallest)
        end = at + count * self.element.smallest
        numbers = struct.unpack_from(f"<{count * self._width}d", data, at)
        for column, part in enumerate(self._parts):
            part.check(numbers[column :: self._width])
        return list(numbers) if self._flat else list(zip(*[iter(numbers)] * self._width)), end


class KeyedRows(ListOf):
    """`[(u64, …, f64, …)]` with one or two `u64` in front: vertices, edges, critical edges."""

    def __init__(self, element: Tuple, keys: int) -> None:
        super().__init__(element)
        self._keys = keys
        self._floats = len(element.parts) - keys
        self._parts = [part for part in element.parts if isinstance(part, Float)]
        # One layout for each class of the first key and, if there are two, of the second.
        heads = _LONG_LETTERS if keys == 1 else [first + second for first in _LONG_LETTERS for second in _LONG_LETTERS]
        self._layouts = [struct.Struct("<" + head + "d" * self._floats) for head in heads]

    def read(self, data: bytes, at: int) -> tuple[list[Any], int]:
        count, at = _read_count(data, at, self.element.smallest)
        rows, at = self._read_one_key(data, at, count) if self._keys == 1 else self._read_two_keys(data, at, count)
        for column, part in enumerate(self._parts, self._keys):
            part.check(list(map(itemgetter(column), rows)))
        return rows, at

    def _read_one_key(self, data: bytes, at: int, count: int) -> tuple[list[Any], int]:
        layouts, classes, lowest = self._layouts, _CLASS, _LOWEST
        rows = []
        for _ in range(count):
            size = classes[data[at]]
            if size > 3:
                raise BodyError(f"{data[at]} begins no number")
            layout = layouts[size]
            row = layout.unpack_from(data, at)
            if row[0] < lowest[size]:
                raise BodyError(f"{row[0]} is not written in its shortest form")
            rows.append(row)
            at += layout.size
        return rows, at

    def _read_two_keys(self, data: bytes, at: int, count: int) -> tuple[list[Any], int]:
        layouts, classes, lowest = self._layouts, _CLASS, _LOWEST
        widths = (1, 3, 5, 9, 0)
        rows = []
        for _ in range(count):
            first = classes[data[at]]
            second = classes[data[at + widths[first]]]
            if first > 3 or second > 3:
                raise BodyError("254 and 255 begin no number")
            layout = layouts[4 * first + second]
            row = layout.unpack_from(data, at)
            if row[0] < lowest[first] or row[1] < lowest[second]:
                raise BodyError(f"one of {row[0]} and {row[1]} is not written in its shortest form")
            rows.append(row)
            at += layout.size
        return rows, at


#: The types of the values of each case, in the order of the numbers of the cases.
Cases = Mapping[str, tuple[Any, ...]]


@dataclasses.dataclass(frozen=True)
class Choice:
    """A value of a `one of` type: the name of its case, and the values of that case."""

    case: str
    values: tuple[Any, ...] = ()

    CASES: ClassVar[Cases] = {}

    def __post_init__(self) -> None:
        if self.case not in self.CASES or len(self.values) != len(self.CASES[self.case]):
            raise ValueError(f"{type(self).__name__} has no case {self.case} with {len(self.values)} values")

    def __str__(self) -> str:
        return f"{self.case}({', '.join(map(str, self.values))})" if self.values else self.case


def _list_codec(element: Codec) -> Codec:
    """The fastest codec for a list of these elements."""
    parts = element.parts if isinstance(element, Tuple) else ()
    keys = [isinstance(part, Unsigned) and part.limit == 1 << 64 for part in parts]
    floats = [isinstance(part, Float) for part in parts]
    if isinstance(element, Float) or (isinstance(element, Tuple) and all(floats)):
        return Floats(element)
    if isinstance(element, Tuple) and sum(keys) in (1, 2) and all(keys[: sum(keys)]) and all(floats[sum(keys) :]):
        return KeyedRows(element, sum(keys))
    return ListOf(element)


def codec_of(hint: Any) -> Codec:
    """The codec of the values that a type hint allows."""
    return _derive(hint)


@cache
def _derive(hint: Any) -> Codec:
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is Annotated:
        codec = arguments[1]
        assert isinstance(codec, Codec)
        return codec
    if hint is bool:
        return Bool()
    if hint is str:
        return String()
    if origin is Union:
        inner = codec_of(arguments[0])
        # The only other union is a list with its `Packed` form. The codec of the list handles both.
        return Option(inner) if type(None) in arguments else inner
    if origin is list:
        return _list_codec(codec_of(arguments[0]))
    if origin is tuple:
        return Tuple(tuple(map(codec_of, arguments)))
    if isinstance(hint, type) and issubclass(hint, Choice):
        return OneOf(hint)
    if isinstance(hint, type) and dataclasses.is_dataclass(hint):
        hints = get_type_hints(hint, include_extras=True)
        return Struct(hint, {field.name: codec_of(hints[field.name]) for field in dataclasses.fields(hint)})
    raise TypeError(f"{hint} has no codec")


def encode_body(value: Any) -> bytearray:
    """Encodes the body of a message, a dataclass. `ValueError` if a field does not match its hint."""
    out = bytearray()
    try:
        codec_of(type(value)).write(value, out)
    except (struct.error, TypeError, AttributeError) as error:
        raise ValueError(f"{type(value).__name__} cannot be written: {error}") from error
    return out


def decode_body(kind: type, body: bytes) -> Any:
    """Decodes a message of this type. All of `body` must be used. Raises only `BodyError`."""
    try:
        value, end = codec_of(kind).read(body, 0)
    except BodyError as error:
        raise BodyError(f"{kind.__name__}: {error}") from None
    except (IndexError, struct.error):
        raise BodyError(f"{kind.__name__}: the body ends too early") from None
    except ValueError as error:
        raise BodyError(f"{kind.__name__}: {error}") from None
    if end != len(body):
        raise BodyError(f"{kind.__name__}: {len(body) - end} bytes remain after the last field")
    return value
