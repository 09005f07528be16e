"""The states of students in objectives, case by case."""

from __future__ import annotations

from dataclasses import replace
from datetime import timedelta
from typing import cast
from uuid import UUID

import pytest

from server.assignments.feedback import FeedbackHold, FeedbackHolds, SittingStage, WithholdingTest
from server.board.objective_loading import remove_withheld_feedback
from server.board.objectives import (
    Mastery,
    MisconceptionLookup,
    PractisedObjective,
    find_objective_states,
    list_practised_objectives,
    summarise_class_objectives,
)
from server.course import Course
from server.course.objectives import Objective
from server.gradebook.histories import Attempts
from tests.board.test_attempts import ADA, NOW, attempts_of

FIRST, SECOND, OTHER = "l20/poses", "l20/icp", "l20/verification"
OBJECTIVE = Objective(
    "poses",
    "Composer des poses.",
    "Les poses",
    "slam",
    {"poses": frozenset({"composer"}), "icp": frozenset()},
    {"verification": frozenset({"angle"})},
)
PRACTISED = PractisedObjective(OBJECTIVE, (FIRST, SECOND), (OTHER,), 2)


class KnownFunctions:
    """Misconceptions that begin with « b » are in `inverse`, which the objective does not have."""

    def belongs_to_objective(self, objective: Objective, exercise: str, misconception: str) -> bool:
        function = "inverse" if misconception.startswith("b") else "composer"
        return objective.does_misconception_belong(exercise.partition("/")[2], misconception, {function})


FINDER = cast("MisconceptionLookup", KnownFunctions())


def series(exercise: str, *attempts: str) -> Attempts:
    return tuple(replace(attempt, exercise=exercise) for attempt in attempts_of(*attempts))


@pytest.mark.parametrize(
    ("first", "second", "other", "expected"),
    [
        ([], [], [], Mastery.none),
        (["9,5"], [], [], Mastery.started),
        (["9,20"], [], [], Mastery.started),
        (["9,20"], ["8,20"], [], Mastery.mastered),
        (["9,20", "8,5,,a", "7,5,,a"], ["8,20"], [], Mastery.mastered),
        (["9,5,,a"], [], [], Mastery.started),
        (["9,5,,a", "8,5,,a"], [], [], Mastery.weak),
        (["9,5,same,a", "8,5,same,a"], [], [], Mastery.started),
        (["9,5,,a", "8,5,,a", "7,8,,b"], [], [], Mastery.started),
        (["9,5,,b", "8,5,,b"], [], [], Mastery.started),
        (["9,5", "8,5", "7,5"], [], [], Mastery.weak),
        (["9,5", "8,6", "7,7"], [], [], Mastery.started),
        (["9,20"], ["9,20"], ["8,5,,angle", "7,5,,angle"], Mastery.weak),
        (["9,20"], ["9,20"], ["8,5,,jauge", "7,5,,jauge"], Mastery.mastered),
        ([], [], ["8,5", "7,5", "6,5"], Mastery.none),
    ],
)  # fmt: skip
def test_the_state_of_a_student(first: list[str], second: list[str], other: list[str], expected: Mastery) -> None:
    sent = {FIRST: first, SECOND: second, OTHER: other}
    own = {name: series(name, *attempts) for name, attempts in sent.items() if attempts}
    (found,) = find_objective_states((PRACTISED,), own, FINDER)
    assert found.state is expected


def test_a_class_is_counted_week_by_week() -> None:
    week = timedelta(days=7)
    done = {FIRST: series(FIRST, "9,20"), SECOND: series(SECOND, f"{60 * 24 * 8},20")}
    weak = {FIRST: series(FIRST, "9,5,,a", "8,5,,a")}
    students = {ADA: done, UUID(int=2): weak, UUID(int=3): {}}
    states = {account: find_objective_states((PRACTISED,), own, FINDER) for account, own in students.items()}
    (row,) = summarise_class_objectives((PRACTISED,), states, [NOW - week, NOW])
    assert [row.count_students(state) for state in Mastery] == [1, 0, 1, 1]
    assert row.students[Mastery.weak] == (UUID(int=2),)
    assert row.mistakes == (((FIRST, "a"), 1),)
    assert row.weekly == (0, 1)


def test_a_challenge_shows_an_objective_but_is_not_required(course: Course) -> None:
    module = course.modules["l20"]
    counted = {f"l20/{slug}" for slug in ("mcl", "defi_kidnappe", "kabsch")}
    rows = {row.objective.id: row for row in list_practised_objectives(module, counted)}
    assert rows["monte-carlo"].exercises == ("l20/mcl", "l20/defi_kidnappe")
    assert rows["monte-carlo"].required == 1
    assert rows["recalage"].required == 1, "of five exercises, one counts here"
    assert "odometrie" not in rows


def test_what_is_held_is_not_told() -> None:
    attempts = {FIRST: series(FIRST, "9,5,,a", "3,20"), SECOND: series(SECOND, "9,5,,a")}
    since = NOW - timedelta(minutes=5)
    test = WithholdingTest(ADA, ADA, "Contrôle", SittingStage.over, since, None)
    hold = FeedbackHold("Devoir", None)
    shown = remove_withheld_feedback(attempts, {FIRST: FeedbackHolds((test,)), SECOND: FeedbackHolds(diagnosis=hold)})
    assert [attempt.score for attempt in shown[FIRST]] == [0.25], "what the test holds is not there"
    assert [attempt.diagnosis for attempt in shown[SECOND]] == [None]
    assert FIRST not in remove_withheld_feedback({FIRST: series(FIRST, "3,20")}, {FIRST: FeedbackHolds((test,))})
