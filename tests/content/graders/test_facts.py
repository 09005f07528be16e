"""Facts that are told with or without a name: they are read in the failed checks and in the file."""

from __future__ import annotations

import pytest

from graders.core.code.facts import MODIFIED_ARGUMENT, Fact, find_facts, is_stated_in_titles
from graders.core.compare.slips import SLIPS
from graders.core.contract.findings import Finding
from graders.core.contract.local import LOCAL
from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult
from tests.support.shipped import CODE

GAIN, COHERENCE = "l19/gain", "l19/coherence"


GAIN_RIGHT = """
import numpy as np

def gain(v, r):
    return v / (v + r)

def fusionner(mesures, variances):
    poids = 1 / variances
    m, v = np.sum(poids * mesures) / np.sum(poids), 1 / np.sum(poids)
    return m, v

def enchainer(m, v, mesures, variances):
    lignes = np.zeros((len(mesures), 2))
    for i in range(len(mesures)):
        K = gain(v, variances[i])
        m, v = m + K * (mesures[i] - m), (1 - K) * v
        lignes[i] = m, v
    return lignes
"""


@pytest.mark.parametrize(
    ("old", "new", "identity", "title"),
    [
        ("    return m, v\n", "    print(m, v)\n", "sans_retour", "fusionner ne renvoie rien"),
        (
            "    return m, v\n",
            "    if len(mesures) < 3:\n        return m, v\n",
            "sans_retour",
            "fusionner ne renvoie rien dans certains cas",
        ),
        ("len(mesures), 2)", "len(mesures), 2), np.float32", "simple_precision", "Un calcul en simple précision"),
        ("(v + r)", "(v + r + 1e-6)", "precision_perdue", "Des résultats justes à quelques chiffres près seulement"),
        (
            "    poids = 1 / variances\n",
            "    variances /= 1\n    mesures += 1\n    mesures -= 1\n    variances[0] += 1\n    variances[0] -= 1\n"
            "    poids = 1 / variances\n    variances *= 2\n",
            "argument_modifie",
            "Un argument modifié sur place",
        ),
    ],
)
def test_a_fact_is_told_without_a_name(old: str, new: str, identity: str, title: str) -> None:
    assert old in GAIN_RIGHT
    grader = CODE[GAIN]
    found = grader.grade(GAIN_RIGHT.replace(old, new).encode(), LOCAL, seed=3, version="v").verdict.diagnosis
    assert found is not None
    assert found.id == identity
    assert found.title == title


@pytest.mark.parametrize(
    ("defined", "message", "cause", "identity"),
    [
        ("niveau", "Il manque à l’appel de bande\u00a0: niveau. [TypeError]", Outcome.RUNTIME_ERROR, "defaut_manquant"),
        ("niveau", "Il manque à l’appel de bande : N. [TypeError]", Outcome.RUNTIME_ERROR, None),
        ("niveau=0.9", "Faux.", Outcome.WRONG_ANSWER, "defaut_different"),
        ("niveau=19 / 20", "Faux.", Outcome.WRONG_ANSWER, None),
        ("niveau=None", "Faux.", Outcome.WRONG_ANSWER, None),
        ("niveau=0.950", "Faux.", Outcome.WRONG_ANSWER, None),
    ],
)
def test_a_default_value_is_told(defined: str, message: str, cause: Outcome, identity: str | None) -> None:
    check = next(check for check in CODE[COHERENCE].checks if check.functions == ("bande",))
    finding = Finding(CheckResult(check.id, check.title, False, 0, check.points, message), cause)
    source = f"def bande(n, N, {defined}):\n    return 0, 1\n".encode()
    facts = find_facts([(check, finding)], source, CODE[COHERENCE].solution, ())
    assert [fact.slip.id for fact in facts] == ([identity] if identity else [])
    assert all(fact.checks == (check.id,) for fact in facts)
    told = ["La valeur par défaut de niveau manque"]
    assert not find_facts([(check, finding)], source, CODE[COHERENCE].solution, told)


def test_a_right_program_has_no_facts() -> None:
    verdict = CODE[GAIN].grade(GAIN_RIGHT.encode(), LOCAL, seed=3, version="v").verdict
    assert (verdict.points, verdict.diagnosis) == (20, None)


def test_a_name_tells_what_it_leaves_unexplained() -> None:
    """An inverted weight in one function, and an error of execution in another one."""
    source = GAIN_RIGHT.replace("poids = 1 / variances", "poids = variances").replace(
        "lignes[i] = m, v", "lignes[i] = m"
    )
    found = CODE[GAIN].grade(source.replace("K = gain", "K = 0.3 * gain").encode(), LOCAL, seed=3, version="v").verdict
    assert found.diagnosis is not None
    assert "qui échoue" in found.diagnosis.explanation
    explained = {check for checks in found.diagnosis.explains for check in checks}
    assert explained
    assert explained < {check.id for check in found.checks if not check.passed}


def test_a_memory_with_an_incomplete_key_is_told() -> None:
    """The first call, repeated last, gets the same answer; the same calls in reverse order do not."""
    source = """
deja = {}

def predire(m, v, u, q):
    return m + u, v + q

def corriger(m, v, z, r):
    cle = r > 1
    if cle not in deja:
        K = v / (v + r)
        deja[cle] = m + K * (z - m), (1 - K) * v
    return deja[cle]
"""
    found = CODE["l19/predire_corriger"].grade(source.encode(), LOCAL, seed=3, version="v").verdict.diagnosis
    assert found is not None
    assert found.id == "memoire"


def test_what_calls_a_named_function_is_not_said_to_be_unexplained() -> None:
    source = CODE[COHERENCE].solution
    assert "np.linalg.inv(P)" in source or "solve" in source
    wrong = (
        source.replace("def nees(", "def juste(")
        + "\n\ndef nees(vraie, estimee, P):\n    return 2 * juste(vraie, estimee, P)\n"
    )
    found = CODE[COHERENCE].grade(wrong.encode(), LOCAL, seed=3, version="v").verdict.diagnosis
    assert found is None or "qui échoue" not in found.explanation


@pytest.mark.parametrize(("title", "told"), [("Les tableaux reçus sont modifiés", True), ("Un signe est faux", False)])
def test_a_title_may_say_what_a_fact_does(title: str, told: bool) -> None:
    assert is_stated_in_titles(Fact(SLIPS[MODIFIED_ARGUMENT], ("arguments",)), iter([title])) == told
