"""Two people, or two tabs, edit the same thing: the later save is told, and chooses."""

from __future__ import annotations

import re
from dataclasses import dataclass
from datetime import timedelta
from typing import Any

import pytest

from server.assignments.models import Assignment, Exemption
from server.classes.models import SchoolClass
from server.database import utc_now
from server.identity.models import Role
from server.web.form_version import form_version_tag
from tests.support.classes import Person, assign, new_class, person, seat
from tests.support.forms import hidden_fields
from tests.support.service import EXERCISE, Site


@dataclass(frozen=True)
class Desk:
    site: Site
    teacher: Person
    made: SchoolClass
    assignment: Assignment

    @property
    def home(self) -> str:
        return f"/classes/{self.made.id}"

    @property
    def path(self) -> str:
        return f"{self.home}/devoirs/{self.assignment.id}"

    def stored(self, of: type[Any], key: Any) -> Any:
        with self.site.database.read() as db:
            return db.get(of, key)


@pytest.fixture
def desk(site: Site) -> Desk:
    teacher = person(site, Role.teacher, "Mme Martin")
    made = new_class(site.database, teacher.account)
    assignment = assign(site.database, made, EXERCISE, due_at=utc_now() + timedelta(days=3))
    return Desk(site, teacher, made, assignment)


def form_fields(page: str) -> dict[str, str]:
    """The text fields and hidden fields of a page, as drawn."""
    pairs = re.findall(r'<input[^>]*name="([^"]+)"[^>]*?value="([^"]*)"', page)
    return {name: value for name, value in pairs if name not in {"eleve"}}


def test_the_later_save_of_settings_is_told_and_may_be_kept(desk: Desk) -> None:
    browser, address = desk.teacher.browser(desk.site), f"{desk.home}/reglages"
    version = re.search(r'name="version" value="(\w+)"', browser.get(address).text)
    assert version is not None
    older = {"version": version[1], "approbation": "oui"}
    assert browser.post(address, data={**older, "name": "MPSI 3"}).status_code == 303
    refused = browser.post(address, data={**older, "name": "MPSI 4"})
    assert refused.status_code == 409
    assert "a été modifié depuis que cette page est ouverte" in refused.text
    assert "MPSI 3" in refused.text
    assert "MPSI 4" in refused.text
    assert desk.stored(SchoolClass, desk.made.id).name == "MPSI 3"
    assert browser.post(address, data=hidden_fields(refused.text, address)).status_code == 303
    assert desk.stored(SchoolClass, desk.made.id).name == "MPSI 4"


def test_a_save_that_changes_nothing_is_no_conflict(desk: Desk) -> None:
    browser, address = desk.teacher.browser(desk.site), f"{desk.home}/reglages"
    same = {"version": "0" * 16, "name": desk.made.name, **({"approbation": "oui"} if desk.made.approval else {})}
    assert browser.post(address, data=same).status_code == 303


def test_an_older_form_of_an_assignment_does_not_take_back_a_date(desk: Desk) -> None:
    browser, address = desk.teacher.browser(desk.site), f"{desk.path}/modifier"
    older = form_fields(browser.get(address).text)
    drawn = {**older, "exercice": EXERCISE, "retard": "accept"}
    moved = {**drawn, "rendre": "2031-05-04T18:00"}
    assert browser.post(address, data=moved).status_code == 303
    refused = browser.post(address, data={**drawn, "titre": "Autre titre"})
    assert refused.status_code == 409
    assert "Date limite" in refused.text
    assert "2031-05-04 18:00" in refused.text
    assert desk.stored(Assignment, desk.assignment.id).title == "Interro"
    chosen = {**hidden_fields(refused.text, address)}
    assert browser.post(address, data=chosen).status_code == 303
    assert desk.stored(Assignment, desk.assignment.id).title == "Autre titre"


def test_a_preview_of_the_form_keeps_the_version_that_it_was_drawn_from(desk: Desk) -> None:
    browser, address = desk.teacher.browser(desk.site), f"{desk.path}/modifier"
    older = {**form_fields(browser.get(address).text), "exercice": EXERCISE, "retard": "accept"}
    assert browser.post(address, data={**older, "titre": "Premier"}).status_code == 303
    preview = browser.post(address, data={**older, "apercu": "oui"}).text
    assert f'name="version" value="{older["version"]}"' in preview


def test_two_teachers_do_not_grant_twice_unknowingly(desk: Desk) -> None:
    student = person(desk.site, name="Ines")
    seat(desk.site.database, desk.made, student.account)
    browser, address = desk.teacher.browser(desk.site), f"{desk.path}/amenagements"
    older = hidden_fields(browser.get(address).text, address)
    grant = {**older, "eleve": str(student.id), "temps": "1,33", "raison": "tiers-temps"}
    assert browser.post(address, data=grant).status_code == 303
    refused = browser.post(address, data={**grant, "temps": "1,5"})
    assert refused.status_code == 409
    assert "Accorder quand même" in refused.text
    with desk.site.database.read() as db:
        assert db.query(Exemption).count() == 1
    assert browser.post(address, data=hidden_fields(refused.text, address)).status_code == 303


def test_versions_do_not_depend_on_the_order_of_fields() -> None:
    assert form_version_tag({"a": "1", "b": "2"}) == form_version_tag({"b": "2", "a": "1"})
    assert form_version_tag({"a": "1"}) != form_version_tag({"a": "2"})
    assert form_version_tag({"a": "1", "b": ""}) != form_version_tag({"a": "", "b": "1"})
