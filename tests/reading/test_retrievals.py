"""Retrieval questions, and exercises and parts for later in a text: what is drawn, marked, stored, folded."""

from __future__ import annotations

from datetime import timedelta

import pytest

from graders.core.answers.retrieval import (
    RetrievalQuestion,
    UnreadableAnswerError,
    WrongAnswer,
    find_question_fault,
)
from server.course.lengths import duration_in_words, estimate_exercise_minutes, estimate_reading_minutes
from server.recall import repository, retrievals
from tests.support.classes import person
from tests.support.quick import the_course
from tests.support.service import Site
from tests.support.small_course import CourseFolder
from tests.support.small_site import SmallSite
from tests.support.texts_on_disk import page, problems, write_page

NUMBER = RetrievalQuestion("Combien ?", 4.0, "Deux fois deux.", (WrongAnswer(5.0, "Un de trop."),), unit="m")
CHOICE = RetrievalQuestion("Quoi ?", "A", "Parce que.", (WrongAnswer("B", "Non."), WrongAnswer("C", "Non plus.")))
JSON = {"Accept": "application/json"}
PATHS = """
[[paths]]
name = "court"
title = "Je suis pressé"
summary = "Le strict nécessaire."
page = "une"
exercises = ["a"]
"""
QUESTIONS = """
from graders.core.answers.retrieval import RetrievalQuestion, WrongAnswer


def somme(rng):
    a = int(rng.integers(2, 90))
    wrong = (WrongAnswer(float(a), "Rien d’ajouté."),)
    return RetrievalQuestion(f"Combien font {a} + 1 ?", float(a + 1), "On ajoute.", wrong)
"""
BODY = """Un début.

::: redire somme
:::

::: faire a
:::

::: plus-tard court Le détail
Trois mots de détail.
:::
"""


@pytest.mark.parametrize(
    ("question", "typed", "is_right", "words"),
    [
        (NUMBER, "4,0", True, "Deux fois deux."),
        (NUMBER, "8/2", True, "Deux fois deux."),
        (NUMBER, "5", False, "Un de trop. La réponse était 4\u00a0m. Deux fois deux."),
        (NUMBER, "17", False, "La réponse était 4\u00a0m. Deux fois deux."),
    ],
)
def test_an_answer_is_marked_with_its_reason(
    question: RetrievalQuestion, typed: str, is_right: bool, words: str
) -> None:
    marking = question.mark(typed, 0)
    assert (marking.is_right, marking.why) == (is_right, words)


def test_a_choice_is_marked_by_the_letters_of_its_seed() -> None:
    orders = {tuple(words for _, words in CHOICE.options(seed)) for seed in range(20)}
    assert len(orders) > 1
    for seed in range(5):
        for letter, words in CHOICE.options(seed):
            assert CHOICE.mark(letter, seed).is_right == (words == "A")
    for nothing in ("", "z", "A", "ab"):
        with pytest.raises(UnreadableAnswerError):
            CHOICE.mark(nothing, 0)
    with pytest.raises(UnreadableAnswerError, match="vide"):
        NUMBER.mark(" ", 0)


@pytest.mark.parametrize(
    ("question", "fault"),
    [
        (RetrievalQuestion("Q", 4.0, "W", (WrongAnswer(4.001, "N"),)), "compté juste"),
        (RetrievalQuestion("Q", 4.0, "W", ()), "aucune réponse fausse"),
        (RetrievalQuestion("Q", "A", "W", (WrongAnswer("A", "N"),)), "s’écrivent pareil"),
        (RetrievalQuestion("Q", "A", "W", ()), "de 2 à 5"),
        (RetrievalQuestion("Q", "A", "W", (WrongAnswer(1.0, "N"),)), "toutes des nombres"),
        (RetrievalQuestion("Q", float("nan"), "W", (WrongAnswer(1.0, "N"),)), "fini"),
        (RetrievalQuestion("Q", 1.0, " ", (WrongAnswer(2.0, "N"),)), "il manque un texte"),
    ],
)
def test_a_question_at_fault_is_told(question: RetrievalQuestion, fault: str) -> None:
    assert fault in find_question_fault(question)
    assert not find_question_fault(NUMBER)
    assert not find_question_fault(CHOICE)


