"""The pages over HTTP, on a made-up course, with verdicts written as a worker writes them."""

from __future__ import annotations

import re
from typing import Any
from uuid import UUID, uuid4

import pytest

from graders.core.contract.outcomes import Outcome
from server.base.app_services import get_service
from server.base.errors import NotFound
from server.database import Database
from server.gradebook.schemas import HINT_OPENS_AFTER
from server.identity.models import Account
from server.pages.waiting import WatchedSubmission
from server.queue.interfaces import WorkerCapabilities
from server.submissions.models import Submission
from server.submissions.service import GRADE, SubmissionService
from tests.support.counting import Counted
from tests.support.service import new_account
from tests.support.small_site import CHECK, PAGE, SmallSite, verdict


def test_every_page_answers_to_a_visitor(small_site: SmallSite) -> None:
    assert "Un module" in small_site.get("/")
    assert "Doubler" in small_site.get("/m9")
    page = small_site.get(PAGE)
    assert "double(x)" in page
    assert "def double(x):" in page
    assert "temps de calcul" in page.lower()
    assert "Vous n’avez encore rien envoyé" in small_site.get(f"{PAGE}/essais")
    assert small_site.get("/m9/kit/m9.py").startswith("def configurer")


def test_the_first_page_says_what_one_may_do_next(small_site: SmallSite) -> None:
    fresh = small_site.get("/")
    assert "Comment cela se passe" in fresh
    assert "Aucun compte n’est nécessaire" in fresh
    small_site.attempt("x = 1", verdict())
    begun = small_site.get("/")
    assert f'href="{PAGE}">Reprendre : Doubler<' in begun
    assert "0 sur 2 exercices réussis" in begun
    small_site.attempt("x = 2", verdict("ok", 20.0))
    begun = small_site.get("/")
    assert "Exercice suivant" in begun
    assert "1 sur 2 exercices réussis" in begun
    assert "Pour enseigner" not in begun
    small_site.become_teacher()
    assert "Pour enseigner" in small_site.get("/")


def test_a_visitor_leaves_no_trace(small_site: SmallSite) -> None:
    answer = small_site.client.get(PAGE)
    assert "set-cookie" not in answer.headers


@pytest.mark.parametrize(
    "path", ["/m1", "/m9/exercices/z", "/m9/kit/m8.py", "/soumissions/1", "/m9/exercices/z/essais"]
)
def test_what_does_not_exist_is_a_page_in_french(small_site: SmallSite, path: str) -> None:
    page = small_site.get(path, status=404)
    assert '<html lang="fr">' in page
    assert "existe pas" in page


def test_from_submission_to_verdict(small_site: SmallSite) -> None:
    href = small_site.submit("def double(x):\n    return x\n")
    waiting = small_site.get(f"{href}/verdict")
    assert 'data-status="queued"' in waiting
    assert "votre envoi est le prochain" in waiting
    small_site.grade(verdict(diagnosis={"id": "oubli", "title": "Rien n’est doublé", "explanation": "Un.\n\nDeux ?"}))
    page = small_site.get(f"{href}/verdict")
    for text in (
        "Réponse à revoir",
        "Rien n’est doublé",
        '<p class="prose-inline">Deux\u202f?</p>',
        "On attend 4.",
        "Donné",
        "Attendu",
        "Obtenu",
        "0,5",
        "Que vaut le double",
        'loading="lazy"',
        f"{href}/figures/simple.svg?correction=",
        "&amp;theme=dark",
    ):
        assert text in page
    assert re.search(r"<p class=\"score\">0<", page)
    assert "x = np.array([2, 0.5])" in page


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("declared_curve", "en bleu, trait plein, les valeurs attendues"),
        ("declared_grid", "un carré orange entoure chaque case qui diffère."),
        ("of an older version", "Votre résultat superposé à la référence."),
    ],
)
def test_a_figure_says_what_it_shows_to_who_does_not_see_it(small_site: SmallSite, kind: str, words: str) -> None:
    href = small_site.submit()
    small_site.grade(verdict(), {"simple": {"kind": kind, "title": "", "expected": [[0.0], [1.0]], "got": None}})
    page = small_site.get(f"{href}/verdict")
    (alt,) = re.findall(r'alt="(Figure de[^"]*)"', page)
    (caption,) = re.findall("<figcaption[^>]*>(.*?)</figcaption>", page)
    assert alt.startswith("Figure de la vérification «\u00a0Des nombres simples\u00a0». ")
    assert words in alt
    assert words in caption, "and to who does"


