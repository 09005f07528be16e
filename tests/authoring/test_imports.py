"""Imports of exercises made elsewhere: drafts that can be read, three lists, and nothing run."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from graders.core.declared.declaration import read_declaration
from server.cli import main
from server.course import load_course
from server.grading.sandbox_grader import SandboxPrograms
from server.sandbox import Sandbox
from server.studio.import_drafts import ImportDraft, ImportRefused
from server.studio.imports import read_drafts
from tests.support.outside import taken_in

EXERCISM = {
    "exercise": "word-count",
    "cases": [
        {"description": "empty", "property": "countWords", "input": {"sentence": ""}, "expected": {}},
        {"cases": [{"property": "countWords", "input": {"sentence": "a b a"}, "expected": {"a": 2, "b": 1}}]},
        {"property": "countWords", "input": {"sentence": None}, "expected": {"error": "no text"}},
        {"property": "apply", "input": {"f": "(x) -> x"}, "expected": 3},
        {"description": "no property", "input": {}, "expected": 3},
    ],
}
SOLUTION = "def carre(n):\n    return n * n\n\ndef table(n):\n    for k in range(n):\n        print(k, carre(k))\n"
TESTS = (
    ("print(carre(-3))", "9", ""),
    ("table(2)", "0 0\n1 1", ""),
    ("", "Bonjour Ada", "Ada"),
    ("x = carre(2)\nprint(x)", "4", ""),
    ("for k in range(3):\n    print(carre(k))", "0\n1\n4", ""),
)
QUESTION = (
    '<quiz><question type="coderunner"><name><text>Carrés</text></name><coderunnertype>python3</coderunnertype>'
    f"<answer><![CDATA[{SOLUTION}]]></answer><testcases>"
    + "".join(
        f"<testcase><testcode><text><![CDATA[{code}]]></text></testcode><stdin><text>{lines}</text></stdin>"
        f"<expected><text>{expected}</text></expected></testcase>"
        for code, expected, lines in TESTS
    )
    + '</testcases></question><question type="coderunner"><coderunnertype>c_function</coderunnertype></question></quiz>'
)
NOTEBOOK = {
    "cells": [
        {"cell_type": "markdown", "source": ["Écrivez `carre(n)`."]},
        {
            "cell_type": "code",
            "metadata": {"nbgrader": {"solution": True}},
            "source": "def carre(n):\n    ### BEGIN SOLUTION\n    return n * n\n    ### END SOLUTION\n",
        },
        {
            "cell_type": "code",
            "metadata": {"nbgrader": {"grade": True}},
            "source": "assert carre(3) == 9\nassert carre(2) > 3\n",
        },
    ]
}


def drafts(folder: Path, name: str, text: str) -> list[ImportDraft]:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return read_drafts(path.name, path.read_bytes())


def test_canonical_data_of_exercism(tmp_path: Path) -> None:
    (draft,) = drafts(tmp_path, "canonical-data.json", json.dumps(EXERCISM))
    assert draft.functions == ["count_words", "apply"]
    assert draft.checks[0]["cas"] == ["count_words('')", "count_words('a b a')", "count_words(None)"]
    assert draft.checks[0]["attendus"] == ["{}", "{'a': 2, 'b': 1}", "ValueError"]
    assert [line.partition(" ")[0] for line in draft.to_look_at] == ["cases[2]", "cases[3]", "écrivez"]
    assert draft.left == ["cases[4] : ce cas n’a pas « property » et « input »"]


def test_questions_of_coderunner(tmp_path: Path) -> None:
    draft, other = drafts(tmp_path, "questions.xml", QUESTION)
    values, printed = draft.checks
    assert values["cas"] == ["carre(-3)", "x = carre(2)\nx"]
    assert printed["regarder"] == "affichage"
    assert (printed["cas"][0], printed["attendus"][0]) == ("table(2)", "'0 0\\n1 1'")
    assert [line.partition(" : ")[0] for line in draft.left] == ["question 1, test 3", "question 1, test 5"]
    assert "c_function" in other.left[0]


PROGRAM = (
    '<quiz><question type="coderunner"><name><text>Nom</text></name><coderunnertype>python3</coderunnertype>'
    "<questiontext><text><![CDATA[<p>Demandez un <b>nom</b>&nbsp;:</p><pre>nom ? Ada</pre>"
    "<ul><li>un</li></ul>]]></text></questiontext>"
    "<answer>print('Bonjour', input('nom ? '))</answer><testcases><testcase><testcode><text></text></testcode>"
    "<stdin><text>Ada</text></stdin><expected><text>nom ? Ada\nBonjour Ada</text></expected></testcase></testcases>"
    "</question></quiz>"
)
SUITE = """
tabs:
- tab: Compteur
  contexts:
  - testcases:
    - statement: "c: compteur = Compteur()"
    - expression: c.ajouter().valeur()
      return: 1
    - statement: c.pas = 2
    - expression: c.ajouter().valeur()
      return: !expression "3"
    - expression: c.choisir()
      return: !oracle {oracle: custom_check, file: evaluator.py, value: 3}
- tab: Textes
  testcases:
  - expression: {python: submission.dire("a"), java: Submission.dire("a")}
    stdout: "A\\n"
  - expression: dire(1)
    exception: {types: {python: TypeError}}
  - expression: copier("a.txt", "b.txt")
    input_files: [{path: a.txt, content: bon}]
    output_files: [{path: b.txt, content: BON}]
