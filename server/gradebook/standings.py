"""Queries on standings: kept as gradings come, made again from the history, read for many accounts at once."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import datetime
from functools import cache
from itertools import groupby
from uuid import UUID

from sqlalchemy import Insert, Select, case, delete, func, select, union
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.orm import Session

from graders.core.contract.outcomes import Outcome
from server.database import table_of, upserting
from server.gradebook.models import Grading, Standing
from server.identity.models import Account
from server.submissions.models import Submission

KEY = ("account_id", "exercise")

Rows = Select[UUID, str, float, int, str, str | None, datetime | None, datetime]


@dataclass(frozen=True)
class Counted:
    """What counts of an attempt: by which score it was graded, when it was sent."""

    sent_at: datetime
    outcome: str
    score: float
    diagnosis: str | None


@dataclass(frozen=True)
class Sums:
    """What a row of standing holds of an account's counted attempts at an exercise."""

    best_score: float
    attempts: int
    last_outcome: str
    last_diagnosis: str | None
    first_success_at: datetime | None
    last_at: datetime


def sums_of(counted: Sequence[Counted]) -> Sums:
    """Of attempts in the order in which they were sent, one at least."""
    successes = [attempt.sent_at for attempt in counted if attempt.outcome == Outcome.OK]
    last = counted[-1]
    return Sums(
        best_score=max(attempt.score for attempt in counted),
        attempts=len(counted),
        last_outcome=last.outcome,
        last_diagnosis=last.diagnosis,
        first_success_at=successes[0] if successes else None,
        last_at=last.sent_at,
    )


def add(db: Session, account_id: UUID, exercise: str, attempt: Counted) -> None:
    """Counts an attempt's first grading, in one statement: two workers that end at once both count.

    Two attempts of one account at one instant do not happen: sending takes turns at the account's allowance.
    """
    row = {"account_id": account_id, "exercise": exercise, **asdict(sums_of([attempt]))}
    db.execute(_counting(db.get_bind().dialect.name), row)


@cache
def _counting(dialect: str) -> Insert:
    """The statement that `add` runs, made once: it stands on the way to a verdict."""
    insert = postgresql.insert if dialect == "postgresql" else sqlite.insert
    statement = insert(table_of(Standing))
    new, old = statement.excluded, table_of(Standing).c
    later = new.last_at >= old.last_at
    sooner = old.first_success_at.is_(None) | (new.first_success_at < old.first_success_at)
    changes = {
        "attempts": old.attempts + 1,
        "best_score": case((new.best_score > old.best_score, new.best_score), else_=old.best_score),
        "last_outcome": case((later, new.last_outcome), else_=old.last_outcome),
        "last_diagnosis": case((later, new.last_diagnosis), else_=old.last_diagnosis),
        "first_success_at": case((sooner, new.first_success_at), else_=old.first_success_at),
        "last_at": case((later, new.last_at), else_=old.last_at),
    }
    return statement.on_conflict_do_update(index_elements=KEY, set_=changes)


def recount(db: Session, account_id: UUID, exercise: str | None = None) -> int:
    """Makes an account's standings again, in one exercise or in all; returns how many were not as they ought to be.

    The account's row and its standings are locked before the history is read, so that a grading that ends meanwhile
    (`add` inserts, which asks for the account's row, or updates) is counted after.
    """
    lock(db, [account_id])
    stored = _kept(db, account_id, exercise)
    right = _from_history(db, account_id, exercise)
    wrong = [name for name in stored.keys() | right.keys() if stored.get(name) != right.get(name)]
    for name in wrong:
        _write(db, account_id, name, right.get(name))
    return len(wrong)


def lock(db: Session, accounts: Collection[UUID]) -> None:
    """Keeps others from adding to what these accounts have sent, until the commit. Always in the same order."""
    db.execute(select(Account.id).where(Account.id.in_(accounts)).order_by(Account.id).with_for_update())


def _write(db: Session, account_id: UUID, exercise: str, sums: Sums | None) -> None:
    if sums is None:
        db.execute(delete(Standing).where(Standing.account_id == account_id, Standing.exercise == exercise))
    else:
        statement = upserting(db, Standing).values(account_id=account_id, exercise=exercise, **asdict(sums))
        db.execute(statement.on_conflict_do_update(index_elements=KEY, set_=asdict(sums)))


def _kept(db: Session, account_id: UUID, exercise: str | None) -> Mapping[str, Sums]:
    return _by_exercise(db, _of_account(account_id, exercise).with_for_update())


def _from_history(db: Session, account_id: UUID, exercise: str | None) -> Mapping[str, Sums]:
    query = (
        select(Submission.exercise, Submission.created_at, Grading.outcome, Grading.score, Grading.diagnosis)
        .join(Grading, Grading.id == Submission.grading_id)
        .where(Submission.account_id == account_id, Grading.outcome != Outcome.INTERNAL_ERROR)
        .order_by(Submission.exercise, Submission.created_at, Submission.id)
    )
    query = query if exercise is None else query.where(Submission.exercise == exercise)
    groups = groupby(db.execute(query), key=lambda row: row[0])
    return {name: sums_of([_counted(*row[1:]) for row in rows]) for name, rows in groups}


def _rows() -> Rows:
    return select(
        Standing.account_id,
        Standing.exercise,
        Standing.best_score,
        Standing.attempts,
        Standing.last_outcome,
        Standing.last_diagnosis,
        Standing.first_success_at,
        Standing.last_at,
    )


def _counted(sent_at: datetime, outcome: str, score: float | None, diagnosis: str | None) -> Counted:
    if score is None:
        raise ValueError(f"a grading that ended as {outcome} has no score")
    return Counted(sent_at, outcome, score, diagnosis)


def _of_account(account_id: UUID, exercise: str | None) -> Rows:
    query = _rows().where(Standing.account_id == account_id)
    return query if exercise is None else query.where(Standing.exercise == exercise)


def _by_exercise(db: Session, query: Rows) -> Mapping[str, Sums]:
    return {row[1]: Sums(*row[2:]) for row in db.execute(query)}


def of_account(db: Session, account_id: UUID, exercise: str | None = None) -> Mapping[str, Sums]:
    """An account's standings, by exercise."""
    return _by_exercise(db, _of_account(account_id, exercise))


def of_class(db: Session, accounts: Collection[UUID], exercises: Collection[str]) -> Mapping[tuple[UUID, str], Sums]:
    """The standings of many accounts in many exercises, in one query."""
    query = _rows().where(Standing.account_id.in_(accounts), Standing.exercise.in_(exercises))
    return {(row[0], row[1]): Sums(*row[2:]) for row in db.execute(query)}


def accounts(db: Session) -> Sequence[UUID]:
    """Every account that has a standing, or ought to."""
    senders = select(Submission.account_id).where(Submission.grading_id.is_not(None))
    return db.execute(union(senders, select(Standing.account_id))).scalars().all()


def count(db: Session) -> int:
    return db.execute(select(func.count()).select_from(Standing)).scalar_one()
