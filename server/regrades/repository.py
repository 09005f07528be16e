"""Queries on regrades. No list loads verdicts: their differences are stored with each item."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import fields
from datetime import datetime
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import Row, bindparam, func, insert, select, tuple_, update
from sqlalchemy.orm import Session, aliased

from graders.core.contract.outcomes import Outcome
from server.classes.models import ClassRole, Membership, Status
from server.database import table_of
from server.gradebook.models import Grading
from server.regrades.differences import VerdictDifference
from server.regrades.models import Regrade, RegradeItem
from server.regrades.schemas import AppliedRegrade, OutdatedExercise, RegradedAttempt
from server.submissions.models import Submission

_items = table_of(RegradeItem)
#: The fields of `RegradedAttempt` that are plain columns.
PLAIN_FIELDS = tuple(field.name for field in fields(RegradedAttempt))[:-2]
_before, _after = aliased(Grading), aliased(Grading)


def find_regrade(db: Session, class_id: UUID, regrade_id: UUID) -> Regrade | None:
    """Return a regrade of this class, or None."""
    query = select(Regrade).where(Regrade.id == regrade_id, Regrade.class_id == class_id)
    return db.execute(query).scalar_one_or_none()


def lock_regrade(db: Session, regrade_id: UUID) -> Regrade | None:
    """Lock and reload a regrade until the commit."""
    query = select(Regrade).where(Regrade.id == regrade_id).with_for_update()
    return db.execute(query.execution_options(populate_existing=True)).scalar_one_or_none()


def load_class_regrades(db: Session, class_id: UUID, limit: int) -> Sequence[Regrade]:
    """Load the last regrades of a class, newest first."""
    query = select(Regrade).where(Regrade.class_id == class_id)
    return db.execute(query.order_by(Regrade.created_at.desc(), Regrade.id).limit(limit)).scalars().all()


def load_running_regrades(db: Session, class_id: UUID) -> Sequence[Regrade]:
    """Load the regrades of a class that are not over."""
    is_waiting = (
        select(RegradeItem.id).where(RegradeItem.regrade_id == Regrade.id, RegradeItem.after_id.is_(None)).exists()
    )
    return (
        db.execute(select(Regrade).where(Regrade.class_id == class_id, Regrade.stopped_at.is_(None), is_waiting))
        .scalars()
        .all()
    )


def count_regraded_and_all_attempts(db: Session, regrades: Collection[UUID]) -> Mapping[UUID, tuple[int, int]]:
    """Count the regraded attempts and all attempts of each regrade."""
    query = (
        select(RegradeItem.regrade_id, func.count(RegradeItem.after_id), func.count())
        .where(RegradeItem.regrade_id.in_(regrades))
        .group_by(RegradeItem.regrade_id)
    )
    counts = {regrade_id: (graded, total) for regrade_id, graded, total in db.execute(query)}
    return {regrade_id: counts.get(regrade_id, (0, 0)) for regrade_id in regrades}


def load_graded_attempts(
    db: Session, accounts: Collection[UUID], exercise: str, limit: int
) -> Sequence[Row[UUID, UUID, datetime, UUID, float | None]]:
    """Load submission, author, time, current grading and its score, in the order of submission."""
    query = (
        select(Submission.id, Submission.account_id, Submission.created_at, Grading.id, Grading.score)
        .join(Grading, Grading.id == Submission.grading_id)
        .where(Submission.account_id.in_(accounts), Submission.exercise == exercise)
        .order_by(Submission.created_at, Submission.id)
    )
    return db.execute(query.limit(limit)).all()


def add_regrade_items(db: Session, regrade_id: UUID, rows: Sequence[tuple[UUID, UUID, bool]]) -> None:
    """Insert items from submission, current grading and whether it makes its author's mark, in this order."""
    items: list[dict[str, object]] = [
        {
            "id": uuid4(),
            "regrade_id": regrade_id,
            "position": position,
            "counted": counted,
            "submission_id": submission,
            "before_id": grading,
            "after_id": None,
            "differences": [],
            "is_applied": False,
        }
        for position, (submission, grading, counted) in enumerate(rows)
    ]
    db.execute(insert(_items), items)


def load_next_item_to_grade(db: Session, regrade_id: UUID) -> Row[RegradeItem, Submission, UUID] | None:
    """Return the next item of a running regrade to grade, its submission and the class."""
    query = (
        select(RegradeItem, Submission, Regrade.class_id)
        .join(Submission, Submission.id == RegradeItem.submission_id)
        .join(Regrade, Regrade.id == RegradeItem.regrade_id)
        .where(RegradeItem.regrade_id == regrade_id, RegradeItem.after_id.is_(None), Regrade.stopped_at.is_(None))
        .order_by(RegradeItem.position)
    )
    return db.execute(query.limit(1)).one_or_none()


