"""Statements that are put together once."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import Select, select

from server.database import Database, prepared_statement, select_core
from server.identity.models import Account, Role


def test_a_statement_is_made_once_and_asked_with_each_ones_values(sqlite: Database) -> None:
    made: list[bool] = []

    @prepared_statement
    def named(role: str, names: Collection[str], *, backwards: bool) -> Select[Any]:
        made.append(backwards)
        query = select(Account.name).where(Account.role == role, Account.name.in_(names))
        return query.order_by(Account.name.desc() if backwards else Account.name)

    with sqlite.write() as db:
        db.add_all(Account(role=Role.student, name=name) for name in ("Ada", "Alan", "Grace"))
    with sqlite.read() as db:
        found = [
            db.execute(*named("student", names, backwards=backwards)).scalars().all()
            for names in (["Ada", "Grace"], ["Alan"], [])
            for backwards in (False, True)
        ]
        assert db.execute(*named("teacher", ["Ada"], backwards=True)).all() == []
    assert found == [["Ada", "Grace"], ["Grace", "Ada"], ["Alan"], ["Alan"], [], []]
    assert made == [False, True]


def test_what_is_asked_the_short_way_is_of_the_same_transaction_with_what_waits_to_be_written(sqlite: Database) -> None:
    named = select(Account.name, Account.created_at).where(Account.name == "Ada")
    ada = Account(name="Ada")
    with sqlite.write() as db:
        assert select_core(db, named, {}).all() == []
        db.add(ada)
        assert [tuple(row) for row in select_core(db, named, {})] == [("Ada", ada.created_at)]
        ada.name = "Grace"
        assert select_core(db, named, {}).all() == []
        db.rollback()
    with sqlite.read() as db:
        assert select_core(db, select(Account.name), {}).all() == []


def test_the_same_identity_is_the_same_object(sqlite: Database) -> None:
    name = uuid4()
    with sqlite.write() as db:
        db.add(Account(id=name, role=Role.student, name="Ada"))
    with sqlite.read() as db, sqlite.read() as again:
        (one,), (other,) = (each.execute(select(Account.id)).scalars().all() for each in (db, again))
    assert isinstance(one, UUID)
    assert one == name
    assert one is other
