"""A film of a simulated lesson: the teacher’s « Séance » at several minutes, then « Après la séance », in pictures.

`LESSON_FILM=DIR pytest -m slow tests/contract/browser/test_lesson_film.py` leaves the pictures in that folder. Whoever
looks at them should say within five seconds whom to help, and on what. No words are cut or stand on others.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from datetime import datetime, timedelta
from functools import cache
from pathlib import Path
from uuid import UUID

import pytest
from sqlalchemy import delete, update

from graders.core.contract.verdict import Verdict
from server.classes.models import Membership, SchoolClass
from server.database import Database, utc_now
from server.demo.people import FAMILY, GIVEN
from server.gradebook.models import Standing
from server.grading.sandbox_grader import SandboxGrader
from server.identity.models import Account, Role
from server.lesson import repository
from server.lesson.models import Afterwards, LessonVisit, LiveLesson
from server.sandbox import Sandbox
from server.submissions.models import Submission
from tests.contract.browser.conftest import NewVisit, Visit, enters
from tests.support.classes import new_class, seat
from tests.support.crowd import Sent, store
from tests.support.layout import find_layout_faults
from tests.support.quick import the_course
from tests.support.served import Server
from tests.support.service import new_account
from tests.support.stuck_class import EXERCISES, START, Pupil, SimulatedClass, simulate_class
from tests.support.stuck_programs import LessonPrograms

DAY = ("l20/poses", "l20/kabsch", "l20/predire2d", "l20/association")
MINUTES = (5, 15, 25, 35, 50, 70)
STUDENTS, SEED = 24, 3
#: Minutes at which the teacher has just seen the student who has been stuck longest, and how long before.
ROUNDS, SEEN_BEFORE = (25, 50), 4
SCREENS = {"portable": (1280, 800), "bureau": (1024, 768), "telephone": (390, 844)}
WHOLE_CARDS = {"portable": 4, "bureau": 4, "telephone": 3}
Grade = Callable[[str, bytes], Verdict]
CARD_ENDS = "() => [...document.querySelectorAll('.stuck-row')].map((row) => row.getBoundingClientRect().bottom)"


@pytest.mark.slow
def test_a_film_of_a_lesson_names_whom_to_help(
    visit: NewVisit, server: Server, course_sandbox: Sandbox, tmp_path: Path
) -> None:
    folder = Path(os.environ.get("LESSON_FILM") or tmp_path)
    folder.mkdir(parents=True, exist_ok=True)
    database, lesson = server.open_database(), simulate_class(seed=SEED, size=STUDENTS)
    teacher = new_account(database, Role.teacher, "Mme Martin")
    made = new_class(database, teacher)
    accounts = _seat_pupils(database, made, lesson)
    names = {account.id: account.name for account in accounts.values()}
    row = LiveLesson(class_id=made.id, exercises=list(DAY), next_step=Afterwards.help, started_at=utc_now())
    with database.write() as db:
        db.add(row)
    programs = {name: LessonPrograms(the_course().exercises[name], seed=SEED) for name in DAY}
    grader = SandboxGrader(the_course(), course_sandbox)
    grade = cache(lambda exercise, code: grader.grade(exercise, code, 1).verdict)
    visitor = enters(visit(at=server, timezone_id="Europe/Paris"), database, teacher)
    named, faults, truth = 0, [], []
    for minute in MINUTES:
        _go_to(database, made, lesson, accounts, row, minute, programs, grade, teacher)
        shown, cut = _take(visitor, folder / f"seance-{minute:02}", f"/classes/{made.id}/seance", WHOLE_CARDS)
        truly = {names[accounts[pupil].id] for pupil in lesson.stuck(minute)}
        truth += _tell_truth(lesson, minute, names, accounts)
        named += not truly or any(name in shown for name in truly)
        wall, cut_there = _take(
            visitor, folder / f"seance-{minute:02}-projecteur", f"/classes/{made.id}/seance/projeter"
        )
        assert not any(name in wall for name in names.values()), "the projector names nobody"
        faults += cut + cut_there
    visitor.page.goto("about:blank")  # the projector's page would leave by itself once the lesson ends
    with database.write() as db:
        db.execute(update(LiveLesson).where(LiveLesson.id == row.id).values(ended_at=utc_now()))
    faults += _take(visitor, folder / "apres-la-seance", f"/classes/{made.id}/seance/{row.id}")[1]
    database.close()
    assert named >= len(MINUTES) - 1, "in all pictures but one, somebody who is stuck is named"
    (folder / "fautes.txt").write_text("\n".join(map(str, faults)))
    (folder / "verite.txt").write_text("\n".join(truth))
    assert faults == []


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
    row: LiveLesson,
    minute: int,
    programs: Mapping[str, LessonPrograms],
    grade: Grade,
    teacher: Account,
) -> None:
    """Make the database that of this minute of the lesson, which is now."""
    begun = utc_now() - timedelta(minutes=minute)
    ids: Collection[UUID] = [account.id for account in accounts.values()]
    with database.write() as db:
        db.execute(update(LiveLesson).where(LiveLesson.id == row.id).values(started_at=begun))
        db.execute(delete(LessonVisit).where(LessonVisit.lesson_id == row.id))
        db.execute(delete(Standing).where(Standing.account_id.in_(ids)))
        db.execute(delete(Submission).where(Submission.account_id.in_(ids)))
        for pupil, seen in lesson.seen_at(minute).items():
            at = None if seen is None else _shifted(seen, begun)
            own = Membership.class_id == made.id, Membership.account_id == accounts[pupil].id
            db.execute(update(Membership).where(*own).values(last_seen_at=at))
    attempts = []
    for (pupil, simulated), series in lesson.attempts_at(minute).items():
        exercise = dict(zip(EXERCISES, DAY, strict=True)).get(simulated)
        for number, attempt in enumerate(series):
            at = _shifted(attempt.sent_at, begun)
            if exercise is None:
                attempts.append(Sent(accounts[pupil].id, "l20/demo_1", at, attempt.score))
                continue
            code, outcome, diagnosis = programs[exercise].write(attempt.diagnosis, attempt.score, number)
            sent = Sent(accounts[pupil].id, exercise, at, attempt.score, diagnosis, code.decode(), outcome)
            if diagnosis is None and attempt.score < 1.0:
                real = grade(exercise, code)
                sent = replace(sent, diagnosis=real.counted_misconception, outcome=real.outcome, checks=real.checks)
            attempts.append(sent)
    store(database, attempts)
    if minute in ROUNDS:
        stuck = [pupil for pupil in lesson.pupils if pupil.account in lesson.stuck(minute)]
        longest = min(stuck, key=lambda pupil: _stuck_since(pupil, minute))
        student = accounts[longest.account].id
        last = max((sent for sent in attempts if sent.account == student), key=lambda sent: sent.at)
        seen_at = utc_now() - timedelta(minutes=SEEN_BEFORE)
        with database.write() as db:
            repository.save_visit(db, row.id, student, last.exercise, seen_at, teacher.id)


def _tell_truth(
    lesson: SimulatedClass, minute: int, names: Mapping[UUID, str], accounts: Mapping[UUID, Account]
) -> list[str]:
    """Return who is truly stuck at that minute, since when, and at which exercise, the longest first."""
    lines = []
    stuck = [pupil for pupil in lesson.pupils if pupil.account in lesson.stuck(minute)]
    for pupil in sorted(stuck, key=lambda pupil: _stuck_since(pupil, minute)):
        own = [series[-1] for (account, _), series in lesson.attempts_at(minute).items() if account == pupil.account]
        last = max(own, key=lambda attempt: attempt.sent_at)
        exercise = dict(zip(EXERCISES, DAY, strict=True)).get(last.exercise, "")
        since, name = round(minute - _stuck_since(pupil, minute)), names[accounts[pupil.account].id]
        lines.append(f"{minute} min: {name}, {since} min, {exercise}, {last.diagnosis}, score {last.score:.2f}")
    return lines


def _stuck_since(pupil: Pupil, minute: float) -> float:
    """Return from which minute a pupil has been stuck who is so at this one."""
    return max(begin for begin, _ in pupil.stuck if begin <= minute)


def _shifted(at: datetime, begun: datetime) -> datetime:
    return begun + (at - START)


def _take(
    visitor: Visit, path: Path, address: str, whole_cards: Mapping[str, int] | None = None
) -> tuple[str, list[list[str]]]:
    """Take pictures of a page on each screen; return its text, and the words that are cut or stand on others."""
    page, faults, shown = visitor.page, [], ""
    for screen, (width, height) in SCREENS.items():
        page.set_viewport_size({"width": width, "height": height})
        page.goto(visitor.server.address + address)
        if page.locator("[data-live]").count():
            page.locator('[data-live][data-kind="live"]').wait_for()
        page.screenshot(path=f"{path}-{screen}.png")
        shown = shown or page.inner_text("main")
        faults += [[path.name, screen, *fault] for fault in find_layout_faults(page)]
        ends = page.evaluate(CARD_ENDS)[: whole_cards[screen]] if whole_cards else ()
        faults += [[path.name, screen, "card below the screen", str(end)] for end in ends if end > height]
        tab = page.locator('label[for="onglet-erreurs"]')
        if tab.is_visible():
            tab.click()
            page.screenshot(path=f"{path}-{screen}-erreurs.png")
            faults += [[path.name, screen, *fault] for fault in find_layout_faults(page)]
    return shown, faults
