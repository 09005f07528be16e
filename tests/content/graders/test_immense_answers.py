"""Answers as large as numbers go are wrong answers like others: judged, shown and named without a warning of ours."""

from __future__ import annotations

import pytest

from graders.core.contract.local import LOCAL
from graders.core.contract.outcomes import Outcome
from tests.support.shipped import CODE

ENLARGED = """

import numpy as _np

def _enlarged(value):
    if isinstance(value, (tuple, list)):
        return type(value)(map(_enlarged, value))
    floats = isinstance(value, float) or isinstance(value, _np.ndarray) and value.dtype.kind == "f"
    return value * {factor} if floats else value

def _enlarging(function):
    return lambda *args, **given: _enlarged(function(*args, **given))
"""


@pytest.mark.parametrize(
    ("exercise", "factor"),
    [("l20/icp_droite", 1e200), ("l20/kabsch", 1e200), ("l20/kabsch", 1e308), ("l20/tp_slam", 1e308)],
)
def test_immense_answers_are_judged_without_a_warning(exercise: str, factor: float) -> None:
    grader = CODE[exercise]
    source = grader.solution + ENLARGED.format(factor=factor)
    for contract in grader.contracts:
        source += f"\n{contract.function} = _enlarging({contract.function})\n"
    verdict = grader.grade(source.encode(), LOCAL, seed=3, version="v").verdict
    assert verdict.outcome in (Outcome.WRONG_ANSWER, Outcome.INVALID_OUTPUT)
    assert verdict.points < verdict.max_points
