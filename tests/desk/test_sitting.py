"""A test, from « Commencer » to the results; and every way round it that a bored student would try."""

from __future__ import annotations

import io
import json
import re
import zipfile
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from typing import Any

import pytest
from sqlalchemy import select, update

from graders.core.contract.findings import Judgement
from graders.core.contract.verdict import Diagnosis
from server.assignments.models import Assignment, Exemption, Mode, SavedWork, Sitting, Visibility
from server.audit import service as audit
from server.audit.models import AuditAction, AuditEvent
from server.base import school_time
from server.base.app_services import get_service
from server.base.errors import Conflict
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.comments import notes
from server.database import utc_now
from server.gradebook import service as gradebook
from server.grading.grading_task import GradingInput
from server.identity.models import Account, Role
from server.submissions.models import Submission
from server.submissions.sitting_collector import SittingCollector
from tests.support.classes import Person, assign, new_class, person, seat
from tests.support.client import TestClient
from tests.support.forms import hidden_fields
from tests.support.service import EXERCISE, Site, fake_verdict

SEND = "/api/v1/submissions"
PAGE = f"/{EXERCISE.replace('/', '/exercices/')}"
MINUTE = timedelta(minutes=1)
FORM = {"Accept": "application/json"}


@dataclass
class Room:
    """A class that sits a test on one exercise, with its teacher. What is graded ends as `outcome` says."""

    site: Site
    teacher: Person
    made: SchoolClass
    test: Assignment
    outcome: str = "ok"

    @property
    def path(self) -> str:
        return f"/classes/{self.made.id}/devoirs/{self.test.id}"

    def student(self, *, begins: bool = True) -> Person:
        one = person(self.site)
        seat(self.site.database, self.made, one.account)
        if begins:
            assert self.post(one, "commencer").status_code == 303
        return one

    def take_out(self, who: Person) -> None:
        with self.site.database.write() as db:
            db.execute(update(Membership).where(Membership.account_id == who.id).values(status=Status.left))

    def post(self, who: Person, what: str, **data: str) -> Any:
        return who.browser(self.site).post(f"{self.path}/{what}", data=data)

    def send(self, who: Person, code: str = "x = 1", **query: Any) -> Any:
        return self.site.client.post(SEND, params=query, json={"exercise": EXERCISE, "code": code}, headers=who.headers)

    def save(self, who: Person, code: str) -> Any:
        return who.browser(self.site).post(f"{PAGE}/brouillon", data={"code": code}, headers=FORM)

    def grade(self) -> None:
        def judged(sent: GradingInput) -> Judgement:
            return Judgement(fake_verdict(f"outcome: {self.outcome}", sent.seed), {"b": {"kind": "fake"}})

        while self.site.worker_with(judged).run_one():
            pass

    def let_time_pass(self, minutes: int = 120) -> None:
        """All of it happened earlier by so much."""
        earlier = timedelta(minutes=minutes)
        with self.site.database.write() as db:
            for column in (Sitting.began_at, SavedWork.saved_at, Submission.created_at):
                for row in db.execute(select(column.class_)).scalars():
                    setattr(row, column.key, getattr(row, column.key) - earlier)

    def collect(self, now: datetime | None = None) -> int:
        return get_service(self.site.app, SittingCollector).end_expired_sittings(self.site.database, now or utc_now())

    def sent(self, who: Person) -> list[Submission]:
        query = select(Submission).where(Submission.account_id == who.id).order_by(Submission.created_at)
        with self.site.database.read() as db:
            return list(db.execute(query).scalars())


@pytest.fixture
def room(site: Site) -> Room:
    site.tighten(submission_burst=1000)
    teacher = person(site, Role.teacher, "Mme Martin")
    made = new_class(site.database, teacher.account)
    test = assign(site.database, made, EXERCISE, mode=Mode.test, duration_minutes=60)
    return Room(site, teacher, made, test)


def told(answer: Any) -> str:
    return re.sub(r"\s+", " ", re.sub(r"<[^>]*>", "", answer.text))


def test_from_begin_to_results(room: Room) -> None:
    ada = room.student(begins=False)
    browser = ada.browser(room.site)
    before = told(browser.get(f"{room.path}/composer"))
    assert "Vous aurez 60 minutes dès que vous commencerez" in before
    assert "Si vous commencez maintenant, il finit le" in before
    assert "commencez-le d’abord" in room.send(ada).json()["detail"]
    assert "Rien ne s’envoie ici avant" in told(browser.get(PAGE))
    assert room.post(ada, "commencer").status_code == 303
    running = browser.get(f"{room.path}/composer").text
    assert 'data-ends="' in running
    assert "Rendre définitivement" in running
    answer = room.send(ada, wait=1)  # the whole of it
    assert (answer.status_code, answer.json()["status"], answer.json()["held"]) == (202, "running", True)
    assert "quand l’enseignant publiera" in answer.json()["notice"]
    room.grade()
    assert "Pas d’indices pendant le contrôle" in told(browser.get(PAGE))
    assert room.post(ada, "rendre").status_code == 303
    assert "Rendu le" in told(browser.get(f"{room.path}/composer"))
    refused = room.send(ada)
    assert (refused.status_code, refused.headers["content-type"]) == (409, "application/problem+json")
    assert room.post(room.teacher, "publier").headers["location"] == room.path
    assert "Les résultats sont publiés" in told(browser.get(f"{room.path}/composer"))
    assert "Exercice réussi" in told(browser.get(PAGE))
    assert room.send(ada, "x = 2").status_code == 202
    assert room.post(room.teacher, "publier").status_code == 409
    with room.site.database.read() as db:
        (event,) = db.execute(select(AuditEvent).where(AuditEvent.what == AuditAction.feedback_released)).scalars()
    assert (event.by, event.about, list(event.after)) == (room.teacher.id, "Interro", ["released_at"])


