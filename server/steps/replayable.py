"""Which failed checks show one call, which can be made again: asked before it is offered, by all that offers it."""

from __future__ import annotations

import json
import re

from graders.core.code.checks import Untouched
from graders.core.code.grading import CodeGrader
from graders.core.compare.words import MORE
from graders.core.contract.verdict import CheckResult
from server.course import Exercise

#: The numbers that JSON tells as text.
SPECIAL = frozenset({"nan", "inf", "-inf"})
_PARAMETERS = re.compile(r"\((.*)\)\s*$", re.DOTALL)


def can_replay(exercise: Exercise, check: CheckResult) -> bool:
    """Whether what a check of a verdict shows is one call of a function, with its arguments whole.

    So it is where the check says so, or where what it gives are arguments of the one function that it judges. A check
    of several functions does not say which of them it called, but for one of arguments that must stay as they are.
    """
    shown, grader = check.counterexample, exercise.grader
    if exercise.kind != "code" or check.passed or shown is None or not isinstance(grader, CodeGrader):
        return False
    found = next((one for one in grader.checks if one.id == check.id), None)
    if found is None or not _is_whole(shown.inputs):
        return False
    if len(found.functions) > 1 and not isinstance(found, Untouched):
        return False
    if not found.tells_call and any(map(_is_described, shown.inputs.values())):
        return False
    names = set(shown.inputs)
    parameters = [_parameters(exercise, function) for function in found.functions]
    if found.tells_call:
        return any(names & known for known, _ in parameters)
    return any(names and required <= names <= known for known, required in parameters)


def _parameters(exercise: Exercise, function: str) -> tuple[set[str], set[str]]:
    """The names of the arguments of a function that is asked for, and of those that must be given."""
    signature = next((one.signature for one in exercise.functions if one.name == function), "")
    inside = _PARAMETERS.search(signature)
    parts = inside[1].split(",") if inside else []
    names = {part.split("=")[0].split(":")[0].strip(" *"): "=" not in part for part in parts}
    return set(names), {name for name, required in names.items() if required}


def _is_described(value: object) -> bool:
    """Whether words stand for the value (« 40 scans »), and not the value itself."""
    return isinstance(value, str) and value not in SPECIAL


def _is_whole(inputs: dict[str, object]) -> bool:
    """Whether nothing was left out of them (see `graders.core.compare.words.to_jsonable`)."""
    written = json.dumps(inputs, ensure_ascii=False)
    return f'"{MORE}"' not in written and '"premiers"' not in written and f'{MORE}"' not in written
