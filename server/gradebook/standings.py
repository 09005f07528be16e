"""Queries on standings: kept as gradings come, made again from the history, read for many accounts at once."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, fields
from datetime import datetime
from functools import cache
from itertools import groupby
from typing import Protocol
from uuid import UUID

from sqlalchemy import Insert, Select, and_, case, delete, func, or_, select, union
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.orm import Session

from graders.core.contract.outcomes import Outcome
from server.database import ask, change, prepared, table_of, upserting
from server.gradebook.models import Grading, Standing
from server.identity.models import Account
from server.submissions.models import Submission

KEY = ("account_id", "exercise")

History = Select[UUID, str, datetime, str, float | None, str | None]
Rows = Select[UUID, str, float, int, str, str | None, datetime | None, datetime]


Standings = Mapping[tuple[UUID, str], "StandingTotals"]


class Countable(Protocol):
    """What tells as much as `Counted`."""

    @property
    def sent_at(self) -> datetime: ...

    @property
    def outcome(self) -> str: ...

    @property
    def score(self) -> float: ...

    @property
    def diagnosis(self) -> str | None: ...


@dataclass(frozen=True)
class CountedAttempt:
    """What counts of an attempt: by which score it was graded, when it was sent."""

    sent_at: datetime
    outcome: str
    score: float
    diagnosis: str | None


@dataclass(frozen=True)
class StandingTotals:
    """What a row of standing holds of an account's counted attempts at an exercise."""

    best_score: float
    attempts: int
    last_outcome: str
    last_diagnosis: str | None
    first_success_at: datetime | None
    last_at: datetime


SUMMED = tuple(field.name for field in fields(StandingTotals))


def compute_totals(counted: Sequence[Countable]) -> StandingTotals:
    """Of attempts in the order in which they were sent, one at least."""
    successes = [attempt.sent_at for attempt in counted if attempt.outcome == Outcome.OK]
    last = counted[-1]
    return StandingTotals(
        best_score=max(attempt.score for attempt in counted),
        attempts=len(counted),
        last_outcome=last.outcome,
        last_diagnosis=last.diagnosis,
        first_success_at=successes[0] if successes else None,
        last_at=last.sent_at,
    )


def count_attempt(db: Session, account_id: UUID, exercise: str, attempt: CountedAttempt) -> None:
    """Counts an attempt's first grading, in one statement: two workers that end at once both count.

    Two attempts of one account at one instant do not happen: sending takes turns at the account's allowance.
    """
    row = {"account_id": account_id, "exercise": exercise, **vars(compute_totals([attempt]))}
    change(db, _counting(db.get_bind().dialect.name), row)


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
    """Makes an account's standings again, in one exercise or in all; returns how many were not as they ought to be."""
    return recount_all(db, [account_id], exercise)


def recount_all(db: Session, accounts: Collection[UUID], exercise: str | None = None) -> int:
    """The same for many accounts at once.

    The accounts' rows and their standings are locked before the history is read, so that a grading that ends meanwhile
    (`add` inserts, which asks for the account's row, or updates) is counted after.
    """
    lock_accounts(db, accounts)
    stored = _kept(db, accounts, exercise)
    right = _from_history(db, accounts, exercise)
    wrong = [key for key in stored.keys() | right.keys() if stored.get(key) != right.get(key)]
    _write(db, {key: right.get(key) for key in wrong})
    return len(wrong)


def lock_accounts(db: Session, accounts: Collection[UUID]) -> None:
    """Keeps others from adding to what these accounts have sent, until the commit. Always in the same order."""
    db.execute(select(Account.id).where(Account.id.in_(accounts)).order_by(Account.id).with_for_update())


def _write(db: Session, made: Mapping[tuple[UUID, str], StandingTotals | None]) -> None:
    """Standings as they ought to be; those that are none any more go."""
    rows = [{"account_id": key[0], "exercise": key[1], **vars(sums)} for key, sums in made.items() if sums is not None]
    if rows:
        statement = upserting(db, Standing)
        db.execute(
            statement.on_conflict_do_update(
                index_elements=KEY, set_={name: statement.excluded[name] for name in SUMMED}
            ),
            rows,
        )
    for account_id, exercise in [key for key, sums in made.items() if sums is None]:
        db.execute(delete(Standing).where(Standing.account_id == account_id, Standing.exercise == exercise))


def _kept(db: Session, accounts: Collection[UUID], exercise: str | None) -> Standings:
    query = _rows().where(Standing.account_id.in_(accounts))
    query = query if exercise is None else query.where(Standing.exercise == exercise)
    return _by_key(db, query.order_by(Standing.account_id, Standing.exercise).with_for_update())


def _from_history(db: Session, accounts: Collection[UUID], exercise: str | None) -> Standings:
    query = _history(accounts)
    return _summed(db, query if exercise is None else query.where(Submission.exercise == exercise))


def _history(accounts: Collection[UUID]) -> History:
    sent = Submission
    return (
        select(sent.account_id, sent.exercise, sent.created_at, Grading.outcome, Grading.score, Grading.diagnosis)
        .join(Grading, Grading.id == sent.grading_id)
        .where(sent.account_id.in_(accounts), Grading.outcome != Outcome.INTERNAL_ERROR)
        .order_by(sent.account_id, sent.exercise, sent.created_at, sent.id)
    )


def _summed(db: Session, query: History) -> Standings:
    groups = groupby(db.execute(query), key=lambda row: (row[0], row[1]))
    return {key: compute_totals([_counted(*row[2:]) for row in rows]) for key, rows in groups}


def load_standings_until(db: Session, account_id: UUID, until: Mapping[str, datetime]) -> Mapping[str, StandingTotals]:
    """What the attempts come to that were sent before these times, by exercise, in these exercises alone."""
    earlier = [and_(Submission.exercise == name, Submission.created_at < when) for name, when in until.items()]
    return {key[1]: sums for key, sums in _summed(db, _history([account_id]).where(or_(*earlier))).items()}


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


def _counted(sent_at: datetime, outcome: str, score: float | None, diagnosis: str | None) -> CountedAttempt:
    if score is None:
        raise ValueError(f"a grading that ended as {outcome} has no score")
    return CountedAttempt(sent_at, outcome, score, diagnosis)


def _by_key(db: Session, query: Rows) -> Standings:
    return {(row[0], row[1]): StandingTotals(*row[2:]) for row in db.execute(query)}


@prepared
def _of_account(account_id: UUID, exercise: str, *, everywhere: bool) -> Rows:
    query = _rows().where(Standing.account_id == account_id)
    return query if everywhere else query.where(Standing.exercise == exercise)


def load_account_standings(db: Session, account_id: UUID, exercise: str | None = None) -> Mapping[str, StandingTotals]:
    """An account's standings, by exercise."""
    found = ask(db, *_of_account(account_id, exercise or "", everywhere=exercise is None))
    return {row[1]: StandingTotals(*row[2:]) for row in found}


def load_standings(db: Session, accounts: Collection[UUID], exercises: Collection[str]) -> Standings:
    """The standings of many accounts in many exercises, in one query."""
    return _by_key(db, _rows().where(Standing.account_id.in_(accounts), Standing.exercise.in_(exercises)))


def list_accounts(db: Session) -> Sequence[UUID]:
    """Every account that has a standing, or ought to."""
    senders = select(Submission.account_id).where(Submission.grading_id.is_not(None))
    return db.execute(union(senders, select(Standing.account_id))).scalars().all()


def count_standings(db: Session) -> int:
    return db.execute(select(func.count()).select_from(Standing)).scalar_one()
