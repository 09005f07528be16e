"""Small calculations and choices: what was confused in an exercise of numbers or choices, asked again."""

from __future__ import annotations

from datetime import timedelta
from uuid import uuid4

import pytest
from sqlalchemy import select

from graders.core.answers.numeric import NumericGrader
from server.assignments.models import Mode
from server.base.errors import Invalid
from server.course import Course
from server.database import utc_now
from server.identity.models import Account, Role
from server.recall import calculations, retrievals
from server.recall.models import RecallAnswer
from tests.support.classes import assign, new_class, person, seat
from tests.support.crowd import Sent, store
from tests.support.quick import the_course
from tests.support.service import Site

PATH, EXERCISE = "/deux-minutes", "l20/calcul_odometrie"
ADA = Account(id=uuid4(), role=Role.student)


def mistakes_of(course: Course, exercise_id: str) -> list[str]:
    answers = course.exercises[exercise_id].answers
    assert answers is not None
    return list(answers.catalogue)


@pytest.mark.parametrize("exercise_id", [EXERCISE, "l20/calcul_kabsch", "l20/verification"])
def test_each_mistake_has_a_question_that_tells_it_from_the_right_answer(course: Course, exercise_id: str) -> None:
    for name in mistakes_of(course, exercise_id):
        asked = calculations.draw_calculation(course, exercise_id, name, ADA, retrievals.today_at_school())
        grader = asked.exercise.answers
        assert grader is not None
        right = grader.right_answers(asked.seed)[asked.question.id]
        letters = right if isinstance(right, list) else [str(right)]
        assert calculations.mark_calculation(asked, letters).is_right, name
        if isinstance(grader, NumericGrader):
            wrong = [str(grader.answers_with_mistake(name, asked.seed, follow=False)[asked.question.id])]
        else:
            wrong = [piece.id for piece in asked.question.pieces if piece.id not in letters][:1]
        marked = calculations.mark_calculation(asked, wrong)
        assert not marked.is_right
        assert marked.message
        for typed in ([], ["douze ans"]):
            with pytest.raises(Invalid):
                calculations.mark_calculation(asked, typed)


def test_a_calculation_comes_back_with_fresh_numbers_and_not_during_a_test(site: Site) -> None:
    ada, course, ago = person(site), the_course(), utc_now() - timedelta(days=3)
    browser, name = ada.browser(site), mistakes_of(the_course(), EXERCISE)[0]
    sent = [Sent(ada.id, EXERCISE, ago, 0.5, name), Sent(ada.id, EXERCISE, ago + timedelta(minutes=9), 1.0)]
    store(site.database, sent)
    assert "1 question" in browser.get("/").text.replace("\u202f", " ").replace("\xa0", " ")
    assert f'name="erreur" value="{name}"' in browser.get(PATH).text
    day = retrievals.today_at_school()
    asked = calculations.draw_calculation(course, EXERCISE, name, ada.account, day)
    later = calculations.draw_calculation(course, EXERCISE, name, ada.account, day + timedelta(days=1))
    assert [datum.text for datum in asked.given] != [datum.text for datum in later.given]
    form = {"exercice": EXERCISE, "erreur": name, "jour": day.isoformat()}
    refused = browser.post(f"{PATH}/calculs", data={**form, "valeur": "douze"}).text
    assert 'value="douze"' in refused
    assert "n’est pas lue" in refused
    assert browser.post(f"{PATH}/calculs", data={**form, "jour": "2026-01-05", "valeur": "1"}).status_code == 409
    made = new_class(site.database, person(site, Role.teacher).account)
    seat(site.database, made, ada.account)
    test = assign(site.database, made, EXERCISE, mode=Mode.test)
    assert 'id="deux-minutes"' not in browser.get("/").text
    assert browser.post(f"{PATH}/calculs", data={**form, "valeur": "1"}).status_code == 409
    with site.database.write() as db:
        db.delete(db.merge(test))
    grader = asked.exercise.answers
    assert grader is not None
    right = grader.right_answers(asked.seed)[asked.question.id]
    page = browser.post(f"{PATH}/calculs", data={**form, "valeur": str(right).replace(".", ",")}).text
    assert "✓ Juste." in page
    assert "Terminer" in page
    with site.database.read() as db:
        stored = db.execute(select(RecallAnswer)).scalar_one()
        assert (stored.kind, stored.misconception, stored.is_right) == ("calculation", name, True)
    assert 'id="deux-minutes"' not in browser.get("/").text
