"""Probes that travel with the exchanges that shrink counterexamples, on the program of the checks."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from graders.core.code import piggyback, simplifying
from graders.core.code.grading import CodeGrader
from graders.core.code.piggyback import HANG_SECONDS, MAX_ANSWER_SECONDS, MAX_EXPECTED_SECONDS, PiggybackCalls
from graders.core.compare.shrinking import Budget
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import PlannedCalls, Reply, StudentFault
from graders.core.contract.verdict import Verdict
from tests.graders.core.test_pipelining import Watched
from tests.support.shipped import CODE

POSES = replace(CODE["l20/poses"], budget=Budget(calls=20, seconds=math.inf))
KEEPS = "_vu = []\n"


@pytest.fixture
def _any_pace(monkeypatch: pytest.MonkeyPatch) -> None:
    """A busy machine would answer too late for the probes to travel."""
    for limit in ("MAX_ANSWER_SECONDS", "MAX_EXPECTED_SECONDS"):
        monkeypatch.setattr(piggyback, limit, math.inf)
    monkeypatch.setattr(simplifying, "MAX_BATCH_SECONDS", 1e9)


def judged(source: str, programs: Watched, grader: CodeGrader = POSES) -> Verdict:
    return grader.grade(source.encode(), programs, seed=5, version="v").verdict


def told(verdict: Verdict) -> dict[str, object]:
    return verdict.to_json() | {"timings": None}


@pytest.mark.usefixtures("_any_pace")
@pytest.mark.parametrize("exercise", ["l20/poses", pytest.param("l20/odometrie", marks=pytest.mark.slow)])
def test_a_mistake_has_the_same_verdict_whether_it_is_named_by_the_same_process_or_by_another(exercise: str) -> None:
    grader = replace(CODE[exercise], budget=Budget(calls=20, seconds=math.inf))
    sources = [mistake.source for mistake in grader.misconceptions[::3]]
    spared = 0
    for source in sources:
        calls, afresh = Watched(), Watched()
        one, other = judged(source, calls, grader), judged(KEEPS + source, afresh, grader)
        assert told(one) == told(other)
        assert calls.launches <= afresh.launches
        spared += afresh.launches - calls.launches
    assert spared >= 0.8 * len(sources)


@pytest.mark.usefixtures("_any_pace")
def test_a_mistake_that_is_named_by_the_same_process_costs_no_exchange_of_its_own() -> None:
    grader = replace(POSES, budget=Budget(calls=20, seconds=math.inf))
    source = grader.misconceptions[0].source
    calls, afresh = Watched(), Watched()
    assert told(judged(source, calls, grader)) == told(judged(KEEPS + source, afresh, grader))
    assert (calls.launches, afresh.launches) == (1, 2)
    assert calls.exchanges == afresh.exchanges - 1


@pytest.mark.usefixtures("_any_pace")
def test_what_only_identities_fail_on_is_asked_of_the_same_process_though_nothing_is_simplified() -> None:
    """No check of its own is there to find `relatif` wrong."""
    source = POSES.solution + "\ndef relatif(a, b):\n    return np.array([0.0, 0.0, 0.0])\n"
    others = tuple(check for check in POSES.checks if check.id in ("composer_exemples", "identites", "arguments"))
    grader = replace(POSES, checks=others)
    calls, afresh = Watched(), Watched()
    one = grader.grade(source.encode(), calls, seed=5, version="v").verdict
    other = grader.grade((KEEPS + source).encode(), afresh, seed=5, version="v").verdict
    assert told(one) == told(other)
    assert (calls.launches, afresh.launches) == (1, 2)


@pytest.mark.usefixtures("_any_pace")
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


FIRST, SECOND, LAST = (PlannedCalls(name, ((1.0,),) * 10) for name in "fgh")
REPLIES = tuple(Reply(0.5) for _ in range(10))


def test_what_would_take_long_is_not_asked_beside_anything() -> None:
    """Their time would be taken from the search for a simple counterexample."""
    calls = PiggybackCalls(lambda: 0.0)
    calls.queue([FIRST, SECOND])
    assert calls.take_queued(seconds_per_call=1.01 * MAX_EXPECTED_SECONDS / 20) == ()
    assert calls.take_queued(seconds_per_call=0.99 * MAX_EXPECTED_SECONDS / 20) == [FIRST, SECOND]
    assert calls.take_queued(seconds_per_call=0.0) == (), "once"


def stored_after(seconds: float, last: StudentFault) -> list[tuple[Reply | StudentFault, ...] | None]:
    """Return the stored answers of three batches, of which the second ended with a fault after some seconds."""
    now = 100.0
    calls = PiggybackCalls(lambda: now)
    calls.queue([FIRST, SECOND, LAST])
    calls.take_queued(0.0)
    now += seconds
    calls.store_answers({FIRST: REPLIES, SECOND: (*REPLIES[:3], last), LAST: ()})
    return [None if told is None else tuple(told) for told in map(calls.stored_answers, (FIRST, SECOND, LAST))]


def test_who_hangs_for_long_is_waited_for_once() -> None:
    hung = StudentFault(Outcome.TIMEOUT, "Trop long.", fatal=True)
    died = StudentFault(Outcome.RUNTIME_ERROR, "Mort.", fatal=True)
    assert stored_after(1.1 * HANG_SECONDS, hung) == [REPLIES, (), ()]
    assert stored_after(1.1 * HANG_SECONDS, died) == [None] * 3
    assert stored_after(0.9 * MAX_ANSWER_SECONDS, hung) == [None] * 3, (
        "under limits of its own it may have come to an end"
    )
