"""What is promised of `odometrie` and `sigma_dtheta`."""

from __future__ import annotations

import math

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.forms import NUMBER, POSE

CONTRACTS = (
    FunctionContract(
        "odometrie",
        {"pose": POSE, "ds_g": NUMBER, "ds_d": NUMBER, "L": NUMBER},
        POSE,
        (
            Boundary("les deux roues de même longueur : tout droit", lambda pose, g, d, L: g == d != 0.0),
            Boundary("les roues opposées : sur place", lambda pose, g, d, L: g == -d != 0.0),
            Boundary("aucune roue ne tourne", lambda pose, g, d, L: g == d == 0.0),
            Boundary("en marche arrière", lambda pose, g, d, L: g < 0.0 and d < 0.0),
            Boundary("un cap de départ de ±π", lambda pose, g, d, L: math.isclose(abs(pose[2]), math.pi)),
            Boundary("un pas qui tourne d’un demi-tour ou plus", free="il n’est pas demandé"),
        ),
    ),
    FunctionContract(
        "sigma_dtheta",
        {"sigma_g": NUMBER, "sigma_d": NUMBER, "L": NUMBER},
        NUMBER,
        (
            Boundary("un écart-type nul", lambda g, d, L: g == 0.0 or d == 0.0),
            Boundary("deux écarts-types égaux", lambda g, d, L: g == d),
        ),
    ),
)
