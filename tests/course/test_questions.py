"""Every malformation of `questions.toml` is reported with its place, and the other exercises still serve."""

from __future__ import annotations

import pytest

from graders.core.answers import Quantity, numeric
from graders.core.contract.local import LOCAL
from server.course import Course
from tests.support.small_course import HINTS, CourseFolder

CARD = 'title = "Choisir"\nsummary = "Une question."\norder = 10\nkind = "answers"\n'
CHOICE = """form = "choice"

[[question]]
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
MISCONCEPTION = """[[misconception]]
id = "compte"
title = "Compter"
explanation = "Un de trop."
question = "Et sur vos doigts ?"
"""
ORDER = """form = "order"

[[step]]
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
NUMERIC = """form = "numeric"

[[data]]
name = "a"
symbol = "a"
meaning = "un nombre"

[[question]]
id = "q"
text = "Que vaut $2 \\\\times {{a}}$ ?"
"""


def loaded(
    course_folder: CourseFolder, questions: str | None, card: str = CARD, *, graded: bool | None = None
) -> Course:
    """The course with an exercise `c` more; it has a grader's folder where it needs one, unless `graded` says."""
    folder = "curriculum/m9/exercices/c"
    course_folder.write(f"{folder}/exercise.toml", card)
    course_folder.write(f"{folder}/enonce.md", "Répondez.\n")
    course_folder.write(f"{folder}/indices.md", HINTS)
    if questions is not None:
        course_folder.write(f"{folder}/questions.toml", questions)
    found = course_folder.graders("a", "b")
    if graded if graded is not None else 'form = "numeric"' in (questions or ""):
        asked = Quantity("q", 20, lambda data, _: 2 * data["a"])
        file = str(course_folder.root / "graders/m9/c/grader.py")
        found.definitions["m9/c"] = numeric(file, deal=lambda rng: {"a": float(rng.integers(1, 9))}, quantities=[asked])
    return course_folder.load(found)


@pytest.mark.parametrize("text", [CHOICE, ORDER, NUMERIC], ids=["choice", "order", "numeric"])
def test_well_formed_questions_are_served_without_starter_nor_functions(course_folder: CourseFolder, text: str) -> None:
    course = loaded(course_folder, text)
    assert course.problems == ()
    exercise = course.exercises["m9/c"]
    assert (exercise.kind, exercise.functions) == ("answers", ())
    assert exercise.answers is exercise.grader
    assert course.exercises["m9/a"].kind == "code"


BROKEN: dict[str, tuple[str, str, int | None, str]] = {
    "no form": ("questions.toml", CHOICE.replace('form = "choice"\n', ""), 1, "champ manquant : « form »"),
    "unknown form": ("questions.toml", CHOICE.replace("choice", "essay"), 1, "form"),
    "a table of another form": ("questions.toml", CHOICE.replace("choice", "order"), 1, "step"),
    "TOML that does not parse": ("questions.toml", CHOICE.replace('why = "Oui."', "why = ", 1), 11, "TOML mal formé"),
    "unknown field": ("questions.toml", CHOICE.replace("right = true", "juste = true", 1), 9, "juste"),
    "wrong type": ("questions.toml", CHOICE.replace("right = true", 'right = "oui"', 1), 9, "right"),
    "missing field": ("questions.toml", CHOICE.replace('why = "Comptez."\n', ""), 13, "champ manquant"),
    "one option": (
        "questions.toml",
        CHOICE.split('[[question.option]]\nid = "trois', maxsplit=1)[0],
        7,
        "option",
    ),
    "same question twice": ("questions.toml", CHOICE.replace('id = "r"', 'id = "q"'), 19, "deux fois : « q »"),
    "same option twice": ("questions.toml", CHOICE.replace('id = "trois"', 'id = "deux"'), 14, "deux fois : « deux »"),
    "bad TeX in a question": ("questions.toml", CHOICE.replace("$1 + 1$", "$\\\\frac{1$"), 5, "formule"),
    "bad TeX in an explanation": ("questions.toml", CHOICE.replace("$4$", "$4_$"), 31, "formule"),
    "unknown exercise in a link": ("questions.toml", CHOICE.replace("Comptez.", "Voir [](exo:zut)."), 16, "zut"),
    "bad link below the quotes": (
        "questions.toml",
        CHOICE.replace('"Comptez."', '"""\n\nVoir\n[](exo:zut)."""'),
        19,
        "zut",
    ),
    "bad link in a comment too": (
        "questions.toml",
        "# [](exo:zut)\n" + CHOICE.replace("Comptez.", "[](exo:zut)"),
        17,
        "zut",
    ),
    "image": ("questions.toml", CHOICE.replace("Comptez.", "![x](y.png)"), 16, "image"),
    "no right option": ("questions.toml", CHOICE.replace("right = true\n", "", 1), 3, "aucune option n’est juste"),
    "two right options": (
        "questions.toml",
        CHOICE.replace('id = "cinq"', 'id = "cinq"\nright = true'),
        18,
        "options sont justes",
    ),
    "uncatalogued misconception": ("misconceptions.toml", CHOICE + 'misconception = "zut"\n', 1, "n’est pas ici"),
    "step after a later one": (
        "questions.toml",
        ORDER.replace('role = "commencer"', 'role = "x"\nafter = ["deux"]'),
        7,
        "étape « un »",
    ),
    "same step twice": ("questions.toml", ORDER.replace('id = "deux"', 'id = "un"'), 9, "deux fois"),
    "distractor named as a step": ("questions.toml", ORDER.replace('id = "faux"', 'id = "un"'), 13, "se nomment"),
    "unknown datum": ("questions.toml", NUMERIC.replace("{{a}}", "{{b}}"), 8, "ne sont pas tirés"),
    "question that is not judged": ("grader.py", NUMERIC.replace('id = "q"', 'id = "r"'), 1, "juge q"),
    "bad TeX in a symbol": ("questions.toml", NUMERIC.replace('symbol = "a"', 'symbol = "a_"'), 5, "formule"),
    "digits out of bounds": (
        "questions.toml",
        NUMERIC.replace('symbol = "a"', 'symbol = "a"\ndigits = 40'),
        6,
        "digits",
    ),
}


