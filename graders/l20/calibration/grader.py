"""l20/calibration: three constants of a robot by least squares, its steps corrected, and those of a real one."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from graders.core.code.checks import Cases, Trial, Untouched
from graders.core.code.exercise import code
from graders.core.compare.comparison import CloseTo
from graders.core.compare.shrinking import keep_unchanged, shrink_array, shrink_number
from graders.core.contract.values import Arguments, Value
from graders.l20 import world
from graders.l20.calibration import cases
from graders.l20.calibration.contract import CONTRACTS
from graders.l20.calibration.judge import SameConstants
from graders.l20.calibration.laboratory import through_the_laboratory
from graders.l20.calibration.pictures import steps_figure
from graders.l20.calibration.probes import PROBES

WAYS, FIT, CORRECT = ("avance",), ("etalonner",), ("corriger",)
CONSTANTS = ("gamma", "beta", "alpha")


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    steps, motions = cases.drawn_journey(np.random.default_rng(cases.STEADY), 4, cases.ROBOTS[0])
    return {"avance": (steps,), "etalonner": (steps, motions), "corriger": (steps, *cases.ROBOTS[0])}


def fewer(steps: Value) -> Iterator[Value]:
    """One step less, then simpler numbers."""
    if len(steps) > 1:
        yield from (np.delete(steps, k, axis=0) for k in range(len(steps)))
    yield from shrink_array(steps)


Lengths = partial(
    Cases,
    functions=WAYS,
    names=("pas",),
    expected=cases.right_ways,
    compare=CloseTo(),
    shrinkers=(fewer,),
    valid=lambda args: len(args[0]) > 0 and cases.stays_short(args[0]),
)
Fits = partial(
    Cases,
    functions=FIT,
    names=("pas", "vrais"),
    expected=cases.right_constants,
    compare=SameConstants(),
    shrinkers=(keep_unchanged, shrink_array),
    valid=cases.determines,
)
Corrections = partial(
    Cases,
    functions=CORRECT,
    names=("pas", *CONSTANTS),
    expected=cases.right_steps,
    compare=CloseTo(),
    shrinkers=(fewer, *(shrink_number,) * 3),
    valid=cases.can_be_corrected,
    figure=steps_figure,
)

CHECKS = (
    Lengths(
        id="avance_exemples",
        title="L'avance : tout droit, en arrière, sur place, un quart de tour",
        points=3,
        cases=cases.ways_by_hand,
        hint="De combien la corde d'un quart de tour est-elle tournée ? Que vaut l'avance d'un robot qui recule ?",
    ),
    Lengths(
        id="avance_quelconque",
        title="L'avance : des pas quelconques",
        points=2,
        cases=cases.any_ways,
        hint="Votre avance change-t-elle si le robot glisse en travers de la corde ?",
    ),
    Fits(
        id="constantes_exemples",
        title="Les trois constantes : quand elles expliquent tout",
        points=4,
        cases=cases.journeys_by_hand,
        hint="Que doivent valoir les constantes si les vrais pas sont ceux que le robot a comptés ?",
    ),
    Fits(
        id="constantes_hasard",
        title="Les trois constantes : quand il reste du hasard",
        points=3,
        cases=cases.slipping_journeys,
        hint="De quelle somme de carrés chaque constante est-elle le minimum ? Que vaut sa dérivée ?",
    ),
    Corrections(
        id="corriger_exemples",
        title="Corriger : une constante à la fois",
        points=3,
        cases=cases.corrections_by_hand,
        hint="Un robot qui croyait aller tout droit tournait : sa corde est-elle encore devant lui ?",
    ),
    Corrections(
        id="corriger_quelconque",
        title="Corriger : des pas et des constantes quelconques",
        points=2,
        cases=cases.any_corrections,
        hint="Est-ce l'avance comptée, ou l'avance corrigée, que multiplie α ?",
    ),
    Trial(
        id="intel",
        title="Et en vrai : l'odométrie du laboratoire d'Intel",
        points=2,
        functions=(*FIT, *CORRECT),
        protocol=through_the_laboratory,
        hint="Vos deux fonctions rangent-elles les trois constantes dans le même ordre ?",
    ),
    Untouched(
        id="arguments",
        title="Les tableaux donnés restent intacts",
        points=1,
        functions=(*WAYS, *FIT, *CORRECT),
        names={"avance": ("pas",), "etalonner": ("pas", "vrais"), "corriger": ("pas", *CONSTANTS)},
        inputs=arguments_to_keep,
        hint="L'écriture pas[:, 2] *= beta crée-t-elle un nouveau tableau, ou change-t-elle celui qui est donné ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=world.kit, probes=PROBES)
