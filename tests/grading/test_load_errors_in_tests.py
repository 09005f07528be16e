"""In a test, that a file does not run is told at once, and nothing of what is right."""

from __future__ import annotations

import re
from typing import Any

import pytest

from server.course import Course
from server.gradebook.schemas import LOAD_SECONDS
from server.sandbox import Sandbox
from tests.support.pupils import Pupil
from tests.support.service import Site

POSES = "l20/poses"
EXERCISE = "l20/exercices/poses"
BROKEN = {
    "syntax": ("def composer(a, b)\n    return a\n", "il manque « : »"),
    "import": ("import pandas\n", "pandas"),
    "exit": ("exit()\ndef composer(a, b):\n    return a\n", "SystemExit"),
    "raises": ("x = 1 / 0\n", "ZeroDivisionError"),
    "missing": ("def composer(a, b):\n    return a\n", "« inverse » est attendue"),
    "notebook": ('{"cells": [{"cell_type": "code", "source": ["x = 1"]}]}', "carnet Jupyter"),
    "empty": ("\n", "vide"),
}


@pytest.fixture
def pupil(site: Site, course: Course, course_sandbox: Sandbox) -> Pupil:
    pupil = Pupil(site, course, course_sandbox)
    pupil.begin()
    return pupil


def plain(text: str) -> str:
    return text.replace("\u00a0", " ")


@pytest.mark.parametrize(("code", "said"), BROKEN.values(), ids=BROKEN.keys())
def test_what_keeps_a_file_from_running_is_told(pupil: Pupil, code: str, said: str) -> None:
    told = pupil.send(code, POSES)
    assert (told["held"], told["status"], told["verdict"]) == (True, "running", None)
    assert said in plain(told["load_error"])
    assert told["load_error"] in told["notice"]
    page = pupil.who.browser(pupil.site).get(f"/soumissions/{told['id']}").text
    assert "à corriger" in page
    assert "/ 20" not in page
    assert "Reçu, mais ne s’exécute pas en entier" in pupil.who.browser(pupil.site).get(f"/{EXERCISE}/essais").text
    sitting = pupil.who.browser(pupil.site).get(f"/classes/{pupil.test.class_id}/devoirs/{pupil.test.id}/composer").text
    assert "Le dernier fichier envoyé ne s’exécute pas en entier" in sitting


def test_files_that_run_look_the_same_whatever_is_right(pupil: Pupil, course: Course) -> None:
    right = course.exercises[POSES].solution
    wrong = right.replace("return composer(inverse(a), b)", "return composer(inverse(b), a)")
    fails = right.replace("return composer(inverse(a), b)", "import absent\n    return 1 / 0")
    seen, listed = [], set()
    browser = pupil.who.browser(pupil.site)
    for code in (right, wrong, fails, "import matplotlib.pyplot as plt\n" + right):
        told = pupil.send(code, POSES)
        fragment = pupil.who.browser(pupil.site).get(f"/soumissions/{told['id']}/verdict").text
        page = browser.get(f"/{EXERCISE}/essais").text
        listed.update(re.findall(r"Reçu, [^<]*", page))
        section = fragment[fragment.index("<section") : fragment.index("</section>")]
        seen.append((_neutral(told), re.sub(r"[0-9a-f-]{36}|n° \d", "", section)))
    assert all(held == seen[0] for held in seen)
    assert seen[0][0]["load_error"] is None
    assert listed == {"Reçu, résultat à paraître"}


def _neutral(told: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in told.items() if name not in ("id", "url", "created_at")}


def test_how_long_a_grading_takes_is_not_told(pupil: Pupil, monkeypatch: pytest.MonkeyPatch) -> None:
    """A withheld attempt is done after a fixed time, graded or not; one that does not run, as soon as that is known."""
    browser = pupil.who.browser(pupil.site)
    body = {
        "exercise": POSES,
        "code": "def composer(a, b): return a\ndef inverse(a): return a\ndef relatif(a, b): return a\n",
    }
    waiting = pupil.site.client.post("/api/v1/submissions", json=body, headers=pupil.who.headers).json()
    fragment = f"/soumissions/{waiting['id']}/verdict"
    assert 'data-status="running"' in browser.get(fragment).text
    pupil.worker.run_one()
    assert 'data-status="running"' in browser.get(fragment).text
    broken = pupil.send("import pandas\n", POSES)
    assert 'data-status="done"' in browser.get(f"/soumissions/{broken['id']}/verdict").text
    monkeypatch.setattr("server.gradebook.schemas.LOAD_SECONDS", 0.0)
    assert LOAD_SECONDS > 0
    assert 'data-status="done"' in browser.get(fragment).text


def test_outside_of_tests_the_verdict_has_both(pupil: Pupil) -> None:
    code = "%matplotlib inline\nimport matplotlib.pyplot as plt\ndef f():\n    pass\n"
    verdict = pupil.submit(code, "l20/odometrie")
    assert "odometrie" in verdict["load_error"]
    assert [plain(remark)[:9] for remark in verdict["remarks"]] == ["Ligne 1 :", "« matplot"]
