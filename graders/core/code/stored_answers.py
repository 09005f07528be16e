"""Answers of a program in a form that is stored, compared up to the graders' tolerance, and looked up.

Equality up to a tolerance is not transitive, so that no rounding can stand for it: values are stored exactly. A lookup
is narrowed by the `structure_hash`, common to equal answers, and by `project_to_number`, which differs by less than
`PROJECTION_TOLERANCE` between equal answers.
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

#: An array of numbers, a word for anything else, or a tuple of these.
StoredAnswer: TypeAlias = "Floats | str | tuple[StoredAnswer, ...]"

#: Numbers and words of one stored answer; no right answer of the course has as many.
MAX_ITEMS = 2000
#: The same for all answers of a program together; later answers count as too large.
MAX_TOTAL_ITEMS = 10_000
#: Characters of a word; a digest beyond.
MAX_WORD = 200
TOO_LARGE = "trop grand"
#: Bound of the distance between the projections of equal answers: less than twice the tolerance.
PROJECTION_TOLERANCE = 1e-6
#: Substitutes of numbers that are not finite, in a projection.
_ODD = {"nan": 3.0, "inf": 1000.0, "-inf": -1000.0}


class _TooLarge(Exception):
    """An answer exceeds the stored size."""


def to_stored_answer(answer: ProbeAnswer) -> StoredAnswer:
    """Return the stored form of an answer; never raises for a value of a program."""
    try:
        return _to_stored_form(answer, [MAX_ITEMS])
    except _TooLarge:
        return TOO_LARGE


def truncate_answers(answers: Sequence[StoredAnswer], max_items: int = MAX_TOTAL_ITEMS) -> tuple[StoredAnswer, ...]:
    """Return the answers, with TOO_LARGE in place of those beyond the total size."""
    stored: list[StoredAnswer] = []
    for answer in answers:
        max_items -= 1 + sum(array.size for array in _iter_arrays(answer))
        stored.append(answer if max_items >= 0 else TOO_LARGE)
    return tuple(stored)


def _to_stored_form(answer: ProbeAnswer, budget: list[int]) -> StoredAnswer:
    _consume_budget(budget, 1)
    if isinstance(answer, ProbeFault):
        return _truncate_word(f"faute {answer.name}")
    if answer is None or isinstance(answer, str):
        return "rien" if answer is None else _truncate_word(f"texte {answer}")
    if isinstance(answer, dict):
        return (
            _truncate_word("dictionnaire " + ", ".join(map(str, answer))),
            *(_to_stored_form(item, budget) for item in answer.values()),
        )
    try:
        array = read_array(answer)
    except UnreadableError:
        if isinstance(answer, list | tuple):
            return tuple(_to_stored_form(item, budget) for item in answer)
        return _truncate_word(
            f"{type(answer).__name__} {answer!r}" if isinstance(answer, complex) else type(answer).__name__
        )
    _consume_budget(budget, array.size)
    return array


def _consume_budget(budget: list[int], items: int) -> None:
    budget[0] -= items
    if budget[0] < 0:
        raise _TooLarge


def _truncate_word(text: str) -> str:
    if len(text) <= MAX_WORD:
        return text
    return f"{text[:MAX_WORD]}… {hashlib.sha256(text.encode(errors='replace')).hexdigest()}"


def same_answer(first: StoredAnswer, second: StoredAnswer, tolerance: float = TOLERANCE) -> bool:
    """Whether two answers are equal, numbers up to the tolerance."""
    if isinstance(first, str) or isinstance(second, str):
        return isinstance(first, str) and isinstance(second, str) and first == second
    if isinstance(first, tuple) or isinstance(second, tuple):
        return isinstance(first, tuple) and isinstance(second, tuple) and same_answers(first, second, tolerance)
    return same_value(first, second, tolerance=tolerance)


def same_answers(first: Sequence[StoredAnswer], second: Sequence[StoredAnswer], tolerance: float = TOLERANCE) -> bool:
    """Whether two sequences of answers are equal, numbers up to the tolerance."""
    return len(first) == len(second) and all(same_answer(a, b, tolerance) for a, b in zip(first, second, strict=True))


def structure_hash(answers: Sequence[StoredAnswer]) -> str:
    """Return a hash of the words and array shapes of the answers, equal for equal answers: 64 characters."""
    return hashlib.sha256(json.dumps(_to_json_value(tuple(answers), values=False)).encode(errors="replace")).hexdigest()


def project_to_number(answers: Sequence[StoredAnswer]) -> float:
    """Map the answers to one number; for equal answers, less than `PROJECTION_TOLERANCE` apart.

    asinh moves by less than √2 times the tolerance between two numbers that are the same, and so does a mean of them.
    """
    numbers = [array.ravel() for array in _iter_arrays(tuple(answers))]
    if not numbers:
        return 0.0
    all_of_them = np.concatenate(numbers)
    if not all_of_them.size:
        return 0.0
    named = np.nan_to_num(np.arcsinh(all_of_them), nan=_ODD["nan"], posinf=_ODD["inf"], neginf=_ODD["-inf"])
    return float(np.mean(named * np.cos(np.arange(named.size))))


def _iter_arrays(value: StoredAnswer) -> Iterator[Floats]:
    if isinstance(value, tuple):
        for item in value:
            yield from _iter_arrays(item)
    elif isinstance(value, np.ndarray):
        yield value


def serialize_answers(answers: Sequence[StoredAnswer]) -> bytes:
    """Return the answers as compressed JSON, numbers exactly."""
    return zlib.compress(json.dumps(_to_json_value(tuple(answers), values=True)).encode(errors="replace"), 1)


def deserialize_answers(data: bytes) -> tuple[StoredAnswer, ...]:
    """Return the answers that `serialize_answers` encoded."""
    read = _from_json_value(json.loads(zlib.decompress(data)))
    assert isinstance(read, tuple), "answers are packed as a list"
    return read


def _to_json_value(value: StoredAnswer, *, values: bool) -> Any:
    if isinstance(value, str):
        return value
    if isinstance(value, tuple):
        return [_to_json_value(item, values=values) for item in value]
    encoded = base64.b64encode(value.astype("<f8").tobytes()).decode() if values else ""
    return {"shape": list(value.shape), "values": encoded}


def _from_json_value(value: Any) -> StoredAnswer:
    if isinstance(value, str):
        return value
    if isinstance(value, list):
        return tuple(map(_from_json_value, value))
    numbers = np.frombuffer(base64.b64decode(value["values"]), dtype="<f8")
    return numbers.astype(np.float64).reshape(value["shape"])