ALIKE = (
    (
        re.compile(r"[0-9a-f]{8}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{12}|\d{4}-\d\d-\d\d-\d{6}-[0-9a-f]{8}"),
        "ID",
    ),
    (re.compile(r"\d{4}-\d\d-\d\d[T ][\d:.]+(\+00:00|Z)?|\d\d/\d\d/\d{4} à \d+\sh\s\d\d"), "TIME"),
    (re.compile(r"\d+(er)? \w+ \d{4} à \d+\sh\s\d\d"), "TIME"),
    (re.compile(r'("seed": )\d+'), r"\1SEED"),
)


def test_nothing_is_offered_for_release_before_the_test_opens(room: Room) -> None:
    opened = room.teacher.browser(room.site).get(room.path).text
    assert "Publier les résultats</button>" in opened
    with room.site.database.write() as db:
        db.execute(update(Assignment).where(Assignment.id == room.test.id).values(opens_at=utc_now() + 60 * MINUTE))
    page = room.teacher.browser(room.site).get(room.path).text
    assert "Publier les résultats</button>" not in page
    assert "Vous publierez ici ses résultats" in page


def alike(text: str) -> str:
    for pattern, word in ALIKE:
        text = pattern.sub(word, text)
    return text


#: Questions on what the verdict has, and on what it has not.
ASKED: tuple[dict[str, Any], ...] = ({"text": "?", "check": "b"}, {"text": "?", "check": "zz"}, {"text": "?"})


def _class_pages(room: Room, who: Person) -> list[str]:
    own = f"/classes/{room.made.id}"
    return ["/classes", f"{own}/devoirs", f"{room.path}/composer", room.path, f"{room.path}/pourquoi", "/compte"]


def _class_calls(room: Room) -> list[str]:
    own = f"/api/v1/classes/{room.made.id}"
    there = f"{own}/assignments/{room.test.id}"
    return ["/api/v1/classes", own, f"{own}/assignments", there, f"{there}/rules", "/api/v1/exercises",
            f"/api/v1/exercises/{EXERCISE}"]  # fmt: skip


def everything(room: Room, who: Person, code: str) -> dict[str, str]:
    """All that the service tells a student, of an attempt and of where they stand."""
    browser, found = who.browser(room.site), {}
    first = room.sent(who)[0].id
    asked = {"json": {"exercise": EXERCISE, "code": code}, "headers": who.headers}
    calls: list[tuple[str, str, dict[str, Any]]] = [
        *(("GET", f"{SEND}/{first}{end}", {"headers": who.headers}) for end in ("", "/figures/b.svg")),
        ("POST", f"{SEND}?reuse=true&wait=0.1", asked),
        ("POST", f"{PAGE}/soumissions", {"data": {"code": code}, "headers": FORM}),
        *(("GET", f"/soumissions/{first}{end}", {}) for end in ("", "/verdict", "/verdict?deja=true")),
        ("GET", f"/soumissions/{first}/figures/b.svg", {}),
        *(("GET", path, {}) for path in ("/", "/l20", PAGE, f"{PAGE}/essais", f"{PAGE}?reprendre={first}")),
        *(("GET", path, {}) for path in _class_pages(room, who)),
        *(("GET", path, {"headers": who.headers}) for path in _class_calls(room)),
        *(("POST", f"{SEND}/{first}/comments", {"json": body, "headers": who.headers}) for body in ASKED),
    ]
    for method, path, options in calls:
        client: TestClient = room.site.client if path.startswith("/api") else browser
        answer = client.request(method, path, **options)
        found[f"{method} {path.replace(str(first), 'ID')}"] = f"{answer.status_code} {alike(answer.text)}"
    archive = zipfile.ZipFile(io.BytesIO(browser.get("/compte/donnees").content))
    for name in archive.namelist():
        found[alike(name)] = alike(archive.read(name).decode())
    return found


def streams(room: Room, who: Person) -> dict[str, str]:
    """All that the streams of an attempt tell, which end once nothing more is waited for."""
    first = room.sent(who)[0].id
    api = room.site.client.get(f"{SEND}/{first}/events", headers=who.headers)
    page = who.browser(room.site).get(f"/soumissions/{first}/evenements")
    return {"API": alike(api.text), "page": alike(page.text)}


