"""Access to the solution of an exercise, and its opening. Functions work inside the caller's transaction."""

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
from server.gradebook.schemas import ExerciseProgress
from server.identity.models import Account
from server.rights import service as rights
from server.rights.models import Right


class AccessReason(StrEnum):
    """Why a solution is open to an account, in order of precedence."""

    to_all = "to_all"
    to_class = "to_class"
    succeeded = "succeeded"
    teaches = "teaches"


@dataclass(frozen=True)
class SolutionAudience:
    """The students of a class, or everyone (no class), to whom an account may open a solution."""

    class_id: UUID | None
    class_name: str
    is_open: bool


@dataclass(frozen=True)
class SolutionAccess:
    """The grounds that open an exercise's hints and solution to an account, apart from its attempts, and their holds.

    Nothing is withheld from teachers.
    """

    to_all: bool
    to_class: bool
    teaches: bool
    hints_held: FeedbackHold | None = None
    solution_held: FeedbackHold | None = None

    def access_reason(self, progress: ExerciseProgress) -> AccessReason | None:
        """Return why the account may read the solution, None where it may not."""
        if self.solution_held is not None:
            return AccessReason.teaches if self.teaches else None
        return self._open_reason(progress)

    def is_closed_only_by_hold(self, progress: ExerciseProgress) -> bool:
        """Whether the solution is closed only because it is withheld."""
        return self.solution_held is not None and not self.teaches and self._open_reason(progress) is not None

    def _open_reason(self, progress: ExerciseProgress) -> AccessReason | None:
        reasons = {
            AccessReason.to_all: self.to_all,
            AccessReason.to_class: self.to_class,
            AccessReason.succeeded: progress.succeeded,
            AccessReason.teaches: self.teaches,
        }
        return next((reason for reason, holds in reasons.items() if holds), None)


def load_solution_access(db: Session, account: Account | None, exercise_id: str) -> SolutionAccess:
    """Load the access of an account in one query, besides what is withheld."""
    if account is None:
        return SolutionAccess(repository.find_solution_opening(db, exercise_id) is not None, False, False)
    module = rights.module_of_exercise(exercise_id)
    to_all, to_class, teaches = repository.load_solution_access(
        db, account.id, exercise_id, module, rights.teaches_clause
    )
    holds = feedback.load_holds(db, account.id, exercise_id)
    return SolutionAccess(to_all, to_class, teaches or account.is_teacher, holds.hints, holds.solution)


def list_audiences(db: Session, account: Account | None, exercise_id: str) -> Sequence[SolutionAudience]:
    """Return to whom this account may open or close a solution, classes in the order of their names."""
    if account is None:
        return []
    to_all = (
        [SolutionAudience(None, "", repository.find_solution_opening(db, exercise_id) is not None)]
        if Right.open_solutions_to_all in rights.server_rights(account)
        else []
    )
    classes = rights.load_classes_to_open_solution_to(db, account, exercise_id)
    opened = repository.list_classes_with_solution(db, exercise_id, [school_class.id for school_class in classes])
    return to_all + [
        SolutionAudience(school_class.id, school_class.name, school_class.id in opened) for school_class in classes
    ]


def set_solution_open(db: Session, account: Account, exercise_id: str, class_id: UUID | None, *, is_open: bool) -> None:
    """Open the solution to a class, or to everyone, or close it. Raise Forbidden or NotFound."""
    if class_id is None:
        rights.require_server_right(account, Right.open_solutions_to_all)
    else:
        place = rights.require_right(db, account, Right.open_solutions, class_id)
        if place.school_class.module != rights.module_of_exercise(exercise_id):
            raise NotFound(UNKNOWN_CLASS)
    opening = _find_opening(db, exercise_id, class_id)
    if is_open and opening is None:
        db.add(_build_opening(exercise_id, class_id, account.id))
    elif not is_open and opening is not None:
        db.delete(opening)


Opening = SolutionOpening | ClassOpening


def _find_opening(db: Session, exercise: str, class_id: UUID | None) -> Opening | None:
    if class_id is None:
        return repository.find_solution_opening(db, exercise)
    return repository.find_class_opening(db, class_id, exercise)


def _build_opening(exercise: str, class_id: UUID | None, by: UUID) -> Opening:
    if class_id is None:
        return SolutionOpening(exercise=exercise, opened_by=by)
    return ClassOpening(class_id=class_id, exercise=exercise, opened_by=by)
