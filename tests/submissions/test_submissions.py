"""Sending files, and what one's attempts open."""

from __future__ import annotations

from collections.abc import AsyncIterator
from dataclasses import dataclass
from uuid import UUID, uuid4

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sqlalchemy import update
from sqlalchemy.orm import Session

from server.base.errors import Forbidden, Invalid, NotFound, RateLimited, StorageFull, TooLarge
from server.base.files import MIN_FREE_BYTES
from server.base.settings import Settings
from server.classes import service as classes
from server.classes.models import Status
from server.database import Database, utc_now
from server.gradebook import service as gradebook
from server.gradebook import solutions
from server.gradebook.schemas import NOTHING_YET, ExerciseProgress
from server.identity.models import Account, Role
from server.limits import service as limits
from server.limits.models import TokenBucket
from server.submissions import service
from server.submissions.job_events import stream_sse
from server.submissions.models import Submission, SubmissionState
from server.submissions.service import VERDICT_KIB, GradingProgress, SubmissionService
from tests.support.classes import new_class, seat
from tests.support.quick import in_a_loop
from tests.support.service import ADDRESS, EXERCISE, QUIET, new_account, worker_of

STARTER = "def composer(a, b):\n    return a\n"


@dataclass(frozen=True)
class Desk:
    """Where files are sent, and graded by hand."""

    database: Database
    settings: Settings
    store: SubmissionService

    def submit(self, account: Account, code: str = "x = 1\n") -> Submission:
        with self.database.write() as db:
            return self.store.submit(db, account, EXERCISE, code, address=ADDRESS)

    def grade_all(self) -> None:
        worker = worker_of(self.database, self.settings)
        while worker.run_one():
            pass


@pytest.fixture
def settings(settings: Settings) -> Settings:
    """No allowance comes back while a test runs, however slow the machine."""
    return settings.model_copy(update={"submission_refill_seconds": 3600.0})


@pytest.fixture
def desk(database: Database, both: Settings, store: SubmissionService) -> Desk:
    return Desk(database, both, store)


def test_a_submission_is_kept_byte_for_byte(desk: Desk, ada: Account) -> None:
    code = "\ufeffé = 1\r\n\tprint('\x00 😀')"
    row = desk.submit(ada, code)
    with desk.database.read() as db:
        attempt = gradebook.find_attempt(db, ada, str(row.id))
        sent = attempt.submission
        assert sent.source == code.encode()
        assert sent.code == code.removeprefix("\ufeff")
        assert (desk.store.progress(db, sent), attempt.grading) == (GradingProgress(SubmissionState.queued, 1), None)
        assert 0 <= sent.seed < 2**53


