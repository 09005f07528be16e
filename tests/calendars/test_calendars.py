"""A person's calendar has their own dates, at an address that only they have."""

from __future__ import annotations

import re
from datetime import datetime, timedelta
from typing import Any

from icalendar import Calendar
from sqlalchemy import select, update

from server.assignments.models import Exemption, LatePolicy, Mode, PastRules
from server.calendars.models import CalendarAddress
from server.classes.models import ClassRole, SchoolClass, Status
from server.database import utc_now
from server.identity.models import Account, Role
from tests.support.classes import Person, assign, new_class, person, seat
from tests.support.service import EXERCISE, Site

NOW = utc_now().replace(microsecond=0)
SOON, LATER = NOW + timedelta(days=2), NOW + timedelta(days=9)
LONG_TITLE = "Repérage, cartes ; et graphes \\ é" * 5


def address_of(site: Site, someone: Person) -> str:
    page = someone.browser(site).post("/compte/agenda")
    found = re.search(r"/agenda/[\w-]+\.ics", page.text)
    assert found, page.text
    return found[0]


def events(site: Site, address: str) -> dict[str, Any]:
    site.client.cookies.clear()
    answer = site.client.get(address)
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == "text/calendar; charset=utf-8"
    assert "set-cookie" not in answer.headers
    return {str(event["SUMMARY"]): event for event in Calendar.from_ical(answer.content).walk("VEVENT")}


def start(event: Any) -> datetime:
    when: datetime = event.decoded("DTSTART")
    return when


def the_class(site: Site) -> tuple[SchoolClass, Person, Person, Person]:
    teacher, ada, bob = person(site, Role.teacher, "Claire"), person(site), person(site, name="Bob")
    made = new_class(site.database, teacher.account, "MPSI")
    seat(site.database, made, ada.account, groups=["TP1"])
    seat(site.database, made, bob.account)
    return made, teacher, ada, bob


def exempt(site: Site, **values: Any) -> None:
    with site.database.write() as db:
        db.add(Exemption(**values))


def test_each_has_their_own_dates(site: Site) -> None:
    made, teacher, ada, bob = the_class(site)
    td = assign(site.database, made, EXERCISE, title=LONG_TITLE, due_at=SOON, closes_at=LATER)
    exempt(site, assignment_id=td.id, account_id=ada.id, due_at=SOON + timedelta(days=1), reason="malade")
    skipped = assign(site.database, made, title="Oral", due_at=SOON, late=LatePolicy.refuse, closes_at=LATER)
    exempt(site, assignment_id=skipped.id, label="TP1", excused=True)
    limit, closing, oral = (
        f"Date limite : {LONG_TITLE} (MPSI)",
        f"Fermeture : {LONG_TITLE} (MPSI)",
        "Date limite : Oral (MPSI)",
    )
    found = {someone.account.name: events(site, address_of(site, someone)) for someone in (teacher, ada, bob)}
    assert set(found["Ada"]) == {limit, closing}
    assert set(found["Bob"]) == set(found["Claire"]) == {limit, closing, oral}
    assert start(found["Ada"][limit]) == SOON + timedelta(days=1)
    assert start(found["Bob"][limit]) == start(found["Claire"][limit]) == SOON
    assert "aménagement" in found["Ada"][limit]["DESCRIPTION"]
    assert "aménagement" not in found["Bob"][limit]["DESCRIPTION"]
    assert "malade" not in str(found), "the reason is for the staff, and calendars are kept elsewhere"
    assert "Ada" not in str(found["Claire"])
    assert found["Ada"][limit]["UID"] == found["Bob"][limit]["UID"]


