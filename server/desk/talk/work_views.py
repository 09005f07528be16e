"""The pages of one student's work, as those who teach them see it."""

from __future__ import annotations

from datetime import datetime
from typing import Any
from uuid import UUID

from server.base.errors import NotFound
from server.classes import repository as classes
from server.classes.models import ClassRole, Membership, Status
from server.classes.schemas import Member
from server.classes.service import NOT_A_MEMBER
from server.comments import service
from server.comments.side_by_side import compare_side_by_side
from server.course import Exercise
from server.desk.views import class_head, class_href
from server.gradebook import student_work
from server.gradebook.team_work import TeammateAttempt, load_teammate_attempts
from server.identity.models import Account
from server.rights.service import ClassAccess
from server.web.threads import UnsentMessageDraft, build_message_form, build_thread_views
from server.web.views import Reader, exercises_in_reading_order
from server.web.words import format_short_time

ATTEMPTS_A_PAGE = 50
NO_SUCH_EXERCISE = "Cet exercice n’est pas de ceux de la classe."
LEFT, ARCHIVED = "Cet élève est sorti de la classe", "La classe est archivée"
GONE = "{why} : ce qui a été envoyé après le {when} n’est pas montré."
NO_SUCH_ATTEMPT = "Cet essai n’existe pas."


class StudentWork:
    """A student of a class; `until`: their work is read up to then (None: without an end)."""

    def __init__(self, access: ClassAccess, member: Member) -> None:
        self.access, self.member = access, member
        self.name, self.groups = member.name, member.groups
        self.href = f"{class_href(access.school_class)}/eleves/{member.id}"
        left = member.membership.left_at if member.status is Status.left else None
        ends = [moment for moment in (left, access.school_class.archived_at) if moment is not None]
        self.until: datetime | None = min(ends, default=None)

    def exercise_href(self, exercise: str) -> str:
        return f"{self.href}/{exercise}"

    @property
    def gone(self) -> str:
        """Return since when nothing more of their work is read, in a sentence; empty where it still is."""
        why = LEFT if self.member.status is Status.left else ARCHIVED
        return "" if self.until is None else GONE.format(why=why, when=format_short_time(self.until))


def find_student_work(reader: Reader, access: ClassAccess, student: UUID) -> StudentWork:
    """Return a present or former student of this class. Raise NotFound."""
    membership: Membership | None = classes.find_membership(reader.db, access.school_class.id, student)
    was_in = membership is not None and not (membership.status == Status.left and membership.left_at is None)
    if membership is None or membership.role != ClassRole.student or membership.status == Status.pending or not was_in:
        raise NotFound(NOT_A_MEMBER)
    account = reader.db.get(Account, student)
    assert account is not None  # a membership goes with its account
    return StudentWork(access, Member(membership, account))


def build_student_page(reader: Reader, student: StudentWork) -> dict[str, Any]:
    school_class = student.access.school_class
    module = reader.course.modules.get(school_class.module)
    work = student_work.load_work_by_exercise(reader.db, student.member.id, school_class.module, student.until)
    by_pair = load_teammate_attempts(reader.db, [student.member.id], class_id=school_class.id, until=student.until)
    shared = {name: attempt for (_, name), attempt in by_pair.items() if name not in work}
    asking = service.count_open_questions(reader.db, student.member.id, student.until)
    exercises = exercises_in_reading_order(module) if module else []
    served = {exercise.id for exercise in exercises}
    own = (reader.course.exercises.get(name) for name in sorted(work.keys() - served))
    exercises += [exercise for exercise in own if exercise is not None]
    return {
        "head": class_head(reader.course, student.access, "/eleves"),
        "student": student,
        "rows": [(exercise, work.get(exercise.id), asking.get(exercise.id, 0)) for exercise in exercises],
        "shared": shared,
        "solved": sum(_is_solved(work.get(exercise.id), shared.get(exercise.id)) for exercise in exercises),
        "asking": sum(asking.get(exercise.id, 0) for exercise in exercises),
    }


def _is_solved(own: student_work.ExerciseWork | None, shared: TeammateAttempt | None) -> bool:
    return own.best == 1 if own else shared is not None and shared.score == 1


def find_class_exercise(reader: Reader, access: ClassAccess, module: str, slug: str) -> Exercise:
    """Return an exercise of the class's module. Raise NotFound."""
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
    draft: UnsentMessageDraft,
) -> dict[str, Any]:
    """Build page `number` (from 1) of a student's attempts at an exercise, with the change made by attempt `chosen`.

    Without `chosen`, the change of the latest attempt on the page is shown. Raise NotFound beyond the last page.
    """
    href = student.exercise_href(exercise.id)
    skipped = (number - 1) * ATTEMPTS_A_PAGE
    work = (reader.db, student.member.id, exercise.id, student.until)
    attempts, total = student_work.list_attempt_summaries(*work, limit=ATTEMPTS_A_PAGE, offset=skipped)
    if skipped and not attempts:
        raise NotFound("Il n’y a pas d’essais plus anciens.")
    shown = chosen or (attempts[0].number if attempts else 0)
    diagnosis = attempts[0].diagnosis if attempts else None
    return {
        "head": class_head(reader.course, student.access, "/eleves"),
        "student": student,
        "exercise": exercise,
        "shared": None if attempts else _load_shared(reader, student, exercise),
        "action": href,
        "attempts": attempts,
        "shown": shown,
        "total": total,
        "number": number,
        "more": skipped + ATTEMPTS_A_PAGE < total,
        "change": _code_change(reader, student, exercise, shown) if shown else None,
        "threads": build_thread_views(service.load_exercise_conversations(*work), account),
        "writer": build_message_form(reader.db, account, exercise.id, href, staff=True, diagnosis=diagnosis),
        "draft": draft,
        "diagnosis": diagnosis,
    }


def _load_shared(reader: Reader, student: StudentWork, exercise: Exercise) -> TeammateAttempt | None:
    """Return what a partner has sent for the student too, None without any."""
    own, class_id = student.member.id, student.access.school_class.id
    rows = load_teammate_attempts(reader.db, [own], class_id=class_id, exercise=exercise.id, until=student.until)
    return rows.get((own, exercise.id))


def _code_change(reader: Reader, student: StudentWork, exercise: Exercise, number: int) -> dict[str, Any] | None:
    """Compare an attempt with the one before it; None for the first, and without code. Raise NotFound."""
    pair = student_work.load_attempt_and_previous(reader.db, student.member.id, exercise.id, student.until, number)
    if not pair:
        raise NotFound(NO_SUCH_ATTEMPT)
    if len(pair) == 1 or exercise.answers is not None:
        return None
    return {"number": number, "pair": pair, "beside": compare_side_by_side(pair[0].code, pair[1].code)}
