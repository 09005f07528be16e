"""Describes values for the tracer, as tagged tuples of base types, by exact types alone.

No code of the student runs here: no `repr`, no method and no attribute of their objects, no comparison, not even the
hash of a type, which a metaclass may define; nor builtins that they replaced.
"""

from __future__ import annotations

import builtins
from collections import deque
from itertools import islice
from types import BuiltinFunctionType, FunctionType, MethodType, ModuleType
from typing import Any
from zlib import crc32

import numpy as np

from .wire_values import Value

globals()["__builtins__"] = dict(vars(builtins))

#: Bounds of one description: nodes in all, levels, characters of a text and of a name, numbers of an array.
NODES, LEVELS, TEXT, NAME, NUMBERS = 250, 5, 200, 80, 400
#: An integer of more bits is described by its size.
BITS = 1000
#: Arrays up to this many bytes are compared whole; larger ones by SAMPLED items spread over them.
COMPARED = 1 << 22
SAMPLED = 1 << 12

_TYPE_NAME = type.__dict__["__name__"].__get__
_MRO = type.__dict__["__mro__"].__get__
_ARGS = vars(BaseException)["args"].__get__
_NAN, _COMPLEX_NAN = float("nan"), complex("nan")
_ARRAY, _DICT, _TYPE, _MODULE, _METHOD = map(id, (np.ndarray, dict, type, ModuleType, MethodType))
_SCALARS = frozenset(map(id, (type(None), bool, int, float, complex, str)))
_NUMPY = frozenset(
    id(kind)
    for kind in (
        *(np.bool_, np.int8, np.int16, np.int32, np.int64, np.uint8, np.uint16, np.uint32, np.uint64),
        *(np.longlong, np.ulonglong, np.float16, np.float32, np.float64, np.complex64, np.complex128),
    )
)
_SEQUENCES = {id(kind): kind.__name__ for kind in (list, tuple, set, frozenset, deque, range)}
#: Sequence types whose objects can be shared and changed.
_MUTABLE = frozenset(map(id, (list, set, deque)))
_NAMED = frozenset(map(id, (FunctionType, BuiltinFunctionType)))


class ValueDescriber:
    """Describes values. The same object gets the same number (`object_number`) each time, as long as it lives."""

    def __init__(self) -> None:
        self._numbers: dict[int, int] = {}
        self.nodes = 0  # of the last value

    def describe(self, value: object) -> Value:
        """One of ("none",), ("bool", b), ("int", n), ("big", bits), ("float", x), ("complex", z), ("numpy", dtype,
        number), ("text", beginning, length), ("sequence", type, alias, length, items), ("mapping", alias, length,
        pairs), ("array", dtype, alias, shape, numbers), ("other", type, name)."""
        room = [NODES]
        described = self._describe(value, 1, room)
        self.nodes = NODES - room[0]
        return described

    def _describe(self, value: Any, level: int, room: list[int]) -> Value:
        room[0] -= 1
        kind = id(type(value))
        if kind in _SCALARS:
            return _describe_scalar(value)
        if kind in _NUMPY:
            return "numpy", value.dtype.str, _unify_nan(value.item())
        if kind == _ARRAY:
            return self._describe_array(value, room)
        if kind in _SEQUENCES:
            return self._describe_sequence(value, kind, level, room)
        if kind == _DICT:
            return self._describe_mapping(value, level, room)
        return "other", type_name(type(value)), _object_name(value, kind)

    def _describe_sequence(self, value: Any, kind: int, level: int, room: list[int]) -> Value:
        items = [self._describe(item, level + 1, room) for item in _take_items(value, level, room) if room[0] > 0]
        alias = self.object_number(value) if kind in _MUTABLE else None
        return "sequence", _SEQUENCES[kind], alias, _length(value), tuple(items)

    def _describe_mapping(self, value: dict[Any, Any], level: int, room: list[int]) -> Value:
        pairs = [
            (self._describe(key, level + 1, room), self._describe(item, level + 1, room))
            for key, item in _take_items(value.items(), level, room)
            if room[0] > 0
        ]
        return "mapping", self.object_number(value), len(value), tuple(pairs)

    def _describe_array(self, array: Any, room: list[int]) -> Value:
        limit = NUMBERS if room[0] == NODES - 1 else max(0, min(NUMBERS, room[0]))
        numbers = _first_numbers(array, limit)
        room[0] -= len(numbers)
        return "array", array.dtype.str, self.object_number(array), array.shape, tuple(numbers)

    def object_number(self, value: object) -> int:
        return self._numbers.setdefault(id(value), len(self._numbers))


