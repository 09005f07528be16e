"""Standings: updated as gradings arrive, rebuilt from the history, and read for many accounts at once."""

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
from server.database import table_of, upsert_statement, write_core
from server.gradebook.models import Grading, Standing
from server.identity.models import Account
from server.submissions.models import Submission

KEY = ("account_id", "exercise")

HistoryQuery = Select[UUID, str, datetime, str, float | None, str | None]
StandingQuery = Select[UUID, str, float, int, str, str | None, datetime | None, datetime]


TotalsByPair = Mapping[tuple[UUID, str], "StandingTotals"]


class Countable(Protocol):
    """An attempt with the properties of `CountedAttempt`."""

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
    """The properties of a graded attempt that count in a standing."""

    sent_at: datetime
    outcome: str
    score: float
    diagnosis: str | None


@dataclass(frozen=True)
class StandingTotals:
    """Totals of an account's counted attempts at an exercise: the columns of a `Standing`."""

    best_score: float
    attempts: int
    last_outcome: str
    last_diagnosis: str | None
    first_success_at: datetime | None
    last_at: datetime


TOTAL_COLUMNS = tuple(field.name for field in fields(StandingTotals))


def compute_standing_totals(attempts: Sequence[Countable]) -> StandingTotals:
    """Return the totals of attempts in the order of sending, one at least."""
    successes = [attempt.sent_at for attempt in attempts if attempt.outcome == Outcome.OK]
    last = attempts[-1]
    return StandingTotals(
        best_score=max(attempt.score for attempt in attempts),
        attempts=len(attempts),
        last_outcome=last.outcome,
        last_diagnosis=last.diagnosis,
        first_success_at=successes[0] if successes else None,
        last_at=last.sent_at,
    )


def add_attempt_to_standing(db: Session, account_id: UUID, exercise: str, attempt: CountedAttempt) -> None:
    """Count an attempt's first grading, in one statement: two workers that end at once are both counted.

    No two attempts of one account have the same time: the rate limit of the account serialises them.
    """
    row = {"account_id": account_id, "exercise": exercise, **vars(compute_standing_totals([attempt]))}
    write_core(db, _build_upsert_statement(db.get_bind().dialect.name), row)


@cache
def _build_upsert_statement(dialect: str) -> Insert:
    """Return the statement of `add_attempt_to_standing`, built once: it is on the hot path of a verdict."""
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


def rebuild_account(db: Session, account_id: UUID, exercise: str | None = None) -> int:
    """Rebuild an account's standings, in one exercise or in all. Return how many have changed."""
    return rebuild_accounts(db, [account_id], exercise)


def rebuild_accounts(db: Session, accounts: Collection[UUID], exercise: str | None = None) -> int:
    """Rebuild the standings of many accounts, in one exercise or in all. Return how many have changed.

    The rows of the accounts and of their standings are locked before the history is read, so that a grading that ends
    meanwhile is counted afterwards: `add_attempt_to_standing` waits for the row of the standing, or for that of the
    account.
    """
    lock_accounts(db, accounts)
    stored = _load_locked_standings(db, accounts, exercise)
    rebuilt = _compute_from_history(db, accounts, exercise)
    wrong = [key for key in stored.keys() | rebuilt.keys() if stored.get(key) != rebuilt.get(key)]
    _write_standings(db, {key: rebuilt.get(key) for key in wrong})
    return len(wrong)


def lock_accounts(db: Session, accounts: Collection[UUID]) -> None:
    """Lock accounts until the commit, always in the same order, so that nothing is added to their history."""
    db.execute(select(Account.id).where(Account.id.in_(accounts)).order_by(Account.id).with_for_update())


def _write_standings(db: Session, totals_by_pair: Mapping[tuple[UUID, str], StandingTotals | None]) -> None:
    """Insert or update standings, and delete those without totals."""
    rows = [
        {"account_id": account_id, "exercise": exercise, **vars(totals)}
        for (account_id, exercise), totals in totals_by_pair.items()
        if totals is not None
    ]
    if rows:
        statement = upsert_statement(db, Standing)
        changes = {name: statement.excluded[name] for name in TOTAL_COLUMNS}
        db.execute(statement.on_conflict_do_update(index_elements=KEY, set_=changes), rows)
    for (account_id, exercise), totals in totals_by_pair.items():
        if totals is None:
            db.execute(delete(Standing).where(Standing.account_id == account_id, Standing.exercise == exercise))


def _load_locked_standings(db: Session, accounts: Collection[UUID], exercise: str | None) -> TotalsByPair:
    query = _select_standings().where(Standing.account_id.in_(accounts))
    query = query if exercise is None else query.where(Standing.exercise == exercise)
    return _load_totals_by_pair(db, query.order_by(Standing.account_id, Standing.exercise).with_for_update())


def _compute_from_history(db: Session, accounts: Collection[UUID], exercise: str | None) -> TotalsByPair:
    query = _select_history(accounts)
    return _compute_totals_by_pair(db, query if exercise is None else query.where(Submission.exercise == exercise))


def _select_history(accounts: Collection[UUID]) -> HistoryQuery:
    sent = Submission
    return (
        select(sent.account_id, sent.exercise, sent.created_at, Grading.outcome, Grading.score, Grading.diagnosis)
        .join(Grading, Grading.id == sent.grading_id)
        .where(sent.account_id.in_(accounts), Grading.outcome != Outcome.INTERNAL_ERROR)
        .order_by(sent.account_id, sent.exercise, sent.created_at, sent.id)
    )


def _compute_totals_by_pair(db: Session, query: HistoryQuery) -> TotalsByPair:
    groups = groupby(db.execute(query), key=lambda row: (row[0], row[1]))
    return {key: compute_standing_totals([_build_counted_attempt(*row[2:]) for row in rows]) for key, rows in groups}


def load_standings_until(db: Session, account_id: UUID, until: Mapping[str, datetime]) -> Mapping[str, StandingTotals]:
    """Return the totals of the attempts sent before these times, by exercise, in these exercises alone."""
    earlier = [and_(Submission.exercise == name, Submission.created_at < when) for name, when in until.items()]
    return {
        key[1]: totals
        for key, totals in _compute_totals_by_pair(db, _select_history([account_id]).where(or_(*earlier))).items()
    }


def _select_standings() -> StandingQuery:
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


def _build_counted_attempt(
    sent_at: datetime, outcome: str, score: float | None, diagnosis: str | None
) -> CountedAttempt:
    if score is None:
        raise ValueError(f"a grading that ended as {outcome} has no score")
    return CountedAttempt(sent_at, outcome, score, diagnosis)


def _load_totals_by_pair(db: Session, query: StandingQuery) -> TotalsByPair:
    return {(row[0], row[1]): StandingTotals(*row[2:]) for row in db.execute(query)}


def load_account_standings(db: Session, account_id: UUID, exercise: str | None = None) -> Mapping[str, StandingTotals]:
    """Return an account's standings, by exercise: in one exercise, or in all."""
    query = _select_standings().where(Standing.account_id == account_id)
    rows = db.execute(query if exercise is None else query.where(Standing.exercise == exercise))
    return {row[1]: StandingTotals(*row[2:]) for row in rows}


def list_accounts_with_standings(db: Session) -> Sequence[UUID]:
    """Return every account that has a standing, or should have one."""
    senders = select(Submission.account_id).where(Submission.grading_id.is_not(None))
    return db.execute(union(senders, select(Standing.account_id))).scalars().all()


def count_standings(db: Session) -> int:
    return db.execute(select(func.count()).select_from(Standing)).scalar_one()
