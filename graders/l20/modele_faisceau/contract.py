"""What is promised of `log_vraisemblance` and `champ_distance`."""

from __future__ import annotations

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.comparison import TOLERANCE
from graders.core.compare.forms import GRID, NUMBER, ArrayForm, NumberForm, array

CONTRACTS = (
    FunctionContract(
        "log_vraisemblance",
        {"z": array("n"), "z_attendu": array("n"), "sigma": NUMBER, "z_max": NUMBER, "alpha": array(4), "lam": NUMBER},
        NumberForm(tolerance=TOLERANCE),
        (
            Boundary("une lecture égale à ce qui est attendu", lambda z, e, *r: len(z) == 1 and z[0] == e[0] < r[1]),
            Boundary("une lecture égale à la portée", lambda z, e, s, z_max, *r: len(z) == 1 and z[0] == z_max > e[0]),
            Boundary("la portée attendue et lue", lambda z, e, s, z_max, *r: len(z) == 1 and z[0] == e[0] == z_max),
            Boundary(
                "un scan dont tous les rayons lisent la portée",
                lambda z, e, s, z_max, *r: len(z) > 1 and bool((z == z_max).all()),
            ),
            Boundary("des scans dont le produit des densités vaut 0", lambda z, *r: len(z) == 400),
            Boundary("un scan vide, une densité nulle", free="ils ne sont pas demandés"),
        ),
    ),
    FunctionContract(
        "champ_distance",
        {"libres": GRID},
        ArrayForm(shape=("H", "W"), tolerance=TOLERANCE),
        (
            Boundary("un seul mur", lambda libres: (~libres).sum() == 1),
            Boundary("aucune case libre", lambda libres: not libres.any()),
            Boundary("une carte sans murs au bord", lambda libres: bool(libres[0].all())),
            Boundary("une carte d’une seule ligne", lambda libres: len(libres) == 1),
            Boundary("une carte sans aucun mur", free="elle n’est pas demandée"),
        ),
    ),
)
