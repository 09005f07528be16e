"""What is promised of `icp`."""

from __future__ import annotations

import numpy as np

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.compound_forms import TupleForm
from graders.core.compare.forms import WHOLE, ArrayForm, array, power_text
from graders.l20.icp.judge import TOLERANCE

CONTRACTS = (
    FunctionContract(
        "icp",
        {"P": array("n", 2), "Q": array("m", 2), "R0": array(2, 2), "t0": array(2), "n_iter": WHOLE},
        TupleForm(
            parts={
                "R": array(2, 2),
                "t": array(2),
                "erreurs": ArrayForm(shape=("k",), called="une suite de nombres"),
            },
            precision=f"R, t et chaque erreur à {power_text(TOLERANCE)} près.",
        ),
        (
            Boundary("une seule itération", lambda P, Q, R0, t0, n=30: n == 1),
            Boundary("n_iter omis", lambda *args: len(args) == 4),
            Boundary("un départ autre que l’identité", lambda P, Q, R0, t0, *n: bool(np.any(np.eye(2) != R0))),
            Boundary("des nuages de tailles différentes", lambda P, Q, *r: len(P) != len(Q)),
            Boundary("un point à égale distance de deux autres", free="il n’y en a jamais"),
            Boundary("la longueur k de la suite", free="de 1 à n_iter + 1, avec ou sans l’erreur du départ"),
            Boundary("un arrêt avant n_iter", free="quand les paires, R et t, ou E ne changent plus"),
        ),
    ),
)
