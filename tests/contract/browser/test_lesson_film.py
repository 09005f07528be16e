"""A film of a simulated lesson: the teacher’s « Séance » at several minutes, then « Demain matin », in pictures.

`LESSON_FILM=DIR pytest -m slow tests/contract/browser/test_lesson_film.py` leaves the pictures in that folder. Whoever
looks at them should say within five seconds whom to help, and on what.
"""

from __future__ import annotations

import os
from collections.abc import Collection
from datetime import datetime, timedelta
from pathlib import Path
from uuid import UUID

import pytest
from sqlalchemy import delete, update

from server.classes.models import Membership, SchoolClass
from server.database import Database, utc_now
from server.demo.people import FAMILY, GIVEN
from server.gradebook.models import Standing
from server.identity.models import Account, Role
from server.lesson.models import Afterwards, LiveLesson
from server.submissions.models import Submission
from tests.contract.browser.conftest import NewVisit, Visit, enters
from tests.support.classes import new_class, seat
from tests.support.crowd import Sent, store
from tests.support.quick import the_course
from tests.support.served import Server
from tests.support.service import new_account
from tests.support.stuck_class import EXERCISES, START, SimulatedClass, simulate_class

DAY = ("l20/poses", "l20/kabsch", "l20/predire2d", "l20/association")
MINUTES = (5, 15, 25, 35, 50, 70)
STUDENTS = 24
DESK, PHONE = (1024, 768), (390, 844)
WHOLE_CARDS = 4
CARD_ENDS = "() => [...document.querySelectorAll('.stuck-row')].map((row) => row.getBoundingClientRect().bottom)"


@pytest.mark.slow
def test_a_film_of_a_lesson_names_whom_to_help(visit: NewVisit, server: Server, tmp_path: Path) -> None:
    folder = Path(os.environ.get("LESSON_FILM") or tmp_path)
    folder.mkdir(parents=True, exist_ok=True)
    database, lesson = server.open_database(), simulate_class(seed=11, size=STUDENTS)
    teacher = new_account(database, Role.teacher, "Mme Martin")
    made = new_class(database, teacher)
    accounts = _seat_pupils(database, made, lesson)
    names = {account.id: account.name for account in accounts.values()}
    row = LiveLesson(class_id=made.id, exercises=list(DAY), next_step=Afterwards.help, started_at=utc_now())
    with database.write() as db:
        db.add(row)
    visitor = enters(visit(at=server), database, teacher)
    named = 0
    for minute in MINUTES:
        _go_to(database, made, lesson, accounts, row.id, minute)
        shown = _take(visitor, folder / f"seance-{minute:02}", f"/classes/{made.id}/seance")
        visitor.page.set_viewport_size({"width": DESK[0], "height": DESK[1]})
        ends = visitor.page.evaluate(CARD_ENDS)
        assert all(end <= DESK[1] for end in ends[:WHOLE_CARDS]), "the first cards stand whole, without scrolling"
        truly = {names[accounts[pupil].id] for pupil in lesson.stuck(minute)}
        named += not truly or any(name in shown for name in truly)
        visitor.page.goto(f"{server.address}/classes/{made.id}/seance/projeter")
        visitor.page.screenshot(path=folder / f"seance-{minute:02}-projecteur.png")
        assert not any(name in visitor.page.content() for name in names.values()), "the projector names nobody"
    with database.write() as db:
        db.execute(update(LiveLesson).where(LiveLesson.id == row.id).values(ended_at=utc_now()))
    _take(visitor, folder / "demain-matin", f"/classes/{made.id}/seance/{row.id}")
    database.close()
    assert named >= len(MINUTES) - 1, "in all pictures but one, somebody who is stuck is named"


def _seat_pupils(database: Database, made: SchoolClass, lesson: SimulatedClass) -> dict[UUID, Account]:
    accounts = {}
    for place, pupil in enumerate(lesson.pupils):
        name = f"{GIVEN[place % len(GIVEN)]} {FAMILY[place * 7 % len(FAMILY)]}"
        accounts[pupil.account] = seat(database, made, new_account(database, name=name))
    return accounts


def _go_to(
    database: Database,
    made: SchoolClass,
    lesson: SimulatedClass,
    accounts: dict[UUID, Account],
    lesson_id: UUID,
    minute: int,
) -> None:
    """Make the database that of this minute of the lesson, which is now."""
    begun = utc_now() - timedelta(minutes=minute)
    ids: Collection[UUID] = [account.id for account in accounts.values()]
    with database.write() as db:
        db.execute(update(LiveLesson).where(LiveLesson.id == lesson_id).values(started_at=begun))
        db.execute(delete(Standing).where(Standing.account_id.in_(ids)))
        db.execute(delete(Submission).where(Submission.account_id.in_(ids)))
        for pupil, seen in lesson.seen_at(minute).items():
            at = None if seen is None else _shifted(seen, begun)
            own = Membership.class_id == made.id, Membership.account_id == accounts[pupil].id
            db.execute(update(Membership).where(*own).values(last_seen_at=at))
    course = the_course()
    exercises = dict(zip(EXERCISES, DAY, strict=True))
    mistakes = {name: sorted(course.exercises[name].grader.mistake_ids())[:2] for name in DAY}
    attempts = []
    for (pupil, simulated), series in lesson.attempts_at(minute).items():
        exercise = exercises.get(simulated, "l20/demo_1")
        for attempt in series:
            own = mistakes.get(exercise, ())
            diagnosis = own[("m1", "m2").index(attempt.diagnosis)] if attempt.diagnosis and own else None
            at = _shifted(attempt.sent_at, begun)
            code = f"def composer(a, b):\n    return a + {attempt.digest}\n"
            attempts.append(Sent(accounts[pupil].id, exercise, at, attempt.score, diagnosis, code))
    store(database, attempts)


def _shifted(at: datetime, begun: datetime) -> datetime:
    return begun + (at - START)


def _take(visitor: Visit, path: Path, address: str) -> str:
    """Take a picture at the desk and on a phone; return the text of the page."""
    page = visitor.page
    for name, (width, height) in (("bureau", DESK), ("telephone", PHONE)):
        page.set_viewport_size({"width": width, "height": height})
        page.goto(visitor.server.address + address)
        page.screenshot(path=f"{path}-{name}.png")
    return page.inner_text("main")
