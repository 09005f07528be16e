"""Publication: what it takes, what a class does with the exercise, and what a later version changes."""

from __future__ import annotations

import re
from html import unescape
from typing import Any

import pytest

from graders.core.declared.trial_report import TrialReport
from server.base.app_services import get_service
from server.classes.models import ClassRole
from server.database import utc_now
from server.gradebook.models import Grading
from server.grading import trial_task
from server.identity.models import Role
from server.regrades.service import RegradeService
from server.studio.authored import build_exercise
from server.studio.service import read_draft
from tests.graders.declared.kinds import STACK
from tests.support.classes import new_class, person, seat
from tests.support.quick import the_course

from .conftest import FORM, MISTAKE, SOLUTION, Studio

TIME = "import time\ndef compter_mots(texte):\n    return {'a': time.time_ns()}\n"
ONCE = SOLUTION.replace("d.get(m, 0) + 1", "1")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"titre": ""}, "Donnez un titre"),
        ({"enonce": ""}, "Écrivez l’énoncé"),
        ({"v-0-c-1-attendu": "{}"}, "ne répond pas encore comme les exemples"),
        ({"v-0-c-1-appel": "compter_mots(cos)"}, "Corrigez d’abord ce qui ne se lit pas : c’est dit plus bas"),
        ({"depart": SOLUTION}, "Le départ a déjà tous les points"),
        ({**MISTAKE, "e-0-programme": SOLUTION}, "n’est pas refusée"),
        ({**MISTAKE, "e-0-explication": ""}, "un titre et une explication"),
        ({**MISTAKE, "e-0-programme": ""}, "Écrivez le programme qui commet l’erreur « Chaque mot compte une fois »"),
        ({**MISTAKE, "e-1-titre": "La même", "e-1-explication": "Oui", "e-1-programme": ONCE}, "n’est pas reconnue"),
        ({"solution": TIME, "v-0-c-0-attendu": "", "v-0-c-1-attendu": ""}, "n’a pas tous les points"),
        ({"v-0-c-1-appel": "", "v-0-c-1-attendu": "", "v-0-c-2-appel": ""}, "plus variés"),
    ],
)
def test_only_what_holds_is_published(studio: Studio, changes: dict[str, str], words: str) -> None:
    path = studio.create()
    studio.save(path, action="publier", **changes)
    assert words in studio.report(path)
    assert studio.stored(path).number == 0


#: Of one exercise each: the solution and its examples, in which there is nothing to decide.
SMALL = (
    (
        "a = int(input())\nb = int(input())\nif a > b:\n    print(a)\nelse:\n    print(b)\n",
        ('programme("3", "4")', 'programme("5", "2")', 'programme("-1", "-1")'),
    ),
    pytest.param(
        STACK,
        ("p = Pile(); p.est_vide()", "p = Pile(); p.empiler(3); p.empiler(4); p.depiler()", "p = Pile(); p.empiler(3)"),
        marks=pytest.mark.slow,
    ),
    pytest.param(
        "def dichotomie(f, a, b, eps):\n    while b - a > eps:\n        m = (a + b) / 2\n        if f(a) * f(m) <= 0:\n"
        "            b = m\n        else:\n            a = m\n    return (a + b) / 2\n",
        (
            "dichotomie(lambda x: x * x - 2, 0, 2, 1e-6)",
            "dichotomie(lambda x: x - 1, 0, 3, 1e-3)",
            "dichotomie(lambda x: x ** 3 - 5, 1, 2, 1e-6)",
        ),
        marks=pytest.mark.slow,
    ),
)


@pytest.mark.parametrize(("solution", "calls"), SMALL)
def test_what_is_proposed_and_ticked_is_published(studio: Studio, solution: str, calls: tuple[str, ...]) -> None:
    """Two of the offered mistakes are taken in their words, then each case that the page ticks: one refusal at most."""
    path = studio.create()
    form = {"titre": "Un exercice", "enonce": "Écrivez-le.", "solution": solution, "v-0-c-1-attendu": ""}
    form |= {"v-0-c-0-attendu": ""} | {f"v-0-c-{number}-appel": call for number, call in enumerate(calls)}
    studio.save(path, **form)

    def proposed(name: str) -> list[str]:
        page = studio.browser.get(f"{path}/essai").text
        ticked = " checked" if name == "cas" else ""
        return [
            unescape(value)
            for value in re.findall(rf'name="{name}" value="([^"]*)" form="\w+" data-pick{ticked}>', page)
        ]

    studio.save(path, **form, action="erreurs", erreur=proposed("erreur")[:2])
    page = studio.browser.get(path).text
    mistakes = read_draft(studio.stored(path)).mistakes
    assert all("répond comme un programme juste dont" in mistake.explanation for mistake in mistakes)
    for number, mistake in enumerate(mistakes):
        form |= {f"e-{number}-titre": mistake.title, f"e-{number}-explication": mistake.explanation}
        form |= {f"e-{number}-programme": mistake.program}
    assert page.count('class="studio-mistake"') == 3
    studio.save(path, **form, action="publier")
    if not studio.stored(path).number:
        studio.save(path, **form, action="cas", cas=proposed("cas"))
    assert studio.stored(path).number == 1, studio.report(path)


