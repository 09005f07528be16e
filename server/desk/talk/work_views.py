"""From one student's work to what the templates show of it."""

from __future__ import annotations

from datetime import datetime
from urllib.parse import quote
from uuid import UUID

from server.base.errors import NotFound
from server.classes import repository as classes
from server.classes.models import ClassRole, Membership, Status
from server.classes.schemas import Member
from server.classes.service import NOT_A_MEMBER
from server.comments import service
from server.comments.side_by_side import compare_side_by_side
from server.course import Exercise
from server.desk.talk.schemas import AttemptListRow, CodeChange, StandingRow, StudentHead, StudentPage, WorkPage
from server.desk.views import class_head, class_href
from server.gradebook import student_work
from server.gradebook.student_work import AttemptSummary, ExerciseWork
from server.identity.models import Account
from server.rights.service import ClassAccess
from server.web import verdicts
from server.web.threads import Draft, thread_views, writer_view
from server.web.views import Reader, exercise_href, exercises_in_reading_order
from server.web.words import format_mark, iso_moment, short_moment

ATTEMPTS_A_PAGE = 50
NO_SUCH_EXERCISE = "Cet exercice n’est pas de ceux de la classe."
LEFT, ARCHIVED = "Cet élève est sorti de la classe", "La classe est archivée"
GONE = "{why} : ce qui a été envoyé après le {when} n’est pas montré."
NO_SUCH_ATTEMPT = "Cet essai n’existe pas."
STATES = {"done": ("✓", "réussi"), "trying": ("✗", "pas encore réussi"), "none": ("·", "pas commencé")}


class StudentWork:
    """A student of a class, and until when their work is read there (None: it still is)."""

    def __init__(self, access: ClassAccess, member: Member) -> None:
        self.access, self.member = access, member
        left = member.membership.left_at if member.status is Status.left else None
        ends = [moment for moment in (left, access.school_class.archived_at) if moment is not None]
        self.until: datetime | None = min(ends, default=None)

    @property
    def href(self) -> str:
        return f"{class_href(self.access.school_class)}/eleves/{self.member.id}"

    def exercise_href(self, exercise: str) -> str:
        return f"{self.href}/{exercise}"

    @property
    def view(self) -> StudentHead:
        why = LEFT if self.member.status is Status.left else ARCHIVED
        gone = "" if self.until is None else GONE.format(why=why, when=short_moment(self.until))
        return StudentHead(self.member.name, self.href, self.member.groups, gone)


def find_student_work(reader: Reader, access: ClassAccess, student: UUID) -> StudentWork:
    """Who is, or was, a student of this class. Raises NotFound."""
    membership: Membership | None = classes.find_membership(reader.db, access.school_class.id, student)
    was_in = membership is not None and not (membership.status == Status.left and membership.left_at is None)
    if membership is None or membership.role != ClassRole.student or membership.status == Status.pending or not was_in:
        raise NotFound(NOT_A_MEMBER)
    account = reader.db.get(Account, student)
    assert account is not None  # a membership goes with its account
    return StudentWork(access, Member(membership, account))


def build_student_page(reader: Reader, student: StudentWork) -> StudentPage:
    school_class = student.access.school_class
    module = reader.course.modules.get(school_class.module)
    tried = student_work.load_by_exercise(reader.db, student.member.id, school_class.module, student.until)
    asking = service.count_open_questions(reader.db, student.member.id, student.until)
    exercises = exercises_in_reading_order(module) if module else []
    rows = tuple(
        _standing_row(student, exercise, tried.get(exercise.id), asking.get(exercise.id, 0)) for exercise in exercises
    )
    return StudentPage(
        head=class_head(reader.course, student.access, "/eleves"),
        student=student.view,
        rows=rows,
        solved=sum(row.tone == "done" for row in rows),
        asking=sum(row.asking for row in rows),
    )


