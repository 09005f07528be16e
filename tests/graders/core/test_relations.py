"""What is told of two arrays that differ: one property or relation, which holds, or nothing."""

from __future__ import annotations

import numpy as np
import pytest

from graders.core.compare.comparison import CloseTo
from graders.core.compare.relations import tell_relation

ROW = np.array([1.5, -2.0, 4.0, 0.5])
COVARIANCE = np.array([[2.0, 0.5, 0.1], [0.5, 1.0, 0.2], [0.1, 0.2, 3.0]])
LEANING = COVARIANCE + np.array([[0.0, 0.3, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
NEGATIVE = COVARIANCE - np.diag([0.0, 2.0, 0.0])
THIRD_COLUMN = np.arange(12.0).reshape(3, 4) ** 2 + np.array([0.0, 0.0, 1.3, 0.0]) * [[1.0], [2.0], [5.0]]


@pytest.mark.parametrize(
    ("expected", "got", "told"),
    [
        (ROW, 2.0 * ROW, "le double"),
        (ROW, ROW / 3.0, "partout 0,33333 fois"),
        (ROW, ROW**2, "le carré"),
        (np.abs(ROW), np.sqrt(np.abs(ROW)), "la racine carrée"),
        (np.array(16.0), np.array(4.0), ""),
        (np.array([2.0, 2.0, 2.0]), np.array([4.0, 4.0, 4.0]), ""),
        (ROW, ROW - 0.25, "le même partout : 0,25 de moins"),
        (ROW, ROW[::-1], "ordre inverse"),
        (ROW, np.roll(ROW, 1), "décalées de 1 rang."),
        (ROW, ROW[[1, 0, 2, 3]], "à d’autres places"),
        (COVARIANCE, LEANING, "symétrique, le vôtre non : (0, 1) vaut 0,8 et (1, 0) 0,5"),
        (COVARIANCE, NEGATIVE, "valeur propre négative"),
        (np.arange(12.0).reshape(3, 4) ** 2, THIRD_COLUMN, "3 valeurs sur 12 sont fausses, toutes dans la colonne 2"),
        (ROW, ROW + np.array([0.0, 0.0, 0.0, 0.7]), "Une valeur sur 4 est fausse."),
        (ROW, np.array([0.3, 8.0, -1.0, 2.0]), ""),
        (ROW, ROW * np.nan, ""),
        (np.array(1.0), np.array(1.7), ""),
        (np.array(0.5), np.array(0.5 - 2.0 * np.pi), "L’écart est de 2π, un tour entier."),
        (np.array([0.0, 0.0, 2.0]), np.array([0.0, 0.0, 2.0 - 2.0 * np.pi]), "un tour entier, partout où c’est faux"),
        (np.array([0.0, -1.0, 1.0]), np.array([0.0, 4.0 * np.pi - 1.0, 1.0]), "un nombre entier de tours"),
        (np.zeros(3), np.array([1.0, 2.0, 3.0]), ""),
    ],
)
def test_one_fact_is_told(expected: np.ndarray, got: np.ndarray, told: str) -> None:
    found = tell_relation(expected, got)
    assert told in found if told else not found


def test_comparators_tell_it_after_the_largest_gap() -> None:
    mismatch = CloseTo()(ROW, (2.0 * ROW).tolist())
    assert mismatch is not None
    assert mismatch.message.endswith("C’est le double de ce qui est attendu, partout.")
