"""Facts that are told with or without a name: they are read in the failed checks and in the file."""

from __future__ import annotations

import pytest

from graders.core.code.grading import CodeGrader
from graders.core.contract.local import LOCAL
from graders.core.contract.verdict import Diagnosis
from tests.support.shipped import CODE

GAIN, COHERENCE, BOUCLES = "l19/gain", "l19/coherence", "l20/boucles"


def diagnosed(exercise: str, *changes: tuple[str, str]) -> Diagnosis | None:
    """Return the diagnosis of the solution with these changes."""
    grader = CODE[exercise]
    assert isinstance(grader, CodeGrader)
    source = grader.solution
    for old, new in changes:
        assert old in source
        source = source.replace(old, new)
    return grader.grade(source.encode(), LOCAL, seed=3, version="v").verdict.diagnosis


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
    assert "points perdus. Rest" in found.diagnosis.explanation
    explained = {check for checks in found.diagnosis.explains for check in checks}
    assert explained
    assert explained < {check.id for check in found.checks if not check.passed}
