"""Marks are made of what the database holds now, whatever was kept of an earlier look."""

from __future__ import annotations

from datetime import timedelta

from sqlalchemy import delete, select, update

from server.assignments.models import Assignment, Counts, Late
from server.classes.models import SchoolClass
from server.course import Course
from server.database import Database, utc_now
from server.gradebook.models import Grading
from server.identity.models import Role
from server.marks.loading import load_gradebook
from server.marks.models import Override
from server.marks.schemas import AssignmentMark, Gradebook
from server.submissions.models import Submission
from tests.support.classes import assign, new_class
from tests.support.crowd import Sent, seated, store
from tests.support.kept import forget
from tests.support.service import EXERCISE, new_account

OTHER = "l20/kabsch"
NOW = utc_now()
DAY = timedelta(days=1)


def read(database: Database, course: Course, made: SchoolClass) -> Gradebook:
    with database.read() as db:
        school_class = db.get(SchoolClass, made.id)
        assert school_class is not None
        return load_gradebook(db, course, school_class, NOW)


def marks(found: Gradebook) -> list[object]:
    return [(row.member.id, row.average, [(mark.points, mark.exercises) for mark in row.marks]) for row in found.rows]


def test_each_change_is_seen_at_the_next_look(database: Database, course: Course) -> None:
    made = new_class(database, new_account(database, Role.teacher))
    given = assign(database, made, EXERCISE, OTHER, opened=9 * DAY)
    ada, alan = seated(database, made, 2, NOW)
    store(database, [Sent(one, EXERCISE, NOW - 4 * DAY, 0.75) for one in (ada, alan)])
    store(database, [Sent(ada, EXERCISE, NOW - DAY, 0.5, code="x = 2\n")])

    def sent_more() -> None:
        store(database, [Sent(alan, OTHER, NOW - DAY, 1.0)])

    def graded_anew() -> None:
        with database.write() as db:
            of = select(Submission.id).where(Submission.account_id == alan, Submission.exercise == EXERCISE)
            db.execute(update(Grading).where(Grading.submission_id.in_(of)).values(score=0.25))

    def due() -> None:
        with database.write() as db:
            values = {"due_at": NOW - 2 * DAY, "late": Late.penalty, "late_per_day": 2.0}
            db.execute(update(Assignment).where(Assignment.id == given.id).values(**values))

    def last_counts() -> None:
        with database.write() as db:
            db.execute(update(Assignment).where(Assignment.id == given.id).values(counts=Counts.last))

    def marked() -> None:
        with database.write() as db:
            row = {"class_id": made.id, "reason": "oral", "based_on": []}
            db.add(Override(account_id=ada, exercise=EXERCISE, points=18.0, **row))

    def purged() -> None:
        with database.write() as db:
            db.execute(delete(Submission).where(Submission.account_id == alan))

    before = marks(read(database, course, made))
    for change in (sent_more, graded_anew, due, last_counts, marked, purged):
        change()
        again = marks(read(database, course, made))
        forget()
        assert again == marks(read(database, course, made)), change.__name__
        assert again != before, change.__name__
        before = again


def test_what_is_the_same_is_not_reckoned_again(database: Database, course: Course) -> None:
    made = new_class(database, new_account(database, Role.teacher))
    assign(database, made, EXERCISE)
    ada, alan = seated(database, made, 2, NOW)
    store(database, [Sent(one, EXERCISE, NOW - DAY, 0.5) for one in (ada, alan)])

    def kept() -> dict[object, AssignmentMark]:
        return {row.member.id: row.marks[0] for row in read(database, course, made).rows}

    first = kept()
    store(database, [Sent(ada, EXERCISE, NOW - timedelta(hours=1), 0.75)])
    second = kept()
    assert second[alan].exercises[0] is first[alan].exercises[0]
    assert second[alan] is first[alan]
    assert second[ada].exercises[0] != first[ada].exercises[0]
