"""What is said of dates that a teacher may not have meant; and that what a page tells is what counts, over HTTP."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from typing import Any
from uuid import UUID

import pytest
from sqlalchemy import update

from server.assignments.models import Assignment, Sitting
from server.base.app_services import get_service
from server.classes.models import SchoolClass
from server.course import Course
from server.database import utc_now
from server.identity.models import Role
from server.marks.loading import load_gradebook
from tests.support.classes import Person, new_class, person, seat
from tests.support.service import EXERCISE, Site

DAY, HOUR, MINUTE = timedelta(days=1), timedelta(hours=1), timedelta(minutes=1)


@pytest.fixture
def made(site: Site) -> tuple[Person, Person, str]:
    """A teacher, a student of their class, and the address of its assignments."""
    teacher = person(site, Role.teacher, "Mme Martin")
    school_class = new_class(site.database, teacher.account)
    ada = person(site, name="Ada Lovelace")
    seat(site.database, school_class, ada.account)
    return teacher, ada, f"/api/v1/classes/{school_class.id}/assignments"


def call(site: Site, who: Person, method: str, path: str, body: Any = None) -> Any:
    answer = site.client.request(method, path, json=body, headers=who.headers)
    assert answer.status_code in {200, 201}, answer.text
    return answer.json()


def text(when: datetime) -> str:
    return when.astimezone(UTC).isoformat()


def assignment(now: datetime, **values: Any) -> dict[str, Any]:
    row = {"title": "DM", "exercises": [{"exercise": EXERCISE, "weight": 1}], "opens_at": text(now - HOUR)}
    return row | {name: text(value) if isinstance(value, datetime) else value for name, value in values.items()}


def test_an_extension_never_leaves_less_than_the_class_has(site: Site, made: tuple[Person, Person, str]) -> None:
    teacher, ada, path = made
    now = utc_now().replace(microsecond=0)
    given = call(site, teacher, "POST", path, assignment(now, due_at=now + DAY, late={"per_day": 5}))
    one = f"{path}/{given['id']}"
    own = {"student": str(ada.id), "due_at": text(now + 2 * DAY), "reason": "malade"}
    assert call(site, teacher, "POST", f"{one}/exceptions", own)["warnings"] == []
    changed = call(site, teacher, "PATCH", one, {"due_at": text(now + 4 * DAY)})
    (warning,) = changed["warnings"]
    assert "Ada Lovelace : la date de remise accordée" in warning
    assert "ne prolonge plus rien" in warning
    seen = call(site, ada, "GET", one)
    assert datetime.fromisoformat(seen["due_at"]) == now + 4 * DAY
    assert seen["warnings"] == []
    rules = call(site, ada, "GET", f"{one}/rules")
    assert [said["origin"] for said in rules["why"]["due_at"]] == ["assignment", "student"]
    page = f"/classes/{path.split('/')[4]}/devoirs/{given['id']}"
    for end in ("", "/amenagements"):
        assert "ne prolonge plus rien" in teacher.browser(site).get(page + end).text


def test_an_earlier_date_is_the_teacher_s_choice_and_is_told(site: Site, made: tuple[Person, Person, str]) -> None:
    teacher, ada, path = made
    now = utc_now().replace(microsecond=0)
    given = call(site, teacher, "POST", path, assignment(now, due_at=now + 3 * DAY))
    one = f"{path}/{given['id']}"
    own = {"student": str(ada.id), "due_at": text(now + DAY)}
    (warning,) = call(site, teacher, "POST", f"{one}/exceptions", own)["warnings"]
    assert "Ada Lovelace a moins de temps que la classe" in warning
    assert datetime.fromisoformat(call(site, ada, "GET", one)["due_at"]) == now + DAY


SAID = [
    (
        "all past",
        {"opens_at": -3 * DAY, "due_at": -2 * DAY, "late": "refuse"},
        "Tout est déjà passé",
    ),
    ("due in the past", {"opens_at": -3 * DAY, "due_at": -2 * DAY}, "est déjà passée"),
    ("too long", {"closes_at": HOUR, "mode": "test", "duration_minutes": 180}, "personne n’aura tout son temps"),
    ("cut short", {"closes_at": 3 * HOUR, "mode": "test", "duration_minutes": 60}, "n’aura pas tout son temps"),
    ("never late", {"due_at": DAY, "closes_at": DAY, "late": {"per_day": 2}}, "ne s’appliquera jamais"),
    ("closes for nothing", {"due_at": DAY, "closes_at": 2 * DAY, "late": "refuse"}, "La fermeture ne change rien"),
    ("never shown", {"solution": "after_close"}, "ne sera jamais montré"),
    ("never ends", {"due_at": DAY, "mode": "test"}, "Rien ne met fin à ce contrôle"),
]


@pytest.mark.parametrize(("values", "said"), [row[1:] for row in SAID], ids=[row[0] for row in SAID])
def test_dates_that_do_not_do_what_they_seem_to_are_said(
    site: Site, made: tuple[Person, Person, str], values: dict[str, Any], said: str
) -> None:
    teacher, _, path = made
    now = utc_now()
    dates = {name: now + value if isinstance(value, timedelta) else value for name, value in values.items()}
    (warning,) = call(site, teacher, "POST", path, assignment(now, **dates))["warnings"]
    assert said in warning


def test_a_sitting_begun_in_time_counts_to_the_end_that_is_told(site: Site, made: tuple[Person, Person, str]) -> None:
    """Extra time goes past the due date; what is sent there, or saved and collected at the end, makes the mark."""
    teacher, ada, path = made
    now = utc_now()
    test = assignment(now, due_at=now + MINUTE, late="refuse", mode="test", duration_minutes=60)
    given = call(site, teacher, "POST", path, test)
    call(site, teacher, "POST", f"{path}/{given['id']}/exceptions", {"student": str(ada.id), "time_factor": 4})
    page = f"/classes/{path.split('/')[4]}/devoirs/{given['id']}"
    browser = ada.browser(site)
    assert browser.post(f"{page}/commencer").status_code == 303
    with site.database.write() as db:  # three hours later: past the date, within the own time
        db.execute(update(Assignment).values(due_at=now - 2 * HOUR, opens_at=now - 5 * HOUR))
        db.execute(update(Sitting).values(began_at=now - 3 * HOUR))
    assert "Fin le" in browser.get(f"{page}/composer").text
    sent = site.client.post(
        "/api/v1/submissions", json={"exercise": EXERCISE, "code": "outcome: ok"}, headers=ada.headers
    )
    assert sent.status_code == 202
    while site.worker.run_one():
        pass
    assert browser.post(f"{page}/rendre").status_code == 303
    with site.database.read() as db:
        school_class = db.get_one(SchoolClass, UUID(path.split("/")[4]))
        (row,) = load_gradebook(db, get_service(site.app, Course), school_class, utc_now()).rows
    assert [(mark.points, mark.exercises[0].days_late) for mark in row.marks] == [(20.0, 0)]
