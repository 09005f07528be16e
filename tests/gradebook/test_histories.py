"""Cached histories equal what the database holds, whatever is changed and rolled back."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import chain
from uuid import UUID, uuid4

import pytest
from sqlalchemy import delete, insert, select, text, update
from sqlalchemy.orm import Session

from graders.core.contract.outcomes import Outcome
from server.database import Database, table_of, utc_now
from server.gradebook import service
from server.gradebook.histories import (
    MAX_RESULTS,
    AccountHistory,
    AttemptHistoryCache,
    Attempts,
    GradedAttempt,
    Revision,
    cached_per_history,
    cached_per_series,
    load_revisions,
)
from server.gradebook.models import Grading
from server.identity.models import Account
from server.personal.guest_adoption import adopt_guest_data
from server.submissions.models import Submission
from tests.gradebook.test_gradebook import graded, record, sent
from tests.support.service import new_account


@pytest.fixture
def ada(database: Database) -> UUID:
    """Who has sent two attempts, of which the first was graded twice."""
    account = new_account(database).id
    for _ in range(2):
        name = sent(database, account)
        record(database, name, graded(score=0.25))
    with database.write() as db:
        first = db.execute(select(Submission.id).order_by(Submission.created_at).limit(1)).scalar_one()
        service.add_uncounted_grading(db, first, graded(Outcome.OK))
    return account


def revision(database: Database, account: UUID) -> Revision | None:
    with database.read() as db:
        return load_revisions(db, [account]).get(account)


def attempts_in(db: Session, histories: AttemptHistoryCache, *accounts: UUID) -> dict[UUID, tuple[GradedAttempt, ...]]:
    loaded = histories.load(db, load_revisions(db, accounts))
    return {one: tuple(chain.from_iterable(history.attempts.values())) for one, history in loaded.items()}


def look(database: Database, histories: AttemptHistoryCache, *accounts: UUID) -> dict[UUID, tuple[GradedAttempt, ...]]:
    with database.read() as db:
        return attempts_in(db, histories, *accounts)


def anew() -> AttemptHistoryCache:
    return AttemptHistoryCache(1000)


def test_every_change_is_loaded_at_once(database: Database, ada: UUID) -> None:
    alan, kept = new_account(database).id, anew()
    with database.read() as db:
        first, last = db.execute(select(Submission.id).order_by(Submission.created_at)).scalars()
        old, new = db.execute(
            select(Grading.id).where(Grading.submission_id == first).order_by(Grading.finished_at)
        ).scalars()

    def chosen(grading: UUID) -> Callable[[], None]:
        def choose() -> None:
            with database.write() as db:
                service.set_counting_grading(db, first, grading)

        return choose

    def changed(model: type[Submission] | type[Grading], name: UUID, **values: object) -> Callable[[], None]:
        def change() -> None:
            with database.write() as db:
                db.execute(update(model).where(model.id == name).values(**values))

        return change

    def inserted() -> None:
        """As no part of the service does: an attempt that comes with its grading, of another one."""
        with database.write() as db:
            row = {"account_id": ada, "exercise": "m/a", "source": b"", "seed": 1, "digest": "d", "grading_id": old}
            db.execute(insert(table_of(Submission)), {"id": uuid4(), "created_at": utc_now(), **row})

    def purged() -> None:
        with database.write() as db:
            db.execute(delete(Submission).where(Submission.exercise == "m/a"))

    def sent_more() -> None:
        record(database, sent(database, ada), graded(Outcome.OK))

    def waits_again() -> None:
        changed(Submission, last, grading_id=None)()

    def moved() -> None:
        with database.write() as db:
            db.execute(update(Submission).where(Submission.id == last).values(account_id=alan))

    def adopted() -> None:
        with database.write() as db:
            adopt_guest_data(db, ada, alan)

    def erased() -> None:
        with database.write() as db:
            db.execute(delete(Account).where(Account.id == alan))

    changes = (
        *(chosen(new), chosen(old), sent_more, inserted, purged),
        *(changed(Submission, last, exercise="m/b"), changed(Submission, last, digest="other")),
        *(changed(Submission, last, created_at=utc_now()), changed(Grading, old, score=0.75)),
        *(changed(Grading, old, outcome="timeout"), changed(Grading, old, diagnosis="tri"), moved, adopted),
        *(waits_again, erased),
    )
    before = look(database, kept, ada, alan)
    seen = {revision(database, ada): before[ada]}
    for change in changes:
        change()
        after = look(database, kept, ada, alan)
        assert after == look(database, anew(), ada, alan)
        assert after != before
        before, again = after, after.get(ada, ())
        assert seen.setdefault(revision(database, ada), again) == again, "none ever returns with anything else"
    assert before == {}
    assert len(seen) == 1 + len(changes) - 3, "after the purge it is what it was before; who has none has no other"


def test_columns_that_are_not_read_keep_the_revision(database: Database, ada: UUID) -> None:
    before = revision(database, ada)
    with database.write() as db:
        db.execute(update(Submission).values(source=b"y = 2\n", seed=7))
        db.execute(update(Grading).values(verdict={}, figures={}, total_ms=3.0))
        service.add_uncounted_grading(db, db.execute(select(Submission.id).limit(1)).scalar_one(), graded(Outcome.OK))
    sent(database, ada)
    assert revision(database, ada) == before


def test_rolled_back_changes_are_never_loaded(database: Database, ada: UUID) -> None:
    """Whoever looks in a transaction that is undone keeps what it saw, and nobody else is ever shown it."""
    kept, before = anew(), look(database, anew(), ada)
    for score in (0.5, 0.75):
        with database.write() as db:
            db.execute(update(Grading).values(score=score))
            inside = attempts_in(db, kept, ada)[ada]
            assert {one.score for one in inside} == {score}
            db.rollback()
        assert look(database, kept, ada) == before
    with database.write() as db:
        with db.begin_nested() as nested:
            db.execute(update(Grading).values(score=0.1))
            assert {one.score for one in attempts_in(db, kept, ada)[ada]} == {0.1}
            nested.rollback()
        assert attempts_in(db, kept, ada)[ada] == before[ada]
        db.execute(update(Grading).values(score=0.2))
        assert {one.score for one in attempts_in(db, kept, ada)[ada]} == {0.2}
    assert {one.score for one in look(database, kept, ada)[ada]} == {0.2}


def test_concurrent_changes(database: Database, ada: UUID) -> None:
    """Of two transactions side by side: what is kept is what was read together, whatever was told before. SQLite shows
    a transaction what was there when it began, PostgreSQL what is there when it asks."""
    kept = anew()
    with database.read() as db:
        told = load_revisions(db, [ada])
        with_file = database.engine.dialect.name == "sqlite"
        record(database, sent(database, ada), graded(Outcome.OK))
        known = kept.load(db, told)[ada]
        assert sum(map(len, known.attempts.values())) == (2 if with_file else 3)
        assert (known.revision == told[ada]) is with_file
        assert (load_revisions(db, [ada])[ada] == told[ada]) is with_file
    assert look(database, kept, ada) == look(database, anew(), ada)
    with database.write() as writing:
        writing.execute(update(Grading).values(score=0.3))
        inside = attempts_in(writing, kept, ada)[ada]
        outside = look(database, kept, ada)[ada]
        assert {one.score for one in inside} == {0.3}
        assert {one.score for one in outside} == {0.25, 1.0}, "nobody sees what is not committed"
        assert attempts_in(writing, kept, ada)[ada] == inside
    assert look(database, kept, ada)[ada] == inside


def test_only_changed_accounts_are_read_again(database: Database, ada: UUID) -> None:
    alan, kept = new_account(database).id, anew()
    record(database, sent(database, alan), graded())

    def load() -> dict[UUID, AccountHistory]:
        with database.read() as db:
            return dict(kept.load(db, load_revisions(db, [ada, alan])))

    first = load()
    again = load()
    assert all(again[one] is first[one] for one in (ada, alan))
    record(database, sent(database, alan), graded(Outcome.OK))
    second = load()
    assert second[alan] is not first[alan]
    assert second[ada] is first[ada]


def test_what_follows_from_attempts_alone_is_computed_once(database: Database, ada: UUID) -> None:
    computed = []

    @cached_per_series
    def count(attempts: Attempts) -> int:
        computed.append(len(attempts))
        return len(attempts)

    def counts() -> list[int]:
        with database.read() as db:
            (history,) = kept.load(db, load_revisions(db, [ada])).values()
        return [count(series) for series in history.attempts.values()]

    kept = anew()
    assert counts() == counts() == [2]
    record(database, sent(database, ada), graded(Outcome.OK))
    assert counts() == counts() == [3]
    assert computed == [2, 3]
    assert count(()) == count(()) == 0, "attempts that no history holds"


def test_what_other_arguments_decide_is_computed_anew_with_these(database: Database, ada: UUID) -> None:
    computed = []

    @cached_per_history
    def score(own: Mapping[str, Attempts], place: str, weights: list[float]) -> float:
        computed.append(place)
        return sum(weights) * sum(map(len, own.values()))

    def scored(place: str, *weights: float) -> float:
        with database.read() as db:
            (history,) = kept.load(db, load_revisions(db, [ada])).values()
        return score(history.attempts, place, list(weights))

    kept = anew()
    assert [scored("a", 1), scored("b", 2), scored("a", 1), scored("b", 2)] == [2, 4, 2, 4]
    assert computed == ["a", "b"], "one place does not drive out another"
    assert [scored("a", 3), scored("a", 1)] == [6, 2]
    record(database, sent(database, ada), graded(Outcome.OK))
    assert [scored("b", 2), score({}, "b", [2])] == [6, 0], "neither old attempts, nor those that no history holds"
    several = [scored(str(place), 1) for place in range(100)]
    assert several == [3] * 100
    with database.read() as db:
        (history,) = kept.load(db, load_revisions(db, [ada])).values()
    assert len(history.attempts.results) <= MAX_RESULTS


def test_a_great_many_attempts_have_a_revision(sqlite: Database) -> None:
    """Sums of sixty bits would outgrow what SQLite counts with after eight."""
    account = new_account(sqlite).id
    for _ in range(12):
        record(sqlite, sent(sqlite, account), graded())
    with sqlite.write() as db:
        db.execute(text("UPDATE submission SET revision = 1152921504606846975"))
    found = look(sqlite, anew(), account)
    assert len(found[account]) == 12
    assert revision(sqlite, account) == (12 * (2**32 - 1), 12 * (2**28 - 1))
