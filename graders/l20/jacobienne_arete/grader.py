"""l20/jacobienne_arete: the residual of one edge, its two Jacobians, and what it adds to the normal equations.

The half step before l20/slam_graphe. Derivatives may come from finite differences: they are compared to 1e-4.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from graders.core.code.checks import Cases, Untouched
from graders.core.code.exercise import code
from graders.core.contract.values import Arguments
from graders.l19.matrices import shrink_covariance
from graders.l19.pairs import SamePair
from graders.l20 import world
from graders.l20.jacobienne_arete import cases
from graders.l20.jacobienne_arete.contract import CONTRACTS
from graders.l20.jacobienne_arete.judge import PRODUCT, SYSTEM, WHOLE, SameColumns
from graders.l20.jacobienne_arete.pictures import columns_figure, residual_figure
from graders.l20.jacobienne_arete.probes import PROBES
from graders.l20.slam_graphe.residual import NAMES, SameError, wraps
from graders.robotics.poses import shrink_pose

RESIDUAL, JACOBIANS, SYSTEM_OF_ONE = ("residu",), ("jacobiennes",), ("contribution",)
WEIGHED = (*NAMES, "omega")


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    edge = cases.edge_to_keep(rng)
    return {"residu": edge, "jacobiennes": edge, "contribution": (*edge, np.diag([1.0, 2.0, 3.0]))}


Residuals = partial(
    Cases,
    functions=RESIDUAL,
    names=NAMES,
    expected=cases.right_residual,
    compare=SameError(),
    shrinkers=(shrink_pose,) * 3,
    figure=residual_figure,
)
Jacobians = partial(
    Cases,
    functions=JACOBIANS,
    names=NAMES,
    expected=cases.right_jacobians,
    shrinkers=(shrink_pose,) * 3,
    valid=cases.is_edge,
    figure=columns_figure,
)
Contributions = partial(
    Cases,
    functions=SYSTEM_OF_ONE,
    names=WEIGHED,
    expected=cases.right_contribution,
    compare=SamePair(SYSTEM, tolerance=PRODUCT),
    shrinkers=(*(shrink_pose,) * 3, shrink_covariance),
    valid=cases.is_weighed_edge,
)

CHECKS = (
    Residuals(
        id="residu_exemples",
        title="Le résidu : quarts de tour, puis des poses quelconques",
        points=2,
        cases=cases.whole_edges,
        valid=cases.is_edge,
        hint="Où le robot placé en xi voit-il la pose xj, dans ses propres axes ? Qu'annonçait la mesure ?",
    ),
    Residuals(
        id="residu_tours",
        title="Le résidu : l'angle revient dans ]−π, π]",
        points=2,
        cases=cases.wrapped_edges,
        valid=wraps,
        hint="Deux caps de 170° et de −170° : de combien diffèrent-ils vraiment ? Et que donne leur soustraction ?",
    ),
    Jacobians(
        id="bouger_j",
        title="B : quand la pose j bouge",
        points=2,
        cases=cases.upright_edges,
        compare=SameColumns(1, 0, 3),
        hint="Le robot i regarde vers le nord, et j fait un pas vers l'est : de quel côté i la voit-il partir ?",
    ),
    Jacobians(
        id="bouger_i",
        title="A, deux premières colonnes : quand le robot i se déplace sans tourner",
        points=2,
        cases=cases.upright_edges,
        compare=SameColumns(0, 0, 2),
        hint="Si i avance d'un pas, j lui paraît-elle plus près ou plus loin ? Que devient le signe ?",
    ),
    Jacobians(
        id="pivoter_i",
        title="A, dernière colonne : quand le robot i pivote",
        points=3,
        cases=cases.upright_edges,
        compare=SameColumns(0, 2, 3),
        hint="Vous pivotez à gauche : une chaise devant vous part-elle à gauche ou à droite ? Et si elle est loin ?",
    ),
    Jacobians(
        id="jacobiennes_quelconques",
        title="A et B, pour des caps quelconques",
        points=2,
        cases=cases.any_edges,
        compare=WHOLE,
        hint="Chaque colonne est-elle égale à (residu(x + h u) − residu(x)) / h, avec h = 1e-6 ?",
    ),
    Contributions(
        id="contribution_exemples",
        title="La contribution d'une arête : de petits nombres",
        points=3,
        cases=cases.contributions_by_hand,
        hint="Combien de lignes et de colonnes ont J, JᵀΩJ et JᵀΩe ? Où sont celles de xi ?",
    ),
    Contributions(
        id="contribution_quelconques",
        title="La contribution d'une arête : des poids corrélés",
        points=3,
        cases=cases.any_contributions,
        hint="Ω entre une fois dans H et une fois dans b : où ? Que deviennent H et b si l'on double Ω ?",
    ),
    Untouched(
        id="arguments",
        title="Les poses, la mesure et le poids donnés restent intacts",
        points=1,
        functions=(*RESIDUAL, *JACOBIANS, *SYSTEM_OF_ONE),
        names={"residu": NAMES, "jacobiennes": NAMES, "contribution": WEIGHED},
        inputs=arguments_to_keep,
        hint="L'écriture xj -= xi crée-t-elle un nouveau tableau, ou change-t-elle celui qui est donné ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=world.kit, probes=PROBES)
