"""The marks of a class, made anew each time that they are asked for: six queries, or seven, whatever the class."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from datetime import UTC, datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import papers
from server.assignments import repository as assignments
from server.assignments.counting import Sent, in_sitting, result
from server.assignments.feedback import Stage, stage_of
from server.assignments.models import Assigned, Assignment, Counts, Exemption, Late, Mode, Sitting
from server.assignments.rules import Rules, in_force
from server.classes import repository as classes
from server.classes.models import SchoolClass, Seat, Status
from server.classes.schemas import Member
from server.course import Course
from server.marks import repository
from server.marks.schemas import AssignmentMark, Book, ExerciseMark, Key, Row, Set, State

ALL_TITLE = "Exercices du module"
ALWAYS = datetime(2000, 1, 1, tzinfo=UTC)


def of_class(
    db: Session, course: Course, school_class: SchoolClass, now: datetime, only: Collection[UUID] | None = None
) -> Book:
    """The marks of its students, or of some; no staff, and nobody who has left or only asks to join."""
    students = [one for one in classes.members(db, school_class.id, only) if _learns(one)]
    given = assignments.of_class(db, school_class.id)
    exercises = assignments.exercises(db, [one.id for one in given])
    if not given:
        given, exercises = _without_assignment(course, school_class)
    tests = [one.id for one in given if one.mode == Mode.test]
    material = _Material(
        exercises=exercises,
        exemptions=assignments.exemptions(db, [one.id for one in given]),
        sittings=papers.sittings_of(db, tests) if tests else {},
        now=now,
    )
    ids = [one.id for one in students]
    names = {one.exercise for rows in exercises.values() for one in rows}
    sent, gradings = repository.graded(db, ids, names, school_class.archived_at)
    set_ones = repository.active(db, school_class.id, ids, names)
    found = _Found(sent, gradings, set_ones)
    weights = tuple(one.weight for one in given)
    return Book(
        school_class=school_class,
        at=now,
        assignments=tuple(given),
        rows=tuple(
            Row(member, tuple(material.mark(one, member, found) for one in given), weights) for member in students
        ),
        titles={name: course.exercises[name].title for name in names if name in course.exercises},
        exercises={one.id: tuple(exercises.get(one.id, ())) for one in given},
    )


def _learns(member: Member) -> bool:
    return member.seat is Seat.student and member.status is Status.active


def _without_assignment(
    course: Course, school_class: SchoolClass
) -> tuple[Sequence[Assignment], Mapping[UUID, Sequence[Assigned]]]:
    """A class without assignments has its module's exercises to do, whenever it likes. Nothing of this is stored."""
    module = course.modules.get(school_class.module)
    names = [] if module is None else [one.id for one in module.exercises]
    everything = _everything(school_class)
    return [everything], {everything.id: [Assigned(name, 1.0) for name in names]}


def _everything(school_class: SchoolClass) -> Assignment:
    return Assignment(
        id=school_class.id,
        class_id=school_class.id,
        title=ALL_TITLE,
        mode=Mode.practice,
        opens_at=ALWAYS,
        late=Late.accept,
        counts=Counts.best,
        weight=1.0,
    )


def outside(db: Session, school_class: SchoolClass, student: UUID, exercise: str) -> ExerciseMark:
    """A student's mark at an exercise that no assignment of the class asks: the best of all attempts."""
    sent, gradings = repository.graded(db, [student], [exercise], school_class.archived_at)
    found = _Found(sent, gradings, repository.active(db, school_class.id, [student], [exercise]))
    rules = in_force(_everything(school_class), (), student, ())
    key = (student, exercise)
    return found.at(key, found.sent.get(key, ()), 1.0, rules, Counts.best)


class _Found:
    """What was sent and what was set, by student and exercise."""

    def __init__(
        self, sent: Mapping[Key, Sequence[Sent]], gradings: Mapping[UUID, str], overrides: Mapping[Key, Set]
    ) -> None:
        self.sent, self.gradings, self.overrides = sent, gradings, overrides

    def at(self, key: Key, sent: Sequence[Sent], weight: float, rules: Rules, counts: Counts) -> ExerciseMark:
        found = result(rules, counts, sent)
        counted = found.counted
        return ExerciseMark(
            exercise=key[1],
            weight=weight,
            counted=counted,
            grading=None if counted is None else self.gradings[counted.attempt],
            sent_at=None if counted is None else next(one.sent_at for one in sent if one.id == counted.attempt),
            attempts=found.attempts,
            override=self.overrides.get(key),
        )


class _Material:
    """What the assignments of a class say, at one moment."""

    def __init__(
        self,
        exercises: Mapping[UUID, Sequence[Assigned]],
        exemptions: Mapping[UUID, Sequence[Exemption]],
        sittings: Mapping[tuple[UUID, UUID], Sitting],
        now: datetime,
    ) -> None:
        self.exercises, self.exemptions, self.sittings, self.now = exercises, exemptions, sittings, now
        self._common: dict[UUID, Rules] = {}

    def mark(self, assignment: Assignment, member: Member, found: _Found) -> AssignmentMark:
        rules, student = self._rules(assignment, member), member.id
        counts = Counts(assignment.counts)
        marks = tuple(
            found.at(key, self._sent(assignment, key, found), weight, rules, counts)
            for exercise, weight in self.exercises.get(assignment.id, ())
            for key in [(student, exercise)]
        )
        sat = (assignment.id, member.id) in self.sittings
        ended = self._ended(assignment, rules, member.id)
        return AssignmentMark(rules, state_of(rules, marks, self.now, sat=sat, ended=ended), marks, ended)

    def _rules(self, assignment: Assignment, member: Member) -> Rules:
        """The same ones for all where nobody has an exemption."""
        exemptions = self.exemptions.get(assignment.id, ())
        if exemptions:
            return in_force(assignment, exemptions, member.id, member.groups)
        if assignment.id not in self._common:
            self._common[assignment.id] = in_force(assignment, (), member.id, ())
        return self._common[assignment.id]

    def _ended(self, assignment: Assignment, rules: Rules, student: UUID) -> bool:
        """Whether it is a test in which this student can send nothing any more, whatever its dates: they have handed
        in, their time is over, or its results are out."""
        if assignment.mode != Mode.test:
            return False
        sitting = self.sittings.get((assignment.id, student))
        return stage_of(assignment, rules, sitting, self.now) in {Stage.over, Stage.missed, Stage.shown}

    def _sent(self, assignment: Assignment, key: Key, found: _Found) -> Sequence[Sent]:
        """Of a test, what was sent while its student sat it."""
        sent = found.sent.get(key, ())
        if assignment.mode != Mode.test:
            return sent
        sitting = self.sittings.get((assignment.id, key[0]))
        return in_sitting(sent, sitting.began_at, sitting.handed_in_at) if sitting else ()


def state_of(
    rules: Rules, marks: Sequence[ExerciseMark], now: datetime, *, sat: bool = False, ended: bool = False
) -> State:
    """Excused goes before all else; a mark that was set counts as something sent.

    Of a test: `sat` by who has begun it, for whom it has opened whatever its dates have become; `ended` for who can
    send nothing any more.
    """
    if rules.excused or (marks and all(one.excused for one in marks)):
        return State.excused
    begun = any(one.points is not None for one in marks)
    if ended:
        return State.done if begun else State.absent
    if now < rules.opens_at and not sat:
        return State.upcoming
    end = rules.last_moment or rules.due_at
    if end is None:
        return State.done if begun else State.open
    if now <= end:
        return State.open
    return State.done if begun else State.absent
