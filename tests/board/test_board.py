"""The board of a class in the database: who and what counts there, whatever the size of the class."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime, timedelta
from statistics import median
from typing import Any
from uuid import UUID

import pytest

from server.assignments.models import AssignedExercise, Assignment
from server.behaviour.models import BehaviourGroup, Fingerprint
from server.board import service
from server.board.schemas import Board, BoardStatistics, ProgressCell, ProgressState
from server.classes.models import ClassRole, SchoolClass, Status
from server.course import Course
from server.database import Database, utc_now
from server.identity.models import Role
from server.marks.models import Override
from server.submissions.models import Submission
from tests.support.classes import new_class, seat
from tests.support.counting import Counted
from tests.support.crowd import Sent, lessons, seated, store
from tests.support.service import EXERCISE, new_account

OTHER = "l20/kabsch"
WRONG = "rotation_oubliee"


@pytest.fixture
def made(database: Database) -> SchoolClass:
    return new_class(database, new_account(database, Role.teacher))


def read(
    database: Database, course: Course, made: SchoolClass, now: datetime | None = None
) -> tuple[Board, BoardStatistics]:
    with database.read() as db:
        school_class = db.get(SchoolClass, made.id)
        assert school_class is not None
        return service.load_board_and_statistics(db, course, school_class, now or utc_now())


def assign(database: Database, made: SchoolClass, exercises: Sequence[str], opens_in_days: float = -1) -> None:
    with database.write() as db:
        opens_at = utc_now() + timedelta(days=opens_in_days)
        assignment = Assignment(class_id=made.id, title="TD", opens_at=opens_at)
        db.add(assignment)
        db.flush()
        for place, name in enumerate(exercises):
            db.add(AssignedExercise(assignment_id=assignment.id, exercise=name, position=place))


def test_cells_and_counts(database: Database, course: Course, made: SchoolClass) -> None:
    assign(database, made, [EXERCISE, OTHER, "l20/parti"])
    assign(database, made, ["l20/boucles"], opens_in_days=1)
    now = utc_now()
    ada, alan, grace = seated(database, made, 3, now)
    minutes = [timedelta(minutes=one) for one in range(10)]
    sent = [Sent(ada, name, now - minutes[1], 1.0) for name in (EXERCISE, OTHER)]
    sent += [Sent(alan, EXERCISE, now - 3 * minutes[4 - place], 0.25, WRONG, f"x = {place}") for place in range(3)]
    sent += [Sent(alan, "l20/boucles", now - minutes[1], 0.5), Sent(grace, EXERCISE, now - minutes[1], None)]
    store(database, sent)
    board, insights = read(database, course, made)
    assert board.exercises == (EXERCISE, OTHER), "neither what opens tomorrow, nor what has left the course"
    assert vars(board.counts) == {"students": 3, "started": 2, "finished": 1, "stuck": 1}
    assert board.cells_by_pair[alan, EXERCISE] == ProgressCell(alan, EXERCISE, 5.0, 3, ProgressState.stuck, WRONG)
    assert board.cells_by_pair[alan, OTHER] == ProgressCell(alan, OTHER, None, 0, ProgressState.none, None)
    assert board.cells_by_pair[grace, EXERCISE].state is ProgressState.none, "an error of ours is nobody's attempt"
    (row,) = board.misconceptions
    assert (row.exercise, row.id, row.now, row.ever, row.students) == (EXERCISE, WRONG, 1, 1, (alan,))
    assert "rotation" in row.title
    assert [(one.n, one.solved, one.success) for one in insights.items] == [(2, 1, None), (1, 1, None)]


def test_only_students_of_the_class_are_on_its_board(database: Database, course: Course, made: SchoolClass) -> None:
    now = utc_now()
    (ada,) = seated(database, made, 1)
    others = {
        "teacher": seat(database, made, new_account(database, Role.teacher), ClassRole.teacher),
        "assistant": seat(database, made, new_account(database), ClassRole.assistant),
        "left": seat(database, made, new_account(database), status=Status.left, left_at=now),
        "pending": seat(database, made, new_account(database), status=Status.pending),
        "of another class": new_account(database),
    }
    other_class = new_class(database, new_account(database, Role.teacher), "PSI")
    seat(database, other_class, others["of another class"])
    store(database, [Sent(one.id, EXERCISE, now, 0.5, WRONG) for one in others.values()])
    board, insights = read(database, course, made)
    assert vars(board.counts) == {"students": 1, "started": 0, "finished": 0, "stuck": 0}
    assert {student for student, _ in board.cells_by_pair} == {ada}
    assert board.misconceptions == ()
    assert insights.unnamed == ()
    assert sum(slot.attempts for slot in insights.days) == 0
    assert read(database, course, other_class)[0].counts.started == 1


def test_overrides_are_in_force_on_the_board(sqlite: Database, course: Course) -> None:
    made = new_class(sqlite, new_account(sqlite, Role.teacher))
    assign(sqlite, made, [EXERCISE, OTHER])
    ada, alan = seated(sqlite, made, 2)
    store(sqlite, [Sent(ada, EXERCISE, utc_now(), 1.0), Sent(alan, EXERCISE, utc_now(), 0.5)])
    with sqlite.write() as db:
        row = {"class_id": made.id, "reason": "absente", "based_on": []}
        db.add(Override(account_id=ada, exercise=OTHER, excused=True, **row))
        db.add(Override(account_id=alan, exercise=EXERCISE, points=12.5, **row))
        db.add(Override(account_id=alan, exercise=OTHER, points=8.0, **row))
    board, _ = read(sqlite, course, made)
    points = [[board.cells_by_pair[one, name].points for name in (EXERCISE, OTHER)] for one in (ada, alan)]
    assert points == [[20.0, None], [12.5, 8.0]]
    assert board.cells_by_pair[alan, OTHER].state is ProgressState.none, "a mark is no attempt"
    assert vars(board.counts) == {"students": 2, "started": 2, "finished": 1, "stuck": 0}


def test_an_archived_class_stays_as_it_was(database: Database, course: Course, made: SchoolClass) -> None:
    now = utc_now()
    (ada,) = seated(database, made, 1)
    with database.write() as db:
        row = db.get(SchoolClass, made.id)
        assert row is not None
        row.archived_at = now - timedelta(days=1)
    store(database, [Sent(ada, EXERCISE, now - timedelta(days=2), 0.5), Sent(ada, EXERCISE, now, 1.0)])
    assert read(database, course, made)[0].cells_by_pair[ada, EXERCISE] == ProgressCell(
        ada, EXERCISE, 10.0, 1, ProgressState.trying, None
    )


def test_a_class_without_students_or_without_its_module(sqlite: Database, course: Course) -> None:
    made = new_class(sqlite, new_account(sqlite, Role.teacher))
    assert set(vars(read(sqlite, course, made)[0].counts).values()) == {0}
    seated(sqlite, made, 2)
    with sqlite.write() as db:
        row = db.get(SchoolClass, made.id)
        assert row is not None
        row.module = "parti9"
    board, insights = read(sqlite, course, made)
    assert (board.cells_by_pair, board.exercises, insights.items) == ({}, (), ())
    assert vars(board.counts) == {"students": 2, "started": 0, "finished": 0, "stuck": 0}


def test_a_simulated_class_against_its_definitions(sqlite: Database, course: Course) -> None:
    made = new_class(sqlite, new_account(sqlite, Role.teacher))
    now = utc_now()
    exercises = [one.id for one in course.modules["l20"].exercises][:5]
    mistakes = {name: sorted(course.exercises[name].grader.mistake_ids())[:3] for name in exercises}
    attempts = lessons(seated(sqlite, made, 24), exercises, mistakes, now)
    store(sqlite, attempts)
    board, insights = read(sqlite, course, made, now)
    by_pair: dict[tuple[UUID, str], list[Sent]] = {}
    for one in sorted(attempts, key=lambda one: one.at):
        by_pair.setdefault((one.account, one.exercise), []).append(one)
    for row in board.misconceptions:
        there = {pair: [one.diagnosis == row.id for one in sent] for pair, sent in by_pair.items()}
        had = {pair[0]: flags for pair, flags in there.items() if pair[1] == row.exercise and any(flags)}
        still = {account for account, flags in had.items() if flags[-1]}
        assert (set(row.students), row.now, row.ever) == (still, len(still), len(had))
        assert row.overcome == row.ever - row.now
        taken = [len(flags) - flags[::-1].index(True) - flags.index(True) for flags in had.values() if not flags[-1]]
        assert row.median_attempts == (median(taken) if taken else None)
    assert [one.now for one in board.misconceptions] == sorted((one.now for one in board.misconceptions), reverse=True)
    named = {(one.exercise, one.diagnosis) for one in attempts if one.diagnosis}
    assert {(one.exercise, one.id) for one in board.misconceptions} == named
    for pair, cell in board.cells_by_pair.items():
        sent = by_pair.get(pair, [])
        assert cell.attempts == len(sent)
        assert cell.points == (pytest.approx(20 * max(one.score or 0.0 for one in sent)) if sent else None)
        assert cell.misconception == (sent[-1].diagnosis if sent else None)
        assert (cell.state is ProgressState.solved) == any(one.score == 1.0 for one in sent)
    for item in insights.items:
        tried = [sent for pair, sent in by_pair.items() if pair[1] == item.exercise]
        solved = [sent for sent in tried if any(one.score == 1.0 for one in sent)]
        assert (item.n, item.solved) == (len(tried), len(solved))
        assert item.success == (len(solved) / len(tried) if len(tried) >= 10 else None)
    recent = [one for one in attempts if one.at >= insights.days[0].begins_at]
    assert sum(slot.attempts for slot in insights.days) == len(recent)


def test_a_board_takes_as_many_queries_for_a_bigger_class(sqlite: Database, course: Course) -> None:
    def queries(students: int, exercises: int) -> int:
        made = new_class(sqlite, new_account(sqlite, Role.teacher))
        names = [one.id for one in course.modules["l20"].exercises][:exercises]
        now = utc_now()
        store(sqlite, lessons(seated(sqlite, made, students), names, {name: ["a", "b"] for name in names}, now))
        with Counted(sqlite) as counted:
            read(sqlite, course, made, now)
        return len(counted.statements)

    assert queries(2, 1) == queries(30, 6) <= 8


def test_failures_with_equal_answers_are_one_group(sqlite: Database, course: Course) -> None:
    made = new_class(sqlite, new_account(sqlite, Role.teacher))
    students, now = seated(sqlite, made, 3), utc_now()
    sent = store(sqlite, [Sent(one, EXERCISE, now, 0.5) for one in students])
    with sqlite.write() as db:
        group = {"structure": "", "projection": 0.0, "answers": b"", "functions": [], "example": None}
        db.add(BehaviourGroup(id="alike", exercise=EXERCISE, exercise_version="v1", **group))
        db.flush()
        rows = [db.get(Submission, one) for one in sent[:2]]
        db.add_all([Fingerprint(grading_id=one.grading_id, group_id="alike") for one in rows if one is not None])
        alike = {one.account_id for one in rows if one is not None}
    _, insights = read(sqlite, course, made)
    found = [(one.group, set(one.students)) for one in insights.unnamed]
    assert found == [("alike", alike), (None, set(students) - alike)]


def test_boards_that_show_the_same_have_one_version(sqlite: Database, course: Course) -> None:
    made = new_class(sqlite, new_account(sqlite, Role.teacher))
    (ada,) = seated(sqlite, made, 1)
    first: Any = read(sqlite, course, made)[0]
    assert first.version == read(sqlite, course, made)[0].version
    store(sqlite, [Sent(ada, EXERCISE, utc_now(), 0.5)])
    second = read(sqlite, course, made)[0]
    assert second.version != first.version
    assert [cell.exercise for cell in second.cells_changed_since(first)] == [EXERCISE]