def test_nothing_tells_how_a_held_attempt_ended_nor_whether_it_was_graded(
    room: Room, monkeypatch: pytest.MonkeyPatch
) -> None:
    load_seconds = "server.gradebook.schemas.LOAD_SECONDS"
    code, seen = "x = 1", {}
    for outcome in ("ok", "wrong_answer", "timeout", ""):
        who = room.student()
        assert room.send(who, code).status_code == 202
        room.outcome = outcome
        if outcome:
            room.grade()
        monkeypatch.setattr(load_seconds, 1000.0)  # nothing is settled before the machine has done all that is asked
        seen[outcome] = everything(room, who, code)
        monkeypatch.setattr(load_seconds, 0.0)
        seen[outcome] |= streams(room, who)
        room.take_out(who)  # the next one's class is as large
    for outcome, told_of_it in seen.items():
        for where, text in told_of_it.items():
            assert text == seen["ok"][where], (outcome, where)
        assert told_of_it.keys() == seen["ok"].keys()
    assert not [where for where, text in seen["ok"].items() if '"points"' in text or "best_score" in text]
    assert seen["ok"]["GET /soumissions/ID/figures/b.svg"].startswith("404")


def test_what_one_takes_away_has_no_mark_that_a_test_holds_back(room: Room) -> None:
    ada, made = room.student(), room.made.id
    mark = {"points": 13.0, "reason": "Très bien vu."}
    path = f"/api/v1/classes/{made}/marks/{ada.id}/{EXERCISE}"
    assert room.send(ada).status_code == 202
    room.grade()
    assert room.site.client.put(path, json=mark, headers=room.teacher.headers).status_code == 200
    with room.site.database.write() as db:
        points = {"before": {"points": 13.0}, "after": {"points": 7.5}}
        audit.record_event(db, made, room.teacher.id, AuditAction.regrade_applied, student=ada.id, **points)

    def taken() -> str:
        archive = ada.browser(room.site).get("/compte/donnees").content
        return zipfile.ZipFile(io.BytesIO(archive)).read("notes.json").decode()

    assert not re.search(r"13\.0|7\.5|bien vu", taken())
    assert room.post(ada, "rendre").status_code == 303
    assert room.post(room.teacher, "publier").status_code == 303
    assert re.search(r"13\.0[^$]*bien vu[^$]*7\.5", taken())


def test_every_door_is_shut_before_one_begins_and_after_one_has_handed_in(room: Room) -> None:
    for who in (room.student(begins=False), room.student()):
        browser = who.browser(room.site)
        room.post(who, "rendre")
        for answer in (
            room.send(who),
            room.send(who, reuse=True),
            browser.post(f"{PAGE}/soumissions", data={"code": "x = 1"}, headers=FORM),
            browser.post(f"{PAGE}/soumissions", data={"code": "x = 1"}),
            room.save(who, "x = 1"),
        ):
            assert answer.status_code == 409
        assert room.sent(who) == []
    assert room.post(who, "commencer").status_code == 303
    assert room.send(who).status_code == 409, "beginning again opens nothing"


def test_leaving_the_class_frees_nothing_but_being_taken_out_of_it_does(room: Room) -> None:
    gone, out = room.student(), room.student()
    for who in (gone, out):
        room.send(who)
    room.grade()
    assert gone.browser(room.site).post(f"/classes/{room.made.id}/quitter").status_code == 303
    address = f"{SEND}/{room.sent(gone)[0].id}"
    assert room.site.client.get(address, headers=gone.headers).json()["verdict"] is None
    with room.site.database.write() as db:
        db.execute(update(SchoolClass).values(approval=True))
    assert gone.browser(room.site).post(f"/rejoindre/{room.made.join_code}").status_code == 303
    assert room.site.client.get(address, headers=gone.headers).json()["verdict"] is None, "nor does asking to come back"
    teacher = room.teacher.browser(room.site)
    teacher.post(f"/classes/{room.made.id}/eleves", data={"action": "retirer", "eleve": str(out.id)})
    assert room.site.client.get(f"{SEND}/{room.sent(out)[0].id}", headers=out.headers).json()["verdict"]


def test_a_guest_s_attempts_stay_held_and_their_time_goes_on_in_the_account_that_they_open(room: Room) -> None:
    guest = TestClient(room.site.app, follow_redirects=False)
    assert guest.post(f"/rejoindre/{room.made.join_code}", data={"given": "Ada", "family": "L"}).status_code == 303
    with room.site.database.write() as db:  # as guests could before they no longer began tests
        guest_id = db.execute(select(Account.id).where(Account.role == Role.guest)).scalar_one()
        db.add(Sitting(assignment_id=room.test.id, account_id=guest_id, began_at=utc_now()))
    href = guest.post(f"{PAGE}/soumissions", data={"code": "x = 1"}).headers["location"]
    room.grade()
    with room.site.database.read() as db:
        began = db.execute(select(Sitting.began_at)).scalar_one()
    form = {"name": "Ada L.", "login": "ada", "password": "notes sur la machine"}
    assert guest.post("/inscription", data=form).status_code == 303
    assert "quand l’enseignant publiera" in told(guest.get(href))
    assert guest.post(f"{room.path}/commencer").status_code == 303
    with room.site.database.read() as db:
        assert db.execute(select(Sitting.began_at)).scalars().all() == [began]


