"""What is promised of the stages of the practical work."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.compound_forms import OtherForm, TupleForm
from graders.core.compare.forms import (
    NOTHING,
    NUMBER,
    POSE,
    TEXT,
    AcceptedVariant,
    ArrayForm,
    IndicesForm,
    NumberForm,
    RefusedAnswer,
    array,
    poses,
    power_text,
)
from graders.core.contract.values import Value
from graders.l20.tp_slam.stages import SAME


def loops_recast(value: Value) -> Iterator[AcceptedVariant]:
    """Yield loops as lists and tuples, their ranks of either type, their poses in each form."""
    yield AcceptedVariant("une liste de tuples", [(int(a), int(b), np.asarray(z)) for a, b, z in value])
    yield AcceptedVariant("un tuple de listes", tuple([np.int64(a), np.int64(b), list(z)] for a, b, z in value))
    yield AcceptedVariant("l’autre sens", [(b, a, _inverse(np.asarray(z))) for a, b, z in value])


def _inverse(z: Value) -> Value:
    x, y, theta = z
    c, s = np.cos(theta), np.sin(theta)
    return np.array([-x * c - y * s, x * s - y * c, -theta])


def no_loops(value: Value) -> Iterator[RefusedAnswer]:
    yield from (NOTHING, TEXT)
    yield RefusedAnswer("des paires", [tuple(loop)[:2] for loop in value] or [(0, 20)], ("triplet",))


LOOPS = OtherForm(
    told="une liste de triplets (a, b, pose de b vue de a)",
    accepts="listes ou tuples ; a et b dans un ordre quelconque, la pose étant celle du second vu du premier",
    given=lambda value: type(value) is list and all(len(loop) == 3 for loop in value),
    recasts=loops_recast,
    outsiders=no_loops,
)
ONCE = "est lancé une fois : les étapes s’y suivent, sur vos propres résultats. Il peut importer `mes_fonctions`."
CONTRACTS = (
    FunctionContract(
        "trajectoire",
        {"roues": array("m", 2), "L": NUMBER},
        ArrayForm(shape=("n", 3), called="des poses", precision=f"À {power_text(SAME)} près, l’angle modulo 2π."),
        (),
        ONCE,
    ),
    FunctionContract(
        "poses_cles",
        {"poses": poses()},
        IndicesForm(),
        (
            Boundary("un seuil atteint à un arrondi près (10⁻⁶)", free="compté ou non : `>` comme `>=`"),
            Boundary("le chemin ou le vol d’oiseau ; la rotation nette ou cumulée", free="au choix"),
        ),
        ONCE,
    ),
    FunctionContract(
        "recaler",
        {"points_a": array("m", 2), "points_b": array("n", 2), "depart": POSE},
        TupleForm(
            parts={"pose": POSE, "part": NumberForm()},
            precision="Jugé à quelques centimètres et centièmes de radian près (l’énoncé les dit).",
        ),
        (
            Boundary("des nuages de tailles différentes", lambda a, b, depart: len(a) != len(b)),
            Boundary(
                "moins de trois paires à la pose finale seulement", free="une part de 0, ou celle que l’on compte"
            ),
        ),
        ONCE,
    ),
    FunctionContract(
        "fermetures",
        {"scans": array("k", "r"), "chaine": poses("k")},
        LOOPS,
        (
            Boundary(
                "un rayon qui lit la portée, 8 m, ne donne pas de point", lambda scans, chaine: np.max(scans) >= 8.0
            ),
            Boundary("une même paire dans les deux ordres", free="comptée une fois"),
            Boundary("la signature", free="une autre que celle de l’énoncé convient, et numpy.fft comme scipy.fft"),
        ),
        ONCE,
    ),
    FunctionContract(
        "optimiser",
        {"chaine": poses("k"), "recalages": poses("j"), "deplacements": poses("j"), "boucles": LOOPS},
        ArrayForm(shape=("k", 3), called="des poses", precision="Jugé par l’écart à la vérité."),
        (Boundary("aucune boucle : une liste vide", lambda c, r, d, boucles: boucles == []),),
        ONCE,
    ),
    FunctionContract(
        "carte",
        {
            "poses": poses("k"),
            "scans": array("k", "r"),
            "forme": OtherForm(told="deux entiers (H, W)"),
            "origine": OtherForm(told="deux nombres (x, y)"),
            "cote": NUMBER,
            "portee": NUMBER,
        },
        ArrayForm(shape=("H", "W"), called="une grille", precision="Jugée par ses signes : libre ou occupé."),
        (
            Boundary(
                "une grille qui n’est pas carrée : [ligne, colonne], donc [y, x]",
                lambda *args: args[2][0] != args[2][1],
            ),
            Boundary("une lecture de 8 m : des cases libres, pas de mur", lambda *args: np.max(args[1]) >= 8.0),
            Boundary("la portée laissée à son défaut", lambda *args: len(args) == 5),
            Boundary("la case du robot", free="elle n’est pas jugée"),
        ),
        ONCE,
    ),
)