def store_new_grading(db: Session, item_id: UUID, grading_id: UUID, differences: Sequence[VerdictDifference]) -> None:
    values = {"after_id": grading_id, "differences": [difference.to_json() for difference in differences]}
    db.execute(update(_items).where(_items.c.id == item_id).values(**values))


def load_ids_of_item(db: Session, item_id: UUID) -> Row[UUID, UUID, UUID | None] | None:
    """Return an item's submission, old grading and new one; None once its author is erased."""
    query = select(RegradeItem.submission_id, RegradeItem.before_id, RegradeItem.after_id)
    return db.execute(query.where(RegradeItem.id == item_id)).one_or_none()


def load_regraded_attempts(db: Session, regrade_id: UUID, *, lock: bool = False) -> Sequence[RegradedAttempt]:
    """Load the attempts of a regrade in the order of submission; `lock` locks their submissions until the commit."""
    query = (
        select(
            RegradeItem.id,
            Submission.id,
            Submission.account_id,
            Submission.created_at,
            RegradeItem.counted,
            Submission.grading_id,
            RegradeItem.before_id,
            _before.score,
            RegradeItem.after_id,
            _after.score,
            _after.exercise_version,
            RegradeItem.differences,
            RegradeItem.is_applied,
        )
        .join(Submission, Submission.id == RegradeItem.submission_id)
        .join(_before, _before.id == RegradeItem.before_id)
        .outerjoin(_after, _after.id == RegradeItem.after_id)
        .where(RegradeItem.regrade_id == regrade_id)
        .order_by(Submission.created_at, Submission.id)
    )
    query = query.with_for_update(of=Submission) if lock else query
    return [_row_to_regraded_attempt(row) for row in db.execute(query)]


def _row_to_regraded_attempt(row: Sequence[Any]) -> RegradedAttempt:
    *values, differences, is_applied = row
    return RegradedAttempt(
        **dict(zip(PLAIN_FIELDS, values, strict=True)),
        differences=tuple(map(VerdictDifference.from_json, differences)),
        is_applied=is_applied,
    )


def load_ids_of_authors(db: Session, regrade_id: UUID) -> frozenset[UUID]:
    query = select(Submission.account_id).join(RegradeItem, RegradeItem.submission_id == Submission.id).distinct()
    return frozenset(db.execute(query.where(RegradeItem.regrade_id == regrade_id)).scalars())


def set_items_applied(db: Session, items: Collection[UUID], *, is_applied: bool) -> None:
    if items:
        statement = update(_items).where(_items.c.id == bindparam("item")).values(is_applied=is_applied)
        db.execute(statement, [{"item": item_id} for item_id in items])


def count_attempts_sent_since(
    db: Session, accounts: Collection[UUID], exercise: str, since: datetime
) -> Mapping[UUID, int]:
    query = (
        select(Submission.account_id, func.count())
        .where(Submission.account_id.in_(accounts), Submission.exercise == exercise, Submission.created_at > since)
        .group_by(Submission.account_id)
    )
    return dict(db.execute(query).all())


def find_applied_regrade(db: Session, grading_id: UUID) -> AppliedRegrade | None:
    """Return the applied regrade by which this grading counts."""
    query = (
        select(Regrade.applied_at, _before.score, _after.score, RegradeItem.differences)
        .select_from(RegradeItem)
        .join(Regrade, Regrade.id == RegradeItem.regrade_id)
        .join(_before, _before.id == RegradeItem.before_id)
        .join(_after, _after.id == RegradeItem.after_id)
        .where(RegradeItem.after_id == grading_id, RegradeItem.is_applied, Regrade.undone_at.is_(None))
    )
    row = db.execute(query).one_or_none()
    if row is None or row[0] is None:
        return None
    return AppliedRegrade(row[0], row[1], row[2], tuple(map(VerdictDifference.from_json, row[3])))


def load_outdated_exercises(db: Session, class_id: UUID, versions: Mapping[str, str]) -> Sequence[OutdatedExercise]:
    """Count, by exercise, the class's graded attempts that its current version never graded.

    A grading that ended by an internal error is ignored.
    """
    if not versions:
        return []
    current = aliased(Grading)
    graded_by_version = select(current.id).where(
        current.submission_id == Submission.id,
        current.outcome != Outcome.INTERNAL_ERROR,
        tuple_(Submission.exercise, current.exercise_version).in_(sorted(versions.items())),
    )
    query = (
        select(Submission.exercise, func.count(), func.count(Submission.account_id.distinct()))
        .join(Membership, Membership.account_id == Submission.account_id)
        .where(
            Membership.class_id == class_id,
            Membership.role == ClassRole.student,
            Membership.status == Status.active,
            Submission.exercise.in_(list(versions)),
            Submission.grading_id.is_not(None),
            ~graded_by_version.exists(),
        )
        .group_by(Submission.exercise)
    )
    outdated = {row[0]: OutdatedExercise(*row) for row in db.execute(query)}
    return [outdated[name] for name in versions if name in outdated]
