"""« Après la séance »: the review of a lesson or of a week, each line with what to do about it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from urllib.parse import urlencode
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments.repository import load_class_assignments
from server.assignments.team_repository import load_places_of_team_assignments
from server.assignments.team_rules import list_current_partners
from server.base import school_time
from server.board.failed_checks import load_first_failed_checks
from server.board.lesson_review import MIN_DAYS, LessonReview, build_lesson_review, list_student_ids_to_see
from server.board.progress import ClassProgress
from server.board.service import load_class_progress
from server.board.stuck import StuckSign, StuckStudent
from server.classes.models import SchoolClass
from server.course import Course
from server.desk.board.links import BoardLinks, misconception_href
from server.desk.lesson.remedial import remedial_href
from server.desk.lesson.stuck_rows import failure_words, minutes_between, mistake_title
from server.desk.schemas import ClassHead
from server.desk.views import class_head, class_href
from server.lesson import repository as lessons
from server.lesson.models import LiveLesson
from server.lesson.service import lesson_end
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web.views import lesson_href
from server.web.words import format_short_day, join_words

WEEK = timedelta(days=7)
#: How long before a lesson others count as earlier ones: of a class with one a week, the last.
MEMORY = timedelta(days=8)

Link = tuple[str, str]


@dataclass(frozen=True)
class SeeRow:
    """A student to see; `mistake` is the last by its name, empty where it has none: then `failure` says what fails.

    `ending`: since when they make no progress or have sent nothing, in words, to be read after the failures. `days`:
    those of a week on which they made it, in words, empty for fewer than two; `named_before`: the day of the
    latest lesson of the week before whose page says to see them already, in words, or empty.
    """

    name: str
    href: str
    exercise: str
    failures: int
    mistake: str
    failure: str
    ending: str
    objectives: str
    remedial: str
    days: str
    named_before: str


@dataclass(frozen=True)
class ExplainRow:
    """A mistake to explain again: `example` shows its figure and counterexample, `lesson` is what to read again."""

    title: str
    href: str
    exercise: str
    people: tuple[Link, ...]
    example: str
    message: str
    lesson: Link | None
    remedial: str


@dataclass(frozen=True)
class FaultRow:
    """An exercise whose statement is to be looked at; `unexplained` students fail for an unknown reason."""

    title: str
    href: str
    tried: int
    solved: int
    unexplained: int


@dataclass(frozen=True)
class OvercomeRow:
    title: str
    exercise: str
    names: tuple[str, ...]


@dataclass(frozen=True)
class ReviewPage:
    """The review of a period: of a lesson, with its `exercises`, else of a week.

    `more_to_see` and `more_to_explain` are those for whom the lists have no room.
    """

    head: ClassHead
    is_lesson: bool
    since: datetime
    until: datetime
    exercises: tuple[str, ...]
    to_see: tuple[SeeRow, ...]
    more_to_see: tuple[Link, ...]
    to_explain: tuple[ExplainRow, ...]
    more_to_explain: int
    at_fault: tuple[FaultRow, ...]
    elsewhere: tuple[Link, ...]
    idle: tuple[Link, ...]
    absent: tuple[Link, ...]
    unknown: tuple[Link, ...]
    overcome: tuple[OvercomeRow, ...]
    idle_remedial: str

    @property
    def is_empty(self) -> bool:
        return not (self.to_see or self.to_explain or self.at_fault or self.elsewhere or self.idle or self.overcome)

    @property
    def is_anybody_silent(self) -> bool:
        """Whether somebody has sent nothing to the exercises of the period."""
        return bool(self.elsewhere or self.idle or self.absent or self.unknown)


def review_page(
    db: Session, course: Course, access: ClassAccess, now: datetime, lesson: LiveLesson | None
) -> ReviewPage:
    """Build the review of a lesson, or of the last seven days."""
    school_class = access.school_class
    earlier = () if lesson is None else lessons.load_earlier_lessons(db, lesson, MEMORY)
    besides = {name for each in (lesson, *earlier) if each is not None for name in each.exercises}
    progress = load_class_progress(db, course, school_class, now, besides=sorted(besides))
    exercises = progress.scope.exercises if lesson is None else tuple(lesson.exercises)
    since = now - WEEK if lesson is None else lesson.started_at
    until = now if lesson is None else min(now, lesson_end(lesson))
    review = build_lesson_review(
        progress, exercises, since, until, _load_partners(db, school_class), is_week=lesson is None
    )
    named_before = _days_named_before(progress, earlier)
    links = BoardLinks(course, class_href(school_class), progress.students)
    names = {student.id: student.name for student in progress.students}

    failures = load_first_failed_checks(db, [row.grading for row in review.to_see if row.mistake is None])
    may_assign = access.has(Right.manage_assignments) and school_class.archived_at is None

    def remedy(exercise: str, students: Collection[UUID]) -> str:
        return remedial_href(links.href, exercise, students) if may_assign else ""

    def person(account: UUID) -> Link:
        return names[account], f"{links.href}/eleves/{account}"

    return ReviewPage(
        head=class_head(course, access, "/seance"),
        is_lesson=lesson is not None,
        since=since,
        until=until,
        exercises=() if lesson is None else tuple(links.title(name) for name in exercises),
        to_see=tuple(
            SeeRow(
                names[row.account],
                f"{links.href}/eleves/{row.account}/{row.exercise}",
                links.title(row.exercise),
                row.failures,
                "" if row.mistake is None else mistake_title(course, row.exercise, row.mistake),
                failure_words(course, row.exercise, failures[row.grading]) if row.grading in failures else "",
                _ending_words(row.stuck, until),
                f"{links.href}/eleves/{row.account}/objectifs",
                remedy(row.exercise, [row.account]),
                join_words(map(format_short_day, row.days)) if len(row.days) >= MIN_DAYS else "",
                named_before.get(row.account, ""),
            )
            for row in review.to_see
        ),
        more_to_see=tuple(
            (names[row.account], f"{links.href}/eleves/{row.account}/{row.exercise}") for row in review.more_to_see
        ),
        to_explain=_explain_rows(course, links, review, remedy, may_write=access.has(Right.comment)),
        at_fault=tuple(
            FaultRow(
                links.title(row.exercise), links.exercise_href(row.exercise), row.tried, row.solved, row.unexplained
            )
            for row in review.at_fault
        ),
        more_to_explain=review.more_to_explain,
        elsewhere=tuple(map(person, review.elsewhere)),
        idle=tuple(map(person, review.idle)),
        absent=tuple(map(person, review.absent)),
        unknown=tuple(map(person, review.unknown)),
        overcome=tuple(
            OvercomeRow(
                mistake_title(course, row.exercise, row.id),
                links.title(row.exercise),
                tuple(names[account] for account in row.students),
            )
            for row in review.overcome
        ),
        idle_remedial=remedy(exercises[0] if exercises else "", [*review.idle, *review.absent, *review.unknown]),
    )


def _ending_words(row: StuckStudent | None, until: datetime) -> str:
    if row is None:
        return " sans progrès"
    what = " sans progrès" if row.sign is StuckSign.failures else ", rien envoyé"
    return f"{what} les {minutes_between(row.since, until)} dernières minutes"


def _days_named_before(progress: ClassProgress, earlier: Sequence[LiveLesson]) -> Mapping[UUID, str]:
    """Return on which day the page of an earlier lesson said to see a student, the latest of them."""
    days: dict[UUID, str] = {}
    for lesson in earlier:
        for account in list_student_ids_to_see(progress, lesson.exercises, lesson.started_at, lesson_end(lesson)):
            days.setdefault(account, format_short_day(school_time.to_local(lesson.started_at)))
    return days


def _load_partners(db: Session, school_class: SchoolClass) -> Mapping[UUID, Collection[UUID]]:
    """Load with whom each student hands in some assignment today."""
    partners: dict[UUID, set[UUID]] = defaultdict(set)
    for places in load_places_of_team_assignments(db, load_class_assignments(db, school_class.id)).values():
        for place in places:
            partners[place.account_id].update(
                each.account_id for each in list_current_partners(places, place.account_id)
            )
    return partners


def _explain_rows(
    course: Course,
    links: BoardLinks,
    review: LessonReview,
    remedy: Callable[[str, Collection[UUID]], str],
    *,
    may_write: bool,
) -> tuple[ExplainRow, ...]:
    rows = []
    for row in review.to_explain:
        query = urlencode({"exercice": row.exercise, "erreur": row.id})
        rows.append(
            ExplainRow(
                title=mistake_title(course, row.exercise, row.id),
                href=misconception_href(links.href, row.exercise, row.id),
                exercise=links.title(row.exercise),
                people=links.people(row.still, row.exercise),
                example=f"/soumissions/{row.example}",
                message=f"{links.href}/mots?{query}#ecrire" if may_write else "",
                lesson=_lesson_to_read(course, row.exercise),
                remedial=remedy(row.exercise, row.still),
            )
        )
    return tuple(rows)


def _lesson_to_read(course: Course, exercise: str) -> Link | None:
    """Return title and address of the lesson that an exercise follows."""
    served = course.exercises.get(exercise)
    if served is None:
        return None
    lessons = course.modules[served.module].lessons
    lesson = next((lesson for lesson in lessons if lesson.slug == served.seance), None)
    return None if lesson is None else (lesson.title, lesson_href(lesson))