def test_who_succeeded_before_has_neither_solution_nor_hints_in_the_test_and_keeps_what_they_had(room: Room) -> None:
    ada = person(room.site)
    sent = room.send(ada, "avant = 1").json()
    room.grade()
    with room.site.database.write() as db:
        db.execute(update(Submission).values(created_at=utc_now() - timedelta(days=1)))
        gradebook.rebuild_account_standings(db, ada.id)
    browser = ada.browser(room.site)
    assert "Corrigé commenté" in browser.get(PAGE).text
    seat(room.site.database, room.made, ada.account)
    room.post(ada, "commencer")
    page = browser.get(PAGE).text
    assert "Corrigé commenté" not in page
    assert "<summary>Indice" not in page
    assert room.site.client.get(sent["url"], headers=ada.headers).json()["verdict"]["points"] == 20
    room.outcome = "wrong_answer"
    room.send(ada, "pendant = 1")
    room.grade()
    assert "Meilleure note : 20 / 20 en 2 essais" in told(browser.get(PAGE))
    room.post(room.teacher, "publier")
    room.post(ada, "rendre")
    assert "Corrigé commenté" in browser.get(PAGE).text


def test_staff_see_everything_at_once(room: Room) -> None:
    ada, helper = room.student(), person(room.site)
    seat(room.site.database, room.made, helper.account, ClassRole.assistant)
    sent = room.send(ada).json()
    room.grade()
    for one in (room.teacher, helper):
        assert room.site.client.get(sent["url"], headers=one.headers).json()["verdict"]["points"] == 20
        assert "Exercice réussi" in told(one.browser(room.site).get(f"/soumissions/{sent['id']}"))


def test_what_was_saved_at_the_end_counts_and_what_came_after_does_not(room: Room) -> None:
    ada, bob, eve = (room.student() for _ in range(3))
    room.send(ada, "envoye = 1")
    assert room.save(ada, "enregistre = 2").status_code == 200
    assert "enregistre = 2" in ada.browser(room.site).get(PAGE).text
    room.save(bob, "ancien = 1")
    room.send(bob, "envoye = 1")
    room.save(eve, "x = 1\r\ny = 2")
    room.send(eve, "x = 1\ny = 2")
    room.save(eve, "x = 1\r\ny = 2")
    assert room.collect() == 0
    room.let_time_pass()
    assert room.save(ada, "trop_tard = 3").status_code == 409
    assert room.collect() == 3
    assert room.collect() == 0, "of several processes one only"
    codes = {who.id: [one.code for one in room.sent(who)] for who in (ada, bob, eve)}
    assert codes == {ada.id: ["envoye = 1", "enregistre = 2"], bob.id: ["envoye = 1"], eve.id: ["x = 1\ny = 2"]}
    with room.site.database.read() as db:
        saved = db.get(SavedWork, (room.test.id, ada.id, EXERCISE))
        sitting = db.get(Sitting, (room.test.id, ada.id))
        assert saved
        assert sitting
        assert room.sent(ada)[-1].created_at == saved.saved_at
        assert (sitting.handed_in_at, sitting.ended_by) == (sitting.began_at + 60 * MINUTE, "time")
    room.grade()
    room.post(room.teacher, "publier")
    assert "Essai n° 2" in told(ada.browser(room.site).get(PAGE))


def test_time_shortened_after_a_save_sends_it_as_of_the_end(room: Room) -> None:
    ada = room.student()
    room.save(ada, "x = 1")
    with room.site.database.write() as db:
        end = utc_now() - MINUTE
        db.execute(update(Assignment).values(closes_at=end, opens_at=end - 60 * MINUTE))
        db.execute(update(Sitting).values(began_at=end - 2 * MINUTE))
    ada.browser(room.site).get(f"{room.path}/composer")
    assert [one.created_at for one in room.sent(ada)] == [end], "a page that is read ends it too"


def test_more_time_given_after_the_end_lets_one_go_on(room: Room) -> None:
    ada = room.student()
    room.save(ada, "x = 1")
    room.let_time_pass(70)
    assert room.collect() == 1
    assert room.send(ada, "x = 2").status_code == 409
    with room.site.database.write() as db:
        db.execute(update(Assignment).values(duration_minutes=90))
    assert room.save(ada, "x = 3").status_code == 200
    room.let_time_pass(30)
    assert room.collect() == 1
    assert [one.code for one in room.sent(ada)] == ["x = 1", "x = 3"]
    assert room.post(ada, "rendre").status_code == 303


