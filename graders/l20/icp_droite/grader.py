"""l20/icp_droite: normals of a wall, one point-to-line step, and the motions that the walls do not hold."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from graders.core.code.checks import Cases, Untouched
from graders.core.code.exercise import code
from graders.core.compare.comparison import CloseTo
from graders.core.compare.shrinking import keep_unchanged, shrink_array
from graders.core.contract.values import Arguments, Value
from graders.l19.matrices import shrink_noise
from graders.l19.pairs import SamePair
from graders.l20 import world
from graders.l20.icp_droite import cases
from graders.l20.icp_droite.contract import CONTRACTS
from graders.l20.icp_droite.judge import LOOSE, SameNormals, SameSpan
from graders.l20.icp_droite.pictures import normals_figure, pairs_figure
from graders.l20.icp_droite.probes import PARTS, PROBES

WALL, SYSTEM, FREE, STEP = ("normales",), ("systeme_droite",), ("directions_libres",), ("pas_droite",)


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    A = cases.drawn_matrix(rng, (0.0, 0.5, 1.2))
    return {
        "normales": next(cases.any_walls(rng)),
        "systeme_droite": cases.drawn_pairs(rng),
        "directions_libres": (A,),
        "pas_droite": (A, np.array([0.1, -0.2, 0.3])),
    }


def shorter(wall: Value) -> Iterator[Value]:
    """Three points of it, then simpler numbers."""
    if len(wall) > 3:
        yield from (wall[k : k + 3] for k in range(len(wall) - 2))
    yield from shrink_array(wall)


Walls = partial(
    Cases,
    functions=WALL,
    names=("Q",),
    expected=cases.right_normals,
    compare=SameNormals(),
    shrinkers=(shorter,),
    valid=cases.is_wall,
    figure=normals_figure,
)
Pairs = partial(
    Cases,
    functions=SYSTEM,
    names=("P", "Q", "N"),
    expected=cases.right_system,
    compare=SamePair(PARTS),
    shrinkers=(shrink_array, shrink_array, keep_unchanged),
    valid=cases.have_unit_normals,
    figure=pairs_figure,
)
Free = partial(Cases, functions=FREE, expected=cases.right_free, compare=SameSpan(), valid=cases.is_clear)
Steps = partial(Cases, functions=STEP, expected=cases.right_step, compare=CloseTo(LOOSE), valid=cases.is_clear)

CHECKS = (
    Walls(
        id="normales_exemples",
        title="Les normales : des murs droits, un coin",
        points=2,
        cases=cases.walls_by_hand,
        hint="Pour un mur le long de x, vos normales sont-elles le long de y ? Et aux deux bouts du mur ?",
    ),
    Walls(
        id="normales_quelconques",
        title="Les normales : des murs courbes",
        points=2,
        cases=cases.any_walls,
        hint="De quels points part la corde, en chaque point ? Quelle est la longueur de vos normales ?",
    ),
    Pairs(
        id="systeme_exemples",
        title="Le système : quelques paires, de petits nombres",
        points=3,
        cases=cases.pairs_by_hand,
        hint="Un point qui glisse le long de son mur : son écart change-t-il ?",
    ),
    Pairs(
        id="systeme_quelconque",
        title="Le système : des nuages loin de l'origine",
        points=3,
        cases=cases.any_pairs,
        hint="Autour de quel point le nuage tourne-t-il ? Divisez-vous par le nombre de paires ?",
    ),
    Free(
        id="libres_exemples",
        title="Les directions libres : un couloir, une pièce ronde, une pièce carrée",
        points=2,
        names=("A",),
        cases=cases.matrices_by_hand,
        hint="Que valent les valeurs propres d'une matrice diagonale, et leurs vecteurs propres ?",
    ),
    Free(
        id="libres_quelconques",
        title="Les directions libres : des axes quelconques",
        points=1.5,
        names=("A",),
        cases=cases.any_matrices,
        shrinkers=(shrink_noise,),
        hint="np.linalg.eigh range-t-elle ses vecteurs propres en lignes, ou en colonnes ?",
    ),
    Free(
        id="libres_seuil",
        title="Les directions libres : à d'autres seuils",
        points=1,
        names=("A", "seuil"),
        cases=cases.matrices_at_a_threshold,
        hint="Quand le seuil monte, y a-t-il plus ou moins de directions libres ?",
    ),
    Steps(
        id="pas_exemples",
        title="Le pas : rien ne bouge là où rien n'est vu",
        points=2,
        names=("A", "g"),
        cases=cases.steps_by_hand,
        shrinkers=(shrink_noise, shrink_array),
        hint="Quand une valeur propre est nulle, par quoi divisez-vous ?",
    ),
    Steps(
        id="pas_quelconque",
        title="Le pas : des axes quelconques",
        points=1.5,
        names=("A", "g"),
        cases=cases.any_steps,
        shrinkers=(shrink_noise, shrink_array),
        hint="Le pas moins les directions libres : A fois votre pas redonne-t-il −g, à ces directions près ?",
    ),
    Steps(
        id="pas_seuil",
        title="Le pas : à d'autres seuils",
        points=1,
        names=("A", "g", "seuil"),
        cases=cases.steps_at_a_threshold,
        hint="Le seuil donné décide-t-il de ce que votre pas laisse de côté ?",
    ),
    Untouched(
        id="arguments",
        title="Les tableaux donnés restent intacts",
        points=1,
        functions=(*WALL, *SYSTEM, *FREE, *STEP),
        names={
            "normales": ("Q",),
            "systeme_droite": ("P", "Q", "N"),
            "directions_libres": ("A",),
            "pas_droite": ("A", "g"),
        },
        inputs=arguments_to_keep,
        hint="L'écriture P -= P.mean(axis=0) crée-t-elle un nouveau tableau, ou change-t-elle celui qui est donné ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=world.kit, probes=PROBES)
