"""Every malformation of `questions.toml` is reported with its place, and the other exercises still serve."""

from __future__ import annotations

from typing import Any

import pytest

from graders.core.answers import choice, numeric, order
from graders.core.answers.numeric import Quantity
from graders.discovery import Discovery
from server.course import Course
from tests.pages.conftest import HINTS, CourseFolder, graders

CARD = 'title = "Choisir"\nsummary = "Une question."\norder = 10\nkind = "answers"\n'
CHOICE = """[[question]]
id = "q"
text = "Combien font $1 + 1$ ?"

[[question.option]]
id = "deux"
right = true
text = "Deux."
why = "Oui."

[[question.option]]
id = "trois"
text = "Trois."
why = "Comptez."

[[question]]
id = "r"
text = "Et $2 + 2$ ?"

[[question.option]]
id = "quatre"
right = true
text = "Quatre."
why = "Oui."

[[question.option]]
id = "cinq"
text = "Cinq."
why = "Non : $4$."
"""
ORDER = """[[step]]
id = "un"
text = "D'abord."
role = "commencer"

[[step]]
id = "deux"
text = "Ensuite."
role = "finir"

[[distractor]]
id = "faux"
text = "Faux."
why = "C'est faux."
"""
NUMERIC = """[[data]]
name = "a"
symbol = "a"
meaning = "un nombre"

[[question]]
id = "q"
text = "Que vaut $2 \\\\times {{a}}$ ?"
"""


def definitions(course_folder: CourseFolder) -> dict[str, Any]:
    file = str(course_folder.root / "graders/m9/c/grader.py")
    asked = Quantity("q", 20, lambda data, _: 2 * data["a"])
    return {
        "choice": choice(file, "m9/c"),
        "order": order(file, "m9/c"),
        "numeric": numeric(file, "m9/c", draw=lambda rng: {"a": float(rng.integers(1, 9))}, quantities=[asked]),
    }


def loaded(course_folder: CourseFolder, form: str, questions: str | None, card: str = CARD) -> Course:
    folder = "curriculum/m9/exercices/c"
    course_folder.write(f"{folder}/exercise.toml", card)
    course_folder.write(f"{folder}/enonce.md", "Répondez.\n")
    course_folder.write(f"{folder}/indices.md", HINTS)
    if questions is not None:
        course_folder.write(f"{folder}/questions.toml", questions)
    return course_folder.load(Discovery({**graders("a", "b").graders, "m9/c": definitions(course_folder)[form]}, ()))


@pytest.mark.parametrize(("form", "text"), [("choice", CHOICE), ("order", ORDER), ("numeric", NUMERIC)])
def test_well_formed_questions_are_served_without_starter_nor_functions(
    course_folder: CourseFolder, form: str, text: str
) -> None:
    course = loaded(course_folder, form, text)
    assert course.problems == ()
    exercise = course.exercises["m9/c"]
    assert (exercise.kind, exercise.functions) == ("answers", ())
    assert exercise.answers is exercise.grader
    assert course.exercises["m9/a"].kind == "code"


