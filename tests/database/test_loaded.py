"""Rows that are read as columns."""

from __future__ import annotations

import pytest
from sqlalchemy import inspect, select
from sqlalchemy.orm.exc import DetachedInstanceError

from server.classes import repository
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.database import Database, detached_instance, table_of
from server.identity.models import Account
from tests.support.service import new_account


def test_a_row_of_columns_is_what_a_closed_session_leaves(database: Database) -> None:
    made = new_account(database)
    columns = table_of(Account).c
    names = columns.keys()
    with database.read() as db:
        (row,) = db.execute(select(*columns).where(columns.id == made.id)).all()
        kept = db.execute(select(Account).where(Account.id == made.id)).scalar_one()
        found = detached_instance(Account, zip(names, row, strict=True))
        assert found not in db
        assert {name: getattr(found, name) for name in names} == dict(zip(names, row, strict=True))
    assert inspect(found).detached
    assert inspect(found).identity == inspect(kept).identity
    assert not inspect(found).modified


def test_a_class_is_listed_by_family_name(database: Database) -> None:
    ada, bob = new_account(database), new_account(database)
    with database.write() as db:
        school_class = SchoolClass(name="M2", module="l20", created_by=ada.id)
        db.add(school_class)
        db.flush()
        for number, account in enumerate((ada, bob)):
            names = {"family_name": f"Z{1 - number}", "given_name": "É", "groups": ["A"] * number}
            db.add(
                Membership(
                    class_id=school_class.id,
                    account_id=account.id,
                    role=ClassRole.student,
                    status=Status.active,
                    **names,
                )
            )
    with database.read() as db:
        listed = [
            (member.id, member.name, member.role, member.status, list(member.groups), member.account.id)
            for member in repository.load_members(db, school_class.id)
        ]
    assert listed == [
        (bob.id, "É Z0", ClassRole.student, Status.active, ["A"], bob.id),
        (ada.id, "É Z1", ClassRole.student, Status.active, [], ada.id),
    ]


def test_a_column_that_was_not_asked_for_is_an_error(database: Database) -> None:
    made = new_account(database)
    found = detached_instance(Account, [("id", made.id), ("name", "Ada")])
    assert found.name == "Ada"
    with pytest.raises(DetachedInstanceError):
        _ = found.login
