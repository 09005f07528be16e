"""Programs as a student would write them: other words, the same answers."""

from __future__ import annotations

import ast

import numpy as np
import pytest

from graders.core.code.hunts import list_hunts
from graders.core.code.student_form import rewrite_as_student_form
from graders.core.contract.local import LOCAL
from graders.core.contract.program import KitSettings
from graders.discovery import load_definition

KIT = KitSettings("l20", {"seed": 1})
TRICKY = '''
import math


def aide(x):
    """À ne pas montrer."""
    total = 0
    for x in range(3):
        total += x
    return total


def aide(valeur):
    """La seconde définition compte."""
    somme = 0.0
    for element in valeur:
        carre, somme = element * element, somme + element
        somme += carre
    return somme


def inutile(n):
    return n


def repondre(valeurs, echelle=2.0):
    a, b = aide(valeurs), math.pi
    a, b = b, a
    interieur = lambda t: t * a
    carres = [v * v for v in valeurs]
    return interieur(b) + sum(carres) * echelle, [c for c in carres if c > a]
'''


@pytest.mark.parametrize("seed", range(6))
def test_another_form_answers_alike(seed: int) -> None:
    form = rewrite_as_student_form(TRICKY, "repondre", seed)
    ast.parse(form)
    assert "inutile" not in form
    assert "À ne pas montrer" not in form
    assert "La seconde" not in form
    programs = [LOCAL.open(source.encode(), KIT) for source in (TRICKY, form)]
    answers = [program.call("repondre", [1.0, 2.5, -3.0]).value for program in programs]
    assert answers[0] == answers[1]


def test_a_form_depends_on_the_seed_alone() -> None:
    forms = {rewrite_as_student_form(TRICKY, "repondre", seed) for seed in range(8)}
    assert len(forms) > 2
    assert rewrite_as_student_form(TRICKY, "repondre", 3) == rewrite_as_student_form(TRICKY, "repondre", 3)


def test_public_functions_keep_their_names() -> None:
    definition = load_definition("l20/poses")
    hunt = next(hunt for hunt in list_hunts(definition) if hunt.misconception.id == "relatif_a_l_envers")  # type: ignore[arg-type]
    form = hunt.wrong_program_source(5, ("composer", "inverse", "relatif"))
    defined = {node.name for node in ast.parse(form).body if isinstance(node, ast.FunctionDef)}
    assert {"relatif", "composer", "inverse"} <= defined
    np.testing.assert_allclose(
        LOCAL.open(form.encode(), KIT).call("relatif", np.zeros(3), np.array([1.0, 0, 0])).value,
        LOCAL.open(hunt.source.encode(), KIT).call("relatif", np.zeros(3), np.array([1.0, 0, 0])).value,
    )
