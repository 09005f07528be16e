"""Gradings and standings: what is kept as gradings come is what the history comes to, whatever happens to it."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from uuid import UUID, uuid4

import pytest
from hypothesis import HealthCheck, given
from hypothesis import settings as runs
from hypothesis import strategies as st
from sqlalchemy import delete, insert, select, update

from graders.core.contract.bounds import VERDICT_BYTES, json_size
from graders.core.contract.findings import Judgement
from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Counterexample, Diagnosis, Verdict
from server.base.errors import NotFound
from server.base.settings import Settings
from server.cli import main
from server.database import Database, utc_now
from server.gradebook import repository, service, standings
from server.gradebook.histories import AttemptHistoryCache, load_revisions
from server.gradebook.models import Grading, Standing
from server.gradebook.schemas import ExerciseProgress, GradingResult
from server.gradebook.standings import StandingTotals
from server.identity import repository as identity
from server.identity.models import Account, Role
from server.submissions.models import Submission
from tests.support.quick import migrated
from tests.support.service import EXERCISE, new_account, worker_of

EXERCISES = ("m/a", "m/b")
HISTORIES = AttemptHistoryCache(10_000)


def graded(outcome: Outcome = Outcome.WRONG_ANSWER, score: float = 0.0, diagnosis: str | None = None) -> GradingResult:
    passed = outcome is Outcome.OK
    check = CheckResult("a", "Une", passed, 20.0 if passed else 20.0 * min(score, 0.95), 20.0)
    checks = [check] if outcome.counts else []
    name = Diagnosis(diagnosis, "Une erreur", "Son explication.") if diagnosis else None
    return GradingResult(
        Judgement(Verdict("m/a", "v1", outcome, 1, checks, name, timings={"total_ms": 2.0})), utc_now()
    )


def sent(database: Database, account_id: UUID, exercise: str = EXERCISE) -> UUID:
    with database.write() as db:
        row = Submission(account_id=account_id, exercise=exercise, source=b"x", digest=str(uuid4()), seed=1)
        db.add(row)
    return row.id


def record(database: Database, submission_id: UUID, grading: GradingResult) -> None:
    with database.write() as db:
        assert service.record_grading(db, submission_id, grading) is not None


def sums(database: Database, account_id: UUID) -> dict[str, StandingTotals]:
    with database.read() as db:
        return dict(standings.load_account_standings(db, account_id))


def test_a_submission_keeps_every_grading_and_one_counts(database: Database, ada: Account) -> None:
    submission = sent(database, ada.id)
    record(database, submission, graded(score=0.25, diagnosis="sign"))
    with database.write() as db:
        second = service.add_uncounted_grading(db, submission, graded(Outcome.OK))
    with database.read() as db:
        attempt = service.find_attempt(db, ada, submission)
        assert attempt.grading is not None
        assert (attempt.grading.score, attempt.grading.diagnosis, attempt.grading.total_ms) == (0.25, "sign", 2.0)
        assert [row.score for row in repository.list_gradings(db, submission)] == [0.25, 1.0]
    with database.write() as db:
        service.set_counting_grading(db, submission, second)
    with database.read() as db:
        assert service.load_progress(db, ada) == {EXERCISE: ExerciseProgress(1.0, 1, succeeded=True)}
        assert len(repository.list_gradings(db, submission)) == 2


def test_a_mistake_that_others_resemble_is_not_counted(database: Database, ada: Account) -> None:
    resembling = graded(diagnosis="sign")
    told = Diagnosis("sign", "Peut-être : un signe est faux", "Son explication.")
    verdict = replace(resembling.judgement.verdict, diagnosis=told)
    submission = sent(database, ada.id)
    record(database, submission, replace(resembling, judgement=Judgement(verdict)))
    assert sums(database, ada.id)[EXERCISE].last_diagnosis is None
    with database.read() as db:
        assert db.scalars(select(Grading.diagnosis)).all() == [None]


def test_only_a_submission_s_own_gradings_may_count(database: Database, ada: Account) -> None:
    mine, other = sent(database, ada.id), sent(database, ada.id)
    record(database, other, graded(Outcome.OK))
    with database.read() as db:
        (foreign,) = repository.list_gradings(db, other)
    for submission in (mine, uuid4()):
        with pytest.raises(NotFound), database.write() as db:
            service.set_counting_grading(db, submission, foreign.id)


def test_last_attempt_is_by_time_of_sending_not_of_grading(database: Database, ada: Account) -> None:
    first, second, third = (sent(database, ada.id) for _ in range(3))
    record(database, third, graded(Outcome.TIMEOUT, diagnosis="loop"))
    record(database, second, graded(Outcome.OK))
    record(database, first, graded(Outcome.OK))
    kept = sums(database, ada.id)[EXERCISE]
    assert (kept.attempts, kept.best_score, kept.last_outcome, kept.last_diagnosis) == (3, 1.0, "timeout", "loop")
    with database.read() as db:
        at = {row.id: row.created_at for row in db.execute(select(Submission)).scalars()}
    assert (kept.first_success_at, kept.last_at) == (at[first], at[third])


def test_concurrent_gradings_are_all_counted(database: Database, ada: Account, both: Settings) -> None:
    """Several workers, and somebody who makes the standings again meanwhile."""
    names = [sent(database, ada.id) for _ in range(24)]

    def grade(name: UUID) -> None:
        record(database, name, graded(Outcome.OK))

    def recount(_: int) -> None:
        with database.write() as db:
            service.rebuild_account_standings(db, ada.id)

    with ThreadPoolExecutor(8) as pool:
        graded_ones = [pool.submit(grade, name) for name in names]
        recounts = [pool.submit(recount, number) for number in range(8)]
        for future in (*graded_ones, *recounts):
            future.result()
    assert sums(database, ada.id)[EXERCISE].attempts == 24
    with database.write() as db:
        assert service.rebuild_account_standings(db, ada.id) == 0


def test_concurrent_guests_are_all_adopted(database: Database, ada: Account) -> None:
    guests = [new_account(database, Role.guest).id for _ in range(6)]
    for guest in guests:
        record(database, sent(database, guest), graded(score=0.5))

    def join(guest: UUID) -> None:
        with database.write() as db:
            service.move_guest_attempts(db, guest, ada.id)
            identity.delete_account(db, guest)

    with ThreadPoolExecutor(6) as pool:
        list(pool.map(join, guests))
    assert sums(database, ada.id)[EXERCISE].attempts == 6
    assert service.rebuild_all_standings(database) == (1, 0)


@dataclass
class Story:
    """A database, and what ought to be in it, kept in the plainest way."""

    database: Database
    accounts: list[UUID] = field(default_factory=list)
    sent: list[dict[str, Any]] = field(default_factory=list)

    def arrive(self) -> None:
        self.accounts.append(new_account(self.database, Role.guest).id)

    def submit(self, who: int, which: int) -> None:
        account = self.accounts[who % len(self.accounts)]
        exercise = EXERCISES[which % len(EXERCISES)]
        name = sent(self.database, account, exercise)
        with self.database.read() as db:
            at = db.execute(select(Submission.created_at).where(Submission.id == name)).scalar_one()
        self.sent.append(
            {"id": name, "account": account, "exercise": exercise, "at": at, "gradings": {}, "counting": None}
        )

    def grade(self, which: int, outcome: Outcome, score: float) -> None:
        """Any of those that wait, in any order."""
        waiting = [row for row in self.sent if row["counting"] is None]
        if waiting:
            row, grading = waiting[which % len(waiting)], graded(outcome, score, f"d{which % 3}")
            record(self.database, row["id"], grading)
            with self.database.read() as db:
                counting = db.execute(select(Submission.grading_id).where(Submission.id == row["id"])).scalar_one()
            row["gradings"][counting], row["counting"] = grading, counting

    def regrade(self, which: int, outcome: Outcome, score: float) -> None:
        done = [row for row in self.sent if row["counting"] is not None]
        if done:
            row, grading = done[which % len(done)], graded(outcome, score)
            with self.database.write() as db:
                row["gradings"][service.add_uncounted_grading(db, row["id"], grading)] = grading

    def choose(self, which: int, other: int) -> None:
        done = [row for row in self.sent if row["counting"] is not None]
        if done:
            row = done[which % len(done)]
            row["counting"] = list(row["gradings"])[other % len(row["gradings"])]
            with self.database.write() as db:
                service.set_counting_grading(db, row["id"], row["counting"])

    def adopt(self, who: int, other: int) -> None:
        guest, account = (self.accounts[number % len(self.accounts)] for number in (who, other))
        if guest == account:
            return
        with self.database.write() as db:
            service.move_guest_attempts(db, guest, account)
            identity.delete_account(db, guest)
        self.accounts.remove(guest)
        for row in self.sent:
            row["account"] = account if row["account"] == guest else row["account"]

    def expected(self, account: UUID, exercise: str) -> StandingTotals | None:
        rows = [row for row in self.sent if (row["account"], row["exercise"]) == (account, exercise)]
        pairs = [(row["at"], row["gradings"][row["counting"]].verdict) for row in rows if row["counting"]]
        pairs = [pair for pair in pairs if pair[1].outcome is not Outcome.INTERNAL_ERROR]
        if not pairs:
            return None
        return StandingTotals(
            best_score=max(verdict.score for _, verdict in pairs),
            attempts=len(pairs),
            last_outcome=pairs[-1][1].outcome,
            last_diagnosis=pairs[-1][1].misconception,
            first_success_at=min((at for at, verdict in pairs if verdict.outcome is Outcome.OK), default=None),
            last_at=pairs[-1][0],
        )

    def check(self) -> None:
        with self.database.read() as db:
            cached, fresh = (
                histories.load(db, load_revisions(db, self.accounts))
                for histories in (HISTORIES, AttemptHistoryCache(1000))
            )
            assert cached == fresh
        for account in self.accounts:
            kept = sums(self.database, account)
            assert kept == {name: row for name in EXERCISES if (row := self.expected(account, name))}
        total, changed = service.rebuild_all_standings(self.database)
        assert changed == 0
        assert total == sum(len(sums(self.database, account)) for account in self.accounts)


NUMBER = st.integers(0, 30)
OUTCOME = st.sampled_from([Outcome.OK, Outcome.WRONG_ANSWER, Outcome.TIMEOUT, Outcome.INTERNAL_ERROR])
SCORE = st.sampled_from([0.0, 0.25, 0.5, 0.95])
STEP = st.one_of(
    st.tuples(st.just("submit"), NUMBER, NUMBER),
    st.tuples(st.just("submit"), NUMBER, NUMBER),
    st.tuples(st.just("grade"), NUMBER, OUTCOME, SCORE),
    st.tuples(st.just("grade"), NUMBER, OUTCOME, SCORE),
    st.tuples(st.just("regrade"), NUMBER, OUTCOME, SCORE),
    st.tuples(st.just("choose"), NUMBER, NUMBER),
    st.tuples(st.just("adopt"), NUMBER, NUMBER),
    st.tuples(st.just("arrive")),
)


def tell(database: Database, steps: list[tuple[Any, ...]]) -> None:
    story = Story(database)
    story.arrive()
    story.arrive()
    for name, *arguments in steps:
        getattr(story, name)(*arguments)
        story.check()


def in_a_file(steps: list[tuple[Any, ...]]) -> None:
    with TemporaryDirectory() as folder, closing(migrated(Settings(data_dir=Path(folder), workers=0))) as database:
        tell(database, steps)


@given(st.lists(STEP, max_size=25))
@runs(max_examples=20, deadline=None, database=None)
def test_incremental_and_rebuilt_standings_agree(steps: list[tuple[Any, ...]]) -> None:
    in_a_file(steps)


@pytest.mark.slow
@given(st.lists(STEP, max_size=60))
@runs(max_examples=200, deadline=None, database=None)
def test_incremental_and_rebuilt_standings_agree_in_long_histories(steps: list[tuple[Any, ...]]) -> None:
    in_a_file(steps)


@pytest.fixture
def on_postgres(settings: Settings, postgres_url: str) -> Iterator[Database]:
    with closing(migrated(settings.model_copy(update={"database_url": postgres_url}))) as database:
        yield database
        with database.write() as db:
            db.execute(delete(Account))


@pytest.mark.contract
@given(st.lists(STEP, max_size=12))
@runs(max_examples=6, deadline=None, database=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_incremental_and_rebuilt_standings_agree_on_postgresql(
    on_postgres: Database, steps: list[tuple[Any, ...]]
) -> None:
    with on_postgres.write() as db:
        db.execute(delete(Account))
    tell(on_postgres, steps)


def spoil(database: Database, account_id: UUID) -> None:
    """One standing wrong, one missing, one too many."""
    for exercise in ("m/a", "m/b"):
        record(database, sent(database, account_id, exercise), graded(Outcome.OK))
    now = utc_now()
    extra = StandingTotals(1.0, 3, "ok", None, now, now)
    with database.write() as db:
        db.execute(update(Standing).where(Standing.exercise == "m/a").values(attempts=7))
        db.execute(delete(Standing).where(Standing.exercise == "m/b"))
        db.execute(insert(Standing).values(account_id=account_id, exercise="m/c", **vars(extra)))


def test_rebuilding_repairs_wrong_missing_and_surplus_standings(database: Database, ada: Account) -> None:
    spoil(database, ada.id)
    assert service.rebuild_all_standings(database) == (2, 3)
    assert {name: row.attempts for name, row in sums(database, ada.id).items()} == {"m/a": 1, "m/b": 1}
    assert service.rebuild_all_standings(database) == (2, 0)


def test_an_administrator_rebuilds_standings(sqlite: Database, settings: Settings, capsys: Any) -> None:
    spoil(sqlite, new_account(sqlite).id)
    command = ["admin", "standings", "--data", str(settings.data_dir)]
    told = []
    for _ in range(2):
        assert main(command) == 0
        told.append(capsys.readouterr().out)
    assert "3 lignes corrigées, 2 en tout" in told[0]
    assert "0 ligne corrigée, 2 en tout" in told[1]


def test_rebuilding_without_a_database_is_reported(tmp_path: Path, capsys: Any) -> None:
    assert main(["admin", "standings", "--data", str(tmp_path / "elsewhere")]) == 2
    assert "pas de base de données" in capsys.readouterr().err
    assert not (tmp_path / "elsewhere").exists()


def test_waiting_attempts_count_among_those_sent(database: Database, ada: Account, both: Settings) -> None:
    record(database, sent(database, ada.id), graded(score=0.5))
    sent(database, ada.id)
    sent(database, ada.id, "m/b")
    with database.read() as db:
        assert service.load_progress(db, ada) == {EXERCISE: ExerciseProgress(0.5, 2), "m/b": ExerciseProgress(None, 1)}
        assert service.load_progress(db, ada, EXERCISE) == {EXERCISE: ExerciseProgress(0.5, 2)}
    assert not worker_of(database, both).run_one(), "these were never queued"


def test_deleting_an_account_deletes_its_gradings(database: Database, ada: Account) -> None:
    submission = sent(database, ada.id)
    record(database, submission, graded(Outcome.OK))
    with database.write() as db:
        service.add_uncounted_grading(db, submission, graded())
        identity.delete_account(db, ada.id)
    with database.read() as db:
        for table in (Submission, Grading, Standing):
            assert db.execute(select(table)).first() is None


def test_recorded_verdicts_are_bounded_and_say_what_was_cut(database: Database, ada: Account) -> None:
    shown = Counterexample({"x": 1.0}, 2.0, {"k" * 300_000: 1})
    check = CheckResult("a", "Une", False, 0, 20.0, "m" * 300_000, shown, figure="a")
    heavy = Verdict("m/a", "v1", Outcome.WRONG_ANSWER, 1, [check], stdout="\x01" * 65536)
    submission = sent(database, ada.id)
    record(database, submission, GradingResult(Judgement(heavy, {"a": {"rows": [0.5] * 90_000}}), utc_now()))
    with database.read() as db:
        grading = service.find_attempt(db, ada, submission).grading
        assert grading is not None
        kept, figures = Verdict.from_json(grading.verdict), repository.load_figures(db, grading.id)
    assert json_size(kept.to_json()) + json_size(figures) <= VERDICT_BYTES
    assert (kept.outcome, kept.points, figures) == (heavy.outcome, heavy.points, {})
    assert "300000 caractères" in kept.checks[0].message
