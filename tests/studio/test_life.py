"""What stays of an author's exercises, what the guide shows, and survivors that an author accepts."""

from __future__ import annotations

import re
from html import unescape

from sqlalchemy import delete

from graders.core.declared.case_reading import parse_scenario
from graders.core.declared.scenarios import FILE, TYPE
from server.base.files import ROOT
from server.identity.models import Account
from server.studio import repository
from server.studio.models import AuthoredExercise
from server.studio.service import read_draft

from .conftest import Studio

GUIDE = ROOT / "server" / "docs" / "enseignants" / "exercices.md"


def test_published_exercises_outlive_their_author_and_drafts_do_not(studio: Studio) -> None:
    published, draft = studio.publish(), studio.create()
    with studio.site.database.write() as db:
        db.execute(delete(Account).where(Account.id == studio.teacher.id))
    with studio.site.database.write() as db:
        repository.delete_abandoned(db)
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
    assert set(read_draft(studio.stored(path)).reasons.values()) == {"0 n’est pas demandé"}


def test_each_call_that_the_guide_shows_is_read(studio: Studio) -> None:
    rows = re.findall(r"^\| .* \| `([^`]+)`.* \|$", GUIDE.read_text(encoding="utf-8"), re.M)
    assert len(rows) >= 7
    for call in rows:
        names = [name for name in re.findall(r"\b([A-Za-z_]\w*)\(", call) if name not in (TYPE, FILE)]
        assert parse_scenario(call, names[:1])


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
    written = [case.call for check in read_draft(studio.stored(path)).checks for case in check.written]
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
