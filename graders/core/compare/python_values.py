"""Values as Python writes them: texts with their quotes, dictionaries with their braces, True, None.

Numbers and arrays of numbers are read as a French reader writes them (`words`); whatever holds anything else is shown
in the notation in which the student typed it.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from typing import Any

import numpy as np

from graders.core.contract.values import Value
from graders.core.syntax_trees import evaluate_literal

MORE = "…"
#: Bounds of one line: items on a level, items in all, characters of one text, depth.
LEVEL_ITEMS, ALL_ITEMS, TEXT_CHARACTERS, MAX_DEPTH = 40, 200, 300, 30
#: Characters of a text that is read as Python.
MAX_PYTHON_TEXT = 4000
#: Significant digits of a number in a line.
DIGITS = 6
#: An integer of more bits is described by its size: writing it would take quadratic time.
MAX_BITS = 4000


class OpaqueObject(str):
    """The name of a type whose objects cannot be sent, such as « Pile »; written « un objet Pile »."""

    __slots__ = ()


class RaisedException(str):
    """The name of an exception that a call raised, such as « ValueError »; a value like any other for a comparator."""

    __slots__ = ()


def is_numeric(value: Value) -> bool:
    """Whether a value is a number, or nested lists, tuples and arrays of numbers alone."""
    if isinstance(value, np.ndarray):
        return value.dtype.kind in "iufcO"
    if isinstance(value, list | tuple):
        return all(map(is_numeric, value))
    return isinstance(value, int | float | complex | np.number) and not isinstance(value, bool | np.bool_)


def python_text(value: Value, digits: int | None = DIGITS) -> str:
    """Return a value in Python's notation, in one line; what is too long is cut at « … ».

    `digits` are the significant digits of a number; None keeps them all.
    """
    return _write_value(value, _LineBudget(digits), 1)


def python_text_pair(value: Value, other: Value, digits: int = DIGITS) -> tuple[str, str]:
    """Return two values in Python's notation, with as many digits as tell them apart, else with their types."""
    for count in (digits, None):
        texts = python_text(value, count), python_text(other, count)
        if texts[0] != texts[1]:
            return texts
    if type(value) is type(other):
        return texts
    return f"{texts[0]} ({type(value).__name__})", f"{texts[1]} ({type(other).__name__})"


class _LineBudget:
    """The remaining items of one line, and the digits of its numbers."""

    def __init__(self, digits: int | None) -> None:
        self.digits, self.items = digits, ALL_ITEMS


def _write_value(value: Value, room: _LineBudget, depth: int) -> str:
    room.items -= 1
    if room.items < 0 or depth > MAX_DEPTH:
        return MORE
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, np.ndarray):
        items = _write_value(value.tolist(), room, depth + 1) if value.size <= LEVEL_ITEMS else ""
        return f"array({items})" if items else f"un tableau de forme {value.shape}"
    if isinstance(value, int | float | complex) and not isinstance(value, bool):
        return _number_text(value, room.digits)
    return (
        _container_text(value, room, depth)
        if isinstance(value, Iterable) and not _is_text_or_bytes(value)
        else _simple_value_text(value)
    )


def _is_text_or_bytes(value: Value) -> bool:
    return isinstance(value, str | bytes)


def _simple_value_text(value: Value) -> str:
    """Return a value without parts: a text, True, None, or the name of what cannot be shown."""
    if isinstance(value, OpaqueObject):
        return f"un objet {value}"
    if isinstance(value, RaisedException):
        return f"l’exception {value}"
    if _is_text_or_bytes(value):
        return _quote_text(value)
    return repr(value) if value is None or isinstance(value, bool) else f"un objet {type(value).__name__}"


def _container_text(value: Any, room: _LineBudget, depth: int) -> str:
    if isinstance(value, dict):
        pairs = (
            f"{_write_value(key, room, depth + 1)}: {_write_value(item, room, depth + 1)}"
            for key, item in value.items()
        )
        return "{" + _join_items(pairs, value) + "}"
    if isinstance(value, set | frozenset):
        members = sorted(value, key=lambda member: (type(member).__name__, repr(member)))
        return (
            "{" + _join_items((_write_value(item, room, depth + 1) for item in members), value) + "}"
            if value
            else "set()"
        )
    if isinstance(value, list | tuple):
        items = _join_items((_write_value(item, room, depth + 1) for item in value), value)
        if isinstance(value, list):
            return f"[{items}]"
        return f"({items},)" if len(value) == 1 else f"({items})"
    return f"un objet {type(value).__name__}"


def _join_items(items: Iterable[str], whole: Collection[Any]) -> str:
    shown = [text for _, text in zip(range(LEVEL_ITEMS), items, strict=False)]
    return ", ".join([*shown, MORE] if len(shown) < len(whole) else shown)


def _quote_text(value: str | bytes) -> str:
    if len(value) <= TEXT_CHARACTERS:
        return repr(value)
    return f"{value[:TEXT_CHARACTERS]!r}{MORE} ({len(value)} caractères)"


def _number_text(value: complex, digits: int | None) -> str:
    if isinstance(value, int):
        return str(value) if value.bit_length() < MAX_BITS else "un entier immense"
    if digits is None:
        return repr(value)
    if isinstance(value, complex):
        return repr(complex(_round_to_digits(value.real, digits), _round_to_digits(value.imag, digits)))
    return repr(_round_to_digits(value, digits))


def _round_to_digits(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}") if math.isfinite(value) else value


def needs_quotes(value: Value) -> bool:
    """Whether a counterexample holds this value by its Python text, as strict JSON cannot: a text would be taken for a
    sentence, and JSON has no bytes, set, complex number, nor key that is no text."""
    if isinstance(value, str | bytes | set | frozenset | complex):
        return True
    if isinstance(value, dict):
        return any(not isinstance(key, str) or _is_beyond_json(item) for key, item in value.items())
    return isinstance(value, list | tuple) and any(map(_is_beyond_json, value))


def _is_beyond_json(value: Value) -> bool:
    return needs_quotes(value) and type(value) is not str


def to_counterexample_value(value: Value) -> Value:
    """Return a value as a counterexample holds it: itself, or its Python text (see `needs_quotes`)."""
    return python_text(value, None) if needs_quotes(value) else value


def is_python_text(text: str) -> bool:
    """Whether a text of a counterexample is a value's Python text, and no sentence."""
    if not text.startswith(("'", '"', "b'", 'b"', "{", "[", "(", "set(")) or len(text) > MAX_PYTHON_TEXT:
        return False
    if text == "set()":
        return True
    try:
        evaluate_literal(text)
    except (ValueError, SyntaxError, RecursionError, MemoryError):
        return False
    return True


def restore_numbers(value: Any) -> Any:
    """Return JSON with NaN and the infinities, which it holds as texts, as numbers again."""
    if isinstance(value, dict):
        return {key: restore_numbers(item) for key, item in value.items()}
    if isinstance(value, list):
        return [restore_numbers(item) for item in value]
    return float(value) if isinstance(value, str) and value in ("nan", "inf", "-inf") else value
