"""l20/fermeture: what the inverse of H says of two poses, and whether it explains the residual of a closure.

Nothing is left to chance: distances stay a hundredth away from their thresholds.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from graders.core.code.checks import Cases, Untouched
from graders.core.code.exercise import code
from graders.core.compare.comparison import CloseTo
from graders.core.compare.shrinking import keep_unchanged
from graders.core.contract.values import Arguments, Value
from graders.l19.matrices import shrink_covariance, shrink_noise
from graders.l19.pairs import SamePair
from graders.l20 import world
from graders.l20.fermeture import cases
from graders.l20.fermeture.contract import CONTRACTS
from graders.l20.fermeture.pictures import gate_figure, relative_figure
from graders.l20.fermeture.probes import PROBES, VERDICT
from graders.robotics.poses import shrink_pose

JOINT, RELATIVE, TEST = ("covariance_jointe",), ("covariance_relative",), ("juger_fermeture",)
GRAPH, PAIR, CLOSURE = ("H", "i", "j"), ("xi", "xj", "sigma"), ("xi", "xj", "z", "sigma", "omega")
TOLERANCE = 1e-4


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    return {
        "covariance_jointe": cases.graph_to_keep(rng),
        "covariance_relative": cases.drawn_pair(rng),
        "juger_fermeture": next(cases.any_closures(rng)),
    }


def shrink_level(level: Value) -> Iterator[Value]:
    return (simpler for simpler in (0.95, 0.9, 0.5, 0.99) if simpler != level)


Graphs = partial(
    Cases,
    functions=JOINT,
    names=GRAPH,
    expected=cases.right_joint,
    compare=CloseTo(TOLERANCE),
)
Pairs = partial(
    Cases,
    functions=RELATIVE,
    names=PAIR,
    expected=cases.right_relative,
    compare=CloseTo(TOLERANCE),
    shrinkers=(shrink_pose, shrink_pose, shrink_noise),
    valid=cases.is_pair,
    figure=relative_figure,
)
Closures = partial(
    Cases,
    functions=TEST,
    expected=cases.right_test,
    compare=SamePair(VERDICT, tolerance=TOLERANCE),
    valid=cases.decides,
    figure=gate_figure,
)

CHECKS = (
    Graphs(
        id="jointe_exemples",
        title="La covariance de deux poses : quelques poses, de petits nombres",
        points=4,
        cases=cases.graphs_by_hand,
        hint="Dans quel ordre faites-vous ces trois gestes : rayer la pose 0, inverser, extraire ?",
    ),
    Graphs(
        id="jointe_quelconque",
        title="La covariance de deux poses : une boucle, des poids corrélés",
        points=3,
        cases=cases.any_graphs,
        hint="Votre résultat est-il symétrique ? Où sont les lignes de la pose i, quand i est plus grand que j ?",
    ),
    Pairs(
        id="relative_exemples",
        title="L'une vue depuis l'autre : de petits nombres",
        points=3,
        cases=cases.pairs_by_hand,
        hint="Si seul le cap de i est incertain, dans quelle direction j est-elle mal connue, vue de i ?",
    ),
    Pairs(
        id="relative_quelconque",
        title="L'une vue depuis l'autre : des caps et des corrélations quelconques",
        points=2,
        cases=cases.any_pairs,
        hint="Si les deux poses se trompent ensemble, du même déplacement, que doit valoir la covariance relative ?",
    ),
    Closures(
        id="porte_exemples",
        title="La porte : de petits nombres",
        points=3,
        names=CLOSURE,
        cases=cases.closures_by_hand,
        shrinkers=(*(shrink_pose,) * 3, shrink_noise, shrink_covariance),
        hint="Qu'est-ce qui peut expliquer l'écart : le doute sur les poses, celui de la mesure, ou les deux ?",
    ),
    Closures(
        id="porte_quelconque",
        title="La porte : des deux côtés du seuil, le niveau n'étant pas donné",
        points=2,
        names=CLOSURE,
        cases=cases.any_closures,
        shrinkers=(*(shrink_pose,) * 2, keep_unchanged, shrink_noise, shrink_covariance),
        hint="Combien de nombres compare-t-on à la fois ? Le seuil se rapporte-t-il à d, ou à son carré ?",
    ),
    Closures(
        id="porte_niveau",
        title="La porte : à d'autres niveaux",
        points=2,
        names=(*CLOSURE, "niveau"),
        cases=cases.closures_at_a_level,
        shrinkers=(*(shrink_pose,) * 2, keep_unchanged, shrink_noise, shrink_covariance, shrink_level),
        hint="Votre seuil monte-t-il ou descend-il quand le niveau passe de 0,5 à 0,99 ?",
    ),
    Untouched(
        id="arguments",
        title="Les tableaux donnés restent intacts",
        points=1,
        functions=(*JOINT, *RELATIVE, *TEST),
        names={"covariance_jointe": GRAPH, "covariance_relative": PAIR, "juger_fermeture": CLOSURE},
        inputs=arguments_to_keep,
        hint="L'écriture H[:3] = 0 change-t-elle une copie, ou le tableau donné ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=world.kit, probes=PROBES)
