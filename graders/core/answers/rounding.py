"""Recognition of a typed number as a value rounded to too few digits."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

MIN_DIGITS = 2  # significant digits: fewer give an order of magnitude only
_PLAIN = re.compile(r"[-+−–]?\s*([0-9]*)(?:[.,]([0-9]*))?", re.ASCII)
_DUST = 1e-9


@dataclass(frozen=True)
class TypedDecimal:
    """A typed decimal number: its value, and the number of digits after the comma."""

    value: float
    decimals: int

    def is_rounding_of(self, value: float) -> bool:
        """Whether this is `value`, rounded or truncated at the last typed digit."""
        unit = 10.0**-self.decimals
        rounded = abs(self.value - value) <= (0.5 + _DUST) * unit
        cut = self.value * value >= 0 and 0 <= abs(value) - abs(self.value) < unit
        return rounded or cut


def parse_decimal(raw: Any, value: float) -> TypedDecimal | None:
    """Return an answer with the given value as a TypedDecimal; None unless it is one of two significant digits."""
    match = _PLAIN.fullmatch((raw if isinstance(raw, str) else repr(raw)).strip())
    if match is None:
        return None
    whole, decimals = match[1], match[2] or ""
    return TypedDecimal(value, len(decimals)) if len((whole + decimals).lstrip("0")) >= MIN_DIGITS else None


def decimals_for(tolerance: float) -> int:
    """Return the number of decimals whose rounding error is at most `tolerance`."""
    return max(0, math.ceil(math.log10(0.5 / tolerance) - _DUST))
