"""Which earlier files an attempt may import from: its author's own, accepted before, and not held back."""

from __future__ import annotations

from datetime import datetime, timedelta
from typing import Any

from graders.core.contract.findings import Judgement
from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Verdict
from server.assignments import feedback
from server.assignments.feedback import FeedbackHolds, SittingStage, WithholdingTest
from server.database import Database, utc_now
from server.gradebook import importable_files, service
from server.gradebook.schemas import GradingResult
from server.identity.models import Account
from server.submissions.models import Submission
from server.submissions.service import digest_code
from tests.support.quick import the_course
from tests.support.service import new_account

POSES, GRAPH = "l20/poses", "l20/slam_graphe"
ASKS = b"from mes_fonctions import composer\n"


def sent(database: Database, account: Account, exercise: str, source: bytes, minutes: float, **verdict: Any) -> None:
    outcome = verdict.get("outcome", Outcome.OK)
    passed = outcome is Outcome.OK
    check = CheckResult("a", "Une", passed, 20.0 if passed else 0.0, 20.0)
    found = GradingResult(Judgement(Verdict(exercise, "v", outcome, 1, [check])), utc_now())
    with database.write() as db:
        row = Submission(
            account_id=account.id,
            exercise=exercise,
            source=source,
            digest=verdict.get("digest", "d"),
            seed=1,
            created_at=at(minutes),
        )
        db.add(row)
        db.flush()
        service.record_grading(db, row.id, found)


START = utc_now() - timedelta(days=1)


def at(minutes: float) -> datetime:
    return START + timedelta(minutes=minutes)


def used(database: Database, account: Account, source: bytes = ASKS, minutes: float = 10) -> Any:
    with database.write() as db:
        row = Submission(
            account_id=account.id, exercise=GRAPH, source=source, digest="e", seed=1, created_at=at(minutes)
        )
        return importable_files.load_importable_files(db, the_course(), row)


def test_the_authors_last_accepted_file_before_the_attempt_is_imported(database: Database) -> None:
    ada, eve = new_account(database, name="ada"), new_account(database, name="eve")
    sent(database, ada, POSES, b"one", 1)
    sent(database, ada, POSES, b"two", 2)
    sent(database, ada, POSES, b"wrong", 3, outcome=Outcome.WRONG_ANSWER)
    sent(database, ada, POSES, b"later", 20)
    sent(database, eve, POSES, b"hers", 4)
    assert used(database, ada) == {POSES: b"two"}
    assert used(database, ada, minutes=30) == {POSES: b"later"}
    assert used(database, ada, source=b"import numpy\n") == {}
    with database.read() as db:
        assert importable_files.load_importable_file_times(db, ada.id, [POSES, GRAPH]) == {POSES: at(20)}


def test_importing_a_file_reveals_no_withheld_verdict(database: Database) -> None:
    ada = new_account(database, name="ada")
    sent(database, ada, POSES, b"one", 1)
    sent(database, ada, POSES, b"held", 5)
    test = WithholdingTest(ada.id, ada.id, "Contrôle", SittingStage.running, at(3), None)
    with database.write() as db:
        db.info[feedback.MEMO] = {(ada.id, None): {POSES: FeedbackHolds(tests=(test,))}}
        row = Submission(account_id=ada.id, exercise=GRAPH, source=ASKS, digest="e", seed=1, created_at=at(10))
        assert importable_files.load_importable_files(db, the_course(), row) == {POSES: b"one"}


def test_a_file_that_imports_earlier_functions_is_graded_anew_each_time(database: Database) -> None:
    ada = new_account(database, name="ada")
    for code in ("x = 1\n", ASKS.decode()):
        sent(database, ada, GRAPH, code.encode(), 1, digest=digest_code(code))
    with database.read() as db:
        found = [service.find_duplicate(db, ada, GRAPH, code, "v") is not None for code in ("x = 1\n", ASKS.decode())]
    assert found == [True, False]
