"""What is answered to the lessons' questions: the first answer stays and follows who gave it, a class sees numbers."""

from __future__ import annotations

import json
import re
from html import unescape

import pytest
from sqlalchemy import select

from server.classes.models import Seat, Status
from server.course import Course
from server.database import Database
from server.identity.models import Account, Role
from server.personal.joining import adopt
from server.polls import repository, service
from server.polls.models import PollAnswer
from tests.support.classes import new_class, person, seat
from tests.support.counting import Counted
from tests.support.service import Site, new_account

ICP = {"question": "rejeux/icp", "answer": "ailleurs"}
SAID = re.compile(r'data-said="([^"]*)"')


def kept(database: Database, account: Account) -> dict[str, tuple[str, str, int]]:
    with database.read() as db:
        return {one.poll: (one.answer, one.last, one.tries) for one in repository.all_of(db, account.id)}


def test_each_replay_of_the_module_asks_one_question_with_one_right_answer(course: Course) -> None:
    module = course.modules["l20"]
    found = service.of_module(module)
    replays = [name for lesson in module.lessons for name in lesson.replays]
    assert list(found) == [f"rejeux/{name}" for name in replays]
    for poll in found.values():
        assert sum(option.right for option in poll.options) == 1
        assert not any("'" in text for text in (poll.question, *(option.words for option in poll.options)))


def test_the_first_answer_is_kept_and_shown_again(site: Site) -> None:
    ada = person(site)
    browser = ada.browser(site)
    assert browser.post("/l20/previsions", json=ICP).json() == {"first": "ailleurs"}
    assert browser.post("/l20/previsions", json={**ICP, "answer": "bonne"}).json() == {"first": "ailleurs"}
    assert kept(site.database, ada.account) == {"l20/rejeux/icp": ("ailleurs", "ailleurs", 1)}
    told = SAID.search(browser.get("/l20/lire/slam").text)
    assert told
    assert json.loads(unescape(told[1])) == {"rejeux/icp": "ailleurs"}
    elsewhere = SAID.search(browser.get("/l20/lire/localiser").text)
    assert elsewhere
    assert elsewhere[1] == "{}"


@pytest.mark.parametrize(
    ("path", "body", "status"),
    [
        ("/l20/previsions", {"question": "rejeux/icp", "answer": "nulle_part"}, 422),
        ("/l20/previsions", {"question": "rejeux/icp", "answer": ""}, 422),
        ("/l20/previsions", {"question": "rejeux/icp"}, 422),
        ("/l20/previsions", {"question": "rejeux/icp", "answer": "x" * 10_000}, 422),
        ("/l20/previsions", {"question": "rejeux/_carte", "answer": "bonne"}, 404),
        ("/l20/previsions", {"question": "../icp", "answer": "bonne"}, 404),
        ("/l21/previsions", ICP, 404),
        ("/l20/previsions", {**ICP, "account": "0"}, 422),
    ],
)
def test_what_is_no_answer_is_refused_and_nothing_is_kept(
    site: Site, path: str, body: dict[str, str], status: int
) -> None:
    ada = person(site)
    assert ada.browser(site).post(path, json=body).status_code == status
    assert kept(site.database, ada.account) == {}


def test_a_visitor_is_kept_by_their_own_browser(site: Site) -> None:
    assert site.client.post("/l20/previsions", json=ICP).status_code == 401
    with site.database.read() as db:
        assert db.execute(select(PollAnswer)).all() == []


def test_answers_are_kept_twice_over_and_move_without_loss(database: Database) -> None:
    guest, ada = new_account(database, Role.guest), new_account(database)
    with database.write() as db:
        for account, poll, answer in [(guest, "l20/a", "x"), (guest, "l20/b", "x"), (ada, "l20/b", "y")]:
            repository.keep_first(db, account.id, poll, answer)
            repository.keep_first(db, account.id, poll, "z")
    with database.write() as db:
        adopt(db, guest.id, ada.id)
        repository.keep(db, ada.id, "l20/a", "w")
    assert kept(database, ada) == {"l20/a": ("x", "w", 2), "l20/b": ("y", "y", 1)}


def test_a_class_is_counted_by_its_active_students_in_as_many_queries_as_nobody(site: Site) -> None:
    teacher = person(site, Role.teacher, "Emmy")
    made = new_class(site.database, teacher.account)
    people = [seat(site.database, made, new_account(site.database)) for _ in range(4)]
    seat(site.database, made, people[3], status=Status.left)
    assistant = seat(site.database, made, new_account(site.database), Seat.assistant)
    stranger = new_account(site.database)
    browser = teacher.browser(site)
    path = f"/classes/{made.id}/previsions"
    with Counted(site.database) as empty:
        assert "Personne n’a encore répondu" in browser.get(path).text
    with site.database.write() as db:
        for account in (*people[:2], people[3], assistant, stranger):
            for poll in ("l20/rejeux/icp", "l20/rejeux/mcl", "l20/rejeux/graphe"):
                repository.keep_first(db, account.id, poll, {"l20/rejeux/icp": "ailleurs"}.get(poll, "perdu"))
        repository.keep_first(db, people[2].id, "l20/rejeux/icp", "bonne")
    with Counted(site.database) as full:
        page = browser.get(path).text
    icp = page[page.index('href="/l20/lire/slam#rejeu-icp"') :]
    assert "3 sur 3 élèves ont répondu, 2 justes." in icp
    assert re.findall(r'poll-count">(\d+)<', icp)[:3] == ["1", "2", "0"]
    assert len(full.statements) <= len(empty.statements)
    student = person(site, account=people[0]).browser(site)
    assert student.get(path).status_code == 403
