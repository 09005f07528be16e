"""What is promised of `ate` and `rpe`."""

from __future__ import annotations

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.forms import NUMBER, WHOLE, poses
from graders.l20.metriques.cases import turns_over

CONTRACTS = (
    FunctionContract(
        "ate",
        {"estimees": poses(), "verite": poses()},
        NUMBER,
        (
            Boundary("une trajectoire en miroir", turns_over),
            Boundary("un alignement parfait, dont l’ATE est nulle", free="il n’est pas demandé"),
            Boundary("des trajectoires droites, ou réduites à un point", free="elles ne sont pas demandées"),
            Boundary(
                "un carré ou un cercle et son image en miroir, que toute rotation aligne aussi bien",
                free="ils ne sont pas demandés",
            ),
        ),
    ),
    FunctionContract(
        "rpe",
        {"estimees": poses(), "verite": poses(), "delta": WHOLE},
        NUMBER,
        (
            Boundary("delta = 1", lambda e, v, delta: delta == 1),
            Boundary("delta = n − 1 : une seule paire", lambda e, v, delta: delta == len(e) - 1 > 1),
            Boundary("delta = n ou plus", free="il n’est pas demandé"),
        ),
    ),
)
