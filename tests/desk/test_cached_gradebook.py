"""The cached body of a gradebook equals a fresh one after each change, for every query."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from sqlalchemy import update

from server.assignments.models import Assignment, Mode
from server.base import school_time
from server.classes.models import ClassRole, Membership
from server.database import utc_now
from server.identity.models import Role
from server.marks.models import Override
from tests.support.caches import clear_caches, record_renders
from tests.support.classes import Person, person, seat
from tests.support.marks import POSES, Term
from tests.support.service import Site

READ_AT = re.compile(r"notes sur 20, le <time.*?</time>")


def page(site: Site, reader: Person, term: Term, query: str = "") -> str:
    answer = reader.browser(site).get(f"/classes/{term.made.id}/carnet{query}")
    assert answer.status_code == 200
    assert READ_AT.search(answer.text)
    return READ_AT.sub("", answer.text)


@pytest.fixture
def term(site: Site) -> Term:
    return Term.begin(site.database)


@pytest.fixture
def martin(site: Site, term: Term) -> Person:
    return person(site, account=term.teacher)


def test_every_change_is_rendered_at_once(
    site: Site, term: Term, martin: Person, monkeypatch: pytest.MonkeyPatch
) -> None:
    rendered = record_renders(monkeypatch)
    term.assignment()
    test = term.assignment("Contrôle", {POSES: 1.0}, mode=Mode.test)
    ada = term.student("Ada", "Lovelace", groups=["TP1"])
    first = term.send(ada, POSES, 8)

    def setting(statement: object) -> Callable[[], None]:
        def change() -> None:
            with site.database.write() as db:
                db.execute(statement)  # type: ignore[call-overload]

        return change

    def marked() -> None:
        with site.database.write() as db:
            row = {"class_id": term.made.id, "reason": "oral", "based_on": []}
            db.add(Override(account_id=ada.id, exercise=POSES, points=18.0, **row))

    changes = {
        "graded anew": lambda: [term.grade(first, 14), None][1],
        "sent": lambda: [term.send(ada, POSES, 16.25), None][1],
        "marked": marked,
        "released": setting(update(Assignment).where(Assignment.id == test.id).values(released_at=utc_now())),
        "title": setting(update(Assignment).values(title="DM")),
        "renamed": setting(update(Membership).where(Membership.account_id == ada.id).values(family_name="Byron")),
        "in another group": setting(update(Membership).where(Membership.account_id == ada.id).values(groups=["TP2"])),
        "joined": lambda: [term.student("Alan", "Turing"), None][1],
    }
    before = page(site, martin, term)
    for name, change in changes.items():
        change()
        after = page(site, martin, term)
        count = len(rendered)
        assert page(site, martin, term) == after
        assert len(rendered) == count, "nothing is rendered again that has not changed"
        clear_caches()
        assert page(site, martin, term) == after, name
        assert after != before, name
        before = after


def test_each_query_and_reader_has_their_own_fragment(site: Site, term: Term, martin: Person) -> None:
    given = term.assignment()
    for number, points in enumerate((8, 14)):
        term.send(term.student("Ada", f"Lovelace {number}", groups=[f"TP{number}"]), POSES, points)
    detail = f"?devoir={given.id}"
    asked = ["", "?tri=moyenne", "?groupe=TP1", "?colonne=moyenne", detail, f"{detail}&tri={POSES}"]
    pages = [page(site, martin, term, one) for one in asked]
    assert len(set(pages)) == len(asked)
    assert [page(site, martin, term, one) for one in asked] == pages
    helper = person(site, Role.teacher, "M. Roy")
    seat(site.database, term.made, helper.account, ClassRole.assistant)
    assert "recorriger<" in pages[4]
    assert "recorriger<" not in page(site, helper, term, detail), (
        "who may not regrade is not offered to, though another one was"
    )


def test_dates_follow_the_time_zone_of_the_school(
    site: Site, term: Term, martin: Person, monkeypatch: pytest.MonkeyPatch
) -> None:
    term.assignment(due_at=utc_now().replace(hour=2))
    before = page(site, martin, term)
    monkeypatch.setattr(school_time, "_zones", list(school_time._zones))
    school_time.set_time_zone("America/Martinique")
    elsewhere = page(site, martin, term)
    clear_caches()
    assert page(site, martin, term) == elsewhere
    assert elsewhere != before
