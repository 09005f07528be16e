"""An exercise whose student writes a whole program: from the form to the verdict."""

from __future__ import annotations

from typing import Any

from server.identity.models import Role
from tests.support.classes import person

from .conftest import Studio

FORM: dict[str, Any] = {
    "titre": "Une somme",
    "enonce": "Écrivez un programme qui lit deux entiers et affiche leur somme.",
    "solution": "a = int(input('a ? '))\nb = int(input('b ? '))\nprint('somme :', a + b)\n",
    "v-0-c-0-appel": 'programme("3", "4")',
    "v-0-c-0-attendu": "somme : 7",
    "v-0-c-1-appel": 'programme("0", "5")',
    "v-0-c-1-attendu": "a ? 0\nb ? 5\nsomme : 5",
    "v-0-c-2-appel": 'programme("-2", "9")',
    "v-0-c-2-attendu": "",
}


def test_a_program_is_written_published_and_done(studio: Studio) -> None:
    exercise = studio.publish(**FORM)
    report = studio.report(f"/mes-exercices/{exercise.id}")
    assert "x1 = entier(-2, 3); x2 = entier(4, 9) dans programme(x1, x2)" in report
    ada = person(studio.site, Role.student, "Ada")
    browser = ada.browser(studio.site)
    page = browser.get(f"/l20/exercices/{exercise.slug}").text
    assert "Programme demandé" in page
    assert "Quand on tape « 3 », puis « 4 », le programme affiche" in page.replace("\u202f", " ").replace("\xa0", " ")
    assert "rejouer-un-appel" not in page
    verdicts = []
    for code in ("print(input() + input())", "print('somme :', int(input()) + int(input()))"):
        sent = browser.post(f"/l20/exercices/{exercise.slug}/soumissions", data={"code": code})
        studio.work()
        verdicts.append(browser.get(sent.headers["location"]).text.replace("\u202f", " ").replace("\xa0", " "))
    assert "Quand on tape « 3 », puis « 4 »" in verdicts[0]
    assert "20/20" in verdicts[1].replace(" ", "")


def test_what_is_typed_alone_is_told_as_a_program(studio: Studio) -> None:
    path = studio.create()
    studio.save(path, **{**FORM, "v-0-c-0-appel": "3"})
    assert "si l’on y tape 3, puis 4, écrivez programme(" in studio.report(path)
