"""Naming, simplifying and refusals of declared exercises."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import Verdict
from graders.core.declared.case_reading import parse_expected, parse_scenario
from graders.core.declared.declaration import read_declaration
from graders.core.declared.draws_reading import parse_draws
from graders.core.declared.grading import DeclaredGrader, SolutionFault
from graders.core.declared.malformed import MalformedDeclaration
from server.grading.sandbox_grader import SandboxPrograms
from server.sandbox import Sandbox

from .conftest import POLICY
from .kinds import STACK, declare

MEAN = "def moyenne(t):\n    return sum(t) / len(t) if t else 0.0\n"
INTEGER = {
    "id": "division_entiere",
    "titre": "La division est entière",
    "explication": "`//` arrondit vers le bas.",
    "question": "Que vaut 1 // 2 ?",
    "programme": "def moyenne(t):\n    return sum(t) // len(t) if t else 0.0\n",
}
EMPTY = {
    "id": "liste_vide",
    "titre": "La liste vide est oubliée",
    "explication": "Elle n’a aucun élément.",
    "question": "Que vaut len([]) ?",
    "programme": "def moyenne(t):\n    return sum(t) / len(t)\n",
}
DECLARATION = declare(
    "moyenne", MEAN, "moyenne([])", "moyenne([1, 2])", tirages="t = liste(entier(-9, 9), 2, 8)", appel="moyenne(t)",
    erreurs=[INTEGER, EMPTY],
)  # fmt: skip


def graded(sandbox: Sandbox, declaration: dict[str, Any], source: str, seed: int = 3) -> Verdict:
    grader = DeclaredGrader("essai/un", read_declaration(declaration))
    programs = SandboxPrograms(sandbox, POLICY, asked=grader.functions)
    return grader.grade(source.encode(), programs, seed=seed, version="1").verdict


def test_a_known_mistake_is_named_by_its_answers_whatever_its_text(sandbox: Sandbox) -> None:
    other = "import math\ndef moyenne(t):\n    if not t:\n        return 0\n    return math.floor(sum(t) / len(t))\n"
    named = graded(sandbox, DECLARATION, other).diagnosis
    assert named is not None
    assert named.id == "division_entiere"
    assert "Que vaut 1 // 2 ?" in named.explanation
    assert graded(sandbox, DECLARATION, "def moyenne(t):\n    return t[0] if t else 0.0\n").diagnosis is None


def test_a_known_mistake_is_named_within_the_tolerance(sandbox: Sandbox) -> None:
    """A student's other way to the same mistake differs by rounding, or by what the exercise takes for the same."""
    third = {**EMPTY, "id": "tiers", "programme": "def f(x):\n    return x / 3\n"}
    near = {**EMPTY, "id": "presque", "programme": "def f(x):\n    return x / 3 + 4e-4\n"}
    declaration = declare("f", "def f(x):\n    return x / 2\n", "f(1)", "f(2)", tolerance=1e-3, erreurs=[third])

    def name(declared: dict[str, Any], added: float) -> str:
        found = graded(sandbox, declared, f"def f(x):\n    return 0.33333333333 * x + {added}\n").diagnosis
        return found.id if found else ""

    assert name({**declaration, "erreurs": [third, near]}, 0.0) == "tiers", "as near as digits tell"
    assert [name(declaration, added) for added in (2e-4, 2e-2)] == ["tiers", ""]
    assert name({**declaration, "erreurs": [third, near]}, 2e-4) == "", (
        "two are as near: no name is better than a wrong one"
    )


def test_a_known_mistake_that_never_ends_in_a_case_is_named(sandbox: Sandbox) -> None:
    loops = "def moyenne(t):\n    while not t:\n        pass\n    return sum(t) / len(t)\n"
    declaration = declare("moyenne", MEAN, "moyenne([1, 2])", "moyenne([])", erreurs=[{**EMPTY, "programme": loops}])
    named = graded(sandbox, declaration, loops).diagnosis
    assert named is not None
    assert named.id == "liste_vide"


def test_drawn_counterexamples_are_simplified_within_what_may_be_drawn(sandbox: Sandbox) -> None:
    declaration = declare("moyenne", MEAN, tirages="t = liste(entier(-9, 9), 2, 8)", appel="moyenne(t)")
    (check,) = graded(sandbox, declaration, "def moyenne(t):\n    return sum(t)\n").checks
    assert check.counterexample is not None
    given = check.counterexample.inputs["t"]
    assert len(given) == 2
    assert sum(abs(number) for number in given) == 1


