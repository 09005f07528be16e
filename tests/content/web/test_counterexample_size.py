"""A counterexample is read: what a page shows of it is some 2 kB long, whatever the exercise and the mistake."""

from __future__ import annotations

import pytest

from graders.core.contract.outcomes import Outcome
from server.web.values import ValueView
from server.web.verdicts import build_verdict_view
from tests.support.quick import the_course
from tests.support.shipped import CODE
from tests.support.verdicts import checked

CHARACTERS = 2300
#: The exercises whose counterexamples are longest: graphs, maps, beliefs, scans of 400 rays.
LONGEST = {"l20/predire2d", "l20/defi_robuste"}
#: Where a grading takes seconds.
LONG = {"l20/mcl", "l20/defi_kidnappe", "l20/tp_slam"}
EXERCISES = [pytest.param(name, marks=() if name in LONGEST else pytest.mark.slow) for name in CODE if name not in LONG]


def shown_length(value: ValueView | None) -> int:
    if value is None:
        return 0
    cells = sum(len(cell.text) + 1 for row in value.rows for cell in row)
    return len(value.text) + len(value.note) + cells + sum(len(name) + shown_length(item) for name, item in value.items)


@pytest.mark.parametrize("exercise", EXERCISES)
def test_a_counterexample_is_short(exercise: str) -> None:
    grader = CODE[exercise]
    wrong = [mistake.source for mistake in grader.misconceptions]
    wrong += [s.path.read_text(encoding="utf-8-sig") for s in grader.specimens() if s.outcome is Outcome.WRONG_ANSWER]
    for source in wrong[-3:] if exercise in LONGEST else wrong:
        view = build_verdict_view(
            checked(exercise, source, 3).verdict, "", functions=the_course().exercises[exercise].functions
        )
        for check in view.checks:
            if (shown := check.counterexample) is not None:
                inputs = sum(len(name) + shown_length(value) for name, value in shown.inputs)
                assert inputs + shown_length(shown.expected) + shown_length(shown.got) <= CHARACTERS, (check.id, source)
