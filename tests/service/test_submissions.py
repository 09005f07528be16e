"""Sending files, and what one's attempts open."""

from __future__ import annotations

from uuid import uuid4

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.base.errors import Invalid, NotFound, TooLarge, TooMany
from server.base.settings import Settings
from server.database import Database
from server.grading.worker import Worker
from server.identity.models import Account, Role
from server.submissions import service
from server.submissions.models import Submission

from .conftest import EXERCISE, fake_grade, new_account

STARTER = "def composer(a, b):\n    return a\n"


def submit(database: Database, account: Account, code: str = "x = 1\n") -> Submission:
    with database.write() as db:
        return service.submit(db, account, EXERCISE, code)


def grade_all(database: Database, settings: Settings) -> None:
    worker = Worker(database, settings, fake_grade)
    while worker.step():
        pass


def test_a_submission_is_kept_byte_for_byte(database: Database, ada: Account) -> None:
    code = "\ufeffé = 1\r\n\tprint('\x00 😀')"
    row = submit(database, ada, code)
    with database.read() as db:
        found = service.get_for(db, ada, str(row.id))
        assert found.source == code.encode()
        assert found.code == code.removeprefix("\ufeff")
        assert (found.state, found.verdict, found.attempts) == ("queued", None, 0)
        assert 0 <= found.seed < 2**53


def test_code_is_bounded_in_bytes(database: Database, ada: Account, both: Settings) -> None:
    submit(database, ada, "é" * (both.code_bytes // 2))
    with pytest.raises(TooLarge, match=r"dépasse de 1.octet la limite de 64.Kio"):
        submit(database, ada, "é" * (both.code_bytes // 2) + "x")


def test_what_is_not_unicode_is_refused(database: Database, ada: Account) -> None:
    with pytest.raises(Invalid):
        submit(database, ada, "x = '\ud800'")


def test_sending_too_fast_is_refused_and_stores_nothing(database: Database, ada: Account, both: Settings) -> None:
    for _ in range(both.submission_burst):
        submit(database, ada)
    with pytest.raises(TooMany) as refused:
        submit(database, ada)
    assert 1 <= refused.value.retry_after <= both.submission_refill_seconds
    with database.read() as db:
        assert len(service.attempts(db, ada, EXERCISE)) == both.submission_burst
    submit(database, new_account(database))


def test_our_error_gives_the_allowance_back(database: Database, ada: Account, both: Settings) -> None:
    for k in range(both.submission_burst):
        submit(database, ada, f"# {k}, outcome: {'internal_error' if k < 2 else 'ok'}")
    with pytest.raises(TooMany):
        submit(database, ada)
    grade_all(database, both)
    for _ in range(2):
        submit(database, ada)
    with pytest.raises(TooMany):
        submit(database, ada)


def test_a_submission_is_seen_by_its_author_and_by_teachers(database: Database, ada: Account) -> None:
    row = submit(database, ada)
    teacher, other = new_account(database, Role.teacher), new_account(database)
    with database.read() as db:
        assert service.get_for(db, teacher, row.id).id == row.id
        for account, wanted in [(other, row.id), (None, row.id), (ada, uuid4()), (ada, "not-an-id")]:
            with pytest.raises(NotFound):
                service.get_for(db, account, wanted)


def test_progress_counts_the_best_and_never_our_errors(database: Database, ada: Account, both: Settings) -> None:
    submit(database, ada, "# outcome: wrong_answer")
    submit(database, ada, "# outcome: internal_error")
    grade_all(database, both)
    with database.read() as db:
        assert service.progress(db, ada) == {EXERCISE: service.Progress(0.5, 1)}
    submit(database, ada, "right")
    grade_all(database, both)
    with database.read() as db:
        mine = service.progress(db, ada)[EXERCISE]
        assert (mine.best, mine.attempts, mine.succeeded) == (1.0, 2, True)
        assert service.progress(db, new_account(database)) == service.progress(db, None) == {}


def test_only_changed_failed_attempts_open_hints(database: Database, ada: Account, both: Settings) -> None:
    tag = "'outcome: wrong_answer'\n"
    for code in (STARTER + tag, tag + "x = 1", tag + "\n# a remark\nx = 1   \n", "y = 1", "'outcome: internal_error'"):
        submit(database, ada, code)
    with database.read() as db:
        assert service.distinct_failed_attempts(db, ada, EXERCISE) == 0, "nothing is graded yet"
    grade_all(database, both)
    with database.read() as db:
        assert service.distinct_failed_attempts(db, ada, EXERCISE) == 2
        assert service.distinct_failed_attempts(db, ada, EXERCISE, besides=[STARTER + tag]) == 1
        assert service.distinct_failed_attempts(db, None, EXERCISE) == 0


def test_the_solution_opens_after_success_or_by_a_teacher(database: Database, ada: Account, both: Settings) -> None:
    bob, teacher = new_account(database), new_account(database, Role.teacher)
    submit(database, ada, "right")
    submit(database, bob, "# outcome: wrong_answer")
    grade_all(database, both)

    def open_to() -> list[bool]:
        with database.read() as db:
            return [service.solution_open(db, one, EXERCISE) for one in (ada, bob, teacher, None)]

    assert open_to() == [True, False, True, False]
    for _ in range(2):
        with database.write() as db:
            service.open_solution(db, EXERCISE, teacher)
    assert open_to() == [True, True, True, True]
    with database.write() as db:
        service.close_solution(db, EXERCISE)
    assert open_to() == [True, False, True, False]


def test_attempts_come_newest_first(database: Database, ada: Account) -> None:
    rows = [submit(database, ada) for _ in range(3)]
    with database.read() as db:
        assert [one.id for one in service.attempts(db, ada, EXERCISE)] == [one.id for one in reversed(rows)]
        assert service.attempts(db, None, EXERCISE) == []


@given(st.text(), st.integers(0, 3), st.sampled_from(["", "# note", "   # note", "\t"]))
def test_blank_lines_and_whole_line_comments_never_count(code: str, spaces: int, line: str) -> None:
    changed = "\n".join(one + " " * spaces for one in code.splitlines()) + f"\n{line}\n"
    assert service.digest(changed) == service.digest(code)


def test_indentation_and_content_count() -> None:
    digests = {service.digest(code) for code in ("x = 1", "x = 2", "  x = 1", "x = 1 # note", "")}
    assert len(digests) == 5
