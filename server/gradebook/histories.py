"""The graded attempts of accounts, cached by revision.

The database draws a new random revision for a submission whenever its counting grading changes
(`Submission.revision`). The sum of an account's revisions is a version tag: equal tags mean equal attempts. A page
loads the tags with one small query, and reads the attempts only of the accounts whose tag has changed. Attempts are
cached with the tag read in the same statement, so that an entry is right whatever other transactions do meanwhile.
What is computed of a series of attempts alone (`computed_once`) lives as long as the series.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import wraps
from itertools import groupby
from operator import attrgetter, itemgetter
from typing import Any, NamedTuple, TypeVar
from uuid import UUID

from sqlalchemy import Integer, func, literal, select
from sqlalchemy.orm import Session

from server.assignments.counting import ScoredAttempt
from server.base.caches import LRUCache
from server.gradebook.models import Grading
from server.gradebook.standings import StandingTotals, compute_totals
from server.submissions.models import Submission

MAX_CACHED_ATTEMPTS = 60_000  # of all accounts together, 1 kB each at most

#: The sums of the low and of the high halves of an account's revisions: a sum of whole ones would overflow.
Revision = tuple[int, int]
Revisions = Mapping[UUID, Revision]
HALF_BITS = 32
LOW_MASK = (1 << HALF_BITS) - 1
REVISION_SUMS = (
    func.sum(Submission.revision.bitwise_and(LOW_MASK)),
    func.sum(Submission.revision.bitwise_rshift(literal(HALF_BITS, Integer))),
)


@dataclass(frozen=True)
class GradedAttempt(ScoredAttempt):
    """An attempt with the grading that counts; `id` is that of the submission, `score` in [0, 1]."""

    account_id: UUID
    exercise: str
    digest: str
    outcome: str
    diagnosis: str | None
    grading_id: UUID


#: Attempts of one account at one exercise, the oldest first.
Attempts = Sequence[GradedAttempt]
AttemptsByPair = Mapping[tuple[UUID, str], Attempts]


class AttemptSeries(tuple[GradedAttempt, ...]):
    """Attempts as a history holds them. Functions marked `computed_once` leave in it what they have returned of it."""


Result = TypeVar("Result")


def computed_once(compute: Callable[[Attempts], Result]) -> Callable[[Attempts], Result]:
    """Compute what depends on attempts alone, and never changes, once for each series of a history."""
    name = f"{compute.__module__}.{compute.__qualname__}"

    @wraps(compute)
    def find_or_compute(attempts: Attempts) -> Result:
        if not isinstance(attempts, AttemptSeries):
            return compute(attempts)
        computed = vars(attempts)
        if name not in computed:
            computed[name] = compute(attempts)
        found: Result = computed[name]
        return found

    return find_or_compute


@computed_once
def attempt_totals(attempts: Attempts) -> StandingTotals:
    """Return what `compute_totals` does."""
    return compute_totals(attempts)


class AccountHistory(NamedTuple):
    """All graded attempts of an account, without internal errors; `size` counts the rows read."""

    revision: Revision
    attempts: AttemptsByPair
    exercises: frozenset[str]
    size: int


def load_revisions(db: Session, accounts: Collection[UUID]) -> Revisions:
    """Return the version tag of each account's graded attempts; accounts without any are left out."""
    query = select(Submission.account_id, *REVISION_SUMS).group_by(Submission.account_id)
    rows = db.execute(query.where(Submission.account_id.in_(accounts), Submission.revision.is_not(None)))
    return {account_id: (int(low), int(high)) for account_id, low, high in rows}


class AttemptHistories:
    """An LRU cache of histories by account, bounded by the attempts of all of them."""

    def __init__(self, max_attempts: int) -> None:
        self._histories: LRUCache[UUID, AccountHistory] = LRUCache(max_attempts, weigh=lambda history: history.size)

    def load(self, db: Session, revisions: Revisions) -> Mapping[UUID, AccountHistory]:
        """Return the histories with these revisions, just loaded in the same transaction, or newer ones."""
        cached = {account_id: self._histories.get(account_id) for account_id in revisions}
        histories = {
            account_id: history
            for account_id, history in cached.items()
            if history is not None and history.revision == revisions[account_id]
        }
        missing = revisions.keys() - histories.keys()
        if missing:
            for account_id, history in _read_histories(db, missing).items():
                histories[account_id] = self._histories.put(account_id, history)
        return dict(sorted(histories.items(), key=lambda item: item[0].int))

    def clear(self) -> None:
        self._histories.clear()


HISTORIES = AttemptHistories(MAX_CACHED_ATTEMPTS)


def load_attempts(
    db: Session, revisions: Revisions, exercises: Collection[str], until: datetime | None
) -> AttemptsByPair:
    """Return the attempts at these exercises, sent by `until` (None: at any time), by account and exercise.

    `revisions` were just loaded in the same transaction. Pairs without attempts are left out.
    """
    wanted = frozenset(exercises)
    by_pair: dict[tuple[UUID, str], Attempts] = {}
    for history in HISTORIES.load(db, revisions).values():
        own = history.attempts
        if not history.exercises <= wanted:
            own = {pair: attempts for pair, attempts in own.items() if pair[1] in wanted}
        by_pair.update(own)
    if until is None:
        return by_pair
    sent = {pair: _sent_by(attempts, until) for pair, attempts in by_pair.items()}
    return {pair: attempts for pair, attempts in sent.items() if attempts}


def _sent_by(attempts: Attempts, until: datetime) -> Attempts:
    if attempts[-1].sent_at <= until:
        return attempts
    return tuple(attempt for attempt in attempts if attempt.sent_at <= until)


def _read_histories(db: Session, accounts: Collection[UUID]) -> Mapping[UUID, AccountHistory]:
    columns = (
        *(Submission.account_id, Submission.exercise, Submission.created_at, Submission.id, Submission.digest),
        *(Grading.outcome, Grading.score, Grading.diagnosis, Submission.grading_id, Submission.revision),
    )
    query = select(*columns).join(Grading, Grading.id == Submission.grading_id)
    rows: list[Any] = sorted(db.execute(query.where(Submission.account_id.in_(accounts))), key=itemgetter(slice(0, 4)))
    histories = {}
    for account_id, group in groupby(rows, key=itemgetter(0)):
        own_rows = list(group)
        revision = sum(row[-1] & LOW_MASK for row in own_rows), sum(row[-1] >> HALF_BITS for row in own_rows)
        graded = [
            GradedAttempt(id, sent_at, score, account_id, exercise, digest, outcome, diagnosis, grading_id)
            for _, exercise, sent_at, id, digest, outcome, score, diagnosis, grading_id, _ in own_rows
            if score is not None
        ]
        series = {name: AttemptSeries(attempts) for name, attempts in groupby(graded, attrgetter("exercise"))}
        by_pair = {(account_id, exercise): attempts for exercise, attempts in series.items()}
        histories[account_id] = AccountHistory(revision, by_pair, frozenset(series), len(own_rows) + 1)
    return histories
