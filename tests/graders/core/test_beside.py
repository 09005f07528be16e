"""Probes that are asked of the program that the checks were run on, beside what simplifies what these failed on."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from graders.core.code.grading import CodeGrader
from graders.core.compare.shrinking import Budget
from graders.core.contract.verdict import Verdict
from tests.graders.core.test_ahead import Watched
from tests.graders.shipped import CODE

POSES = replace(CODE["l20/poses"], budget=Budget(calls=20, seconds=math.inf))
KEEPS = "_vu = []\n"


def judged(source: str, programs: Watched, grader: CodeGrader = POSES) -> Verdict:
    return grader.grade(source.encode(), programs, seed=5, version="v").verdict


def told(verdict: Verdict) -> dict[str, object]:
    return verdict.to_json() | {"timings": None}


@pytest.mark.parametrize("exercise", ["l20/poses", "l20/odometrie"])
def test_a_mistake_has_the_same_verdict_whether_it_is_named_by_the_same_process_or_by_another(exercise: str) -> None:
    grader = replace(CODE[exercise], budget=Budget(calls=20, seconds=math.inf))
    sources = [one.source for one in grader.misconceptions]
    spared = 0
    for source in sources:
        beside, afresh = Watched(), Watched()
        one, other = judged(source, beside, grader), judged(KEEPS + source, afresh, grader)
        assert told(one) == told(other)
        assert beside.launches <= afresh.launches
        spared += afresh.launches - beside.launches
    assert spared >= 0.8 * len(sources)


def test_a_mistake_that_is_named_by_the_same_process_costs_no_exchange_of_its_own() -> None:
    source = POSES.misconceptions[0].source
    beside, afresh = Watched(), Watched()
    assert told(judged(source, beside)) == told(judged(KEEPS + source, afresh))
    assert (beside.launches, afresh.launches) == (1, 2)
    assert beside.exchanges == afresh.exchanges - 1


def test_what_only_identities_fail_on_is_asked_of_the_same_process_though_nothing_is_simplified() -> None:
    """No check of its own is there to find `relatif` wrong."""
    source = POSES.solution + "\ndef relatif(a, b):\n    return np.array([0.0, 0.0, 0.0])\n"
    others = tuple(check for check in POSES.checks if check.id in ("composer_exemples", "identites", "arguments"))
    grader = replace(POSES, checks=others)
    beside, afresh = Watched(), Watched()
    one = grader.grade(source.encode(), beside, seed=5, version="v").verdict
    other = grader.grade((KEEPS + source).encode(), afresh, seed=5, version="v").verdict
    assert told(one) == told(other)
    assert (beside.launches, afresh.launches) == (1, 2)


@pytest.mark.parametrize("deadly", [1, 5, 27])
def test_a_program_that_dies_of_a_probe_is_asked_them_all_afresh(deadly: int) -> None:
    source = POSES.misconceptions[0].source
    assert POSES.prober is not None
    first, alive = POSES.prober.probes[0], Watched()
    verdict = judged(source, alive)
    dies = Watched(alive.calls.index((first.function, str(first.calls[0]))) + deadly)
    again = judged(source, dies)
    assert again.misconception == verdict.misconception
    assert [check.passed for check in again.checks] == [check.passed for check in verdict.checks]
    assert dies.launches >= 2
