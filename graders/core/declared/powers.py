"""Powers of small numbers, as they are written in a case: 2 ** 0.5, 10 ** -3."""

from __future__ import annotations

from graders.core.contract.values import Value

#: Bounds of the size of a base and of its exponent: an integer has at most some 1,300 bits.
MAX_BASE, MAX_EXPONENT = 1_000_000, 64
TOO_LARGE = f"« ** » se lit ici jusqu’à un million à la puissance {MAX_EXPONENT}"


def bounded_power(base: Value, exponent: Value) -> Value:
    """Return a power of two numbers; None beyond the bounds, or where it has no value."""
    if isinstance(exponent, complex) or abs(base) > MAX_BASE or abs(exponent) > MAX_EXPONENT:
        return None
    try:
        return base**exponent
    except ArithmeticError:
        return None
