"""Which students are stuck: the rules case by case, and measured on simulated classes where the truth is known."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import timedelta
from uuid import UUID

import pytest

from graders.core.contract.outcomes import Outcome
from server.board.stuck import LessonExercises, StuckSign, find_stuck_students, median_pace
from server.gradebook.histories import Attempts, GradedAttempt
from tests.support.stuck_class import EXERCISES, START, SimulatedClass, simulate_class

NOW = START + timedelta(minutes=60)
ADA = UUID(int=1)
EXERCISE, OTHER = "l20/poses", "l20/kabsch"
FIRST = 5
MINUTES = (20, 30, 40, 50, 65, 80)
CLASSES = range(24)


def attempts_of(*attempts: str, exercise: str = EXERCISE) -> Attempts:
    """Each `minutes ago, points[, code]`; 20 points are a success."""
    found = []
    for number, text in enumerate(attempts):
        ago, points, code = [*(part.strip() for part in text.split(",")), ""][:3]
        outcome = Outcome.OK if points == "20" else Outcome.WRONG_ANSWER
        sent_at = NOW - timedelta(minutes=float(ago))
        identity = UUID(int=number)
        digest = code or f"#{number}"
        found.append(
            GradedAttempt(
                identity, sent_at, int(points) / 20, ADA, exercise, digest, outcome.value, None, UUID(int=1000 + number)
            )
        )
    return tuple(found)


STUCK = {
    "two different failures for nine minutes": (["9,5", "1,5"], True),
    "the first attempt is no better score than nothing": (["9,5", "1,0"], True),
    "two failures for six minutes": (["6,5", "1,5"], False),
    "one only": (["5,5"], False),
    "the same code": (["9,5,a", "5,5,a", "1,5,a"], False),
    "a better score begins anew": (["20,0", "9,5", "1,5"], False),
    "two since the better score": (["12,0", "11,8", "9,5", "1,5"], True),
    "no better than an older score": (["300,10", "9,0", "1,10"], True),
    "succeeded": (["9,5", "5,5", "1,20"], False),
    "long ago": (["300,5", "299,5", "298,5"], False),
    "slow as ever: a pace of five minutes": (["300,0", "295,1", "290,2", "285,3", "12,1", "2,1"], False),
    "slow, and longer than ever": (["300,0", "295,1", "290,2", "285,3", "16,1", "2,1"], True),
}


@pytest.mark.parametrize(("attempts", "stuck"), STUCK.values(), ids=STUCK.keys())
def test_failures_without_progress_are_stuck(attempts: list[str], stuck: bool) -> None:
    found = find_stuck_students({(ADA, EXERCISE): attempts_of(*attempts)}, {ADA: NOW}, NOW)
    assert [row.exercise for row in found] == ([EXERCISE] if stuck else [])


@pytest.mark.parametrize(
    ("sent", "seen", "stuck"),
    [(7, 1, False), (9, 1, True), (39, 14, True), (39, 16, False), (41, 1, False), (9, None, False)],
)
def test_present_students_who_fall_silent_are_stuck(sent: int, seen: int | None, stuck: bool) -> None:
    seen_at = {ADA: None if seen is None else NOW - timedelta(minutes=seen)}
    attempts = {(ADA, EXERCISE): attempts_of(f"{sent},5")}
    found = find_stuck_students(attempts, seen_at, NOW)
    assert [row.sign for row in found] == ([StuckSign.silence] if stuck else [])
    elsewhere = {**attempts, (ADA, OTHER): attempts_of("1,5", exercise=OTHER)}
    assert not find_stuck_students(elsewhere, seen_at, NOW), "who works at something else is not held up here"


def test_a_student_may_be_stuck_before_the_first_attempt_of_a_lesson() -> None:
    lesson = LessonExercises((EXERCISE, OTHER), NOW - timedelta(minutes=12))
    (row,) = find_stuck_students({}, {ADA: NOW}, NOW, lesson)
    assert (row.exercise, row.sign, row.since) == (EXERCISE, StuckSign.beginning, lesson.started_at)
    assert not find_stuck_students({}, {ADA: NOW}, NOW), "outside a lesson nothing is expected"
    assert not find_stuck_students({}, {ADA: NOW - timedelta(days=1)}, NOW, lesson), "who is absent is not stuck"
    solved = {(ADA, EXERCISE): attempts_of("11,20")}
    (row,) = find_stuck_students(solved, {ADA: NOW}, NOW, lesson)
    assert (row.exercise, row.since) == (OTHER, NOW - timedelta(minutes=11))
    done = {**solved, (ADA, OTHER): attempts_of("11,20", exercise=OTHER)}
    assert not find_stuck_students(done, {ADA: NOW}, NOW, lesson), "who has finished is not stuck"


def test_a_pace_needs_some_attempts_and_leaves_breaks_out() -> None:
    assert median_pace([attempts_of("9,5", "1,5")]) == timedelta(minutes=3)
    assert median_pace([attempts_of("900,5", "300,5", "296,5", "292,5", "288,5")]) == timedelta(minutes=4)


def first_of(simulated: SimulatedClass, minute: float) -> Sequence[UUID]:
    now = START + timedelta(minutes=minute)
    lesson = LessonExercises(EXERCISES, START)
    rows = find_stuck_students(simulated.attempts_at(minute), simulated.seen_at(minute), now, lesson)
    return [row.account for row in rows[:FIRST]]


def test_who_is_really_stuck_is_among_the_first_five() -> None:
    """At least 80 % of those whom the simulation knows to be stuck (of as many as five places hold), and at most one
    false name in five. A student of slow pace, one who has left or is absent, and one who has finished are false."""
    known = named = listed = false = 0
    for seed in CLASSES:
        simulated = simulate_class(seed)
        for minute in MINUTES:
            first, stuck = set(first_of(simulated, minute)), simulated.stuck(minute)
            known += min(FIRST, len(stuck))
            named += len(first & stuck)
            listed += len(first)
            false += len(first - simulated.stuck(minute, after=0.0))
    assert known > 400, "enough students are stuck for the figures to mean something"
    assert named / known >= 0.8
    assert false / listed <= 0.2


def test_the_finished_and_the_absent_are_never_named() -> None:
    for seed in CLASSES:
        simulated = simulate_class(seed)
        first = set(first_of(simulated, 80))
        for pupil in simulated.pupils:
            assert pupil.account not in first or pupil.kind != "absent"
            last = max((attempt.sent_at for series in pupil.attempts.values() for attempt in series), default=START)
            has_finished = pupil.has_finished and last <= START + timedelta(minutes=80)
            assert pupil.account not in first or not has_finished