def _standing_row(student: StudentWork, exercise: Exercise, tried: ExerciseWork | None, asking: int) -> StandingRow:
    tone = "none" if tried is None else "done" if tried.best == 1 else "trying"
    sign, word = STATES[tone]
    return StandingRow(
        title=exercise.title,
        href=student.exercise_href(exercise.id),
        tone=tone,
        sign=sign,
        word=word,
        points="" if tried is None or tried.best is None else format_mark(20 * tried.best),
        attempts=0 if tried is None else tried.attempts,
        when="" if tried is None else iso_moment(tried.last_at),
        when_text="" if tried is None else short_moment(tried.last_at),
        mistake="" if tried is None else tried.mistake,
        asking=asking,
    )


def find_class_exercise(reader: Reader, access: ClassAccess, module: str, slug: str) -> Exercise:
    """An exercise of the class's module. Raises NotFound."""
    exercise = reader.course.exercises.get(f"{module}/{slug}")
    if exercise is None or module != access.school_class.module:
        raise NotFound(NO_SUCH_EXERCISE)
    return exercise


def build_work_page(
    reader: Reader,
    student: StudentWork,
    exercise: Exercise,
    account: Account,
    chosen: int | None,
    number: int,
    draft: Draft,
) -> WorkPage:
    """`chosen` is the attempt whose change is shown, else the latest; `number` the page of the list, from 1."""
    member, href = student.member, student.exercise_href(exercise.id)
    skipped = (number - 1) * ATTEMPTS_A_PAGE
    found = (reader.db, member.id, exercise.id, student.until)
    tried, total = student_work.list_attempts(*found, limit=ATTEMPTS_A_PAGE, offset=skipped)
    if skipped and not tried:
        raise NotFound("Il n’y a pas d’essais plus anciens.")
    shown = chosen or (tried[0].number if tried else 0)
    latest = tried[0].diagnosis if tried else None
    talks = service.load_exercise_conversations(*found)
    address = f"{href}?page="
    return WorkPage(
        head=class_head(reader.course, student.access, "/eleves"),
        student=student.view,
        exercise_title=exercise.title,
        exercise_href=exercise_href(exercise),
        action=href,
        attempts=tuple(_attempt_row(exercise, attempt, href, shown) for attempt in tried),
        total=total,
        newer=f"{address}{number - 1}" if number > 1 else "",
        older=f"{address}{number + 1}" if skipped + ATTEMPTS_A_PAGE < total else "",
        change=_code_change(reader, student, exercise, shown) if shown else None,
        threads=thread_views(talks, account),
        writer=writer_view(reader.db, account, exercise.id, href, staff=True, diagnosis=latest),
        draft=draft,
        word_href=_note_href(student.access, exercise, latest),
    )


def _note_href(access: ClassAccess, exercise: Exercise, mistake: str | None) -> str:
    about = f"&erreur={quote(mistake, safe='')}" if mistake else ""
    return f"{class_href(access.school_class)}/mots?exercice={quote(exercise.id, safe='')}{about}#ecrire"


def _attempt_row(exercise: Exercise, tried: AttemptSummary, href: str, shown: int) -> AttemptListRow:
    return AttemptListRow(
        number=tried.number,
        href=f"/soumissions/{tried.id}",
        compared_href=f"{href}?essai={tried.number}#changement"
        if tried.number > 1 and exercise.answers is None
        else "",
        here=tried.number == shown,
        points="" if tried.score is None else format_mark(20 * tried.score),
        outcome=verdicts.outcome_title(tried.outcome, exercise.kind),
        mistake=tried.mistake,
        when=iso_moment(tried.sent_at),
        when_text=short_moment(tried.sent_at),
    )


def _code_change(reader: Reader, student: StudentWork, exercise: Exercise, number: int) -> CodeChange | None:
    """Raises NotFound for an attempt that is not there."""
    pair = student_work.load_with_previous(reader.db, student.member.id, exercise.id, student.until, number)
    if not pair:
        raise NotFound(NO_SUCH_ATTEMPT)
    if len(pair) == 1 or exercise.answers is not None:
        return None
    before, after = pair
    hrefs = [f"/soumissions/{attempt.id}" for attempt in pair]
    return CodeChange(number, compare_side_by_side(before.code, after.code), *hrefs)
