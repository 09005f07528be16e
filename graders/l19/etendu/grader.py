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
    compare=SamePair(RANGE, TOLERANCE, loose=True),
    shrinkers=(shrink_array, shrink_array),
    valid=cases.is_place,
    figure=range_figure,
)
Readings = partial(
    Cases,
    functions=CORRECT,
    names=NAMES,
    expected=right_correction,
    compare=SamePair(STATE, TOLERANCE),
    shrinkers=(shrink_array, shrink_covariance, shrink_number, shrink_array, shrink_number),
    valid=cases.is_reading,
    figure=reading_figure,
)

CHECKS = (
    Places(
        id="distance_exemples",
        title="La distance et sa dérivée : des triangles rectangles",
        points=3,
        cases=cases.places_by_hand,
        hint="Si le robot s'écarte de la balise d'un mètre, de combien la distance augmente-t-elle ? Et s'il tourne "
        "autour d'elle ?",
    ),
    Places(
        id="distance_quelconques",
        title="La distance et sa dérivée : des positions quelconques",
        points=3,
        cases=cases.any_places,
        hint="Déplacez x de 0,001 selon chaque axe : de combien change la distance ? Est-ce 0,001 fois votre H ?",
    ),
    Readings(
        id="correction_exemples",
        title="Corriger : plus loin ou plus près que prévu",
        points=5,
        cases=cases.readings_by_hand,
        hint="Dans quelle direction l'état peut-il bouger, si le doute est le même dans toutes ? Et de quel côté ?",
    ),
    Readings(
        id="correction_quelconques",
        title="Corriger : des positions et des doutes quelconques",
        points=4,
        cases=cases.any_readings,
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