def test_what_an_attempt_mended_is_told_though_the_mark_has_not_moved(small_site: SmallSite) -> None:
    centre = "Le lidar est placé au coin de la case"
    sum_ = "La croyance corrigée ne somme pas à 1"
    first = {"id": "centre", "title": f"{centre} — et aussi : {sum_}", "explanation": "Un."}
    page = small_site.get(small_site.attempt("x = 1", verdict(diagnosis=first)))
    assert "Depuis l’essai" not in page
    shown = {**first, "title": sum_, "explains": [[CHECK["id"]]], "certain": True}
    page = small_site.get(small_site.attempt("x = 2", verdict(diagnosis=shown)))
    told = re.sub(r"<[^>]*>|\s+", " ", page)
    for text in ("Depuis l’essai n° 1", f"N’est plus en cause : « {centre} »", f"Il reste : « {sum_} »"):
        assert re.sub(r"\s+", " ", text) in re.sub(r"\s+", " ", told)
    page = small_site.get(small_site.attempt("x = 3", verdict(diagnosis=shown)))
    assert "Depuis l’essai" not in page
    page = small_site.get(small_site.attempt("x = 4", verdict(diagnosis={**first, "title": "Autre chose"})))
    assert "plus en cause" not in page, "it is not recognised any more, which does not show that it is mended"


def test_the_place_in_the_queue_is_told(small_site: SmallSite) -> None:
    small_site.submit("a")
    small_site.submit("b")
    assert "2 envois passent avant le vôtre" in small_site.get(small_site.submit("c"))


def test_events_end_with_the_verdict(small_site: SmallSite) -> None:
    href = small_site.attempt("a", verdict())
    with small_site.client.stream("GET", f"{href}/evenements") as answer:
        assert answer.headers["content-type"].startswith("text/event-stream")
        body = "".join(answer.iter_text())
    assert body.startswith("event: status\ndata: ")
    assert '"status": "done"' in body


def test_events_of_nothing_are_a_404_before_any_stream(small_site: SmallSite) -> None:
    assert small_site.client.get(f"/soumissions/{uuid4()}/evenements").status_code == 404
    assert small_site.client.get("/soumissions/rien/evenements").status_code == 404


def test_who_waits_asks_for_the_place_alone_until_the_verdict_is_there(small_site: SmallSite) -> None:
    app: Any = small_site.client.app
    database = small_site.database
    small_site.submit("a")
    identity = UUID(small_site.submit("b").rpartition("/")[2])
    with database.read() as db:
        author = db.get_one(Account, db.get_one(Submission, identity).account_id)
    watch = WatchedSubmission(author, get_service(app, SubmissionService), database, identity)
    assert watch.read_state().text == "En attente : 1 envoi passe avant le vôtre."
    with Counted(database) as counted:
        assert not watch.read_state().done
    assert len(counted.statements) == 1
    small_site.grade(verdict())
    small_site.grade(verdict())
    assert watch.read_state().done
    stranger = WatchedSubmission(new_account(database), watch.store, database, identity)
    with pytest.raises(NotFound):
        stranger.read_state()


def test_without_script_a_form_leads_to_the_attempt(small_site: SmallSite) -> None:
    answer = small_site.client.post(f"{PAGE}/soumissions", data={"code": "a\r\nb"}, follow_redirects=False)
    assert answer.status_code == 303
    page = small_site.get(answer.headers["location"])
    assert '<noscript><meta http-equiv="refresh"' in page
    small_site.grade(verdict("ok", 20.0))
    page = small_site.get(answer.headers["location"])
    assert "http-equiv" not in page
    assert "Exercice réussi" in page


def test_attempts_are_kept_with_their_code(small_site: SmallSite) -> None:
    first = small_site.attempt("premier = 1", verdict())
    small_site.attempt("second = 2", verdict("ok", 20.0))
    page = small_site.get(first)
    assert "Essai n° 1" in page
    assert "premier" in page
    taken = small_site.get(f"{PAGE}?reprendre={first.rsplit('/', 1)[1]}")
    assert "\npremier = 1</textarea>" in taken
    assert 'data-taken="true"' in taken
    assert "\nsecond = 2</textarea>" in small_site.get(PAGE)
    assert "20 / 20" in small_site.get(f"{PAGE}/essais")
    assert "Réussi" in small_site.get("/m9")


