"""Size limit of a verdict with its figures: the excess is cut, and the verdict says so.

Each shown value has a limit of its own (`compare.words`); this is the limit of the whole, for everything that is
recorded or printed. Honest submissions stay far below (82 KiB at most in the course, figures included) and are
unchanged.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from graders.core.contract.films import drop_heaviest_films
from graders.core.contract.findings import Judgement
from graders.core.contract.verdict import CheckResult, Counterexample

#: Bytes of a verdict and of its figures' data together, as JSON that escapes what is not ASCII: its longest form.
VERDICT_BYTES = 256 * 1024
#: Bytes reserved for the note of a cut, for each part that may be cut.
_WORDS = 200
_NO_DRAWING = "Le dessin de ce cas serait trop volumineux : il n’est pas montré."


def json_size(value: Any) -> int:
    """Return the number of bytes of a value as strict JSON."""
    return len(json.dumps(value, allow_nan=False))


def limit_size(judgement: Judgement, max_bytes: int = VERDICT_BYTES) -> Judgement:
    """Return the judgement within `max_bytes`: the largest values, messages, figures and prints are cut.

    All parts above the highest possible level are cut to that level, so that small parts stay complete. Films have a
    limit of their own.
    """
    films = drop_heaviest_films(judgement.films)
    if len(films) < len(judgement.films):
        judgement = replace(judgement, films=films)
    verdict = judgement.verdict
    whole = json_size(verdict.to_json()) + json_size(judgement.figures)
    if whole <= max_bytes:
        return judgement
    parts = [*_cuttable_values(verdict.checks), *judgement.figures.values(), verdict.stdout]
    weights = [json_size(part) for part in parts]
    level = _highest_fitting_level(weights, max_bytes - (whole - sum(weights)) - _WORDS * len(parts))
    figures = {name: data for name, data in judgement.figures.items() if json_size(data) <= level}
    checks = [_cut_check_result(check, level, figures) for check in verdict.checks]
    return Judgement(replace(verdict, checks=checks, stdout=_cut_text(verdict.stdout, level)), figures, films)


def _highest_fitting_level(weights: Sequence[int], room: int) -> int:
    """Return the highest level at which the sizes, each cut to it, fit into the room together."""
    for index, heaviest in enumerate(ordered := sorted(weights)):
        share = max(room, 0) // (len(ordered) - index)
        if heaviest > share:
            return share
        room -= heaviest
    return max(weights, default=0)


def _cuttable_values(checks: Sequence[CheckResult]) -> list[Any]:
    """Return the parts of the checks that may be large."""
    counterexamples = [check.counterexample for check in checks if check.counterexample is not None]
    values = [
        value
        for counterexample in counterexamples
        for value in (*counterexample.inputs.values(), counterexample.expected, counterexample.got)
    ]
    return [check.message for check in checks] + values


def _cut_check_result(check: CheckResult, level: int, figures: dict[str, Any]) -> CheckResult:
    lost = check.figure is not None and check.figure not in figures
    message = _cut_text(check.message, level)
    return replace(
        check,
        message=f"{message} {_NO_DRAWING}".strip() if lost else message,
        counterexample=check.counterexample
        and _map_counterexample_values(check.counterexample, lambda value: _cut_value(value, level)),
        figure=None if lost else check.figure,
    )


def _map_counterexample_values(counterexample: Counterexample, light: Callable[[Any], Any]) -> Counterexample:
    inputs = {name: light(value) for name, value in counterexample.inputs.items()}
    return Counterexample(inputs, light(counterexample.expected), light(counterexample.got))


def _cut_value(value: Any, level: int) -> Any:
    if json_size(value) <= level:
        return value
    return _cut_text(value, level) if isinstance(value, str) else "valeur trop longue pour être montrée ici"


def _cut_text(text: str, level: int) -> str:
    """Return the beginning of a text within `level` bytes, followed by a note of its full length."""
    if json_size(text) <= level:
        return text
    shortened = text[: max(level, 0) // 12]  # a character takes 12 bytes at most, and most of them one
    while (more := text[: 2 * len(shortened) + 1]) != shortened and json_size(more) <= level:
        shortened = more
    return f"{shortened}… (coupé ici : {len(text)} caractères en tout)"
