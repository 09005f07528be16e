"""The place of a mistake in the student's own program: what is found, in how many steps, and in which words."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graders.core.code.changes import ProgramChange, add_loop_counters, find_changes, insert_variable_recorder
from graders.core.code.diagnosis import add_unexplained_checks
from graders.core.code.line_values import LineEvidence, insert_all_recorders, insert_line_recorder, judge_line_by_values
from graders.core.code.mending import Mending, MendingSearch, MendingStep, map_steps_to_original_lines, start_time_limit
from graders.core.code.places import add_place_to_diagnosis, diagnose_mendings, find_place, is_worth_searching
from graders.core.code.related_lines import JudgedFunctions, related_lines_sentence
from graders.core.code.variants import VariantCaller
from graders.core.contract.local import LOCAL
from graders.core.contract.program import KitSettings, Reply
from graders.core.contract.verdict import CheckResult, Diagnosis, Verdict
from tests.support.shipped import CODE
from tests.support.verdicts import knowing

KIT = KitSettings("l19")
EXERCISE = "l19/predire_corriger"
#: Without the mistakes of its catalogue, which are none of these programs'.
BARE = knowing(EXERCISE)
PROGRAM = """
def predire(m, v, u, q):
    return m + u, v + q

def corriger(m, v, z, r):
    a = 1 / v
    b = 1 / r
    moyenne = (a * m + b * z) / (a + b)
    return moyenne, 1 / (a + b)
"""


def verdict_of(source: str) -> Verdict:
    return CODE[EXERCISE].grade(source.encode(), LOCAL, seed=3, version="v").verdict


def mending_of(source: str) -> Mending | None:
    return MendingSearch(BARE, LOCAL, 3, lambda: False).find_mending(source)


def test_the_line_and_the_kind_of_thing_are_told_and_never_the_change() -> None:
    source = PROGRAM.replace("a = 1 / v", "a = 1 // v")
    verdict = verdict_of(source)
    found = find_place(BARE, source, verdict, LOCAL, lambda: False)
    assert found is not None
    assert found.diagnosis.title == "Changer la ligne 6 suffit"
    assert "« a = 1 // v »" in found.diagnosis.explanation
    assert "v y vaut" in found.diagnosis.explanation
    assert "1 / v" not in found.diagnosis.explanation
    assert set(found.diagnosis.explains[0]) == {check.id for check in verdict.checks if not check.passed}


def test_two_changes_are_found_one_after_the_other() -> None:
    source = PROGRAM.replace("a = 1 / v", "a = 1 // v").replace("m + u, v + q", "m + u, v + q + m * 1e-3")
    mending = mending_of(source)
    assert mending is not None
    assert sorted(step.change.line for step in mending.steps) == [3, 6]
    assert mending.left == frozenset()
    words = diagnose_mendings([mending], source, verdict_of(source).checks)
    first, second = words.titles
    assert first.startswith("Changer la ligne ")
    assert second.startswith("changer ensuite la ligne ")
    assert "autres vérifications" in second
    assert "Écrite autrement elle aussi" in words.explanation


def test_a_right_program_has_no_place_and_one_that_does_not_load_neither() -> None:
    assert mending_of(PROGRAM) is None
    assert mending_of("def predire(\n") is None


def test_nothing_is_searched_where_a_certain_name_explains_all() -> None:
    certain = verdict_of(PROGRAM.replace("v + q", "v - q"))
    assert certain.diagnosis is not None
    assert certain.diagnosis.certain
    assert not is_worth_searching(certain)
    assert is_worth_searching(verdict_of(PROGRAM.replace("1 / v", "1 // v")))


@pytest.mark.parametrize("loop", ["while True:\n        if v > 0: pass", "for k in iter(int, 1): pass"])
def test_a_changed_program_that_no_longer_ends_costs_nothing(loop: str) -> None:
    """The turns of each loop are counted, whatever stands first in its block."""
    counted = add_loop_counters(f"def f(v):\n    {loop}\n")
    assert counted.count("_tour()") == 1
    compile(counted, "solution.py", "exec")


def test_the_changes_of_other_functions_are_left_out() -> None:
    lines = {change.line for change in find_changes(PROGRAM, ["predire"], None, lambda: False)}
    assert lines == {3}


def test_a_function_that_draws_is_held_against_the_solution_with_the_same_draws() -> None:
    grader = knowing("l20/reechantillonnage")
    head = grader.solution.split("def reechantillonner_systematique")[0]
    source = (
        head
        + """def reechantillonner_systematique(particules, poids):
    N = len(poids)
    u = rng.random() / N
    garde, i, somme = [], 0, 0.0
    for k in range(N):
        while somme < u + k / N and i < N:
            somme += poids[i]
            i += 1
        garde.append(particules[min(i, N - 1)])
    return np.array(garde)
