"""Numbers and values as a French reader writes them, and as strict JSON holds them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any, TypeVar

import numpy as np

from graders.core.compare.python_values import is_numeric, python_text
from graders.core.contract.values import Floats, Value

#: Limits of one value: items on a level, total items as a multiple of that, characters of a text, a key, all texts.
MAX_ITEMS = 400
LEVELS = 5
MAX_TEXT = 400
MAX_KEY = 80
MAX_CHARACTERS = 40_000
#: Limits of a value written in a sentence: items on a level, items in all, characters.
LINE_ITEMS, LINE_ALL, MAX_LINE = 40, 200, 4000
MORE = "…"
MINUS = "\N{MINUS SIGN}"
NEGLIGIBLE = 1e-13
T = TypeVar("T")
#: An integer of more bits may be beyond every float.
_FLOAT_BITS = 1023


class _RemainingRoom:
    """Remaining space for one value; `cut` once something was left out."""

    def __init__(self, level: int, items: int) -> None:
        self.level, self.items = level, items
        self.characters = MAX_CHARACTERS
        self.cut = False

    def take_while_room(self, values: Iterable[T]) -> Iterator[T]:
        """Yield the values of one level while there is room."""
        for index, value in enumerate(values):
            if index >= self.level or self.items <= 0 or self.characters <= 0:
                self.cut = True
                return
            self.items -= 1
            yield value

    def cut_to_room(self, text: str, max_length: int = MAX_TEXT) -> str:
        self.cut = self.cut or len(text) > max_length
        text = _cut_text(text, max_length)
        self.characters -= len(text)
        return text


def to_jsonable(value: Value, *, limit: int = MAX_ITEMS) -> Any:
    """Turn a plain value into strict JSON: NaN and infinities become text, large arrays a summary.

    A number keeps all its digits, so that a counterexample can be typed in again. However large the value, at most
    `LEVELS` times `limit` items are written, and some tens of thousands of characters; « … » tells what is left out.
    """
    return _to_bounded_json(value, _RemainingRoom(limit, LEVELS * limit))


def to_complete_jsonable(value: Value, *, limit: int) -> Any:
    """Return `to_jsonable(value)`; None where something would be left out."""
    room = _RemainingRoom(limit, LEVELS * limit)
    written = _to_bounded_json(value, room)
    return None if room.cut else written


def _to_bounded_json(value: Value, room: _RemainingRoom) -> Any:
    if isinstance(value, np.ndarray):
        if value.size > min(room.level, room.items):
            room.cut = True
            return {
                "forme": list(value.shape),
                "premiers": [_scalar_to_json(x, room) for x in value.ravel()[:12].tolist()],
            }
        return _finite_number_row(value, room) or _to_bounded_json(value.tolist(), room)
    if isinstance(value, np.generic):
        return _to_bounded_json(value.item(), room)
    if isinstance(value, dict):
        members = room.take_while_room(value.items())
        written = {room.cut_to_room(str(key), MAX_KEY): _to_bounded_json(item, room) for key, item in members}
        return written if len(written) == len(value) else written | {MORE: MORE}
    if isinstance(value, list | tuple):
        items = [_to_bounded_json(item, room) for item in room.take_while_room(value)]
        return items if len(items) == len(value) else [*items, MORE]
    return _scalar_to_json(value, room)


def _finite_number_row(array: Floats, room: _RemainingRoom) -> list[float]:
    """Return a row of finite numbers for which there is room; [] where items must be written one by one."""
    if array.ndim != 1 or array.dtype != np.float64 or room.characters <= 0:
        return []
    items: list[float] = array.tolist()
    if not all(map(math.isfinite, items)):
        return []
    room.items -= len(items)
    return items


def remove_rounding_noise(value: Any) -> Any:
    """Return JSON without rounding noise: 6.1e-17 and -0.0 become 0.0, 0.9999999999999999 becomes 1.0.

    For expected and obtained values; inputs, which may be typed in again, keep all their digits.
    """
    if isinstance(value, float):
        return 0.0 if abs(value) < NEGLIGIBLE else float(f"{value:.14g}")
    if isinstance(value, list):
        return [remove_rounding_noise(item) for item in value]
    return {key: remove_rounding_noise(item) for key, item in value.items()} if isinstance(value, dict) else value


def _scalar_to_json(value: Value, room: _RemainingRoom) -> Any:
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, int):
        if abs(value) < 2**53:
            return value
        return room.cut_to_room(str(value) if value.bit_length() < 4000 else "entier immense")
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    return room.cut_to_room(str(value))


def _cut_text(text: str, max_length: int = MAX_TEXT) -> str:
    return text if len(text) <= max_length else text[: max_length - 1] + MORE


def number(value: complex, digits: int = 6) -> str:
    """Return a number in French: decimal comma, true minus sign, at most `digits` significant digits, π/2 by its name.

    Magnitudes below 1e-13 are rounding noise and read 0.
    """
    if isinstance(value, complex):
        return f"{number(value.real, digits)} + {number(value.imag, digits)} i"
    named = _extreme_number_text(value) or fraction_of_pi(value)
    if named is not None:
        return named
    if abs(value) < NEGLIGIBLE:
        return "0"
    text = f"{value:.{digits}g}" if not isinstance(value, int) or abs(value) >= 10**15 else str(value)
    if "e" in text:
        mantissa, exponent = text.split("e")
        text = f"{mantissa} × 10^{int(exponent)}"
    return text.replace(".", ",").replace("-", MINUS)


def _extreme_number_text(value: float) -> str | None:
    """Return the text of NaN, an infinity, or an integer beyond every float; None for other numbers."""
    if isinstance(value, int) and value.bit_length() > _FLOAT_BITS:
        return f"environ {MINUS if value < 0 else ''}10^{int(value.bit_length() * math.log10(2))}"
    if math.isnan(value):
        return "nan"
    if math.isinf(value):
        return "∞" if value > 0 else f"{MINUS}∞"
    return None


def fraction_of_pi(value: float) -> str | None:
    """« π/2 » rather than 1,5708: only for simple fractions, exact to rounding."""
    if abs(value) > 12 * math.pi or abs((twelfths := value * 12 / math.pi) - round(twelfths)) > 1e-10:
        return None  # most numbers are no twelfths of it, and are seen at once to be none of the simple fractions
    for denominator in (1, 2, 3, 4, 6):
        multiple = value * denominator / math.pi
        times = round(multiple)
        if times and abs(times) < 12 and abs(multiple - times) < 1e-12:
            sign = MINUS if times < 0 else ""
            top = "π" if abs(times) == 1 else f"{abs(times)}π"
            return sign + top + (f"/{denominator}" if denominator > 1 else "")
    return None


class NumberText(str):
    """A number that is written already, in the place of the number."""

    __slots__ = ()


def text(value: Value, *, digits: int = 6) -> str:
    """A plain value in one readable line: long arrays are cut, and so is what would make a line of a table.

    Numbers are written in French; a value that holds anything else, as Python writes it.
    """
    if not _is_written_in_french(value):
        return _cut_text(python_text(value, digits), MAX_LINE)
    room = _RemainingRoom(LINE_ITEMS, LINE_ALL)
    line = _value_text(value, digits, room)
    return _cut_text(
        line if room.items > 0 else _value_text(value, digits, _RemainingRoom(LINE_ITEMS, LINE_ITEMS)), MAX_LINE
    )


def _is_written_in_french(value: Value) -> bool:
    if isinstance(value, list | tuple):
        return all(map(_is_written_in_french, value))
    return isinstance(value, NumberText) or is_numeric(value)


def _value_text(value: Value, digits: int, room: _RemainingRoom) -> str:
    if type(value) is float:  # which most are
        return number(value, digits)
    if isinstance(value, np.ndarray):
        if value.size > LINE_ITEMS:
            return f"un tableau de forme {shape_text(value.shape)}"
        return _value_text(value.tolist(), digits, room)
    if isinstance(value, list | tuple):
        return _items_text(value, digits, room)
    if isinstance(value, NumberText):
        return room.cut_to_room(str(value))
    return number(value.item() if isinstance(value, np.generic) else value, digits)


def _items_text(value: list[Value] | tuple[Value, ...], digits: int, room: _RemainingRoom) -> str:
    pieces = [_value_text(item, digits, room) for item in room.take_while_room(value)]
    line = " ; ".join(pieces + [MORE] * (len(pieces) < len(value)))
    return f"[{line}]" if isinstance(value, list) else f"({line})"


def shape_text(shape: tuple[int, ...]) -> str:
    """A shape as numpy writes it; () is « un seul nombre »."""
    if shape == ():
        return "un seul nombre"
    if len(shape) == 1:
        return f"({shape[0]},)"
    return "(" + ", ".join(str(n) for n in shape) + ")"


def angle(value: float) -> str:
    """An angle in radians, with its degrees: « π/2 rad (90°) »."""
    return f"{number(value)} rad ({number(math.degrees(value), 4)}°)"
