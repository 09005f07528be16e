"""What a program answered, in a form that can be kept, compared up to the tolerance of the graders, and looked up.

Equality up to a tolerance is not transitive, so that no rounding can stand for it: values are kept as they are. What
narrows a search is a `structure`, which equal answers share, and a `projection`, which moves less than `NEAR` between
answers that are the same.
"""

from __future__ import annotations

import base64
import hashlib
import json
import zlib
from collections.abc import Iterator, Sequence
from typing import Any, TypeAlias

import numpy as np

from graders.core.code.probes import TOLERANCE, ProbeAnswer, ProbeFault
from graders.core.contract.values import Floats, UnreadableError, read_array, same_value

#: Numbers in an array, a word for what is no number, or several of these.
StoredAnswer: TypeAlias = "Floats | str | tuple[StoredAnswer, ...]"

#: Numbers and words of one answer that are kept: no right one of the course has as many.
MAX_ITEMS = 2000
#: The same of all answers of a program together: those that come after are too large.
MAX_TOTAL_ITEMS = 10_000
#: Characters of a word; a digest beyond.
MAX_WORD = 200
TOO_LARGE = "trop grand"
#: How far apart the projections of two answers that are the same may be, which is less than twice the tolerance.
PROJECTION_TOLERANCE = 1e-6
#: What stands in a projection for what is no finite number.
_ODD = {"nan": 3.0, "inf": 1000.0, "-inf": -1000.0}


class _TooLarge(Exception):
    """More than is kept of one answer."""


def to_stored(shown: ProbeAnswer) -> StoredAnswer:
    """An answer as it is kept; it never raises for what a program returned."""
    try:
        return _plain(shown, [MAX_ITEMS])
    except _TooLarge:
        return TOO_LARGE


def truncate_answers(answers: Sequence[StoredAnswer], most: int = MAX_TOTAL_ITEMS) -> tuple[StoredAnswer, ...]:
    """The same answers, as far as all of them together may be kept."""
    kept: list[StoredAnswer] = []
    for answer in answers:
        most -= 1 + sum(array.size for array in _arrays(answer))
        kept.append(answer if most >= 0 else TOO_LARGE)
    return tuple(kept)


def _plain(shown: ProbeAnswer, room: list[int]) -> StoredAnswer:
    _take(room, 1)
    if isinstance(shown, ProbeFault):
        return _word(f"faute {shown.name}")
    if shown is None or isinstance(shown, str):
        return "rien" if shown is None else _word(f"texte {shown}")
    if isinstance(shown, dict):
        return (_word("dictionnaire " + ", ".join(map(str, shown))), *(_plain(one, room) for one in shown.values()))
    try:
        array = read_array(shown)
    except UnreadableError:
        if isinstance(shown, list | tuple):
            return tuple(_plain(one, room) for one in shown)
        return _word(f"{type(shown).__name__} {shown!r}" if isinstance(shown, complex) else type(shown).__name__)
    _take(room, array.size)
    return array


def _take(room: list[int], items: int) -> None:
    room[0] -= items
    if room[0] < 0:
        raise _TooLarge


def _word(text: str) -> str:
    if len(text) <= MAX_WORD:
        return text
    return f"{text[:MAX_WORD]}… {hashlib.sha256(text.encode(errors='replace')).hexdigest()}"


def same_answer(one: StoredAnswer, other: StoredAnswer, tolerance: float = TOLERANCE) -> bool:
    """The same answer, numbers up to the tolerance."""
    if isinstance(one, str) or isinstance(other, str):
        return isinstance(one, str) and isinstance(other, str) and one == other
    if isinstance(one, tuple) or isinstance(other, tuple):
        return isinstance(one, tuple) and isinstance(other, tuple) and same_answers(one, other, tolerance)
    return same_value(one, other, tolerance=tolerance)


def same_answers(one: Sequence[StoredAnswer], other: Sequence[StoredAnswer], tolerance: float = TOLERANCE) -> bool:
    """The same answers in the same order."""
    return len(one) == len(other) and all(same_answer(a, b, tolerance) for a, b in zip(one, other, strict=True))


def structure_hash(answers: Sequence[StoredAnswer]) -> str:
    """What answers that are the same have in common: their words, and the shapes of their arrays. 64 characters."""
    return hashlib.sha256(json.dumps(_jsonable(tuple(answers), values=False)).encode(errors="replace")).hexdigest()


def projection(answers: Sequence[StoredAnswer]) -> float:
    """One number for all that the answers hold; of answers that are the same, less than `NEAR` apart.

    asinh moves by less than √2 times the tolerance between two numbers that are the same, and so does a mean of them.
    """
    numbers = [array.ravel() for array in _arrays(tuple(answers))]
    if not numbers:
        return 0.0
    all_of_them = np.concatenate(numbers)
    if not all_of_them.size:
        return 0.0
    named = np.nan_to_num(np.arcsinh(all_of_them), nan=_ODD["nan"], posinf=_ODD["inf"], neginf=_ODD["-inf"])
    return float(np.mean(named * np.cos(np.arange(named.size))))


def _arrays(value: StoredAnswer) -> Iterator[Floats]:
    if isinstance(value, tuple):
        for one in value:
            yield from _arrays(one)
    elif isinstance(value, np.ndarray):
        yield value


def serialize_answers(answers: Sequence[StoredAnswer]) -> bytes:
    """The answers as bytes, every number whole."""
    return zlib.compress(json.dumps(_jsonable(tuple(answers), values=True)).encode(errors="replace"), 1)


def deserialize_answers(data: bytes) -> tuple[StoredAnswer, ...]:
    """What `packed` made."""
    read = _read(json.loads(zlib.decompress(data)))
    assert isinstance(read, tuple), "answers are packed as a list"
    return read


def _jsonable(value: StoredAnswer, *, values: bool) -> Any:
    if isinstance(value, str):
        return value
    if isinstance(value, tuple):
        return [_jsonable(one, values=values) for one in value]
    held = base64.b64encode(value.astype("<f8").tobytes()).decode() if values else ""
    return {"shape": list(value.shape), "values": held}


def _read(value: Any) -> StoredAnswer:
    if isinstance(value, str):
        return value
    if isinstance(value, list):
        return tuple(map(_read, value))
    numbers = np.frombuffer(base64.b64decode(value["values"]), dtype="<f8")
    return numbers.astype(np.float64).reshape(value["shape"])
