"""l19/predire_corriger: a Gaussian belief on a line, which a displacement widens and a reading narrows."""

from __future__ import annotations

from functools import partial

from graders.core.code.checks import Cases, Trial
from graders.core.code.exercise import code
from graders.core.compare.shrinking import shrink_number
from graders.l19.pairs import SamePair
from graders.l19.predire_corriger import cases
from graders.l19.predire_corriger.contract import CONTRACTS
from graders.l19.predire_corriger.corridor import walk_on
from graders.l19.predire_corriger.pictures import MEASURED, MOVED, belief_figure
from graders.l19.predire_corriger.probes import NAMES, PROBES
from graders.l19.truth import moved, seen

SHRINKERS = (shrink_number,) * 4

Moves = partial(
    Cases,
    functions=("predire",),
    names=("m", "v", "u", "q"),
    expected=moved,
    compare=SamePair(NAMES),
    shrinkers=SHRINKERS,
    valid=cases.is_telling_move,
    figure=partial(belief_figure, MOVED),
)
Readings = partial(
    Cases,
    functions=("corriger",),
    names=("m", "v", "z", "r"),
    expected=seen,
    compare=SamePair(NAMES),
    shrinkers=SHRINKERS,
    valid=cases.is_telling_reading,
    figure=partial(belief_figure, MEASURED),
)

CHECKS = (
    Moves(
        id="predire_exemples",
        title="Prédire : des nombres simples",
        points=3,
        cases=cases.moves_by_hand,
        hint="Le robot avance de 3 m, à un écart-type près. Sait-on mieux, ou moins bien, où il est après ?",
    ),
    Moves(
        id="predire_quelconques",
        title="Prédire : des nombres quelconques",
        points=3,
        cases=cases.any_moves,
        hint="Deux erreurs indépendantes s'ajoutent : que deviennent leurs variances ? Et leurs écarts-types ?",
    ),
    Readings(
        id="corriger_exemples",
        title="Corriger : un bon capteur, un mauvais, un aussi sûr que la croyance",
        points=5,
        cases=cases.readings_by_hand,
        hint="Si la mesure et la croyance sont aussi sûres l'une que l'autre, où est la nouvelle moyenne ?",
    ),
    Readings(
        id="corriger_quelconques",
        title="Corriger : des nombres quelconques",
        points=5,
        cases=cases.any_readings,
        hint="Affichez le gain : de quel côté va-t-il quand r devient très grand ? Et la variance, peut-elle grandir ?",
    ),
    Trial(
        id="couloir",
        title="Un couloir : prédire et corriger à la suite",
        points=4,
        functions=("predire", "corriger"),
        protocol=walk_on,
        hint="Chaque appel part de ce que votre fonction a rendu à l'appel d'avant. Quel est le premier qui soit "
        "faux ? Se souvient-elle de quelque chose d'un appel à l'autre ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, probes=PROBES)
