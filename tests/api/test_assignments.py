"""Assignments by the HTTP interface (contract, section 6): made, changed, exempted from; what students see of them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any
from uuid import uuid4

import pytest

from server.assignments.models import Exemption
from server.audit.models import AuditAction, AuditEvent
from server.classes import service as classes
from server.classes.models import ClassRole, Status
from server.database import utc_now
from server.identity.models import Role
from server.rights.models import Right
from tests.support.classes import Person, new_class, person, seat
from tests.support.service import Site

NOW = utc_now().replace(microsecond=0)
DAY = timedelta(days=1)
GOOD: dict[str, Any] = {
    "title": "Se repérer",
    "exercises": [{"exercise": "l20/poses", "weight": 2.0}, {"exercise": "l20/calcul_odometrie", "weight": 1.0}],
    "opens_at": (NOW - DAY).isoformat(),
    "due_at": (NOW + 3 * DAY).isoformat(),
    "closes_at": (NOW + 10 * DAY).isoformat(),
    "late": {"per_day": 2.0},
    "mode": "practice",
    "counts": "last",
}


@dataclass
class School:
    """A class with a teacher, an assistant, two students; `ada` is in group TP1."""

    site: Site
    martin: Person
    helper: Person
    ada: Person
    bob: Person
    url: str

    def call(self, who: Person, method: str, path: str = "", status: int = 200, *, body: Any = None) -> Any:
        content = json.dumps(body) if body is not None else None  # ASCII: a lone surrogate gets there as it is
        headers = who.headers | {"Content-Type": "application/json"}
        answer = self.site.client.request(method, self.url + path, headers=headers, content=content)
        assert answer.status_code == status, answer.text
        return answer.json() if answer.content else None

    def make(self, status: int = 201, **changes: Any) -> Any:
        return self.call(self.martin, "POST", status=status, body=GOOD | changes)

    def events(self) -> list[AuditEvent]:
        with self.site.database.read() as db:
            return db.query(AuditEvent).order_by(AuditEvent.at).all()


@pytest.fixture
def school(site: Site) -> School:
    martin, helper, ada, bob = person(site, Role.teacher, "Mme Martin"), person(site), person(site), person(site)
    made = new_class(site.database, martin.account)
    seat(site.database, made, helper.account, ClassRole.assistant)
    seat(site.database, made, ada.account, groups=["TP1"])
    seat(site.database, made, bob.account)
    return School(site, martin, helper, ada, bob, f"/api/v1/classes/{made.id}/assignments")


def same(left: str, right: str) -> bool:
    return datetime.fromisoformat(left) == datetime.fromisoformat(right)


def test_an_assignment_is_made_read_changed_and_taken_back(school: School) -> None:
    made = school.make()
    for name in ("title", "exercises", "late", "mode", "counts"):
        assert made[name] == GOOD[name]
    assert all(same(made[name], GOOD[name]) for name in ("opens_at", "due_at", "closes_at"))
    assert (made["weight"], made["hints"], made["time_factor"]) == (1.0, "usual", None)
    path = f"/{made['id']}"
    assert school.call(school.helper, "GET", path) == made
    assert school.call(school.martin, "GET") == [made]

    changed = school.call(school.martin, "PATCH", path, body={"due_at": None, "late": "refuse", "title": " Deux  "})
    assert changed == made | {"due_at": None, "late": "refuse", "title": "Deux"}
    assert school.call(school.martin, "PATCH", path, body={}) == changed
    swapped = school.call(school.martin, "PATCH", path, body={"exercises": [{"exercise": "l20/calcul_odometrie"}]})
    assert [one["exercise"] for one in swapped["exercises"]] == ["l20/calcul_odometrie"]
    school.call(school.martin, "DELETE", path, 204)
    school.call(school.martin, "GET", path, 404)
    assert school.call(school.martin, "GET") == []

    kinds = [AuditAction(one.what) for one in school.events()]
    assert kinds == [AuditAction.assignment_made, *[AuditAction.assignment_changed] * 2, AuditAction.assignment_deleted]
    first = school.events()[1]
    assert (first.before["late"], first.after["late"]) == ("penalty", "refuse")
    assert first.before.keys() | first.after.keys() == {"title", "due_at", "late", "late_per_day"}


BAD: list[tuple[str, dict[str, Any], str]] = [
    ("title", {"title": "  "}, "titre de 1 à 200"),
    ("title", {"title": "x" * 201}, "titre de 1 à 200"),
    ("title", {"title": "a\x07b"}, "U+0007"),
    ("exercises", {"exercises": []}, "au moins un exercice"),
    ("exercises", {"exercises": [{"exercise": "l99/rien"}]}, "n’est pas du module"),
    ("exercises", {"exercises": [{"exercise": "l20/poses"}] * 2}, "donné deux fois"),
    ("exercises", {"exercises": [{"exercise": "l20/poses", "weight": 0}]}, "plus grand que 0"),
    ("exercises", {"exercises": [{"exercise": "l20/poses", "weight": 1e9}]}, "plus grand que 0"),
    ("weight", {"weight": -1}, "plus grand que 0"),
    ("due_at", {"due_at": GOOD["opens_at"].replace(str(NOW.year), "2001")}, "avant l’ouverture"),
    ("closes_at", {"closes_at": (NOW + 2 * DAY).isoformat()}, "avant la date de remise"),
    ("closes_at", {"closes_at": "2400-01-01T00:00:00Z"}, "entre 2000 et 2199"),
    ("late", {"late": {"per_day": 0}}, "plus de 0, et 20 au plus"),
    ("late", {"late": {"per_day": 5e-324}}, "plus de 0, et 20 au plus"),
    ("weight", {"weight": 10**300}, "plus grand que 0"),
    ("duration_minutes", {"duration_minutes": 10**40, "mode": "test"}, "nombre de minutes"),
    ("late", {"late": {"per_day": 20.5}}, "plus de 0, et 20 au plus"),
    ("due_at", {"due_at": None}, "demande une date de remise"),
    ("duration_minutes", {"duration_minutes": 60}, "Seul un contrôle"),
    ("duration_minutes", {"duration_minutes": 0, "mode": "test"}, "nombre de minutes"),
]
MALFORMED: list[tuple[str, dict[str, Any]]] = [
    ("due_at", {"due_at": "2026-03-23T18:00:00"}),
    ("due_at", {"due_at": "demain"}),
    ("due_at", {"due_at": 12}),
    ("due_at", {"due_at": "0001-01-01T00:00:00+14:00"}),
    ("due_at", {"due_at": "9" * 9000}),
    ("mode", {"mode": "exam"}),
    ("late", {"late": "maybe"}),
    ("weight", {"weight": "2"}),
    ("title", {"title": None}),
    ("weight", {"weight": 10**400}),
    ("exercises", {"exercises": [{"exercise": "\ud800"}]}),
    ("title", {"title": "a\ud800"}),
    ("exercises", {"exercises": [{"exercise": "x" * 201}]}),
    ("released_at", {"released_at": None}),
]


def test_what_is_wrong_is_told_with_its_place_and_nothing_is_written(school: School) -> None:
    for field, change, told in BAD:
        refused = school.make(422, **change)
        assert told in refused["detail"], (field, refused)
        assert f"#/{field}" in [one["pointer"] for one in refused["errors"]], (field, refused)
    for field, change in MALFORMED:
        refused = school.make(422, **change)
        assert any(one["pointer"].startswith(f"#/{field}") for one in refused["errors"]), (field, refused)
    assert school.site.client.post(
        school.url, headers=school.martin.headers, content=b'{"title": NaN, "weight": Infinity}'
    ).status_code in {400, 422}
    several = school.make(422, title="", weight=0)
    assert len(several["errors"]) == 2
    assert school.call(school.martin, "GET") == []
    assert school.events() == []


def test_who_may_not_is_told_which_right_is_missing(school: School) -> None:
    made = school.make()
    stranger, pending = person(school.site, Role.teacher), person(school.site)
    with school.site.database.read() as db:
        (joined,) = classes.repository.load_joined_classes(db, school.martin.id)
    seat(school.site.database, joined.school_class, pending.account, status=Status.pending)
    for who in (school.helper, school.ada):
        for method, path in (("POST", ""), ("PATCH", f"/{made['id']}"), ("DELETE", f"/{made['id']}")):
            refused = school.call(who, method, path, 403, body=GOOD)
            assert Right.manage_assignments.value in refused["detail"]
    school.call(school.ada, "GET", f"/{made['id']}/exceptions", 403)
    school.call(pending, "GET", "", 403)
    for path in ("", f"/{made['id']}", f"/{made['id']}/rules", f"/{made['id']}/exceptions"):
        school.call(stranger, "GET", path, 404)
    for name in (uuid4(), "zut", "é" * 500):
        school.call(school.martin, "GET", f"/{name}", 404)
        school.call(school.martin, "DELETE", f"/{made['id']}/exceptions/{name}", 404)
    other = new_class(school.site.database, school.martin.account, "PSI")
    elsewhere = f"/api/v1/classes/{other.id}/assignments/{made['id']}"
    assert school.site.client.get(elsewhere, headers=school.martin.headers).status_code == 404


def test_a_student_sees_their_own_dates_and_never_the_reason(school: School) -> None:
    made = school.make()
    path = f"/{made['id']}"
    later = (NOW + 20 * DAY).isoformat()
    given = school.call(
        school.martin, "POST", f"{path}/exceptions", 201, body={"group": "TP1", "due_at": later, "reason": "grippe"}
    )
    own = school.call(school.ada, "GET", path)
    assert same(own["due_at"], later)
    assert same(own["closes_at"], later), "the end never comes before the due date"
    assert (own["time_factor"], own["excused"]) == (1.0, False)
    assert school.call(school.ada, "GET") == [own]
    assert same(school.call(school.bob, "GET", path)["due_at"], GOOD["due_at"])

    rules = school.call(school.ada, "GET", f"{path}/rules")
    assert [(one["origin"], one["group"]) for one in rules["why"]["due_at"]] == [("label", "TP1"), ("assignment", None)]
    assert rules["why"]["closes_at"][0]["origin"] == "adjusted"
    assert "grippe" not in str(rules) + str(own)
    told = school.call(school.helper, "GET", f"{path}/rules?student={school.ada.id}")
    assert told["why"]["due_at"][0]["reason"] == "grippe"
    assert told | {"why": None} == rules | {"why": None}
    school.call(school.ada, "GET", f"{path}/rules?student={school.bob.id}", 403)
    school.call(school.martin, "GET", f"{path}/rules?student={uuid4()}", 404)
    school.call(school.martin, "GET", f"{path}/rules", 404)

    school.call(school.martin, "DELETE", f"{path}/exceptions/{given['id']}", 204)
    school.call(school.martin, "DELETE", f"{path}/exceptions/{given['id']}", 204)
    assert same(school.call(school.ada, "GET", path)["due_at"], GOOD["due_at"])
    (listed,) = school.call(school.martin, "GET", f"{path}/exceptions")
    assert listed["revoked_at"] is not None
    assert [one.what for one in school.events()].count(AuditAction.exemption_revoked) == 1
    assert {one.reason for one in school.events() if one.what == AuditAction.exemption_made} == {"grippe"}


def test_an_exception_that_says_nothing_or_of_nobody_is_refused(school: School) -> None:
    path = f"/{school.make()['id']}/exceptions"
    later = {"due_at": GOOD["closes_at"]}
    ada = {"student": str(school.ada.id)}
    for body in (
        later,
        ada,
        {**ada, "group": "TP1", **later},
        {"group": "TP9", **later},
        {"student": str(school.helper.id), **later},
        {"student": str(uuid4()), **later},
        {**ada, "time_factor": 0.5},
        {**ada, "time_factor": 4.1},
        {**ada, "due_at": (NOW - 9 * DAY).isoformat()},
        {**ada, "opens_at": GOOD["closes_at"], "due_at": GOOD["due_at"]},
        {**ada, "due_at": GOOD["closes_at"], "closes_at": GOOD["due_at"]},
        {**ada, **later, "reason": "x" * 2001},
        {**ada, **later, "reason": "a\0b"},
        {"group": "\ud800", **later},
        {**ada, "due_at": "2026-03-23T18:00:00"},
        {"student": "zut", **later},
    ):
        refused = school.call(school.martin, "POST", path, 422, body=body)
        assert refused["errors"], body
    with school.site.database.read() as db:
        assert db.query(Exemption).count() == 0


def test_the_exercises_of_a_test_stay_unknown_until_it_opens(school: School) -> None:
    soon = {"opens_at": (NOW + DAY).isoformat(), "duration_minutes": 60, "mode": "test"}
    path = f"/{school.make(**soon)['id']}"
    assert school.call(school.ada, "GET", path)["exercises"] is None
    assert school.call(school.helper, "GET", path)["exercises"] == GOOD["exercises"]
    early = {"student": str(school.ada.id), "opens_at": (NOW - DAY).isoformat(), "time_factor": 1.33}
    school.call(school.martin, "POST", f"{path}/exceptions", 201, body=early)
    assert school.call(school.ada, "GET", path)["exercises"] == GOOD["exercises"]
    assert school.call(school.ada, "GET", f"{path}/rules")["duration_seconds"] == pytest.approx(60 * 60 * 1.33)
    assert school.call(school.bob, "GET", path)["exercises"] is None
    upcoming = f"/{school.make(opens_at=soon['opens_at'])['id']}"
    assert school.call(school.ada, "GET", upcoming)["exercises"] == GOOD["exercises"]


def test_an_archived_class_stays_as_it_is(school: School) -> None:
    path = f"/{school.make()['id']}"
    with school.site.database.write() as db:
        (joined,) = classes.repository.load_joined_classes(db, school.martin.id)
        classes.archive_class(joined.school_class)
    school.make(409)
    school.call(school.martin, "PATCH", path, 409, body={"title": "x"})
    school.call(school.martin, "DELETE", path, 409)
    body = {"student": str(school.ada.id), "excused": True}
    school.call(school.martin, "POST", f"{path}/exceptions", 409, body=body)
    assert school.call(school.ada, "GET", path)["title"] == GOOD["title"]
