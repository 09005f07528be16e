"""l19/etendu: the extended filter, with a sensor that reads how far a beacon is."""

from __future__ import annotations

from functools import partial

import numpy as np

from graders.core.code.checks import Cases, Trial, Untouched
from graders.core.code.exercise import code
from graders.core.compare.shrinking import shrink_array, shrink_number
from graders.core.contract.values import Arguments
from graders.l19.etendu import cases
from graders.l19.etendu.contract import CONTRACTS
from graders.l19.etendu.pictures import RANGE, STATE, range_figure, reading_figure
from graders.l19.etendu.probes import PROBES
from graders.l19.etendu.truth import right_correction, right_range
from graders.l19.etendu.walk import NAMES, walk_on
from graders.l19.matrices import shrink_covariance
from graders.l19.pairs import SamePair

#: A derivative by small differences is honest: forwards, by a step of 1e-6, it is off by some 1e-7.
TOLERANCE = 1e-5
MEASURE, CORRECT = ("distance_et_jacobien",), ("corriger_distance",)


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    return {"distance_et_jacobien": next(cases.any_places(rng)), "corriger_distance": next(cases.any_readings(rng))}


Places = partial(
    Cases,
    functions=MEASURE,
    names=("x", "balise"),
    expected=right_range,
    shrinkers=(shrink_array, shrink_array),
    valid=cases.is_place,
    figure=range_figure,
)
Readings = partial(
    Cases,
    functions=CORRECT,
    names=NAMES,
    cases=cases.readings,
    expected=right_correction,
    shrinkers=(shrink_array, shrink_covariance, shrink_number, shrink_array, shrink_number),
    valid=cases.is_reading,
    figure=reading_figure,
)
#: Of each pair, one check judges the first value, another one the second: half an answer earns half of the points.
DISTANCE, DERIVATIVE = (SamePair(RANGE, TOLERANCE, loose=True, judged=which) for which in range(2))
MEAN, DOUBT = (SamePair(STATE, TOLERANCE, judged=which) for which in range(2))

CHECKS = (
    Places(
        id="distance",
        title="La distance",
        points=2,
        cases=cases.places,
        compare=DISTANCE,
        hint="Dans le triangle rectangle qui va de la balise au robot, quels sont les deux petits côtés ?",
    ),
    Places(
        id="derivee_exemples",
        title="La dérivée de la distance : des triangles rectangles",
        points=2,
        cases=cases.places_by_hand,
        compare=DERIVATIVE,
        hint="Si le robot s'écarte de la balise d'un mètre, de combien la distance augmente-t-elle ? Et s'il tourne "
        "autour d'elle ?",
    ),
    Places(
        id="derivee_quelconques",
        title="La dérivée de la distance : des positions quelconques",
        points=2,
        cases=cases.any_places,
        compare=DERIVATIVE,
        hint="Déplacez x de 0,001 selon chaque axe : de combien change la distance ? Est-ce 0,001 fois votre H ?",
    ),
    Readings(
        id="correction_etat",
        title="Corriger : l’état, plus loin ou plus près que prévu",
        points=5,
        compare=MEAN,
        hint="Dans quelle direction l'état peut-il bouger, si le doute est le même dans toutes ? Et de quel côté ?",
    ),
    Readings(
        id="correction_doute",
        title="Corriger : la covariance",
        points=4,
        compare=DOUBT,
        hint="Affichez d, H, S et K, et refaites le calcul à la main. Lequel des quatre diffère ?",
    ),
    Trial(
        id="promenade",
        title="Une promenade entre trois balises",
        points=3,
        functions=CORRECT,
        protocol=walk_on,
        hint="Chaque correction part de ce que votre fonction a rendu pour la balise d'avant. Est-ce bien en ce point, "
        "et pas ailleurs, que vous prenez la dérivée ?",
    ),
    Untouched(
        id="arguments",
        title="Les vecteurs et les matrices donnés restent intacts",
        points=2,
        functions=(*MEASURE, *CORRECT),
        names={"distance_et_jacobien": ("x", "balise"), "corriger_distance": NAMES},
        inputs=arguments_to_keep,
        hint="L'écriture x += … crée-t-elle un nouveau tableau, ou change-t-elle celui qui est donné ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, probes=PROBES)
