"""Values that a followed program told, read strictly: whatever is in another form than a tracer's is refused."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from server.sandbox.child.value_descriptions import LEVELS, NODES, NUMBERS, TEXT
from server.steps.schemas import (
    ArrayOut,
    MappingOut,
    NothingOut,
    NumberOut,
    OtherOut,
    SequenceOut,
    TextOut,
    TruthOut,
    Value,
)
from server.text.plain import visible

#: Of what is told: characters of a name, the longest whole number that JSON carries, the sides of an array.
NAME, WHOLE, SIDES = 80, 2**53 - 1, 8
_DTYPE = re.compile(r"[<>|=](?:b1|[iu][1248]|f(?:2|4|8|12|16)|c(?:8|16|24|32))")
_LONG = {"f12": "longdouble", "f16": "longdouble", "c24": "clongdouble", "c32": "clongdouble"}
#: One for all: a hostile trace may hold half a million.
_NOTHING = NothingOut()
_SEQUENCES = frozenset({"list", "tuple", "set", "frozenset", "deque", "range"})


class Malformed(ValueError):
    """What a program told is not in the form of what a tracer tells."""


def read(told: Any) -> Value:
    """The value that a tracer described. Raises Malformed."""
    return _value(told, 1)


def text(told: Any, most: int = NAME) -> str:
    """A text of bounded length, in which nothing hides. Raises Malformed."""
    if type(told) is not str or len(told) > most:
        raise Malformed("no text, or too long a one")
    return visible(told)


def whole(told: Any, most: int = WHOLE) -> int:
    """A whole number from 0 on, brought within what JSON carries. Raises Malformed."""
    if type(told) is not int or told < 0:
        raise Malformed("no whole number")
    return min(told, most)


def _value(told: Any, level: int) -> Value:
    if type(told) is not tuple or not told or type(told[0]) is not str:
        raise Malformed("no value")
    reader = _READERS.get(told[0])
    if reader is None or level > LEVELS + 1:
        raise Malformed("unknown kind of value, or too deep")
    return reader(told[1:], level)


def _exactly(parts: Sequence[Any], count: int) -> Sequence[Any]:
    if len(parts) != count:
        raise Malformed("another number of parts")
    return parts


def _alias(told: Any) -> int | None:
    return None if told is None else whole(told)


def _items(told: Any) -> tuple[Any, ...]:
    if type(told) is not tuple or len(told) > NODES + NUMBERS:
        raise Malformed("no items, or too many")
    return told


def _none(parts: Sequence[Any], level: int) -> NothingOut:
    _exactly(parts, 0)
    return _NOTHING


def _bool(parts: Sequence[Any], level: int) -> TruthOut:
    (truth,) = _exactly(parts, 1)
    if type(truth) is not bool:
        raise Malformed("no truth")
    return TruthOut(value=truth)


def _python(kind: type) -> Callable[[Sequence[Any], int], NumberOut]:
    def number(parts: Sequence[Any], level: int) -> NumberOut:
        (value,) = _exactly(parts, 1)
        if type(value) is not kind:
            raise Malformed("a number of another type")
        return NumberOut(type=kind.__name__, text=repr(value))

    return number


def _big(parts: Sequence[Any], level: int) -> NumberOut:
    bits = whole(*_exactly(parts, 1))
    return NumberOut(type="int", text=f"environ 10^{int(bits * math.log10(2))}")


def _numpy(parts: Sequence[Any], level: int) -> NumberOut:
    dtype, value = _exactly(parts, 2)
    name = _dtype(dtype)
    return NumberOut(type=name, text=_digits(value, name))


def _text(parts: Sequence[Any], level: int) -> TextOut:
    beginning, length = _exactly(parts, 2)
    return TextOut(text=text(beginning, TEXT), length=whole(length))


def _sequence(parts: Sequence[Any], level: int) -> SequenceOut:
    kind, alias, length, items = _exactly(parts, 4)
    if type(kind) is not str or kind not in _SEQUENCES:
        raise Malformed("unknown kind of sequence")
    shown = [_value(item, level + 1) for item in _items(items)]
    return SequenceOut(type=kind, items=shown, length=max(whole(length), len(shown)), alias=_alias(alias))


def _mapping(parts: Sequence[Any], level: int) -> MappingOut:
    alias, length, pairs = _exactly(parts, 3)
    shown = [_pair(pair, level) for pair in _items(pairs)]
    return MappingOut(items=shown, length=max(whole(length), len(shown)), alias=_alias(alias))


def _pair(told: Any, level: int) -> tuple[Value, Value]:
    if type(told) is not tuple or len(told) != 2:
        raise Malformed("no pair")
    return _value(told[0], level + 1), _value(told[1], level + 1)


def _array(parts: Sequence[Any], level: int) -> ArrayOut:
    dtype, alias, shape, numbers = _exactly(parts, 4)
    if type(shape) is not tuple or len(shape) > 4 * SIDES:
        raise Malformed("no shape")
    sides = [whole(side) for side in shape]
    name = _dtype(dtype)
    values = [_digits(number, name) for number in _items(numbers)]
    if len(values) > min(NUMBERS, math.prod(sides)):
        raise Malformed("more values than the array has")
    return ArrayOut(dtype=name, shape=sides, values=values, cut=len(values) < math.prod(sides), alias=_alias(alias))


def _other(parts: Sequence[Any], level: int) -> OtherOut:
    kind, name = _exactly(parts, 2)
    return OtherOut(type=text(kind), name=text(name))


def _dtype(told: Any) -> str:
    """The name of a dtype: those of numbers as numpy says it, « str » and « object », any other as it is written."""
    code = text(told)
    if _DTYPE.fullmatch(code):
        return _LONG.get(code[1:]) or np.dtype(code).name
    return "str" if code[1:2] == "U" else "object" if code[1:2] == "O" else code


def _digits(value: Any, dtype: str) -> str:
    """A number as Python writes it, with no more digits than its dtype has."""
    if type(value) is str:
        return text(value, TEXT)
    if type(value) not in (bool, int, float, complex):
        raise Malformed("no number")
    if dtype in ("float16", "float32") and type(value) is complex:
        raise Malformed("a complex number in a dtype that has none")
    if dtype in ("float16", "float32", "complex64") and type(value) in (float, complex):
        with np.errstate(over="ignore"):
            return str(np.dtype(dtype).type(value))
    return repr(value)


_READERS: dict[str, Callable[[Sequence[Any], int], Value]] = {
    "none": _none,
    "bool": _bool,
    "int": _python(int),
    "float": _python(float),
    "complex": _python(complex),
    "big": _big,
    "numpy": _numpy,
    "text": _text,
    "sequence": _sequence,
    "mapping": _mapping,
    "array": _array,
    "other": _other,
}