def test_the_same_seed_gives_the_same_verdict(sandbox: Sandbox) -> None:
    wrong = "def moyenne(t):\n    return sum(t)\n"
    first, second = (graded(sandbox, DECLARATION, wrong, seed=5).to_json() for _ in range(2))
    assert {**first, "timings": {}} == {**second, "timings": {}}


@pytest.mark.parametrize(
    ("source", "outcome"),
    [
        ("def moyenne(t:\n    pass\n", Outcome.SYNTAX_ERROR),
        ("def autre(t):\n    return 0\n", Outcome.MISSING_FUNCTION),
        ("def moyenne(t):\n    return sum(t) / len(t)\n", Outcome.RUNTIME_ERROR),
        ("def moyenne(t):\n    while True:\n        pass\n", Outcome.TIMEOUT),
        ("import os\ndef moyenne(t):\n    os._exit(0)\n", Outcome.RUNTIME_ERROR),
        ("def moyenne(t):\n    return [0] * 10**6\n", Outcome.OUTPUT_LIMIT),
        ("import os\ndef moyenne(t):\n    return os\n", Outcome.INVALID_OUTPUT),
    ],
)
def test_each_end_of_a_program_has_its_outcome(sandbox: Sandbox, source: str, outcome: Outcome) -> None:
    verdict = graded(sandbox, DECLARATION, source)
    assert verdict.outcome is outcome, verdict.checks
    assert verdict.points == 0


def test_no_expected_value_is_in_the_process_of_the_student(sandbox: Sandbox) -> None:
    """All that a program can reach, its caller's frames included, holds the steps and nothing of the solution."""
    spy = (
        "import sys\ndef moyenne(t):\n    frame, seen = sys._getframe(), []\n"
        "    while frame:\n        seen.append(repr(frame.f_locals)[:4000])\n        frame = frame.f_back\n"
        "    print(seen)\n    return 0\n"
    )
    declaration = declare("moyenne", "def moyenne(t):\n    return 1234567.25\n", "moyenne([1])")
    assert "1234567" not in graded(sandbox, declaration, spy).stdout


def test_a_solution_that_fails_is_our_own_fault(sandbox: Sandbox) -> None:
    declaration = declare("f", "def f(x):\n    while True:\n        pass\n", "f(1)")
    with pytest.raises(SolutionFault, match=r"f\(1\)"):
        graded(sandbox, declaration, "def f(x):\n    return 1\n")