def test_what_is_saved_is_bounded_and_not_too_often(room: Room) -> None:
    ada = room.student()
    assert room.save(ada, "x" * 70_000).status_code == 413
    room.site.tighten(save_burst=1, save_refill_seconds=1000)
    assert [room.save(ada, "x = 1").status_code for _ in range(2)] == [200, 429]


def test_without_script_one_saves_and_comes_back_to_the_exercise(room: Room) -> None:
    browser = room.student().browser(room.site)
    page = browser.get(PAGE).text
    assert f'formaction="{PAGE}/brouillon"' in page
    answer = browser.post(f"{PAGE}/brouillon", data={"code": "x = 1"})
    assert (answer.status_code, answer.headers["location"]) == (303, f"{PAGE}#essai")
    assert "enregistré" in browser.get(PAGE).text
    assert "enregistré le" in told(browser.get(f"{room.path}/composer"))


def test_an_older_tab_does_not_replace_what_another_one_saved(room: Room) -> None:
    ada = room.student()
    browser = ada.browser(room.site)
    older = hidden_fields(browser.get(PAGE).text, f"{PAGE}/soumissions")
    newer = hidden_fields(browser.get(PAGE).text, f"{PAGE}/soumissions")
    saved = browser.post(f"{PAGE}/brouillon", data={**newer, "code": "x = 2"}, headers=FORM).json()
    refused = browser.post(f"{PAGE}/brouillon", data={**older, "code": "x = 1"}, headers=FORM)
    assert refused.status_code == 409
    assert refused.json()["type"].endswith("autre-version")
    assert refused.json()["depuis"] == saved["depuis"]
    same = browser.post(f"{PAGE}/brouillon", data={**older, "code": "x = 2"}, headers=FORM)
    assert same.status_code == 200  # the same text is no conflict
    again = browser.post(f"{PAGE}/brouillon", data={**newer, "depuis": same.json()["depuis"], "code": "x = 3"})
    assert again.status_code == 303

    page = browser.post(f"{PAGE}/brouillon", data={**older, "code": "x = 1"}).text
    assert "x = 3" in page
    assert "x = 1" in page
    mine = hidden_fields(page, f"{PAGE}/brouillon")
    assert browser.post(f"{PAGE}/brouillon", data=mine).status_code == 303  # chosen in words
    room.let_time_pass(61)
    room.collect()
    assert [sent.code for sent in room.sent(ada)] == ["x = 1"]


def test_a_page_opened_before_the_test_says_what_its_send_would_be(room: Room) -> None:
    with room.site.database.write() as db:
        db.execute(update(Assignment).values(opens_at=utc_now() + MINUTE))
    ada = room.student(begins=False)
    browser, send = ada.browser(room.site), f"{PAGE}/soumissions"
    before = hidden_fields(browser.get(PAGE).text, send)
    with room.site.database.write() as db:
        db.execute(update(Assignment).values(opens_at=utc_now() - MINUTE))
    room.post(ada, "commencer")
    refused = browser.post(send, data={**before, "code": "x = 1"})
    assert refused.status_code == 409
    assert "Vous composez maintenant le contrôle « Interro »" in refused.text
    assert room.sent(ada) == []
    chosen = hidden_fields(refused.text, send)
    assert browser.post(send, data=chosen).status_code == 303
    assert [sent.code for sent in room.sent(ada)] == ["x = 1"]


def test_a_page_of_a_test_whose_results_are_out_does_not_pass_for_it(room: Room) -> None:
    ada = room.student()
    browser, send = ada.browser(room.site), f"{PAGE}/soumissions"
    during = hidden_fields(browser.get(PAGE).text, send)
    room.post(ada, "rendre")
    over = browser.post(send, data={**during, "code": "x = 1"})
    assert "est terminé pour vous" in over.text
    assert room.post(room.teacher, "publier").status_code == 303
    refused = browser.post(send, data={**during, "code": "x = 1"}, headers=FORM)
    assert refused.status_code == 409
    assert refused.json()["button"] == "Envoyer comme entraînement"
    assert browser.post(send, data={**during, "controle": "", "code": "x = 1"}).status_code == 303


def test_publishing_says_first_whom_it_shuts_out(room: Room) -> None:
    ines, malo = room.student(begins=False), room.student()
    page = room.teacher.browser(room.site).get(room.path).text
    assert "1 élève n’a pas commencé et ne pourra plus : Ada" in page
    assert "1 élève compose encore, jusqu’à sa propre fin : Ada" in page
    drawn = hidden_fields(page, f"{room.path}/publier")
    room.post(ines, "commencer")
    refused = room.post(room.teacher, "publier", **drawn)
    assert refused.status_code == 409
    assert "2 élèves composent encore" in refused.text
    assert room.post(malo, "rendre").status_code == 303
    drawn = hidden_fields(room.teacher.browser(room.site).get(room.path).text, f"{room.path}/publier")
    assert room.post(room.teacher, "publier", **drawn).status_code == 303


