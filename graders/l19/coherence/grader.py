"""l19/coherence: does a filter deserve the trust that it has in itself? The NEES, and the band of its mean.

Nothing is left to chance: means stay a hundredth away from the ends of their bands, so that how an honest program
computes a quantile decides nothing (to 1e-6, the tolerance of `bande`).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from graders.core.code.checks import Cases, Untouched
from graders.core.code.exercise import code
from graders.core.compare.comparison import ScalarCloseTo
from graders.core.compare.shrinking import shrink_array, shrink_number
from graders.core.contract.values import Arguments
from graders.l19.coherence import cases
from graders.l19.coherence.contract import CONTRACTS
from graders.l19.coherence.pictures import band_figure, error_figure, runs_figure
from graders.l19.coherence.probes import ENDS, PROBES, VERDICT
from graders.l19.coherence.truth import right_band, right_nees, right_verdict
from graders.l19.matrices import shrink_covariance
from graders.l19.pairs import SamePair

NEES, BAND, JUDGE = ("nees",), ("bande",), ("coherence",)
ONE, ALL = ("vraie", "estimee", "P"), ("vraies", "estimees", "covariances")


def shrink_count(count: int) -> Iterator[int]:
    """Fewer dimensions, or fewer runs."""
    yield from (fewer for fewer in (1, 2, 10) if fewer < count)


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    return {"nees": next(cases.any_errors(rng)), "coherence": next(cases.telling_runs(rng))}


Errors = partial(
    Cases,
    functions=NEES,
    names=ONE,
    expected=right_nees,
    compare=ScalarCloseTo(),
    shrinkers=(shrink_array, shrink_array, shrink_covariance),
    valid=cases.is_error,
    figure=error_figure,
)
Bands = partial(
    Cases,
    functions=BAND,
    expected=right_band,
    compare=SamePair(ENDS, tolerance=1e-6),
    valid=cases.is_band,
    figure=band_figure,
)
Runs = partial(
    Cases,
    functions=JUDGE,
    names=ALL,
    expected=right_verdict,
    compare=SamePair(VERDICT),
    figure=runs_figure,
)

CHECKS = (
    Errors(
        id="nees_exemples",
        title="Le NEES d'une estimation : de petits nombres",
        points=3,
        cases=cases.errors_by_hand,
        hint="Une erreur de 2 m : est-elle plus grave si le filtre annonce un écart-type de 1 m, ou de 4 m ?",
    ),
    Errors(
        id="nees_quelconques",
        title="Le NEES d'une estimation : d'une à quatre composantes",
        points=3,
        cases=cases.any_errors,
        hint="En dimension 1, votre NEES vaut-il e² / P ? Que devient la division quand P est une matrice ?",
    ),
    Bands(
        id="bande",
        title="La bande, à un niveau donné",
        points=3,
        names=("n", "N", "niveau"),
        cases=cases.bands,
        shrinkers=(shrink_count, shrink_count, shrink_number),
        hint="Combien de degrés de liberté a la somme de N NEES ? Et que reste-t-il de chaque côté de la bande ?",
    ),
    Bands(
        id="bande_usuelle",
        title="La bande à 95 %, quand le niveau n'est pas donné",
        points=2,
        names=("n", "N"),
        cases=cases.usual_bands,
        shrinkers=(shrink_count, shrink_count),
        hint="Comment écrit-on, dans la ligne « def », la valeur que prend un paramètre absent ?",
    ),
    Runs(
        id="coherence_exemples",
        title="Juger un filtre : quelques essais",
        points=4,
        cases=cases.runs_by_hand,
        hint="Un NEES moyen très grand : le filtre se trompe-t-il plus, ou moins, qu'il ne l'annonce ?",
    ),
    Runs(
        id="coherence_quelconques",
        title="Juger un filtre : plus d'essais, tout près de la bande",
        points=3,
        cases=cases.any_runs,
        hint="Affichez la moyenne et les deux bouts de la bande. Qu'est-ce qui est faux : elle, eux, ou l'avis ?",
    ),
    Untouched(
        id="arguments",
        title="Les tableaux donnés restent intacts",
        points=2,
        functions=(*NEES, *JUDGE),
        names={"nees": ONE, "coherence": ALL},
        inputs=arguments_to_keep,
        hint="L'écriture vraies -= estimees crée-t-elle un nouveau tableau, ou change-t-elle celui qui est donné ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, probes=PROBES)
