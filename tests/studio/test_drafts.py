"""Drafts: nothing typed is lost, the trial says what holds, and what it proposes is taken up with one button."""

from __future__ import annotations

import re
from html import unescape

import pytest

from graders.core.declared.case_reading import parse_scenario
from graders.core.declared.declaration import read_declaration
from graders.core.declared.grading import DeclaredGrader
from graders.core.declared.scenarios import Scenario
from graders.core.declared.tolerances import propose_tolerance
from server.grading.sandbox_grader import SandboxPrograms
from server.grading.trial_task import TRIAL_POLICY
from server.sandbox import Sandbox
from server.studio.drafts import EXAMPLES_TITLE, MORE_EXAMPLES_TITLE, ExerciseDraft
from server.studio.models import AuthoredExercise
from server.studio.service import find_own_exercise, read_draft

from .conftest import FORM, MISTAKE, SOLUTION, Studio

#: The calls of a function of one number, whose results are the solution's.
PLAIN = {
    "v-0-c-0-appel": "f(1)", "v-0-c-0-attendu": "", "v-0-c-1-appel": "f(2)", "v-0-c-1-attendu": "", "v-0-c-2-appel": "",
}  # fmt: skip


def test_a_draft_is_tried_as_it_is_saved(studio: Studio) -> None:
    path = studio.create()
    answer = studio.browser.post(path, data={**FORM, "action": "brouillon"})
    assert answer.status_code == 200
    assert "Essai en cours" in answer.text
    studio.work()
    told = studio.report(path)
    assert "compter_mots(&#34;le Chat&#34;) → {&#39;le&#39;: 1, &#39;Chat&#39;: 1}" in re.sub(r" +", " ", told)
    assert "0 acceptée à tort" in told
    assert "x1 = mots(&#39;a b le Chat&#39;, 0, 3, espaces=True)" in told
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
    assert "Ajouter les cas cochés" in told
    typed = {name: value for name, value in FORM.items() if not name.startswith(("v-0-c-1", "v-0-c-2"))}
    typed |= {"v-0-c-1-appel": 'compter_mots("a b")'}
    assert "Vous n’avez coché aucun cas" in studio.browser.post(path, data={**typed, "action": "cas"}).text
    picked = re.findall(r'name="cas" value="([^"]+)"', studio.browser.get(path).text)
    assert picked
    studio.browser.post(path, data={**typed, "action": "cas", "cas": [unescape(case) for case in picked]})
    studio.work()
    assert len(read_draft(studio.stored(path)).checks[0].cases) > 2
    assert "0 acceptée à tort" in studio.report(path)
    offered = re.findall(r'name="erreur" value="(\w+)"', studio.browser.get(path).text)
    answer = studio.browser.post(path, data={**typed, "action": "erreurs", "erreur": offered[:2]})
    assert answer.status_code == 303
    mistakes = read_draft(studio.stored(path)).mistakes
    assert len(mistakes) == 2
    assert len({mistake.title for mistake in mistakes}) == 2
    assert all(mistake.program != SOLUTION and "`" not in mistake.title for mistake in mistakes)
    for picked, words in (({"erreur": "0" * 12}, "L’essai a changé depuis"), ({}, "Vous n’avez coché aucune erreur")):
        refused = studio.browser.post(path, data={**FORM, "action": "erreurs", **picked})
        assert refused.status_code == 422
        assert words in refused.text
    assert studio.browser.post(path, data={**FORM, "action": "erreur:1"}).status_code == 404


@pytest.mark.parametrize(
    ("changes", "title"),
    [
        ({}, EXAMPLES_TITLE),
        ({"enonce": "Écrivez `f`.\n\n```python\n>>> f(1)\n2\n```"}, MORE_EXAMPLES_TITLE),
        ({"v-0-titre": "Des entiers", "enonce": "```\nf\n```"}, "Des entiers"),
    ],
)
def test_the_statement_shows_the_examples_that_its_check_is_named_after(
    studio: Studio, changes: dict[str, str], title: str
) -> None:
    path = studio.create()
    calls = {f"v-0-c-{number}-appel": f"f({number})" for number in range(5)}
    studio.save(path, **{**PLAIN, "solution": "def f(x):\n    return x + 1\n", **calls, **changes})
    trial = studio.stored(path).trial
    assert trial is not None
    completed = trial["completed"]
    assert completed["declaration"]["verifications"][0]["titre"] == title
    if not changes:
        assert all(
            f">>> {call}\n{number + 1}\n" in completed["statement"] for number, call in enumerate(calls.values())
        )


