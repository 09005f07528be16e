"""What is promised of `erreur` and `gauss_newton`."""

from __future__ import annotations

import math

import numpy as np

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.comparison import TOLERANCE
from graders.core.compare.compound_forms import OtherForm
from graders.core.compare.forms import POSE, WHOLE, ArrayForm, poses, power_text
from graders.core.contract.values import Value
from graders.l20.slam_graphe.optimum import POSE_TOLERANCE


def is_edge(value: Value) -> bool:
    """Whether it is (i, j, z, omega): two whole numbers, a pose, a matrix."""
    i, j, z, omega = value
    return type(i) is type(j) is int and z.shape == (3,) and omega.shape == (3, 3)


EDGES = OtherForm(
    told="une liste de quadruplets (i, j, z, omega) : deux entiers, une pose (3,), une matrice (3, 3)",
    given=lambda value: type(value) is list and all(map(is_edge, value)),
)


def has_pair_twice(poses_: Value, aretes: Value, *rest: Value) -> bool:
    pairs = [frozenset(edge[:2]) for edge in aretes]
    return len(set(pairs)) < len(pairs)


CONTRACTS = (
    FunctionContract(
        "erreur",
        {"xi": POSE, "xj": POSE, "z": POSE},
        ArrayForm(shape=(3,), called="trois nombres", angle=2, tolerance=TOLERANCE),
        (
            Boundary("deux poses d’accord avec la mesure", lambda xi, xj, z: np.array_equal(xj, z) and not xi.any()),
            Boundary("des caps de part et d’autre de ±π", lambda xi, xj, z: abs(xj[2] - xi[2]) > math.pi),
            Boundary("la convention", free="relatif(z, relatif(xi, xj)), ou la différence des composantes"),
        ),
    ),
    FunctionContract(
        "gauss_newton",
        {"poses": poses(), "aretes": EDGES, "n_iter": WHOLE},
        ArrayForm(
            shape=("n", 3),
            called="des poses",
            angle=2,
            precision=f"À {power_text(POSE_TOLERANCE)} près du minimum, dans l’absolu : peu importe le chemin.",
        ),
        (
            Boundary("deux poses, une seule arête", lambda p, a, *n: len(p) == 2 and len(a) == 1),
            Boundary("une même paire mesurée plusieurs fois", has_pair_twice),
            Boundary("une arête à rebours, (j, i)", lambda p, a, *n: any(i > j for i, j, _, _ in a)),
            Boundary("n_iter omis", lambda *args: len(args) == 2),
            Boundary("n_iter inférieur à 10", free="il n’est pas donné"),
            Boundary("un départ déjà au minimum", lambda p, a, *n: len(a) == 2 and np.array_equal(p[1], a[0][2])),
            Boundary("un cap de la première pose hors de ]−π, π]", free="il n’est pas donné"),
            Boundary("un graphe en plusieurs morceaux", free="il n’est pas demandé"),
        ),
    ),
)
