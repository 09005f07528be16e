"""l20/defi_robuste: the null space of a pose graph, and an optimisation that gives up false loop closures.

Nothing that is judged is statistical: the graphs are those of seeds that were looked through beforehand, where twenty
robust programs pass with room to spare and plain least squares do not (see `graphs`).
"""

from __future__ import annotations

from functools import partial

import numpy as np

from graders.core.code.checks import Cases, Untouched
from graders.core.code.exercise import code
from graders.core.compare.comparison import ScalarCloseTo
from graders.core.compare.shrinking import keep_unchanged
from graders.core.contract.values import Arguments
from graders.l20 import world
from graders.l20.defi_robuste import graphs, kernel
from graders.l20.defi_robuste.contract import CONTRACTS
from graders.l20.defi_robuste.probes import PROBES
from graders.l20.defi_robuste.robust import Robustness

KERNEL, ROBUST = ("dimension_noyau",), ("gauss_newton_robuste",)


def arguments_to_keep(rng: np.random.Generator, number: int = 0) -> dict[str, Arguments]:
    one = graphs.chosen(rng, 1)[number]
    kept = (one.poses, list(one.edges), graphs.DELTA, 2)
    return {"dimension_noyau": kernel.in_pieces(rng, 2), "gauss_newton_robuste": kept}


CHECKS = (
    Cases(
        id="noyau_exemples",
        title="La dimension du noyau : quelques graphes, d'un ou de plusieurs morceaux",
        points=4,
        functions=KERNEL,
        names=kernel.NAMES,
        cases=kernel.examples,
        expected=kernel.expected,
        compare=ScalarCloseTo(),
        figure=kernel.pieces_figure,
        hint="Combien de mouvements d'ensemble ne changent aucune erreur ? Et si le graphe est en deux morceaux ?",
    ),
    Cases(
        id="noyau_hasard",
        title="La dimension du noyau : des poses, des poids et des arêtes au hasard",
        points=3,
        functions=KERNEL,
        names=kernel.NAMES,
        cases=kernel.drawn,
        expected=kernel.expected,
        compare=ScalarCloseTo(),
        shrinkers=(keep_unchanged, kernel.shrink_edges),
        valid=kernel.whole,
        figure=kernel.pieces_figure,
        hint="Affichez les valeurs propres de H : laquelle est la première qui n'est pas nulle aux arrondis près ?",
    ),
    Robustness(
        id="une_fausse",
        title="Une fausse fermeture parmi douze vraies : la carte tient, la fausse est débranchée",
        points=6,
        functions=ROBUST,
        graphs=partial(graphs.chosen, false=1),
        filmed=True,
        hint="Affichez les poids à chaque tour : celui de la fausse arête tombe-t-il ? Votre carte en dépend-elle ?",
    ),
    Robustness(
        id="deux_fausses",
        title="Deux fausses fermetures parmi douze vraies",
        points=6,
        functions=ROBUST,
        graphs=partial(graphs.chosen, false=2),
        hint="Le poids vient-il de l'erreur blanchie, √(eᵀΩe), aux poses de ce tour ? Entre-t-il dans H et dans b ?",
    ),
    Untouched(
        id="arguments",
        title="Les poses et les mesures données restent intactes",
        points=1,
        functions=("dimension_noyau", "gauss_newton_robuste"),
        names={"dimension_noyau": kernel.NAMES, "gauss_newton_robuste": ("poses", "aretes", "delta", "n_iter")},
        inputs=arguments_to_keep,
        then=partial(arguments_to_keep, number=1),
        hint="Votre boucle écrit-elle dans les tableaux reçus, ou dans des copies ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=world.kit, probes=PROBES)
