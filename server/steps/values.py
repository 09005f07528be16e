"""Reads the value descriptions of a traced program strictly: any other form is refused."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from server.sandbox.child.value_descriptions import LEVELS, NODES, NUMBERS, TEXT
from server.steps.schemas import (
    ArrayOut,
    BoolValueOut,
    MappingOut,
    NoneValueOut,
    NumberOut,
    OtherOut,
    SequenceOut,
    TextOut,
    Value,
)
from server.text.plain import show_invisible_characters

#: Bounds: characters of a name, the largest whole number that JSON carries, dimensions of an array.
MAX_NAME_CHARACTERS, MAX_WHOLE_NUMBER, MAX_DIMENSIONS = 80, 2**53 - 1, 8
_DTYPE = re.compile(r"[<>|=](?:b1|[iu][1248]|f(?:2|4|8|12|16)|c(?:8|16|24|32))")
_LONG = {"f12": "longdouble", "f16": "longdouble", "c24": "clongdouble", "c32": "clongdouble"}
#: A single instance: a hostile trace may hold half a million.
_NOTHING = NoneValueOut()
_SEQUENCES = frozenset({"list", "tuple", "set", "frozenset", "deque", "range"})


class MalformedTrace(ValueError):
    """A record does not have the form of a tracer's."""


def read_value(record: Any) -> Value:
    """Read a value that a tracer described. Raises MalformedTrace."""
    return _read_value(record, 1)


def read_text(record: Any, limit: int = MAX_NAME_CHARACTERS) -> str:
    """Read a text of bounded length; control characters become visible. Raises MalformedTrace."""
    if type(record) is not str or len(record) > limit:
        raise MalformedTrace("no text, or too long a one")
    return show_invisible_characters(record)


def read_whole_number(record: Any, limit: int = MAX_WHOLE_NUMBER) -> int:
    """Read a whole number ≥ 0, clamped to `limit`. Raises MalformedTrace."""
    if type(record) is not int or record < 0:
        raise MalformedTrace("no whole number")
    return min(record, limit)


def _read_value(record: Any, level: int) -> Value:
    if type(record) is not tuple or not record or type(record[0]) is not str:
        raise MalformedTrace("no value")
    reader = _READERS.get(record[0])
    if reader is None or level > LEVELS + 1:
        raise MalformedTrace("unknown kind of value, or too deep")
    return reader(record[1:], level)


def _require_length(parts: Sequence[Any], count: int) -> Sequence[Any]:
    if len(parts) != count:
        raise MalformedTrace("another number of parts")
    return parts


def _read_alias(record: Any) -> int | None:
    return None if record is None else read_whole_number(record)


def _require_items(record: Any) -> tuple[Any, ...]:
    if type(record) is not tuple or len(record) > NODES + NUMBERS:
        raise MalformedTrace("no items, or too many")
    return record


def _read_none(parts: Sequence[Any], level: int) -> NoneValueOut:
    _require_length(parts, 0)
    return _NOTHING


def _read_bool(parts: Sequence[Any], level: int) -> BoolValueOut:
    (truth,) = _require_length(parts, 1)
    if type(truth) is not bool:
        raise MalformedTrace("no truth")
    return BoolValueOut(value=truth)


def _make_number_reader(kind: type) -> Callable[[Sequence[Any], int], NumberOut]:
    def number(parts: Sequence[Any], level: int) -> NumberOut:
        (value,) = _require_length(parts, 1)
        if type(value) is not kind:
            raise MalformedTrace("a number of another type")
        return NumberOut(type=kind.__name__, text=repr(value))

    return number


def _read_big_integer(parts: Sequence[Any], level: int) -> NumberOut:
    bits = read_whole_number(*_require_length(parts, 1))
    return NumberOut(type="int", text=f"environ 10^{int(bits * math.log10(2))}")


def _read_numpy_scalar(parts: Sequence[Any], level: int) -> NumberOut:
    dtype, value = _require_length(parts, 2)
    name = _read_dtype_name(dtype)
    return NumberOut(type=name, text=_format_number(value, name))


def _read_text(parts: Sequence[Any], level: int) -> TextOut:
    beginning, length = _require_length(parts, 2)
    return TextOut(text=read_text(beginning, TEXT), length=read_whole_number(length))


def _read_sequence(parts: Sequence[Any], level: int) -> SequenceOut:
    kind, alias, length, items = _require_length(parts, 4)
    if type(kind) is not str or kind not in _SEQUENCES:
        raise MalformedTrace("unknown kind of sequence")
    items_read = [_read_value(item, level + 1) for item in _require_items(items)]
    return SequenceOut(
        type=kind, items=items_read, length=max(read_whole_number(length), len(items_read)), alias=_read_alias(alias)
    )


def _read_mapping(parts: Sequence[Any], level: int) -> MappingOut:
    alias, length, pairs = _require_length(parts, 3)
    items_read = [_read_pair(pair, level) for pair in _require_items(pairs)]
    return MappingOut(
        items=items_read, length=max(read_whole_number(length), len(items_read)), alias=_read_alias(alias)
    )


def _read_pair(record: Any, level: int) -> tuple[Value, Value]:
    if type(record) is not tuple or len(record) != 2:
        raise MalformedTrace("no pair")
    return _read_value(record[0], level + 1), _read_value(record[1], level + 1)


def _read_array(parts: Sequence[Any], level: int) -> ArrayOut:
    dtype, alias, shape, numbers = _require_length(parts, 4)
    if type(shape) is not tuple or len(shape) > 4 * MAX_DIMENSIONS:
        raise MalformedTrace("no shape")
    sides = [read_whole_number(side) for side in shape]
    name = _read_dtype_name(dtype)
    values = [_format_number(number, name) for number in _require_items(numbers)]
    if len(values) > min(NUMBERS, math.prod(sides)):
        raise MalformedTrace("more values than the array has")
    return ArrayOut(
        dtype=name, shape=sides, values=values, cut=len(values) < math.prod(sides), alias=_read_alias(alias)
    )


def _read_other_object(parts: Sequence[Any], level: int) -> OtherOut:
    kind, name = _require_length(parts, 2)
    return OtherOut(type=read_text(kind), name=read_text(name))


def _read_dtype_name(record: Any) -> str:
    """Return the name of a dtype: numpy's for numbers, « str », « object », any other code as it is."""
    code = read_text(record)
    if _DTYPE.fullmatch(code):
        return _LONG.get(code[1:]) or np.dtype(code).name
    return "str" if code[1:2] == "U" else "object" if code[1:2] == "O" else code


def _format_number(value: Any, dtype: str) -> str:
    """Format a number as Python does, with no more digits than its dtype has."""
    if type(value) is str:
        return read_text(value, TEXT)
    if type(value) not in (bool, int, float, complex):
        raise MalformedTrace("no number")
    if dtype in ("float16", "float32") and type(value) is complex:
        raise MalformedTrace("a complex number in a dtype that has none")
    if dtype in ("float16", "float32", "complex64") and type(value) in (float, complex):
        with np.errstate(over="ignore"):
            return str(np.dtype(dtype).type(value))
    return repr(value)


_READERS: dict[str, Callable[[Sequence[Any], int], Value]] = {
    "none": _read_none,
    "bool": _read_bool,
    "int": _make_number_reader(int),
    "float": _make_number_reader(float),
    "complex": _make_number_reader(complex),
    "big": _read_big_integer,
    "numpy": _read_numpy_scalar,
    "text": _read_text,
    "sequence": _read_sequence,
    "mapping": _read_mapping,
    "array": _read_array,
    "other": _read_other_object,
}
