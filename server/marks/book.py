"""The marks of a class, made anew each time that they are asked for: six queries, or seven, whatever the class."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import papers
from server.assignments import repository as assignments
from server.assignments.counting import in_sitting
from server.assignments.feedback import Stage, stage_of
from server.assignments.models import Assigned, Assignment, Counts, Exemption, Late, Mode, Sitting
from server.assignments.rules import Rules, in_force
from server.classes import repository as classes
from server.classes.models import SchoolClass, Seat, Status
from server.classes.schemas import Member
from server.course import Course
from server.marks import repository
from server.marks.schemas import AssignmentMark, Book, ExerciseMark, Key, Row, Set, State
from server.marks.sent import Graded, Terms, Trail, Trails, graded, known, known_mark, mark_of

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
    asked = _asked(db, given, exercises)
    ids = [one.id for one in students]
    names = {one.exercise for rows in exercises.values() for one in rows}
    sent = graded(db, ids, names, school_class.archived_at)
    found = _Found(sent, repository.active(db, school_class.id, ids, names))
    weights = tuple(one.weight for one in given)
    return Book(
        school_class=school_class,
        at=now,
        assignments=tuple(given),
        rows=tuple(Row(member, tuple(one.mark(member, found, now) for one in asked), weights) for member in students),
        titles={name: course.exercises[name].title for name in names if name in course.exercises},
        exercises={one.id: tuple(exercises.get(one.id, ())) for one in given},
    )


def _asked(db: Session, given: Sequence[Assignment], exercises: Mapping[UUID, Sequence[Assigned]]) -> Sequence[_Asked]:
    exemptions = assignments.exemptions(db, [one.id for one in given])
    tests = [one.id for one in given if one.mode == Mode.test]
    sittings: dict[UUID, dict[UUID, Sitting]] = defaultdict(dict)
    for (assignment, student), sitting in (papers.sittings_of(db, tests) if tests else {}).items():
        sittings[assignment][student] = sitting
    return [
        _Asked.of(one, exercises.get(one.id, ()), exemptions.get(one.id, ()), sittings.get(one.id, {})) for one in given
    ]


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
    sent = graded(db, [student], [exercise], school_class.archived_at)
    found = _Found(sent, repository.active(db, school_class.id, [student], [exercise]))
    rules = in_force(_everything(school_class), (), student, ())
    key = (student, exercise)
    return found.at(key, found.sent.get(key, ()), rules, Terms.of(rules, Counts.best, 1.0))


class _Found:
    """What was sent and what was set, by student and exercise."""

    def __init__(self, sent: Trails, overrides: Mapping[Key, Set]) -> None:
        self.sent, self.overrides = sent, overrides

    def at(self, key: Key, sent: Sequence[Graded], rules: Rules, terms: Terms) -> ExerciseMark:
        """`terms` are those of the rules."""
        mark = (
            known_mark(key[1], sent, rules, terms) if isinstance(sent, Trail) else mark_of(key[1], sent, rules, terms)
        )
        override = self.overrides.get(key)
        return mark if override is None else replace(mark, override=override)


@dataclass(frozen=True)
class _Asked:
    """An assignment of a class, read once for all its students; `rules` and `terms` (of each exercise) are those of
    all, None where some differ."""

    assignment: Assignment
    exercises: Sequence[Assigned]
    exemptions: Sequence[Exemption]
    sittings: Mapping[UUID, Sitting]
    rules: Rules | None
    terms: Sequence[Terms]
    is_test: bool

    @classmethod
    def of(
        cls,
        assignment: Assignment,
        exercises: Sequence[Assigned],
        exemptions: Sequence[Exemption],
        sittings: Mapping[UUID, Sitting],
    ) -> _Asked:
        rules = None if exemptions else in_force(assignment, (), assignment.class_id, ())
        terms = () if rules is None else _terms(assignment, exercises, rules)
        return cls(assignment, exercises, exemptions, sittings, rules, terms, assignment.mode == Mode.test)

    def mark(self, member: Member, found: _Found, now: datetime) -> AssignmentMark:
        student = member.id
        rules = self.rules or in_force(self.assignment, self.exemptions, student, member.groups)
        terms = self.terms if self.rules else _terms(self.assignment, self.exercises, rules)
        sitting = self.sittings.get(student)
        marks = []
        for (exercise, _), its_terms in zip(self.exercises, terms, strict=True):
            sent: Sequence[Graded] = found.sent.get((student, exercise), ())
            if self.is_test:
                sent = in_sitting(sent, sitting.began_at, sitting.handed_in_at) if sitting else ()
            marks.append(found.at((student, exercise), sent, rules, its_terms))
        ended = self._ended(rules, sitting, now)
        state = state_of(rules, marks, now, sat=sitting is not None, ended=ended)
        return known(AssignmentMark(rules, state, tuple(marks), ended), (self.assignment.id, student))

    def _ended(self, rules: Rules, sitting: Sitting | None, now: datetime) -> bool:
        """Whether it is a test in which this student can send nothing any more, whatever its dates: they have handed
        in, their time is over, or its results are out."""
        if not self.is_test:
            return False
        return stage_of(self.assignment, rules, sitting, now) in {Stage.over, Stage.missed, Stage.shown}


def _terms(assignment: Assignment, exercises: Sequence[Assigned], rules: Rules) -> Sequence[Terms]:
    counts = Counts(assignment.counts)
    return [Terms.of(rules, counts, weight) for _, weight in exercises]


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
