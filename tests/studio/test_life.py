"""What stays of an author's exercises, what the guide shows, and survivors that an author accepts."""

from __future__ import annotations

import re
from functools import partial
from html import unescape

from sqlalchemy import delete

from graders.core.declared.declaration import read_declaration
from graders.core.declared.grading import DeclaredGrader
from graders.core.declared.scenarios import PROGRAM
from graders.core.declared.trial import ExerciseTrial
from server.base.files import ROOT
from server.grading.sandbox_grader import SandboxPrograms
from server.grading.trial_task import TRIAL_POLICY
from server.identity.models import Account
from server.sandbox import Sandbox
from server.studio import repository
from server.studio.models import AuthoredExercise
from server.studio.service import read_draft
from tests.graders.declared.kinds import declare

from .conftest import Studio

GUIDE = ROOT / "server" / "docs" / "enseignants" / "exercices.md"


def test_published_exercises_outlive_their_author_and_drafts_do_not(studio: Studio) -> None:
    published, draft = studio.publish(), studio.create()
    with studio.site.database.write() as db:
        db.execute(delete(Account).where(Account.id == studio.teacher.id))
    with studio.site.database.write() as db:
        repository.delete_abandoned_exercises(db)
    with studio.site.database.read() as db:
        (left,) = db.query(AuthoredExercise).all()
        assert (left.id, left.author_id) == (published.id, None)
    assert draft != f"/mes-exercices/{published.id}"
    assert studio.site.client.get(f"/l20/exercices/{published.slug}").status_code == 200


def test_a_surviving_change_may_be_accepted_with_a_reason(studio: Studio) -> None:
    form = {
        "solution": "def signe(n):\n    if n > 0:\n        return 1\n    return 0\n",
        "v-0-c-0-appel": "signe(3)",
        "v-0-c-0-attendu": "",
        "v-0-c-1-appel": "signe(-3)",
        "v-0-c-1-attendu": "",
        "v-0-c-2-appel": "",
        "v-0-points": "20",  # nothing is drawn besides
    }
    path = studio.create()
    studio.save(path, **form, action="publier")
    assert "Des programmes faux auraient 20/20 : " in studio.report(path)
    fields = re.findall(r'name="(raison-[0-9a-f-]+)"', studio.browser.get(path).text)
    assert fields
    studio.save(path, **form, **dict.fromkeys(fields, "0 n’est pas demandé"), action="publier")
    assert studio.stored(path).number == 1
    report = studio.report(path)
    assert f"{sum(name.count('-') for name in fields)} acceptée" in report
    assert "avec une raison" in report
    assert "0 acceptée à tort" in report
    assert "aurait 20/20" not in report
    assert "vingt tirages" not in report
    assert set(read_draft(studio.stored(path)).reasons.values()) == {"0 n’est pas demandé"}


#: What the calls of the guide are played on, and what each gives.
GUIDE_SOLUTION = """import numpy as np
from math import cos
def compter_mots(texte):
    return {mot: texte.split().count(mot) for mot in texte.split()}
def dichotomie(f, a, b, eps):
    while b - a > eps:
        m = (a + b) / 2
        a, b = (a, m) if f(a) * f(m) <= 0 else (m, b)
    return round((a + b) / 2, 3)
class Pile:
    def __init__(self):
        self.t = []
    def empiler(self, x):
        self.t.append(x)
    def depiler(self):
        return self.t.pop()
def transposee(m):
    return m.T.tolist()
def demander_age():
    return int(input())
def moyenne_du_fichier():
    notes = [float(ligne) for ligne in open("notes.txt")]
    return sum(notes) / len(notes)
"""
GUIDE_ANSWERS = ["{'a': 2, 'b': 1}", "1.414", "3", "[[1.0], [2.0]]", "3", "13.5", "1.571", "1.571"]


