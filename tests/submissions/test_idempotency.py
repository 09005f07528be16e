"""A sending that was cut off, and is made again under its name: it is stored once, whoever was first."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from sqlalchemy import func, select

from server.base.errors import Invalid
from server.base.settings import Settings
from server.database import Database
from server.identity.models import Account
from server.submissions.models import Submission
from server.submissions.service import SubmissionService
from tests.support.service import ADDRESS, EXERCISE, QUIET, Site, new_account

KEY, SEVERAL = "un envoi", 4


def stored(database: Database) -> int:
    with database.read() as db:
        return db.execute(select(func.count()).select_from(Submission)).scalar_one()


def test_one_of_several_concurrent_submissions_is_stored(database: Database, both: Settings, ada: Account) -> None:
    """The first is slow to commit: the others have looked for it before it was there."""
    store = SubmissionService(both.model_copy(update={"submission_burst": 2}), QUIET)

    def send(_number: int) -> str:
        with database.write() as db:
            sent = store.submit(db, ada, EXERCISE, "x = 1\n", address=ADDRESS, key=KEY)
            time.sleep(0.05)
            return str(sent.id)

    with ThreadPoolExecutor(SEVERAL) as threads:
        told = set(threads.map(send, range(SEVERAL)))
    assert (len(told), stored(database)) == (1, 1)
    with database.write() as db:
        store.submit(db, ada, EXERCISE, "x = 1\n", address=ADDRESS)  # the others have cost nothing


def test_a_name_is_its_account_s_own(database: Database, store: SubmissionService, ada: Account) -> None:
    other = new_account(database)
    with database.write() as db:
        one, its = (store.submit(db, who, EXERCISE, "x = 1\n", address=ADDRESS, key=KEY) for who in (ada, other))
        assert (one.id != its.id, one.account_id, its.account_id) == (True, ada.id, other.id)


@pytest.mark.parametrize(("exercise", "code"), [(EXERCISE, "x = 2\n"), ("l20/lidar", "x = 1\n")])
def test_a_name_that_has_served_for_something_else_is_refused(
    sqlite: Database, settings: Settings, exercise: str, code: str
) -> None:
    store, account = SubmissionService(settings, QUIET), new_account(sqlite)
    with sqlite.write() as db:
        store.submit(db, account, EXERCISE, "x = 1\n", address=ADDRESS, key=KEY)
    with pytest.raises(Invalid, match="Idempotency-Key"), sqlite.write() as db:
        store.submit(db, account, exercise, code, address=ADDRESS, key=KEY)


def test_over_http_it_is_the_same_submission_even_graded_or_beyond_the_limit(site: Site) -> None:
    site.tighten(submission_burst=1, submission_refill_seconds=3600)
    headers = {**site.token(), "Idempotency-Key": KEY}
    body = {"exercise": EXERCISE, "code": "x = 1\n"}

    def send(wait: float = 0, **others: str) -> tuple[int, str, str]:
        answer = site.client.post(f"/api/v1/submissions?wait={wait}", json={**body, **others}, headers=headers)
        told = answer.json()
        return answer.status_code, told.get("id", ""), str(told.get("status"))

    (first, name, _), again = send(), send()
    assert (first, again) == (202, (202, name, "queued"))
    site.worker.run_one()
    assert send() == (200, name, "done")
    began = time.monotonic()
    assert send(wait=30) == (200, name, "done")
    assert time.monotonic() - began < 29, "its end has come: nothing is waited for"
    assert send(code="x = 2\n")[0] == 422
    answers = {"exercise": "l20/calcul_odometrie", "answers": {"ds": 1}}
    unnamed = site.client.post("/api/v1/submissions", json=answers, headers=site.token())
    assert unnamed.status_code == 202
    named = {**site.token(), "Idempotency-Key": KEY}
    sent = {site.client.post("/api/v1/submissions", json=answers, headers=named).json()["id"] for _ in range(2)}
    assert len(sent) == 1
