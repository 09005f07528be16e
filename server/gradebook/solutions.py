"""Who may read the solution of an exercise, and who opens it. Functions work inside the caller's transaction."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import feedback
from server.assignments.feedback import FeedbackHold
from server.base.errors import NotFound
from server.classes.service import UNKNOWN_CLASS
from server.gradebook import repository
from server.gradebook.models import ClassOpening, SolutionOpening
from server.gradebook.schemas import Progress
from server.identity.models import Account
from server.rights import service as rights
from server.rights.models import Right


class AccessReason(StrEnum):
    """Why a solution is open to somebody: the first that holds."""

    to_all = "to_all"
    to_class = "to_class"
    succeeded = "succeeded"
    teaches = "teaches"


@dataclass(frozen=True)
class SolutionAudience:
    """Those to whom one may open a solution: the students of a class, or everyone (no class)."""

    class_id: UUID | None
    class_name: str
    is_open: bool


@dataclass(frozen=True)
class SolutionAccess:
    """What opens an exercise's hints and solution to an account, whatever it has done, and what holds them back.

    Nothing holds them back from who teaches.
    """

    to_all: bool
    to_class: bool
    teaches: bool
    hints_held: FeedbackHold | None = None
    solution_held: FeedbackHold | None = None

    def because(self, progress: Progress) -> AccessReason | None:
        """Why the account may read the solution, or None where it may not."""
        if self.solution_held is not None:
            return AccessReason.teaches if self.teaches else None
        return self._reason(progress)

    def would_open(self, progress: Progress) -> bool:
        """Whether the solution would be open, were it not held back."""
        return self.solution_held is not None and not self.teaches and self._reason(progress) is not None

    def _reason(self, progress: Progress) -> AccessReason | None:
        reasons = {
            AccessReason.to_all: self.to_all,
            AccessReason.to_class: self.to_class,
            AccessReason.succeeded: progress.succeeded,
            AccessReason.teaches: self.teaches,
        }
        return next((why for why, holds in reasons.items() if holds), None)


def load_solution_access(db: Session, account: Account | None, exercise_id: str) -> SolutionAccess:
    """In one query, besides what is held back."""
    if account is None:
        return SolutionAccess(repository.opening(db, exercise_id) is not None, False, False)
    module = rights.module_of(exercise_id)
    to_all, to_class, teaches = repository.access(db, account.id, exercise_id, module, rights.teaches_clause)
    known = feedback.load_holds(db, account.id, exercise_id)
    return SolutionAccess(to_all, to_class, teaches or account.is_teacher, known.hints, known.solution)


def list_audiences(db: Session, account: Account | None, exercise_id: str) -> Sequence[SolutionAudience]:
    """What this account may open or close, its classes in the order of their names."""
    if account is None:
        return []
    to_all = (
        [SolutionAudience(None, "", repository.opening(db, exercise_id) is not None)]
        if Right.open_solutions_to_all in rights.server_rights(account)
        else []
    )
    classes = rights.classes_to_open(db, account, exercise_id)
    already = repository.classes_opened(db, exercise_id, [one.id for one in classes])
    return to_all + [SolutionAudience(one.id, one.name, one.id in already) for one in classes]


def set_solution_open(db: Session, account: Account, exercise_id: str, class_id: UUID | None, *, wanted: bool) -> None:
    """Opens the solution to a class, or to everyone, or closes it. Raises Forbidden or NotFound."""
    if class_id is None:
        rights.require_server_right(account, Right.open_solutions_to_all)
    else:
        place = rights.require_right(db, account, Right.open_solutions, class_id)
        if place.school_class.module != rights.module_of(exercise_id):
            raise NotFound(UNKNOWN_CLASS)
    opened = _opened(db, exercise_id, class_id)
    if wanted and opened is None:
        db.add(_opening(exercise_id, class_id, account.id))
    elif not wanted and opened is not None:
        db.delete(opened)


Opening = SolutionOpening | ClassOpening


def _opened(db: Session, exercise: str, class_id: UUID | None) -> Opening | None:
    if class_id is None:
        return repository.opening(db, exercise)
    return repository.class_opening(db, class_id, exercise)


def _opening(exercise: str, class_id: UUID | None, by: UUID) -> Opening:
    if class_id is None:
        return SolutionOpening(exercise=exercise, opened_by=by)
    return ClassOpening(class_id=class_id, exercise=exercise, opened_by=by)
