"""Who may begin a test: no guest, and nobody under the name of somebody else; a clock is started once."""

from __future__ import annotations

import re
from typing import Any
from uuid import UUID

import pytest
from sqlalchemy import select

from server.assignments import eligibility
from server.assignments.models import Assignment, Mode, Sitting
from server.audit.models import AuditAction, AuditEvent
from server.base.errors import Forbidden
from server.classes.models import Membership
from server.database import Database, utc_now
from server.identity.models import Account, Role
from tests.support.classes import Person, assign, new_class, person, seat
from tests.support.client import TestClient
from tests.support.service import EXERCISE, Site, new_account

PASSWORD = "notes sur la machine"


class Hall:
    """A class with Ada Lovelace on its list, and a test that is open."""

    def __init__(self, site: Site) -> None:
        self.site = site
        self.teacher = person(site, Role.teacher, "Mme Martin")
        self.made = new_class(site.database, self.teacher.account)
        self.test = assign(site.database, self.made, EXERCISE, mode=Mode.test, duration_minutes=60)
        self.path = f"/classes/{self.made.id}/devoirs/{self.test.id}"
        self.ada = self.listed("Ada Lovelace")

    def listed(self, name: str) -> Person:
        one = person(self.site, name=name)
        seat(self.site.database, self.made, one.account, created_by_list=True)
        return one

    def joined(self, login: str, name: str) -> TestClient:
        """Somebody who signs up under a name of their choice, and joins by the code."""
        browser = self.visitor()
        browser.post("/inscription", data={"name": name, "login": login, "password": PASSWORD})
        assert browser.post(f"/rejoindre/{self.made.join_code}").status_code == 303
        return browser

    def guest(self, given: str, family: str) -> TestClient:
        browser = self.visitor()
        form = {"given": given, "family": family}
        assert browser.post(f"/rejoindre/{self.made.join_code}", data=form).status_code == 303
        return browser

    def visitor(self) -> TestClient:
        return TestClient(self.site.app, follow_redirects=False)

    def begin(self, browser: Any) -> int:
        status: int = browser.post(f"{self.path}/commencer").status_code
        return status

    def sittings(self) -> list[UUID]:
        with self.site.database.read() as db:
            return list(db.execute(select(Sitting.account_id)).scalars())


@pytest.fixture
def hall(site: Site) -> Hall:
    return Hall(site)


def told(answer: Any) -> str:
    return re.sub(r"\s+", " ", re.sub(r"<[^>]*>", " ", answer.text))


@pytest.mark.parametrize("name", [("Ada", "Lovelace"), ("LOVELACE", "Ada"), ("Une", "Inconnue")])
def test_a_guest_begins_no_test_and_is_told_the_next_step(hall: Hall, name: tuple[str, str]) -> None:
    guest = hall.guest(*name)
    page = guest.get(f"{hall.path}/composer")
    assert "/commencer" not in page.text
    assert "Un invité ne commence pas de contrôle" in told(page)
    assert f'href="/connexion?suite={hall.path}/composer"' in page.text.replace("%2F", "/")
    assert 'href="/inscription?suite=' in page.text
    assert hall.begin(guest) == 403
    assert hall.sittings() == []
    assert hall.begin(hall.ada.browser(hall.site)) == 303, "the place is not taken"


def test_a_guest_who_logs_in_begins_under_their_own_name(hall: Hall) -> None:
    guest = hall.guest("Grace", "Hopper")
    guest.post("/inscription", data={"name": "Grace Hopper", "login": "grace", "password": PASSWORD})
    assert hall.begin(guest) == 303


@pytest.mark.parametrize("name", ["Ada Lovelace", "LOVELACE Ada", "ada  lovelace", "Àda Lovelàce"])
def test_nobody_begins_under_a_name_of_the_list(hall: Hall, name: str) -> None:
    impostor = hall.joined("eve", name)
    assert "connectez-vous avec ce compte-là" in told(impostor.get(f"{hall.path}/composer"))
    assert hall.begin(impostor) == 403
    assert hall.sittings() == []