@pytest.mark.parametrize(
    ("changes", "place", "words"),
    [
        ({"fonctions": []}, "fonctions", "au moins une fonction"),
        ({"inconnu": 1}, "", "clé inconnue : « inconnu »"),
        ({"cas": ["autre(1)"]}, "verifications[0].cas[0]", "n’est pas une de vos fonctions"),
        ({"cas": ["f(__import__('os'))"]}, "verifications[0].cas[0]", "seules set, bytes"),
        ({"cas": ["f(np.array([None, 1]))"]}, "verifications[0].cas[0]", "ne tient ici que des nombres"),
        ({"cas": ["f(x)"]}, "verifications[0].cas[0]", "« x » n’est pas connu ici"),
        ({"cas": ["f(cos)"]}, "verifications[0].cas[0]", "écrivez « math.cos », ou « from math import cos »"),
        ({"cas": ["f(lambda x: exp(x))"]}, "verifications[0].cas[0]", "écrivez « math.exp »"),
        ({"cas": ["f(lambda x: seuil)"]}, "verifications[0].cas[0]", "importez-le dans votre solution"),
        ({"cas": ["f(math.__loader__)"]}, "verifications[0].cas[0]", "deux soulignés"),
        ({"cas": ["f((1"]}, "verifications[0].cas[0]", "n’est pas du Python"),
        ({"cas": ["f(" + "[" * 60 + "]" * 60 + ")"]}, "verifications[0].cas[0]", "imbriquées"),
        ({"cas": ["f(9 ** 9 ** 9)"]}, "verifications[0].cas[0]", "un million à la puissance 64"),
        ({"cas": ["p = f(1); p.__class__()"]}, "verifications[0].cas[0]", "deux soulignés"),
        ({"cas": ["sorted(f(1))"]}, "verifications[0].cas[0]", "appelez votre fonction seule, f(1), et choisissez"),
        ({"cas": ["import os"]}, "verifications[0].cas[0]", "écrivez des appels"),
        ({"points": 12}, "verifications", "les points font 12"),
        ({"tirages": "a = entier(3, 1)", "appel": "f(a)"}, "verifications[0].tirages", "rien entre ces deux bornes"),
        ({"tirages": "a = hasard()", "appel": "f(a)"}, "verifications[0].tirages", "de générateurs"),
        (
            {"tirages": "a = entier(0, 9)", "appel": "f(a)", "conditions": ["a > 9"]},
            "verifications[0].tirages",
            "jamais",
        ),
        (
            {"tirages": "a = liste(entier(0, 1), 9000, 9001)", "appel": "f(a)"},
            "verifications[0].tirages",
            "2000 au plus",
        ),
        ({"tirages": "a = entier(0, 1)"}, "verifications[0]", "vont ensemble"),
        ({"ordre": "peut-être"}, "verifications[0].ordre", "oui, non, ensemble"),
        ({"tolerance": -1}, "verifications[0].tolerance", "nombre positif"),
        ({"interdits": ["a b"]}, "interdits[0]", "un nom de fonction"),
        ({"erreurs": [{**EMPTY, "id": "É"}]}, "erreurs[0].id", "minuscules sans accent"),
        ({"erreurs": [EMPTY, EMPTY]}, "erreurs", "deux fois le même"),
        ({"solution": 3}, "solution", "il faut un texte"),
    ],
)
def test_a_malformed_declaration_is_told_with_its_place(changes: dict[str, Any], place: str, words: str) -> None:
    declaration = declare("f", "def f(x):\n    return x\n", "f(1)")
    of_check = {key for key in changes if key not in {*declaration, "inconnu", "interdits", "erreurs"}}
    declaration["verifications"][0].update({key: changes[key] for key in of_check})
    declaration.update({key: value for key, value in changes.items() if key not in of_check})
    with pytest.raises(MalformedDeclaration) as refused:
        read_declaration(declaration)
    assert refused.value.place == place
    assert words in refused.value.message


@pytest.mark.parametrize(
    ("program", "passes"),
    [
        ("def f(x, eps=1.0):\n    return x\n", True),
        ("def f(x, eps=1.0):\n    return x + 0.4 * eps\n", True),
        ("def f(x, eps=1.0):\n    return x + 1.6 * eps\n", False),
        ("def f(x, eps=1.0):\n    return x + 0.01\n", False),
    ],
)
def test_a_tolerance_may_be_a_parameter_of_the_case(sandbox: Sandbox, program: str, passes: bool) -> None:
    solution = "def f(x, eps=1.0):\n    return eps * round(x / eps)\n"
    cases = ("f(0.3, 0.1)", "f(0.25, eps=0.001)", "f(0.6)")
    more = {"tirages": "x = reel(0, 1)", "appel": "f(x, 0.25)"}
    declared = declare("f", solution, *cases, tolerance="eps", attendus=["0.35", "0.2505", "0.8"], **more)
    assert (graded(sandbox, declared, program).points == 20) is passes
    with pytest.raises(MalformedDeclaration, match="un nombre, ou un calcul sur les paramètres, comme eps"):
        read_declaration({**declared, "verifications": [{**declared["verifications"][0], "tolerance": "delta"}]})


@pytest.mark.parametrize(
    ("text", "value"),
    [("2 ** 0.5", 2**0.5), ("-2 ** 3", -8), ("10 ** -3", 1e-3), ("[2 ** 10]", [1024]), ("1e3 ** 2", 1e6)],
)
def test_a_power_of_small_numbers_is_read(text: str, value: Any) -> None:
    assert parse_expected(text) == value


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("2 ** 65", "un million à la puissance 64"),
        ("9 ** 9 ** 9", "un million à la puissance 64"),
        ("(9 ** 9) ** 9", "un million à la puissance 64"),
        ("1e6 ** 64", "un million à la puissance 64"),
        ("0 ** -1", "un million à la puissance 64"),
        ("2 ** 1j", "un million à la puissance 64"),
        ("7 // 2", "écrivez-le avec +, -, *, / et **"),
    ],
)
def test_a_power_has_bounds(text: str, words: str) -> None:
    with pytest.raises(MalformedDeclaration, match=re.escape(words)):
        parse_expected(text)


