"""A page cached by the version of the class equals a fresh one, after every kind of change and at every time."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from contextlib import closing
from dataclasses import replace
from datetime import datetime, timedelta
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from uuid import UUID, uuid4

from hypothesis import given, settings
from hypothesis import strategies as st
from sqlalchemy import delete, select, update
from sqlalchemy.orm import Session

from server.assignments.models import (
    AssignedExercise,
    Assignment,
    AttemptSelection,
    EndedBy,
    Exemption,
    LatePolicy,
    Mode,
    Sitting,
)
from server.base.settings import Settings
from server.classes.models import Membership, SchoolClass, Status
from server.course import Course
from server.database import Database
from server.gradebook import service as gradebook
from server.gradebook.models import Grading
from server.identity.models import Account
from server.marks.loading import GradebookInputs, build_gradebook, load_inputs
from server.marks.models import ManualColumn, ManualMark, MarkingPolicy, Override, StateDecision
from server.marks.schemas import Gradebook, is_test_withheld
from server.personal.guest_adoption import adopt_guest_data
from server.submissions.models import Submission
from tests.support.caches import clear_caches
from tests.support.marks import AFTER, DAY, ODOMETRY, OPENS, POSES, Term
from tests.support.quick import migrated, the_course
from tests.support.service import new_account

HOUR, INSTANT = timedelta(hours=1), timedelta(microseconds=1)


#: The contents of gradebooks by version, as fragments of pages are cached.
CACHE: dict[Hashable, list[object]] = {}


def load(db: Session, term: Term, course: Course, now: datetime, only: list[UUID] | None = None) -> GradebookInputs:
    school_class = db.get(SchoolClass, term.made.id)
    assert school_class is not None
    return load_inputs(db, course, school_class, now, only)


def read(term: Term, course: Course, now: datetime = AFTER) -> list[object]:
    with term.database.read() as db:
        return inside(db, term, course, now)


def inside(db: Session, term: Term, course: Course, now: datetime = AFTER) -> list[object]:
    """Return the contents of a gradebook, from the cache where its version is there, and its name, which is not."""
    inputs = load(db, term, course, now)
    if inputs.version not in CACHE:
        CACHE[inputs.version] = contents(build_gradebook(db, inputs))
    return [*CACHE[inputs.version], inputs.school_class.name]


def contents(gradebook: Gradebook) -> list[object]:
    columns = Assignment.__table__.columns.keys()
    assignments = [[getattr(assignment, name) for name in columns] for assignment in gradebook.assignments]
    withheld = [is_test_withheld(assignment, gradebook.at) for assignment in gradebook.assignments]
    return [assignments, withheld, gradebook.rows, gradebook.titles, gradebook.exercises, gradebook.columns]


def forget() -> None:
    CACHE.clear()
    clear_caches()


def version(term: Term, course: Course, now: datetime = AFTER, only: list[UUID] | None = None) -> Hashable:
    with term.database.read() as db:
        return load(db, term, course, now, only).version


def test_every_change_is_shown_at_once(database: Database, course: Course) -> None:
    term = Term.begin(database)
    given = term.assignment(exercises={POSES: 1.0, ODOMETRY: 2.0})
    test = term.assignment("Contrôle", {POSES: 1.0}, mode=Mode.test, duration_minutes=60)
    ada, alan = term.student("Ada", "Lovelace", groups=["TP1"]), term.student("Alan", "Turing")
    guest, martin = new_account(database), new_account(database, name="M. Roy")
    first = term.send(ada, POSES, 8)
    term.send(alan, POSES, 20, OPENS + HOUR / 8)
    for who, exercise, points in ((ada, ODOMETRY, 12), (guest, ODOMETRY, 16)):
        term.send(who, exercise, points)

    def doing(change: Callable[[Any], object]) -> Callable[[], None]:
        def done() -> None:
            with database.write() as db:
                change(db)

        return done

    def setting(model: Any, *of: Any, **values: Any) -> Callable[[], None]:
        return doing(lambda db: db.execute(update(model).where(*of).values(**values)))

    def regraded(points: float) -> Callable[[], None]:
        def choose(db: Any) -> None:
            query = select(Grading.id).where(Grading.submission_id == first, Grading.score == points / 20)
            gradebook.set_counting_grading(db, first, db.execute(query).scalar_one())

        return doing(choose)

    def marked() -> None:
        with database.write() as db:
            row = {"class_id": term.made.id, "reason": "oral", "based_on": [], "by": martin.id}
            db.add(Override(account_id=ada.id, exercise=POSES, points=18.0, **row))

    def marked_in(assignment: UUID) -> None:
        with database.write() as db:
            row = {"class_id": term.made.id, "reason": "oral", "based_on": []}
            db.add(Override(account_id=ada.id, exercise=POSES, assignment_id=assignment, points=19.0, **row))

    def decided() -> None:
        with database.write() as db:
            db.add(StateDecision(assignment_id=given.id, account_id=ada.id, state="absent"))

    rules = dict.fromkeys(("not_handed_in", "late_refused", "absent", "unanswered"), "zero")
    zeroes = MarkingPolicy(class_id=term.made.id, **rules)
    oral = ManualColumn(id=uuid4(), class_id=term.made.id, title="Oral", out_of=10.0, position=1)

    def listed(**values: Any) -> Callable[[], None]:
        return setting(Membership, Membership.class_id == term.made.id, Membership.account_id == alan.id, **values)

    def exempt() -> None:
        term.exempt(given, ada, due_at=AFTER + DAY, closes_at=AFTER + DAY, reason="malade")

    def exempt_a_group() -> None:
        with database.write() as db:
            db.add(Exemption(assignment_id=given.id, label="TP1", excused=True))

    of_given, of_test = Assignment.id == given.id, Assignment.id == test.id
    asks_poses = AssignedExercise.exercise == POSES
    changes: dict[str, Callable[[], None]] = {
        "graded anew": lambda: [term.grade(first, 14), None][1],
        "regrade undone": regraded(8),
        "regrade applied": regraded(14),
        "sent": lambda: [term.send(alan, ODOMETRY, 5), None][1],
        "marked": marked,
        "who marked is called otherwise": setting(Account, Account.id == martin.id, name="Mme Roy"),
        "who marked has gone": doing(lambda db: db.execute(delete(Account).where(Account.id == martin.id))),
        "marked in one assignment": lambda: marked_in(given.id),
        "mark withdrawn": setting(Override, withdrawn_at=AFTER),
        "absent": decided,
        "absent no more": setting(StateDecision, withdrawn_at=AFTER),
        "zero for what is missing": doing(lambda db: db.add(zeroes)),
        "column": doing(lambda db: db.add(oral)),
        "typed": doing(lambda db: db.add(ManualMark(column_id=oral.id, account_id=ada.id, points=7.0))),
        "typed anew": setting(ManualMark, points=None, state="absent"),
        "column renamed": setting(ManualColumn, title="Exposé"),
        "column deleted": setting(ManualColumn, deleted_at=AFTER),
        "exempt": exempt,
        "exempt by a label": exempt_a_group,
        "revoked": setting(Exemption, Exemption.label == "TP1", revoked_at=AFTER),
        "sitting begun": lambda: term.sit(test, alan),
        "sent in it": lambda: [term.send(alan, POSES, 3, OPENS + HOUR / 2), None][1],
        "sitting ended": setting(Sitting, handed_in_at=OPENS + HOUR / 4, ended_by=EndedBy.student),
        "released": setting(Assignment, of_test, released_at=AFTER - HOUR),
        "no test any more": setting(Assignment, of_test, mode=Mode.practice),
        "in another group": listed(groups=["TP2"]),
        "called otherwise": listed(family_name="Aaron", email="alan@example.org"),
        "logs in otherwise": setting(Account, Account.id == alan.id, login="alan.t"),
        "title": setting(Assignment, of_given, title="DM de mai"),
        "weight": setting(Assignment, of_given, weight=3.0),
        "weight of an exercise": setting(AssignedExercise, AssignedExercise.exercise == ODOMETRY, weight=7.0),
        "due": setting(Assignment, of_given, due_at=OPENS, late=LatePolicy.penalty, late_per_day=1.0),
        "the last counts": setting(Assignment, of_given, counts=AttemptSelection.last),
        "asked no more": doing(lambda db: db.execute(delete(AssignedExercise).where(asks_poses))),
        "adopted": doing(lambda db: adopt_guest_data(db, guest.id, alan.id)),
        "purged": doing(lambda db: db.execute(delete(Submission).where(Submission.account_id == alan.id))),
        "archived": setting(SchoolClass, archived_at=OPENS),
        "back": setting(SchoolClass, archived_at=None),
        "named": setting(SchoolClass, name="MPSI 3"),
        "left": listed(status=Status.left),
        "erased": doing(lambda db: db.execute(delete(Account).where(Account.id == ada.id))),
        "joined": lambda: [term.student("Emmy", "Noether"), None][1],
        "no assignment": doing(lambda db: db.execute(delete(Assignment))),
        "another module": setting(SchoolClass, module="aucun"),
    }
    before = read(term, course)
    for name, change in changes.items():
        change()
        after = read(term, course)
        assert read(term, course) == after
        forget()
        assert read(term, course) == after, name
        assert after != before, name
        before = after


def test_version_stays_until_something_changes(database: Database, course: Course) -> None:
    term = Term.begin(database)
    term.assignment()
    ada, alan = term.student("Ada", "Lovelace"), term.student("Alan", "Turing")
    term.send(ada, POSES, 8)
    first = version(term, course)
    assert version(term, course, AFTER + DAY) == first, "time alone changes nothing between two instants"
    assert len({first, version(term, course, only=[ada.id]), version(term, course, only=[alan.id])}) == 3
    assert version(term, replace(course)) != first, "another edition of the course"
    term.send(alan, POSES, 5)
    assert version(term, course) != first


def test_uncommitted_changes_are_never_shown_to_others(database: Database, course: Course) -> None:
    term = Term.begin(database)
    given = term.assignment()
    term.send(term.student("Ada", "Lovelace"), POSES, 8)
    before = read(term, course)
    for change in (
        update(Grading).values(score=1.0),
        update(Assignment).where(Assignment.id == given.id).values(weight=9.0),
        update(Membership).values(family_name="Byron"),
    ):
        with database.write() as db:
            db.execute(change)
            assert inside(db, term, course) != before
            db.rollback()
        assert read(term, course) == before


def test_concurrent_transactions_see_their_own_marks(database: Database, course: Course) -> None:
    """Who writes sees what they have written, and nobody else does before it is committed."""
    term = Term.begin(database)
    term.assignment()
    term.send(term.student("Ada", "Lovelace"), POSES, 8)
    before = read(term, course)
    with database.write() as db:
        db.execute(update(Grading).values(score=1.0))
        mine = inside(db, term, course)
        assert mine != before
        assert read(term, course) == before
        assert inside(db, term, course) == mine
    assert read(term, course) == mine


#: Of half hours after the opening of the earliest.
HALF = st.integers(0, 12)
SOMETIMES = st.one_of(st.none(), HALF)
GIVEN = st.fixed_dictionaries(
    {
        "opens": HALF, "due": SOMETIMES, "closes": SOMETIMES, "released": SOMETIMES,
        "late": st.sampled_from(LatePolicy), "mode": st.sampled_from(Mode),
        "minutes": st.sampled_from([None, 30, 60, 120]),
        "exempt": st.sampled_from([None, "due_at", "closes_at", "opens_at", "time_factor", "excused"]), "to": HALF,
        "sits": SOMETIMES, "ended": SOMETIMES, "sent": SOMETIMES,
    }
)  # fmt: skip


def at(half: int | None) -> datetime | None:
    return None if half is None else OPENS + half * HOUR / 2


def give(term: Term, wanted: dict[str, Any], students: list[Account]) -> None:
    """An assignment for all, that is another one for the first student."""
    opens = at(wanted["opens"])
    dates = {"opens_at": opens, "due_at": at(wanted["due"]), "closes_at": at(wanted["closes"])}
    penalty = 2.0 if wanted["late"] is LatePolicy.penalty else None
    rules = {"late": wanted["late"], "late_per_day": penalty, "mode": wanted["mode"]}
    more = {"duration_minutes": wanted["minutes"], "released_at": at(wanted["released"])}
    assignment = term.assignment("Un devoir", {POSES: 1.0}, **dates, **rules, **more)
    values = {"time_factor": 1.5, "excused": True}
    if wanted["exempt"] is not None:
        term.exempt(assignment, students[0], **{wanted["exempt"]: values.get(wanted["exempt"], at(wanted["to"]))})
    began = at(wanted["sits"])
    if wanted["mode"] is Mode.test and began is not None:
        ended = None if wanted["ended"] is None else began + wanted["ended"] * HOUR / 2
        by = None if ended is None else EndedBy.student if wanted["to"] % 2 else EndedBy.time
        with term.database.write() as db:
            for student in students[:2]:
                row = {"began_at": began, "handed_in_at": ended, "ended_by": by}
                db.add(Sitting(assignment_id=assignment.id, account_id=student.id, **row))
    sent_at = at(wanted["sent"])
    if sent_at is not None:
        term.send(students[0], POSES, 11, sent_at)


#: Of quarters of an hour after the opening of the earliest: from before all of it to after the longest sitting.
QUARTERS = range(-1, 42)


def quarters(drawn: dict[str, Any]) -> set[int]:
    """Return the quarters of an hour at which something of this assignment may change."""
    halves = [drawn[name] for name in ("opens", "due", "closes", "released", "to", "sits", "sent")]
    found = {2 * half for half in halves if half is not None}
    if drawn["sits"] is not None:
        lengths = [30 * (drawn["ended"] or 0), drawn["minutes"] or 0]
        found |= {2 * drawn["sits"] + int(factor * length) // 15 for length in lengths for factor in (1, 1.5)}
    return found & {*QUARTERS}


@given(st.lists(GIVEN, min_size=1, max_size=3), st.randoms(use_true_random=False))
@settings(max_examples=5, deadline=None, database=None)
def test_a_cached_gradebook_is_right_at_every_time(wanted: list[dict[str, Any]], draw: Any) -> None:
    """At each time on which something may depend and at a few others, just before and after; in any order."""
    course = the_course()
    with TemporaryDirectory() as folder, closing(migrated(Settings(data_dir=Path(folder), workers=0))) as database:
        term = Term.begin(database)
        students = [term.student("Ada", "Lovelace"), term.student("Alan", "Turing"), term.student("Emmy", "Noether")]
        for drawn in wanted:
            give(term, drawn, students)
        # Times that were extended by a half, of a half hour, fall on quarters.
        chosen = sorted({QUARTERS[0], QUARTERS[-1], *draw.sample(QUARTERS, 3)}.union(*map(quarters, wanted)))
        times = [OPENS + quarter * HOUR / 4 + near * INSTANT for quarter, near in product(chosen, (-1, 0, 1))]
        forget()
        cached = [read(term, course, now) for now in times]
        mixed = draw.sample(range(len(times)), len(times) // 3)
        again = {index: read(term, course, times[index]) for index in mixed}
        for index, now in enumerate(times):
            forget()
            fresh = read(term, course, now)
            assert cached[index] == fresh, now
            assert again.get(index, fresh) == fresh, now
