"""l19/matrice: the Kalman filter of several numbers, with matrices of all shapes."""

from __future__ import annotations

from functools import partial

import numpy as np

from graders.core.code.checks import Cases, Trial, Untouched
from graders.core.code.exercise import code
from graders.core.compare.shrinking import shrink_array
from graders.core.contract.values import Arguments
from graders.l19.matrice import cases
from graders.l19.matrice.contract import CONTRACTS
from graders.l19.matrice.pictures import NAMES, measured_figure, moved_figure
from graders.l19.matrice.probes import PROBES
from graders.l19.matrice.pursuit import ARGUMENTS, follow
from graders.l19.matrices import shrink_covariance, shrink_noise
from graders.l19.pairs import SamePair
from graders.l19.truth import corrected, predicted


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    return {"predire": next(cases.any_steps(rng)), "corriger": next(cases.any_readings(rng))}


Steps = partial(
    Cases,
    functions=("predire",),
    names=ARGUMENTS["predire"],
    expected=predicted,
    compare=SamePair(NAMES),
    shrinkers=(shrink_array, shrink_covariance, shrink_array, shrink_noise),
    valid=cases.is_step,
    figure=moved_figure,
)
Readings = partial(
    Cases,
    functions=("corriger",),
    names=ARGUMENTS["corriger"],
    expected=corrected,
    compare=SamePair(NAMES),
    shrinkers=(shrink_array, shrink_covariance, shrink_array, shrink_array, shrink_covariance),
    valid=cases.is_reading,
    figure=measured_figure,
)

CHECKS = (
    Steps(
        id="predire_exemples",
        title="Prédire : de petites matrices",
        points=3,
        cases=cases.steps_by_hand,
        hint="Un wagon roule à une vitesse mal connue : après un pas, connaît-on mieux sa position, ou moins bien ?",
    ),
    Steps(
        id="predire_quelconques",
        title="Prédire : deux, trois, quatre composantes",
        points=3,
        cases=cases.any_steps,
        hint="Refaites F P Fᵀ à la main pour une matrice 2 × 2 : dans quel ordre viennent les trois facteurs ?",
    ),
    Readings(
        id="corriger_exemples",
        title="Corriger : une mesure de la position, d'une différence, de deux nombres",
        points=4,
        cases=cases.readings_by_hand,
        hint="Quelles sont les formes de S et de K ? Affichez-les : K a-t-il une ligne par composante de x ?",
    ),
    Readings(
        id="corriger_quelconques",
        title="Corriger : des formes et des nombres quelconques",
        points=4,
        cases=cases.any_readings,
        hint="Votre nouvelle covariance est-elle symétrique ? Ses variances ont-elles diminué ?",
    ),
    Trial(
        id="poursuite",
        title="Un wagon suivi pas à pas, dont on ne lit que la position",
        points=4,
        functions=("predire", "corriger"),
        protocol=follow,
        hint="Chaque appel part de ce que votre fonction a rendu à l'appel d'avant. Quel est le premier qui soit "
        "faux ? La vitesse n'est jamais mesurée : qu'est-ce qui la corrige ?",
    ),
    Untouched(
        id="arguments",
        title="Les vecteurs et les matrices donnés restent intacts",
        points=2,
        functions=("predire", "corriger"),
        names=ARGUMENTS,
        inputs=arguments_to_keep,
        hint="L'écriture P += Q crée-t-elle une nouvelle matrice, ou change-t-elle celle qui est donnée ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, probes=PROBES)
