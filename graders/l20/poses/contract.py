"""What is promised of `composer`, `inverse` and `relatif`."""

from __future__ import annotations

import math

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.forms import POSE
from graders.core.contract.values import Floats


def adds_up_to(a: Floats, b: Floats, turn: float) -> bool:
    """Whether the angles of two poses add up to this angle or its opposite."""
    return math.isclose(abs(a[2] + b[2]), turn)


def is_still(a: Floats, b: Floats) -> bool:
    """Whether two poses are the same."""
    return bool((a == b).all())


CONTRACTS = (
    FunctionContract(
        "composer",
        {"a": POSE, "b": POSE},
        POSE,
        (
            Boundary("des caps dont la somme fait un demi-tour exact", lambda a, b: adds_up_to(a, b, math.pi)),
            Boundary("des caps dont la somme fait un tour complet", lambda a, b: adds_up_to(a, b, math.tau)),
            Boundary("l’une des deux poses nulle", lambda a, b: not a.any()),
        ),
    ),
    FunctionContract(
        "inverse",
        {"a": POSE},
        POSE,
        (
            Boundary("un demi-tour exact", lambda a: math.isclose(abs(a[2]), math.pi)),
            Boundary("la pose nulle", lambda a: not a.any()),
        ),
    ),
    FunctionContract(
        "relatif",
        {"a": POSE, "b": POSE},
        POSE,
        (
            Boundary("deux poses confondues", is_still),
            Boundary("des caps opposés, à un demi-tour l’un de l’autre", lambda a, b: adds_up_to(a, -b, math.pi)),
            Boundary("des caps de part et d’autre de ±π", lambda a, b: abs(b[2] - a[2]) > math.pi + 0.1),
        ),
    ),
)
