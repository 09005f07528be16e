"""What is promised of `residu`, `jacobiennes` and `contribution`."""

from __future__ import annotations

import numpy as np

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.comparison import TOLERANCE
from graders.core.compare.compound_forms import TupleForm
from graders.core.compare.forms import POSE, ArrayForm, array
from graders.l20.jacobienne_arete.judge import DERIVATIVE, PRODUCT

EDGE = {"xi": POSE, "xj": POSE, "z": POSE}
CONTRACTS = (
    FunctionContract(
        "residu",
        EDGE,
        ArrayForm(shape=(3,), called="trois nombres", angle=2, tolerance=TOLERANCE),
        (Boundary("des caps de part et d’autre de ±π", lambda xi, xj, z: abs(xj[2] - xi[2] - z[2]) > np.pi),),
    ),
    FunctionContract(
        "jacobiennes",
        EDGE,
        TupleForm(
            parts={
                "A": ArrayForm(shape=(3, 3), tolerance=DERIVATIVE),
                "B": ArrayForm(shape=(3, 3), tolerance=DERIVATIVE),
            }
        ),
        (Boundary("la méthode", free="à la main, ou par différences finies d’un pas de 10⁻⁶"),),
    ),
    FunctionContract(
        "contribution",
        {**EDGE, "omega": array(3, 3)},
        TupleForm(
            parts={"H": ArrayForm(shape=(6, 6), tolerance=PRODUCT), "b": ArrayForm(shape=(6,), tolerance=PRODUCT)}
        ),
    ),
)