def test_two_versions_of_a_draft_are_shown_in_words(studio: Studio) -> None:
    path = studio.create()
    older = re.findall(r'name="version" value="(\w+)"', studio.browser.get(path).text)
    studio.save(path)
    refused = studio.save(path, **{"version": older, "titre": "Compter", "v-0-tolerance": "1e-3"})
    assert refused.status_code == 409
    page = unescape(refused.text)
    assert "votre version n’est que sur cette page" in page
    assert 'compter_mots("a b a") → {"a": 2, "b": 1}\ncompter_mots("le  Chat") → (celui de la solution)' in page
    assert "Écart permis : 1e-3" in page
    assert '{"title"' not in page


def test_an_exception_that_nobody_expects_is_a_fault_of_the_solution(studio: Studio) -> None:
    """An exception of the solution is the answer only once its author says so; one of a typing mistake never is."""
    path = studio.create()
    divides = {**PLAIN, "solution": "def f(x):\n    return 6 / x\n", "v-0-c-2-appel": "f(0)"}
    studio.save(path, **divides, action="publier")
    assert "Un diviseur est nul" in studio.report(path)
    assert "Attendre ZeroDivisionError" in studio.report(path)
    assert studio.stored(path).number == 0
    studio.save(path, **divides, action="attendre:0:2")
    assert read_draft(studio.stored(path)).checks[0].cases[2].expected == "ZeroDivisionError"
    assert "Exemples ✓" in studio.report(path)
    studio.save(path, **{**PLAIN, "solution": "def f(x):\n    return y / x\n"})
    assert "n’est défini nulle part" in studio.report(path)
    assert "Attendre" not in studio.report(path)


def test_of_a_class_too_mistakes_and_cases_are_proposed(studio: Studio) -> None:
    stack = "class Pile:\n    def __init__(self):\n        self.t = []\n    def empiler(self, x):\n"
    stack += "        self.t.append(x)\n    def depiler(self):\n        return self.t.pop()\n"
    path, form = studio.create(), {**PLAIN, "solution": stack, "v-0-c-1-appel": ""}
    studio.save(path, **{**form, "v-0-c-0-appel": "p = Pile(); p.empiler(3); p.depiler()"})
    page = unescape(studio.browser.get(path).text)
    assert re.search(r'name="cas" value="p = Pile\(\); p.empiler\(\d\); p.empiler', page), "a call more shows the order"
    studio.save(path, **{**form, "v-0-c-0-appel": "p = Pile(); p.empiler(3); p.empiler(4); p.depiler()"})
    assert "self.t.append(x) → self.t.insert(0, x) Dans" in studio.report(path), "as pop(0), which answers alike"
    shown = studio.browser.get(f"{path}/essayer").text
    assert "Classe demandée" in shown
    assert "class Pile : empiler(x), depiler()" in shown
    assert shown.count("Pile") == shown.replace("Écrire la classe Pile", "").count("Pile"), "the statement says it"


def test_draws_are_proposed_and_never_join_unasked(studio: Studio) -> None:
    path = studio.create()
    form = {**PLAIN, "solution": "def f(a, b):\n    return b - a\n"}
    form |= {"v-0-c-0-appel": "f(1, 2)", "v-0-c-1-appel": "f(0, 7)"}
    studio.save(path, **form)
    report, trial = studio.report(path), studio.stored(path).trial
    assert trial is not None
    assert "Ajouter ces tirages" in report
    assert "avec x1 &lt; x2" in report
    assert len(trial["completed"]["declaration"]["verifications"]) == 1
    assert re.search(r"f\(-?\d, \d\) → \d", report), "some of the inputs are seen, with the solution's answers"
    studio.save(path, **form, action="tirages")
    drawn = read_draft(studio.stored(path)).checks[1]
    assert (drawn.call, drawn.conditions, drawn.points) == ("f(x1, x2)", "x1 < x2", "8")
    page = studio.browser.get(path).text
    assert "Retirer cette vérification" in page
    assert "Ajouter ces tirages" not in studio.report(path)
    fields = {"v-1-tirages": drawn.draws, "v-1-appel": drawn.call, "v-1-points": "8"}
    studio.save(path, **form, **fields, action="retirer-verification:1")
    assert len(read_draft(studio.stored(path)).checks) == 1


