"""What is promised of `predire` and `corriger` with matrices."""

from __future__ import annotations

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.compound_forms import TupleForm
from graders.core.compare.forms import array

STATE = TupleForm(parts={"état": array("n"), "covariance": array("n", "n")})
CONTRACTS = (
    FunctionContract(
        "predire",
        {"x": array("n"), "P": array("n", "n"), "F": array("n", "n"), "Q": array("n", "n")},
        STATE,
        (
            Boundary("un état d’un seul nombre : (1,) et (1, 1)", lambda x, P, F, Q: len(x) == 1),
            Boundary("Q = 0", lambda x, P, F, Q: not Q.any()),
        ),
    ),
    FunctionContract(
        "corriger",
        {"x": array("n"), "P": array("n", "n"), "z": array("m"), "H": array("m", "n"), "R": array("m", "m")},
        STATE,
        (
            Boundary("un état d’un seul nombre : (1,) et (1, 1)", lambda x, P, z, H, R: len(x) == 1),
            Boundary("une mesure d’un seul nombre : z (1,), R (1, 1)", lambda x, P, z, H, R: len(z) == 1),
            Boundary("plus de mesures que d’états", lambda x, P, z, H, R: len(z) > len(x)),
            Boundary(
                "ce que vos fonctions renvoient, redonné à l’appel suivant",
                free="toujours en tableaux, même si vous renvoyez des listes",
            ),
        ),
    ),
)
