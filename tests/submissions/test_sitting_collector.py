"""The end of a test at the same instant as everything else, in several threads and on both databases."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta
from threading import Barrier

from sqlalchemy import select

from server.assignments import sittings
from server.assignments.models import Mode, SavedWork, Sitting
from server.base.errors import Conflict
from server.course import Course
from server.database import Database, utc_now
from server.identity.models import Account, Role
from server.submissions.models import Submission
from server.submissions.service import SubmissionService
from server.submissions.sitting_collector import SittingCollector
from tests.support.classes import assign, new_class, seat
from tests.support.service import ADDRESS, EXERCISE, new_account


def test_submissions_racing_with_the_end_come_before_it_or_are_refused(
    database: Database, store: SubmissionService, course: Course, ada: Account
) -> None:
    made = new_class(database, new_account(database, Role.teacher))
    seat(database, made, ada)
    collecting = SittingCollector(course, store)
    for round_ in range(2):
        test = assign(database, made, EXERCISE, mode=Mode.test, duration_minutes=60)
        with database.write() as db:
            sittings.begin_sitting(db, test, ada.id, (), utc_now())

        def saves(number: int, round_: int = round_) -> Callable[[Database], None]:
            def save() -> None:
                with database.write() as db:
                    store.save_work(db, ada, EXERCISE, f"sauve = {round_}{number}".encode())

            return lambda _: save()

        def sends(number: int, round_: int = round_) -> Callable[[Database], None]:
            def send() -> None:
                with database.write() as db:
                    store.submit(db, ada, EXERCISE, f"envoye = {round_}{number}", address=ADDRESS)

            return lambda _: send()

        def ends(_: Database, test: object = test) -> None:
            with database.write() as db:
                collecting.hand_in(db, test, ada.id, utc_now())  # type: ignore[arg-type]

        doing = [saves(0), saves(1), sends(0), ends, ends, sends(1)]
        start = Barrier(len(doing))

        def at_once(one: Callable[[Database], None], start: Barrier = start) -> bool:
            start.wait(300)
            try:
                one(database)
            except Conflict:
                return False
            return True

        with ThreadPoolExecutor(len(doing)) as threads:
            done = list(threads.map(at_once, doing))
        assert done[3:5] == [True, True], "who hands in twice is not told off"
        with database.read() as db:
            sitting = db.get(Sitting, (test.id, ada.id))
            saved = db.get(SavedWork, (test.id, ada.id, EXERCISE))
            query = select(Submission).where(Submission.created_at >= test.opens_at + timedelta(hours=1))
            sent = [
                one for one in db.execute(query.order_by(Submission.created_at)).scalars() if f"= {round_}" in one.code
            ]
        assert sitting
        assert sitting.handed_in_at
        assert all(one.created_at <= sitting.handed_in_at for one in sent)
        assert len({one.code for one in sent}) == len(sent)
        assert sum(one.code.startswith("envoye") for one in sent) == done[2] + done[5]
        if saved is not None:
            assert sent
            assert saved.saved_at <= sitting.handed_in_at
            assert sent[-1].source == saved.source or sent[-1].created_at >= saved.saved_at
        assert (saved is not None) == (done[0] or done[1])
        with database.write() as db:
            test.released_at = utc_now()
            db.merge(test)


def test_one_of_several_collectors_submits_the_saved_work(
    database: Database, store: SubmissionService, course: Course, ada: Account
) -> None:
    made = new_class(database, new_account(database, Role.teacher))
    seat(database, made, ada)
    test = assign(database, made, EXERCISE, mode=Mode.test, duration_minutes=60)
    with database.write() as db:
        sittings.begin_sitting(db, test, ada.id, (), utc_now())
        store.save_work(db, ada, EXERCISE, b"sauve = 1")
    later = utc_now() + timedelta(hours=2)
    with ThreadPoolExecutor(4) as threads:
        counts = list(
            threads.map(lambda _: SittingCollector(course, store).end_expired_sittings(database, later), range(4))
        )
    assert sorted(counts) == [0, 0, 0, 1]
    with database.read() as db:
        (sent,) = db.execute(select(Submission)).scalars()
    assert sent.code == "sauve = 1"