def test_an_exception_of_a_drawn_input_is_told(studio: Studio) -> None:
    path = studio.create()
    form = {
        **PLAIN,
        "solution": "def f(x):\n    return 6 / x\n",
        "v-0-tirages": "x = entier(0, 0)",
        "v-0-appel": "f(x)",
    }
    studio.save(path, **form)
    assert "f(0) , votre solution lève ZeroDivisionError" in studio.report(path)


def test_a_proposed_case_tells_what_the_examples_have_and_it_has_not(studio: Studio) -> None:
    path = studio.create()
    form = {**PLAIN, "solution": "def f(a, b):\n    return max(a, b) - a\n"}
    studio.save(path, **{**form, "v-0-c-0-appel": "f(1, 2)", "v-0-c-1-appel": "f(0, 7)"})
    assert "Dans vos exemples, a est toujours inférieur à b" in studio.report(path)
    studio.save(path, **{**form, "v-0-c-0-appel": "f(0, 2)", "v-0-c-1-appel": "f(0, 7)"})
    assert "Dans vos exemples, a vaut toujours 0" in studio.report(path), (
        "a relation with what is the same says nothing"
    )


@pytest.mark.parametrize(("call", "expected"), [("f(2)", "3,5"), ("f(1,5)", "")])
def test_a_decimal_comma_is_advised(studio: Studio, call: str, expected: str) -> None:
    path = studio.create()
    form = {**PLAIN, "solution": "def f(x):\n    return x + 1.5\n", "v-0-c-0-appel": call, "v-0-c-0-attendu": expected}
    studio.save(path, **form)
    assert "un nombre décimal s’écrit avec un point" in studio.report(path)


def test_what_is_left_before_publication_is_listed(studio: Studio) -> None:
    path = studio.create()
    studio.save(path, **{**MISTAKE, "e-0-explication": "", "titre": "", "v-0-c-1-attendu": "{}"})
    report = studio.report(path)
    assert "Avant de publier, il reste à faire : Donnez un titre" in report
    assert "Votre erreur connue sera essayée quand tous les exemples seront justes" in report
    studio.save(path, **MISTAKE)
    assert "Prêt à publier" in studio.report(path)


def test_the_tolerance_is_said_beside_decimal_answers_and_changed_there(studio: Studio) -> None:
    path = studio.create()
    form = {**PLAIN, "solution": "def f(x):\n    return x / 3\n"}
    studio.save(path, **form)
    assert re.search(r'name="ecart-0" value="" placeholder="1e-9"', studio.browser.get(path).text)
    studio.save(path, **form, **{"ecart-0": "1e-6"})
    assert read_draft(studio.stored(path)).checks[0].tolerance == "1e-6"
    studio.save(path, **form, **{"ecart-0": "1e-6", "v-0-tolerance": "1e-4"})
    assert read_draft(studio.stored(path)).checks[0].tolerance == "1e-4", "the other field is changed"
    page = studio.browser.get(path).text
    assert "écart permis : 1e-4" in page, "the fold says what it holds"
    studio.save(path, **{**form, "v-0-c-0-attendu": "0.3333"}, **{"v-0-tolerance": "1e-4"})
    trial = studio.stored(path).trial or {}
    assert ">>> f(1)\n0.3333\n>>> f(2)\n0.6666" in trial["completed"]["statement"], "students see what was typed"
    studio.save(path, **{**form, "solution": "def f(x):\n    return x\n"})
    assert "ecart-0" not in studio.browser.get(path).text


