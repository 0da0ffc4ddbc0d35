"""Test vectors: messages as JSON.

In: a message class and JSON, or a message. Out: the other. Invariant: `{…}` are objects, `(…)` are arrays, options are
null or their value. A case without values is its name, one with a value is `{name: value}`, one with several is `{name:
[values]}`. Numbers that JSON does not have are strings that Python's `float` reads.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from hopes_client.codec import Bool, Codec, Float, ListOf, OneOf, Option, String, Struct, Tuple, Unsigned


def read_hex(path: Path) -> bytes:
    """The bytes of a `.hex` file."""
    return bytes.fromhex("".join(path.read_text().split()))


def to_json(codec: Codec, value: Any) -> Any:
    """A value as JSON."""
    if isinstance(codec, Option):
        return None if value is None else to_json(codec.some, value)
    if isinstance(codec, ListOf):
        return [to_json(codec.element, item) for item in value]
    if isinstance(codec, Tuple):
        return [to_json(part, item) for part, item in zip(codec.parts, value)]
    if isinstance(codec, Struct):
        fields = codec.fields.items()
        return {name.rstrip("_"): to_json(field, getattr(value, name)) for name, field in fields}
    if isinstance(codec, OneOf):
        values = to_json(codec.cases[value.case], value.values)
        return {value.case: values[0] if len(values) == 1 else values} if values else value.case
    if isinstance(codec, Float) and not math.isfinite(value):
        return str(value)
    return value


def from_json(codec: Codec, value: Any) -> Any:
    """The value that JSON stands for."""
    if isinstance(codec, Option):
        return None if value is None else from_json(codec.some, value)
    if isinstance(codec, ListOf):
        return [from_json(codec.element, item) for item in value]
    if isinstance(codec, Tuple):
        return tuple(from_json(part, item) for part, item in zip(codec.parts, value))
    if isinstance(codec, Struct):
        return codec.kind(*(from_json(field, value[name.rstrip("_")]) for name, field in codec.fields.items()))
    if isinstance(codec, OneOf):
        case, values = (value, []) if isinstance(value, str) else next(iter(value.items()))
        parts = codec.cases[case]
        return codec.kind(case, from_json(parts, values if len(parts.parts) != 1 else [values]))
    if isinstance(codec, Float):
        return float(value)
    assert isinstance(codec, (Unsigned, Bool, String))
    return value
