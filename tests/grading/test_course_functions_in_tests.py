"""A test keeps its answers: no program of somebody who sits it gets the course's functions that it asks for."""

from __future__ import annotations

from datetime import timedelta

import pytest

from graders.core.contract.outcomes import Outcome
from server.course import Course
from server.database import utc_now
from server.sandbox import Sandbox
from tests.support.pupils import Pupil
from tests.support.service import Site

POSES, GRAPH, METRICS = "l20/poses", "l20/slam_graphe", "l20/metriques"
SPELLINGS = [
    "import importlib\nm = importlib.import_module('mes_' + 'fonctions')",
    "m = __import__(''.join(('mes', '_fonc', 'tions')))",
    "m = eval(bytes(reversed(b')\"snoitcnof\" \"_sem\"(__tropmi__')).decode())",
    "import sys\nm = sys.modules['snoitcnof_sem'[::-1]]",
    "import gc, types\nm = [o for o in gc.get_objects() if isinstance(o, types.ModuleType)"
    " and o.__name__[:4] == 'mes' + chr(95)][0]",
    "exec('from mes_' 'fonctions import ' '*')\nm = type('M', (), {'composer': staticmethod(composer)})",
]  # fmt: skip
PRINTS = "\nprint(m.composer((1, 2, 0), (1, 0, 0)))\n"


@pytest.fixture
def pupil(site: Site, course: Course, course_sandbox: Sandbox) -> Pupil:
    return Pupil(site, course, course_sandbox)


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_no_spelling_gets_what_a_running_test_asks_for(pupil: Pupil, spelling: str) -> None:
    before = pupil.submit(spelling + PRINTS)["stdout"]
    assert before.startswith("[2. 2. 0.]") or "gc" in spelling or "sys" in spelling
    pupil.begin()
    during = pupil.submit("# en plein contrôle\n" + spelling + PRINTS)
    assert during["stdout"] == ""
    assert during["outcome"] in (Outcome.IMPORT_ERROR, Outcome.RUNTIME_ERROR)
    pupil.hand_in()
    assert pupil.submit("# après\n" + spelling + PRINTS)["stdout"] == before


def test_an_attempt_sent_before_the_sitting_is_graded_as_it_was_when_it_was_sent(pupil: Pupil) -> None:
    """Also if it waits for its grading, or is graded anew, while its author sits the test."""
    code = "from mes_fonctions import composer\nprint(composer((1, 2, 0), (1, 0, 0)))\n"
    body = {"exercise": GRAPH, "code": code}
    sent = pupil.site.client.post("/api/v1/submissions", json=body, headers=pupil.who.headers)
    pupil.begin(utc_now() + timedelta(milliseconds=1))
    pupil.worker.run_one()
    answer = pupil.site.client.get(sent.json()["url"], headers=pupil.who.headers).json()
    assert answer["verdict"]["stdout"] == "[2. 2. 0.]\n"
    assert pupil.inputs[0].tested == frozenset()


def test_what_a_test_does_not_ask_for_stays_available(pupil: Pupil) -> None:
    pupil.begin()
    code = "import importlib\nprint(importlib.import_module('mes_' + 'fonctions').kabsch.__name__)\n"
    assert pupil.submit(code, METRICS)["stdout"] == "kabsch\n"
    assert pupil.inputs[0].tested == {POSES}


def test_an_exercise_that_reuses_nothing_costs_no_query(pupil: Pupil) -> None:
    pupil.begin()
    assert pupil.submit("x = 1\n", "l20/odometrie")["outcome"] == Outcome.MISSING_FUNCTION
    assert pupil.inputs[0].tested == frozenset()


@pytest.mark.parametrize("exercise", ["l20/defi_kidnappe"])
def test_the_courses_answer_to_an_exercise_is_not_on_its_own_shelf(pupil: Pupil, exercise: str) -> None:
    """It asks for functions of the same names as an earlier exercise, whose solution would earn marks."""
    verdict = pupil.submit("from mes_fonctions import initialiser, pas_mcl, estimer\n", exercise)
    assert (verdict["outcome"], verdict["score"]) == (Outcome.IMPORT_ERROR, 0.0)
    assert "mes_fonctions ne donne pas" in verdict["checks"][0]["message"]


def test_the_page_says_which_functions_of_the_course_there_are(pupil: Pupil) -> None:
    browser = pupil.who.browser(pupil.site)

    def told(slug: str) -> list[bool]:
        text = browser.get(f"/l20/exercices/{slug}").text
        return ["celle du cours, en attendant la vôtre" in text, "la vôtre, une fois cet exercice réussi" in text]

    assert (told("jacobienne_arete"), told("defi_kidnappe")) == ([True, False], [True, True])
    pupil.begin()
    assert told("jacobienne_arete") == [False, True]