def test_a_long_list_of_exercises_is_searched_and_paged(studio: Studio) -> None:
    with studio.site.database.write() as db:
        for number in range(40):
            draft = ExerciseDraft(title=f"Tri {number:02d}", themes="tableaux" if number % 2 else "récursivité")
            db.add(
                AuthoredExercise(author_id=studio.teacher.id, module="l20", draft=draft.to_data(), digest=draft.digest)
            )
    first = studio.browser.get("/mes-exercices").text
    second = studio.browser.get("/mes-exercices", params={"page": 2}).text
    titles = [re.findall(r">(Tri \d\d)<", page) for page in (first, second)]
    assert [len(page) for page in titles] == [30, 10]
    assert len({*titles[0], *titles[1]}) == 40
    assert "page=2" in first
    found = studio.browser.get("/mes-exercices", params={"q": "recursivite tri"}).text
    assert len(re.findall(r">Tri \d\d<", found)) == 20
    assert "20 exercices sur 40" in found.replace("\u202f", " ").replace("\xa0", " ")
    assert "ne contient tous ces mots" in studio.browser.get("/mes-exercices", params={"q": "piles"}).text


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
            find_own_exercise(db, studio.teacher.account, path.rpartition("/")[2])


BISECTION = """def dichotomie(f, a, b, {name}):
    while b - a > {name}:
        m = (a + b) / 2
        if f(a) * f(m) <= 0:
            b = m
        else:
            a = m
    return (a + b) / 2
"""


@pytest.mark.parametrize(
    ("solution", "given", "tolerance"),
    [
        (BISECTION.format(name="eps"), "0.001", "eps"),
        (BISECTION.format(name="largeur"), "0.001", "largeur"),
        ("def racine(x, a, b, tol):\n    return x ** 0.5\n", "1e-6", "tol"),
        ("def arrondi(x, a, b, precision):\n    return round(2 / 3, precision)\n", "2", ""),
        ("def pas(f, t, y, h):\n    return y + h * f(t + y)\n", "0.1", ""),
    ],
)
def test_the_precision_that_a_call_asks_for_is_the_tolerance(solution: str, given: str, tolerance: str) -> None:
    name = solution[4 : solution.index("(")]
    calls = [f"{name}(lambda x: x - {number}, 0, 2, {given})" for number in (1, 0.7)]
    scenarios = [Scenario(parse_scenario(call, [name])) for call in calls]
    assert propose_tolerance(solution, scenarios) == tolerance


def test_the_page_proposes_the_precision_and_other_bisections_are_right(
    studio: Studio, course_sandbox: Sandbox
) -> None:
    """A recursive bisection that returns an end of its last interval was given 0 for being nearer to the root."""
    path = studio.create()
    recursive = (
        "def dichotomie(f, a, b, eps):\n    m = (a + b) / 2\n    if b - a <= eps:\n        return a\n"
        "    return dichotomie(f, a, m, eps) if f(a) * f(m) <= 0 else dichotomie(f, m, b, eps)\n"
    )
    form = {**PLAIN, "solution": BISECTION.format(name="eps"), "v-0-c-0-attendu": "", "v-0-c-1-attendu": ""}
    calls = {"v-0-c-0-appel": "dichotomie(lambda x: x ** 3 - 2, 1, 3, 0.001)"}
    calls["v-0-c-1-appel"] = "dichotomie(lambda x: x - 1, 0, 3, 1e-6)"
    studio.browser.post(path, data=FORM | form | calls)
    studio.worker.run_one()  # the changes of a bisection take their time
    assert 'name="ecart-0" value="" placeholder="eps"' in studio.browser.get(path).text
    declared = (studio.stored(path).trial or {})["completed"]["declaration"]
    assert declared["verifications"][0]["tolerance"] == "eps"
    grader = DeclaredGrader("l20/essai", read_declaration(declared))
    graded = grader.grade(recursive.encode(), SandboxPrograms(course_sandbox, TRIAL_POLICY), seed=1, version="")
    assert graded.verdict.points == 20
