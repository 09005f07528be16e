"""Requests are taken up a few a pass of the loop: members first, strangers by address in turn, bounded in number."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from uuid import uuid4

import pytest

from server.base import admission
from server.base.admission import INTERVAL, LATELY, MAX_WAITING, MEMBER_SECONDS, PER_PASS, RequestAdmission
from server.base.turns import record_sender

HEAD = b"GET /l20 HTTP/1.1\r\nHost: a\r\n%s\r\n\r\n"


@dataclass(eq=False)
class Connection:
    """A connection that notes what becomes of it."""

    name: str
    log: list[str]
    address: str = "192.0.2.1"
    is_gone: bool = False

    def take_up(self) -> None:
        self.log.append(self.name)

    def refuse(self) -> None:
        self.log.append(f"{self.name} refused")


@dataclass
class Loop:
    """Passes of an event loop, by hand."""

    actions: list[Callable[[], object]] = field(default_factory=list)
    log: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.now = 0.0
        self.admission = RequestAdmission(lambda _seconds, action: self.actions.append(action), lambda: self.now)

    def come(
        self, name: str, header: bytes = b"X: y", address: str = "192.0.2.1", *, is_gone: bool = False
    ) -> Connection:
        connection = Connection(name, self.log, address, is_gone)
        if self.admission.may_pass(HEAD % header, connection):
            connection.take_up()
        return connection

    def turn(self) -> list[str]:
        """Run one pass; return what it has done."""
        actions, before = list(self.actions), len(self.log)
        self.actions.clear()
        for action in actions:
            action()
        return self.log[before:]


def test_a_pass_takes_up_a_few_and_an_idle_loop_all_at_once() -> None:
    loop = Loop()
    for number in range(2 * PER_PASS + 1):
        loop.come(str(number))
    assert len(loop.log) == PER_PASS
    assert loop.turn() == [str(number) for number in range(PER_PASS, 2 * PER_PASS)]
    assert loop.turn() == [str(2 * PER_PASS)]
    assert loop.turn() == []
    assert not loop.actions, "an idle loop has nothing to do"
    loop.come("later")
    assert loop.log[-1] == "later"


@pytest.mark.parametrize("header", [b"Cookie: a=b; balise_session=%s; c=d", b"Authorization: Bearer %s"])
def test_members_go_first(header: bytes) -> None:
    record_sender("of-a-member_1", uuid4(), is_guest=False)
    record_sender("of-a-guest", uuid4(), is_guest=True)
    loop = Loop()
    for number in range(3 * PER_PASS):
        loop.come(f"stranger {number}")
    loop.come("guest", header % b"of-a-guest")
    loop.come("unknown", header % b"of-nobody")
    loop.come("member", header % b"of-a-member_1")
    assert loop.turn()[0] == "member"
    assert "guest" not in loop.log


def test_addresses_take_turns_and_who_has_left_takes_none() -> None:
    loop = Loop()
    for number in range(4 * PER_PASS):
        loop.come(f"many {number}", is_gone=number == PER_PASS + 1)
    loop.come("other", address="192.0.2.2")
    assert loop.turn()[:2] == [f"many {PER_PASS}", "other"]
    assert f"many {PER_PASS + 1}" not in loop.log


def test_the_address_with_the_most_has_its_last_request_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(admission, "MAX_WAITING", 3)
    assert MAX_WAITING > 100
    loop = Loop()
    for number in range(PER_PASS + 3):
        loop.come(str(number))
    loop.log.clear()
    loop.come("other", address="192.0.2.2")
    assert loop.log == [f"{PER_PASS + 2} refused"]
    loop.come("last")
    assert loop.log[1:] == ["last refused"]
    assert set(loop.turn()) == {str(PER_PASS), str(PER_PASS + 1), "other"}


def test_strangers_come_at_intervals_while_a_member_is_served() -> None:
    record_sender("of-a-member_2", uuid4(), is_guest=False)
    loop = Loop()
    member = loop.come("member", b"Cookie: balise_session=of-a-member_2")
    for number in range(5 * PER_PASS):
        loop.come(f"stranger {number}")
    assert loop.log == ["member", "stranger 0"], "none has come yet, and one may"
    loop.log.clear()
    assert loop.turn() == []
    loop.now += INTERVAL
    assert len(loop.turn()) == 1
    assert loop.turn() == []
    loop.admission.note_request_ended(member)
    assert len(loop.turn()) == 1
    assert len(loop.turn()) == 1, "a pass each: a page that a member opens now stands behind one"

    loop.come("again", b"Cookie: balise_session=of-a-member_2")
    assert loop.log[-1] == "again", "at once, before all strangers who wait"
    loop.turn()
    loop.now += MEMBER_SECONDS + INTERVAL
    assert len(loop.turn()) == 1, "a stream of a member's keeps nobody waiting for long"
    loop.now += LATELY
    assert len(loop.turn()) == PER_PASS, "no member is there"


def test_a_stranger_with_no_other_before_it_waits_as_well_while_a_member_is_served() -> None:
    """Few connections that ask again as soon as they are answered never wait for each other: all were taken up."""
    record_sender("of-a-member_3", uuid4(), is_guest=False)
    loop = Loop()
    loop.come("member", b"Cookie: balise_session=of-a-member_3")
    for number in range(20):
        loop.come(f"stranger {number}")
        loop.turn()
        loop.now += INTERVAL / 10
    assert len(loop.log) == 3