def test_what_arrived_in_time_counts_however_long_it_waited(room: Room, monkeypatch: pytest.MonkeyPatch) -> None:
    """A busy server makes nobody late: the arrival of the request counts, and not when its turn has come."""
    ada = room.student()
    arrived = utc_now()
    room.let_time_pass(61)
    assert room.collect() == 1
    assert room.send(ada).status_code == 409
    monkeypatch.setattr("server.submissions.service.arrival_time", lambda: arrived - timedelta(minutes=59))
    assert room.send(ada).status_code == 202
    assert room.save(ada, "x = 2").status_code == 200


def test_a_group_that_gives_time_is_not_taken_away_in_mid_sitting(room: Room) -> None:
    ada, roster = room.student(begins=False), f"/classes/{room.made.id}/eleves"
    teacher = room.teacher.browser(room.site)
    group = {"eleve": str(ada.id), "groupe": "tiers-temps"}
    teacher.post(roster, data={**group, "action": "grouper"})
    with room.site.database.write() as db:
        db.add(Exemption(assignment_id=room.test.id, label="tiers-temps", time_factor=1.33))
    room.post(ada, "commencer")
    refused = teacher.post(roster, data={**group, "action": "degrouper"})
    assert refused.status_code == 409
    assert "Ada compose en ce moment" in refused.text
    assert "tiers-temps" in told(teacher.get(roster))
    teacher.post(roster, data={**group, "groupe": "TP1", "action": "grouper"})
    assert teacher.post(roster, data={**group, "groupe": "TP1", "action": "degrouper"}).status_code == 303
    room.post(ada, "rendre")
    assert teacher.post(roster, data={**group, "action": "degrouper"}).status_code == 303


def test_archiving_says_first_who_still_sits_a_test(room: Room) -> None:
    settings = f"/classes/{room.made.id}/reglages"
    room.student()
    page = told(room.teacher.browser(room.site).get(settings))
    assert "1 élève compose en ce moment : Ada. 1 devoir en cours : Interro." in page


def test_a_release_is_taken_back_for_a_day(room: Room) -> None:
    ines = room.student(begins=False)
    assert room.post(room.teacher, "publier", action="reprendre").status_code == 409
    room.post(room.teacher, "publier")
    assert room.post(ines, "commencer").status_code == 409
    assert "Reprendre la publication" in room.teacher.browser(room.site).get(room.path).text
    assert room.post(room.teacher, "publier", action="reprendre").status_code == 303
    assert room.post(ines, "commencer").status_code == 303
    room.post(room.teacher, "publier")
    with room.site.database.write() as db:
        db.execute(update(Assignment).values(released_at=utc_now() - timedelta(days=1, minutes=1)))
    assert "Reprendre la publication" not in room.teacher.browser(room.site).get(room.path).text
    assert room.post(room.teacher, "publier", action="reprendre").status_code == 409
    with room.site.database.read() as db:
        actions = [event.what for event in db.scalars(select(AuditEvent))]
    assert actions.count(AuditAction.release_withdrawn) == 1


def test_a_copy_handed_in_by_mistake_is_reopened_and_its_clock_went_on(room: Room) -> None:
    ada = room.student()
    assert room.post(room.teacher, "rouvrir", eleve=str(ada.id)).status_code == 409  # it is still open
    room.post(ada, "rendre")
    assert room.send(ada).status_code == 409
    assert "Rouvrir une copie rendue par erreur" in room.teacher.browser(room.site).get(room.path).text
    assert room.post(ada, "rouvrir", eleve=str(ada.id)).status_code == 403
    assert room.post(room.teacher, "rouvrir", eleve="x").status_code == 404
    assert room.post(room.teacher, "rouvrir", eleve=str(ada.id)).status_code == 303
    assert room.send(ada).status_code == 202
    room.post(ada, "rendre")
    room.let_time_pass(61)
    refused = room.post(room.teacher, "rouvrir", eleve=str(ada.id))
    assert "accordez-lui d’abord un aménagement" in refused.text
    room.post(room.teacher, "publier")
    assert room.post(room.teacher, "rouvrir", eleve=str(ada.id)).status_code == 409


def test_answers_are_saved_and_sent_as_code_is(room: Room) -> None:
    name, page = "l20/calcul_odometrie", "/l20/exercices/calcul_odometrie"
    test = assign(room.site.database, room.made, name, mode=Mode.test)
    ada = room.student()
    browser = ada.browser(room.site)
    path = f"/classes/{room.made.id}/devoirs/{test.id}"
    browser.post(f"{path}/commencer")
    field = re.search(r'name="(q\.[^"]+)"', browser.get(page).text)
    assert field
    assert browser.post(f"{page}/brouillon", data={field[1]: "0,25"}, headers=FORM).status_code == 200
    assert 'value="0,25"' in browser.get(page).text
    browser.post(f"{path}/rendre")
    (sent,) = room.sent(ada)
    assert json.loads(sent.source) == {field[1].removeprefix("q."): "0,25"}
    assert sent.exercise == name