"""
    )
    mending = MendingSearch(grader, LOCAL, 3, lambda: False).find_mending(source)
    assert mending is not None
    assert not mending.left
    assert source.splitlines()[mending.steps[0].change.line - 1].strip().startswith("garde.append")


@pytest.mark.parametrize("second_name", ["poids = variances", "poids = np.asarray(variances)\n    poids = poids"])
def test_a_copy_that_changes_no_answer_mends_a_modified_argument(second_name: str) -> None:
    grader = knowing("l19/gain")
    head, _, tail = grader.solution.partition("def fusionner(mesures, variances):")
    returned = "np.dot(poids, mesures) / np.sum(poids), 1 / np.sum(poids)"
    body = f"    {second_name}\n    poids[:] = 1 / poids\n    return {returned}\n"
    rest = tail[tail.index("\ndef ") :]
    source = f"{head}def fusionner(mesures, variances):\n{body}\n{rest}"
    mending = MendingSearch(grader, LOCAL, 3, lambda: False).find_mending(source)
    assert mending is not None
    assert not mending.left
    assert "poids = " in source.splitlines()[mending.steps[0].change.line - 1]


def test_a_mistake_that_no_probe_shows_is_searched_on_the_calls_of_the_checks() -> None:
    """A single measure is the only wrong call, and no probe has one."""
    grader = knowing("l19/gain")
    head = "def fusionner(mesures, variances):\n"
    single = "    if len(mesures) == 1:\n        return mesures[0], 1 / variances[0]\n"
    source = grader.solution.replace(head, head + single)
    lines = source.splitlines()
    mending = MendingSearch(grader, LOCAL, 3, lambda: False).find_mending(source)
    assert mending is not None
    assert not mending.left
    (step,) = mending.steps
    assert {lines[change.line - 1].strip() for change in (step.change, *step.rivals)} & set(
        map(str.strip, single.splitlines())
    )


def test_one_check_that_a_second_change_mends_is_told_in_the_singular() -> None:
    steps = tuple(
        MendingStep(ProgramChange("", "", k, "angle"), frozenset({check})) for k, check in ((1, "a"), (2, "b"))
    )
    words = diagnose_mendings([Mending(steps, frozenset({"c"}))], "def f(g):\n    return 2 * g\n", ())
    assert words.titles[1].endswith("réussir 1 autre vérification")


def test_two_lines_that_only_together_mend_are_told_together() -> None:
    change = ProgramChange("", "", 2, "", "axes_echanges", (3,))
    mending = Mending((MendingStep(change, frozenset({"a"})),), frozenset())
    words = diagnose_mendings([mending], "def f(g):\n    n, m = g.shape\n    return g[n - 1, 0]\n", ())
    assert words.title == "Changer les lignes 2 et 3 suffit"
    assert "« n, m = g.shape »" in words.explanation
    assert "« return g[n - 1, 0] »" in words.explanation
    assert "Écrites autrement ensemble, ces lignes font réussir tout ce qui échoue." in words.explanation


def test_a_line_that_only_stands_at_the_wrong_place_is_to_be_moved() -> None:
    """As it is written it is right."""
    source = "def f(g):\n    g = g - 1\n    h = 2 * g\n    return g + h\n"
    moved = MendingStep(ProgramChange("", "", 2, "ordre des lignes"), frozenset({"a"}))
    words = diagnose_mendings([Mending((moved,), frozenset())], source, ())
    assert words.title == "Déplacer la ligne 2 suffit"
    assert "Placée autrement, cette seule ligne fait réussir tout ce qui échoue." in words.explanation
    rewritten = MendingStep(moved.change, moved.mended, (ProgramChange("", "", 3, "angle"),))
    assert diagnose_mendings([Mending((rewritten,), frozenset())], source, ()).title == "Changer la ligne 2 ou 3 suffit"


SHARED = """STEP = 1e-3

def raw(v):
    return v - 1

def first(v):
    return raw(v) % 7

def second(v):
    far = [k > v for k in range(9)]
    far[0] = True
    for k in range(-v, v):
        if far[k]:
            v += k * STEP
    return raw(v) + sum(far)
