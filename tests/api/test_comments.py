"""What is said of submissions, over the HTTP interface."""

from __future__ import annotations

from typing import Any
from uuid import uuid4

import pytest

from server.identity.models import Role
from tests.support.classes import Person, new_class, person, seat
from tests.support.service import Site

CODE = "x = 1\ny = 2  # outcome: wrong_answer\n"


@pytest.fixture
def people(site: Site) -> tuple[Person, Person]:
    """A student, and who teaches them."""
    teacher, ada = person(site, Role.teacher, "Mme Martin"), person(site)
    seat(site.database, new_class(site.database, teacher.account), ada.account)
    return ada, teacher


def send(site: Site, by: Person, code: str = CODE) -> str:
    sent = site.submit(by.headers, code)
    assert site.worker.run_one()
    return f"/api/v1/submissions/{sent['id']}/comments"


def call(site: Site, by: Person, method: str, path: str, status: int, json: Any = None) -> Any:
    answer = site.client.request(method, path, headers=by.headers, json=json)
    assert answer.status_code == status, answer.text
    return answer.json()


def test_a_thread_over_the_interface(site: Site, people: tuple[Person, Person]) -> None:
    ada, teacher = people
    path = send(site, ada)
    made = call(site, ada, "POST", path, 201, {"text": "Pourquoi ?", "check": "b"})
    assert (made["check"], made["state"], made["lines"], made["fate"]) == ("b", "open", None, "carried")
    answered = call(site, teacher, "POST", path, 201, {"text": "Voyez x.", "thread": made["id"]})
    assert [(one["author"], one["staff"], one["mine"]) for one in answered["messages"]] == [
        ("Ada", False, False),
        ("Mme Martin", True, True),
    ]
    assert call(site, ada, "PATCH", f"{path}/{made['id']}", 200, {"state": "settled"})["state"] == "settled"
    assert call(site, ada, "PATCH", f"{path}/{made['id']}", 200, {"state": "open"})["state"] == "answered"
    call(site, teacher, "POST", path, 201, {"text": "Ici.", "lines": [2, 2]})
    later = call(site, ada, "GET", send(site, ada, "# outcome: wrong_answer\n" + CODE), 200)
    assert [(one["lines"], one["fate"]) for one in later] == [([3, 3], "carried")]


def test_what_is_wrong_is_refused_with_its_place(site: Site, people: tuple[Person, Person]) -> None:
    ada, teacher = people
    path = send(site, ada)
    made = call(site, ada, "POST", path, 201, {"text": "Pourquoi ?"})
    for body in (
        {},
        {"text": ""},
        {"text": "x" * 10**5},
        {"text": "x", "lines": [1]},
        {"text": "x", "lines": [2, 1]},
        {"text": "x", "lines": [0, 1]},
        {"text": "x", "lines": ["1", "2"]},
        {"text": "x", "lines": [1, 10**12]},
        {"text": "x", "check": "zut"},
        {"text": "x", "check": "b", "lines": [1, 1]},
        {"text": "x", "thread": "zut"},
        {"text": "x", "tone": "y"},
    ):
        call(site, ada, "POST", path, 422, body)
    headers = {**ada.headers, "Content-Type": "application/json"}
    assert site.client.post(path, content=b'{"text": "\\ud800"}', headers=headers).status_code in {400, 422}
    call(site, ada, "POST", path, 404, {"text": "x", "thread": str(uuid4())})
    call(site, ada, "PATCH", f"{path}/{made['id']}", 422, {"state": "answered"})
    call(site, ada, "PATCH", f"{path}/zut", 404, {"state": "open"})
    other = send(site, teacher)
    call(site, teacher, "POST", other, 404, {"text": "x", "thread": made["id"]})
    call(site, teacher, "PATCH", f"{other}/{made['id']}", 404, {"state": "settled"})
    call(site, teacher, "POST", other, 409, {"text": "À moi-même"})
    assert len(call(site, ada, "GET", path, 200)) == 1
