"""Authors who mean harm: none of their bytes runs outside of the sandbox, and nobody else waits for them."""

from __future__ import annotations

import sys
import time

import pytest

from server.base.app_services import get_service
from server.classes.models import ClassRole
from server.identity.models import Role
from server.studio.service import MAX_WAITING, StudioService
from tests.studio.conftest import FORM, SOLUTION, Studio
from tests.support.classes import assign, new_class, person, seat
from tests.support.quick import the_course
from tests.support.service import EXERCISE

MARK = "balise_auteur_dehors"
#: Says that it ran in this process, or on this machine, if it ever does.
SPY = f"import sys\nsys.modules['{MARK}'] = sys\n"
GOOD = "def compter_mots(texte):\n    return {}\n"
#: None of these may be in a page that shows what they wrote.
HARM = ("<script", "<img src=x", "onerror=alert(1)>", 'href="javascript', 'href="data', "<style>body", "<b>")
#: Seconds of a trial of one hostile file on a busy machine: its limits, and no more.
LONG = 60.0

SOLUTIONS = {
    "loop at import": "while True:\n    pass\n",
    "loop in a call": "def compter_mots(texte):\n    while True:\n        pass\n",
    "fork": "import os\nwhile True:\n    os.fork()\n",
    "memory": "x = bytearray(4 << 30)\n" + GOOD,
    "files": "open('/etc/passwd').read()\n" + GOOD,
    "network": "import socket\nsocket.create_connection(('127.0.0.1', 22), 1)\n" + GOOD,
    "kill": "import os\nos.kill(os.getppid(), 9)\n" + GOOD,
    "exit": "import os\nos._exit(0)\n",
    "recursion": "def compter_mots(texte):\n    return compter_mots(texte)\n",
    "flood": "def compter_mots(texte):\n    print('x' * 10**8)\n    return [0] * 10**7\n",
    "object": "class D(dict):\n    __eq__ = lambda self, other: True\ndef compter_mots(texte):\n    return D()\n",
    "deep": "x = " + "(" * 5000 + ")" * 5000 + "\n" + GOOD,
    "long": "x = " + "-" * 19_000 + "1\n",
    "huge": "x = 1\n" * 20_000,
    "null": "x = '\x00'\n",
    "powers": "x = 9 ** 9 ** 9 ** 9\n" + GOOD,
}


@pytest.mark.parametrize("name", SOLUTIONS)
def test_a_hostile_solution_harms_nobody(studio: Studio, name: str) -> None:
    """Its trial ends and says why, it is not published, and the next author's exercise is tried as ever."""
    path, started = studio.create(), time.monotonic()
    studio.save(path, action="publier", solution=SPY + SOLUTIONS[name])
    assert time.monotonic() - started < LONG
    assert "Pas encore publié" in studio.report(path)
    assert studio.stored(path).number == 0
    assert MARK not in sys.modules
    after = studio.create()
    studio.save(after)
    assert "0 accepté à tort" in studio.report(after)


@pytest.mark.parametrize(
    "case",
    [
        "compter_mots(__import__('os').system('true'))",
        "compter_mots(open('/etc/passwd').read())",
        "compter_mots('a' * 10**10)",
        "compter_mots(9 ** 9 ** 9)",
        "compter_mots(lambda: __import__('sys').modules.update({'" + MARK + "': 1}))",
        "compter_mots.__globals__",
        "compter_mots(" + "[" * 3000 + "]" * 3000 + ")",
        "[compter_mots(x) for x in range(10**9)]",
    ],
)
def test_a_hostile_case_is_data(studio: Studio, case: str) -> None:
    path = studio.create()
    studio.save(
        path, **{"v-0-c-0-appel": case, "v-0-c-0-attendu": case, "v-0-appel": case, "v-0-tirages": f"x = {case}"}
    )
    assert MARK not in sys.modules
    assert studio.browser.get(path).status_code == 200


def test_a_hostile_starter_and_mistake_run_behind_the_walls(studio: Studio) -> None:
    program = SPY + "while True:\n    pass\n"
    path = studio.create()
    studio.save(path, action="publier", **{"depart": program, "e-0-titre": "Boucle", "e-0-programme": program})
    assert MARK not in sys.modules
    assert studio.browser.get(path).status_code == 200


def test_a_statement_brings_no_script(studio: Studio) -> None:
    words = (
        "<script>alert(1)</script> <img src=x onerror=alert(1)> [a](javascript:alert(1)) [b](data:text/html,x)\n\n"
        "![c](javascript:alert(1)) <a href='//evil.example'>d</a> $\\href{javascript:alert(1)}{x}$ "
        "$\\htmlClass{a}{b}$ $" + "\\def\\a{\\a\\a}\\a" + "$\n\n<style>body{display:none}</style>\n"
    )
    exercise = studio.publish(enonce=words, titre="<b>gras</b>")
    own = studio.browser.get(f"/mes-exercices/{exercise.id}").text
    preview = studio.browser.post("/mes-exercices/apercu", data={"enonce": words, "module": "l20"}).text
    shown = studio.browser.get(f"/l20/exercices/{exercise.slug}").text
    for page in (own, preview, shown):
        body = page.replace('<script type="module"', "").replace("<script src=", "")
        for harm in (
            "<script",
            "<img src=x",
            "onerror=alert(1)>",
            'href="javascript',
            'href="data',
            "<style>body",
            "<b>",
        ):
            assert harm not in body, harm


def test_what_one_author_sends_has_bounds(studio: Studio) -> None:
    """Too many trials wait: the next one is refused in words, and what was typed comes back."""
    service = get_service(studio.site.app, StudioService)
    paths = [studio.create() for _ in range(MAX_WAITING + 1)]
    answers = [studio.browser.post(path, data=FORM) for path in paths]
    assert [answer.status_code for answer in answers] == [303] * MAX_WAITING + [429]
    assert SOLUTION.splitlines()[0] in answers[-1].text or "Rien n’est perdu" in answers[-1].text
    assert service.settings.save_burst < 10_000


def test_an_author_reads_no_attempt_of_another_s_class(studio: Studio) -> None:
    """The exercise is hers, the class is not: neither attempts nor held results are."""
    exercise = studio.publish()
    other = person(studio.site, Role.teacher, "Alan")
    made = new_class(studio.site.database, other.account)
    ada = person(studio.site, Role.student, "Ada")
    seat(studio.site.database, made, ada.account, ClassRole.student)
    assign(studio.site.database, made, exercise.name, EXERCISE, mode="test", duration_minutes=60)
    sent = ada.browser(studio.site).post(f"/l20/exercices/{exercise.slug}/soumissions", data={"code": SOLUTION})
    studio.work()
    place = sent.headers.get("location", f"/classes/{made.id}")
    assert studio.browser.get(place).status_code == 404
    assert studio.browser.get(f"/classes/{made.id}/carnet").status_code == 404
    assert the_course().exercises[exercise.name].title == FORM["titre"]
