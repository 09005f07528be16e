"""The questions with which a class begins a lesson: chosen from what its students confused, answered, projected."""

from __future__ import annotations

import html
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from datetime import timedelta
from uuid import UUID, uuid4

import pytest
from httpx2 import Response
from sqlalchemy import select

from server.base.app_services import add_services, get_service
from server.board.live import LiveClassViews
from server.classes.models import SchoolClass
from server.course import Course
from server.database import utc_now
from server.hunts.protocol import (
    AnswerComparison,
    ComparedAnswer,
    ComparisonRequest,
    HuntName,
    HuntQuestion,
    HuntReply,
)
from server.hunts.service import HuntService
from server.identity.models import Role
from server.recall.models import QuestionKind, RecallAnswer
from server.recall.scheduling import Review
from server.recall.service import RecallCandidate
from server.warmup.making import build_retrieval_question
from server.warmup.models import WarmUp
from server.warmup.needs import StudentRecallHistory, SubjectReviewNeed, rank_subjects_to_review
from tests.support.classes import Person, new_class, person, seat
from tests.support.crowd import Sent, seated, store
from tests.support.service import EXERCISE, Site
from tests.support.streams import parts_of

WRONG = "rotation_oubliee"
CALL = "composer([0, 0, pi/2], [1, 0, 0])"


@dataclass
class Process:
    """Runs nothing: compares the answers to one call."""

    asked: list[HuntQuestion] = field(default_factory=list)

    async def __call__(self, question: bytes, *, reader: str, flow: str, rank: int = 0) -> bytes:
        self.asked.append(HuntQuestion.model_validate_json(question))
        hunt = HuntName(exercise=EXERCISE, misconception=WRONG, function="composer")
        wrong = (ComparedAnswer(misconception=WRONG, words="[1 ; 0 ; π/2]"),)
        found = AnswerComparison(index=0, hunt=hunt, call=CALL, right="[0 ; 1 ; π/2]", wrong=wrong)
        return HuntReply(comparison=found).model_dump_json().encode()


def read(response: Response) -> str:
    """Return the text of a page, its spaces plain."""
    return " ".join(html.unescape(re.sub(r"<[^>]+>", " ", response.text)).split())


@pytest.fixture
def process(site: Site) -> Process:
    fake = Process()
    add_services(site.app, replace(get_service(site.app, HuntService), ask=fake))
    return fake


@pytest.fixture
def martin(site: Site) -> Person:
    return person(site, Role.teacher, "Mme Martin")


def confused_class(site: Site, martin: Person, confused: int) -> tuple[SchoolClass, Sequence[UUID]]:
    """A class of six, of whom so many confused the same thing and mended it five days ago."""
    made = new_class(site.database, martin.account)
    students = seated(site.database, made, 6)
    ago = utc_now() - timedelta(days=5)
    sent = [
        attempt
        for student in students[:confused]
        for attempt in (
            Sent(student, EXERCISE, ago, 0.2, WRONG),
            Sent(student, EXERCISE, ago + timedelta(hours=1), 1.0),
        )
    ]
    store(site.database, sent)
    return made, students


def test_a_class_begins_with_what_five_confused_and_answers_come_back_to_the_schedule(
    site: Site, martin: Person, process: Process
) -> None:
    made, _ = confused_class(site, martin, 5)
    ada = person(site, name="Ada")
    seat(site.database, made, ada.account)
    page, teacher, student = f"/classes/{made.id}/pour-commencer", martin.browser(site), ada.browser(site)
    assert "Pas de question" in student.get(page).text
    assert student.post(page).status_code == 403
    assert teacher.get(f"{page}/projeter").status_code == 404
    for _ in range(2):
        assert teacher.post(page).status_code == 303
    assert len(process.asked) == 1, "the questions of a day are made once"
    asked = process.asked[0].hunts
    assert isinstance(asked, ComparisonRequest)
    assert asked.hunts[0] == HuntName(exercise=EXERCISE, misconception=WRONG)
    with site.database.read() as db:
        question = db.execute(select(WarmUp)).scalar_one().questions[0]
    right = question["right"]
    shown = read(student.get(page))
    assert CALL in shown
    assert "rotation" not in shown.lower(), "no mistake is named before one answers"
    assert "1 question</a>, sans note" in student.get(f"/classes/{made.id}").text.replace("\xa0", " ")
    wrong = next(option["id"] for option in question["options"] if option["id"] != right)
    assert student.post(f"{page}/reponses", data={"question": "1", "reponse": "Z"}).status_code == 422
    assert student.post(f"{page}/reponses", data={"question": "2", "reponse": right}).status_code == 404
    for letter in (wrong, right):  # the first answer stays
        assert student.post(f"{page}/reponses", data={"question": "1", "reponse": letter}).status_code == 303
    assert "la réponse était [0 ; 1 ; π/2]" in read(student.get(page))
    assert "vous avez répondu" in read(student.get(f"/classes/{made.id}"))
    with site.database.read() as db:
        stored = db.execute(select(RecallAnswer)).scalar_one()
        assert (stored.account_id, stored.kind, stored.is_right) == (ada.id, QuestionKind.calculation, False)
        assert stored.misconception == WRONG
    wall = read(teacher.get(f"{page}/projeter"))
    assert "1 réponse sur 7 élèves" in wall
    assert "✓" not in wall, "the right answer is shown when it is asked for"
    told = read(teacher.get(f"{page}/projeter?question=1&reponses=oui"))
    assert "✓ 0" in told
    assert "Ada" not in wall + told + read(teacher.get(page))


