"""What is kept of a class between two looks is never what it was: each look tells what a first one would."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from datetime import timedelta

from sqlalchemy import delete, select, update

from server.board import kept, repository, service
from server.board.repository import Scope
from server.board.schemas import Board, Insights
from server.classes.models import Membership, SchoolClass, Status
from server.course import Course
from server.database import Database, utc_now
from server.gradebook.models import Grading
from server.identity.models import Role
from server.marks.models import Override
from server.submissions.models import Submission
from tests.support.classes import assign, new_class, seat
from tests.support.crowd import Sent, lessons, seated, store
from tests.support.kept import forget
from tests.support.service import EXERCISE, new_account

OTHER, LATER = "l20/kabsch", "l20/predire2d"
WRONG = "rotation_oubliee"
NOW = utc_now() + timedelta(minutes=1)


def read(database: Database, course: Course, made: SchoolClass) -> tuple[Board, Insights]:
    with database.read() as db:
        school_class = db.get(SchoolClass, made.id)
        assert school_class is not None
        return service.load_dashboard(db, course, school_class, NOW)


def test_each_change_is_seen_at_the_next_look(database: Database, course: Course) -> None:
    made = new_class(database, new_account(database, Role.teacher))
    assign(database, made, EXERCISE, OTHER, opened=timedelta(days=3))
    students = seated(database, made, 6, NOW)
    store(database, lessons(students, [EXERCISE, OTHER], {EXERCISE: [WRONG], OTHER: ["a", "b"]}, NOW))
    newcomer = new_account(database)
    store(database, [Sent(newcomer.id, EXERCISE, NOW - timedelta(minutes=3), 0.25, WRONG)])
    minute = timedelta(minutes=1)

    def sent() -> None:
        store(database, [Sent(students[0], OTHER, NOW - place * minute, 0.0, code=f"{place}") for place in range(4)])

    def graded_anew() -> None:
        """As a regrade does: another grading counts, of as many points."""
        with database.write() as db:
            one = db.execute(select(Submission).where(Submission.account_id == students[1]).limit(1)).scalar_one()
            old = db.get(Grading, one.grading_id)
            assert old is not None
            columns = {
                name: getattr(old, name) for name in map(str, Grading.__mapper__.column_attrs.keys()) if name != "id"
            }
            new = Grading(**{**columns, "diagnosis": "c" if old.diagnosis != "c" else "d"})
            db.add(new)
            db.flush()
            db.execute(update(Submission).where(Submission.id == one.id).values(grading_id=new.id))

    def marked() -> None:
        with database.write() as db:
            row = {"class_id": made.id, "reason": "absente", "based_on": []}
            db.add(Override(account_id=students[2], exercise=OTHER, excused=True, **row))
            db.add(Override(account_id=students[3], exercise=EXERCISE, points=12.5, **row))

    def joined() -> None:
        seat(database, made, newcomer)

    def left() -> None:
        with database.write() as db:
            of = (Membership.class_id == made.id, Membership.account_id == students[4])
            db.execute(update(Membership).where(*of).values(status=Status.left, left_at=NOW))

    def renamed() -> None:
        with database.write() as db:
            of = (Membership.class_id == made.id, Membership.account_id == students[5])
            db.execute(update(Membership).where(*of).values(family_name="Aaron", groups=["G"]))

    def assigned() -> None:
        assign(database, made, LATER, opened=timedelta(days=1), title="Suite")

    def purged() -> None:
        with database.write() as db:
            db.execute(delete(Submission).where(Submission.account_id == students[0], Submission.exercise == OTHER))

    changes: list[Callable[[], None]] = [sent, graded_anew, marked, joined, left, renamed, assigned, purged]
    before = read(database, course, made)
    for change in changes:
        change()
        again = read(database, course, made)
        forget()
        assert again == read(database, course, made), change.__name__
        assert again[0].version != before[0].version, change.__name__
        before = again


def test_what_is_the_same_is_not_reckoned_again(database: Database, course: Course) -> None:
    made = new_class(database, new_account(database, Role.teacher))
    students = seated(database, made, 3)
    store(database, [Sent(one, EXERCISE, NOW - timedelta(hours=1), 0.5, WRONG) for one in students])

    def done() -> kept.Done:
        with database.read() as db:
            school_class = db.get(SchoolClass, made.id)
            assert school_class is not None
            return kept.done(db, course, service.load_scope(db, course, school_class, NOW), students)

    first = done()
    assert done() is first
    store(database, [Sent(students[0], EXERCISE, NOW, 1.0)])
    second = done()
    assert [second.trails[one, EXERCISE] is first.trails[one, EXERCISE] for one in students] == [False, True, True]
    with database.read() as db:
        school_class = db.get(SchoolClass, made.id)
        assert school_class is not None
        scope = service.load_scope(db, course, school_class, NOW)
        assert kept.done(db, replace(course), scope, students) is not second, "another edition of the course"
        assert kept.done(db, course, scope, students[:1]).students == (students[0],)


def test_what_a_database_tells_is_read_by_its_own_types(database: Database, course: Course) -> None:
    made = new_class(database, new_account(database, Role.teacher))
    (ada,) = seated(database, made, 1)
    (submission,) = store(database, [Sent(ada, EXERCISE, NOW, 0.5, WRONG, "x = 2\n")])
    with database.read() as db:
        (trail,) = kept.done(db, course, Scope(made.id, [EXERCISE], None), [ada]).trails.values()
    (sent,) = trail
    assert (sent.account, sent.exercise, sent.sent_at, sent.submission) == (ada, EXERCISE, NOW, submission)
    assert (sent.outcome, sent.score, sent.diagnosis) == ("wrong_answer", 0.5, WRONG)


def test_its_pulse_is_another_one_whenever_the_board_may_be(database: Database, course: Course) -> None:
    made = new_class(database, new_account(database, Role.teacher))
    ada, alan = seated(database, made, 2)
    (submission,) = store(database, [Sent(ada, EXERCISE, NOW, 0.5, WRONG)])
    guest = new_account(database)

    def pulse() -> str:
        with database.read() as db:
            return str(repository.pulse(db, made.id))

    def graded_anew() -> None:
        """Of as many points."""
        with database.write() as db:
            counting = update(Grading).where(Grading.submission_id == submission)
            db.execute(counting.values(diagnosis="another"))

    def left() -> None:
        with database.write() as db:
            db.execute(update(Membership).where(Membership.account_id == alan).values(status=Status.left))

    seen = [pulse()]
    for change in (
        graded_anew,
        left,
        lambda: seat(database, made, guest),
        lambda: store(database, [Sent(guest.id, OTHER, NOW, None)]),
        lambda: store(database, [Sent(guest.id, OTHER, NOW, 0.0)]),
    ):
        assert pulse() == seen[-1]
        change()
        seen.append(pulse())
    assert len(set(seen)) == 6
    store(database, [Sent(alan, EXERCISE, NOW, 1.0)])
    assert pulse() == seen[-1], "who has left is nobody there"
