"""What is answered to the lessons' questions: the first answer stays and follows who gave it, a class sees numbers."""

from __future__ import annotations

import json
import re
from html import unescape
from uuid import UUID

import pytest
from sqlalchemy import select

from server.assignments.models import Mode
from server.classes.models import ClassRole, SchoolClass, Status
from server.course import Course
from server.database import Database
from server.identity.models import Account, Role
from server.personal.guest_adoption import adopt_guest_data
from server.polls import repository, service
from server.polls.models import PollAnswer
from tests.support.classes import assign, new_class, person, seat
from tests.support.counting import Counted
from tests.support.service import Site, new_account

ICP = {"question": "rejeux/icp", "answer": "ailleurs"}
SAID = re.compile(r'data-said="([^"]*)"')


def kept(database: Database, account: Account) -> dict[str, tuple[str, str, int]]:
    with database.read() as db:
        return {one.poll: (one.answer, one.last, one.tries) for one in repository.load_poll_answers(db, account.id)}


def test_each_replay_of_the_module_asks_one_question_with_one_right_answer(course: Course) -> None:
    module = course.modules["l20"]
    found = service.polls_of_module(module)
    replays = [name for lesson in module.lessons for name in lesson.replays]
    assert [name for name, poll in found.items() if poll.is_prediction] == [f"rejeux/{name}" for name in replays]
    for poll in found.values():
        assert sum(option.right for option in poll.options) == 1 or poll.several
        assert not any("'" in text for text in (poll.question, *(option.words for option in poll.options)))


def test_the_first_answer_is_kept_and_shown_again(site: Site) -> None:
    ada = person(site)
    browser = ada.browser(site)
    told = {"first": "ailleurs", "right": None, "why": ""}
    assert browser.post("/l20/previsions", json=ICP).json() == told
    assert browser.post("/l20/previsions", json={**ICP, "answer": "bonne"}).json() == told
    assert kept(site.database, ada.account) == {"l20/rejeux/icp": ("ailleurs", "ailleurs", 1)}
    shown = SAID.search(browser.get("/l20/lire/slam").text)
    assert shown
    assert json.loads(unescape(shown[1])) == {"rejeux/icp": "ailleurs"}
    elsewhere = SAID.search(browser.get("/l20/lire/localiser").text)
    assert elsewhere
    assert elsewhere[1] == "{}"


def test_each_seance_of_lessons_and_the_telemeter_ask_questions_of_the_quiz(course: Course) -> None:
    module = course.modules["l20"]
    asked = {lesson.slug: lesson.questions for lesson in module.lessons if lesson.questions}
    assert asked.keys() == {"localiser", "cartographier", "slam", "ros2", "recherche", "telemetre", "rayons"}
    assert all(name.startswith("verification/") for names in asked.values() for name in names)
    every = [name for names in asked.values() for name in names]
    assert len(set(every)) == len(every) == 29
    places = [[option.right for option in service.find_poll(module, name).options].index(True) for name in every]
    assert len(set(places)) > 2


def test_a_question_is_marked_in_place_and_every_try_is_counted(site: Site) -> None:
    ada = person(site)
    browser = ada.browser(site)
    wrong = browser.post("/l20/previsions", json={"question": "verification/amcl", "answer": "precision"}).json()
    assert (wrong["first"], wrong["right"]) == ("precision", False)
    assert "fait aussi bien" in wrong["why"]
    assert "plusieurs bosses" not in wrong["why"]
    right = browser.post("/l20/previsions", json={"question": "verification/amcl", "answer": "bosses"}).json()
    assert (right["first"], right["right"]) == ("precision", True)
    assert kept(site.database, ada.account) == {"l20/verification/amcl": ("precision", "bosses", 2)}


def test_a_visitor_is_marked_too_and_not_kept(site: Site) -> None:
    several = {"question": "verification/produit", "answer": "confiance,zero"}
    assert site.client.post("/l20/previsions", json=several).json()["right"] is True
    part = site.client.post("/l20/previsions", json={**several, "answer": "zero"}).json()
    assert part["right"] is False
    assert "il manque" in part["why"]
    with site.database.read() as db:
        assert db.execute(select(PollAnswer)).all() == []


def test_no_option_of_a_question_says_that_it_is_right(site: Site) -> None:
    page = site.client.get("/l20/lire/localiser").text
    assert page.count('<section class="asked"') == 9
    start = page.index('id="question-verification-amcl"')
    asked = page[start : page.index("</section>", start)]
    assert asked.count('type="radio"') == 4
    assert "right" not in asked
    assert "Dans un bâtiment où des endroits se ressemblent" not in asked


def test_a_test_that_asks_it_is_no_oracle(site: Site) -> None:
    teacher = person(site, Role.teacher, "Emmy")
    made = new_class(site.database, teacher.account)
    ada = person(site)
    seat(site.database, made, ada.account)
    assign(site.database, made, "l20/verification", mode=Mode.test, title="Interro")
    body = {"question": "verification/amcl", "answer": "bosses"}
    refused = ada.browser(site).post("/l20/previsions", json=body)
    assert refused.status_code == 409
    assert "Oui" not in refused.text
    assert kept(site.database, ada.account) == {}


