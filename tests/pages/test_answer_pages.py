"""Pages of the exercises answered without code: forms that need no script, answers put back, and no secret told."""

from __future__ import annotations

import html
import re
from collections.abc import Mapping
from html.parser import HTMLParser
from typing import Any

import pytest

from graders.core.contract.findings import Judgement
from graders.core.contract.local import LOCAL
from server.course import Course
from server.grading.grading_task import GradingInput
from server.grading.sandbox_grader import SandboxGrader
from server.identity import links
from server.pages import marks
from server.pages.answers import FIELD, PLACE
from server.queue.worker import Worker
from server.sandbox import Sandbox
from server.submissions.models import Submission, Variant
from tests.submissions.test_answers import ODOMETRY, PROOF, QUIZ, stored
from tests.support.service import Site

JSON = {"Accept": "application/json"}


class Form(HTMLParser):
    """What a browser without script would send of a page's form, and the words in its attributes: but for the labels
    that are read aloud, which say what is written beside them."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.fields: list[tuple[str, str]] = []
        self.names: set[str] = set()
        self.words: set[str] = set()
        self._select = ""
        self.feed(text)

    def handle_starttag(self, tag: str, pairs: list[tuple[str, str | None]]) -> None:
        attributes = {name: value or "" for name, value in pairs}
        name = attributes.get("name", "")
        self.words.update(
            word for key, value in attributes.items() if key != "aria-label" for word in re.split(r"[.\s-]", value)
        )
        if tag == "select":
            self._select = name
        if tag == "option" and "selected" in attributes:
            self.fields.append((self._select, attributes["value"]))
        kept = attributes.get("type") == "text" or "checked" in attributes
        if tag == "input" and name.startswith(FIELD):
            self.fields += [(name, attributes.get("value", ""))] if kept else []
        if tag in {"input", "select"}:
            self.names.add(name)


@pytest.fixture
def worker(site: Site, course: Course, course_sandbox: Sandbox) -> Any:
    grader = SandboxGrader(course, course_sandbox)

    def grade(sent: GradingInput) -> Judgement:
        return grader.grade(sent.exercise, sent.source, sent.seed)

    return site.worker_with(grade)


def path_of(name: str) -> str:
    module, slug = name.split("/")
    return f"/{module}/exercices/{slug}"


def page(site: Site, path: str) -> str:
    answer = site.client.get(path)
    assert answer.status_code == 200, answer.text
    return str(answer.text)


def fields_of(name: str, answers: Mapping[str, Any]) -> dict[str, Any]:
    if name == PROOF:
        return {f"{PLACE}ordre.{letter}": str(place) for place, letter in enumerate(answers["ordre"], 1)}
    return {FIELD + key: value for key, value in answers.items()}


def right(site: Site, course: Course, name: str) -> dict[str, Any]:
    page(site, path_of(name))
    deal = next(row for row in stored(site.database, Variant) if row.exercise == name)
    grader = course.exercises[name].answers
    assert grader is not None
    return dict(grader.right_answers(deal.seed))


def sent(site: Site, name: str, fields: Mapping[str, Any], status: int = 303) -> str:
    answer = site.client.post(f"{path_of(name)}/soumissions", data=dict(fields))
    assert answer.status_code == status, answer.text
    return str(answer.headers.get("location", answer.text))


@pytest.mark.parametrize("name", [ODOMETRY, QUIZ, PROOF])
def test_a_form_without_script_is_sent_judged_and_put_back(
    site: Site, worker: Worker, course: Course, name: str
) -> None:
    answers = right(site, course, name)
    fields = fields_of(name, answers)
    assert fields.keys() <= Form(page(site, path_of(name))).names
    attempt = sent(site, name, fields)
    assert worker.run_one()
    assert "Exercice réussi" in page(site, attempt)
    (row,) = stored(site.database, Submission)
    again = Form(page(site, path_of(name))).fields
    expected = [
        (key, str(one)) for key, value in fields.items() for one in (value if isinstance(value, list) else [value])
    ]
    assert sorted(again) == sorted(expected)
    assert sorted(Form(page(site, f"{path_of(name)}?reprendre={row.id}")).fields) == sorted(expected)
    assert 'data-taken="true"' in page(site, f"{path_of(name)}?reprendre={row.id}")


def test_an_attempt_at_one_exercise_is_not_taken_up_in_another(site: Site, course: Course) -> None:
    sent(site, ODOMETRY, fields_of(ODOMETRY, right(site, course, ODOMETRY)))
    (row,) = stored(site.database, Submission)
    for other in (QUIZ, PROOF, "l20/poses"):
        assert site.client.get(f"{path_of(other)}?reprendre={row.id}").status_code == 404


@pytest.mark.parametrize("name", [ODOMETRY, QUIZ, PROOF])
def test_an_attempt_shows_its_answers_as_they_are_read(site: Site, worker: Worker, course: Course, name: str) -> None:
    attempt = sent(site, name, fields_of(name, right(site, course, name)))
    worker.run_one()
    text = page(site, attempt).split("Réponses envoyées")[1]
    assert '{"' not in text
    assert {ODOMETRY: "Rotation du robot", QUIZ: "plusieurs bosses", PROOF: "formule de Bayes"}[name] in text
    assert ("mrad" in text) == (name == ODOMETRY)


@pytest.mark.parametrize("name", [ODOMETRY, QUIZ, PROOF])
def test_the_correction_opens_with_success_and_not_before(
    site: Site, worker: Worker, course: Course, name: str
) -> None:
    answers = right(site, course, name)
    sent(site, name, {})
    worker.run_one()
    before = page(site, path_of(name))
    assert "Corrigé commenté" not in before
    sent(site, name, fields_of(name, answers))
    worker.run_one()
    after = page(site, path_of(name))
    told = {ODOMETRY: "mrad</strong>", QUIZ: "du graphe", PROOF: "Les intrus"}[name]
    assert told in after.split("Corrigé commenté")[1]


def test_a_teacher_reads_the_correction_of_the_draw_that_is_looked_at(
    site: Site, worker: Worker, course: Course
) -> None:
    right(site, course, ODOMETRY)
    attempt = sent(site, ODOMETRY, {f"{FIELD}ds": "1"})
    worker.run_one()
    seed = stored(site.database, Submission)[0].seed
    grader: Any = course.exercises[ODOMETRY].answers
    with site.database.write() as db:
        token = links.create_administrator_invitation(db)
    site.client.cookies.clear()
    form = {"name": "Mme Martin", "login": "martin", "password": "une phrase assez longue"}
    site.client.post(f"/bienvenue/{token}", data=form)
    assert (
        f"{grader.right_answers(seed)['ds']:.4g}".replace(".", ",") in page(site, attempt).split("Corrigé commenté")[1]
    )
    assert "Corrigé commenté" in page(site, path_of(QUIZ)), "at the first visit already"


@pytest.mark.parametrize("name", [QUIZ, PROOF])
def test_a_page_and_a_blank_verdict_tell_no_secret(site: Site, worker: Worker, course: Course, name: str) -> None:
    page(site, path_of(name))
    attempt = sent(site, name, {})
    worker.run_one()
    grader: Any = course.exercises[name].answers
    pieces = [one for q in grader.questions for one in q.options] if name == QUIZ else grader.sheet.pieces
    public = {one.id for one in grader.questions} if name == QUIZ else set()
    names = {one.id for one in pieces} - public
    for path in (path_of(name), attempt, f"{attempt}/verdict"):
        text = re.sub(r"\s+", " ", page(site, path))
        form = text.split('id="essai"')[-1].split("</form>")[0]
        assert names & Form(form).words == set()
        reasons = [getattr(one, "why", getattr(one, "role", "")).split("'")[0][:25] for one in pieces]
        assert [one for one in reasons if len(one) > 15 and one in text] == []


def beside(text: str, question: str) -> str:
    """What a page says from the head of a question to the next question."""
    parts = re.split(r'id="question-(\w+)"', text)
    return html.unescape(re.sub(r"<[^>]+>", " ", parts[parts.index(question) + 1]))


def test_each_question_is_marked_in_its_place(site: Site, worker: Worker, course: Course) -> None:
    answers = right(site, course, QUIZ)
    grader: Any = course.exercises[QUIZ].answers
    seed = stored(site.database, Variant)[0].seed
    letters = {question.id: question.letters(seed).by_name for question in grader.questions}
    del answers["tf"]
    answers |= {"amcl": letters["amcl"]["precision"], "fermeture": answers["fermeture"][:1]}
    attempt = sent(site, QUIZ, fields_of(QUIZ, answers))
    worker.run_one()
    for path in (path_of(QUIZ), attempt):
        text = page(site, path)
        for question, told in {
            "amcl": [
                "À revoir",
                "essai n° 1" if path != attempt else "0 /",
                "fait aussi bien",
                "toujours moins précis",
            ],
            "fermeture": ["En partie juste", "il manque au moins une bonne réponse"],
            "tf": ["Sans réponse"],
            "jauge": ["Juste", "Pourquoi c’est juste"],
        }.items():
            said = re.sub(r"\s+", " ", beside(text, question)).replace("\u00a0", " ")
            assert [one for one in told if one not in said] == [], (path, question, said)
        assert "Répondu : " + answers["amcl"] in re.sub(r"\s+", " ", beside(text, "amcl")) or path == attempt
        assert "plusieurs poses expliquent" not in text, "what was not ticked is not explained"
        links = re.findall(r'class="check-line" href="#(question-\w+)"', text)
        assert links == [f"question-{question.id}" for question in grader.questions]
        assert all(f'id="{link}"' in text for link in links)
    parts = re.findall(r'data-part="mark-(\w+)"', page(site, f"{attempt}/verdict"))
    assert parts == [question.id for question in grader.questions]


def test_marks_go_where_the_next_verdict_says_nothing_of_a_question(site: Site, worker: Worker, course: Course) -> None:
    sent(site, QUIZ, fields_of(QUIZ, right(site, course, QUIZ)))
    worker.run_one()
    assert 'class="question-mark question-mark-good"' in page(site, path_of(QUIZ))
    attempt = sent(site, QUIZ, {})
    worker.run_one()
    for path in (path_of(QUIZ), f"{attempt}/verdict"):
        text = page(site, path)
        assert len(re.findall(r'data-part="mark-\w+"[^>]* class="question-mark" hidden>', text)) == 34
        assert "question-mark-" not in text


def test_another_deal_has_no_marks(site: Site, worker: Worker, course: Course) -> None:
    sent(site, QUIZ, fields_of(QUIZ, right(site, course, QUIZ)))
    exercise, (row,) = course.exercises[QUIZ], stored(site.database, Submission)
    verdict = exercise.grader.grade(row.source, LOCAL, seed=row.seed, version="").verdict
    assert {mark.tone for mark in marks.build_question_marks(exercise, row, verdict, row.seed)} == {"good"}
    assert {mark.tone for mark in marks.build_question_marks(exercise, row, verdict, row.seed + 1)} == {"none"}
    assert {mark.tone for mark in marks.build_question_marks(exercise, row, None, row.seed)} == {"none"}


def test_numbers_are_typed_by_hand_and_come_back_as_typed(site: Site, worker: Worker) -> None:
    page(site, path_of(ODOMETRY))
    attempt = sent(site, ODOMETRY, {f"{FIELD}ds": " 0,1 ", f"{FIELD}x": '"><script>alert(1)</script>', f"{FIELD}y": ""})
    worker.run_one()
    (row,) = stored(site.database, Submission)
    assert row.code == '{"ds":"0,1","x":"\\"><script>alert(1)</script>"}'
    for path in (attempt, path_of(ODOMETRY)):
        text = page(site, path)
        assert "<script>alert" not in text
        assert "&lt;script&gt;alert(1)" in text
    assert 'value="0,1"' in page(site, path_of(ODOMETRY))


def test_two_steps_in_one_place_are_refused_in_a_sentence(site: Site) -> None:
    page(site, path_of(PROOF))
    told = sent(site, PROOF, {f"{PLACE}ordre.a": "1", f"{PLACE}ordre.b": "1"}, status=422)
    assert "même numéro" in told
    assert stored(site.database, Submission) == []


@pytest.mark.parametrize("value", ["-1", "0", "1e3", "٣", "99999", "x", "1.0", " "])
def test_a_place_that_is_none_leaves_the_step_aside(site: Site, value: str) -> None:
    page(site, path_of(PROOF))
    sent(site, PROOF, {f"{PLACE}ordre.a": value, f"{PLACE}ordre.b": "7"})
    assert stored(site.database, Submission)[0].code == '{"ordre":["b"]}'


def test_a_file_in_place_of_a_field_is_no_answer(site: Site) -> None:
    page(site, path_of(ODOMETRY))
    answer = site.client.post(f"{path_of(ODOMETRY)}/soumissions", files={f"{FIELD}ds": ("a.txt", b"1")}, headers=JSON)
    assert answer.status_code == 202
    assert stored(site.database, Submission)[0].code == "{}"
    answer = site.client.post("/l20/exercices/poses/soumissions", files={"code": ("a.py", b"x")}, headers=JSON)
    assert answer.status_code == 422


def test_blank_answers_open_no_hint(site: Site, worker: Worker) -> None:
    page(site, path_of(QUIZ))
    sent(site, QUIZ, {})
    worker.run_one()
    assert "(encore 1)" not in page(site, path_of(QUIZ))
    assert page(site, path_of(QUIZ)).count("hint-closed") == 3
