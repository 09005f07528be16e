"""The page of a test for its student, and the release of its results for its teacher."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime

from sqlalchemy.orm import Session

from server.assignments import feedback, releases, repository, sitting_repository
from server.assignments.models import Assignment, EndedBy
from server.assignments.releases import ReleaseEffects
from server.assignments.rules import MAX_POINTS, SendingWindow, SendTiming
from server.assignments.sittings import StudentTest
from server.classes.repository import load_active_students
from server.database import utc_now
from server.desk.schemas import ReleaseView, SittingExercise, SittingPage
from server.desk.views import class_head
from server.gradebook import service as gradebook
from server.identity.models import Account
from server.rights.service import ClassAccess
from server.web.form_version import form_version_tag
from server.web.views import Reader
from server.web.words import count_with_noun, format_points, join_names_with_limit


def own_labels(access: ClassAccess) -> Sequence[str]:
    return access.membership.groups if access.membership is not None else ()


def sitting_href(test: Assignment) -> str:
    return feedback.sitting_path(test.class_id, test.id)


def build_sitting_page(
    reader: Reader, access: ClassAccess, own: StudentTest, account: Account, now: datetime
) -> SittingPage:
    test, rules = own.assignment, own.rules
    ends = own.ends_at if own.sitting is not None else rules.latest_sitting_end(max(now, rules.opens_at))
    minutes = None if rules.duration is None else round(rules.duration.total_seconds() / 60)
    return SittingPage(
        head=class_head(reader.course, access),
        title=test.title,
        stage=own.stage,
        opens=rules.opens_at,
        closes=rules.closes_at,
        begin_by=SendingWindow(rules).ends_at,
        late=describe_late_beginning(rules.judge_timing(own.sitting.began_at if own.sitting is not None else now)),
        minutes="" if minutes is None else count_with_noun(minutes, "minute"),
        extra=rules.time_factor > 1.0,
        now=now,
        ends=ends,
        handed_in=own.sitting is not None and own.sitting.ended_by == EndedBy.student,
        exercises=_sitting_exercises(reader, own, account),
        action=sitting_href(test).removesuffix("/composer"),
    )


def describe_late_beginning(timing: SendTiming) -> str:
    """A sentence on a test that is begun late; empty for one that is begun in time."""
    if not timing.days_late:
        return ""
    days = count_with_noun(timing.days_late, "jour de retard", "jours de retard")
    late = f"La date pour commencer est passée ({days}) : "
    if not timing.penalty:
        return late + "ce que vous enverrez comptera en entier, marqué en retard."
    lost = min(timing.penalty, MAX_POINTS)
    return late + f"ce que vous enverrez perdra {format_points(lost)} {'point' if lost < 2 else 'points'} sur 20."


def _sitting_exercises(reader: Reader, own: StudentTest, account: Account) -> tuple[SittingExercise, ...]:
    """Those that this server has; what was sent counts since the sitting began."""
    assigned = repository.load_exercises(reader.db, [own.assignment.id])[own.assignment.id]
    known = [
        reader.course.exercises[weighted.exercise]
        for weighted in assigned
        if weighted.exercise in reader.course.exercises
    ]
    saved = sitting_repository.load_last_save_times(reader.db, own.assignment.id, account.id)
    began = own.sitting.began_at if own.sitting is not None else own.rules.opens_at
    since = {exercise.id: began for exercise in known}
    sent = gradebook.count_attempts_since(reader.db, account.id, since)
    failed = gradebook.count_internal_errors_since(reader.db, account.id, since)
    return tuple(
        SittingExercise(
            exercise,
            sent.get(exercise.id, 0),
            failed.get(exercise.id, 0),
            exercise.id not in sent or _does_last_file_run(reader, account, exercise.id),
            saved.get(exercise.id),
        )
        for exercise in known
    )


def _does_last_file_run(reader: Reader, account: Account, exercise_id: str) -> bool:
    last = gradebook.find_latest_attempt(reader.db, account, exercise_id)
    return last is None or not last.load_error


def release_view(db: Session, test: Assignment) -> ReleaseView:
    """For the page of a test, as its teacher sees it."""
    now = utc_now()
    begun, ended = sitting_repository.count_begun_and_ended_sittings(db, test.id)
    waits = not begun and test.opens_at > now
    effects = releases.load_release_effects(db, test, now)
    reopenable = releases.load_students_handed_in(db, test) if test.released_at is None else ()
    students = load_active_students(db, test.class_id) if reopenable else ()
    return ReleaseView(
        action=f"{sitting_href(test).removesuffix('/composer')}/publier",
        opens=test.opens_at if waits else None,
        released=test.released_at,
        begun=begun,
        sitting=begun - ended,
        effects=release_lines(effects),
        version=release_version(effects),
        may_withdraw=releases.can_still_withdraw_release(test, now),
        copies=tuple((str(student.id), student.name) for student in students if student.id in reopenable),
    )


def release_lines(effects: ReleaseEffects) -> tuple[str, ...]:
    """Return what a release now does to whom, a line each."""
    lines = []
    if effects.shut_out:
        count = count_with_noun(
            len(effects.shut_out),
            "élève n’a pas commencé et ne pourra plus",
            "élèves n’ont pas commencé et ne pourront plus",
        )
        lines.append(f"{count} : {join_names_with_limit([student.name for student in effects.shut_out])}.")
    if effects.running:
        count = count_with_noun(len(effects.running), "élève compose encore,", "élèves composent encore, chacun")
        lines.append(
            f"{count} jusqu’à sa propre fin : {join_names_with_limit([student.name for student in effects.running])}."
        )
    return tuple(lines)


def release_version(effects: ReleaseEffects) -> str:
    """Return the version tag of these effects: other students, another tag."""
    touched = {"shut_out": effects.shut_out, "running": effects.running}
    return form_version_tag(
        {name: " ".join(str(student.id) for student in students) for name, students in touched.items()}
    )