BROKEN: dict[str, tuple[str, str, int | None, str]] = {
    "TOML that does not parse": ("choice", CHOICE.replace('why = "Oui."', "why = ", 1), 9, "TOML mal formé"),
    "unknown field": ("choice", CHOICE.replace("right = true", "juste = true", 1), 7, "juste"),
    "wrong type": ("choice", CHOICE.replace("right = true", 'right = "oui"', 1), 7, "right"),
    "missing field": ("choice", CHOICE.replace('why = "Comptez."\n', ""), 11, "champ manquant"),
    "one option": ("choice", CHOICE.split('[[question.option]]\nid = "trois', maxsplit=1)[0], 5, "option"),
    "same question twice": ("choice", CHOICE.replace('id = "r"', 'id = "q"'), 17, "deux fois : « q »"),
    "same option twice": ("choice", CHOICE.replace('id = "trois"', 'id = "deux"'), 12, "deux fois : « deux »"),
    "bad TeX in a question": ("choice", CHOICE.replace("$1 + 1$", "$\\\\frac{1$"), 3, "formule"),
    "bad TeX in an explanation": ("choice", CHOICE.replace("$4$", "$4_$"), 29, "formule"),
    "unknown exercise in a link": ("choice", CHOICE.replace("Comptez.", "Voir [](exo:zut)."), 14, "zut"),
    "bad link below the quotes": ("choice", CHOICE.replace('"Comptez."', '"""\n\nVoir\n[](exo:zut)."""'), 17, "zut"),
    "bad link in a comment too": ("choice", "# [](exo:zut)\n" + CHOICE.replace("Comptez.", "[](exo:zut)"), 15, "zut"),
    "image": ("choice", CHOICE.replace("Comptez.", "![x](y.png)"), 14, "image"),
    "no right option": ("choice", CHOICE.replace("right = true\n", "", 1), 1, "no right option"),
    "two right options": ("choice", CHOICE.replace('id = "trois"', 'id = "trois"\nright = true'), 1, "right options"),
    "uncatalogued misconception": ("choice", CHOICE + 'misconception = "zut"\n', 1, "not catalogued"),
    "step after a later one": (
        "order",
        ORDER.replace('role = "commencer"', 'role = "x"\nafter = ["deux"]'),
        1,
        "un comes",
    ),
    "same step twice": ("order", ORDER.replace('id = "deux"', 'id = "un"'), 7, "deux fois"),
    "distractor named as a step": ("order", ORDER.replace('id = "faux"', 'id = "un"'), 1, "same name"),
    "unknown datum": ("numeric", NUMERIC.replace("{{a}}", "{{b}}"), 1, "unknown data"),
    "question that is not judged": ("numeric", NUMERIC.replace('id = "q"', 'id = "r"'), 1, "judges"),
    "bad TeX in a symbol": ("numeric", NUMERIC.replace('symbol = "a"', 'symbol = "a_"'), 3, "formule"),
    "digits out of bounds": ("numeric", NUMERIC.replace('symbol = "a"', 'symbol = "a"\ndigits = 40'), 4, "digits"),
}


@pytest.mark.parametrize(("form", "text", "line", "message"), BROKEN.values(), ids=BROKEN.keys())
def test_a_malformed_sheet_is_reported_with_its_place(
    course_folder: CourseFolder, form: str, text: str, line: int | None, message: str
) -> None:
    course = loaded(course_folder, form, text)
    (problem,) = course.problems
    assert (problem.line, message in problem.message) == (line, True), str(problem)
    assert problem.path.name in {"questions.toml", "grader.py", "misconceptions.toml"}
    assert list(course.exercises) == ["m9/a", "m9/b"]


def test_a_missing_sheet_and_a_wrong_kind_are_reported(course_folder: CourseFolder) -> None:
    assert [one.path.name for one in loaded(course_folder, "choice", None).problems] == ["questions.toml"]
    code = CARD.replace('kind = "answers"\n', "")
    (problem,) = loaded(course_folder, "choice", CHOICE, card=code).problems
    assert "autre sorte" in problem.message
    functions = CARD + '\n[[functions]]\nname = "f"\nsignature = "f()"\n'
    (problem,) = loaded(course_folder, "choice", CHOICE, card=functions).problems
    assert "aucune fonction" in problem.message


def test_an_exercise_of_code_still_needs_functions(course_folder: CourseFolder) -> None:
    card = course_folder.exercise("a") / "exercise.toml"
    card.write_text(card.read_text(encoding="utf-8").split("[[functions]]")[0], encoding="utf-8")
    (problem,) = course_folder.load().problems
    assert (problem.path, problem.line) == (card, 1)
    assert "functions" in problem.message


def test_the_version_covers_the_questions(course_folder: CourseFolder) -> None:
    before = loaded(course_folder, "choice", CHOICE).exercises["m9/c"].version
    assert loaded(course_folder, "choice", CHOICE.replace("Comptez", "Recomptez")).exercises["m9/c"].version != before


def test_specimens_are_named_as_the_course_names_its_options(course_folder: CourseFolder) -> None:
    course_folder.write("graders/m9/c/specimens/wrong_answer/trois.json", '{"q": "trois", "r": "quatre"}')
    course_folder.write("graders/m9/c/specimens/syntax_error/rien.json", "[")
    grader = loaded(course_folder, "choice", CHOICE).exercises["m9/c"].grader
    found = {one.subject: one for one in grader.known() if one.subject.startswith("spécimen")}
    assert len(found) == 2
    for one in found.values():
        for seed in range(8):
            graded = grader.grade(one.write(seed), lambda _: None, seed=seed, version="")  # type: ignore[arg-type,return-value]
            assert graded.verdict.outcome is one.outcome
