"""Authors who mean harm: none of their bytes runs outside of the sandbox, and nobody else waits for them."""

from __future__ import annotations

import io
import json
import sys
import time
import zipfile
from collections.abc import Callable

import pytest

from server.base.app_services import get_service
from server.base.files import ROOT
from server.classes.models import ClassRole
from server.identity.models import Role
from server.studio.import_drafts import MAX_READ
from server.studio.service import MAX_WAITING, StudioService
from tests.studio.conftest import FORM, SOLUTION, Studio
from tests.support.classes import assign, new_class, person, seat
from tests.support.quick import the_course
from tests.support.service import EXERCISE

MARK = "balise_auteur_dehors"
#: Says that it ran in this process, or on this machine, if it ever does.
SPY = f"import sys\nsys.modules['{MARK}'] = sys\n"
#: None of these may be in a page that shows what they wrote.
HARM = ("<script", "<img src=x", "onerror=alert(1)>", 'href="javascript', 'href="data', "<style>body", "<b>")
#: Seconds of a trial of one hostile file on a busy machine: its limits, and no more.
LONG = 60.0

AUTHORS = ROOT / "tests" / "hostile" / "auteurs"
#: Those that are too long for a file.
LONG_SOLUTIONS = {
    "deep": "x = " + "(" * 5000 + ")" * 5000 + "\ndef compter_mots(texte):\n    return {}\n",
    "huge": "x = 1\n" * 20_000,
    "long": "x = " + "-" * 19_000 + "1\n",
}
SOLUTIONS = LONG_SOLUTIONS | {
    path.stem: path.read_text(encoding="utf-8") for path in sorted((AUTHORS / "solutions").glob("*.py"))
}
CASES = (AUTHORS / "cas.txt").read_text(encoding="utf-8").splitlines()
CASES.append("compter_mots(" + "[" * 3000 + "]" * 3000 + ")")
AGAINST_PROCESSES = ("fork", "memory", "kill", "exit")


@pytest.mark.parametrize("name", SOLUTIONS)
def test_a_hostile_solution_harms_nobody(studio: Studio, name: str) -> None:
    """Its trial ends and says why, it is not published; after what attacks processes the next one is tried as ever."""
    path, started = studio.create(), time.monotonic()
    studio.save(path, action="publier", solution=SPY + SOLUTIONS[name])
    assert time.monotonic() - started < LONG
    assert "Pas encore publié" in studio.report(path)
    assert studio.stored(path).number == 0
    assert MARK not in sys.modules
    if name in AGAINST_PROCESSES:
        after = studio.create()
        studio.save(after, solution=f"# after {name}\n{SOLUTION}")  # tried by no other test
        assert "0 acceptée à tort" in studio.report(after)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case[:40])
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
        for harm in HARM:
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


LAUGHS = '<!DOCTYPE z [<!ENTITY a "aaa"><!ENTITY b "&a;&a;">]><quiz><question type="coderunner">&b;</question></quiz>'
LONG_CELL = {"cell_type": "code", "metadata": {"nbgrader": {"grade": True}}, "source": "x\n" * 30_000}
CELL = {"cell_type": "code", "metadata": {"nbgrader": {"grade": True}}, "source": "assert f(1) == 1\n" * 2000}
CASE = {"property": "f", "input": {"a": 1}, "expected": 1}


def packed(**files: str) -> bytes:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(name.replace("__", ".").replace("_up_", "../"), text)
    return made.getvalue()


def lying() -> bytes:
    """A file of 40 MB of which the archive says that it has 1000 bytes."""
    size = 40 << 20
    whole = packed(declaration__toml="a" * size, solution__py="")
    return whole.replace(size.to_bytes(4, "little"), (1000).to_bytes(4, "little"))


