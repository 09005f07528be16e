"""A board cached by its version equals a fresh one after every kind of change."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import replace
from datetime import timedelta

from sqlalchemy import delete, select, update
from sqlalchemy.orm import Session

from server.board import repository, service
from server.board.insights import activity_slot_start
from server.board.schemas import Board, BoardStatistics
from server.board.service import BoardInputs
from server.classes.models import Membership, SchoolClass, Status
from server.course import Course
from server.database import Database, utc_now
from server.gradebook.models import Grading
from server.identity.models import Role
from server.marks.models import Override
from server.submissions.models import Submission
from tests.support.caches import clear_caches
from tests.support.classes import assign, new_class, seat
from tests.support.crowd import Sent, lessons, seated, store
from tests.support.service import EXERCISE, new_account

OTHER, LATER = "l20/kabsch", "l20/predire2d"
WRONG = "rotation_oubliee"
NOW = utc_now() + timedelta(minutes=1)


#: Boards and insights by version, as fragments of pages are cached.
CACHE: dict[Hashable, Board | BoardStatistics] = {}


def load(db: Session, course: Course, made: SchoolClass) -> BoardInputs:
    school_class = db.get(SchoolClass, made.id)
    assert school_class is not None
    return service.load_board_inputs(db, course, school_class, NOW)


def read(database: Database, course: Course, made: SchoolClass) -> tuple[Board, BoardStatistics]:
    with database.read() as db:
        inputs = load(db, course, made)
        groups = tuple(service.load_unnamed_behaviour_groups(db, inputs.progress))
        side_key = (inputs.progress.version, groups, activity_slot_start(inputs.progress.now))
        if inputs.version not in CACHE:
            CACHE[inputs.version] = inputs.board
        if side_key not in CACHE:
            CACHE[side_key] = service.build_board_statistics(inputs.progress, groups)
        board, insights = CACHE[inputs.version], CACHE[side_key]
        assert isinstance(board, Board)
        assert isinstance(insights, BoardStatistics)
        return board, insights


def test_every_change_is_shown_at_once(database: Database, course: Course) -> None:
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
        CACHE.clear()
        clear_caches()
        assert again == read(database, course, made), change.__name__
        assert again[0].version != before[0].version, change.__name__
        before = again


def test_version_and_attempts_stay_until_something_changes(database: Database, course: Course) -> None:
    made = new_class(database, new_account(database, Role.teacher))
    students = seated(database, made, 3)
    store(database, [Sent(one, EXERCISE, NOW - timedelta(hours=1), 0.5, WRONG) for one in students])

    def inputs(course: Course) -> BoardInputs:
        with database.read() as db:
            return load(db, course, made)

    first = inputs(course)
    assert inputs(course).version == first.version
    assert inputs(replace(course)).version != first.version, "another edition of the course"
    store(database, [Sent(students[0], EXERCISE, NOW, 1.0)])
    second = inputs(course)
    assert second.version != first.version
    before, after = first.progress.attempts, second.progress.attempts
    assert [after[one, EXERCISE] is before[one, EXERCISE] for one in students] == [False, True, True]


def test_columns_of_attempts_are_read_with_their_types(database: Database, course: Course) -> None:
    made = new_class(database, new_account(database, Role.teacher))
    (ada,) = seated(database, made, 1)
    (submission,) = store(database, [Sent(ada, EXERCISE, NOW, 0.5, WRONG, "x = 2\n")])
    with database.read() as db:
        ((attempt,),) = load(db, course, made).progress.attempts.values()
    assert (attempt.account_id, attempt.exercise, attempt.sent_at, attempt.id) == (ada, EXERCISE, NOW, submission)
    assert (attempt.outcome, attempt.score, attempt.diagnosis) == ("wrong_answer", 0.5, WRONG)


def test_the_pulse_changes_whenever_the_board_may_change(database: Database, course: Course) -> None:
    made = new_class(database, new_account(database, Role.teacher))
    ada, alan = seated(database, made, 2)
    (submission,) = store(database, [Sent(ada, EXERCISE, NOW, 0.5, WRONG)])
    guest = new_account(database)

    def pulse() -> str:
        with database.read() as db:
            return str(repository.load_class_version_tag(db, made.id))

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
