"""What a statement was compiled to is found by what it is, and another statement never gets it."""

from __future__ import annotations

import pytest
from sqlalchemy import Select, bindparam, literal, select

from server.database import Database, ask, prepared
from server.database import compiled as room
from server.database.compiled import Compiled
from server.identity.models import Account
from tests.support.counting import Counted


@prepared
def _named(name: str) -> Select[str]:
    return select(Account.name).where(Account.name == name)


class Key:
    """The part of a key that tells all of a statement; how often it was hashed is counted."""

    def __init__(self) -> None:
        self.hashed = 0

    def __hash__(self) -> int:
        self.hashed += 1
        return 1

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Key)


def test_the_same_statement_is_found_without_being_hashed_and_an_equal_one_by_its_hash() -> None:
    kept, first, equal = Compiled(), Key(), Key()
    kept["dialect", first, ("name",)] = "compiled"
    assert kept.get(("dialect", first, ("name",))) == "compiled"
    before = first.hashed
    assert kept.get(("dialect", first, ("name",))) == "compiled"
    assert first.hashed == before
    assert kept.get(("dialect", equal, ("name",))) == "compiled"
    assert equal.hashed
    for other in (("another", first, ("name",)), ("dialect", first, ()), ("dialect", first, ("name", "more"))):
        assert kept.get(other) is None


def test_no_more_is_kept_than_so_many(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room, "MOST", 8)
    kept = Compiled()
    kept["dialect", Key(), ()] = "compiled"
    for _ in range(50):
        assert kept.get(("dialect", Key(), ())) == "compiled"
    assert len(kept._same) <= 8


def test_a_statement_that_is_made_from_another_is_asked_as_it_is(database: Database) -> None:
    with database.write() as db:
        db.add_all([Account(name="Ada"), Account(name="Bob")])
    (statement, values) = _named("Ada")
    narrower = statement.where(literal(1) == bindparam("one"))
    with database.read() as db, Counted(database) as counted:
        for _ in range(2):
            assert ask(db, *_named("Ada")).scalars().all() == ["Ada"]
            assert ask(db, *_named("Bob")).scalars().all() == ["Bob"]
            assert ask(db, narrower, {**values, "one": 2}).scalars().all() == []
            assert ask(db, narrower, {**values, "one": 1}).scalars().all() == ["Ada"]
            for place in range(3):
                found = ask(db, select(Account.name).order_by(Account.name).offset(place).limit(1), {})
                assert found.scalars().all() == ["Ada", "Bob"][place : place + 1]
    assert len(set(counted.statements)) == 3
