"""What is promised of `dimension_noyau` and `gauss_newton_robuste`."""

from __future__ import annotations

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.compound_forms import TupleForm
from graders.core.compare.forms import NUMBER, WHOLE, ArrayForm, poses
from graders.l20.defi_robuste.kernel import expected
from graders.l20.slam_graphe.contract import EDGES

CONTRACTS = (
    FunctionContract(
        "dimension_noyau",
        {"poses": poses(), "aretes": EDGES},
        WHOLE,
        (
            Boundary("un seul morceau", lambda p, a: expected(p, a) == 3),
            Boundary("deux morceaux", lambda p, a: expected(p, a) == 6),
            Boundary("trois morceaux", lambda p, a: expected(p, a) == 9),
            Boundary("une pose qu’aucune arête ne touche", free="elle n’est pas demandée"),
        ),
    ),
    FunctionContract(
        "gauss_newton_robuste",
        {"poses": poses(), "aretes": EDGES, "delta": NUMBER, "n_iter": WHOLE},
        TupleForm(
            parts={"poses": poses(), "poids": ArrayForm(shape=("m",))},
            precision="Jugé par l’écart à la vérité (moins de 0,4 fois celui des moindres carrés) et par les poids des "
            "fausses arêtes (moins de 0,1) ; un poids sort de [0, 1] à partir de 10⁻⁶. Les poids peuvent être une "
            "colonne (m, 1) ou une ligne (1, m).",
        ),
        (
            Boundary("les poids renvoyés", free="ceux du dernier tour, ou recalculés aux poses renvoyées"),
            Boundary("un cap de la première pose hors de ]−π, π]", free="il n’est pas donné"),
            Boundary("moins de n_iter tours", free="on peut s’arrêter quand plus rien ne bouge"),
            Boundary("la fonction de poids", free="celle que vous voulez, pourvu que delta serve d’échelle"),
            Boundary(
                "des poids calculés une seule fois, au départ", free="ils conviennent : seul le résultat est jugé"
            ),
        ),
    ),
)