def test_practice_holds_back_diagnosis_hints_and_solution_until_its_dates(room: Room) -> None:
    shown = {"hints": Visibility.after_due, "diagnosis": Visibility.after_due, "solution": Visibility.never}
    with room.site.database.write() as db:
        db.execute(update(Assignment).values(mode=Mode.practice, due_at=utc_now() + 60 * MINUTE, **shown))
    ada = room.student(begins=False)

    def judged(sent: GradingInput) -> Judgement:
        verdict = fake_verdict(f"outcome: {room.outcome}", sent.seed)
        named = Diagnosis("secrete", "Une erreur nommée", "Voici.") if room.outcome != "ok" else None
        return Judgement(type(verdict)(**{**vars(verdict), "diagnosis": named}), {})

    room.outcome = "wrong_answer"
    worker = room.site.worker_with(judged)
    sent = room.send(ada, "x = 1").json()
    assert worker.run_one()
    browser = ada.browser(room.site)
    verdict = room.site.client.get(sent["url"], headers=ada.headers).json()["verdict"]
    assert (verdict["points"], verdict["diagnosis"]) == (10, None)
    archive = zipfile.ZipFile(io.BytesIO(browser.get("/compte/donnees").content))
    everything = b"".join(archive.read(name) for name in archive.namelist()).decode() + browser.get(PAGE).text
    assert "nommée" not in everything
    assert "secrete" not in everything
    page = told(browser.get(PAGE))
    assert "ne nomme pas les erreurs jusqu’au" in page
    assert "garde les indices fermés jusqu’au" in page
    room.outcome = "ok"
    room.send(ada, "x = 2")
    assert worker.run_one()
    assert "garde le corrigé fermé." in told(browser.get(PAGE))
    assert "Corrigé commenté" not in browser.get(PAGE).text
    with room.site.database.write() as db:
        db.execute(update(Assignment).values(due_at=utc_now() - MINUTE, solution=Visibility.after_due))
    assert "Une erreur nommée" in told(browser.get(f"/soumissions/{sent['id']}"))
    assert "Corrigé commenté" in browser.get(PAGE).text


def own_page(room: Room, who: Person) -> str:
    return told(who.browser(room.site).get(f"/classes/{room.made.id}"))


def test_the_class_s_page_leads_to_the_test_and_says_no_more_than_what_was_sent(room: Room) -> None:
    ada, eve = room.student(begins=False), room.student(begins=False)
    seen, watching = [], f"/classes/{room.made.id}/eleves/{ada.id}/comme"
    teacher = room.teacher.browser(room.site)

    def look() -> str:
        page = ada.browser(room.site).get(f"/classes/{room.made.id}").text
        watched = teacher.get(watching).text
        assert f'href="{room.path}/composer"' in page
        assert f'href="{room.path}/composer"' not in watched
        at = '<p class="button-row">'
        ends = 'id="place"'
        same = [told_in(text.split(at)[1].split(ends)[0]) for text in (page, watched)]
        for door in ("Mes objectifs ", "Ma copie · ", "Ajouter ces dates à mon agenda "):  # to the student's own pages
            same[0] = same[0].replace(door, "")
        assert same[0] == same[1]
        seen.append(same[0])
        return same[0]

    assign(room.site.database, room.made, EXERCISE, title="DM")
    assert "Commencer le contrôle : Interro" in look()
    room.post(ada, "commencer")
    for _ in range(2):
        room.send(ada, f"x = {len(seen)}")
    waiting = look()
    assert "Reprendre le contrôle : Interro" in waiting
    assert "• Composer, inverser et comparer des poses retenu le temps d’un contrôle" in waiting, "in practice too"
    assert "• Composer, inverser et comparer des poses envoyé" in waiting
    room.grade()
    assert look() == waiting, "nor whether it was graded"
    assert "Interro&nbsp;: vous composez jusqu’au" in told(ada.browser(room.site).get("/"))
    room.post(room.teacher, "publier")
    assert look() == waiting, "published while they still sit it"
    room.post(ada, "rendre")
    assert "note&nbsp;: 20 / 20" in look()
    assert "vous composez" not in told(ada.browser(room.site).get("/"))
    assert "Les résultats du contrôle" in own_page(room, eve)
    why = told(ada.browser(room.site).get(f"{room.path}/pourquoi"))
    assert "Commencé le" in why
    assert "rendu le" in why


def told_in(text: str) -> str:
    return re.sub(r"\s+", " ", re.sub(r"<[^>]*>", "", text))


def test_archiving_a_class_tells_nothing_that_a_test_holds_and_frees_who_never_began(room: Room) -> None:
    ada, bob = room.student(), room.student(begins=False)
    sent = room.send(ada).json()
    room.grade()
    room.teacher.browser(room.site).post(f"/classes/{room.made.id}/archiver", data={"archiver": "true"})
    assert room.site.client.get(sent["url"], headers=ada.headers).json()["verdict"] is None
    assert room.send(bob).status_code == 202
    assert room.post(room.teacher, "publier").status_code == 303
    room.post(ada, "rendre")
    assert room.site.client.get(sent["url"], headers=ada.headers).json()["verdict"]["points"] == 20