def test_a_class_does_it(studio: Studio) -> None:
    """The form of an assignment offers it, students get verdicts, the mistake is named, the gradebook counts it."""
    exercise = studio.publish(**MISTAKE)
    made = new_class(studio.site.database, studio.teacher.account)
    ada = person(studio.site, Role.student, "Ada Lovelace")
    seat(studio.site.database, made, ada.account, ClassRole.student)
    form = studio.browser.get(f"/classes/{made.id}/devoirs/nouveau").text
    assert f'value="{exercise.name}"' in form
    given = studio.browser.post(
        f"/classes/{made.id}/devoirs",
        data={"titre": "DM", "exercice": exercise.name, "ouvre": "2020-01-01T08:00", "retard": "accept"},
    )
    assert given.status_code == 303, given.text
    browser = ada.browser(studio.site)
    page = browser.get(f"/l20/exercices/{exercise.slug}")
    assert page.status_code == 200
    assert "qui compte les mots" in page.text
    sent = browser.post(f"/l20/exercices/{exercise.slug}/soumissions", data={"code": ONCE})
    assert sent.status_code == 303
    studio.work()
    verdict = browser.get(sent.headers["location"]).text
    assert "Chaque mot compte une fois" in verdict
    assert "Que vaut d[m] au deuxième passage" in verdict
    with studio.site.database.read() as db:
        grading = db.query(Grading).one()
        assert grading.exercise_version == studio.versions()[0].version
    for address in ("", "/carnet", "/devoirs", "/recalculs", f"/eleves/{ada.id}"):
        assert studio.browser.get(f"/classes/{made.id}{address}").status_code == 200, address
    for address in ("", f"/eleves/{ada.id}"):
        assert FORM["titre"] in studio.browser.get(f"/classes/{made.id}{address}").text, address
    assert browser.get(f"/classes/{made.id}").status_code == 200
    api = studio.site.client.post(
        "/api/v1/submissions", json={"exercise": exercise.name, "code": SOLUTION}, headers=ada.headers
    )
    assert api.status_code == 202
    studio.work()
    done = studio.site.client.get(f"/api/v1/submissions/{api.json()['id']}", headers=ada.headers).json()
    assert done["verdict"]["points"] == 20
    assert studio.site.client.get(f"/api/v1/exercises/{exercise.name}", headers=ada.headers).status_code == 200


def test_a_new_version_calls_for_a_regrade_and_changes_no_mark(studio: Studio) -> None:
    exercise = studio.publish()
    made = new_class(studio.site.database, studio.teacher.account)
    ada = person(studio.site, Role.student, "Ada")
    seat(studio.site.database, made, ada.account, ClassRole.student)
    studio.browser.post(
        f"/classes/{made.id}/devoirs",
        data={"titre": "DM", "exercice": exercise.name, "ouvre": "2020-01-01T08:00", "retard": "accept"},
    )
    ada.browser(studio.site).post(f"/l20/exercices/{exercise.slug}/soumissions", data={"code": SOLUTION})
    studio.work()
    path = f"/mes-exercices/{exercise.id}"
    regrades = get_service(studio.site.app, RegradeService)

    def outdated() -> list[Any]:
        with studio.site.database.read() as db:
            return list(regrades.load_outdated_exercises(db, made))

    studio.save(path, action="publier", enonce="Un autre énoncé.")
    assert outdated() == [], "the words of the statement change no mark"
    studio.save(path, action="publier", **{"v-0-c-3-appel": 'compter_mots("z z z")'})
    assert [each.exercise for each in outdated()] == [exercise.name]
    first, words, second = studio.versions()
    assert first.version == words.version != second.version
    with studio.site.database.read() as db:
        assert db.query(Grading).one().exercise_version == first.version


def test_a_version_names_mistakes_without_running_them_again(studio: Studio) -> None:
    exercise = studio.publish(**MISTAKE)
    (version,) = studio.versions()
    built = build_exercise(version, "l20", exercise.slug or "", the_course())
    assert built.grader.fingerprints == {
        "chaque_mot_compte_une_fois": tuple(version.fingerprints["chaque_mot_compte_une_fois"])
    }  # type: ignore[attr-defined]
    assert version.published_at <= utc_now()


def test_an_unpublished_name_is_no_exercise(studio: Studio) -> None:
    exercise = studio.publish()
    assert exercise.slug is not None
    other = exercise.slug[:-1] + ("2" if exercise.slug[-1] != "2" else "3")
    assert studio.browser.get(f"/l20/exercices/{other}").status_code == 404
    assert studio.browser.get(f"/l19/exercices/{exercise.slug}").status_code == 404


def test_what_is_ready_is_published_without_trying_its_changes_again(
    studio: Studio, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A busy machine does not take back « Prêt à publier »."""
    tried: list[bool] = []

    class Watched(trial_task.ExerciseTrial):
        def run(self, *args: Any, with_changes: bool = True, **named: Any) -> TrialReport:
            tried.append(with_changes)
            return super().run(*args, with_changes=with_changes, **named)

    monkeypatch.setattr(trial_task, "ExerciseTrial", Watched)
    path = studio.create()
    studio.save(path)
    assert "Prêt à publier" in studio.report(path)
    studio.save(path, action="publier")
    assert studio.stored(path).number == 1
    assert tried == [False, True, False]
    studio.save(path, action="publier", solution=SOLUTION.replace("d.get(m, 0) + 1", "1 + d.get(m, 0)"))
    assert studio.stored(path).number == 2
    assert tried[-1], "another solution is tried whole"
