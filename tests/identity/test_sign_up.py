"""What a sign-up costs, and to whom: nothing is hashed for nothing, a few at once, and never on the loop."""

from __future__ import annotations

import asyncio
import threading
from typing import Any

import pytest
from sqlalchemy import select

from server.base.errors import Overloaded
from server.identity import secrets
from server.identity.hashing import KNOWN, NOBODY, PasswordHasher
from server.identity.models import Account
from server.limits.models import TokenBucket
from tests.support.quick import in_a_loop
from tests.support.service import Site

FORM = {"name": "Ada L.", "login": "ada", "password": "notes sur la machine"}


@pytest.fixture
def hashed(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The passwords that are hashed."""
    asked: list[str] = []
    real = secrets.hash_password

    def note(password: str) -> str:
        asked.append(password)
        return real(password)

    monkeypatch.setattr(secrets, "hash_password", note)
    return asked


def sign_up(site: Site, **change: str) -> Any:
    site.client.cookies.clear()
    return site.client.post("/inscription", data={**FORM, **change})


def test_sign_ups_from_one_address_are_bounded_before_any_hash(site: Site, hashed: list[str]) -> None:
    site.tighten(sign_up_burst=2, sign_up_refill_seconds=1000.0)
    statuses = [sign_up(site, login=f"ada{number}").status_code for number in range(4)]
    assert statuses == [303, 303, 429, 429]
    assert len(hashed) == 2


def test_a_form_that_is_refused_takes_nothing_from_the_others(site: Site) -> None:
    site.tighten(sign_up_burst=1, sign_up_refill_seconds=1000.0)
    for _ in range(3):
        assert sign_up(site, password="court").status_code == 422
    assert sign_up(site).status_code == 303


def test_a_login_that_is_taken_costs_no_hash_and_asking_is_slow(site: Site, hashed: list[str]) -> None:
    assert sign_up(site).status_code == 303
    site.tighten(sign_up_burst=3, sign_up_refill_seconds=1000.0)
    statuses = [sign_up(site).status_code for _ in range(4)]
    assert statuses == [422, 422, 422, 429]
    assert len(hashed) == 1


def test_of_two_who_take_a_login_at_once_one_is_told(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    assert sign_up(site).status_code == 303
    monkeypatch.setattr("server.identity.service.require_login_free", lambda _db, _login: None)
    answer = sign_up(site)
    assert (answer.status_code, "pas disponible" in answer.text) == (422, True)


def test_a_link_that_is_none_costs_no_hash(site: Site, hashed: list[str]) -> None:
    assert site.client.post("/bienvenue/au-hasard", data=FORM).status_code == 404
    assert hashed == []
    with site.database.read() as db:
        keys = list(db.execute(select(TokenBucket.key)).scalars())
        assert db.execute(select(Account)).first() is None
    assert keys == ["sign-up:inconnue"], "guessing links is slow too"


def test_few_are_hashed_at_once_off_the_loop_and_too_many_are_sent_away(monkeypatch: pytest.MonkeyPatch) -> None:
    running: list[int] = []
    most, gate, loop_thread = [0], threading.Event(), []

    def slow(password: str) -> str:
        running.append(1)
        most[0] = max(most[0], len(running))
        assert threading.current_thread() not in loop_thread
        gate.wait(300)
        running.pop()
        return password

    monkeypatch.setattr(secrets, "hash_password", slow)

    async def scene() -> list[object]:
        loop_thread.append(threading.current_thread())
        few = PasswordHasher(at_once=2, waiting=3)
        flood = [asyncio.create_task(few.hash(f"p{number}", address="a")) for number in range(8)]
        while sum(task.done() for task in flood) < 3:
            await asyncio.sleep(0)
        other = asyncio.create_task(few.hash("other", address="b"))
        while sum(task.done() for task in flood) < 4:  # one of the flood gives way
            await asyncio.sleep(0)
        while len(running) < 2:  # both threads have begun
            await asyncio.sleep(0)
        gate.set()
        return await asyncio.gather(*flood, other, return_exceptions=True)

    results = in_a_loop(scene())
    assert most[0] == 2
    assert [type(result) for result in results].count(Overloaded) == 4
    assert results[-1] == "other"


def test_who_is_known_does_not_wait_behind_a_flood_of_passwords(monkeypatch: pytest.MonkeyPatch) -> None:
    gate, begun = threading.Event(), list[str]()

    def slow(password: str) -> str:
        begun.append(password)
        gate.wait(300)
        return password

    monkeypatch.setattr(secrets, "hash_password", slow)

    async def scene() -> None:
        few = PasswordHasher(at_once=1)
        flood = [asyncio.create_task(few.hash(f"p{number}", address="a")) for number in range(8)]
        known = asyncio.create_task(few.hash("known", address="a", rank=KNOWN))
        while "known" not in begun:
            await asyncio.sleep(0)
        assert len(begun) == 2
        gate.set()
        await asyncio.gather(*flood, known)

    in_a_loop(scene())


def test_a_first_log_in_goes_before_a_flood_of_wrong_logins_at_its_address(monkeypatch: pytest.MonkeyPatch) -> None:
    """And a login that is tried again and again waits behind one that is tried once."""
    gate, begun = threading.Event(), list[str]()

    def slow(password: str, _stored: str | None) -> bool:
        begun.append(password)
        gate.wait(300)
        return False

    monkeypatch.setattr(secrets, "verify_password", slow)

    async def scene() -> None:
        few = PasswordHasher(at_once=1)
        tasks = [
            asyncio.create_task(few.verify(f"n{k}", None, address="a", rank=NOBODY, login=f"n{k}")) for k in range(8)
        ]
        tasks += [asyncio.create_task(few.verify(f"x{k}", "h", address="a", login="x")) for k in range(4)]
        await asyncio.sleep(0)
        first = asyncio.create_task(few.verify("first", "h", address="a", login="ada"))
        while len(begun) < 2:
            await asyncio.sleep(0)
        gate.set()
        await asyncio.gather(*tasks, first)

    in_a_loop(scene())
    assert begun.index("first") <= 3, begun
    assert begun.index("x3") < begun.index("n1")