"""


@pytest.mark.parametrize(
    ("lines", "right", "told"),
    [
        ((15,), (), "Elle lit v (ligne 14) et far (ligne 11)."),
        ((12,), (), "k sert aux lignes 13 et 14."),
        ((14,), (), "Elle lit k (ligne 12) et STEP (ligne 1)."),
        ((11, 12), (), "Elles lisent far (ligne 10)."),
        ((4,), ("first",), "Mais raw sert aussi à first, qui n’a rien de faux : regardez plutôt ce que second en fait"),
        ((4,), (), ""),
        ((1,), (), ""),
    ],
)
def test_lines_that_have_to_do_with_a_changed_one_are_told(
    lines: tuple[int, ...], right: tuple[str, ...], told: str
) -> None:
    """What it reads is computed elsewhere, what it counts is read elsewhere, or a right function calls it too."""
    found = related_lines_sentence(SHARED, lines, JudgedFunctions(("second",), right))
    assert found.startswith(told) if told else not found
    borne_out = related_lines_sentence(SHARED, lines, JudgedFunctions(("second",), right), is_borne_out=True)
    assert borne_out == (found if right else "")


def test_two_lines_that_each_mend_all_are_both_told() -> None:
    """Where the sign is lost, and where the value is returned: neither is shown to be the wrong one."""
    source = PROGRAM.replace("return m + u, v + q", "w = -(v + q)\n    return m + u, w")
    mending = mending_of(source)
    assert mending is not None
    told = diagnose_mendings([mending], source, verdict_of(source).checks)
    assert told.titles == ("Changer la ligne 3 ou 4 suffit",)


def test_a_line_that_makes_up_for_the_wrong_one_is_told_beside_it() -> None:
    """Line 9 can be changed for the angle to come out right, though line 11 is the wrong one."""
    grader = CODE["l20/odometrie"]
    source = """import numpy as np


def odometrie(pose, ds_g, ds_d, L):
    x, y, theta = pose
    ds = (ds_g + ds_d) / 2
    dtheta = (ds_d - ds_g) / L
    cap = theta + dtheta / 2
    theta = theta + dtheta
    if abs(theta) > np.pi:
        theta = theta % np.pi
    return np.array([x + ds * np.cos(cap), y + ds * np.sin(cap), theta])


def sigma_dtheta(sigma_g, sigma_d, L):
    return np.sqrt(sigma_g**2 + sigma_d**2) / L
"""
    verdict = grader.grade(source.encode(), LOCAL, seed=3, version="v").verdict
    found = find_place(grader, source, verdict, LOCAL, lambda: False)
    assert found is not None
    assert found.diagnosis.title == "Changer la ligne 9 ou 11 suffit"
    assert "Ligne 9 : « theta = theta + dtheta ». Ligne 11 : « theta = theta % np.pi »." in found.diagnosis.explanation
    assert "une seule de ces lignes fait réussir tout ce qui échoue" in found.diagnosis.explanation


@pytest.mark.parametrize("unlikely", [True, False])
def test_a_kind_of_change_that_may_make_up_for_another_line_says_so(unlikely: bool) -> None:
    change = ProgramChange("", "", 2, "angle", is_unlikely=unlikely)
    mending = Mending((MendingStep(change, frozenset({"a"})),), frozenset())
    words = diagnose_mendings([mending], "def f(g):\n    return 2 * g\n", ())
    assert ("cherchez parmi les lignes qui calculent ou emploient les mêmes" in words.explanation) == unlikely


def test_what_the_last_name_explains_does_not_remain() -> None:
    change = ProgramChange("", "", 2, "angle")
    name = Diagnosis("angle", "L'angle n'est pas ramené", "Il sort de l'intervalle.", None, (("b",),))
    mending = Mending((MendingStep(change, frozenset({"a"})),), frozenset({"b", "c"}), name)
    checks = tuple(CheckResult(letter, letter.upper(), False, 0.0, 1.0) for letter in "abc")
    words = diagnose_mendings([mending], "def f(g):\n    return 2 * g\n", checks).explanation
    assert "Ce qui reste, une fois l'autre ligne écrite autrement : L'angle n'est pas ramené." in words
    assert "Autre vérification qui échoue : « C »." in words


def test_points_of_checks_that_wait_or_may_fail_for_the_same_reason_are_not_counted() -> None:
    named = Diagnosis("angle", "L'angle n'est pas ramené", "Il sort.", None, (("a",),))
    checks = [CheckResult(letter, letter.upper(), False, 0.0, 1.0) for letter in "abc"]
    checks.append(CheckResult("d", "D", False, 0.0, 8.0, neutral=True))
    words = add_unexplained_checks(named, checks, ["b"], mended=["a"]).explanation
    assert "Cela explique au moins 1 des 3 points perdus. Autre vérification qui échoue : « C »." in words
    assert "Les autres points attendent que le reste soit juste : « D »." in words
    assert (
        "Cela explique 2 des 3 points"
        in add_unexplained_checks(named, checks, besides=["b"], mended=["a", "b"]).explanation
    )
    assert "points perdus" not in add_unexplained_checks(named, checks, besides=["b"], mended=["b"]).explanation
    assert add_unexplained_checks(replace(named, explains=()), checks) == replace(named, explains=())


@pytest.mark.parametrize(("operator", "count"), [("signe", 0), ("copie", 1)])
def test_what_a_function_passes_that_does_nothing_shows_no_place(operator: str, count: int) -> None:
    grader = CODE["l19/gain"]
    intact = frozenset(check.id for check in grader.checks if check.requires_other_check)
    change = ProgramChange(grader.solution, grader.solution, 2, operator)
    assert len(MendingSearch(grader, LOCAL, 3, lambda: False).checks_mended_on_other_seeds(change, intact)) == count


def test_a_check_that_passes_on_the_inputs_of_one_seed_only_is_not_mended(monkeypatch: pytest.MonkeyPatch) -> None:
    search, (first, second, *_) = MendingSearch(CODE[EXERCISE], LOCAL, 3, lambda: False), CODE[EXERCISE].checks
    monkeypatch.setattr(search, "failed_checks", lambda text, is_late, seed, checks: checks[1:] if seed == 5 else [])
    assert search.checks_mended_on_other_seeds(ProgramChange("", "", 2, "signe"), frozenset((first.id, second.id))) == {
        first.id
    }


DISTANCE = """def distance(x, y):
    d = x - y
    return (d @ d) ** 0.5
