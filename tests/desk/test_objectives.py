"""The pages of objectives: a class, a student, the conseil de classe, and the mistakes as files."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable
from datetime import timedelta

import pytest
from python_calamine import CalamineWorkbook
from sqlalchemy import update

from server.assignments.models import Mode
from server.classes.models import Membership, SchoolClass, Status
from server.database import utc_now
from server.identity.models import Role
from tests.desk.test_classes import text_of
from tests.support.caches import clear_caches
from tests.support.classes import Person, assign, new_class, person, seat
from tests.support.counting import Counted
from tests.support.crowd import Sent, seated, store
from tests.support.service import EXERCISE, Site

WRONG, WRONG_TITLE = "rotation_oubliee", "La rotation est oubliée"


@pytest.fixture
def martin(site: Site) -> Person:
    return person(site, Role.teacher, "Mme Martin")


@pytest.fixture
def made(site: Site, martin: Person) -> SchoolClass:
    return new_class(site.database, martin.account)


def send(site: Site, student: Person, *attempts: tuple[float, str | None], exercise: str = EXERCISE) -> None:
    now = utc_now()
    store(
        site.database,
        [
            Sent(student.id, exercise, now - timedelta(minutes=9 - turn), score, name, f"x = {turn}\n")
            for turn, (score, name) in enumerate(attempts)
        ],
    )


def test_the_pages_say_who_has_mastered_what(site: Site, martin: Person, made: SchoolClass) -> None:
    weak, done = person(site, Role.student, "Ada Lovelace"), person(site, Role.student, "Alan Turing")
    for student in (weak, done):
        seat(site.database, made, student.account)
    send(site, weak, (0.25, WRONG), (0.25, WRONG))
    send(site, done, (1.0, None))
    browser, href = martin.browser(site), f"/classes/{made.id}"
    text = text_of(browser, f"{href}/objectifs")
    row = text.split('id="poses"')[1].split("</li>")[0]
    assert "1 acquis, 0 en cours, 1 à retravailler, 0 pas commencé" in row
    assert f'<a href="{href}/eleves/{weak.id}/objectifs">Ada Lovelace</a>' in row
    assert f"{href}/erreurs/{EXERCISE}/{WRONG}" in row
    assert "%" not in re.sub(r"inline-size: [\d.]+%", "", row), "no percentage of two students"
    page = text_of(browser, f"{href}/eleves/{weak.id}/objectifs")
    assert "1 à retravailler" in page
    assert WRONG_TITLE in page
    own = text_of(weak.browser(site), f"{href}/objectifs")
    assert "Reprendre&nbsp;: Composer" in own
    assert f"Votre dernière erreur&nbsp;: {WRONG_TITLE}" in own
    assert "Alan" not in own, "no student is compared with another"
    sheet = text_of(browser, f"{href}/conseil")
    assert "À retravailler : composer des poses. Erreur persistante" in sheet.replace("\u202f", " ").replace(
        "\u00a0", " "
    )
    assert sheet.count("1 objectif acquis sur 1 commencé") == 1
    for path in (f"eleves/{weak.id}/objectifs", "conseil", "erreurs/fichier"):
        assert text_of(weak.browser(site), f"{href}/{path}", 403)
    assert text_of(browser, f"{href}/conseil?depuis=hier", 422)


def test_the_cached_page_of_a_class_equals_a_fresh_one_after_each_change(
    site: Site, martin: Person, made: SchoolClass
) -> None:
    ada, alan = person(site, Role.student, "Ada Lovelace"), person(site, Role.student, "Alan Turing")
    for student in (ada, alan):
        seat(site.database, made, student.account)
    send(site, alan, (0.25, WRONG), (0.25, WRONG))

    def set_member(**values: object) -> None:
        with site.database.write() as db:
            db.execute(update(Membership).where(Membership.account_id == ada.id).values(**values))

    changes: dict[str, Callable[[], object]] = {
        "verdict": lambda: send(site, ada, (0.25, WRONG)),
        "solved": lambda: send(site, ada, (1.0, None)),
        "renamed": lambda: set_member(given_name="Augusta", family_name="Byron"),
        "assigned to a group": lambda: assign(site.database, made, EXERCISE, "l20/odometrie", groups=["TP1"]),
        "in the group": lambda: set_member(groups=["TP1"]),
        "gone": lambda: set_member(status=Status.left),
    }
    browser, href = martin.browser(site), f"/classes/{made.id}/objectifs"
    before = text_of(browser, href)
    for name, change in changes.items():
        change()
        after = text_of(browser, href)
        clear_caches()
        assert text_of(browser, href) == after, name
        assert name == "in the group" or after != before, name
        before = after


def test_a_test_that_is_not_released_stays_out_of_the_students_own_page(
    site: Site, martin: Person, made: SchoolClass
) -> None:
    ada = person(site, Role.student, "Ada")
    seat(site.database, made, ada.account)
    assign(site.database, made, EXERCISE, mode=Mode.test)
    send(site, ada, (0.25, WRONG), (0.25, WRONG))
    own = text_of(ada.browser(site), f"/classes/{made.id}/objectifs")
    assert WRONG_TITLE not in own
    assert "retravailler." not in own.split("Quand un objectif")[0]
    assert WRONG_TITLE in text_of(martin.browser(site), f"/classes/{made.id}/eleves/{ada.id}/objectifs")


def test_mistakes_are_files(site: Site, martin: Person, made: SchoolClass) -> None:
    ada = person(site, Role.student, "Ada")
    seat(site.database, made, ada.account)
    send(site, ada, (0.25, WRONG), (0.25, WRONG), (0.5, None))
    browser, href = martin.browser(site), f"/classes/{made.id}/erreurs/fichier"
    text = browser.get(f"{href}?format=csv").content.decode("utf-8-sig")
    header, row = csv.reader(io.StringIO(text), delimiter=";")
    found = dict(zip(header, row, strict=True))
    assert (found["Erreur"], found["Objectif"]) == (WRONG_TITLE, "Composer des poses")
    assert (found["État"], found["Essais"]) == ("corrigée", "2")
    book = CalamineWorkbook.from_object(io.BytesIO(browser.get(href).content))
    assert book.sheet_names == ["Erreurs", "Objectifs", "Explications"]
    assert "en cours" in book.get_sheet_by_name("Objectifs").to_python()[1]


def test_a_page_takes_as_many_queries_for_many_as_for_few(site: Site, martin: Person) -> None:
    counts = []
    for size in (2, 9):
        made = new_class(site.database, martin.account)
        students = seated(site.database, made, size)
        store(site.database, [Sent(student, EXERCISE, utc_now(), 0.25, WRONG) for student in students])
        browser = martin.browser(site)
        text_of(browser, f"/classes/{made.id}/objectifs")
        with Counted(site.database) as counted:
            text_of(browser, f"/classes/{made.id}/objectifs")
        counts.append(len(counted.statements))
    assert counts[0] == counts[1]
