"""Queries on regrades. Lists never open a verdict: what differs between two is kept with each item."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import fields
from datetime import datetime
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import Row, Select, bindparam, func, insert, select, tuple_, update
from sqlalchemy.orm import Session, aliased

from graders.core.contract.outcomes import Outcome
from server.classes.models import ClassRole, Membership, Status
from server.database import ask, prepared, table_of
from server.gradebook.models import Grading
from server.regrades.differences import VerdictDifference
from server.regrades.models import Regrade, RegradeItem
from server.regrades.schemas import AppliedRegrade, OutdatedExercise, RegradedAttempt
from server.submissions.models import Submission

_items = table_of(RegradeItem)
#: The fields of a copy that are columns as they are.
COPIED = tuple(field.name for field in fields(RegradedAttempt))[:-2]
_before, _after = aliased(Grading), aliased(Grading)


def find_regrade(db: Session, class_id: UUID, regrade_id: UUID) -> Regrade | None:
    """Of this class alone."""
    query = select(Regrade).where(Regrade.id == regrade_id, Regrade.class_id == class_id)
    return db.execute(query).scalar_one_or_none()


def lock_regrade(db: Session, regrade_id: UUID) -> Regrade | None:
    """As it stands now; nobody else changes it until the commit."""
    query = select(Regrade).where(Regrade.id == regrade_id).with_for_update()
    return db.execute(query.execution_options(populate_existing=True)).scalar_one_or_none()


def load_class_regrades(db: Session, class_id: UUID, most: int) -> Sequence[Regrade]:
    """Newest first."""
    query = select(Regrade).where(Regrade.class_id == class_id)
    return db.execute(query.order_by(Regrade.created_at.desc(), Regrade.id).limit(most)).scalars().all()


def load_running_regrades(db: Session, class_id: UUID) -> Sequence[Regrade]:
    """Those of the class that are not over."""
    waits = select(RegradeItem.id).where(RegradeItem.regrade_id == Regrade.id, RegradeItem.after_id.is_(None)).exists()
    return (
        db.execute(select(Regrade).where(Regrade.class_id == class_id, Regrade.stopped_at.is_(None), waits))
        .scalars()
        .all()
    )


def count_graded(db: Session, regrades: Collection[UUID]) -> Mapping[UUID, tuple[int, int]]:
    """Of each, how many attempts are graded anew, and how many there are."""
    query = (
        select(RegradeItem.regrade_id, func.count(RegradeItem.after_id), func.count())
        .where(RegradeItem.regrade_id.in_(regrades))
        .group_by(RegradeItem.regrade_id)
    )
    found = {name: (graded, total) for name, graded, total in db.execute(query)}
    return {name: found.get(name, (0, 0)) for name in regrades}


def load_graded_attempts(
    db: Session, accounts: Collection[UUID], exercise: str, most: int
) -> Sequence[Row[UUID, UUID, datetime, UUID, float | None]]:
    """Submission, author, time, the grading that counts and its score, in the order of sending."""
    query = (
        select(Submission.id, Submission.account_id, Submission.created_at, Grading.id, Grading.score)
        .join(Grading, Grading.id == Submission.grading_id)
        .where(Submission.account_id.in_(accounts), Submission.exercise == exercise)
        .order_by(Submission.created_at, Submission.id)
    )
    return db.execute(query.limit(most)).all()


def add_items(db: Session, regrade_id: UUID, rows: Sequence[tuple[UUID, UUID, bool]]) -> None:
    """Submission, the grading that counts, and whether it makes its author's mark; in the order of their turns."""
    items: list[dict[str, object]] = [
        {
            "id": uuid4(),
            "regrade_id": regrade_id,
            "position": position,
            "counted": counting,
            "submission_id": submission,
            "before_id": grading,
            "after_id": None,
            "differences": [],
            "is_applied": False,
        }
        for position, (submission, grading, counting) in enumerate(rows)
    ]
    db.execute(insert(_items), items)


