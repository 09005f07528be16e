"""What is promised of `normales`, `systeme_droite`, `directions_libres` and `pas_droite`."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.compound_forms import OtherForm, TupleForm
from graders.core.compare.forms import NOTHING, NUMBER, TEXT, AcceptedVariant, ArrayForm, RefusedAnswer, array
from graders.core.contract.values import Floats, Value
from graders.l20.icp_droite.cases import THRESHOLD


def recast_directions(value: Value) -> Iterator[AcceptedVariant]:
    rows = np.asarray(value, dtype=np.float64).reshape(-1, 3)
    yield AcceptedVariant("un tableau (k, 3)", rows)
    yield AcceptedVariant("une liste de listes", rows.tolist())
    yield AcceptedVariant("une liste de tableaux", list(rows))
    yield AcceptedVariant("dans l’autre sens", -rows[::-1])
    if len(rows) == 1:
        yield AcceptedVariant("un tableau (3,)", rows[0])


def other_directions(value: Value) -> Iterator[RefusedAnswer]:
    yield from (NOTHING, TEXT)
    yield RefusedAnswer("un seul nombre", 1.0, ("forme",))
    yield RefusedAnswer("des directions de deux nombres", np.ones((1, 2)), ("forme",))


DIRECTIONS = OtherForm(
    told="un tableau (k, 3), une direction de longueur 1 par ligne",
    accepts="tableau numpy, liste ou tuple imbriqués ; vide s’il n’y en a pas, (3,) s’il n’y en a qu’une ; chaque "
    "direction dans un sens ou dans l’autre, et toute autre base du même plan",
    recasts=recast_directions,
    outsiders=other_directions,
    precision="À 10⁻⁶ près.",
)


def free(A: Floats, threshold: float) -> int:
    return int(np.sum(np.linalg.eigvalsh(A) < threshold))


CONTRACTS = (
    FunctionContract(
        "normales",
        {"Q": array("n", 2)},
        ArrayForm(shape=("n", 2)),
        (
            Boundary("trois points", lambda Q: len(Q) == 3),
            Boundary("un coin", lambda Q: len(Q) == 5),
            Boundary("le sens de chaque normale", free="n ou −n"),
        ),
    ),
    FunctionContract(
        "systeme_droite",
        {"P": array("n", 2), "Q": array("n", 2), "N": array("n", 2)},
        TupleForm(parts={"A": array(3, 3), "g": array(3)}),
        (
            Boundary("deux paires", lambda P, Q, N: len(P) == 2),
            Boundary("toutes les normales parallèles", lambda P, Q, N: len(P) > 2 and not N[:, 0].any()),
        ),
    ),
    FunctionContract(
        "directions_libres",
        {"A": array(3, 3), "seuil": NUMBER},
        DIRECTIONS,
        (
            Boundary("aucune direction libre", lambda A, seuil=THRESHOLD: free(A, seuil) == 0),
            Boundary("deux directions libres", lambda A, seuil=THRESHOLD: free(A, seuil) == 2),
            Boundary("une valeur propre exactement nulle", lambda A, *seuil: not np.diag(A).all()),
            Boundary("seuil omis", lambda *args: len(args) == 1),
            Boundary(
                "une valeur propre à peine négative, par arrondi",
                free="elle est libre, par sa valeur absolue comme par son signe",
            ),
            Boundary("une valeur propre près du seuil", free="aucune n’est entre 0,7 et 1,4 fois le seuil"),
        ),
    ),
    FunctionContract(
        "pas_droite",
        {"A": array(3, 3), "g": array(3), "seuil": NUMBER},
        ArrayForm(shape=(3,), called="trois nombres"),
        (
            Boundary("aucune direction libre", lambda A, g, seuil=THRESHOLD: free(A, seuil) == 0),
            Boundary("deux directions libres", lambda A, g, seuil=THRESHOLD: free(A, seuil) == 2),
            Boundary("seuil omis", lambda *args: len(args) == 2),
        ),
    ),
)
