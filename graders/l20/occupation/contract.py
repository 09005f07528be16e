"""What is promised of `vers_logodds`, `vers_proba` and `integrer_scan`."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.compound_forms import OtherForm
from graders.core.compare.forms import NOTHING, NUMBER, POSE, TEXT, AcceptedVariant, ArrayForm, RefusedAnswer, array
from graders.core.contract.values import Value


def numbers_or_arrays(value: Value) -> Iterator[AcceptedVariant]:
    """Yield a number or an array in each of its forms."""
    form = ArrayForm(shape=()) if np.ndim(value) == 0 else array(*np.shape(value))
    if np.ndim(value):
        yield from form.accepted_variants(value)
    else:
        yield from NUMBER.accepted_variants(value)


def other_shapes(value: Value) -> Iterator[RefusedAnswer]:
    yield from (NOTHING, TEXT)
    yield RefusedAnswer("un axe de trop", np.asarray(value)[None, None, None], ("forme",))
    yield RefusedAnswer("des nombres complexes", np.asarray(value) + 1j, ("réels",))


ELEMENTWISE = OtherForm(
    told="un nombre ou un tableau, de la forme de ce qui est donné",
    accepts="pour un nombre, un flottant de Python ou de numpy ou un tableau 0-d ; pour un tableau, un tableau numpy, "
    "une liste ou un tuple",
    given=lambda value: type(value) is float or (type(value) is np.ndarray and value.dtype == np.float64),
    recasts=numbers_or_arrays,
    outsiders=other_shapes,
)
GRID = ArrayForm(
    shape=("H", "W"),
    called="une grille",
    precision="À 0,0005 près par rayon, dans l’absolu ; un calcul en float32 suffit.",
)
RELAUNCHED = "est relancé sur d’autres cartes ; la forme de la grille est toujours celle de l."

CONTRACTS = (
    FunctionContract(
        "vers_logodds",
        {"p": ELEMENTWISE},
        ELEMENTWISE,
        (
            Boundary("un nombre seul", lambda p: type(p) is float),
            Boundary("un tableau 0-d", lambda p: type(p) is np.ndarray and p.ndim == 0),
            Boundary("un tableau d’une seule valeur", lambda p: np.shape(p) == (1,)),
            Boundary("p = 0,5", lambda p: np.ndim(p) == 0 and p == 0.5),
            Boundary("p = 0 ou p = 1", free="ce n’est pas demandé"),
            Boundary("des entiers, des listes", free="ils ne sont pas donnés"),
        ),
        RELAUNCHED,
    ),
    FunctionContract(
        "vers_proba",
        {"l": ELEMENTWISE},
        ELEMENTWISE,
        (
            Boundary("un nombre seul", lambda log_odds: type(log_odds) is float),
            Boundary("un tableau 0-d", lambda log_odds: type(log_odds) is np.ndarray and log_odds.ndim == 0),
            Boundary("l = 0", lambda log_odds: np.ndim(log_odds) == 0 and log_odds == 0.0),
            Boundary(
                "l immense, dans les deux sens",
                lambda log_odds: np.ndim(log_odds) == 1 and np.abs(log_odds).max() > 1000.0,
            ),
            Boundary("l infini", free="ce n’est pas demandé"),
        ),
        RELAUNCHED,
    ),
    FunctionContract(
        "integrer_scan",
        {"l": GRID, "pose": POSE, "scan": array("n"), "portee_max": NUMBER},
        GRID,
        (
            Boundary("une lecture égale à la portée", lambda grid, pose, z, p: len(z) == 1 and z[0] == p),
            Boundary("une lecture au-delà de la portée", lambda grid, pose, z, p: len(z) == 1 and z[0] > p),
            Boundary(
                "un scan dont tous les rayons lisent la portée", lambda grid, pose, z, p: len(z) > 1 and min(z) >= p
            ),
            Boundary("un arrêt pile sur la face d’une case", lambda grid, pose, z, p: tuple(pose) == (1.5, 2.5, 0.0)),
            Boundary("un arrêt hors de la grille", lambda grid, pose, z, p: grid.shape[1] < pose[0] + z[0] < 8.5),
            Boundary("des cases déjà à 5 ou à −5", lambda grid, pose, z, p: bool((np.abs(grid) == 5.0).any())),
            Boundary("un scan vide", free="il a toujours un rayon au moins"),
            Boundary("la case du robot", free="la libérer ou non"),
            Boundary("une case que plusieurs rayons rencontrent", free="une voix par rayon, ou par scan"),
            Boundary("une case que des rayons traversent et où un autre s’arrête", free="elle n’est pas jugée"),
            Boundary("les bornes −5 et 5", free="appliquées à la fin du scan, ou après chaque voix"),
        ),
        RELAUNCHED,
    ),
)
