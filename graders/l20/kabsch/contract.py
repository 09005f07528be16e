"""What is promised of `kabsch`."""

from __future__ import annotations

import numpy as np

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.compound_forms import TupleForm
from graders.core.compare.forms import array, power_text
from graders.core.contract.values import Floats
from graders.l20.kabsch.judge import ORTHONORMAL


def same_points(P: Floats, Q: Floats) -> bool:
    return len(P) > 1 and bool((np.ptp(P, axis=0) == 0.0).all())


def on_a_line(P: Floats, Q: Floats) -> bool:
    return len(P) > 2 and bool(np.linalg.matrix_rank(P - P.mean(axis=0)) == 1)


def flat(P: Floats, Q: Floats) -> bool:
    return P.shape[1] == 3 and bool(np.linalg.matrix_rank(P - P.mean(axis=0)) == 2)


def mirrored(P: Floats, Q: Floats) -> bool:
    return float(np.linalg.det((P - P.mean(axis=0)).T @ (Q - Q.mean(axis=0)))) < -1e-6


CONTRACTS = (
    FunctionContract(
        "kabsch",
        {"P": array("n", "d"), "Q": array("n", "d")},
        TupleForm(
            parts={"R": array("d", "d"), "t": array("d")},
            precision="Jugé par la somme des carrés, minimale à 10⁻⁷ près, en proportion, et "
            f"RᵀR = I à {power_text(ORTHONORMAL)} près (un calcul en float32 ne suffit pas).",
        ),
        (
            Boundary("un seul point", lambda P, Q: len(P) == 1),
            Boundary("des points confondus", same_points),
            Boundary("des points alignés", on_a_line),
            Boundary("dans l’espace, des points d’un même plan", flat),
            Boundary("un nuage retourné comme dans un miroir", mirrored),
            Boundary("plusieurs rotations aussi bonnes", free="n’importe laquelle"),
        ),
    ),
)
