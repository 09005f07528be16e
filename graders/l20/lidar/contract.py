"""What is promised of `lancer_rayon`."""

from __future__ import annotations

import math

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.forms import GRID, NUMBER, NumberForm
from graders.l20.lidar.cases import Grid, distance


def reads_the_range(libres: Grid, x: float, y: float, angle: float, portee: float) -> bool:
    """Whether no wall is met within the range."""
    return distance(libres, x, y, angle, portee) == portee


def stops_beside_a_corner(libres: Grid, x: float, y: float, angle: float, portee: float) -> bool:
    """Whether the ray goes through less than a tenth of a cell of wall, or of a free cell: a corner that is cut."""
    near = distance(libres, x, y, angle, portee)
    ahead = [near + 0.01 * k for k in range(1, 40)]
    places = [(math.floor(y + d * math.sin(angle)), math.floor(x + d * math.cos(angle))) for d in ahead]
    height, width = libres.shape
    inside = [(r, c) for r, c in places if 0 <= r < height and 0 <= c < width]
    return near < portee and any(libres[cell] for cell in inside)


CONTRACTS = (
    FunctionContract(
        "lancer_rayon",
        {"libres": GRID, "x": NUMBER, "y": NUMBER, "angle": NUMBER, "portee_max": NUMBER},
        NumberForm(
            precision="À 0,1 case près, dans l’absolu (un pas de marche de 0,1 suffit, arrondi compris), et jamais "
            "plus que portee_max."
        ),
        (
            Boundary("rien dans la portée : la portée elle-même", reads_the_range),
            Boundary("la direction exacte d’un axe", lambda g, x, y, a, p: a in (0.0, math.pi / 2, -math.pi / 2)),
            Boundary("un angle de π, un angle de −π", lambda g, x, y, a, p: a == -math.pi),
            Boundary("un coin de mur coupé de peu", stops_beside_a_corner),
            Boundary("une carte sans murs au bord", lambda g, x, y, a, p: bool(g[0].any())),
            Boundary("un rayon qui passe à moins de 0,06 case d’un coin", free="il n’est pas demandé"),
            Boundary(
                "un départ dans un mur, ou à moins de 0,06 case d’une ligne de la grille", free="il n’est pas demandé"
            ),
        ),
    ),
)
