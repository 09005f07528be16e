"""Reading a student's signature: any array of one dimension, of finite real or complex numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.compare import words as render
from graders.core.contract.outcomes import Outcome
from graders.core.contract.values import Floats, UnreadableError, Value, holds_text, read_array

FUNCTION = "signature"
ROUNDING = 1e-5
"""Invariance is asked up to this share of what separates two places: single precision passes, no mistake does."""


@dataclass(frozen=True)
class Unsuitable:
    """A value that is no signature: why, in French, and a word for the diagnosis."""

    word: str
    message: str
    cause: Outcome = Outcome.INVALID_OUTPUT


def read_signature(value: Value) -> Floats | Unsuitable:
    """The signature as reals (k,), the real parts before the imaginary ones when it is complex."""
    try:
        array = _complex_parts(value)
    except UnreadableError as error:
        return Unsuitable("illisible", f"signature ne convient pas : {error}.")
    if array.ndim != 1:
        shape = render.shape_text(array.shape)
        return Unsuitable(f"dimension {array.ndim}", f"La forme de la signature est {shape} : il faut un tableau 1-D.")
    if array.size == 0:
        return Unsuitable("vide", "La signature est un tableau vide.")
    if not np.all(np.isfinite(array)):
        return Unsuitable("nan", "La signature contient « nan » ou un infini.", Outcome.WRONG_ANSWER)
    return array


def _complex_parts(value: Value) -> Floats:
    if holds_text(value):
        return read_array(value)
    try:
        array = np.asarray(value)
    except ValueError:
        return read_array(value)
    if array.dtype.kind != "c":
        return read_array(value)
    array = array.astype(np.complex128)
    return np.concatenate([array.real, array.imag]) if array.ndim == 1 else np.abs(array)


def is_complex(value: Value) -> bool:
    """Does a value hold numbers with an imaginary part?"""
    return bool(np.any(np.iscomplex(np.asarray(value))))


def is_mask(value: Value) -> bool:
    """Is a readable value an array of booleans, where indices are asked for?"""
    array = np.asarray(value)
    return array.size > 0 and array.dtype == np.bool_


def signature(bench: Bench, scan: Floats) -> Floats:
    """The student's signature of a scan, or a Rejection that says why it is none."""
    value = bench.call(FUNCTION, scan)
    reading = read_signature(value)
    if isinstance(reading, Unsuitable):
        bench.observe(FUNCTION, reading.word, ok=False)
        slip = {"nan": "nan", "dimension 0": "scalaire"}.get(reading.word)
        raise Rejection(
            reading.message,
            inputs={"scan": scan},
            expected="un tableau 1-D de nombres finis",
            got=value,
            slip=slip,
            cause=reading.cause,
        )
    return reading


def apart(first: Floats, other: Floats) -> float:
    """The largest gap between two signatures; infinite when their lengths differ."""
    return float(np.max(np.abs(first - other))) if first.shape == other.shape else np.inf


def tolerance(here: Floats, elsewhere: Floats) -> float:
    """What rounding may do: a share of the gap between two places, plus the precision of large components."""
    gap = apart(here, elsewhere)
    spread = gap if np.isfinite(gap) else float(np.max(np.abs(here)))
    return ROUNDING * spread + 1e-9 * float(np.max(np.abs(here))) + 1e-12


def habits(bench: Bench, scan: Floats, elsewhere: Floats) -> str:
    """How a signature that follows the heading behaves, in words that do not depend on how it was written.

    « tourne » : shifting the scan shifts it; « moyenne » : that of the mean of two scans is the mean of theirs;
    « échelle » : half the distances give the same; « tête » : its first number ignores the heading; and so on.
    """
    raw = bench.call(FUNCTION, scan)
    asked = (scan, np.roll(scan, -1), elsewhere, (scan + elsewhere) / 2.0, scan / 2.0)
    read = [read_signature(bench.call(FUNCTION, z)) for z in asked]
    known = [value for value in read if not isinstance(value, Unsuitable)]
    if len(known) < len(read) or len({value.shape for value in known}) != 1:
        return "de longueur variable"
    here, shifted, there, middle, half = known
    slack = tolerance(here, there)
    words = {
        "complexe": is_complex(raw),
        "seul": here.size == 1,
        "tourne": here.size == scan.size and apart(np.roll(here, -1), shifted) <= slack,
        "moyenne": apart(middle, (here + there) / 2.0) <= slack,
        "échelle": apart(half, here) <= slack,
        "tête": abs(here[0] - shifted[0]) <= slack,
        "tête commune": abs(here[0] - there[0]) <= slack,
    }
    return ", ".join(word for word, true in words.items() if true) or "suit le cap"
