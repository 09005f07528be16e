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
from server.desk.talk.schemas import Change, StandingRow, StudentHead, StudentPage, TriedRow, WorkPage
from server.desk.views import head, href_of
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


class Student:
    """A student of a class, and until when their work is read there (None: it still is)."""

    def __init__(self, place: ClassAccess, member: Member) -> None:
        self.place, self.member = place, member
        left = member.membership.left_at if member.status is Status.left else None
        ends = [one for one in (left, place.school_class.archived_at) if one is not None]
        self.until: datetime | None = min(ends, default=None)

    @property
    def href(self) -> str:
        return f"{href_of(self.place.school_class)}/eleves/{self.member.id}"

    def in_exercise(self, exercise: str) -> str:
        return f"{self.href}/{exercise}"

    @property
    def view(self) -> StudentHead:
        why = LEFT if self.member.status is Status.left else ARCHIVED
        gone = "" if self.until is None else GONE.format(why=why, when=short_moment(self.until))
        return StudentHead(self.member.name, self.href, self.member.groups, gone)


def student_of(reader: Reader, place: ClassAccess, student: UUID) -> Student:
    """Who is, or was, a student of this class. Raises NotFound."""
    membership: Membership | None = classes.find_membership(reader.db, place.school_class.id, student)
    was_in = membership is not None and not (membership.status == Status.left and membership.left_at is None)
    if membership is None or membership.role != ClassRole.student or membership.status == Status.pending or not was_in:
        raise NotFound(NOT_A_MEMBER)
    account = reader.db.get(Account, student)
    assert account is not None  # a membership goes with its account
    return Student(place, Member(membership, account))


def student_page(reader: Reader, student: Student) -> StudentPage:
    school_class = student.place.school_class
    module = reader.course.modules.get(school_class.module)
    tried = student_work.load_by_exercise(reader.db, student.member.id, school_class.module, student.until)
    asking = service.count_open_questions(reader.db, student.member.id, student.until)
    exercises = exercises_in_reading_order(module) if module else []
    rows = tuple(_standing(student, one, tried.get(one.id), asking.get(one.id, 0)) for one in exercises)
    return StudentPage(
        head=head(reader.course, student.place, "/eleves"),
        student=student.view,
        rows=rows,
        solved=sum(row.tone == "done" for row in rows),
        asking=sum(row.asking for row in rows),
    )


def _standing(student: Student, exercise: Exercise, tried: ExerciseWork | None, asking: int) -> StandingRow:
    tone = "none" if tried is None else "done" if tried.best == 1 else "trying"
    sign, word = STATES[tone]
    return StandingRow(
        title=exercise.title,
        href=student.in_exercise(exercise.id),
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


def exercise_of(reader: Reader, place: ClassAccess, module: str, slug: str) -> Exercise:
    """An exercise of the class's module. Raises NotFound."""
    exercise = reader.course.exercises.get(f"{module}/{slug}")
    if exercise is None or module != place.school_class.module:
        raise NotFound(NO_SUCH_EXERCISE)
    return exercise


def work_page(
    reader: Reader,
    student: Student,
    exercise: Exercise,
    account: Account,
    chosen: int | None,
    number: int,
    draft: Draft,
) -> WorkPage:
    """`chosen` is the attempt whose change is shown, else the latest; `number` the page of the list, from 1."""
    member, href = student.member, student.in_exercise(exercise.id)
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
        head=head(reader.course, student.place, "/eleves"),
        student=student.view,
        exercise_title=exercise.title,
        exercise_href=exercise_href(exercise),
        action=href,
        attempts=tuple(_row(exercise, one, href, shown) for one in tried),
        total=total,
        newer=f"{address}{number - 1}" if number > 1 else "",
        older=f"{address}{number + 1}" if skipped + ATTEMPTS_A_PAGE < total else "",
        change=_change(reader, student, exercise, shown) if shown else None,
        threads=thread_views(talks, account),
        writer=writer_view(reader.db, account, exercise.id, href, staff=True, diagnosis=latest),
        draft=draft,
        word_href=_word_href(student.place, exercise, latest),
    )


def _word_href(place: ClassAccess, exercise: Exercise, mistake: str | None) -> str:
    about = f"&erreur={quote(mistake, safe='')}" if mistake else ""
    return f"{href_of(place.school_class)}/mots?exercice={quote(exercise.id, safe='')}{about}#ecrire"


def _row(exercise: Exercise, tried: AttemptSummary, href: str, shown: int) -> TriedRow:
    return TriedRow(
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


def _change(reader: Reader, student: Student, exercise: Exercise, number: int) -> Change | None:
    """Raises NotFound for an attempt that is not there."""
    pair = student_work.load_with_previous(reader.db, student.member.id, exercise.id, student.until, number)
    if not pair:
        raise NotFound(NO_SUCH_ATTEMPT)
    if len(pair) == 1 or exercise.answers is not None:
        return None
    before, after = pair
    hrefs = [f"/soumissions/{one.id}" for one in pair]
    return Change(number, compare_side_by_side(before.code, after.code), *hrefs)
