"""Drafts: nothing typed is lost, the trial says what holds, and what it proposes is taken up with one button."""

from __future__ import annotations

import re

import pytest

from server.studio.models import AuthoredExercise
from server.studio.service import find_own, read_draft

from .conftest import FORM, MISTAKE, SOLUTION, Studio


def test_a_draft_is_tried_as_it_is_saved(studio: Studio) -> None:
    path = studio.create()
    answer = studio.browser.post(path, data={**FORM, "action": "brouillon"})
    assert answer.status_code == 200
    assert "Essai en cours" in answer.text
    studio.work()
    told = studio.report(path)
    assert "compter_mots(&#34;le chat&#34;) → {&#39;le&#39;: 1, &#39;chat&#39;: 1}" in re.sub(r" +", " ", told)
    assert "0 accepté à tort" in told
    assert "x1 = texte(&#39; abcehlt&#39;, 0, 8)" in told
    page = studio.browser.get(path).text
    assert SOLUTION.replace('"', "&#34;") in page


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"solution": "def compter_mots(texte):\n    return {\n"}, "n’est jamais refermé"),
        ({"solution": "x = 1\n"}, "Les fonctions"),
        ({"solution": "def compter_mots(texte):\n    while True: pass\n"}, "la limite. Une boucle"),
        ({"v-0-c-1-attendu": '{"a": 3}'}, "vous attendez {&#34;a&#34;: 3}"),
        ({"v-0-c-1-appel": "compter_mot(1)"}, "n’est pas une de vos fonctions"),
        ({"v-0-c-1-attendu": "{"}, "Vérification 1, le résultat attendu du cas 2"),
        ({"v-0-points": "beaucoup"}, "Vérification 1, les points"),
        ({"v-0-tirages": "t = hasard()", "v-0-appel": "compter_mots(t)"}, "Vérification 1, les tirages"),
    ],
)
def test_what_is_wrong_is_told_with_its_place_and_kept(studio: Studio, changes: dict[str, str], words: str) -> None:
    path = studio.create()
    assert studio.save(path, **changes).status_code == 303
    assert words in studio.report(path)
    draft = read_draft(studio.stored(path))
    assert changes.get("solution", SOLUTION) == draft.solution
    assert draft.title == FORM["titre"]


def test_what_a_trial_proposes_is_taken_up(studio: Studio) -> None:
    path = studio.create()
    studio.save(path, **{"v-0-c-1-appel": 'compter_mots("a b")', "v-0-c-1-attendu": "", "v-0-c-2-appel": ""})
    told = studio.report(path)
    assert "Ajouter ces cas" in told
    typed = {name: value for name, value in FORM.items() if not name.startswith(("v-0-c-1", "v-0-c-2"))}
    typed |= {"v-0-c-1-appel": 'compter_mots("a b")'}
    studio.browser.post(path, data={**typed, "action": "cas"})
    studio.work()
    assert len(read_draft(studio.stored(path)).checks[0].cases) > 2
    assert "0 accepté à tort" in studio.report(path)
    number = re.search(r'value="erreur:(\d+)"', studio.browser.get(path).text)
    assert number is not None
    assert studio.browser.post(path, data={**FORM, "action": f"erreur:{number[1]}"}).status_code == 303
    (mistake,) = read_draft(studio.stored(path)).mistakes
    assert mistake.program != SOLUTION
    assert "au lieu de" in mistake.title
    assert studio.browser.post(path, data={**FORM, "action": "erreur:999"}).status_code == 404


def test_what_was_saved_meanwhile_is_not_overwritten(studio: Studio) -> None:
    path = studio.create()
    version = re.search(r'name="version" value="(\w+)"', studio.browser.get(path).text)
    assert version is not None
    studio.save(path)
    refused = studio.browser.post(path, data={**FORM, "titre": "Autre", "version": version[1]})
    assert refused.status_code == 409
    assert "Autre" in refused.text
    assert read_draft(studio.stored(path)).title == FORM["titre"]


def test_what_is_saved_during_a_trial_is_tried_after_it(studio: Studio) -> None:
    path = studio.create()
    studio.browser.post(path, data=FORM)
    studio.browser.post(path, data={**FORM, "titre": "Second"})
    studio.work()
    exercise = studio.stored(path)
    assert exercise.trial is not None
    assert exercise.trial["digest"] == exercise.digest


def test_too_long_a_draft_is_refused_and_shown_again(studio: Studio) -> None:
    path = studio.create()
    long = "x" * 160_000
    refused = studio.browser.post(path, data={**FORM, "enonce": long})
    assert refused.status_code == 422
    assert "caractères en tout" in refused.text
    assert long in refused.text


def test_a_draft_is_its_author_s_alone(studio: Studio) -> None:
    from server.identity.models import Role
    from tests.support.classes import person

    path = studio.create()
    studio.save(path, **MISTAKE)
    other = person(studio.site, Role.teacher, "Alan").browser(studio.site)
    student = person(studio.site, Role.student, "Ada").browser(studio.site)
    for browser, status in ((other, 404), (student, 403)):
        for answer in (browser.get(path), browser.get(f"{path}/essai"), browser.post(path, data=FORM)):
            assert answer.status_code == status
    assert student.get("/mes-exercices").status_code == 403
    assert studio.browser.post(path, data={**FORM, "action": "supprimer"}).status_code == 303
    with studio.site.database.read() as db:
        assert db.query(AuthoredExercise).count() == 0
        with pytest.raises(Exception, match="n’existe plus"):
            find_own(db, studio.teacher.account, path.rpartition("/")[2])
