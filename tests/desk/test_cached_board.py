"""The cached fragments of a board equal fresh ones after each change."""

from __future__ import annotations

import re
from collections.abc import Callable
from datetime import timedelta
from uuid import UUID

import pytest
from sqlalchemy import select, update

from server.assignments.models import Assignment
from server.base import school_time
from server.classes.models import ClassRole, Membership, SchoolClass
from server.database import utc_now
from server.identity.models import Role
from server.marks.models import Override
from tests.support.caches import clear_caches, record_renders
from tests.support.classes import Person, assign, new_class, person, seat
from tests.support.crowd import Sent, lessons, seated, store
from tests.support.service import EXERCISE, Site

OTHER, WRONG = "l20/kabsch", "rotation_oubliee"
READ_AT = re.compile(r"Données</span> du .*? · ")


def page(site: Site, reader: Person, made: SchoolClass, query: str = "") -> str:
    answer = reader.browser(site).get(f"/classes/{made.id}{query}")
    assert answer.status_code == 200
    return READ_AT.sub("", answer.text)


@pytest.fixture
def teacher(site: Site) -> Person:
    return person(site, Role.teacher, "Mme Martin")


@pytest.fixture
def students() -> list[UUID]:
    return []


@pytest.fixture
def made(site: Site, teacher: Person, students: list[UUID]) -> SchoolClass:
    """A class of six that has worked at two exercises."""
    made, now = new_class(site.database, teacher.account), utc_now()
    assign(site.database, made, EXERCISE, OTHER, opened=timedelta(days=3))
    students += seated(site.database, made, 6, now)
    store(site.database, lessons(students, [EXERCISE, OTHER], {EXERCISE: [WRONG], OTHER: ["a", "b"]}, now))
    return made


def test_every_change_is_rendered_at_once(
    site: Site, teacher: Person, made: SchoolClass, students: list[UUID], monkeypatch: pytest.MonkeyPatch
) -> None:
    rendered = record_renders(monkeypatch)

    def sent() -> None:
        store(site.database, [Sent(students[0], OTHER, utc_now(), 0.0, code=f"{place}") for place in range(4)])

    def marked() -> None:
        with site.database.write() as db:
            row = {"class_id": made.id, "reason": "absente", "based_on": []}
            db.add(Override(account_id=students[3], exercise=EXERCISE, points=12.5, **row))

    def renamed() -> None:
        with site.database.write() as db:
            of = (Membership.class_id == made.id, Membership.account_id == students[5])
            db.execute(update(Membership).where(*of).values(family_name="Aaron", groups=["G"]))

    def given_less() -> None:
        with site.database.write() as db:
            db.delete(db.execute(select(Assignment).where(Assignment.class_id == made.id)).scalar_one())
        assign(site.database, made, OTHER, opened=timedelta(days=3))

    changes: tuple[Callable[[], None], ...] = (sent, marked, renamed, given_less)
    before = page(site, teacher, made)
    for change in changes:
        change()
        after = page(site, teacher, made)
        count = len(rendered)
        assert page(site, teacher, made) == after
        assert len(rendered) == count, "nothing is rendered again that has not changed"
        clear_caches()
        assert page(site, teacher, made) == after, change.__name__
        assert after != before, change.__name__
        before = after


def test_each_query_and_reader_has_their_own_fragment(site: Site, teacher: Person, made: SchoolClass) -> None:
    asked = ["", "?tri=bloques", "?tri=-nom", "?groupe=TP1", "?erreurs=toutes"]
    pages = [page(site, teacher, made, one) for one in asked]
    assert len(set(pages)) == 5
    assert [page(site, teacher, made, one) for one in asked] == pages
    helper = person(site, Role.teacher, "M. Roy")
    seat(site.database, made, helper.account, ClassRole.assistant)
    assert "recorriger<" in pages[0]
    assert "recorriger<" not in page(site, helper, made), (
        "who may not regrade is not offered to, though another one was"
    )


def test_times_follow_the_time_zone_of_the_school(
    site: Site, teacher: Person, made: SchoolClass, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = page(site, teacher, made).split('id="activite"')[1]
    monkeypatch.setattr(school_time, "_zones", list(school_time._zones))
    school_time.set_time_zone("America/Martinique")
    elsewhere = page(site, teacher, made).split('id="activite"')[1]
    clear_caches()
    assert page(site, teacher, made).split('id="activite"')[1] == elsewhere
    assert elsewhere != before
