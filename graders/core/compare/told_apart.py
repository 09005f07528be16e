"""Two values shown together, such as expected and obtained: as many digits as tell them apart, and by how little.

A number written with a fixed count of digits may hide the very difference that it is shown for.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np

from graders.core.compare.python_values import is_numeric, python_text_pair
from graders.core.compare.words import MINUS, NumberText, fraction_of_pi, number, remove_rounding_noise, text
from graders.core.contract.values import Value

DIGITS, MOST_DIGITS = 6, 17
#: Numbers nearer than this, relative or absolute, differ by the rounding of a computation.
NOISE = 1e-12
#: Numbers nearer than this, relative or absolute, look alike.
NEAR = 1e-5
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_LARGEST = 40
_LONGEST_INT = 256
_TYPES = {bool: "booléen", int: "entier", float: "flottant", complex: "complexe"}


def number_text_pair(value: complex, other: complex, digits: int = DIGITS) -> tuple[str, str]:
    """Return two numbers in French: `digits` digits, or as many more as their texts need to differ.

    Equal numbers are told apart by the sign of zero, else by their types, else not at all.
    """
    kinds = type(value), type(other)
    value, other = _to_python_number(value), _to_python_number(other)
    texts = number(value, digits), number(other, digits)
    if _is_nan(value) or _is_nan(other) or (texts[0] != texts[1] and not _are_written_alike(value, other)):
        return texts
    if value == other:
        return _pair_with_types(value, other, texts[0], kinds)
    names = tuple(None if isinstance(it, complex) else fraction_of_pi(it) for it in (value, other))
    counts = range(max(digits, 1), MOST_DIGITS + 1)
    written = [(_number_with_digits(value, count), _number_with_digits(other, count)) for count in counts]
    # Two roundings may differ, and those with a digit more be alike: the pair after a pair that differs shows the gap.
    shown = [pair for before, pair in pairwise(written) if before[0] != before[1] and pair[0] != pair[1]]
    texts = shown[0] if shown else written[-1]
    if names[0] != names[1]:
        left, right = (f"{name} ≈ {it}" if name else it for name, it in zip(names, texts, strict=True))
        return left, right
    return texts[0], texts[1]


def angle_text_pair(value: float, other: float) -> tuple[str, str]:
    """Return two angles in radians with their degrees: « π/2 rad (90°) »."""
    radians, degrees = number_text_pair(value, other), number_text_pair(math.degrees(value), math.degrees(other), 4)
    first, second = (f"{rad} rad ({deg}°)" for rad, deg in zip(radians, degrees, strict=True))
    return first, second


def value_text_pair(value: Value, other: Value, *, digits: int = DIGITS) -> tuple[str, str]:
    """Return two plain values as lines: each number beside its counterpart has the digits that tell them apart."""
    if not (is_numeric(value) and is_numeric(other)):
        texts = text(value, digits=digits), text(other, digits=digits)
        return texts if texts[0] != texts[1] else python_text_pair(value, other, digits)
    texts = text(value, digits=digits), text(other, digits=digits)
    for noise in (NOISE, 0.0):
        left, right = _pair_values(value, other, digits, noise)
        texts = text(left, digits=digits), text(right, digits=digits)
        if texts[0] != texts[1]:
            break
    return texts


def remove_noise_from_pair(expected: Any, got: Any) -> tuple[Any, Any]:
    """Return two JSON values without rounding noise, unless it is the only difference of the two."""
    tidied = remove_rounding_noise(expected), remove_rounding_noise(got)
    return (expected, got) if tidied[0] == tidied[1] and expected != got else tidied


def gap_text(expected: float, got: float) -> str:
    """« à 4·10⁻⁹ près », with the usual cause where the numbers show it; empty unless they look alike."""
    gap = abs(got - expected)
    if not 0.0 < gap <= NEAR * max(1.0, abs(expected)):
        return ""
    mantissa, exponent = f"{gap:.0e}".split("e")
    cause = _difference_cause_text(expected, got)
    return f"à {mantissa}·10{str(int(exponent)).translate(_SUPERSCRIPTS)} près{f', {cause}' if cause else ''}"


def got_instead_of_expected_text(expected: float, got: float, digits: int = DIGITS) -> str:
    """« 0,9999991 au lieu de 1 (à 9·10⁻⁷ près) »."""
    wanted, obtained = number_text_pair(expected, got, digits)
    gap = gap_text(expected, got)
    return f"{obtained} au lieu de {wanted}{f' ({gap})' if gap else ''}"


def angle_instead_of_expected_text(expected: float, got: float) -> str:
    """« −2,14159266 rad (−122,7°) au lieu de −2,14159265 rad (…) (à 7·10⁻⁹ près) »."""
    wanted, obtained = angle_text_pair(expected, got)
    gap = gap_text(expected, got)
    return f"{obtained} au lieu de {wanted}{f' ({gap})' if gap else ''}"


def are_within_tolerance(value: complex, other: complex, tolerance: float) -> bool:
    """Whether two numbers are equal within a relative or absolute tolerance; however large, and never for NaN."""
    try:
        return bool(value == other or abs(value - other) <= tolerance * max(1.0, abs(value)))
    except OverflowError:  # integers beyond every float
        return False


def _to_python_number(value: complex) -> complex | float | int:
    return value.item() if isinstance(value, np.generic) else value


def _is_nan(value: complex) -> bool:
    return isinstance(value, float) and math.isnan(value)


def _are_written_alike(value: complex, other: complex) -> bool:
    """Whether two numbers are too near for six digits, although one of them may be named as a fraction of π."""
    return not isinstance(value, complex) and not isinstance(other, complex) and are_numbers_written_alike(value, other)


def are_numbers_written_alike(value: float, other: float) -> bool:
    """Whether two numbers are written alike with six digits."""
    return _number_with_digits(value, DIGITS) == _number_with_digits(other, DIGITS)


def _number_with_digits(value: complex, digits: int) -> str:
    """Return a number with that many digits, whatever its size, and without a name."""
    if isinstance(value, complex):
        return f"{_number_with_digits(value.real, digits)} + {_number_with_digits(value.imag, digits)} i"
    if isinstance(value, int) and value.bit_length() < _LONGEST_INT:
        return str(value).replace("-", MINUS)
    if isinstance(value, int) or not math.isfinite(value):
        return number(value, digits)
    written = f"{value:.{digits}g}"
    if "e" in written:
        mantissa, exponent = written.split("e")
        written = f"{mantissa} × 10^{int(exponent)}"
    return written.replace(".", ",").replace("-", MINUS)


def _pair_with_types(value: complex, other: complex, same: str, kinds: tuple[type, type]) -> tuple[str, str]:
    if isinstance(value, float) and isinstance(other, float) and math.copysign(1, value) != math.copysign(1, other):
        return (f"{MINUS}0,0", "0,0") if math.copysign(1, value) < 0 else ("0,0", f"{MINUS}0,0")
    if kinds[0] is kinds[1]:
        return same, same
    first, second = (_TYPES.get(kind, kind.__name__) for kind in kinds)
    return f"{same} ({first})", f"{same} ({second})"


def _is_number(value: Value) -> bool:
    return isinstance(value, int | float | complex | np.number) and not isinstance(value, bool)


def _pair_values(value: Any, other: Any, digits: int, noise: float) -> tuple[Any, Any]:
    """Return both values with the texts of those numbers that need digits of their own in the place of these."""
    value, other = (it.tolist() if isinstance(it, np.ndarray) and it.size <= _LARGEST else it for it in (value, other))
    if _is_number(value) and _is_number(other):
        if are_within_tolerance(value, other, noise):
            return value, other
        first, second = number_text_pair(value, other, digits)
        return NumberText(first), NumberText(second)
    if isinstance(value, list | tuple) and isinstance(other, list | tuple) and len(value) == len(other):
        both = [_pair_values(left, right, digits, noise) for left, right in zip(value, other, strict=True)]
        return type(value)(left for left, _ in both), type(other)(right for _, right in both)
    return value, other


def _difference_cause_text(expected: float, got: float) -> str:
    """Return what may have made the difference of two numbers that look alike; empty where nothing shows it."""
    gap = abs(got - expected)
    if gap <= NOISE * max(1.0, abs(expected)):
        return "par les arrondis du calcul"
    for decimals in range(2, 13):
        factor = 10**decimals
        for pi in (round(math.pi, decimals), math.floor(math.pi * factor) / factor):
            times = gap / abs(math.pi - pi)
            if 0.5 <= times <= 4.5 and abs(2 * times - round(2 * times)) < 1e-3:
                return f"comme si π valait {_number_with_digits(pi, decimals + 1)} : np.pi a tous ses chiffres"
    if got == float(np.float32(expected)):
        return "comme en simple précision (float32)"
    for decimals in range(2, 12):
        if abs(got - round(expected, decimals)) <= NOISE * max(1.0, abs(expected)):
            return f"comme arrondi à {decimals} décimales"
    return ""
