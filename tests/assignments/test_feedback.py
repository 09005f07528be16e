"""Where a student is in a test, and what assignments hold back: pure, by a table and by properties."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from typing import Any
from uuid import uuid4

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Diagnosis, Verdict
from server.assignments.feedback import FeedbackHolds, SittingStage, compute_holds, sitting_stage
from server.assignments.feedback_repository import AssignedExerciseRow
from server.assignments.models import Assignment, EndedBy, Exemption, Mode, Sitting, Visibility
from server.assignments.rules import rules_in_force

OPENS = datetime(2026, 11, 20, 8, tzinfo=UTC)
HOUR = timedelta(hours=1)
ADA = uuid4()


def made(**values: Any) -> Assignment:
    shown = dict.fromkeys(("hints", "diagnosis", "solution"), Visibility.usual)
    row = {"mode": Mode.test, "late": "accept", "title": "Interro", "opens_at": OPENS, **shown, **values}
    return Assignment(id=uuid4(), class_id=uuid4(), **row)


def at(hours: float) -> datetime:
    return OPENS + hours * HOUR


def seen(
    now: float,
    *,
    began: float | None = None,
    handed_in: float | None = None,
    by_time: bool = False,
    told: tuple[Exemption, ...] = (),
    active: bool = True,
    **values: Any,
) -> tuple[SittingStage, FeedbackHolds]:
    """Stage and feedback `now` hours after the opening, by the rules that `values` and `told` make."""
    one = made(**values)
    sitting = None
    if began is not None:
        ended_by = None if handed_in is None else EndedBy.time if by_time else EndedBy.student
        end = None if handed_in is None else at(handed_in)
        sitting = Sitting(assignment_id=one.id, account_id=ADA, began_at=at(began), handed_in_at=end, ended_by=ended_by)
    rules = rules_in_force(one, told, ADA, ())
    stage = sitting_stage(one, rules, sitting, at(now))
    return stage, compute_holds([(AssignedExerciseRow(ADA, one, "l20/poses", (), active, sitting), rules)], at(now))


def own(**values: Any) -> tuple[Exemption, ...]:
    return (Exemption(account_id=ADA, **values),)


CLOSES = {"closes_at": at(2)}
LASTS = {"duration_minutes": 60, "closes_at": at(5)}
RELEASED = {"released_at": at(3), "closes_at": at(2)}
STAGES: list[tuple[str, float, dict[str, Any], SittingStage]] = [
    ("not open yet", -1, CLOSES, SittingStage.before),
    ("open", 1, CLOSES, SittingStage.may_begin),
    ("closed on who never began", 2, CLOSES, SittingStage.missed),
    ("begun", 1, {**CLOSES, "began": 0.5}, SittingStage.running),
    ("closed on who sits", 2, {**CLOSES, "began": 0.5}, SittingStage.over),
    ("own time over", 1.5, {**LASTS, "began": 0.5}, SittingStage.over),
    ("own time with a factor", 1.9, {**LASTS, "began": 0.5, "told": own(time_factor=1.5)}, SittingStage.running),
    ("own time with a factor, over", 2, {**LASTS, "began": 0.5, "told": own(time_factor=1.5)}, SittingStage.over),
    ("handed in", 1, {**CLOSES, "began": 0.5, "handed_in": 0.75}, SittingStage.over),
    ("handed in, and given more time", 1, {**LASTS, "began": 0.5, "handed_in": 0.6}, SittingStage.over),
    (
        "ended by time, and given more",
        1,
        {**LASTS, "began": 0.5, "handed_in": 0.9, "by_time": True},
        SittingStage.running,
    ),
    ("released", 3, {**RELEASED, "began": 0.5, "handed_in": 1}, SittingStage.shown),
    ("released to who never began", 3, RELEASED, SittingStage.shown),
    ("to be released", 2.5, {**RELEASED, "began": 0.5, "handed_in": 1}, SittingStage.over),
    (
        "released while one has more time",
        3,
        {**RELEASED, "began": 0.5, "told": own(closes_at=at(4))},
        SittingStage.running,
    ),
    (
        "released, before one's own day",
        4,
        {**RELEASED, "told": own(opens_at=at(5), closes_at=at(7))},
        SittingStage.before,
    ),
    (
        "released, on one's own day",
        6,
        {**RELEASED, "told": own(opens_at=at(5), closes_at=at(7))},
        SittingStage.may_begin,
    ),
    ("after one's own day", 7, {**RELEASED, "told": own(opens_at=at(5), closes_at=at(7))}, SittingStage.shown),
    ("never ends by itself", 1000, {"began": 1}, SittingStage.running),
]


@pytest.mark.parametrize(("now", "case", "stage"), [row[1:] for row in STAGES], ids=[row[0] for row in STAGES])
def test_a_student_is_where_the_clock_and_their_rules_say(
    now: float, case: dict[str, Any], stage: SittingStage
) -> None:
    found, known = seen(now, **case)
    assert found is stage
    assert bool(known.tests) == (stage not in {SittingStage.before, SittingStage.shown})
    assert (known.submission_refusal == "") == (
        stage in {SittingStage.before, SittingStage.shown, SittingStage.running}
    )
    if known.tests:
        assert known.hints
        assert known.solution
        assert known.find_withholding_test(at(now))
        opens = case["told"][0].opens_at if case.get("told") and case["told"][0].opens_at else OPENS
        assert not known.find_withholding_test(opens - timedelta(seconds=1)), (
            "what was sent before it opened stays told"
        )


def test_who_is_excused_is_not_held_unless_they_have_begun() -> None:
    assert seen(1, **CLOSES, told=own(excused=True))[1] == FeedbackHolds()
    assert seen(1, **CLOSES, began=0.5, told=own(excused=True))[1].tests


def test_an_opening_moved_later_frees_nothing_that_was_sent_in_the_test() -> None:
    known = seen(1, began=0.5, told=own(opens_at=at(0.9)))[1]
    assert known.find_withholding_test(at(0.5))


def test_who_sits_one_test_may_send_whatever_another_one_says() -> None:
    over, running = seen(1, began=0.1, handed_in=0.2)[1], seen(1, began=0.5)[1]
    both = FeedbackHolds(over.tests + running.tests)
    assert over.submission_refusal
    assert not both.submission_refusal
    assert not both.find_withholding_test(at(-1))


PRACTICE: list[tuple[str, float, dict[str, Any], tuple[bool, datetime | None]]] = [
    ("usual", 1, {}, (False, None)),
    ("after due, before", 1, {"solution": Visibility.after_due, "due_at": at(2)}, (True, at(2))),
    ("after due, then", 2, {"solution": Visibility.after_due, "due_at": at(2)}, (False, None)),
    (
        "after due, one's own",
        2,
        {"solution": Visibility.after_due, "due_at": at(2), "told": own(due_at=at(3))},
        (True, at(3)),
    ),
    ("after close", 3, {"solution": Visibility.after_close, "due_at": at(2), "closes_at": at(4)}, (True, at(4))),
    ("closed", 4, {"solution": Visibility.after_close, "closes_at": at(4)}, (False, None)),
    ("without a date", 4, {"solution": Visibility.after_close}, (True, None)),
    ("never", 9, {"solution": Visibility.never, "closes_at": at(4)}, (True, None)),
    ("not open yet", -1, {"solution": Visibility.never}, (False, None)),
    ("gone from the class", 1, {"solution": Visibility.never, "active": False}, (False, None)),
    ("excused", 1, {"solution": Visibility.never, "told": own(excused=True)}, (False, None)),
]


@pytest.mark.parametrize(("now", "case", "held"), [row[1:] for row in PRACTICE], ids=[row[0] for row in PRACTICE])
def test_practice_holds_back_what_it_says_for_as_long(
    now: float, case: dict[str, Any], held: tuple[bool, datetime | None]
) -> None:
    closed = seen(now, mode=Mode.practice, **case)[1].solution
    assert (closed is not None, closed.until if closed else None) == held


@given(st.lists(st.none() | st.integers(1, 9), min_size=1, max_size=4))
def test_of_several_assignments_the_most_restrictive_holds(hours: list[int | None]) -> None:
    ones = [
        made(mode=Mode.practice, hints=Visibility.after_close, closes_at=None if h is None else at(h)) for h in hours
    ]
    pairs = [
        (AssignedExerciseRow(ADA, one, "l20/poses", (), True, None), rules_in_force(one, (), ADA, ())) for one in ones
    ]
    known = compute_holds(pairs, at(0.5))
    assert known.hints
    assert known.hints.until == (None if None in hours else max(at(h) for h in hours if h is not None))
    assert known.solution is None


def test_a_verdict_loses_what_is_held_back_and_nothing_else() -> None:
    failed = CheckResult("a", "Un", False, 0, 20, "On attend 4.", None, "Piste", None)
    whole = Verdict(
        "l20/poses",
        "v",
        Outcome.WRONG_ANSWER,
        1,
        [failed],
        Diagnosis("d", "Nommée", "…"),
        timings={"diagnosis_ms": 3.0},
    )
    unnamed = seen(1, mode=Mode.practice, diagnosis=Visibility.never)[1].remove_withheld_parts(whole)
    assert (unnamed.diagnosis, dict(unnamed.timings), unnamed.checks) == (None, {}, whole.checks)
    unhinted = seen(1, mode=Mode.practice, hints=Visibility.never)[1].remove_withheld_parts(whole)
    assert (unhinted.diagnosis, unhinted.checks[0].hint) == (whole.diagnosis, None)
    assert unhinted.checks[0].message == "On attend 4."
    assert FeedbackHolds().remove_withheld_parts(whole) == whole
