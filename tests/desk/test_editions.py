"""A class keeps its edition of a module until its teacher copies it into another."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from types import MappingProxyType
from uuid import UUID

import pytest

from server.assignments.models import AssignedExercise
from server.base.app_services import add_services, get_service
from server.classes.models import SchoolClass
from server.course import Course
from server.identity.models import Role
from tests.desk.test_classes import stored, text_of
from tests.support.classes import assign, new_class, person, seat
from tests.support.service import Site

LEFT, KEPT = "l20/kabsch", "l20/poses"
NEWER = "L20, 2ᵉ édition"


@pytest.fixture
def two_editions(site: Site) -> Iterator[Site]:
    """The second has no kabsch."""
    course = get_service(site.app, Course)
    module = course.modules["l20"]
    exercises = tuple(replace(one, module="l20e2") for one in module.exercises if one.id != LEFT)
    newer = replace(module, slug="l20e2", exercises=exercises)
    add_services(site.app, Course(MappingProxyType({**course.modules, "l20e2": newer}), ()))
    yield site
    add_services(site.app, course)


def test_a_class_keeps_its_edition_until_it_is_copied(two_editions: Site) -> None:
    site = two_editions
    martin, ada, bob = person(site, Role.teacher, "Mme Martin"), person(site, name="Ada"), person(site, name="Bob")
    made = new_class(site.database, martin.account)
    seat(site.database, made, ada.account)
    assign(site.database, made, KEPT, LEFT, title="Deux")
    assign(site.database, made, LEFT, title="Un")
    teacher, member, stranger = (one.browser(site) for one in (martin, ada, bob))
    href = f"/classes/{made.id}"

    assert 'href="/l20e2"' not in text_of(member, "/").partition("<main")[2]
    assert 'href="/l20"' not in text_of(stranger, "/").partition("<main")[2]
    assert "Votre classe garde cette édition" in text_of(member, "/l20")
    assert "Votre classe travaille sur une autre édition" in text_of(member, "/l20e2")
    assert f"Une édition plus récente de ce module existe\u202f: {NEWER}" in text_of(stranger, "/l20")
    assert "édition de ce module" not in text_of(stranger, "/l20e2").partition("<main")[2]
    assert 'value="l20"' not in text_of(teacher, "/classes"), "a new class is of the last edition"

    settings = text_of(teacher, f"{href}/reglages")
    assert settings.count("du devoir «") == 2
    assert teacher.post(f"{href}/copier", data={"name": "PSI", "edition": "m9"}).status_code == 404
    wanted = {"name": "PSI", "edition": "l20e2", "eleves": "true", "semaines": "0"}
    there = UUID(teacher.post(f"{href}/copier", data=wanted).headers["location"].rpartition("/")[2])
    assert {one.id: one.module for one in stored(site, SchoolClass)} == {made.id: "l20", there: "l20e2"}
    given = sorted(one.exercise for one in stored(site, AssignedExercise))
    assert given == sorted([KEPT, LEFT, LEFT, "l20e2/poses"])
    home = text_of(member, "/").partition("<main")[2]
    assert 'href="/l20e2"' in home
    assert 'href="/l20"' in home
    teacher.post(f"{href}/archiver", data={"archiver": "true"})
    assert 'href="/l20"' not in text_of(member, "/").partition("<main")[2]


def test_one_edition_is_not_spoken_of(site: Site) -> None:
    martin = person(site, Role.teacher, "Mme Martin")
    made = new_class(site.database, martin.account)
    browser = martin.browser(site)
    for path in ("/", "/l20", f"/classes/{made.id}/reglages"):
        assert "édition" not in text_of(browser, path).partition("<main")[2].replace("expédition", "")
