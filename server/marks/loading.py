"""The marks of a class. All that they are made of is asked for each time; they are made again where something of it has
changed, or time has passed by an instant on which they depend."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import told as assignments
from server.assignments.counting import in_sitting
from server.assignments.feedback import Stage, stage_of
from server.assignments.models import Assigned, Assignment, Counts, Exemption, Late, Mode, Sitting
from server.assignments.rules import Rules, in_force
from server.assignments.told import ToldAssignments
from server.base.caches import Lately
from server.classes import repository as classes
from server.classes.models import SchoolClass
from server.classes.schemas import Listed
from server.course import Course
from server.database import Told
from server.gradebook.sent import Revisions, revisions
from server.marks import repository
from server.marks.schemas import (
    ActiveOverride,
    AssignmentMark,
    ExerciseMark,
    Gradebook,
    MarkState,
    StudentExercise,
    StudentMarks,
)
from server.marks.sent import Graded, Terms, Trail, Trails, graded, known, known_mark, mark_of

ALL_TITLE = "Exercices du module"
ALWAYS = datetime(2000, 1, 1, tzinfo=UTC)
MOST_KEPT = 60_000  # marks at exercises of the books looked at last, and rows that they are made of: 1 kB each at most


@dataclass(frozen=True)
class _Told:
    """All that a book is made of. Told again as it was, the book is the same at the same time."""

    students: Sequence[Told]
    given: ToldAssignments
    overrides: Sequence[Told]
    revisions: Revisions
    module: str
    archived_at: datetime | None


@dataclass(frozen=True, eq=False)
class _Kept:
    """What a book holds, made of what was `told`. `instants`: those on which it depends; `place`: where its moment is
    among them. Nothing of it belongs to a session."""

    course: Course
    told: _Told
    assignments: tuple[Assignment, ...]
    rows: tuple[StudentMarks, ...]
    titles: Mapping[str, str]
    exercises: Mapping[UUID, tuple[Assigned, ...]]
    instants: Sequence[datetime]
    place: tuple[int, int]
    made: object = field(default_factory=object)

    def holds(self, course: Course, told: _Told, now: datetime) -> bool:
        return self.course is course and self.place == _place(self.instants, now) and self.told == told

    def book(self, school_class: SchoolClass, now: datetime) -> Gradebook:
        return Gradebook(school_class, now, self.assignments, self.rows, self.titles, self.exercises, self.made)

    @property
    def size(self) -> int:
        told = sum(map(len, (*self.told.given, self.told.students, self.told.overrides)))
        return told + len(self.rows) * sum(map(len, self.exercises.values())) + 1


_KEPT: Lately[tuple[UUID, tuple[UUID, ...] | None], _Kept] = Lately(MOST_KEPT, size=lambda kept: kept.size)


def load_gradebook(
    db: Session, course: Course, school_class: SchoolClass, now: datetime, only: Collection[UUID] | None = None
) -> Gradebook:
    """The marks of its students, or of some; no staff, and nobody who has left or only asks to join."""
    told = _told(db, school_class, only)
    key = school_class.id, None if only is None else tuple(only)
    kept = _KEPT.get(key)
    if kept is None or not kept.holds(course, told, now):
        kept = _KEPT.put(key, _made(db, course, school_class, told, now))
    return kept.book(school_class, now)


def _told(db: Session, school_class: SchoolClass, only: Collection[UUID] | None) -> _Told:
    """Five queries, six where there are tests, whatever the class."""
    students = classes.told(db, school_class.id, only)
    return _Told(
        students=students,
        given=assignments.of_class(db, school_class.id),
        overrides=repository.told(db, school_class.id, only),
        revisions=revisions(db, classes.identities(db, students)),
        module=school_class.module,
        archived_at=school_class.archived_at,
    )


def _made(db: Session, course: Course, school_class: SchoolClass, told: _Told, now: datetime) -> _Kept:
    students = classes.listed(db, told.students)
    found = assignments.read(db, told.given)
    given, exercises = found.assignments, found.exercises
    if not given:
        given, exercises = _without_assignment(course, school_class)
    asked = [
        _Asked.of(one, exercises.get(one.id, ()), found.exemptions.get(one.id, ()), found.sittings.get(one.id, {}))
        for one in given
    ]
    names = {one.exercise for rows in exercises.values() for one in rows}
    sent, sent_as = graded(db, told.revisions, names, school_class.archived_at)
    marks = _Found(sent, repository.read(db, told.overrides))
    weights = tuple(one.weight for one in given)
    rows = tuple(
        StudentMarks(member, tuple(one.mark(member, marks, now) for one in asked), weights) for member in students
    )
    instants = _instants(asked, rows)
    return _Kept(
        course=course,
        told=replace(told, revisions=sent_as),
        assignments=tuple(given),
        rows=rows,
        titles={name: course.exercises[name].title for name in names if name in course.exercises},
        exercises={one.id: tuple(exercises.get(one.id, ())) for one in given},
        instants=instants,
        place=_place(instants, now),
    )


def _place(instants: Sequence[datetime], now: datetime) -> tuple[int, int]:
    """Before, at or after which of them: whatever compares a time with them finds the same where this is the same."""
    return bisect_left(instants, now), bisect_right(instants, now)


def _instants(asked: Sequence[_Asked], rows: Sequence[StudentMarks]) -> Sequence[datetime]:
    """All that a book compares its moment with (`state_of`, `feedback.stage_of`, `schemas.held_back`)."""
    found = {one.assignment.released_at for one in asked}
    for row in rows:
        for one, mark in zip(asked, row.marks, strict=True):
            rules, sitting = mark.rules, one.sittings.get(row.member.id)
            found |= {rules.opens_at, rules.due_at, rules.closes_at}
            found.add(None if sitting is None else rules.end_of_sitting(sitting.began_at))
    return sorted(one for one in found if one is not None)


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


def load_unassigned_mark(db: Session, school_class: SchoolClass, student: UUID, exercise: str) -> ExerciseMark:
    """A student's mark at an exercise that no assignment of the class asks: the best of all attempts."""
    sent, _ = graded(db, revisions(db, [student]), [exercise], school_class.archived_at)
    found = _Found(sent, repository.load_overrides(db, school_class.id, [student], [exercise]))
    rules = in_force(_everything(school_class), (), student, ())
    key = (student, exercise)
    return found.at(key, found.sent.get(key, ()), rules, Terms.of(rules, Counts.best, 1.0))


class _Found:
    """What was sent and what was set, by student and exercise."""

    def __init__(self, sent: Trails, overrides: Mapping[StudentExercise, ActiveOverride]) -> None:
        self.sent, self.overrides = sent, overrides

    def at(self, key: StudentExercise, sent: Sequence[Graded], rules: Rules, terms: Terms) -> ExerciseMark:
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

    def mark(self, member: Listed, found: _Found, now: datetime) -> AssignmentMark:
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
) -> MarkState:
    """Excused goes before all else; a mark that was set counts as something sent.

    Of a test: `sat` by who has begun it, for whom it has opened whatever its dates have become; `ended` for who can
    send nothing any more.
    """
    if rules.excused or (marks and all(one.excused for one in marks)):
        return MarkState.excused
    begun = any(one.points is not None for one in marks)
    if ended:
        return MarkState.done if begun else MarkState.absent
    if now < rules.opens_at and not sat:
        return MarkState.upcoming
    end = rules.last_moment or rules.due_at
    if end is None:
        return MarkState.done if begun else MarkState.open
    if now <= end:
        return MarkState.open
    return MarkState.done if begun else MarkState.absent