def test_a_second_account_of_one_s_own_gives_no_second_clock(hall: Hall) -> None:
    """In a class without a list too: the first who begins under a name is the only one."""
    first, second = hall.joined("grace", "Grace Hopper"), hall.joined("grace2", "Hopper Grace")
    assert [hall.begin(first), hall.begin(second), hall.begin(first)] == [303, 403, 303]
    assert len(hall.sittings()) == 1


def test_leaving_and_coming_back_gives_no_second_clock(hall: Hall) -> None:
    grace = hall.joined("grace", "Grace Hopper")
    hall.begin(grace)
    with hall.site.database.read() as db:
        began = db.execute(select(Sitting.began_at)).scalar_one()
    assert grace.post(f"/classes/{hall.made.id}/quitter").status_code == 303
    second = hall.joined("grace2", "Grace Hopper")
    assert hall.begin(second) == 403, "who has left is still known"
    assert grace.post(f"/rejoindre/{hall.made.join_code}").status_code == 303
    assert hall.begin(grace) == 303
    with hall.site.database.read() as db:
        assert db.execute(select(Sitting.began_at)).scalars().all() == [began]


def test_being_removed_and_added_again_gives_no_second_clock(hall: Hall) -> None:
    ada, teacher = hall.ada.browser(hall.site), hall.teacher.browser(hall.site)
    hall.begin(ada)
    with hall.site.database.read() as db:
        began = db.execute(select(Sitting.began_at)).scalar_one()
    for action in ("retirer", "reprendre"):
        form = {"action": action, "eleve": str(hall.ada.id)}
        assert teacher.post(f"/classes/{hall.made.id}/eleves", data=form).status_code == 303
    assert hall.begin(ada) == 303
    with hall.site.database.read() as db:
        assert db.execute(select(Sitting.began_at)).scalars().all() == [began]


def test_two_of_one_name_on_the_list_both_begin(hall: Hall) -> None:
    other = hall.listed("Ada Lovelace")
    assert [hall.begin(one.browser(hall.site)) for one in (hall.ada, other)] == [303, 303]


def test_a_teacher_tells_two_people_of_one_name_apart_and_the_log_says_so(hall: Hall) -> None:
    other, teacher = hall.joined("ada2", "Ada Lovelace"), hall.teacher.browser(hall.site)
    with hall.site.database.read() as db:
        other_id = db.execute(select(Account.id).where(Account.login == "ada2")).scalar_one()
    people = f"/classes/{hall.made.id}/eleves"
    page = teacher.get(people).text
    assert page.count("même nom qu’un autre élève") == 1
    form = {"action": "confirmer", "eleve": str(other_id)}
    assert other.post(people, data=form).status_code == 403, "not by oneself"
    assert teacher.post(people, data=form).status_code == 303
    assert "même nom qu’un autre élève" not in teacher.get(people).text
    assert hall.begin(other) == 303
    with hall.site.database.read() as db:
        event = db.execute(select(AuditEvent).where(AuditEvent.what == AuditAction.student_confirmed)).scalar_one()
    assert (event.by, event.student) == (hall.teacher.id, other_id)


def test_on_both_databases_of_two_accounts_of_one_name_the_second_is_refused(database: Database) -> None:
    made = new_class(database, new_account(database, Role.teacher, "Mme Martin"))
    test = assign(database, made, EXERCISE, mode=Mode.test)
    first, second, disabled = (
        seat(database, made, new_account(database, name="Ada"), is_confirmed=False) for _ in range(3)
    )

    def begin(account: Account) -> None:
        with database.write() as db:
            membership = db.get_one(Membership, (made.id, account.id))
            eligibility.require_may_begin(db, db.get_one(Assignment, test.id), account, membership)
            db.add(Sitting(assignment_id=test.id, account_id=account.id, began_at=utc_now()))

    with database.write() as db:
        db.get_one(Account, disabled.id).disabled_at = utc_now()
    with pytest.raises(Forbidden, match="suspendu"):
        begin(disabled)
    begin(first)
    with pytest.raises(Forbidden, match="Ada"):
        begin(second)
    with database.read() as db:
        assert db.execute(select(Sitting.account_id)).scalars().all() == [first.id]