"""
WHOLE = """
- tab: Programme
  testcases:
  - stdin: "3\\n4"
    arguments: [-v]
    stdout: "7"
  - expression: "TOTAL # le total"
    return: 0
"""


def test_a_whole_program_of_coderunner(tmp_path: Path) -> None:
    (draft,) = drafts(tmp_path, "nom.xml", PROGRAM)
    assert draft.functions == ["programme"]
    assert draft.checks[0]["cas"] == ["programme('Ada')"]
    assert draft.statement == "Demandez un **nom** :\n\n```text\nnom ? Ada\n```\n\n- un"


def test_a_suite_of_tested(tmp_path: Path) -> None:
    (draft,) = drafts(tmp_path, "suite.yaml", SUITE)
    values, printed, dire, written = draft.checks
    assert values["cas"][1].split("\n")[2:] == ["c.pas = 2", "c.ajouter().valeur()"]
    assert values["attendus"] == ["1", "3"]
    assert (printed["cas"], printed["attendus"], printed["regarder"]) == (["dire('a')"], ["'A\\n'"], "affichage")
    assert dire["attendus"] == ["TypeError"]
    assert (written["cas"], written["attendus"]) == (
        ["fichier('a.txt', 'bon')\ncopier('a.txt', 'b.txt')"], ["{'b.txt': 'BON'}"],
    )  # fmt: skip
    assert draft.left == [
        "onglet 1, contexte 1, test 5 : « return » est comparé par un programme (« oracle »), qui n’est pas repris"
    ]
    read_declaration(draft.build_declaration() | {"solution": ""})
    (whole,) = drafts(tmp_path, "suite.yml", WHOLE)
    assert whole.functions == ["programme"]
    assert [check["cas"] for check in whole.checks] == [
        ["arguments('-v')\nprogramme('3', '4')"],
        ["programme()\nTOTAL"],
    ]
    read_declaration(whole.build_declaration() | {"solution": ""})


def test_cells_of_nbgrader(tmp_path: Path) -> None:
    (draft,) = drafts(tmp_path, "devoir.ipynb", json.dumps(NOTEBOOK))
    assert draft.solution == "def carre(n):\n    return n * n\n\n"
    assert draft.checks[0]["cas"] == ["carre(3)"]
    assert draft.left == ["cellule 3, ligne 2 : « assert carre(2) > 3 » n’est pas « assert f(…) == … »"]
    assert draft.statement.startswith("Écrivez")


def test_what_is_imported_is_a_folder_that_grades(
    tmp_path: Path, sandbox: Sandbox, capsys: pytest.CaptureFixture[str]
) -> None:
    course, source = tmp_path / "cours", tmp_path / "questions.xml"
    source.write_text(QUESTION, encoding="utf-8")
    assert main(["new", "module", "l31", "--course", str(course)]) == 0
    assert main(["new", "declared", "l31/carres", "--from", str(source), "--course", str(course)]) == 0
    told = capsys.readouterr().out
    assert "Carrés : 3 cas lus" in told
    assert "laissé : question 1, test 3 : aucune fonction" in told
    with taken_in(course):
        read = load_course(course / "curriculum", code=course, render=False)
        assert [problem for problem in read.problems if "n’a pas d’exercice" not in problem.message] == []
        exercise = read.exercises["l31/carres"]
        assert [function.signature for function in exercise.functions] == ["carre(n)", "table(n)"]
        programs = SandboxPrograms(sandbox, exercise.policy)
        verdict = exercise.grader.grade(SOLUTION.encode(), programs, seed=1, version="1").verdict
    assert verdict.points == 20, verdict.checks


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.txt", "", "se lisent ici"),
        ("a.json", "{", "pas du JSON"),
        ("a.yaml", "a: &a [*a]", "des renvois"),
        ("a.yaml", "[" * 60, "imbriqué"),
        ("a.yaml", "a: [", "pas du YAML"),
        ("a.yaml", "a: 3", "suite de TESTed"),
        ("a.json", "[" * 100_000, "pas du JSON"),
        ("a.json", "{}", "cases"),
        ("a.xml", "<quiz>", "pas du XML"),
        ("a.xml", '<!DOCTYPE q [<!ENTITY a "aaaa">]><quiz>&a;</quiz>', "entités"),
        ("a.xml", "<quiz/>", "aucun exercice"),
        ("a.ipynb", "[]", "cells"),
        ("a.ipynb", " " * (4 << 20) + "{}", "au plus"),
    ],
)
def test_a_file_that_cannot_be_read_is_refused(tmp_path: Path, name: str, text: str, words: str) -> None:
    with pytest.raises(ImportRefused, match=words):
        drafts(tmp_path, name, text)


def test_no_text_of_a_file_is_run(tmp_path: Path) -> None:
    """Code where values are expected is left, or is text of the solution; it touches nothing."""
    witness = tmp_path / "witness"
    attack = f"__import__('pathlib').Path({str(witness)!r}).touch()"
    data = {"cases": [{"property": attack, "input": {"x": 1}, "expected": 2}]}
    question = QUESTION.replace("print(carre(-3))", f"print(carre({attack}))")
    notebook = json.dumps(NOTEBOOK).replace("assert carre(3) == 9", f"assert carre({attack}) == 9")
    for name, text in (("a.json", json.dumps(data)), ("a.xml", question), ("a.ipynb", notebook)):
        try:
            for draft in drafts(tmp_path, name, text):
                if draft.checks:
                    read_declaration({**draft.build_declaration(), "solution": draft.solution})
        except ImportRefused:
            continue
    assert not witness.exists()