@pytest.mark.parametrize(("name", "text", "line", "message"), BROKEN.values(), ids=BROKEN.keys())
def test_a_malformed_sheet_is_reported_with_its_place(
    course_folder: CourseFolder, name: str, text: str, line: int | None, message: str
) -> None:
    course = loaded(course_folder, text)
    (problem,) = course.problems
    assert (problem.path.name, problem.line, message in problem.message) == (name, line, True), str(problem)
    assert list(course.exercises) == ["m9/a", "m9/b"]


def test_a_missing_sheet_and_a_wrong_kind_are_reported(course_folder: CourseFolder) -> None:
    assert [one.path.name for one in loaded(course_folder, None).problems] == ["questions.toml"]
    code = CARD.replace('kind = "answers"\n', "")
    (problem,) = loaded(course_folder, NUMERIC, card=code).problems
    assert "autre sorte" in problem.message
    functions = CARD + '\n[[functions]]\nname = "f"\nsignature = "f()"\n'
    (problem,) = loaded(course_folder, CHOICE, card=functions).problems
    assert "aucune fonction" in problem.message


def test_numbers_need_a_grader_and_the_other_forms_have_none(course_folder: CourseFolder) -> None:
    (problem,) = loaded(course_folder, NUMERIC, graded=False).problems
    assert problem.path == course_folder.exercise("c") / "exercise.toml"
    assert "sans correcteur" in problem.message
    for text in (CHOICE, ORDER):
        (problem,) = loaded(course_folder, text, graded=True).problems
        assert problem.path == course_folder.root / "graders/m9/c/grader.py"
        assert "de trop" in problem.message


def test_misconceptions_of_a_choice_stand_beside_its_questions(course_folder: CourseFolder) -> None:
    folder = "curriculum/m9/exercices/c"
    course_folder.write(f"{folder}/misconceptions.toml", MISCONCEPTION)
    exercise = loaded(course_folder, CHOICE + 'misconception = "compte"\n').exercises["m9/c"]
    assert exercise.grader.mistake_ids() == {"compte"}
    assert [one.subject for one in exercise.grader.known_submissions() if one.diagnosis == "compte"] == ["r : cinq"]


def test_an_exercise_of_code_still_needs_functions(course_folder: CourseFolder) -> None:
    card = course_folder.exercise("a") / "exercise.toml"
    card.write_text(card.read_text(encoding="utf-8").split("[[functions]]")[0], encoding="utf-8")
    (problem,) = course_folder.load().problems
    assert (problem.path, problem.line) == (card, 1)
    assert "functions" in problem.message


def test_the_version_covers_the_questions(course_folder: CourseFolder) -> None:
    before = loaded(course_folder, CHOICE).exercises["m9/c"].version
    assert loaded(course_folder, CHOICE.replace("Comptez", "Recomptez")).exercises["m9/c"].version != before


def test_specimens_are_named_as_the_course_names_its_options(course_folder: CourseFolder) -> None:
    specimens = "curriculum/m9/exercices/c/specimens"
    course_folder.write(f"{specimens}/wrong_answer/trois.json", '{"q": "trois", "r": "quatre"}')
    course_folder.write(f"{specimens}/syntax_error/rien.json", "[")
    grader = loaded(course_folder, CHOICE).exercises["m9/c"].grader
    found = {one.subject: one for one in grader.known_submissions() if one.subject.startswith("spécimen")}
    assert len(found) == 2
    for one in found.values():
        for seed in range(8):
            graded = grader.grade(one.source_for_seed(seed), LOCAL, seed=seed, version="")
            assert graded.verdict.outcome is one.outcome
