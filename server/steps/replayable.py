"""Decides whether the counterexample of a failed check is a single call that can be replayed."""

from __future__ import annotations

import json
import re

from graders.core.code.checks import Untouched
from graders.core.code.grading import CodeGrader
from graders.core.compare.words import MORE
from graders.core.contract.verdict import CheckResult
from graders.core.declared.grading import DeclaredGrader
from server.course import Exercise

#: Numbers that JSON holds as text.
SPECIAL = frozenset({"nan", "inf", "-inf"})
_PARAMETERS = re.compile(r"\((.*)\)\s*$", re.DOTALL)


def can_replay(exercise: Exercise, check: CheckResult) -> bool:
    """Whether the counterexample of a check is one call of a function, with complete arguments.

    That holds where the check says so, or where its inputs are the arguments of the one function that it judges. A
    check of several functions does not say which one it called, except for checks of unmodified arguments. A declared
    exercise plays its cases again.
    """
    counterexample, grader = check.counterexample, exercise.grader
    if exercise.kind != "code" or check.passed or counterexample is None or not isinstance(grader, CodeGrader):
        return isinstance(grader, DeclaredGrader) and grader.find_failing_case(check) is not None
    graded = next((candidate for candidate in grader.checks if candidate.id == check.id), None)
    if graded is None or not _has_no_shortened_value(counterexample.inputs):
        return False
    if len(graded.functions) > 1 and not isinstance(graded, Untouched):
        return False
    if not graded.reports_call and any(map(_is_description, counterexample.inputs.values())):
        return False
    names = set(counterexample.inputs)
    parameters = [_parameter_names(exercise, function) for function in graded.functions]
    if graded.reports_call:
        return any(names & accepted for accepted, _ in parameters)
    return any(names and required <= names <= accepted for accepted, required in parameters)


def _parameter_names(exercise: Exercise, function: str) -> tuple[set[str], set[str]]:
    """Return the names of all parameters of a requested function, and of the required ones."""
    signature = next((wanted.signature for wanted in exercise.functions if wanted.name == function), "")
    inside = _PARAMETERS.search(signature)
    parts = inside[1].split(",") if inside else []
    names = {part.split("=")[0].split(":")[0].strip(" *"): "=" not in part for part in parts}
    return set(names), {name for name, required in names.items() if required}


def _is_description(value: object) -> bool:
    """Whether the value is a description (« 40 scans ») instead of the value itself."""
    return isinstance(value, str) and value not in SPECIAL


def _has_no_shortened_value(inputs: dict[str, object]) -> bool:
    """Whether no value was shortened (see `graders.core.compare.words.to_jsonable`)."""
    written = json.dumps(inputs, ensure_ascii=False)
    return f'"{MORE}"' not in written and '"premiers"' not in written and f'{MORE}"' not in written