def test_hints_open_with_changed_failed_attempts(small_site: SmallSite) -> None:
    def opened() -> int:
        return small_site.get(PAGE).count("<summary>Indice ")

    seen = [opened()]
    for number in range(max(HINT_OPENS_AFTER)):
        small_site.attempt(f"x = {number}", verdict())
        seen.append(opened())
    assert seen == [sum(count >= needed for needed in HINT_OPENS_AFTER) for count in range(len(seen))]


def test_the_same_code_again_opens_nothing(small_site: SmallSite) -> None:
    for code in ("x = 1", "x = 1\n\n# rien de neuf\n", "def double(x):\n    return x\n"):
        small_site.attempt(code, verdict())
    page = small_site.get(PAGE)
    assert page.count("<summary>Indice ") == 1
    assert "La formule" not in page


def test_the_same_file_again_is_no_new_attempt(small_site: SmallSite) -> None:
    now = {"exercise_version": small_site.version}
    first = small_site.attempt("x = 1", verdict(**now))
    small_site.attempt("x = 2", verdict(**now))
    assert small_site.submit("x = 1\r\n").split("?")[0] != first, "another file, be it by an empty line"
    small_site.grade(verdict(**now))
    assert small_site.submit("x = 1") == f"{first}?deja=true"
    told = "Ce code a déjà été envoyé"
    assert told in small_site.get(f"{first}/verdict?deja=true")
    assert told not in small_site.get(f"{first}/verdict")
    answer = small_site.client.post(f"{PAGE}/soumissions", data={"code": "x = 1"})
    assert (str(answer.url.path), told in answer.text) == (first, True)
    assert "en 3 essais" in small_site.get(PAGE)
    assert small_site.another().submit("x = 1").split("?")[0] != first


@pytest.mark.parametrize(
    ("outcome", "version"),
    [("timeout", None), ("memory_limit", None), ("internal_error", None), ("wrong_answer", "an older one")],
)
def test_what_may_end_otherwise_is_graded_again(small_site: SmallSite, outcome: str, version: str | None) -> None:
    first = small_site.attempt("x = 1", verdict(outcome, exercise_version=version or small_site.version))
    second = small_site.submit("x = 1")
    assert second != first
    assert small_site.submit("x = 1") == f"{second}?deja=true", "it waits for its verdict"


def test_the_solution_opens_after_success(small_site: SmallSite) -> None:
    assert "Corrigé" not in small_site.get(PAGE)
    small_site.attempt("x = 1", verdict("ok", 20.0))
    page = small_site.get(PAGE)
    assert "Corrigé" in page
    assert page.count("<summary>Indice ") == 3
    assert "Corrigé" not in small_site.another().get(PAGE)


def test_a_teacher_opens_and_closes_the_solution_for_all(small_site: SmallSite) -> None:
    pupil = small_site.another()
    assert pupil.client.post(f"{PAGE}/corrige", data={"ouvrir": "true"}).status_code == 401
    pupil.submit()
    assert pupil.client.post(f"{PAGE}/corrige", data={"ouvrir": "true"}).status_code == 403
    small_site.become_teacher()
    assert "Ouvrir le corrigé" in small_site.get(PAGE)
    assert small_site.client.post(f"{PAGE}/corrige", data={"ouvrir": "true"}).status_code == 200
    assert "Corrigé" in pupil.get(PAGE)
    assert "Refermer" in small_site.get(PAGE)
    small_site.client.post(f"{PAGE}/corrige", data={"ouvrir": "false"})
    assert "Corrigé" not in pupil.get(PAGE)


def test_what_nobody_takes_is_told_to_who_waits(small_site: SmallSite, monkeypatch: pytest.MonkeyPatch) -> None:
    app: Any = small_site.client.app
    monkeypatch.setattr(get_service(app, SubmissionService), "_is_stalled", lambda: True)
    href = small_site.submit()
    for path in (f"{href}/verdict", PAGE):
        assert "plus rien n’est corrigé depuis un moment" in small_site.get(path)
    small_site.grade(verdict())
    assert "plus rien" not in small_site.get(f"{href}/verdict")


