"""The graded attempts of accounts, cached by revision.

The database draws a new random revision for a submission whenever its counting grading changes
(`Submission.revision`). The sum of an account's revisions is a version tag: equal tags mean equal attempts. A page
loads the tags with one small query, and reads the attempts only of the accounts whose tag has changed. Attempts are
cached with the tag read in the same statement, so that an entry is right whatever other transactions do meanwhile.
A result that depends on a series of attempts alone lives as long as the series (`cached_per_series`); one that depends
on all attempts of an account, and on other arguments, lives until these change (`cached_per_history`).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import wraps
from itertools import groupby
from operator import attrgetter, itemgetter
from typing import Any, NamedTuple, TypeVar, TypeVarTuple, Unpack
from uuid import UUID

from sqlalchemy import Integer, func, literal, select
from sqlalchemy.orm import Session

from server.assignments.counting import ScoredAttempt
from server.base.caches import LRUCache
from server.gradebook.models import Grading
from server.gradebook.standings import StandingTotals, compute_standing_totals
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
    """Attempts as a history holds them. Functions marked `cached_per_series` store their results in it."""


class OwnAttempts(dict[str, Attempts]):
    """Attempts of one account by exercise, as a history holds them: never changed. `by_pair`: the same.

    Functions marked `cached_per_history` store their results in it.
    """

    def __init__(self, account: UUID, attempts: Mapping[str, Attempts]) -> None:
        super().__init__(attempts)
        self.account = account
        self.by_pair: AttemptsByPair = {(account, exercise): series for exercise, series in attempts.items()}
        self.results: dict[tuple[str, Hashable], tuple[tuple[object, ...], Any]] = {}


class LoadedAttempts(dict[tuple[UUID, str], Attempts]):
    """Attempts by account and exercise; `by_account`: the same, of each account that has some."""

    def __init__(self, loaded: Iterable[OwnAttempts]) -> None:
        super().__init__()
        self.by_account: dict[UUID, Mapping[str, Attempts]] = {}
        for own in loaded:
            if own:
                self.by_account[own.account] = own
                self.update(own.by_pair)


MAX_RESULTS = 32  # of an account; then all are computed anew
Result = TypeVar("Result")
Place = TypeVar("Place", bound=Hashable)
Arguments = TypeVarTuple("Arguments")


def cached_per_series(compute: Callable[[Attempts], Result]) -> Callable[[Attempts], Result]:
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


def cached_per_history(
    compute: Callable[[Mapping[str, Attempts], Place, Unpack[Arguments]], Result],
) -> Callable[[Mapping[str, Attempts], Place, Unpack[Arguments]], Result]:
    """Compute what depends on an account's attempts and other arguments anew only where one of these has changed.

    The second argument says for what it is computed, such as a class: the last result of each stays in the history.
    The function depends on nothing else, not on the time either; its arguments, compared by `==`, never change.
    """
    name = f"{compute.__module__}.{compute.__qualname__}"

    @wraps(compute)
    def find_or_compute(own: Mapping[str, Attempts], place: Place, *arguments: *Arguments) -> Result:
        if not isinstance(own, OwnAttempts):
            return compute(own, place, *arguments)
        found = own.results.get((name, place))
        if found is None or found[0] != arguments:
            if found is None and len(own.results) >= MAX_RESULTS:
                own.results.clear()
            found = own.results[name, place] = arguments, compute(own, place, *arguments)
        result: Result = found[1]
        return result

    return find_or_compute


@cached_per_series
def cached_totals(attempts: Attempts) -> StandingTotals:
    """Return what `compute_standing_totals` does."""
    return compute_standing_totals(attempts)


class AccountHistory(NamedTuple):
    """All graded attempts of an account, without internal errors; `size` counts the rows read."""

    revision: Revision
    attempts: OwnAttempts
    size: int


def load_revisions(db: Session, accounts: Collection[UUID]) -> Revisions:
    """Return the version tag of each account's graded attempts; accounts without any are left out."""
    query = select(Submission.account_id, *REVISION_SUMS).group_by(Submission.account_id)
    rows = db.execute(query.where(Submission.account_id.in_(accounts), Submission.revision.is_not(None)))
    return {account_id: (int(low), int(high)) for account_id, low, high in rows}


class AttemptHistoryCache:
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
            for account_id, history in _read_account_histories(db, missing).items():
                histories[account_id] = self._histories.put(account_id, history)
        return dict(sorted(histories.items(), key=lambda item: item[0].int))

    def clear(self) -> None:
        self._histories.clear()


HISTORIES = AttemptHistoryCache(MAX_CACHED_ATTEMPTS)


def load_attempts_by_pair(
    db: Session, revisions: Revisions, exercises: Collection[str], until: datetime | None
) -> LoadedAttempts:
    """Return the attempts at these exercises, sent by `until` (None: at any time), by account and exercise.

    `revisions` were just loaded in the same transaction. Pairs without attempts are left out.
    """
    wanted = frozenset(exercises)
    histories = (history.attempts for history in HISTORIES.load(db, revisions).values())
    attempts = (own if own.keys() <= wanted else _select_exercises(own, wanted, own.account) for own in histories)
    return LoadedAttempts(attempts if until is None else (_sent_until(own, until) for own in attempts))


def group_by_account(attempts: AttemptsByPair) -> Mapping[UUID, Mapping[str, Attempts]]:
    """Return the attempts of each account by exercise."""
    if isinstance(attempts, LoadedAttempts):
        return attempts.by_account
    by_account: dict[UUID, dict[str, Attempts]] = {}
    for (account, exercise), series in attempts.items():
        by_account.setdefault(account, {})[exercise] = series
    return by_account


@cached_per_history
def _select_exercises(own: Mapping[str, Attempts], wanted: frozenset[str], account: UUID) -> OwnAttempts:
    return OwnAttempts(account, {exercise: series for exercise, series in own.items() if exercise in wanted})


def _sent_until(own: OwnAttempts, until: datetime) -> OwnAttempts:
    if all(series[-1].sent_at <= until for series in own.values()):
        return own
    sent = {name: [attempt for attempt in series if attempt.sent_at <= until] for name, series in own.items()}
    return OwnAttempts(own.account, {name: tuple(series) for name, series in sent.items() if series})


def _read_account_histories(db: Session, accounts: Collection[UUID]) -> Mapping[UUID, AccountHistory]:
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
        histories[account_id] = AccountHistory(revision, OwnAttempts(account_id, series), len(own_rows) + 1)
    return histories