def test_a_test_that_holds_something_is_released_before_it_is_let_go(room: Room) -> None:
    ada, teacher = room.student(), room.teacher.browser(room.site)
    room.send(ada)
    room.grade()

    def changed(**fields: str) -> Any:
        form = {"titre": "Interro", "exercice": EXERCISE, "mode": "test", "duree": "60", "retard": "accept"}
        return teacher.post(f"{room.path}/modifier", data=form | fields)

    for refused in (changed(mode="practice", duree=""), changed(exercice="l20/calcul_odometrie")):
        assert refused.status_code == 422
        assert "publiez d’abord ses résultats" in told(refused)
    assert teacher.post(f"{room.path}/supprimer").status_code == 409
    address = f"{SEND}/{room.sent(ada)[0].id}"
    assert room.site.client.get(address, headers=ada.headers).json()["verdict"] is None
    room.post(room.teacher, "publier")
    assert "composent encore" in told(teacher.post(f"{room.path}/supprimer"))
    room.post(ada, "rendre")
    assert teacher.post(f"{room.path}/supprimer").status_code == 303


def test_nobody_s_time_is_ended_in_the_past(room: Room) -> None:
    ada, teacher = room.student(), room.teacher.browser(room.site)
    room.let_time_pass(30)
    room.send(ada)
    form = {"titre": "Interro", "exercice": EXERCISE, "mode": "test", "duree": "60", "retard": "accept"}
    form["ouvre"] = school_time.format_field(room.test.opens_at)
    past = school_time.format_field(utc_now() - 5 * MINUTE)
    for fields in ({"duree": "20"}, {"ferme": past}):
        refused = teacher.post(f"{room.path}/modifier", data=form | fields)
        assert (refused.status_code, "finirait dans le passé" in told(refused)) == (422, True)
    longer = {"eleve": str(ada.id), "temps": "1,33"}
    assert teacher.post(f"{room.path}/amenagements", data=longer).status_code == 303
    room.let_time_pass(40)
    with room.site.database.read() as db:
        (one,) = db.query(Exemption).all()
    assert teacher.post(f"{room.path}/amenagements/{one.id}/retirer").status_code == 409
    later = school_time.format_field(utc_now() + 60 * MINUTE)
    assert teacher.post(f"{room.path}/modifier", data=form | {"ouvre": later}).status_code == 303
    assert "vous composez" in own_page(room, ada), "whatever the dates become, who has begun goes on"
    assert room.send(ada, "x = 2").status_code == 202


def test_an_error_of_ours_is_told_and_one_may_send_again(room: Room) -> None:
    ada = room.student()
    room.outcome = "internal_error"
    sent = room.send(ada).json()
    room.grade()
    browser = ada.browser(room.site)
    answer = room.site.client.get(sent["url"], headers=ada.headers).json()
    assert (answer["verdict"], answer["held"]) == (None, True)
    assert "pas corrigé" in answer["notice"]
    for path in (f"/soumissions/{sent['id']}", PAGE):
        assert "mais pas corrigé : c’est une erreur de notre côté" in told(browser.get(path))
    assert "Pas corrigé, erreur de notre côté" in told(browser.get(f"{PAGE}/essais"))
    assert "1 envoi n’a pas été corrigé" in told(browser.get(f"{room.path}/composer"))
    room.outcome = "ok"
    again = room.send(ada, reuse=True)
    assert again.status_code == 202
    assert again.json()["id"] != sent["id"]
    room.grade()
    assert "pas corrigé" not in room.site.client.get(again.json()["url"], headers=ada.headers).json()["notice"]


def test_a_word_to_who_makes_a_mistake_waits_until_the_test_is_released(room: Room) -> None:
    ada = room.student()
    judged = replace(fake_verdict("outcome: wrong_answer", 1), diagnosis=Diagnosis("signe", "Signe", "…"))
    room.send(ada)
    while room.site.worker_with(lambda _: Judgement(judged)).run_one():
        pass

    def tell() -> int:
        with room.site.database.write() as db:
            teacher = db.merge(room.teacher.account)
            return notes.send_note_to_students(
                db, teacher, room.made, EXERCISE, "signe", "Relisez.", "", room.site.settings
            )[1]

    with pytest.raises(Conflict, match="retient ce diagnostic"):
        tell()
    room.post(room.teacher, "publier")
    room.post(ada, "rendre")
    assert tell() == 1


def test_another_assignment_with_the_same_exercise_tells_nothing_of_the_test(room: Room) -> None:
    assign(room.site.database, room.made, EXERCISE, title="Devoir maison")
    seen = {}
    for outcome in ("ok", "wrong_answer"):
        who = room.student()
        assert room.send(who).status_code == 202
        room.outcome = outcome
        room.grade()
        browser = who.browser(room.site)
        paths = ("/", "/l20", "/classes", *(f"/classes/{room.made.id}{end}" for end in ("", "/devoirs")))
        seen[outcome] = {path: told(browser.get(path)) for path in paths}
        room.take_out(who)
    for path, text in seen["ok"].items():
        assert alike(text) == alike(seen["wrong_answer"][path]), path