def test_code_is_bounded_in_bytes(desk: Desk, ada: Account) -> None:
    desk.submit(ada, "é" * (desk.settings.code_bytes // 2))
    with pytest.raises(TooLarge, match=r"dépasse de 1.octet la limite de 64.Kio"):
        desk.submit(ada, "é" * (desk.settings.code_bytes // 2) + "x")


def test_invalid_unicode_is_refused(desk: Desk, ada: Account) -> None:
    with pytest.raises(Invalid):
        desk.submit(ada, "x = '\ud800'")


def test_sending_too_fast_is_refused_and_stores_nothing(desk: Desk, ada: Account) -> None:
    for _ in range(desk.settings.submission_burst):
        desk.submit(ada)
    with pytest.raises(RateLimited) as refused:
        desk.submit(ada)
    assert 1 <= refused.value.retry_after <= desk.settings.submission_refill_seconds
    with desk.database.read() as db:
        assert gradebook.list_attempts(db, ada, EXERCISE, 1).total == desk.settings.submission_burst
    desk.submit(new_account(desk.database))


def test_our_error_gives_the_allowance_back(desk: Desk, ada: Account) -> None:
    for k in range(desk.settings.submission_burst):
        desk.submit(ada, f"# {k}, outcome: {'internal_error' if k < 2 else 'ok'}")
    with pytest.raises(RateLimited):
        desk.submit(ada)
    desk.grade_all()
    for _ in range(2):
        desk.submit(ada)
    with pytest.raises(RateLimited):
        desk.submit(ada)


def test_what_an_account_stores_is_bounded(desk: Desk, ada: Account) -> None:
    """Three short files, or two long ones; whoever is in no class shares what is left at their address."""
    short = VERDICT_KIB + 1
    settings = desk.settings.model_copy(update={"storage_burst": 3 * short, "storage_refill_seconds": 3600.0})
    bounded = Desk(desk.database, settings, SubmissionService(settings, QUIET))
    for _ in range(3):
        bounded.submit(ada)
    with pytest.raises(RateLimited, match="place réservée à vos propositions") as refused:
        bounded.submit(ada)
    assert refused.value.retry_after == short * 3600
    with desk.database.read() as db:
        assert gradebook.list_attempts(db, ada, EXERCISE, 1).total == 3
    bounded.submit(long_writer := new_account(desk.database), "#" * 64 * 1024)
    with pytest.raises(RateLimited):
        bounded.submit(long_writer)

    pupil = new_account(desk.database)
    seat(desk.database, new_class(desk.database, new_account(desk.database, Role.teacher)), pupil)
    with desk.database.write() as db:
        key = f"storage-from:{ADDRESS}"
        db.execute(update(TokenBucket).where(TokenBucket.key == key).values(tokens=short * 1.5, updated_at=utc_now()))
    bounded.submit(new_account(desk.database))
    with pytest.raises(RateLimited, match="aucune classe"):
        bounded.submit(new_account(desk.database))
    bounded.submit(pupil)


def test_the_last_room_on_the_disk_is_for_classes(desk: Desk, ada: Account, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(service, "free_bytes", lambda _folder: MIN_FREE_BYTES + 1)
    with pytest.raises(StorageFull, match="gardé aux élèves des classes"):
        desk.submit(ada)
    seat(desk.database, new_class(desk.database, new_account(desk.database, Role.teacher)), ada)
    desk.submit(ada)


def test_a_class_is_graded_before_other_accounts(desk: Desk, ada: Account) -> None:
    """Who only asks to join, has left, or is in a class of last year, is in none."""
    teacher = new_account(desk.database, Role.teacher)
    made, old = new_class(desk.database, teacher, "MPSI"), new_class(desk.database, teacher, "de l’an dernier")
    asking, pupil, former = (new_account(desk.database) for _ in range(3))
    seat(desk.database, made, pupil)
    seat(desk.database, made, asking, status=Status.pending)
    seat(desk.database, old, former)
    with desk.database.write() as db:
        classes.archive_class(db.merge(old))
    for one in (ada, asking, former, pupil):
        row = desk.submit(one)
    with desk.database.read() as db:
        assert desk.store.progress(db, row) == GradingProgress(SubmissionState.queued, 1)


def test_a_submission_is_seen_by_its_author_their_teacher_and_the_administrator(desk: Desk, ada: Account) -> None:
    row = desk.submit(ada)
    teacher, stranger = new_account(desk.database, Role.teacher), new_account(desk.database, Role.teacher)
    seat(desk.database, new_class(desk.database, teacher), ada)
    new_class(desk.database, stranger)
    other, administrator = new_account(desk.database), new_account(desk.database, Role.administrator)
    with desk.database.read() as db:
        for account in (ada, teacher, administrator):
            assert gradebook.find_attempt(db, account, row.id).submission.id == row.id
        for account, wanted in [
            (other, row.id),
            (stranger, row.id),
            (None, row.id),
            (ada, uuid4()),
            (ada, "not-an-id"),
        ]:
            with pytest.raises(NotFound):
                gradebook.find_attempt(db, account, wanted)


def test_progress_counts_the_best_and_never_our_errors(desk: Desk, ada: Account) -> None:
    desk.submit(ada, "# outcome: wrong_answer")
    desk.submit(ada, "# outcome: internal_error")
    desk.grade_all()
    with desk.database.read() as db:
        assert gradebook.load_progress(db, ada) == {EXERCISE: ExerciseProgress(0.5, 1)}
    desk.submit(ada, "right")
    desk.grade_all()
    with desk.database.read() as db:
        mine = gradebook.load_progress(db, ada)[EXERCISE]
        assert (mine.best, mine.attempts, mine.succeeded) == (1.0, 2, True)
        assert gradebook.load_progress(db, new_account(desk.database)) == gradebook.load_progress(db, None) == {}


def test_only_changed_failed_attempts_open_hints(desk: Desk, ada: Account) -> None:
    tag = "'outcome: wrong_answer'\n"
    for code in (STARTER + tag, tag + "x = 1", tag + "\n# a remark\nx = 1   \n", "y = 1", "'outcome: internal_error'"):
        desk.submit(ada, code)
    with desk.database.read() as db:
        assert gradebook.count_distinct_failures(db, ada, EXERCISE) == 0, "nothing is graded yet"
    desk.grade_all()
    with desk.database.read() as db:
        assert gradebook.count_distinct_failures(db, ada, EXERCISE) == 2
        assert gradebook.count_distinct_failures(db, ada, EXERCISE, besides=STARTER + tag) == 1
        assert gradebook.count_distinct_failures(db, None, EXERCISE) == 0


def test_the_solution_opens_after_success_or_by_a_teacher(desk: Desk, ada: Account) -> None:
    bob, eve = new_account(desk.database), new_account(desk.database)
    teacher, administrator = new_account(desk.database, Role.teacher), new_account(desk.database, Role.administrator)
    made = new_class(desk.database, teacher)
    seat(desk.database, made, bob)
    seat(desk.database, made, eve, status=Status.pending)
    desk.submit(ada, "right")
    desk.submit(bob, "# outcome: wrong_answer")
    desk.grade_all()

    def open_to() -> list[bool]:
        with desk.database.read() as db:
            return [
                solutions.load_solution_access(db, account, EXERCISE).access_reason(progress_of(db, account))
                is not None
                for account in (ada, bob, eve, teacher, None)
            ]

    def progress_of(db: Session, account: Account | None) -> ExerciseProgress:
        return gradebook.load_progress(db, account, EXERCISE).get(EXERCISE, NOTHING_YET)

    def turn(by: Account, class_id: UUID | None, wanted: bool) -> None:
        for _ in range(2):
            with desk.database.write() as db:
                solutions.set_solution_open(db, by, EXERCISE, class_id, is_open=wanted)

    closed = [True, False, False, True, False]
    assert open_to() == closed
    turn(teacher, made.id, True)
    assert open_to() == [True, True, False, True, False], "who asks to join is not in the class yet"
    turn(teacher, made.id, False)
    assert open_to() == closed
    with pytest.raises(Forbidden, match="ouvrir les corrigés à tous"):
        turn(teacher, None, True)
    turn(administrator, None, True)
    assert open_to() == [True] * 5
    turn(administrator, None, False)
    assert open_to() == closed


def test_attempts_come_newest_first(desk: Desk, ada: Account) -> None:
    rows = [desk.submit(ada) for _ in range(3)]
    with desk.database.read() as db:
        listed = gradebook.list_attempts(db, ada, EXERCISE, 2)
        assert [(line.id, line.number) for line in listed.lines] == [(rows[2].id, 3), (rows[1].id, 2)]
        assert listed.total == 3
        older = gradebook.list_attempts(db, ada, EXERCISE, 2, offset=2)
        assert [(line.id, line.number) for line in older.lines] == [(rows[0].id, 1)]
        assert [gradebook.attempt_number(db, row) for row in rows] == [1, 2, 3]
        assert gradebook.list_attempts(db, None, EXERCISE, 2).total == 0


def test_a_guest_whose_address_has_its_heap_learns_that_accounts_come_first(desk: Desk, ada: Account) -> None:
    store = SubmissionService(desk.settings.model_copy(update={"waiting_from_address": 1}), QUIET)
    one, two = (new_account(desk.database, Role.guest) for _ in range(2))

    def send(account: Account, address: str = ADDRESS) -> None:
        with desk.database.write() as db:
            store.submit(db, account, EXERCISE, "x = 1\n", address=address)

    send(one)
    with pytest.raises(RateLimited, match=r"depuis votre adresse.*Ceux qui ont un compte passent avant") as refused:
        send(two)
    assert refused.value.retry_after >= 1
    with desk.database.read() as db:
        assert gradebook.list_attempts(db, two, EXERCISE, 1).total == 0
        assert db.get(TokenBucket, limits.submission_bucket_key(two.id)) is None, "a refusal costs nothing"
    send(two, "198.51.100.7")
    send(ada)


@given(st.text(), st.integers(0, 3), st.sampled_from(["", "# note", "   # note", "\t"]))
def test_blank_lines_and_whole_line_comments_never_count(code: str, spaces: int, line: str) -> None:
    changed = "\n".join(one + " " * spaces for one in code.splitlines()) + f"\n{line}\n"
    assert service.digest_code(changed) == service.digest_code(code)


def test_indentation_and_content_count() -> None:
    digests = {service.digest_code(code) for code in ("x = 1", "x = 2", "  x = 1", "x = 1 # note", "")}
    assert len(digests) == 5


def test_an_event_s_line_ends_only_where_its_reader_ends_it() -> None:
    async def told(text: str) -> list[str]:
        async def once() -> AsyncIterator[str]:
            yield text

        return [event async for event in stream_sse(once(), str)]

    assert in_a_loop(told("a\u2028b\x85c\x0bd\ne\r\nf")) == [
        "event: status\ndata: a\u2028b\x85c\x0bd\ndata: e\ndata: f\n\n"
    ]
