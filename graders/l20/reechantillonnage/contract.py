"""What is promised of `n_eff` and `reechantillonner_systematique`."""

from __future__ import annotations

import numpy as np

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.forms import NUMBER, ArrayForm, array

CONTRACTS = (
    FunctionContract(
        "n_eff",
        {"poids": array("N")},
        NUMBER,
        (
            Boundary("des poids tous égaux", lambda poids: len(poids) > 1 and np.ptp(poids) == 0.0),
            Boundary("un seul poids non nul", lambda poids: len(poids) > 1 and poids.max() == 1.0),
            Boundary("une seule particule", lambda poids: len(poids) == 1),
            Boundary("des poids dont la somme n’est pas 1", free="ils ne sont pas donnés"),
        ),
    ),
    FunctionContract(
        "reechantillonner_systematique",
        {"particules": array("N", "d"), "poids": array("N")},
        ArrayForm(
            shape=("N", "d"),
            precision="Chaque ligne est la copie exacte d’une ligne reçue (float32 accepté), dans un ordre quelconque.",
        ),
        (
            Boundary("des poids tous égaux", lambda p, poids: len(poids) > 1 and np.ptp(poids) == 0.0),
            Boundary("un seul poids non nul", lambda p, poids: len(poids) > 1 and poids.max() == 1.0),
            Boundary("des poids nuls, au début et à la fin", lambda p, poids: poids[0] == 0.0),
            Boundary("une seule particule", lambda p, poids: len(poids) == 1),
            Boundary("le générateur", free="`rng`, un autre de numpy ou le module random : seules les copies comptent"),
        ),
    ),
)
