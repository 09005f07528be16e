"""Answers of a program to the probes of a declared exercise, as texts by which known mistakes are told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from hashlib import sha256

import numpy as np

from graders.core.compare.python_values import python_text
from graders.core.contract.values import Value
from graders.core.declared.declaration import DeclaredCheck, DeclaredMistake
from graders.core.declared.playing import PlayedScenario
from graders.core.syntax_trees import evaluate_literal

#: Digits by which two programs are told apart.
PROBE_DIGITS = 9
#: Relative distance of two numbers that differ by the rounding of one digit.
ROUNDING = 1e-8


def probe_answer(played: PlayedScenario) -> str:
    """Return what a program did with a probe: its values, what it printed and wrote, or its fault."""
    if played.fault is not None:
        return f"{played.fault.outcome.value} {played.fault.exception or ''}"
    written = [dict(played.written)] if played.written else []
    return python_text(_normalise_types([*played.values, played.printed, *written]), PROBE_DIGITS)


def behaviour_digest(played: Sequence[PlayedScenario]) -> str:
    """Return a short digest of what a program did with some inputs: two that did the same have the same."""
    return sha256("\n".join(map(probe_answer, played)).encode("utf-8", "replace")).hexdigest()[:16]


def find_mistake(
    mistakes: Sequence[DeclaredMistake],
    known: Mapping[str, Sequence[str]],
    answers: Sequence[str],
    checks: Sequence[DeclaredCheck],
) -> DeclaredMistake | None:
    """Return the mistake whose `known` answers are these; `checks` are those of the probes.

    Where none answers exactly so, the only one that does within the tolerances of the checks; None where several do.
    """
    exact = next((each for each in mistakes if tuple(known.get(each.id, ())) == tuple(answers)), None)
    if exact is not None:
        return exact
    near = [each for each in mistakes if _are_same_answers(known.get(each.id, ()), answers, checks)]
    return near[0] if len(near) == 1 else None


def _are_same_answers(known: Sequence[str], answers: Sequence[str], checks: Sequence[DeclaredCheck]) -> bool:
    if not len(known) == len(answers) == len(checks):
        return False
    return all(same_probe_answer(*trio) for trio in zip(checks, known, answers, strict=True))


def same_probe_answer(check: DeclaredCheck, text: str, other: str) -> bool:
    """Whether two answers are the same for a check: the same text, or values that its comparator takes for the same.

    An answer keeps `PROBE_DIGITS` digits: numbers agree at least within their rounding.
    """
    if text == other:
        return True
    try:
        values, others = evaluate_literal(text), evaluate_literal(other)
    except (ValueError, SyntaxError, RecursionError, MemoryError):  # a fault, or a value that no literal writes
        return False
    if not (isinstance(values, list) and isinstance(others, list) and len(values) == len(others)):
        return False
    same = replace(check.comparator, tolerance=max(check.comparator.tolerance, ROUNDING))
    return all(same(value, given) is None for value, given in zip(values, others, strict=True))


def _normalise_types(value: Value) -> Value:
    """Return a value in which 1.0 is 1, and a tuple or an array is a list: what comparators take for the same."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [_normalise_types(item) for item in value]
    if isinstance(value, dict):
        return {key: _normalise_types(value[key]) for key in sorted(value, key=repr)}
    return int(value) if isinstance(value, float) and value.is_integer() else value
