"""Numbers and values as a French reader writes them, and as strict JSON holds them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graders.core.contract.values import Value

MAX_ITEMS = 400
MAX_TEXT = 400
MINUS = "\N{MINUS SIGN}"
NEGLIGIBLE = 1e-13
#: An integer of more bits may be beyond every float.
_FLOAT_BITS = 1023


def to_jsonable(value: Value, *, limit: int = MAX_ITEMS) -> Any:
    """Turn a plain value into strict JSON: NaN and infinities become text, large arrays a summary.

    A number keeps all its digits, so that a counterexample can be typed in again.
    """
    if isinstance(value, np.ndarray):
        if value.size > limit:
            return {"forme": list(value.shape), "premiers": to_jsonable(value.ravel()[:12])}
        return to_jsonable(value.tolist(), limit=limit)
    if isinstance(value, np.generic):
        return to_jsonable(value.item(), limit=limit)
    if isinstance(value, dict):
        return {str(key): to_jsonable(item, limit=limit) for key, item in list(value.items())[:limit]}
    if isinstance(value, list | tuple):
        return [to_jsonable(item, limit=limit) for item in value[:limit]]
    return _scalar_to_jsonable(value)


def tidy(value: Any) -> Any:
    """JSON without the dust of rounding: 6.1e-17 and -0.0 are 0.0, 0.9999999999999999 is 1.0.

    For what is read, expected and obtained values; inputs, which may be typed in again, keep all their digits.
    """
    if isinstance(value, float):
        return 0.0 if abs(value) < NEGLIGIBLE else float(f"{value:.14g}")
    if isinstance(value, list):
        return [tidy(item) for item in value]
    return {key: tidy(item) for key, item in value.items()} if isinstance(value, dict) else value


def _scalar_to_jsonable(value: Value) -> Any:
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, int):
        return value if abs(value) < 2**53 else _cut(str(value) if value.bit_length() < 4000 else "entier immense")
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    return _cut(str(value))


def _cut(text: str) -> str:
    return text if len(text) <= MAX_TEXT else text[: MAX_TEXT - 1] + "…"


def number(value: complex, digits: int = 6) -> str:
    """A number in French: decimal comma, true minus sign, at most `digits` significant digits, π/2 by its name.

    What is below 1e-13 is the dust of rounding and reads 0.
    """
    if isinstance(value, complex):
        return f"{number(value.real, digits)} + {number(value.imag, digits)} i"
    named = _beyond(value) or _fraction_of_pi(value)
    if named is not None:
        return named
    if abs(value) < NEGLIGIBLE:
        return "0"
    text = f"{value:.{digits}g}" if not isinstance(value, int) or abs(value) >= 10**15 else str(value)
    if "e" in text:
        mantissa, exponent = text.split("e")
        text = f"{mantissa} × 10^{int(exponent)}"
    return text.replace(".", ",").replace("-", MINUS)


def _beyond(value: float) -> str | None:
    """What digits cannot say: not a number, an infinity, an integer beyond every float."""
    if isinstance(value, int) and value.bit_length() > _FLOAT_BITS:
        return f"environ {MINUS if value < 0 else ''}10^{int(value.bit_length() * math.log10(2))}"
    if math.isnan(value):
        return "nan"
    if math.isinf(value):
        return "∞" if value > 0 else f"{MINUS}∞"
    return None


def _fraction_of_pi(value: float) -> str | None:
    """« π/2 » rather than 1,5708: only for simple fractions, exact to rounding."""
    if abs(value) > 12 * math.pi:
        return None
    for denominator in (1, 2, 3, 4, 6):
        multiple = value * denominator / math.pi
        times = round(multiple)
        if times and abs(times) < 12 and abs(multiple - times) < 1e-12:
            sign = MINUS if times < 0 else ""
            top = "π" if abs(times) == 1 else f"{abs(times)}π"
            return sign + top + (f"/{denominator}" if denominator > 1 else "")
    return None


def text(value: Value, *, digits: int = 6) -> str:
    """A plain value in one readable French line; long arrays are cut."""
    if isinstance(value, np.ndarray):
        if value.size > 40:
            return f"un tableau de forme {shape_text(value.shape)}"
        return text(value.tolist(), digits=digits)
    if isinstance(value, bool | np.bool_):
        return "vrai" if value else "faux"
    if isinstance(value, int | float | complex | np.number):
        return number(value.item() if isinstance(value, np.generic) else value, digits)
    return _items_text(value, digits) if isinstance(value, list | tuple | dict) else _cut(str(value))


def _items_text(value: list[Value] | tuple[Value, ...] | dict[str, Value], digits: int) -> str:
    cut = ["…"] if len(value) > 40 else []
    if isinstance(value, dict):
        return " ; ".join([f"{k} : {text(v, digits=digits)}" for k, v in list(value.items())[:40]] + cut)
    left, right = ("[", "]") if isinstance(value, list) else ("(", ")")
    return left + " ; ".join([text(item, digits=digits) for item in value[:40]] + cut) + right


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