def test_each_call_that_the_guide_shows_gives_what_it_says(studio: Studio, course_sandbox: Sandbox) -> None:
    text = GUIDE.read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([^|]+) \| `([^`]+)`.* \|$", text, re.M)
    program, calls = [call for _, call in rows if call.startswith(PROGRAM)], [call for _, call in rows]
    calls = [call for call in calls if call not in program]
    calls += [f"{call[: call.index('(')]}(cos, 1, 2, 1e-6)" for call in calls if "math.cos" in call]
    trial = ExerciseTrial("l20/essai", *[lambda *_: SandboxPrograms(course_sandbox, TRIAL_POLICY)] * 2)
    functions = " ".join(re.findall(r"^(?:def|class) (\w+)", GUIDE_SOLUTION, re.M))
    assert trial.answer_written_cases(declare(functions, GUIDE_SOLUTION, *calls)) == [GUIDE_ANSWERS]
    assert trial.answer_written_cases(declare(PROGRAM, "print(int(input()) + int(input()))\n", *program)) == [
        ["'7\\n'"]
    ]


def test_the_answers_within_eps_of_the_guide_are_judged_as_it_says(course_sandbox: Sandbox) -> None:
    section = GUIDE.read_text(encoding="utf-8").split("## Une réponse à `eps` près")[1].split("\n## ")[0]
    text = " ".join(section.split())
    call, answer, right, wrong = re.findall(
        r"Avec `(.+?)`, la solution.+? renvoie `(.+?)`.+?, `(.+?)` est juste aussi, et `(.+?)` ne l’est pas", text
    )[0]
    solution = section.split("```python\n")[1].split("```")[0]
    declared = declare("dichotomie", solution, call, tolerance="eps")
    start = partial(SandboxPrograms, course_sandbox, TRIAL_POLICY)
    assert ExerciseTrial("l20/essai", start, lambda _: start()).answer_written_cases(declared) == [[answer]]
    grader = DeclaredGrader("l20/essai", read_declaration(declared))
    for given, points in ((right, 20), (wrong, 0)):
        program = f"def dichotomie(f, a, b, eps):\n    return {given}\n".encode()
        assert grader.grade(program, start(), seed=1, version="").verdict.points == points


LARGEST = "def maximum(t):\n    m = t[0]\n    for x in t:\n        if x > m:\n            m = x\n    return m\n"
FROM_ZERO = LARGEST.replace("t[0]", "0")
FIRST = "def maximum(t):\n    return t[0]\n"


def test_a_mistake_that_no_case_refuses_has_its_case_proposed(studio: Studio) -> None:
    form = {
        "solution": LARGEST,
        "v-0-c-0-appel": "maximum([3])",
        "v-0-c-0-attendu": "",
        "v-0-c-1-appel": "maximum([4, 2])",
        "v-0-c-1-attendu": "",
        "v-0-c-2-appel": "",
        "v-0-points": "20",
        "e-0-titre": "Part de zéro",
        "e-0-explication": "Un maximum peut être négatif.",
        "e-0-programme": FROM_ZERO,
        "e-1-titre": "Le premier",
        "e-1-explication": "Les autres comptent aussi.",
        "e-1-programme": FIRST,
    }
    path = studio.create()
    studio.save(path, **form, action="publier")
    report = studio.report(path)
    assert re.search(r"« Part de zéro » n’est pas refusée : ajoutez le cas maximum\(\[-\d+", report), report
    assert re.search(r"« Le premier » n’est pas refusée : ajoutez le cas maximum\(\[", report), report
    assert "Ajouter les cas cochés et publier" in report
    page = studio.browser.get(path).text
    fields = dict(re.findall(r'name="(version)" value="([^"]*)"', page))
    picked = [unescape(case) for case in re.findall(r'name="cas" value="([^"]*)"', page)]
    studio.save(path, **form, **fields, action="cas", cas=picked)
    written = [case.call for check in read_draft(studio.stored(path)).checks for case in check.nonempty_cases]
    assert len(written) >= 4
    assert "0 acceptée à tort" in studio.report(path)
    assert "n’est pas refusée" not in studio.report(path)


def test_two_mistakes_that_answer_alike_are_told_apart_by_a_case(studio: Studio) -> None:
    form = {
        "solution": LARGEST,
        "v-0-c-0-appel": "maximum([3, 4, 1])",
        "v-0-c-0-attendu": "4",
        "v-0-c-1-appel": "maximum([-5, -9, -8])",
        "v-0-c-1-attendu": "-5",
        "v-0-c-2-appel": "",
        "v-0-points": "20",
        "e-0-titre": "Le premier",
        "e-0-explication": "a",
        "e-0-programme": FIRST,
        "e-1-titre": "Le premier, s’il est impair",
        "e-1-explication": "b",
        "e-1-programme": "def maximum(t):\n    return t[0] if t[0] % 2 else t[-1]\n",
    }
    path = studio.create()
    studio.save(path, **form)
    assert "prise pour « Le premier », qui répond de même sauf à ce cas : maximum(" in studio.report(path)