@pytest.mark.parametrize(
    ("path", "body", "status"),
    [
        ("/l20/previsions", {"question": "rejeux/icp", "answer": "nulle_part"}, 422),
        ("/l20/previsions", {"question": "rejeux/icp", "answer": ""}, 422),
        ("/l20/previsions", {"question": "rejeux/icp"}, 422),
        ("/l20/previsions", {"question": "rejeux/icp", "answer": "x" * 10_000}, 422),
        ("/l20/previsions", {"question": "rejeux/_carte", "answer": "bonne"}, 404),
        ("/l20/previsions", {"question": "verification/amcl", "answer": "bosses,precision"}, 422),
        ("/l20/previsions", {"question": "verification/produit", "answer": "zero,zero"}, 422),
        ("/l20/previsions", {"question": "verification/augmentee", "answer": "trois_quarts"}, 404),
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


def test_a_place_is_kept_as_it_was_put_and_counted_by_how_far_it_was(site: Site) -> None:
    teacher = person(site, Role.teacher, "Emmy")
    made = new_class(site.database, teacher.account)
    people = [person(site, account=seat(site.database, made, new_account(site.database))) for _ in range(4)]
    said = ["10.25,0", "12,0", "2,-5.5", "11,-1"]
    for one, answer in zip(people, said, strict=True):
        sent = one.browser(site).post("/l20/previsions", json={"question": "rejeux/banane", "answer": answer})
        assert sent.json()["first"] == answer
    assert kept(site.database, people[0].account) == {"l20/rejeux/banane": ("10.25,0", "10.25,0", 1)}
    with site.database.write() as db:  # what was said before the question changed
        repository.save_first_answer(db, new_account_of(site, made), "l20/rejeux/banane", "deca")
    page = teacher.browser(site).get(f"/classes/{made.id}/previsions").text
    banana = page[page.index('href="/l20/lire/localiser#rejeu-banane"') :]
    assert "4 sur 5 élèves ont répondu, 1 juste." in banana
    assert re.findall(r'poll-count">(\d+)<', banana)[:3] == ["1", "1", "2"]
    assert "Entre 0,8 et 1,6 case" in banana
    for wrong in ("pres", "99,0", "1;2", "10.257,0"):
        body = {"question": "rejeux/banane", "answer": wrong}
        assert people[0].browser(site).post("/l20/previsions", json=body).status_code == 422


def new_account_of(site: Site, made: SchoolClass) -> UUID:
    return seat(site.database, made, new_account(site.database)).id


def test_answers_are_kept_twice_over_and_move_without_loss(database: Database) -> None:
    guest, ada = new_account(database, Role.guest), new_account(database)
    with database.write() as db:
        for account, poll, answer in [(guest, "l20/a", "x"), (guest, "l20/b", "x"), (ada, "l20/b", "y")]:
            repository.save_first_answer(db, account.id, poll, answer)
            repository.save_first_answer(db, account.id, poll, "z")
    with database.write() as db:
        adopt_guest_data(db, guest.id, ada.id)
        repository.save_latest_answer(db, ada.id, "l20/a", "w")
    assert kept(database, ada) == {"l20/a": ("x", "w", 2), "l20/b": ("y", "y", 1)}


def test_a_class_is_counted_by_its_active_students_in_as_many_queries_as_nobody(site: Site) -> None:
    teacher = person(site, Role.teacher, "Emmy")
    made = new_class(site.database, teacher.account)
    people = [seat(site.database, made, new_account(site.database)) for _ in range(4)]
    seat(site.database, made, people[3], status=Status.left)
    assistant = seat(site.database, made, new_account(site.database), ClassRole.assistant)
    stranger = new_account(site.database)
    browser = teacher.browser(site)
    path = f"/classes/{made.id}/previsions"
    with Counted(site.database) as empty:
        assert "Personne n’a encore répondu" in browser.get(path).text
    with site.database.write() as db:
        for account in (*people[:2], people[3], assistant, stranger):
            for poll in ("l20/rejeux/icp", "l20/rejeux/mcl", "l20/rejeux/graphe"):
                repository.save_first_answer(db, account.id, poll, {"l20/rejeux/icp": "ailleurs"}.get(poll, "perdu"))
        repository.save_first_answer(db, people[2].id, "l20/rejeux/icp", "bonne")
    with Counted(site.database) as full:
        page = browser.get(path).text
    icp = page[page.index('href="/l20/lire/slam#rejeu-icp"') :]
    assert "3 sur 3 élèves ont répondu, 2 justes." in icp
    assert re.findall(r'poll-count">(\d+)<', icp)[:3] == ["1", "2", "0"]
    assert len(full.statements) <= len(empty.statements)
    student = person(site, account=people[0]).browser(site)
    assert student.get(path).status_code == 403