def test_a_test_is_an_event_and_its_published_results_another(site: Site) -> None:
    made, _, ada, _ = the_class(site)
    row = {"mode": Mode.test, "opened": NOW - SOON, "closes_at": SOON + timedelta(hours=4), "duration_minutes": 90}
    assign(site.database, made, title="Interro", **row)
    assign(site.database, made, title="Ancien", mode=Mode.test, opened=timedelta(days=30), released_at=NOW)
    found = events(site, address_of(site, ada))
    assert set(found) == {
        "Contrôle : Interro (MPSI)", "Ouverture du contrôle : Ancien (MPSI)", "Résultats publiés : Ancien (MPSI)",
    }  # fmt: skip
    test = found["Contrôle : Interro (MPSI)"]
    assert test.decoded("DTEND") == SOON + timedelta(hours=4)
    assert "Durée : 1 h 30." in test["DESCRIPTION"]


def test_a_change_keeps_the_uid_and_raises_the_sequence(site: Site) -> None:
    made, _, ada, _ = the_class(site)
    td = assign(site.database, made, title="TD", due_at=SOON)
    address = address_of(site, ada)
    before = events(site, address)["Date limite : TD (MPSI)"]
    with site.database.write() as db:
        row = db.merge(td)
        old = {name: getattr(row, name) for name in ("opens_at", "due_at", "closes_at", "late", "late_per_day")}
        row.past_rules = (PastRules(until=utc_now(), duration_minutes=None, **old),)
        row.due_at = LATER
    after = events(site, address)["Date limite : TD (MPSI)"]
    assert after["UID"] == before["UID"]
    assert after["SEQUENCE"] == before["SEQUENCE"] + 1
    assert after.decoded("DTSTAMP") >= before.decoded("DTSTAMP")
    assert start(after) == LATER


def test_only_the_last_address_is_one_and_only_its_digest_is_stored(site: Site) -> None:
    _, _, ada, _ = the_class(site)
    first = address_of(site, ada)
    second = address_of(site, ada)
    assert site.client.get(first).status_code == 404
    assert site.client.get(second).status_code == 200
    with site.database.read() as db:
        (row,) = db.execute(select(CalendarAddress)).scalars()
    assert row.token_digest not in second
    assert site.client.get(f"/agenda/{row.token_digest}.ics").status_code == 404
    assert "elle ne sera plus jamais affichée" not in ada.browser(site).get("/compte").text
    with site.database.write() as db:
        db.execute(update(Account).where(Account.id == ada.id).values(disabled_at=utc_now()))
    assert site.client.get(second).status_code == 404
    with site.database.write() as db:
        db.execute(update(Account).where(Account.id == ada.id).values(disabled_at=None))
    assert ada.browser(site).post("/compte/agenda/supprimer").status_code == 303
    assert site.client.get(second).status_code == 404


def test_nothing_of_a_class_that_one_has_left_or_asks_to_enter(site: Site) -> None:
    made, _, ada, bob = the_class(site)
    assign(site.database, made, title="TD", due_at=SOON)
    asked = new_class(site.database, person(site, Role.teacher).account, "PSI")
    assign(site.database, asked, title="DM", due_at=SOON)
    seat(site.database, asked, ada.account, status=Status.pending)
    seat(site.database, made, bob.account, status=Status.left)
    seat(site.database, asked, bob.account, ClassRole.assistant)
    assert set(events(site, address_of(site, ada))) == {"Date limite : TD (MPSI)"}
    assert set(events(site, address_of(site, bob))) == {"Date limite : DM (PSI)"}


def test_an_unchanged_calendar_is_not_sent_again(site: Site) -> None:
    made, _, ada, _ = the_class(site)
    assign(site.database, made, title="TD", due_at=SOON)
    address = address_of(site, ada)
    first = site.client.get(address)
    again = site.client.get(address, headers={"If-None-Match": first.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    assert first.headers["cache-control"].startswith("private")
    assign(site.database, made, title="TD 2", due_at=SOON)
    assert site.client.get(address, headers={"If-None-Match": first.headers["etag"]}).status_code == 200


def test_a_guest_has_no_address(site: Site) -> None:
    guest = person(site, Role.guest)
    assert guest.browser(site).post("/compte/agenda").status_code == 403
