"""The list of a course: read in pages of its platform alone, shown, then given as seats."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any

import pytest
from sqlalchemy import select

from server.classes.models import Membership, SchoolClass
from server.federation.models import ProviderContext
from server.identity.models import Account, FederatedIdentity
from tests.support.platforms import ASSISTANT, INSTRUCTOR, LEARNER, Browser, Platform
from tests.support.service import Site


def listed(subject: str, roles: Sequence[str] = (LEARNER,), **more: Any) -> dict[str, Any]:
    return {"user_id": subject, "roles": [*roles], "status": "Active", "name": f"Nom {subject}", **more}


class People:
    """Answers with these people, two a page."""

    def __init__(self, *people: Any) -> None:
        self.people, self.next = list(people), "https://moodle.example/members"

    def handle(
        self, _method: str, url: str, headers: Mapping[str, str], _content: bytes
    ) -> tuple[int, Mapping[str, str], bytes]:
        assert headers["Authorization"] == "Bearer jeton"
        start = int((re.findall(r"[?&]from=(\d+)", url) or ["0"])[-1])
        link = {"link": f'<{self.next}?from={start + 2}>; rel="next"'} if start + 2 < len(self.people) else {}
        return 200, link, json.dumps({"id": url, "members": self.people[start : start + 2]}).encode()


class Teacher:
    """A teacher whose course is tied to a new class."""

    def __init__(self, site: Site, *people: Any) -> None:
        self.site, self.people = site, People(*people)
        self.platform = Platform(handlers={"/members": self.people.handle})
        self.platform.register(site)
        self.browser = Browser(site)
        course = self.browser.launch(self.platform, roles=[INSTRUCTOR], sub="t").headers["location"].partition("?")[0]
        self.browser.post(course, data={"action": "creer", "name": "MPSI", "module": "l20"})
        with site.database.read() as db:
            (made,) = db.execute(select(SchoolClass)).scalars()
            (context,) = db.execute(select(ProviderContext)).scalars()
        self.address, self.course = f"/classes/{made.id}/plateforme/liste", str(context.id)

    def ask(self, digest: str = "") -> Any:
        return self.browser.post(self.address, data={"cours": self.course, "attendu": digest})

    def digest(self, page: Any) -> str:
        (found,) = re.findall(r'name="attendu" value="(\w+)"', page.text)
        return str(found)

    def seats(self) -> dict[str, str]:
        with self.site.database.read() as db:
            query = select(FederatedIdentity.subject, Membership.role).join(
                Membership, Membership.account_id == FederatedIdentity.account_id
            )
            return {row[0]: row[1] for row in db.execute(query)}


def test_a_list_is_shown_first_and_then_gives_seats_that_their_people_find(site: Site) -> None:
    teacher = Teacher(
        site, listed("t", [INSTRUCTOR]), listed("s1"), listed("s2", name=None), listed("a", [ASSISTANT]),
        listed("odd", [INSTRUCTOR, LEARNER], name="\ud800\0", given_name="\ud800", family_name=7),
        listed("gone", status="Inactive"), listed("m", ["Mentor"]), {"user_id": 7}, "nobody", listed("s1"),
    )  # fmt: skip
    page = teacher.ask()
    assert "4 personnes entrent" in page.text
    assert "Nom s1" in page.text
    assert teacher.seats() == {"t": "teacher"}
    assert teacher.ask(teacher.digest(page)).headers["location"].endswith("/eleves")
    assert teacher.seats() == {"t": "teacher", "s1": "student", "s2": "student", "a": "assistant", "odd": "student"}
    assert "0 personne entre" in teacher.ask().text
    Browser(site).launch(teacher.platform, sub="s1", name="Nom s1")
    with site.database.read() as db:
        assert len(db.execute(select(Account)).all()) == 5


def test_a_list_that_changes_meanwhile_is_shown_again(site: Site) -> None:
    teacher = Teacher(site, listed("s1"))
    digest = teacher.digest(teacher.ask())
    teacher.people.people.append(listed("s2"))
    page = teacher.ask(digest)
    assert "changé entre-temps" in page.text
    assert teacher.seats() == {"t": "teacher"}
    teacher.ask(teacher.digest(page))
    teacher.people.people.pop()
    assert "ne les nomme plus, et ils restent dans la classe : Nom s2" in teacher.ask().text.replace(
        "\xa0", " "
    ).replace("&nbsp;", " ")
    assert teacher.seats().keys() == {"t", "s1", "s2"}


def test_an_access_token_that_is_refused_is_renewed_once(site: Site) -> None:
    """Platforms forget tokens before their time: a restart of theirs, or a longer list than the token lasts."""
    teacher = Teacher(site, listed("s1"), listed("s2"), listed("s3"))
    answer, refused = teacher.people.handle, [2]

    def forget(*request: Any) -> Any:
        refused[0] -= 1
        return (401, {}, b"{}") if refused[0] == 0 or teacher.people.next == "" else answer(*request)

    teacher.platform.handlers["/members"] = forget
    assert "3 personnes entrent" in teacher.ask().text
    teacher.people.next, before = "", len(teacher.platform.requests)
    assert "réponse 401" in teacher.ask().text
    assert teacher.platform.requests[before:] == [("POST", "/token.php"), ("GET", "/members")] * 2


@pytest.mark.parametrize("case", ["next page elsewhere", "no list", "no service", "without end"])
def test_a_list_that_cannot_be_read_gives_no_seat(site: Site, case: str) -> None:
    teacher = Teacher(site, listed("s1"), listed("s2"), listed("s3"))
    if case == "next page elsewhere":
        teacher.people.next = "https://evil.example/members"
    if case == "no list":
        teacher.platform.handlers["/members"] = lambda *_: (200, {}, b'{"members": {}}')
    if case == "no service":
        with site.database.write() as db:
            for context in db.execute(select(ProviderContext)).scalars():
                context.roster_url = ""
    if case == "without end":
        again = {"link": '<https://moodle.example/members?x=1>; rel="next"'}
        teacher.platform.handlers["/members"] = lambda *_: (200, again, b'{"members": []}')
    page = teacher.ask()
    assert page.status_code == 422
    assert "n’a pas donné sa liste" in page.text
    assert teacher.seats() == {"t": "teacher"}
