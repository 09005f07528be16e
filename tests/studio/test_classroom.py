"""A teacher tries a draft as a student; the students of her classes, and no others, find what she proposes to them."""

from __future__ import annotations

from dataclasses import replace

import pytest
from sqlalchemy import func, select

from server.classes.models import ClassRole, SchoolClass
from server.grading import tryout_task
from server.identity.models import Role
from server.studio.models import AuthoredExercise
from server.submissions.models import Submission
from tests.support.classes import new_class, person, seat

from .conftest import SOLUTION, Studio

ONCE = SOLUTION.replace("d.get(m, 0) + 1", "1")


def plain(text: str) -> str:
    return text.replace("\u202f", " ").replace("\xa0", " ").replace("&#39;", "'")


def test_a_draft_is_tried_as_a_student_and_nothing_counts(studio: Studio) -> None:
    path = studio.create()
    assert studio.browser.get(f"{path}/essayer").status_code == 409
    studio.save(path)
    page = studio.browser.get(f"{path}/essayer").text
    assert "qui compte les mots" in page
    assert "À vous de jouer" in page
    sent = studio.browser.post(f"{path}/essayer", data={"code": ONCE})
    assert sent.status_code == 303
    assert "Correction en cours" in studio.browser.get(f"{path}/essayer").text
    studio.work()
    verdict = plain(studio.browser.get(f"{path}/essayer").text)
    assert "on attend {'a': 2, 'b': 1} et compter_mots renvoie" in verdict
    assert "Essai n°" not in verdict
    studio.browser.post(f"{path}/essayer", data={"code": SOLUTION})
    studio.work()
    assert "sur 20" in studio.browser.get(f"{path}/essayer").text
    with studio.site.database.read() as db:
        assert db.scalar(select(func.count()).select_from(Submission)) == 0
    other = person(studio.site, Role.teacher, "Alan").browser(studio.site)
    assert other.get(f"{path}/essayer").status_code == 404
    assert other.post(f"{path}/essayer", data={"code": "x"}).status_code == 404


@pytest.mark.parametrize("code", ["x" * 20_001, "while True:\n    pass\n", "import os\nos._exit(3)\n"])
def test_a_hostile_program_of_an_author_ends(studio: Studio, code: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tryout_task, "POLICY", replace(tryout_task.POLICY, cpu_seconds=0.25))
    path = studio.create()
    studio.save(path)
    answer = studio.browser.post(f"{path}/essayer", data={"code": code})
    studio.work()
    assert answer.status_code in (303, 422)
    assert studio.browser.get(f"{path}/essayer").status_code == 200


def test_a_class_finds_what_is_proposed_to_it(studio: Studio) -> None:
    exercise = studio.publish()
    made = new_class(studio.site.database, studio.teacher.account)
    other = new_class(studio.site.database, person(studio.site, Role.teacher, "Alan").account)
    ada, bob = (person(studio.site, Role.student, name) for name in ("Ada", "Bob"))
    seat(studio.site.database, made, ada.account, ClassRole.student)
    seat(studio.site.database, other, bob.account, ClassRole.student)
    href = f'href="/l20/exercices/{exercise.slug}"'
    browsers = [each.browser(studio.site) for each in (ada, bob)]

    def who_finds_it() -> list[bool]:
        return [href in browser.get("/l20").text for browser in (*browsers, studio.site.client)]

    assert who_finds_it() == [False, False, False]
    studio.save(f"/mes-exercices/{exercise.id}", action="classes")
    assert who_finds_it() == [True, False, False]
    assert f"Proposé à votre classe {made.name} :" in studio.report(f"/mes-exercices/{exercise.id}")
    assert "Publié, version 1." in studio.report(f"/mes-exercices/{exercise.id}")
    assert "publié, version 1 ; proposé à vos classes" in studio.browser.get("/mes-exercices").text
    studio.save(f"/mes-exercices/{exercise.id}", titre="Un autre titre")
    assert "publié, version 1 ; modifié depuis" in studio.browser.get("/mes-exercices").text
    assert "Les exercices de votre classe" in browsers[0].get("/l20").text
    with studio.site.database.write() as db:
        db.get_one(SchoolClass, made.id).archived_at = func.now()
    assert who_finds_it() == [False, False, False]
    with studio.site.database.write() as db:
        db.get_one(SchoolClass, made.id).archived_at = None
    studio.save(f"/mes-exercices/{exercise.id}", action="hors-classes")
    assert who_finds_it() == [False, False, False]


def test_an_exercise_of_an_earlier_form_is_changed_by_its_author_alone(studio: Studio) -> None:
    """The digest of a draft covers every field of the form, and fields are added to it."""
    published = studio.publish()
    path = f"/mes-exercices/{published.id}"
    with studio.site.database.write() as db:
        stored = db.get_one(AuthoredExercise, published.id)
        checks = [
            {name: value for name, value in check.items() if name != "ignores_spaces"}
            for check in stored.draft["checks"]
        ]
        stored.draft, stored.digest = {**stored.draft, "checks": checks}, "0" * 64
        stored.trial = {**(stored.trial or {}), "published_digest": stored.digest}

    def is_said_changed(**fields: str) -> bool:
        studio.save(path, **fields)
        return "modifié depuis" in studio.browser.get("/mes-exercices").text

    assert [is_said_changed(**each) for each in ({"action": "classes"}, {}, {"niveau": "MPSI"}, {})] == [
        False,
        False,
        True,
        False,
    ]


def test_a_corrige_is_said_commented_where_it_is(studio: Studio) -> None:
    for program, title in ((SOLUTION, "Corrigé"), (f"# Un mot à la fois.\n{SOLUTION}", "Corrigé commenté")):
        exercise = studio.publish(solution=program)
        page = studio.browser.get(f"/l20/exercices/{exercise.slug}").text
        assert f"<summary>{title}</summary>" in page


def test_a_lesson_has_an_exercise_of_its_teachers(studio: Studio) -> None:
    exercise = studio.publish()
    made = new_class(studio.site.database, studio.teacher.account)
    ada = person(studio.site, Role.student, "Ada Lovelace")
    seat(studio.site.database, made, ada.account, ClassRole.student)
    page = f"/classes/{made.id}/seance"
    assert f'value="{exercise.name}"' in studio.browser.get(page).text
    begun = studio.browser.post(page, data={"action": "commencer", "exercice": exercise.name})
    assert begun.status_code == 303, begun.text
    ada.browser(studio.site).post(f"/l20/exercices/{exercise.slug}/soumissions", data={"code": ONCE})
    studio.work()
    shown = plain(studio.browser.get(page).text)
    assert exercise.draft["title"] in shown
    assert "1 essai" in shown
    assert studio.browser.get(f"{page}/projeter").status_code == 200
    studio.browser.post(page, data={"action": "terminer"})
    assert studio.browser.get(page).status_code == 200
