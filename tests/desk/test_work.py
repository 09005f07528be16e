"""One student as their teacher reads them: exercises, attempts, what each changed; questions; words to several."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from datetime import timedelta
from uuid import UUID, uuid4

import pytest

from graders.core.contract.findings import Judgement
from graders.core.contract.verdict import Diagnosis
from server.classes.models import ClassRole, Membership, SchoolClass
from server.comments.models import Message, Thread, ThreadState
from server.database import utc_now
from server.gradebook import service as gradebook
from server.gradebook.schemas import GradingResult
from server.identity.models import Role
from server.submissions.models import Submission
from server.submissions.service import digest_code
from tests.support.classes import Person, new_class, person, seat
from tests.support.client import TestClient
from tests.support.counting import Counted
from tests.support.service import EXERCISE, Site, fake_verdict

WRONG = "# outcome: wrong_answer\n"


@dataclass
class Desk:
    site: Site
    made: SchoolClass
    ada: Person
    staff: TestClient
    sent: list[UUID] = field(default_factory=list)

    @property
    def href(self) -> str:
        return f"/classes/{self.made.id}"

    @property
    def work(self) -> str:
        return f"{self.href}/eleves/{self.ada.id}/{EXERCISE}"

    def send(self, *codes: str, mistake: str = "", by: Person | None = None) -> None:
        with self.site.database.write() as db:
            for code in codes:
                verdict = fake_verdict(code, 1)
                if mistake:
                    verdict = replace(verdict, diagnosis=Diagnosis(mistake, f"Titre de {mistake}", "Pourquoi."))
                row = {"source": code.encode(), "digest": digest_code(code), "seed": 1, "created_at": utc_now()}
                sent = Submission(account_id=(by or self.ada).id, exercise=EXERCISE, **row)
                db.add(sent)
                db.flush()
                gradebook.record_grading(db, sent.id, GradingResult(Judgement(verdict), utc_now()))
                self.sent.append(sent.id)

    def get(self, path: str, status: int = 200) -> str:
        answer = self.staff.get(path)
        assert answer.status_code == status, answer.text
        return answer.text


@pytest.fixture
def desk(site: Site) -> Desk:
    teacher, ada = person(site, Role.teacher, name="Mme Martin"), person(site)
    made = new_class(site.database, teacher.account)
    seat(site.database, made, ada.account, given_name="Ada", family_name="Lovelace", groups=["TP1"])
    return Desk(site, made, ada, teacher.browser(site))


def test_a_student_s_exercises_with_where_they_stand(desk: Desk) -> None:
    desk.send(WRONG, mistake="signe")
    page = desk.get(f"{desk.href}/eleves/{desk.ada.id}")
    assert f'href="{desk.work}"' in page
    assert "pas encore réussi" in page
    assert "Titre de signe" in page
    assert "Ada Lovelace" in page
    desk.send("x = 1\n")
    page = desk.get(f"{desk.href}/eleves/{desk.ada.id}")
    assert "1 exercice réussi sur" in page
    assert "Titre de signe" not in page
    assert f'href="{desk.href}/eleves/{desk.ada.id}"' in desk.get(f"{desk.href}/eleves")


def test_what_each_attempt_changed_is_shown_with_signs(desk: Desk) -> None:
    desk.send(f"{WRONG}a = 1\nb = 2\n", f"{WRONG}a = 1\nb = 3\nc = 4\n", "<b>tout</b>\n")
    page = desk.get(f"{desk.work}?essai=2")
    assert f'href="/soumissions/{desk.sent[0]}"' in page
    cells = re.findall(r'<td class="side side-(\w+)">.*?<code>(.*?)</code>', page)
    assert cells == [("removed", "b = 2"), ("added", "b = 3"), ("added", "c = 4")]
    assert page.count('aria-hidden="true">−</span>') == 1
    assert "1 ligne retirée" in page
    latest = desk.get(desk.work)
    assert "De l’essai n° 2 à l’essai n° 3" in latest
    assert "&lt;b&gt;tout&lt;/b&gt;" in latest
    assert "<b>tout</b>" not in latest
    assert 'class="difference"' not in desk.get(f"{desk.work}?essai=1")
    desk.get(f"{desk.work}?essai=4", 404)
    desk.get(f"{desk.work}?page=2", 404)
    for refused in ("essai=0", "essai=zut", f"essai={10**30}", "page=0"):
        desk.get(f"{desk.work}?{refused}", 422)


def test_only_the_class_s_students_and_exercises_are_there(desk: Desk) -> None:
    stranger = person(desk.site, name="Inconnu")
    staff = person(desk.site, name="Aide")
    seat(desk.site.database, desk.made, staff.account, ClassRole.assistant)
    asking = person(desk.site, name="Demande")
    seat(desk.site.database, desk.made, asking.account, status="pending")
    for nobody in (stranger.id, staff.id, asking.id, uuid4()):
        desk.get(f"{desk.href}/eleves/{nobody}", 404)
        desk.get(f"{desk.href}/eleves/{nobody}/{EXERCISE}", 404)
    desk.get(f"{desk.href}/eleves/zut", 422)
    desk.get(f"{desk.href}/eleves/{desk.ada.id}/l20/zut", 404)
    desk.get(f"{desk.href}/eleves/{desk.ada.id}/l21/poses", 404)
    assert person(desk.site, account=staff.account).browser(desk.site).get(desk.work).status_code == 200


def test_what_is_sent_after_leaving_is_not_shown(desk: Desk) -> None:
    desk.send(WRONG)
    with desk.site.database.write() as db:
        membership = db.get(Membership, (desk.made.id, desk.ada.id))
        assert membership
        membership.status, membership.left_at = "left", utc_now()
    desk.send("x = 'après'\n")
    for path in (desk.work, f"{desk.href}/eleves/{desk.ada.id}"):
        page = desk.get(path)
        assert "n’est pas montré" in page
        assert "après&#39;" not in page
        assert str(desk.sent[1]) not in page
    desk.get(f"{desk.work}?essai=2", 404)
    assert "0 exercice réussi" in desk.get(f"{desk.href}/eleves/{desk.ada.id}")
    assert desk.staff.post(desk.work, data={"texte": "Bonjour"}).status_code == 404


def test_a_comment_on_the_work_and_its_refusal(desk: Desk) -> None:
    answer = desk.staff.post(desk.work, data={"texte": "Courage", "garder": "oui"})
    assert answer.headers["location"].startswith(f"{desk.work}#fil-")
    assert desk.get(desk.work).count("Courage") >= 2  # the comment and the phrase that was kept
    refused = desk.staff.post(desk.work, data={"texte": "x" * 5000})
    assert (refused.status_code, "trop long" in refused.text) == (422, True)
    assert desk.staff.post(desk.work, data={"texte": "x", "phrase": "zut"}).status_code == 404


def ask(desk: Desk, count: int, state: ThreadState = ThreadState.open, who: Person | None = None) -> None:
    with desk.site.database.write() as db:
        for number in range(count):
            at = utc_now() + timedelta(seconds=number)
            account_id = (who or desk.ada).id
            thread = Thread(
                account_id=account_id, exercise=EXERCISE, work_at=utc_now(), by_staff=False, state=state,
                check_title="", changed_at=at,
            )  # fmt: skip
            db.add(thread)
            db.flush()
            text = f"Question {number} <script>"
            db.add(Message(thread_id=thread.id, author_id=account_id, as_staff=False, text=text, created_at=at))


def test_the_questions_of_a_class_newest_first_by_state(desk: Desk) -> None:
    ask(desk, 51)
    ask(desk, 1, ThreadState.settled)
    ask(desk, 1, who=person(desk.site, name="Étrangère"))
    page = desk.get(f"{desk.href}/questions")
    assert "À répondre (51)" in page
    found = [int(number) for number in re.findall(r"Question (\d+) &lt;script&gt;", page)]
    assert found == list(range(50, 0, -1))
    assert "Étrangère" not in page
    assert len(re.findall(r"Question 0 ", desk.get(f"{desk.href}/questions?page=2"))) == 1
    assert "Réglés (1)" in desk.get(f"{desk.href}/questions?etat=reglees")
    assert "Rien ici" in desk.get(f"{desk.href}/questions?etat=repondues")
    desk.get(f"{desk.href}/questions?etat=zut", 422)
    assert "51 questions sans réponse" in desk.get("/classes")


def test_pages_ask_as_much_for_many_rows_as_for_few(desk: Desk) -> None:
    counts = []
    desk.get(f"{desk.href}/questions")  # a first visit is noted
    for many in (1, 7):
        desk.send(*[f"{WRONG}x = {number}" for number in range(many)], mistake="signe")
        ask(desk, many)
        for path in (f"/eleves/{desk.ada.id}", f"/eleves/{desk.ada.id}/{EXERCISE}", "/questions", "/mots"):
            with Counted(desk.site.database) as counted:
                desk.staff.get(desk.href + path)
            counts.append(len(counted.statements))
    assert counts[:4] == counts[4:]
    assert max(counts) <= 14


def test_a_word_to_who_has_a_mistake_now(desk: Desk) -> None:
    bob = person(desk.site, name="Bob")
    seat(desk.site.database, desk.made, bob.account)
    desk.send(WRONG, mistake="signe")
    desk.send(WRONG, mistake="signe", by=bob)
    desk.send("x = 1\n", by=bob)
    form = desk.get(f"{desk.href}/mots?exercice=l20%2Fposes&erreur=signe")
    assert "Titre de signe (1)" in form
    assert "Envoyer à 1 élève<" in form
    word = {"exercice": EXERCISE, "erreur": "signe", "texte": "Relisez.", "lien": "/l20/lire/localiser"}
    for wrong, said in (
        ({"lien": "https://evil.example"}, "Choisissez une page"),
        ({"texte": " "}, "Écrivez d’abord"),
        ({"erreur": "autre"}, "Aucun élève"),
    ):
        refused = desk.staff.post(f"{desk.href}/mots", data={**word, **wrong})
        assert (refused.status_code in {409, 422}, said in refused.text) == (True, True)
    assert desk.staff.post(f"{desk.href}/mots", data={**word, "exercice": "l20/zut"}).status_code == 404
    assert desk.staff.post(f"{desk.href}/mots", data=word).headers["location"] == f"{desk.href}/mots#dits"
    page = f"/l20/exercices/{EXERCISE.partition('/')[2]}"
    assert "Relisez." in desk.ada.browser(desk.site).get(page).text
    assert "Relisez." not in bob.browser(desk.site).get(page).text
    assert "lu par 0 sur 1" in desk.get(f"{desk.href}/mots")


def test_a_student_is_told_on_the_page_of_their_classes(desk: Desk) -> None:
    thread = desk.staff.post(desk.work, data={"texte": "Courage"}).headers["location"].partition("#fil-")[2]
    browser = desk.ada.browser(desk.site)
    assert f'href="/fils/{thread}"' in browser.get("/classes").text
    assert "Courage" in browser.get(f"/fils/{thread}").text
    assert f'href="/fils/{thread}"' not in browser.get("/classes").text
