"""A student's copy of an assignment on one page, to read and to print: code, verdicts, remarks and marks."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments.models import Assignment
from server.assignments.student_assignments import UNKNOWN
from server.assignments.team_repository import find_teammate_name
from server.base.errors import NotFound
from server.comments import service as comments
from server.course import Course
from server.database import utc_now
from server.gradebook import service as gradebook
from server.gradebook.figures import describe_figures
from server.gradebook.schemas import Attempt
from server.identity.models import Account
from server.marks import rubrics_repository
from server.marks.columns_repository import build_typed_mark, load_column_marks
from server.marks.loading import load_gradebook
from server.marks.means import format_number, format_points
from server.marks.own import describe_assignment_mark
from server.marks.rubric_items import OVERALL, RubricItem
from server.marks.schemas import AssignmentMark, ExerciseMark
from server.marks.service import load_visible_marks
from server.marks.states import STATE_WORDS
from server.marks.typed import format_typed_mark
from server.rights.service import ClassAccess
from server.web.code_lines import CodeView, build_code_view
from server.web.schemas import VerdictView
from server.web.threads import ThreadView, build_thread_views
from server.web.verdicts import build_verdict_view
from server.web.views import Reader
from server.web.words import count_with_noun


@dataclass(frozen=True)
class CopyPart:
    """An exercise of a copy, with the attempt that counts; `number` is None where there is none.

    `held`: what stands in place of a withheld verdict; `partner`: who has sent it, where the student has not.
    """

    title: str
    mark: str
    number: int | None = None
    href: str = ""
    sent_at: datetime | None = None
    late: str = ""
    code: CodeView | None = None
    verdict: VerdictView | None = None
    threads: tuple[ThreadView, ...] = ()
    held: str = ""
    partner: str = ""


@dataclass(frozen=True)
class MarkedItem:
    """A criterion of a rubric as its student reads it: « 2 / 3 », the words that were picked, the remark."""

    title: str
    points: str
    words: str
    remark: str


@dataclass(frozen=True)
class MarkedRubric:
    title: str
    mark: str
    items: tuple[MarkedItem, ...]
    remark: str


@dataclass(frozen=True)
class CopyView:
    """`mark` is empty while a test withholds it."""

    name: str
    mark: str
    parts: tuple[CopyPart, ...]
    rubric: MarkedRubric | None = None


def build_copy(
    reader: Reader,
    access: ClassAccess,
    assignment: Assignment,
    student: UUID,
    name: str,
    *,
    with_threads: bool = True,
) -> CopyView:
    """Build the copy as the reader may see it: its student without what is withheld from them, staff whole."""
    assert reader.account is not None
    own = reader.account.id == student
    mark, exercises = (_load_own_mark if own else _load_mark)(reader, access, assignment, student)
    parts = tuple(
        _build_copy_part(reader, reader.account, student, own_mark, mark, with_threads) for own_mark in exercises
    )
    return CopyView(
        name=name,
        mark="" if mark is None else describe_assignment_mark(mark),
        parts=parts,
        rubric=load_marked_rubric(reader.db, assignment, student),
    )


def _load_mark(
    reader: Reader, access: ClassAccess, assignment: Assignment, student: UUID
) -> tuple[AssignmentMark | None, tuple[ExerciseMark, ...]]:
    book = load_gradebook(reader.db, reader.course, access.school_class, utc_now(), only=[student])
    for row in book.rows:
        for each, mark in zip(book.assignments, row.marks, strict=True):
            if each.id == assignment.id:
                return mark, mark.exercises
    return None, ()


def _load_own_mark(
    reader: Reader, access: ClassAccess, assignment: Assignment, student: UUID
) -> tuple[AssignmentMark | None, tuple[ExerciseMark, ...]]:
    own = load_visible_marks(reader.db, reader.course, access.school_class, student, utc_now())
    for each in own.marks:
        if each.assignment.id == assignment.id:
            return each.mark, tuple(each.exercises.values())
    raise NotFound(UNKNOWN)  # it is for other groups


def _build_copy_part(
    reader: Reader,
    account: Account,
    student: UUID,
    mark: ExerciseMark,
    whole: AssignmentMark | None,
    with_threads: bool,
) -> CopyPart:
    title = _title_of_exercise(reader.course, mark.exercise)
    if mark.points is not None:
        points = f"{format_points(mark.points)} / 20"
    else:
        points = "" if whole is None else STATE_WORDS[mark.state_within(whole.state)]
    exercise = reader.course.exercises.get(mark.exercise)
    if mark.counted is None or exercise is None:
        return CopyPart(title, points)
    attempt = gradebook.find_attempt(reader.db, account, mark.counted.attempt)
    talks = comments.load_attempt_conversations(reader.db, attempt) if with_threads else ()
    is_code = exercise.answers is None
    talker = account if account.id == student else None  # on paper « vous » is the student
    code = build_code_view(attempt.submission.code, talks, talker) if is_code else None
    on_lines = {talk.thread.id for talk in talks if is_code and talk.lines is not None}
    return CopyPart(
        title=title,
        mark=points,
        number=gradebook.attempt_number(reader.db, attempt.submission),
        href=f"/soumissions/{attempt.submission.id}",
        sent_at=attempt.submission.created_at,
        late=f"{count_with_noun(mark.days_late, 'jour')} de retard" if mark.days_late else "",
        code=code,
        verdict=_build_attempt_verdict_view(reader, attempt),
        threads=build_thread_views([talk for talk in talks if talk.thread.id not in on_lines], talker),
        held=attempt.held_text,
        partner=find_teammate_name(reader.db, student, attempt.submission.account_id)
        if with_threads and attempt.submission.account_id != student
        else "",
    )


def _title_of_exercise(course: Course, exercise: str) -> str:
    known = course.exercises.get(exercise)
    return exercise if known is None else known.title


def _build_attempt_verdict_view(reader: Reader, attempt: Attempt) -> VerdictView | None:
    verdict = attempt.verdict
    if verdict is None or attempt.grading is None:
        return None
    exercise = reader.course.exercises[attempt.submission.exercise]
    texts = None if exercise.answers is None else exercise
    figures = f"/soumissions/{attempt.submission.id}/figures"
    grading = attempt.grading.id
    described = describe_figures(reader.db, grading, verdict)
    return build_verdict_view(verdict, figures, texts, exercise.functions, grading=grading, described=described)


def load_marked_rubric(db: Session, assignment: Assignment, student: UUID) -> MarkedRubric | None:
    """Load what a published rubric gave a student; None without one. The mark is that of the gradebook."""
    row = rubrics_repository.find_rubric(db, assignment.id)
    if row is None or row[1].published_at is None:
        return None
    rubric, column = row
    marking = rubrics_repository.find_rubric_marking(db, rubric.column_id, student)
    typed = load_column_marks(db, column.id).get(student)
    if typed is None or build_typed_mark(typed).points is None:
        return None
    mark = f"{format_typed_mark(build_typed_mark(typed))} / {format_number(column.out_of)}"
    if marking is None or marking.finished_at is None:
        return MarkedRubric(column.title, mark, (), "")
    given = rubrics_repository.read_rubric_scores(marking)
    items = tuple(
        _marked_item(item, given.points.get(item.id), given.remarks.get(item.id, ""))
        for item in rubrics_repository.read_rubric_items(rubric)
    )
    return MarkedRubric(column.title, mark, items, given.remarks.get(OVERALL, ""))


def _marked_item(item: RubricItem, points: float | None, remark: str) -> MarkedItem:
    words = next((level.text for level in item.levels if level.points == points), "")
    shown = "—" if points is None else f"{format_number(points)} / {format_number(item.points)}"
    return MarkedItem(item.title, shown, words, remark)
