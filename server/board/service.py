"""The board of a class, read. Every function works inside the caller's transaction.

The number of queries depends on nothing but the code: neither on students nor on exercises.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments.service import counting_exercises
from server.board import insights, repository
from server.board.names import named
from server.board.points import in_force
from server.board.repository import Scope
from server.board.schemas import Board, Cell, Counts, Insights, Misconception, State, Student
from server.board.states import going_nowhere, gone_quiet, median_of, state_of
from server.board.trails import Had, Pair, Trails, misconceptions, sums, trails
from server.board.unnamed import unnamed
from server.classes import repository as classes
from server.classes.models import SchoolClass, Seat, Status
from server.course import Course
from server.gradebook.standings import Sums
from server.identity.models import Account
from server.marks.schemas import InForce
from server.rights import service as rights
from server.rights.models import Right


@dataclass(frozen=True)
class Work:
    """What the students of a class have done until `now`, where it counts."""

    scope: Scope
    now: datetime
    students: tuple[Student, ...]
    trails: Trails

    @cached_property
    def standings(self) -> Mapping[Pair, Sums]:
        return {pair: sums(trail) for pair, trail in self.trails.items()}


def board(db: Session, course: Course, school_class: SchoolClass, now: datetime) -> Board:
    """Of an archived class, as it was when it was archived: its teachers see nothing that was sent later."""
    return _board(db, course, school_class, _work(db, course, school_class, now))


def dashboard(db: Session, course: Course, school_class: SchoolClass, now: datetime) -> tuple[Board, Insights]:
    """The board, with what is read beside it."""
    work = _work(db, course, school_class, now)
    shown = _board(db, course, school_class, work)
    lesson, days = insights.activity(work.trails, work.now)
    exercises = work.scope.exercises
    return shown, Insights(
        unnamed=unnamed(db, work.scope, [one.id for one in work.students], work.trails),
        items=insights.items(exercises, work.standings, work.trails),
        helped=insights.helped(shown.misconceptions),
        hints=insights.hints(course, exercises, work.trails),
        lesson=lesson,
        days=days,
    )


def scope_of(db: Session, course: Course, school_class: SchoolClass, now: datetime) -> Scope:
    """What counts on the board of a class."""
    exercises = tuple(counting_exercises(db, course, school_class, now))
    return Scope(school_class.id, exercises, school_class.archived_at)


def students_of(db: Session, class_id: UUID) -> tuple[Student, ...]:
    """Those who are in the class, in the order of a list of names."""
    return tuple(
        Student(one.id, one.name, one.groups, one.membership.last_seen_at)
        for one in classes.members(db, class_id)
        if one.seat is Seat.student and one.status is Status.active
    )


def may_watch(db: Session, account_id: UUID, class_id: UUID) -> bool:
    """Whether an account may (still) see the board of a class."""
    account = db.get(Account, account_id)
    return account is not None and rights.may(db, account, Right.read_work, class_id)


def _work(db: Session, course: Course, school_class: SchoolClass, now: datetime) -> Work:
    now = min(now, school_class.archived_at or now)
    scope = scope_of(db, course, school_class, now)
    students = students_of(db, school_class.id)
    return Work(scope, now, students, trails(repository.history(db, scope)))


def _board(db: Session, course: Course, school_class: SchoolClass, work: Work) -> Board:
    seen = {one.id: one.seen_at for one in work.students}
    stuck = going_nowhere(work.trails, work.now) | gone_quiet(work.standings, seen, work.now)
    marks = in_force(db, work.scope, [one.id for one in work.students], work.standings)
    cells = {
        (student.id, exercise): _cell((student.id, exercise), work.standings, marks, stuck)
        for student in work.students
        for exercise in work.scope.exercises
    }
    return Board(
        class_id=school_class.id,
        generated_at=work.now,
        students=work.students,
        exercises=tuple(work.scope.exercises),
        cells=cells,
        counts=_counts(work, cells, {pair for pair, mark in marks.items() if mark.excused}),
        misconceptions=_misconceptions(course, work.trails),
    )


def _cell(pair: Pair, standings: Mapping[Pair, Sums], marks: Mapping[Pair, InForce], stuck: frozenset[Pair]) -> Cell:
    sums = standings.get(pair)
    return Cell(
        student=pair[0],
        exercise=pair[1],
        points=marks[pair].points if pair in marks else None,
        attempts=sums.attempts if sums else 0,
        state=state_of(sums, stuck=pair in stuck),
        misconception=sums.last_diagnosis if sums else None,
    )


def _counts(work: Work, cells: Mapping[Pair, Cell], excused: Collection[Pair]) -> Counts:
    """Who is excused from an exercise finishes without it."""
    states: dict[UUID, list[State]] = defaultdict(list)
    required: dict[UUID, list[State]] = defaultdict(list)
    for pair, cell in cells.items():
        states[cell.student].append(cell.state)
        if pair not in excused:
            required[cell.student].append(cell.state)
    return Counts(
        students=len(work.students),
        started=sum(any(state is not State.none for state in one) for one in states.values()),
        finished=sum(all(state is State.solved for state in one) for one in required.values()),
        stuck=sum(State.stuck in one for one in states.values()),
    )


def _misconceptions(course: Course, done: Trails) -> tuple[Misconception, ...]:
    """Those that most students still have come first; of these, what most ever had; then in the course's order."""
    had: dict[tuple[str, str], list[Had]] = defaultdict(list)
    for (_, exercise), trail in done.items():
        for name, one in misconceptions(trail):
            had[exercise, name].append(one)
    order = {name: place for place, name in enumerate(course.exercises)}
    found = [_misconception(course, exercise, name, rows) for (exercise, name), rows in had.items()]
    return tuple(sorted(found, key=lambda one: (-one.now, -one.ever, order.get(one.exercise, len(order)), one.id)))


def _misconception(course: Course, exercise: str, name: str, rows: Sequence[Had]) -> Misconception:
    still = sorted((one.account for one in rows if one.attempts is None), key=str)
    overcome = [one.attempts for one in rows if one.attempts is not None]
    return Misconception(
        exercise=exercise,
        id=name,
        title=named(course, exercise, name).diagnosis.title,
        now=len(still),
        ever=len(rows),
        overcome=len(overcome),
        median_attempts=median_of(overcome),
        students=tuple(still),
        followed=sum(one.followed for one in rows),
        improved=sum(one.improved for one in rows),
    )