def _take_items(items: Any, level: int, room: list[int]) -> list[Any]:
    """Return as many items as the budget allows, before describing them: a description may trigger a garbage collection
    that runs the student's finalisers."""
    return list(islice(items, max(0, room[0]))) if level <= LEVELS else []


def _length(value: Any) -> int:
    try:
        return len(value)
    except OverflowError:  # a range
        return 2**62


def _describe_scalar(value: Any) -> Value:
    if value is None:
        return ("none",)
    if type(value) is int:
        bits = value.bit_length()
        return ("big", bits) if bits > BITS else ("int", value)
    if type(value) is str:
        return "text", value[:TEXT], len(value)
    return type(value).__name__, _unify_nan(value)


def _unify_nan(value: Any) -> Any:
    """Return the number; a single nan object stands for all nans."""
    if value == value:  # noqa: PLR0124
        return value
    return _COMPLEX_NAN if type(value) is complex else _NAN


def _first_numbers(array: Any, limit: int) -> list[Any]:
    """Return the first items of an array, row by row: numbers, or texts for other items."""
    kind = array.dtype.kind
    if kind not in "biufcUO":
        return []
    items = array.flat[:limit]
    if kind in "fc" and array.dtype.itemsize > (8 if kind == "f" else 16):
        return [_unify_nan((float if kind == "f" else complex)(item)) for item in items]
    if kind in "fc":
        return [_unify_nan(item) for item in items.tolist()]
    return [_describe_array_item(item) for item in items.tolist()] if kind in "UO" else list(items.tolist())


def _describe_array_item(value: Any) -> Any:
    """Describe an item of an array of objects or texts."""
    if id(type(value)) not in _SCALARS:
        return type_name(type(value))
    if type(value) is str:
        return value[:NAME]
    if type(value) is int and value.bit_length() > BITS:
        return "int"
    return "None" if value is None else _unify_nan(value)


def type_name(kind: type) -> str:
    """Return the name of a type as the interpreter stores it, whatever its metaclass."""
    name = _TYPE_NAME(kind)
    return name[:NAME] if type(name) is str else ""


def _object_name(value: Any, kind: int) -> str:
    if kind == _METHOD:
        value, kind = value.__func__, id(type(value.__func__))
    if kind in _NAMED:
        name = value.__name__
    elif kind == _MODULE:
        name = next((text for key, text in list(vars(value).items()) if type(key) is str and key == "__name__"), "")
    elif kind == _TYPE:
        name = _TYPE_NAME(value)
    else:
        return ""
    return name[:NAME] if type(name) is str else ""


def describe_exception(kind: type, value: Any) -> tuple[str, str]:
    """Return the name of an exception and its message, where its argument is a text or a number."""
    said = value
    if any(base is BaseException for base in _MRO(type(value))):
        arguments = _ARGS(value)
        said = arguments[0] if type(arguments) is tuple and arguments else None
    if type(said) is str:
        return type_name(kind), said[:TEXT]
    plain = type(said) is float or (type(said) is int and said.bit_length() <= BITS)
    return type_name(kind), str(said) if plain else ""


def fingerprint(value: Any, described: ValueDescriber) -> Any:
    """Return a fingerprint by which `is_same` tells whether a variable has changed."""
    kind = id(type(value))
    if kind in _SCALARS or kind in _NUMPY:
        return value
    if kind == _ARRAY:
        return Fingerprint(id(value), (array_fingerprint(value), value.shape, value.dtype.str))
    if kind in _SEQUENCES or kind == _DICT:
        return Fingerprint(id(value), described.describe(value))
    return Fingerprint(id(value), type_name(type(value)))


class Fingerprint:
    """Fingerprint of a mutable value."""

    __slots__ = ("content", "number")

    def __init__(self, number: int, content: Any) -> None:
        self.number, self.content = number, content


def is_same(before: Any, now: Any) -> bool:
    if type(before) is not type(now):
        return False
    if type(now) is Fingerprint:
        return before.number == now.number and _is_deeply_equal(before.content, now.content)
    return before is now or bool(before == now) or bool(before != before and now != now)  # noqa: PLR0124


def _is_deeply_equal(before: Any, other: Any) -> bool:
    """Equal, and of the same types all the way: 1 is not 1.0."""
    if type(before) is not type(other):
        return False
    if type(before) is tuple:
        return len(before) == len(other) and all(map(_is_deeply_equal, before, other))
    return before is other or bool(before == other)


def array_fingerprint(array: Any) -> int:
    """The same number as long as an array keeps its content; of a very large one, what is looked at of it."""
    if array.nbytes <= COMPARED:
        return crc32(array.tobytes())
    return crc32(array.flat[:: array.size // SAMPLED].tobytes())