def test_numbers_are_of_an_account_and_a_day(site: Site) -> None:
    module, day = the_course().modules["l20"], retrievals.today_at_school()
    ada, bob = person(site).account, person(site).account
    questions = [(ada, day), (bob, day), (ada, day + timedelta(days=1)), (None, day)]
    drawn = [retrievals.draw_retrieval(module, "localiser/copies", who, when).question for who, when in questions]
    assert drawn[0] == retrievals.draw_retrieval(module, "localiser/copies", ada, day).question
    assert len({question.text for question in drawn}) > 1


def test_the_first_answer_of_a_day_is_stored_and_others_are_marked(site: Site) -> None:
    ada, module, day = person(site), the_course().modules["l20"], retrievals.today_at_school()
    browser = ada.browser(site)
    asked = retrievals.draw_retrieval(module, "localiser/cap", ada.account, day)
    form = {"question": "localiser/cap", "jour": day.isoformat()}
    wrong = browser.post("/l20/rappels", data={**form, "reponse": "-3"}, headers=JSON).json()
    assert wrong["right"] is False
    assert "La réponse était" in wrong["why"]
    right = browser.post("/l20/rappels", data={**form, "reponse": str(asked.question.answer)}, headers=JSON).json()
    assert right["right"] is True
    assert "La réponse était" in browser.post("/l20/rappels", data={**form, "reponse": "-3"}).text, "without script"
    with site.database.read() as db:
        (stored,) = repository.load_recall_answers(db, ada.account.id)
    assert (stored.subject, stored.kind, stored.is_right) == ("rappel:l20/localiser/cap", "calculation", False)


def test_what_is_no_answer_is_told_in_words(site: Site) -> None:
    browser, day = person(site).browser(site), retrievals.today_at_school()
    form = {"question": "localiser/cap", "jour": day.isoformat(), "reponse": "douze"}
    assert browser.post("/l20/rappels", data=form, headers=JSON).status_code == 422
    shown = browser.post("/l20/rappels", data=form)
    assert "« douze » n’est pas connu" in shown.text.replace("\u00a0", " ")
    assert 'value="douze"' in shown.text
    old = {**form, "jour": (day - timedelta(days=2)).isoformat(), "reponse": "3"}
    assert browser.post("/l20/rappels", data=old, headers=JSON).status_code == 409
    assert browser.post("/l20/rappels", data={**form, "question": "localiser/rien"}, headers=JSON).status_code == 404


@pytest.fixture
def folder(course_folder: CourseFolder) -> CourseFolder:
    write_page(course_folder, "une", BODY, folder="seances")
    course_folder.write("curriculum/m9/rappels/une.py", QUESTIONS)
    toml = course_folder.curriculum / "m9" / "module.toml"
    toml.write_text(toml.read_text(encoding="utf-8") + PATHS, encoding="utf-8")
    return course_folder


def test_a_part_for_later_is_folded_for_readers_of_its_path(folder: CourseFolder, small_site: SmallSite) -> None:
    assert problems(folder) == []
    text = small_site.get("/m9/lire/une")
    assert 'data-later="court" open>' in text
    assert "«\u00a0Je suis pressé\u00a0»\u00a0: pour plus tard" in text
    assert "Combien font" in text
    assert 'id="faire-a"' in text
    small_site.client.post("/m9/chemin", data={"chemin": "une"})
    assert 'data-later="court">' in small_site.get("/m9/lire/une")


def test_lengths_count_the_text_and_leave_out_what_a_path_does(folder: CourseFolder) -> None:
    lesson = page(folder, "une")
    whole, short = estimate_reading_minutes(lesson), estimate_reading_minutes(lesson, ("court",))
    assert whole - short == pytest.approx(6 / 150)
    assert short == pytest.approx(1 + 2 / 150)
    exercise = the_course().exercises["l20/odometrie"]
    lines = [line for line in exercise.solution.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    assert abs(estimate_exercise_minutes(exercise) - (10 + len(lines))) <= 2.5
    assert [duration_in_words(minutes) for minutes in (0.4, 1, 7, 62)] == ["", "1\u00a0min", "5\u00a0min", "1\u00a0h"]


def test_a_file_of_questions_that_does_not_compile_is_told(folder: CourseFolder) -> None:
    folder.write("curriculum/m9/rappels/une.py", "def somme(:\n")
    assert any(problem.path.name == "une.py" and problem.line == 1 for problem in problems(folder))