"""


@pytest.mark.parametrize(
    ("wrong", "changed", "expected"),
    [
        # The sum is wrong, and an absolute value of the difference, which is right, makes up for it.
        (("d @ d", "d.sum() ** 2 / 2"), ("d = x - y", "d = np.abs(x - y)"), LineEvidence.RIGHT),
        (("x - y", "x + y"), ("x + y", "x - y"), LineEvidence.WRONG),
        (("x - y", "x + y"), ("x + y", "x + 2 * y"), LineEvidence.UNKNOWN),
    ],
)
def test_a_line_whose_values_the_solution_computes_too_is_right(
    wrong: tuple[str, str], changed: tuple[str, str], expected: LineEvidence
) -> None:
    source = DISTANCE.replace(*wrong)
    texts = [
        insert_line_recorder(source, 2),
        insert_line_recorder(source.replace(*changed), 2),
        insert_all_recorders(DISTANCE),
    ]
    calls = [(np.array([1.5, k]), np.array([4.2, 0.3])) for k in (2.0, 3.0)]
    seen = VariantCaller(LOCAL).record_line_values([text or "" for text in texts], "distance", calls, KIT)
    rows = [[answer.value for answer in answers if isinstance(answer, Reply)] for answers in seen]
    assert judge_line_by_values(*rows) is expected


@pytest.mark.parametrize(
    ("statement", "shown"),
    [("a, b = x\n    return a", "a, b = x; _voir(a, b)"), ("return (x + 1)", "return (_voir(x + 1))"), ("pass", None)],
)
def test_a_statement_shows_what_it_sets_or_returns(statement: str, shown: str | None) -> None:
    text = insert_line_recorder(f"def f(x):\n    {statement}\n", 2)
    assert (text is None) if shown is None else text is not None and text.splitlines()[1].strip() == shown


@pytest.mark.parametrize(("doubtful", "left", "count"), [(True, "b", 0), (True, "", 1), (False, "b", 1)])
def test_an_unlikely_change_that_leaves_a_failure_proves_nothing(
    doubtful: bool, left: str, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    search, failed = MendingSearch(CODE[EXERCISE], LOCAL, 3, lambda: False), CODE[EXERCISE].checks[: 1 + len(left)]
    step = MendingStep(ProgramChange(PROGRAM, PROGRAM, 2, "variable"), frozenset((failed[0].id,)), (), doubtful)
    monkeypatch.setattr(search, "failed_checks", lambda source: failed)
    monkeypatch.setattr(search, "_search_steps", lambda *_: [step])
    mending = search.find_mending(PROGRAM)
    assert (0 if mending is None else len(mending.steps)) == count


def test_the_lines_of_a_second_change_are_those_of_the_program_as_it_was() -> None:
    first = ProgramChange("a\nnew\nb\nc\n", "", 2, "copie")
    second = ProgramChange("a\nnew\nb\nd\n", "", 4, "signe")
    steps = (MendingStep(first, frozenset({"x"})), MendingStep(second, frozenset({"y"})))
    assert [step.change.line for step in map_steps_to_original_lines("a\nb\nc\n", steps)] == [2, 3]


def test_what_is_read_unsorted_is_sorted() -> None:
    source = "def f(x):\n    y = x\n    return [z for z in y]\n"
    changes = [change for change in find_changes(source, ["f"], None, lambda: False) if change.operator == "rangement"]
    assert [change.line for change in changes] == [2, 3]


@pytest.mark.parametrize(
    ("line", "mended"),
    [
        ("return a + b / 2", "return (((a) + (b)) / (2))"),
        ("return x - y * c", "return (((x) - (y)) * (c))"),
        ("return (x @ x) ** 1 / 2", "return ((x @ x) ** ((1) / (2)))"),
    ],
)
def test_missing_parentheses_are_put(line: str, mended: str) -> None:
    changes = find_changes(f"def f(a, b, c, x, y):\n    {line}\n", ["f"], None, lambda: False)
    assert [change.text.split("\n")[1].strip() for change in changes if change.operator == "parenthèses"] == [mended]


def test_a_line_notes_what_it_reads() -> None:
    noted = insert_variable_recorder(PROGRAM, 8)
    assert noted is not None
    assert noted[1] == ["moyenne", "a", "m", "b", "z"]
    assert insert_variable_recorder(PROGRAM, 5) is None


def test_a_place_is_joined_to_a_name() -> None:
    place = Diagnosis("lieu", "Changer la ligne 6 suffit", "Ligne 6 : « a ».\n\nQue vaut a ?")
    assert add_place_to_diagnosis(None, place) is place
    joined = add_place_to_diagnosis(Diagnosis("x", "Un nom", "Pourquoi."), place)
    assert (joined.id, joined.title) == ("x", "Un nom")
    told = "Dans votre programme : changer la ligne 6 suffit. Ligne 6 : « a »."
    assert joined.explanation == f"Pourquoi.\n\n{told}"


def test_two_names_of_the_same_checks_give_way_to_one_place_that_mends_them() -> None:
    both = Diagnosis("x", "Un nom — et aussi : Un autre", "Pourquoi.", None, (("a", "b"), ("a", "b")), certain=True)
    assert (
        add_place_to_diagnosis(both, Diagnosis("lieu", "Changer la ligne 6 suffit", "Là.", None, (("a", "b"),))).id
        == "lieu"
    )
    assert (
        add_place_to_diagnosis(both, Diagnosis("lieu", "Changer la ligne 6 suffit", "Là.", None, (("a",),))).id == "x"
    )
    two_places = Diagnosis("lieu", "Ligne 6 — et aussi : ligne 7", "Là.", None, (("a",), ("b",)))
    assert add_place_to_diagnosis(both, two_places).id == "x"


def test_a_name_in_another_function_is_held_against_its_own_answers() -> None:
    """A wrong upper end alone gives some opinions that a normal law gives too, and another band."""
    grader = CODE["l19/coherence"]
    source = (
        grader.solution.replace("def bande(", "def autre(")
        + """

def bande(n, N, niveau=0.95):
    from scipy.stats import chi2

    return chi2.ppf((1 - niveau) / 2, n * N) / N, chi2.ppf(niveau, n * N) / N
"""
    )
    found = grader.grade(source.encode(), LOCAL, seed=2026, version="v").verdict.diagnosis
    assert found is None or found.id != "loi_normale"


def test_a_zero_taken_for_no_value_and_a_line_that_sets_one_name_too_late_are_changed() -> None:
    source = "def f(x, date):\n    a, b = x\n    if not date:\n        return a\n    _, b = date, a\n    return b\n"
    texts = [change.text for change in find_changes(source, ["f"], None, lambda: False)]
    assert source.replace("not date", "(date is None)") in texts
    assert source.replace("_, b = date, a", "pass") in texts


def test_a_search_spends_the_processor_time_of_its_programs_too() -> None:
    class Metered:
        spent = 0.0

        def ended_cpu_seconds(self) -> float:
            return self.spent

    programs = Metered()
    is_spent = start_time_limit(1e9, 1e3, programs)  # type: ignore[arg-type]
    assert not is_spent()
    programs.spent = 1e3 + 1.0
    assert is_spent()
    assert not start_time_limit(1e9, 1e3, LOCAL)()