def test_a_comparison_is_sent_to_both_fields() -> None:
    with pytest.raises(MalformedDeclaration, match=re.escape("écrivez f(2.5) comme appel, et 2.5 comme résultat")):
        parse_scenario("f(2.5) == 2.5", ["f"])


@pytest.mark.parametrize(
    ("program", "words", "passes_alone"),
    [
        (STACK.replace("def __init__(self):\n        self.t = []", "t = []"), "IndexError et depiler renvoie 3.", True),
        (STACK.replace("self.t.pop()", "self.t[-1] if self.t else 0"), "IndexError et depiler renvoie 0.", False),
        (STACK.replace("class Pile:", "class Pile:\n    vues = []").replace("t.pop()", "t.pop() if self.t else 0"),
         "IndexError et depiler renvoie 0.", False),
    ],
)  # fmt: skip
def test_a_case_that_passes_alone_is_told(sandbox: Sandbox, program: str, words: str, passes_alone: bool) -> None:
    declared = declare("Pile", STACK, "p = Pile(); p.empiler(3); p.est_vide()", "Pile().depiler()")
    message = graded(sandbox, declared, program).checks[0].message
    assert words in message
    assert ("Appelé seul, dans un programme neuf, c’est juste" in message) is passes_alone


def test_a_method_is_named_in_its_verdict(sandbox: Sandbox) -> None:
    declared = declare("Pile", STACK, "Pile().est_vide()")
    message = graded(sandbox, declared, STACK.replace("not self.t", "False")).checks[0].message
    assert message == "Pour Pile().est_vide(), on attend True et est_vide renvoie False."


NEAR = "0.9999999403953552"


@pytest.mark.parametrize(
    ("solution", "typed", "answer", "passes"),
    [
        (NEAR, "1", "1 + 9.5e-7", True),
        (NEAR, "1", "1 - 9.5e-7", True),
        (NEAR, "1", "1 - 1.02e-6", False),
        (NEAR, "", "1 + 9.5e-7", False),
        (f"[{NEAR}, 'a', True]", "[1, 'a', True]", "[1 + 9.5e-7, 'a', True]", True),
        (f"{{'x': ({NEAR},)}}", "{'x': (1,)}", "{'x': (1 + 9.5e-7,)}", True),
        (f"np.array([{NEAR}, 0.0])", "[1, 0]", "np.array([1 + 9.5e-7, 0.0])", True),
        (f"np.array([{NEAR}, 0.0])", "[1, 0]", "np.array([1 + 9.5e-7, 0.1])", False),
    ],
)
def test_the_number_that_the_author_typed_is_the_reference(
    sandbox: Sandbox, solution: str, typed: str, answer: str, passes: bool
) -> None:
    def program(text: str) -> str:
        return f"import numpy as np\ndef f(x):\n    return {text}\n"

    declared = declare("f", program(solution), "f(1)", attendus=[typed], tolerance=1e-6)
    assert graded(sandbox, declared, program(solution)).points == 20, "the solution itself"
    verdict = graded(sandbox, declared, program(answer))
    assert (verdict.points == 20) is passes
    if typed == "1" and not passes:
        assert verdict.checks[0].message == "Pour f(1), on attend 1 et f renvoie 0.999999."


def test_drawn_words_are_those_of_the_examples_mixed() -> None:
    rng = np.random.default_rng(2)
    for text in ("x = mots('le chat dort', 2, 6)", "x = mots('kayak', 1, 1)", "x = mots('a b', 0, 4, espaces=True)"):
        draws = parse_draws(text)
        drawn = [draws.draw(rng) for _ in range(40)]
        assert all(map(draws.allows, drawn))
        texts = [str(each["x"]) for each in drawn]
        assert len(set(texts)) > 5, texts
        assert any("  " in each for each in texts) is ("espaces" in text)
        simpler = [
            str(each["x"]) for each in draws.iter_simpler_variables(max(drawn, key=lambda each: len(str(each["x"]))))
        ]
        assert simpler
        assert min(map(len, simpler)) < max(map(len, texts))
    assert any(len(each.split()) > len(set(each.split())) for each in texts), "words are drawn again"
