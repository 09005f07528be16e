"""Queries on submissions, draws and opened solutions."""

from collections.abc import Collection, Sequence
from typing import Any
from uuid import UUID

from sqlalchemy import Row, case, delete, func, select, update
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.orm import Session, undefer

from server.database import utc_now
from server.submissions.models import INTERNAL_ERROR, Draw, SolutionOpening, State, Submission


def by_id(db: Session, submission_id: UUID) -> Submission | None:
    return db.get(Submission, submission_id, populate_existing=True)


def figures_of(db: Session, submission_id: UUID) -> dict[str, Any]:
    query = select(Submission).where(Submission.id == submission_id).options(undefer(Submission.figures))
    return db.execute(query).scalar_one().figures or {}


def of_account(db: Session, account_id: UUID, exercise: str) -> Sequence[Submission]:
    query = (
        select(Submission)
        .where(Submission.account_id == account_id, Submission.exercise == exercise)
        .order_by(Submission.created_at.desc(), Submission.id)
    )
    return db.execute(query).scalars().all()


def progress(db: Session, account_id: UUID) -> Sequence[Row[str, float | None, int]]:
    """For each exercise tried: its name, the best score so far, the number of counted submissions."""
    counted = case((Submission.outcome == INTERNAL_ERROR, 0), else_=1)
    query = (
        select(Submission.exercise, func.max(Submission.score), func.sum(counted))
        .where(Submission.account_id == account_id)
        .group_by(Submission.exercise)
    )
    return db.execute(query).all()


def failed_digests(db: Session, account_id: UUID, exercise: str, besides: Collection[str]) -> int:
    """How many different codes were graded and failed."""
    query = select(func.count(Submission.digest.distinct())).where(
        Submission.account_id == account_id,
        Submission.exercise == exercise,
        Submission.state == State.done,
        Submission.outcome.not_in(("ok", INTERNAL_ERROR)),
        Submission.digest.not_in(besides),
    )
    return db.execute(query).scalar_one()


def has_succeeded(db: Session, account_id: UUID, exercise: str) -> bool:
    query = select(Submission.id).where(
        Submission.account_id == account_id, Submission.exercise == exercise, Submission.outcome == "ok"
    )
    return db.execute(query.limit(1)).first() is not None


def move(db: Session, old: UUID, new: UUID) -> None:
    db.execute(update(Submission).where(Submission.account_id == old).values(account_id=new))


def find_seed(db: Session, account_id: UUID, exercise: str) -> int | None:
    query = select(Draw.seed).where(Draw.account_id == account_id, Draw.exercise == exercise)
    return db.execute(query).scalar_one_or_none()


def drawn_seed(db: Session, account_id: UUID, exercise: str) -> int:
    """The seed that is known to be kept."""
    query = select(Draw.seed).where(Draw.account_id == account_id, Draw.exercise == exercise)
    return db.execute(query).scalar_one()


def keep_seed(db: Session, account_id: UUID, exercise: str, seed: int) -> None:
    """Keeps a seed, unless there is one already: of two requests at once, the first one's stays."""
    row = {"account_id": account_id, "exercise": exercise, "seed": seed, "created_at": utc_now()}
    if db.get_bind().dialect.name == "postgresql":
        db.execute(postgresql.insert(Draw).values(row).on_conflict_do_nothing())
    else:
        db.execute(sqlite.insert(Draw).values(row).on_conflict_do_nothing())


def move_draws(db: Session, old: UUID, new: UUID) -> None:
    """Moves the draws of exercises for which `new` has none."""
    known = select(Draw.exercise).where(Draw.account_id == new)
    moved = update(Draw).where(Draw.account_id == old, Draw.exercise.not_in(known)).values(account_id=new)
    db.execute(moved.execution_options(synchronize_session=False))


def opening(db: Session, exercise: str) -> SolutionOpening | None:
    return db.get(SolutionOpening, exercise)


def delete_opening(db: Session, exercise: str) -> None:
    db.execute(delete(SolutionOpening).where(SolutionOpening.exercise == exercise))