@pytest.mark.parametrize(
    ("name", "make", "words"),
    [
        ("laughs.xml", LAUGHS.encode, "définit des entités"),
        ("laughs16.xml", lambda: LAUGHS.encode("utf-16"), "n’est pas en UTF-8"),
        ("laughs.yaml", lambda: b"a: &a [x, x]\ntabs: [*a, *a]\n", "renvois"),
        ("tag.yaml", lambda: b"tabs: !!python/object/apply:os.system ['true']\n", "n’est pas du YAML"),
        ("long.yaml", lambda: b"tabs:\n" + b"- {tab: a}\n" * 9000, "trop long"),
        ("deep.json", lambda: b"[" * 100_000, "n’est pas du JSON"),
        ("digits.json", lambda: b'{"cases": ' + b"9" * 90_000 + b"}", "n’est pas du JSON"),
        ("many.json", lambda: json.dumps({"cases": [CASE] * 5000}).encode(), f"les {MAX_READ} premiers cas sont lus"),
        ("many.ipynb", lambda: json.dumps({"cells": [CELL] * 9}).encode(), f"les {MAX_READ} premiers cas sont lus"),
        (
            "long.ipynb",
            lambda: json.dumps({"cells": [LONG_CELL]}).encode(),
            "caractères ; 40000 au plus",
        ),
        ("large.json", lambda: b" " * (1 << 20) + b"{}", "dépasse 512 Kio"),
        ("bomb.zip", lambda: packed(declaration__toml="a" * (8 << 20)), "trop grand"),
        ("lying.zip", lying, "n’est pas un ZIP de textes"),
        ("dotted.zip", lambda: packed(declaration__toml=("a." * 200 + "b=1\n") * 50, solution__py=""), "trop imbriqué"),
        (
            "spaced.zip",
            lambda: packed(declaration__toml='x={"a" . ' + "b . " * 50 + "c=1}", solution__py=""),
            "trop imbriqué",
        ),
        ("deep.zip", lambda: packed(declaration__toml="a=" + "[" * 9000, solution__py=""), "ne se lit pas"),
        ("kinds.zip", lambda: packed(declaration__toml="verifications=[{cas=3}]", solution__py=""), "ne se lit pas"),
        ("outside.zip", lambda: packed(_up__up_etc_x__toml="a=1"), "n’est ni un exercice exporté d’ici"),
        ("noise.zip", lambda: b"PK\x03\x04" + b"\x00" * 500, "n’est pas un ZIP"),
    ],
    ids=lambda value: value if isinstance(value, str) and "." in value else "",
)
def test_a_hostile_file_is_refused_or_read_in_part(
    studio: Studio, name: str, make: Callable[[], bytes], words: str
) -> None:
    """Neither its bytes nor what they unpack to cost more than an author's own exercise."""
    answer = studio.browser.post("/mes-exercices/importer", data={"module": "l20"}, files={"fichier": (name, make())})
    text = " ".join(answer.text.replace("\u202f", " ").replace("&nbsp;", " ").split())
    assert answer.status_code == (413 if "dépasse" in words else answer.status_code), text
    assert words in text, text


def test_a_shared_code_is_not_guessed(studio: Studio) -> None:
    statuses = {
        studio.browser.post("/mes-exercices/copier", data={"code": f"abcdefgh{number:02d}"}).status_code
        for number in range(int(studio.site.settings.join_burst) + 2)
    }
    assert statuses == {404, 429}
    first = person(studio.site, Role.teacher, "Alan").browser(studio.site)
    page = first.post("/mes-exercices/copier", data={"code": "inconnu"})
    assert "Aucun exercice n’a ce code" in page.text
    assert 'value="inconnu"' in page.text


def test_a_huge_form_is_refused_and_comes_back(studio: Studio) -> None:
    """A hundred fields of 64 kB: nothing is stored, no trial begins, and the page that answers keeps what it can."""
    path = studio.create()
    answer = studio.browser.post(path, data={**FORM, **{f"v-0-c-{row}-appel": "x" * 65_536 for row in range(40)}})
    assert answer.status_code in (413, 422)
    assert studio.stored(path).draft["title"] == ""
    smaller = studio.browser.post(path, data={**FORM, "enonce": "y" * 160_000})
    assert smaller.status_code == 422
    assert "Rien n’est perdu" in smaller.text
    assert "y" * 160_000 in smaller.text


def test_a_stranger_and_a_student_reach_nothing_of_it(studio: Studio) -> None:
    exercise = studio.publish()
    path = f"/mes-exercices/{exercise.id}"
    student = person(studio.site, Role.student, "Ada").browser(studio.site)
    colleague = person(studio.site, Role.teacher, "Alan").browser(studio.site)
    for browser, refused in ((studio.site.client, (303, 401, 403)), (student, (403,)), (colleague, (404,))):
        for address in ("", "/essai", "/essayer", "/archive.zip"):
            assert browser.get(path + address, follow_redirects=False).status_code in refused, address
        for address in ("", "/essayer"):
            answer = browser.post(path + address, data={**FORM, "action": "supprimer"}, follow_redirects=False)
            assert answer.status_code in refused, address
    copied = colleague.post("/mes-exercices/copier", data={"exercice": str(exercise.id)})
    assert copied.status_code == 404, "it is not in the bank"
    assert studio.stored(path).number == 1