def load_next_item(db: Session, regrade_id: UUID) -> Row[RegradeItem, Submission, UUID] | None:
    """The first that waits, of a regrade that goes on; what was sent; the class."""
    query = (
        select(RegradeItem, Submission, Regrade.class_id)
        .join(Submission, Submission.id == RegradeItem.submission_id)
        .join(Regrade, Regrade.id == RegradeItem.regrade_id)
        .where(RegradeItem.regrade_id == regrade_id, RegradeItem.after_id.is_(None), Regrade.stopped_at.is_(None))
        .order_by(RegradeItem.position)
    )
    return db.execute(query.limit(1)).one_or_none()


def set_graded(db: Session, item_id: UUID, grading_id: UUID, why: Sequence[VerdictDifference]) -> None:
    changed = {"after_id": grading_id, "differences": [one.to_json() for one in why]}
    db.execute(update(_items).where(_items.c.id == item_id).values(**changed))


def load_item_ids(db: Session, item_id: UUID) -> Row[UUID, UUID, UUID | None] | None:
    """Its submission, the grading from before and the new one; None once its author has gone."""
    query = select(RegradeItem.submission_id, RegradeItem.before_id, RegradeItem.after_id)
    return db.execute(query.where(RegradeItem.id == item_id)).one_or_none()


def load_attempts(db: Session, regrade_id: UUID, *, lock: bool = False) -> Sequence[RegradedAttempt]:
    """In the order of sending; with `lock`, nobody else has another grading count until the commit."""
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
    return [_copy(row) for row in db.execute(query)]


def _copy(row: Sequence[Any]) -> RegradedAttempt:
    *values, why, moved = row
    return RegradedAttempt(
        **dict(zip(COPIED, values, strict=True)),
        differences=tuple(map(VerdictDifference.from_json, why)),
        is_applied=moved,
    )


def load_author_ids(db: Session, regrade_id: UUID) -> frozenset[UUID]:
    query = select(Submission.account_id).join(RegradeItem, RegradeItem.submission_id == Submission.id).distinct()
    return frozenset(db.execute(query.where(RegradeItem.regrade_id == regrade_id)).scalars())


def set_applied(db: Session, items: Collection[UUID], *, moved: bool) -> None:
    if items:
        statement = update(_items).where(_items.c.id == bindparam("item")).values(is_applied=moved)
        db.execute(statement, [{"item": name} for name in items])


def count_sent_since(db: Session, accounts: Collection[UUID], exercise: str, when: datetime) -> Mapping[UUID, int]:
    query = (
        select(Submission.account_id, func.count())
        .where(Submission.account_id.in_(accounts), Submission.exercise == exercise, Submission.created_at > when)
        .group_by(Submission.account_id)
    )
    return dict(db.execute(query).all())


@prepared
def _told(grading_id: UUID) -> Select[datetime | None, float | None, float | None, Any]:
    return (
        select(Regrade.applied_at, _before.score, _after.score, RegradeItem.differences)
        .select_from(RegradeItem)
        .join(Regrade, Regrade.id == RegradeItem.regrade_id)
        .join(_before, _before.id == RegradeItem.before_id)
        .join(_after, _after.id == RegradeItem.after_id)
        .where(RegradeItem.after_id == grading_id, RegradeItem.is_applied, Regrade.undone_at.is_(None))
    )


def find_applied_regrade(db: Session, grading_id: UUID) -> AppliedRegrade | None:
    """Of the regrade that is applied, and has this grading count."""
    row = ask(db, *_told(grading_id)).one_or_none()
    if row is None or row[0] is None:
        return None
    return AppliedRegrade(row[0], row[1], row[2], tuple(map(VerdictDifference.from_json, row[3])))


def load_outdated_exercises(db: Session, class_id: UUID, versions: Mapping[str, str]) -> Sequence[OutdatedExercise]:
    """By exercise, the attempts of the class's students that are graded, never by its present version.

    A grading that ended by an error of ours is none.
    """
    if not versions:
        return []
    present = aliased(Grading)
    graded_by_it = select(present.id).where(
        present.submission_id == Submission.id,
        present.outcome != Outcome.INTERNAL_ERROR,
        tuple_(Submission.exercise, present.exercise_version).in_(sorted(versions.items())),
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
            ~graded_by_it.exists(),
        )
        .group_by(Submission.exercise)
    )
    found = {row[0]: OutdatedExercise(*row) for row in db.execute(query)}
    return [found[name] for name in versions if name in found]
