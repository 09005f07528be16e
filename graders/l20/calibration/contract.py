"""What is promised of `avance`, `etalonner` and `corriger`."""

from __future__ import annotations

import numpy as np

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.forms import NUMBER, ArrayForm, array
from graders.l20.calibration.cases import right_ways
from graders.l20.calibration.judge import NAMES

STEPS = array("n", 3)

CONTRACTS = (
    FunctionContract(
        "avance",
        {"pas": STEPS},
        array("n"),
        (
            Boundary("un seul pas", lambda pas: len(pas) == 1),
            Boundary("en marche arrière", lambda pas: right_ways(pas)[0] < 0.0),
            Boundary("sur place", lambda pas: not pas[:, :2].any()),
        ),
    ),
    FunctionContract(
        "etalonner",
        {"pas": STEPS, "vrais": STEPS},
        ArrayForm(shape=(3,), called="trois nombres", names=NAMES),
        (
            Boundary("rien à corriger", np.array_equal),
            Boundary("trois pas", lambda pas, vrais: len(pas) == 3),
            Boundary("des pas qui ne distinguent pas α de β", free="cela n’arrive pas"),
        ),
    ),
    FunctionContract(
        "corriger",
        {"pas": STEPS, "gamma": NUMBER, "beta": NUMBER, "alpha": NUMBER},
        STEPS,
        (
            Boundary("un seul pas", lambda pas, *constants: len(pas) == 1),
            Boundary("rien à corriger", lambda pas, *constants: constants == (1.0, 1.0, 0.0)),
            Boundary("sur place", lambda pas, *constants: not pas[:, :2].any()),
            Boundary("un virage d’un demi-tour", free="aucun n’y arrive, même corrigé"),
        ),
    ),
)
