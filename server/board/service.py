"""The board of a class, read. Every function works inside the caller's transaction.

The number of queries depends on nothing but the code: neither on students nor on exercises.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments.service import counting_exercises
from server.board import insights, kept
from server.board.done import Done, Looked, cell_of
from server.board.repository import Scope
from server.board.schemas import Board, BoardStudent, ClassCounts, Insights, ProgressCell, ProgressState, Shown
from server.board.states import going_nowhere, gone_quiet
from server.board.trails import Pair
from server.board.unnamed import unnamed
from server.classes import repository as classes
from server.classes.models import SchoolClass
from server.course import Course
from server.identity.models import Account
from server.marks import repository as overrides
from server.marks.schemas import ActiveOverride, EffectivePoints
from server.rights import service as rights
from server.rights.models import Right


@dataclass(frozen=True)
class Work:
    """What the students of a class have done until `now`, where it counts."""

    scope: Scope
    now: datetime
    students: tuple[BoardStudent, ...]
    done: Done


def load_board(db: Session, course: Course, school_class: SchoolClass, now: datetime) -> Board:
    """Of an archived class, as it was when it was archived: its teachers see nothing that was sent later."""
    return _board(db, _work(db, course, school_class, now))


def load_dashboard(db: Session, course: Course, school_class: SchoolClass, now: datetime) -> tuple[Board, Insights]:
    """The board, with what is read beside it."""
    work = _work(db, course, school_class, now)
    shown, done = _board(db, work), work.done
    lesson, days = insights.activity(done.times, work.now)
    return shown, Insights(
        unnamed=unnamed(db, work.scope, done),
        items=done.items,
        helped=done.helped,
        hints=done.hints,
        lesson=lesson,
        days=days,
        made=done.made,
    )


def load_exercise_work(db: Session, course: Course, school_class: SchoolClass, exercise: str, now: datetime) -> Work:
    """At one exercise; nothing where it does not count."""
    return _work(db, course, school_class, now, only=exercise)


def load_scope(db: Session, course: Course, school_class: SchoolClass, now: datetime) -> Scope:
    """What counts on the board of a class."""
    exercises = tuple(counting_exercises(db, course, school_class, now))
    return Scope(school_class.id, exercises, school_class.archived_at)


def list_students(db: Session, class_id: UUID) -> tuple[BoardStudent, ...]:
    """Those who are in the class, in the order of a list of names."""
    return tuple(BoardStudent(one.id, one.name, one.groups, one.seen_at) for one in classes.learners(db, class_id))


def may_watch(db: Session, account_id: UUID, class_id: UUID) -> bool:
    """Whether an account may (still) see the board of a class."""
    account = db.get(Account, account_id)
    return account is not None and rights.may(db, account, Right.read_work, class_id)


def _work(db: Session, course: Course, school_class: SchoolClass, now: datetime, only: str | None = None) -> Work:
    now = min(now, school_class.archived_at or now)
    scope = load_scope(db, course, school_class, now)
    if only is not None:
        scope = replace(scope, exercises=tuple(name for name in scope.exercises if name == only))
    students = list_students(db, school_class.id)
    return Work(scope, now, students, kept.done(db, course, scope, [one.id for one in students]))


def _board(db: Session, work: Work) -> Board:
    done, seen = work.done, {one.id: one.seen_at for one in work.students}
    stuck = going_nowhere(done.trails, work.now) | gone_quiet(done.latest, seen, work.now)
    marks = overrides.read(db, overrides.told(db, work.scope.class_id, None))
    looked = done.looked
    if looked is None or (looked.stuck, looked.marks) != (stuck, marks):
        looked = done.looked = Looked(stuck, marks, _shown(done, stuck, marks))
    return Board(work.scope.class_id, work.now, work.students, tuple(work.scope.exercises), looked.shown)


def _shown(done: Done, stuck: frozenset[Pair], marks: Mapping[Pair, ActiveOverride]) -> Shown:
    other = {pair: _cell(done, pair, marks.get(pair), stuck) for pair in stuck | marks.keys()}
    cells = {**done.cells, **{pair: cell for pair, cell in other.items() if pair in done.cells}}
    excused = {pair for pair, mark in marks.items() if mark.excused}
    return Shown(cells, _counts(done, cells, excused), done.misconceptions)


def _cell(done: Done, pair: Pair, mark: ActiveOverride | None, stuck: frozenset[Pair]) -> ProgressCell:
    points = EffectivePoints(done.points.get(pair), mark).points
    return cell_of(pair, done.standings.get(pair), points, stuck=pair in stuck)


def _counts(done: Done, cells: Mapping[Pair, ProgressCell], excused: Collection[Pair]) -> ClassCounts:
    """Who is excused from an exercise finishes without it."""
    shown, width = list(cells.values()), len(done.exercises)
    started = finished = stuck = 0
    for place in range(len(done.students)):
        row = shown[place * width : (place + 1) * width]
        states = {cell.state for cell in row}
        asked = {cell.state for cell in row if (cell.student, cell.exercise) not in excused} if excused else states
        started += bool(states - {ProgressState.none})
        finished += asked == {ProgressState.solved}
        stuck += ProgressState.stuck in states
    return ClassCounts(len(done.students), started, finished, stuck)
