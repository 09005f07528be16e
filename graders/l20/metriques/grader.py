"""l20/metriques: how far an estimated trajectory is from the true one, by its shape (ATE) and by its steps (RPE)."""

from __future__ import annotations

from functools import partial

import numpy as np

from graders.core.code.checks import Cases, Trial, Untouched
from graders.core.code.exercise import code
from graders.core.compare.comparison import ScalarCloseTo
from graders.core.compare.shrinking import keep_unchanged
from graders.core.contract.values import Arguments
from graders.l20 import world
from graders.l20.metriques import cases
from graders.l20.metriques.contract import CONTRACTS
from graders.l20.metriques.frames import NAMES, tellings, told_elsewhere
from graders.l20.metriques.pictures import absolute_figure, relative_figure
from graders.l20.metriques.probes import PROBES

ATE = ("ate",)
RPE = ("rpe",)


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    estimate, truth = cases.walk(rng, 6)
    return {"ate": (estimate, truth), "rpe": (estimate, truth, 2)}


Absolute = partial(
    Cases,
    functions=ATE,
    names=NAMES[:2],
    expected=cases.right_ate,
    compare=ScalarCloseTo(),
    shrinkers=(cases.shrink_positions,) * 2,
    figure=absolute_figure,
)
Relative = partial(
    Cases,
    functions=RPE,
    names=NAMES,
    expected=cases.right_rpe,
    compare=ScalarCloseTo(),
    shrinkers=(cases.shrink_trajectory, cases.shrink_trajectory, keep_unchanged),
    valid=cases.is_on_the_move,
    figure=relative_figure,
)

CHECKS = (
    Absolute(
        id="ate_exemples",
        title="ATE : de petites trajectoires",
        points=4,
        cases=cases.small_pairs,
        valid=cases.is_pair,
        hint="Sur l'exemple de l'énoncé, où arrive chaque coin du rectangle une fois aligné ? À quelle distance du "
        "coin du carré ?",
    ),
    Absolute(
        id="ate_quelconques",
        title="ATE : des trajectoires quelconques, dans des repères quelconques",
        points=4,
        cases=cases.any_pairs,
        valid=cases.is_pair,
        hint="Tracez vos deux trajectoires après votre alignement : se superposent-elles au mieux ? Quelle moyenne "
        "prenez-vous des distances ?",
    ),
    Absolute(
        id="ate_miroir",
        title="ATE : une trajectoire en miroir",
        points=2,
        cases=cases.mirrored_pairs,
        valid=cases.is_mirrored_pair,
        hint="Le robot a pris sa gauche pour sa droite. Un mouvement peut-il effacer cette faute ? Que vaut le "
        "déterminant de votre matrice ?",
    ),
    Relative(
        id="rpe_un_pas",
        title="RPE : d'une pose à la suivante",
        points=3,
        cases=cases.single_steps,
        hint="Un robot avance d'un mètre vers le nord, la vérité dit un mètre vers l'est : s'est-il trompé sur le "
        "déplacement, tel que lui le voit ?",
    ),
    Relative(
        id="rpe_delta",
        title="RPE : sur plusieurs pas",
        points=4,
        cases=cases.longer_steps,
        hint="Pour quatre poses et delta = 2, quelles sont les paires (i, i + delta) ? Combien y en a-t-il ?",
    ),
    Trial(
        id="reperes",
        title="Les mêmes trajectoires, racontées dans d'autres repères",
        points=2,
        functions=(*ATE, *RPE),
        protocol=told_elsewhere,
        asks=tellings,
        no_more=True,
        hint="Si l'on tourne et décale toute la trajectoire estimée, le robot s'est-il trompé davantage ?",
    ),
    Untouched(
        id="arguments",
        title="Les trajectoires données restent intactes",
        points=1,
        functions=(*ATE, *RPE),
        names={"ate": NAMES[:2], "rpe": NAMES},
        inputs=arguments_to_keep,
        hint="L'écriture estimees[:, :2] donne une vue du tableau reçu : y écrire le modifie. Où écrivez-vous ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=world.kit, probes=PROBES)
