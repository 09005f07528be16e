"""What is promised of `nees`, `bande` and `coherence`."""

from __future__ import annotations

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.compound_forms import TupleForm
from graders.core.compare.forms import NUMBER, WHOLE, NumberForm, WholeNumberForm, array

CONTRACTS = (
    FunctionContract(
        "nees",
        {"vraie": array("n"), "estimee": array("n"), "P": array("n", "n")},
        NUMBER,
        (Boundary("un état d’un seul nombre : (1,) et (1, 1)", lambda vraie, estimee, P: len(vraie) == 1),),
    ),
    FunctionContract(
        "bande",
        {"n": WHOLE, "N": WHOLE, "niveau": NUMBER},
        TupleForm(parts={"bas": NumberForm(), "haut": NumberForm()}),
        (
            Boundary("un seul essai", lambda n, N, *niveau: N == 1),
            Boundary("niveau omis", lambda *args: len(args) == 2),
        ),
    ),
    FunctionContract(
        "coherence",
        {"vraies": array("N", "n"), "estimees": array("N", "n"), "covariances": array("N", "n", "n")},
        TupleForm(parts={"NEES moyen": NumberForm(), "avis": WholeNumberForm(called="un entier : 1, 0 ou −1")}),
        (
            Boundary("un état d’un seul nombre", lambda vraies, estimees, covariances: vraies.shape[1] == 1),
            Boundary("une moyenne au bout de la bande", free="elle en reste à plus de 1 %"),
            Boundary("le type de l’avis", free="1, 1.0 ou True ; 0, 0.0 ou False"),
        ),
    ),
)