def test_answers_are_counted_live_and_relapses_when_asked_for(site: Site, martin: Person, process: Process) -> None:
    made, _ = confused_class(site, martin, 5)
    ada = person(site, name="Ada")
    seat(site.database, made, ada.account)
    page, teacher = f"/classes/{made.id}/pour-commencer", martin.browser(site)
    get_service(site.app, LiveClassViews).max_stream_seconds = 0.0
    assert "event: parts" not in teacher.get(f"{page}/evenements").text, "nothing was prepared"
    teacher.post(page)
    shown = teacher.get(page).text
    assert f'data-stream="{page}/evenements"' in shown
    assert "Pas encore assez de cas" not in shown
    assert "Pas encore assez de cas" in teacher.get(f"{page}?utile=oui").text

    def parts(query: str = "") -> dict[str, str]:
        return parts_of(teacher.get(f"{page}/evenements{query}").text)

    assert "0 réponse sur 7 élèves" in parts()["answers-1"].replace("\xa0", " ")
    ada.browser(site).post(f"{page}/reponses", data={"question": "1", "reponse": "A"})
    assert "1 réponse sur 7 élèves" in parts()["answers-1"].replace("\xa0", " ")
    assert parts("?mur=oui").keys() == {"answered"}, "the wall shows what was chosen once one asks for it"
    assert "warm-up-right" in parts("?mur=oui&reponses=oui")["options"]
    assert "Ada" not in teacher.get(f"{page}/evenements").text


@pytest.mark.parametrize("confused", [1, 4])
def test_what_fewer_than_five_confused_is_not_projected(
    site: Site, martin: Person, process: Process, confused: int
) -> None:
    made, _ = confused_class(site, martin, confused)
    refused = martin.browser(site).post(f"/classes/{made.id}/pour-commencer")
    assert refused.status_code == 409
    assert "Rien à revoir tous ensemble" in read(refused)
    assert process.asked == []


def test_subjects_of_most_students_come_first_and_those_that_nobody_is_to_see_do_not() -> None:
    now = utc_now()
    long_ago, just_now = now - timedelta(days=9), now - timedelta(minutes=5)
    candidate = RecallCandidate(EXERCISE, WRONG)

    def memory(**reviews: Sequence[Review]) -> StudentRecallHistory:
        return StudentRecallHistory(reviews, {name: [candidate] for name in reviews}, ())

    failed = [Review(long_ago, False)]
    both = {uuid4(): memory(angle=failed, frame=failed, fresh=[Review(just_now, False)]) for _ in range(5)}
    one_more = {uuid4(): memory(frame=failed)}
    still = {uuid4(): StudentRecallHistory({}, {"open": [candidate]}, {"open"}) for _ in range(7)}
    ranked = rank_subjects_to_review(both | one_more | still, now)
    assert [(need.subject, need.students_to_review) for need in ranked] == [("open", 7), ("frame", 6), ("angle", 5)]
    assert ranked[0].candidates == (candidate,)


def test_a_lesson_s_number_becomes_a_choice_among_the_answers_of_known_mistakes(course: Course) -> None:
    module = course.modules["l20"]
    need = SubjectReviewNeed("rappel:", 5, 5, ())
    made = {name: build_retrieval_question(module, name, need, seed=3) for name in module.retrievals}
    questions = [question for question in made.values() if question is not None]
    assert len(questions) > 0.8 * len(made)
    for question in questions:
        words = [option.words for option in question.options]
        assert len(set(words)) == len(words) >= 2
        option = question.find_option(question.right)
        assert option is not None
        assert not option.why, "the right answer is explained by the question itself"
