"""Values of scenarios on their way to a program and back: base types stand for themselves, tuples are tags."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from graders.core.compare.python_values import DIGITS, OpaqueObject, RaisedException, python_text
from graders.core.contract.values import Value


@dataclass(frozen=True)
class FunctionSource:
    """A function given as an argument, by its source.

    `imports` are the names that it uses of modules, each with its module and attribute; `names` those of the case and
    of the program.
    """

    source: str
    imports: tuple[tuple[str, str, str], ...] = ()
    names: tuple[str, ...] = ()


@dataclass(frozen=True)
class Reference:
    """An earlier name of the case, a function of the program, or what is `imported`: its module and attribute."""

    name: str
    imported: tuple[str, str] | None = None


@dataclass(frozen=True)
class NestedCall:
    """A call whose value is an argument, or on whose value a method is called: `base` is that value.

    What is called is of the program, or `imported`: its module and attribute.
    """

    callee: str
    arguments: tuple[Value, ...] = ()
    named: tuple[tuple[str, Value], ...] = ()
    base: Value = None
    imported: tuple[str, str] | None = None

    @property
    def called_program_name(self) -> str:
        """The first name of the program that is called; empty where none is."""
        if self.imported is not None:
            inside = (*self.arguments, *(value for _, value in self.named))
            return next(
                (
                    value.called_program_name
                    for value in inside
                    if isinstance(value, NestedCall) and value.called_program_name
                ),
                "",
            )
        return self.base.called_program_name if isinstance(self.base, NestedCall) else self.callee.partition(".")[0]


def call_text(
    callee: str,
    arguments: Iterable[Value],
    named: Iterable[tuple[str, Value]],
    digits: int | None = DIGITS,
) -> str:
    """Return a call as Python writes it; see `python_text` for `digits`."""
    parts = [value_text(value, digits) for value in arguments]
    parts += [f"{name}={value_text(value, digits)}" for name, value in named]
    return f"{callee}({', '.join(parts)})"


def value_text(value: Value, digits: int | None = DIGITS) -> str:
    """Return a value of a case as Python writes it; see `python_text` for `digits`."""
    if isinstance(value, NestedCall):
        base = f"{value_text(value.base, digits)}." if isinstance(value.base, NestedCall) else ""
        return base + call_text(value.callee, value.arguments, value.named, digits)
    if isinstance(value, FunctionSource):
        return value.source
    if isinstance(value, Reference):
        return value.name
    return python_text(value, digits)


def encode_value(value: Value) -> Value:
    """Return a value as the driver reads it, of types that `marshal` writes: tuples are tags, lists and base types
    stand for themselves."""
    if isinstance(value, list):
        return [encode_value(item) for item in value]
    if isinstance(value, int | float | str | complex | None):
        return value.item() if isinstance(value, np.generic) else value
    encoders: tuple[tuple[Any, str, Callable[[Any], Value]], ...] = (
        (FunctionSource, "f", _encode_function),
        (Reference, "r", lambda reference: list(reference.imported) if reference.imported else reference.name),
        (NestedCall, "c", _encode_call),
        (tuple, "t", lambda items: [encode_value(item) for item in items]),
        (set | frozenset, "s", lambda items: [encode_value(item) for item in sorted(items, key=repr)]),
        (dict, "d", lambda pairs: [[encode_value(key), encode_value(item)] for key, item in pairs.items()]),
        (bytes, "b", bytes),
        (np.ndarray, "a", _encode_array),
        (np.generic, "n", lambda number: number.item()),
    )
    return next(((tag, encode(value)) for kind, tag, encode in encoders if isinstance(value, kind)), value)


def _encode_array(array: Value) -> Value:
    if array.dtype.hasobject:  # its bytes are addresses in this process
        raise TypeError("no array of objects travels")
    return array.dtype.str, array.shape, array.tobytes()


def _encode_function(function: FunctionSource) -> Value:
    if not (function.imports or function.names):
        return function.source
    return [function.source, [list(each) for each in function.imports], list(function.names)]


def _encode_call(call: NestedCall) -> Value:
    named = [[name, encode_value(value)] for name, value in call.named]
    base = [encode_value(call.base)] if call.base is not None else []
    callee = list(call.imported) if call.imported else call.callee
    return [callee, [encode_value(value) for value in call.arguments], named, base]


def decode_values(answer: Value) -> Iterator[Value]:
    """Yield the values of the steps that a driver returned. Raises ValueError for what no driver returns."""
    if not isinstance(answer, list):
        raise ValueError("no list of values")
    for item in answer:
        yield decode_value(item)


def decode_value(value: Value) -> Value:
    """Return a value that a driver encoded. Raises ValueError for what no driver returns."""
    if isinstance(value, list):
        return [decode_value(item) for item in value]
    if not isinstance(value, tuple):
        return value
    if len(value) != 2 or not isinstance(value[0], str):
        raise ValueError("no tag")
    tag, content = value
    if tag == "o" and isinstance(content, str):
        return OpaqueObject(content[:80])
    if tag not in _DECODERS or not isinstance(content, list):
        raise ValueError("unknown tag, or no content")
    return _DECODERS[tag](content)


_DECODERS: dict[str, Callable[[list[Value]], Value]] = {
    "e": lambda names: RaisedException(next((str(name)[:80] for name in names), "Exception")),
    "b": bytes,
    "d": lambda pairs: {_to_hashable(decode_value(key)): decode_value(item) for key, item in pairs},
    "s": lambda items: {_to_hashable(decode_value(item)) for item in items},
    "t": lambda items: tuple(decode_value(item) for item in items),
    "g": lambda items: [decode_value(item) for item in items],
}


def _to_hashable(value: Value) -> Value:
    """Return a member of a set: a value that can be hashed."""
    if isinstance(value, list | dict | set | np.ndarray):
        raise ValueError("no member of a set")
    return value
