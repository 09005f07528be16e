"""Regrades: begun, looked at, applied, undone."""

from collections import Counter

from fastapi import APIRouter

from server.api.documentation import problem_responses
from server.api.regrade_schemas import ChangeOut, NewRegrade, ProgressOut, RegradeBegun, RegradeOut
from server.classes.service import require_not_archived
from server.course.dependencies import CourseOf
from server.course.models import Course
from server.database.dependencies import Db
from server.identity.dependencies import ApiAccount
from server.identity.models import Account
from server.regrades import applying, service
from server.regrades.dependencies import RegradeServiceOf
from server.regrades.models import Regrade, RegradePolicy
from server.regrades.schemas import MarkOutcome, RegradeInput
from server.rights import service as rights
from server.rights.models import Right
from server.web import regraded

router = APIRouter(prefix="/classes/{class_id}/regrades", tags=["classes"])


@router.post("", status_code=202, responses=problem_responses(400, 401, 403, 404, 409, 413, 422))
def begin(class_id: str, body: NewRegrade, account: ApiAccount, store: RegradeServiceOf, db: Db) -> RegradeBegun:
    """Grades attempts anew in the background; nothing counts until it is applied."""
    place = rights.require_right(db, account, Right.regrade, class_id)
    wanted = RegradeInput(body.exercise, RegradePolicy(body.policy), body.assignment, body.student)
    return RegradeBegun(id=store.start_regrade(db, place.school_class, account.id, wanted).id)


@router.get("/{regrade_id}", responses=problem_responses(401, 403, 404))
def read(class_id: str, regrade_id: str, account: ApiAccount, course: CourseOf, db: Db) -> RegradeOut:
    """How far it is, and whose mark it changes: what counts is graded first."""
    return _regrade_out(db, course, _find_regrade(db, account, class_id, regrade_id))


@router.post("/{regrade_id}/apply", responses=problem_responses(401, 403, 404, 409))
def apply(class_id: str, regrade_id: str, account: ApiAccount, course: CourseOf, db: Db) -> RegradeOut:
    """Has the new gradings count, all at once; where it is applied already, changes nothing."""
    regrade = _find_regrade(db, account, class_id, regrade_id, to_change=True)
    applying.apply_regrade(db, course, regrade.id, account.id)
    return _regrade_out(db, course, regrade)


@router.post("/{regrade_id}/undo", responses=problem_responses(401, 403, 404, 409))
def undo(class_id: str, regrade_id: str, account: ApiAccount, course: CourseOf, db: Db) -> RegradeOut:
    """Has what counted before count again, all at once; where it is not applied, changes nothing."""
    regrade = _find_regrade(db, account, class_id, regrade_id, to_change=True)
    applying.undo_regrade(db, course, regrade.id, account.id)
    return _regrade_out(db, course, regrade)


def _find_regrade(db: Db, account: Account, class_id: str, regrade_id: str, *, to_change: bool = False) -> Regrade:
    place = rights.require_right(db, account, Right.regrade, class_id)
    regrade = service.find_regrade(db, place.school_class.id, regrade_id)
    if to_change:
        require_not_archived(place.school_class)
    return regrade


def _regrade_out(db: Db, course: Course, regrade: Regrade) -> RegradeOut:
    found = service.preview_regrade(db, regrade)
    exercise = course.exercises.get(regrade.exercise)
    kind = "code" if exercise is None else exercise.kind
    fates = Counter(change.outcome for change in found.changes)
    return RegradeOut(
        id=regrade.id,
        exercise=regrade.exercise,
        policy=RegradePolicy(regrade.policy),
        assignment=regrade.assignment_id,
        student=regrade.student_id,
        state=found.progress.state,
        progress=ProgressOut(done=found.progress.graded, total=found.progress.total),
        students={fate: fates[fate] for fate in MarkOutcome},
        failed=sum(change.failed for change in found.changes),
        changes=[
            ChangeOut(
                student=change.student,
                before=change.before,
                after=change.after,
                why=" ; ".join(regraded.verdict_difference_sentences(change.differences, kind)),
            )
            for change in found.changes
            if change.before != change.after
        ],
    )
