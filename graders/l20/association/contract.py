"""What is promised of `distances2`, `associer`, `nouveaux` and `associer_ensemble`."""

from __future__ import annotations

import numpy as np

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.forms import NUMBER, IndicesForm, array
from graders.l20.association.cases import right_joint, right_nearest, right_new

SCAN = {"z": array("m", 2), "amers": array("l", 2), "S": array("l", 2, 2)}
NUMBERS = IndicesForm(called="m entiers, le numéro d’un amer ou −1", may_be_empty=False)
NO_TIE = Boundary("une distance au seuil, ou deux distances égales", free="cela n’arrive pas")

CONTRACTS = (
    FunctionContract(
        "distances2",
        SCAN,
        array("m", "l"),
        (
            Boundary("une seule mesure", lambda z, amers, S: len(z) == 1),
            Boundary("un seul amer", lambda z, amers, S: len(amers) == 1),
        ),
    ),
    FunctionContract(
        "associer",
        {**SCAN, "niveau": NUMBER},
        NUMBERS,
        (
            Boundary("un seul amer, plusieurs mesures", lambda z, amers, *rest: len(amers) == 1 < len(z)),
            Boundary("rien dans aucune porte", lambda *args: set(right_nearest(*args)) == {-1}),
            Boundary("niveau omis", lambda *args: len(args) == 3),
            NO_TIE,
        ),
    ),
    FunctionContract(
        "nouveaux",
        {**SCAN, "niveau": NUMBER},
        IndicesForm(called="des entiers croissants"),
        (
            Boundary("aucune mesure nouvelle", lambda *args: not right_new(*args)),
            Boundary("toutes nouvelles", lambda *args: len(right_new(*args)) == len(args[0])),
            Boundary("niveau omis", lambda *args: len(args) == 3),
            NO_TIE,
        ),
    ),
    FunctionContract(
        "associer_ensemble",
        {"z": array("m", 2), "amers": array("l", 2), "C": array("2l", "2l"), "R": array(2, 2), "niveau": NUMBER},
        NUMBERS,
        (
            Boundary("une seule mesure", lambda z, *rest: len(z) == 1),
            Boundary("aucune hypothèse compatible", lambda *args: set(right_joint(*args)) == {-1}),
            Boundary("une mesure de trop", lambda *args: len(args[0]) > 1 and -1 in right_joint(*args)),
            Boundary("C = 0", lambda z, amers, C, R, *niveau: not np.any(C)),
            Boundary("niveau omis", lambda *args: len(args) == 4),
            NO_TIE,
        ),
    ),
)
