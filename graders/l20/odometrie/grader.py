"""l20/odometrie: one step of a robot on two wheels, and how far its turn may be off (the course's odometry formula)."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from graders.core.code.checks import Cases, Trial, Untouched
from graders.core.code.exercise import code
from graders.core.compare.comparison import ScalarCloseTo
from graders.core.compare.shrinking import shrink_number
from graders.core.contract.findings import FigureData
from graders.core.contract.values import Arguments, Floats, Value
from graders.l20 import world
from graders.l20.odometrie import cases
from graders.l20.odometrie.contract import CONTRACTS
from graders.l20.odometrie.journey import NAMES, drive_on
from graders.l20.odometrie.probes import PROBES
from graders.robotics.poses import SamePose, shrink_pose
from reference.odometry import DifferentialDrive

STEP = ("odometrie",)
SPREAD = ("sigma_dtheta",)


def right_step(pose: Floats, ds_g: float, ds_d: float, L: float) -> Floats:
    return DifferentialDrive(L).step(pose, ds_g, ds_d)


def right_spread(sigma_g: float, sigma_d: float, L: float) -> float:
    """The two wheels of `DifferentialDrive` have one sigma: that of which twice the square is the sum of the two."""
    return DifferentialDrive(L, sigma=math.hypot(sigma_g, sigma_d) / math.sqrt(2.0)).turn_deviation(0.0, 0.0)


def step_figure(args: Arguments, expected: Value, got: Floats | None) -> FigureData:
    return {"kind": "step", "start": args[0], "track": args[3], "expected": expected, "got": got}


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    return {"odometrie": next(cases.any_steps(rng))}


Steps = partial(
    Cases,
    functions=STEP,
    names=NAMES,
    expected=right_step,
    shrinkers=(shrink_pose, shrink_number, shrink_number, shrink_number),
    figure=step_figure,
)
Spreads = partial(
    Cases,
    functions=SPREAD,
    names=("sigma_g", "sigma_d", "L"),
    expected=right_spread,
    compare=ScalarCloseTo(),
    shrinkers=(shrink_number,) * 3,
    valid=cases.is_spread,
)

CHECKS = (
    Steps(
        id="exemples",
        title="Un pas : tout droit, sur place, en virage",
        points=4,
        cases=cases.simple_steps,
        compare=SamePose(any_turn=True),
        valid=cases.stays,
        hint="Le robot est en (0, 0) et regarde vers l'est. Seule sa roue droite avance : de quel côté tourne-t-il, et "
        "où se retrouve le milieu de son essieu ?",
    ),
    Steps(
        id="quelconques",
        title="Des pas quelconques, en marche arrière aussi",
        points=4,
        cases=cases.steps_all_round,
        compare=SamePose(any_turn=True),
        valid=cases.is_step,
        hint="Affichez Δs, Δθ et le cap du milieu, et refaites le calcul à la main. Lequel des trois diffère ?",
    ),
    Steps(
        id="tours",
        title="Le cap revient dans ]−π, π]",
        points=3,
        cases=cases.turning_steps,
        compare=SamePose(heading_only=True),
        valid=cases.wraps,
        hint="Un robot de cap 170° tourne encore de 20° vers la gauche : comment s'écrit son nouveau cap ?",
    ),
    Trial(
        id="trajet",
        title="Un trajet : des pas mis bout à bout",
        points=2,
        functions=STEP,
        protocol=drive_on,
        hint="Chaque pas part de la pose que votre fonction a renvoyée au pas précédent. Au premier pas faux, quel est "
        "le cap du robot ? Se souvient-elle de quelque chose d'un appel à l'autre ?",
    ),
    Spreads(
        id="sigma_exemples",
        title="L'écart-type de Δθ : des nombres simples",
        points=3,
        cases=cases.simple_spreads,
        hint="Deux erreurs indépendantes de 3 mm et de 4 mm : quel est l'écart-type de leur différence ? Est-ce 1, 5 "
        "ou 7 mm ?",
    ),
    Spreads(
        id="sigma_quelconques",
        title="L'écart-type de Δθ : des nombres quelconques",
        points=3,
        cases=cases.any_spreads,
        hint="Par quel nombre la formule de Δθ multiplie-t-elle chaque chemin ? Et chaque variance ?",
    ),
    Untouched(
        id="arguments",
        title="La pose donnée reste intacte",
        points=1,
        functions=STEP,
        names={"odometrie": NAMES},
        inputs=arguments_to_keep,
        hint="L'écriture pose += … crée-t-elle un nouveau tableau, ou change-t-elle celui qui est donné ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=world.kit, probes=PROBES)
