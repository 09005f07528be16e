"""What accounts have sent that was graded, kept by the revisions that the database draws (`Submission.revision`).

The revisions are asked for each time, in one small question; attempts are read of those accounts alone whose revisions
are no more what they were. What is kept was read together with its own revisions, in one statement: whatever else goes
on meanwhile, in transactions that are committed or not, it is what an account has sent wherever these are told.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import groupby
from operator import itemgetter
from typing import Any, Generic, NamedTuple, Protocol, TypeVar
from uuid import UUID

from sqlalchemy import Integer, Select, func, literal, select
from sqlalchemy.orm import Session

from server.base.caches import Lately
from server.database import Telling, ask, prepared, table_of
from server.gradebook.models import Grading
from server.submissions.models import Submission

Value = TypeVar("Value")


class Dated(Protocol):
    """What has a place in time."""

    @property
    def sent_at(self) -> datetime: ...


Trail = TypeVar("Trail", bound=tuple[Dated, ...])
#: Of all that an account has sent: the sums of both halves of its revisions, which no sum of many of them outgrows.
Revision = tuple[int, int]
Revisions = Mapping[UUID, Revision]
HALF = 32
LOW = (1 << HALF) - 1

_submissions, _gradings = table_of(Submission), table_of(Grading)
_sent = _submissions.c
SUMS = (func.sum(_sent.revision.bitwise_and(LOW)), func.sum(_sent.revision.bitwise_rshift(literal(HALF, Integer))))


class Attempt(NamedTuple):
    """An attempt as it is graded now; errors of ours have no score."""

    account: UUID
    exercise: str
    sent_at: datetime
    submission: UUID
    digest: str
    outcome: str
    score: float | None
    diagnosis: str | None
    grading: UUID


class Known(NamedTuple, Generic[Value]):
    """What was made of an account's attempts, and their revisions."""

    revision: Revision
    value: Value
    size: int


#: Read as attempts are, with its revision behind.
TOLD = Telling(
    _sent.account_id,
    _sent.exercise,
    _sent.created_at,
    _sent.id,
    _sent.digest,
    _gradings.c.outcome,
    _gradings.c.score,
    _gradings.c.diagnosis,
    _sent.grading_id,
    _sent.revision,
)


@prepared
def _revisions(accounts: Collection[UUID]) -> Select[*tuple[Any, ...]]:
    query = select(_sent.account_id, *SUMS).where(_sent.account_id.in_(accounts), _sent.revision.is_not(None))
    return query.group_by(_sent.account_id)


def revisions(db: Session, accounts: Collection[UUID]) -> Revisions:
    """Those of accounts of which something was graded. The same again: what they have sent is the same."""
    return {account: (int(low), int(high)) for account, low, high in ask(db, *_revisions(accounts)).all()}


@prepared
def _attempts(accounts: Collection[UUID]) -> Select[*tuple[Any, ...]]:
    query = select(*TOLD.asked).select_from(_submissions.join(_gradings, _gradings.c.id == _sent.grading_id))
    return query.where(_sent.account_id.in_(accounts))


def _read(db: Session, accounts: Collection[UUID]) -> Mapping[UUID, tuple[Revision, Sequence[Attempt]]]:
    """By account, all that it has sent, by exercise and in order."""
    read = TOLD.reader(db)
    rows = sorted((read(row) for row in ask(db, *_attempts(accounts)).all()), key=itemgetter(slice(0, 4)))
    found = {}
    for account, group in groupby(rows, key=itemgetter(0)):
        mine = list(group)
        revision = sum(row[-1] & LOW for row in mine), sum(row[-1] >> HALF for row in mine)
        found[account] = revision, [Attempt(*row[:-1]) for row in mine]
    return found


def until(trail: Trail, moment: datetime | None) -> Trail:
    """What of attempts in order was sent by then (None: all)."""
    if moment is None or trail[-1].sent_at <= moment:
        return trail
    return type(trail)(one for one in trail if one.sent_at <= moment)


@dataclass(frozen=True)
class Histories(Generic[Value]):
    """What `make` makes of one account's attempts, by exercise and in order; errors of ours are among them."""

    make: Callable[[Sequence[Attempt]], Value]
    kept: Lately[UUID, Known[Value]]

    @classmethod
    def of(cls, make: Callable[[Sequence[Attempt]], Value], most: int) -> Histories[Value]:
        """`most`: attempts that are kept, of all accounts."""
        return cls(make, Lately(most, size=lambda known: known.size))

    def told(self, db: Session, revisions: Revisions) -> Mapping[UUID, Known[Value]]:
        """Of accounts, with what was asked of their revisions just before: theirs, or newer ones. By account."""
        found = {one: known for one in revisions if (known := self.kept.get(one)) and known.revision == revisions[one]}
        missing = [one for one in revisions if one not in found]
        if missing:
            for account, (revision, attempts) in _read(db, missing).items():
                found[account] = self.kept.put(account, Known(revision, self.make(attempts), len(attempts) + 1))
        return dict(sorted(found.items()))