def test_what_waits_for_a_worker_of_its_version_is_told_to_who_waits(small_site: SmallSite) -> None:
    app: Any = small_site.client.app
    href = small_site.submit()
    with get_service(app, Database).write() as db:
        assert get_service(app, SubmissionService)._queue.mark_refused(db, [GRADE], WorkerCapabilities([], 60.0))
    for path in (f"{href}/verdict", PAGE):
        assert "attend un correcteur de la même version" in small_site.get(path)
    small_site.grade(verdict())
    assert "la même version" not in small_site.get(f"{href}/verdict")


def test_somebody_elses_attempt_does_not_exist(small_site: SmallSite) -> None:
    href = small_site.attempt("secret = 1", verdict())
    other = small_site.another()
    other.submit()
    for path in (href, f"{href}/verdict", f"{href}/figures/simple.svg", f"{PAGE}?reprendre={href.rsplit('/', 1)[1]}"):
        assert "secret" not in other.get(path, status=404)
    teacher = small_site.another()
    teacher.become_teacher()
    assert "secret" in teacher.get(href)


def test_refusals_say_why(small_site: SmallSite) -> None:
    for number in range(8):
        small_site.submit(f"x = {number}")
    answer = small_site.client.post(f"{PAGE}/soumissions", data={"code": "x"}, headers={"Accept": "application/json"})
    assert answer.status_code == 429
    assert "en peu de temps" in answer.text
    answer = small_site.another().client.post(f"{PAGE}/soumissions", data={"code": "x" * 70_000})
    assert answer.status_code == 413
    assert "la limite de 64" in answer.text


HOSTILE = "<script>alert(1)</script>{{ 7 * 7 }}\x1b[31m\u202e</textarea></pre>"


def test_nothing_of_the_students_is_markup(small_site: SmallSite) -> None:
    check = {
        **CHECK,
        "message": HOSTILE,
        "counterexample": {"inputs": {HOSTILE: HOSTILE}, "expected": 1, "got": [HOSTILE]},
    }
    href = small_site.attempt(HOSTILE, verdict(stdout=HOSTILE, checks=[check]))
    for path in (href, f"{href}/verdict", PAGE):
        page = small_site.get(path)
        assert "<script>alert" not in page
        assert "{{ 7 * 7 }}" in page
        if path != PAGE:  # the editor gives back what was written, whatever it is
            assert "\x1b" not in page
            assert "\u202e" not in page
            assert "⟦U+202E⟧" in page


@pytest.mark.parametrize("outcome", Outcome)
def test_every_outcome_has_its_words(small_site: SmallSite, outcome: Outcome) -> None:
    href = small_site.attempt(outcome.value, verdict(outcome.value))
    page = re.sub(r"\s", " ", small_site.get(href))
    wording = outcome.wording()
    assert wording.title in page
    assert wording.sentence in page
    assert ('class="score"' in page) == outcome.counts


def test_a_file_that_does_not_load_is_told_once(small_site: SmallSite) -> None:
    checks = [
        {**CHECK, "id": name, "message": "Ligne 3 : il manque « : ».", "counterexample": None, "figure": None}
        for name in "ab"
    ]
    page = small_site.get(small_site.attempt("x", verdict("syntax_error", checks=checks)))
    assert page.count("Ligne 3") == 1


def test_static_files_are_kept_for_ever_and_nothing_else_is_served(small_site: SmallSite) -> None:
    styles = re.findall(r'href="(/static/[^"]+app\.css)"', small_site.get("/"))
    assert len(styles) == 1
    answer = small_site.client.get(styles[0])
    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith("text/css")
    small_site.get("/static/x/../../app.py", status=404)
    small_site.get("/static/x/%2e%2e/%2e%2e/app.py", status=404)


def test_no_page_names_another_site(small_site: SmallSite) -> None:
    href = small_site.attempt("x", verdict())
    for path in ("/", "/m9", PAGE, href, "/connexion"):
        page = small_site.get(path)
        addresses = re.findall(r'(?:href|src|srcset|action)="([^"]*)"', page)
        assert addresses
        assert not [one for one in addresses if not one.startswith(("/", "#", "?"))]
