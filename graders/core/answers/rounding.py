"""Whether a number that was typed is a value of which too few digits are left."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

MIN_DIGITS = 2  # of what says more than an order of magnitude
_PLAIN = re.compile(r"[-+−–]?\s*([0-9]*)(?:[.,]([0-9]*))?", re.ASCII)
_DUST = 1e-9


@dataclass(frozen=True)
class TypedDecimal:
    """A decimal number as it was typed: its value, and how many digits stand after the comma."""

    value: float
    decimals: int

    def rounds(self, value: float) -> bool:
        """Whether this is `value`, rounded or cut at the last digit that was typed."""
        unit = 10.0**-self.decimals
        rounded = abs(self.value - value) <= (0.5 + _DUST) * unit
        cut = self.value * value >= 0 and 0 <= abs(value) - abs(self.value) < unit
        return rounded or cut


def parse_decimal(raw: Any, value: float) -> TypedDecimal | None:
    """An answer that reads as `value`, where it is a decimal number of two significant digits or more."""
    match = _PLAIN.fullmatch((raw if isinstance(raw, str) else repr(raw)).strip())
    if match is None:
        return None
    whole, decimals = match[1], match[2] or ""
    return TypedDecimal(value, len(decimals)) if len((whole + decimals).lstrip("0")) >= MIN_DIGITS else None


def decimals_for(tolerance: float) -> int:
    """How many digits after the comma leave no more than `tolerance` between a value and its rounding."""
    return max(0, math.ceil(math.log10(0.5 / tolerance) - _DUST))
