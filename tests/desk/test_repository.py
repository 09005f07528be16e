"""Queries of the desk, on both databases, against counts made by hand."""

from __future__ import annotations

from datetime import timedelta

from server.assignments import editing, sittings
from server.assignments.models import Mode, WeightedExercise
from server.assignments.schemas import AssignmentInput
from server.classes.models import ClassRole, Status
from server.database import Database, utc_now
from server.desk import repository
from server.gradebook.models import Standing
from server.identity.models import Role
from tests.support.classes import assign, new_class, seat
from tests.support.quick import the_course
from tests.support.service import new_account

BOTH = ("l20/poses", "l20/calcul_odometrie")


def test_who_has_finished_is_counted_once_and_among_the_students_alone(database: Database) -> None:
    teacher, now = new_account(database, Role.teacher, "Mme Martin"), utc_now()
    made, solved = new_class(database, teacher), now - timedelta(days=1)
    members = {
        "all": (ClassRole.student, Status.active, BOTH),
        "half": (ClassRole.student, Status.active, BOTH[:1]),
        "gone": (ClassRole.student, Status.left, BOTH),
        "helper": (ClassRole.assistant, Status.active, BOTH),
    }
    accounts = {name: new_account(database, Role.student, name) for name in [*members, "stranger"]}
    for name, (role, status, _) in members.items():
        seat(database, made, accounts[name], role, status=status)
    with database.write() as db:
        for name, account in accounts.items():
            for exercise in BOTH:
                done = name == "stranger" or exercise in members[name][2]
                row = {"best_score": float(done), "attempts": 3, "last_outcome": "ok", "last_at": now}
                first = solved if done else None
                db.add(Standing(account_id=account.id, exercise=exercise, first_success_at=first, **row))
        given = [
            editing.create_assignment(
                db,
                the_course(),
                made,
                teacher.id,
                AssignmentInput(str(names), tuple(map(WeightedExercise, names)), now),
            )
            for names in (BOTH, BOTH[:1], BOTH[1:])
        ]
    with database.read() as db:
        found = repository.count_finished_students(db, made.id, [one.id for one in given])
        assert [found.get(one.id, 0) for one in given] == [1, 2, 1]


def test_who_has_begun_a_test_is_counted_among_the_students_alone(database: Database) -> None:
    made = new_class(database, new_account(database, Role.teacher))
    tests = [assign(database, made, BOTH[0], mode=Mode.test) for _ in range(2)]
    members = {
        "begun": (ClassRole.student, Status.active),
        "gone": (ClassRole.student, Status.left),
        "helper": (ClassRole.assistant, Status.active),
    }
    for name, (role, status) in members.items():
        account = new_account(database, Role.student, name)
        seat(database, made, account, role, status=status)
        with database.write() as db:
            sittings.begin_sitting(db, tests[0], account.id, (), utc_now())
    with database.read() as db:
        assert repository.count_begun_students(db, made.id, [test.id for test in tests]) == {tests[0].id: 1}
