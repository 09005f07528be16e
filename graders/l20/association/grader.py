"""l20/association: which landmark each measurement is of, one by one and then all together; which ones are new.

Nothing hangs on a tie: no distance is near its threshold, and no two choices are as near.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from graders.core.code.checks import Cases, Untouched
from graders.core.code.exercise import code
from graders.core.compare.comparison import CloseTo, SameIndices
from graders.core.compare.shrinking import keep_unchanged, shrink_array
from graders.core.contract.values import Arguments, Value
from graders.l19.matrices import shrink_noise
from graders.l20 import world
from graders.l20.association import cases
from graders.l20.association.contract import CONTRACTS
from graders.l20.association.judge import SameAssociation
from graders.l20.association.pictures import joint_figure, scan_figure
from graders.l20.association.probes import PROBES

TABLE, NEAREST, NEW, JOINT = ("distances2",), ("associer",), ("nouveaux",), ("associer_ensemble",)
SCAN, TOGETHER = ("z", "amers", "S"), ("z", "amers", "C", "R")


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    scan = cases.steady_scan(*cases.SCANS[0])[:3]
    return {"distances2": scan, "associer": scan, "nouveaux": scan, "associer_ensemble": next(cases.joint_by_hand(rng))}


def fewer(z: Value) -> Iterator[Value]:
    """One measurement less, then simpler numbers."""
    if len(z) > 1:
        yield from (np.delete(z, k, axis=0) for k in range(len(z)))
    yield from shrink_array(z)


Tables = partial(
    Cases,
    functions=TABLE,
    names=SCAN,
    expected=cases.right_distances,
    compare=CloseTo(),
    shrinkers=(fewer, shrink_array, keep_unchanged),
    valid=lambda args: len(args[0]) > 0,
)
Scans = partial(
    Cases,
    functions=NEAREST,
    expected=cases.right_nearest,
    compare=SameAssociation(),
    valid=cases.is_clear,
    figure=scan_figure,
)
Newcomers = partial(Cases, functions=NEW, expected=cases.right_new, compare=SameIndices(), valid=cases.is_clear)
Joints = partial(
    Cases,
    functions=JOINT,
    expected=cases.right_joint,
    compare=SameAssociation(),
    valid=cases.decides,
    figure=joint_figure,
)

CHECKS = (
    Tables(
        id="distances",
        title="Les distances de chaque mesure à chaque amer",
        points=3,
        cases=cases.one_by_one,
        hint="Quelle matrice sert à la colonne k ? Que vaut d² pour un écart d'un écart-type exactement ?",
    ),
    Scans(
        id="proches_exemples",
        title="Le plus proche d'abord : deux amers, de petits nombres",
        points=3,
        names=SCAN,
        cases=cases.scans_by_hand,
        shrinkers=(fewer, shrink_array, keep_unchanged),
        hint="Quelle paire de votre tableau est la plus proche ? Est-elle dans la porte, et que reste-t-il ensuite ?",
    ),
    Scans(
        id="proches_quelconques",
        title="Le plus proche d'abord : des cartes serrées, à plusieurs niveaux",
        points=3,
        names=(*SCAN, "niveau"),
        cases=cases.any_scans,
        shrinkers=(fewer, shrink_array, keep_unchanged, keep_unchanged),
        hint="Une fois une paire prise, quelles autres paires ne sont plus permises ?",
    ),
    Newcomers(
        id="nouveaux_exemples",
        title="Les nouveaux : deux amers, de petits nombres",
        points=2,
        names=SCAN,
        cases=cases.scans_by_hand,
        shrinkers=(fewer, shrink_array, keep_unchanged),
        hint="Pour chaque mesure, à quel amer est-elle la plus proche, et cette distance passe-t-elle la porte ?",
    ),
    Newcomers(
        id="nouveaux_quelconques",
        title="Les nouveaux : des cartes serrées, à plusieurs niveaux",
        points=1,
        names=(*SCAN, "niveau"),
        cases=cases.any_scans,
        shrinkers=(fewer, shrink_array, keep_unchanged, keep_unchanged),
        hint="À combien d'amers comparez-vous chaque mesure avant de la dire nouvelle ?",
    ),
    Joints(
        id="ensemble_exemples",
        title="Toutes ensemble : l'exemple de l'énoncé, puis de petits nombres",
        points=4,
        names=TOGETHER,
        cases=cases.joint_by_hand,
        shrinkers=(fewer, shrink_array, shrink_noise, keep_unchanged),
        hint="Que vaut D² pour l'hypothèse attendue, et pour la vôtre ? À quel seuil comparez-vous chacune ?",
    ),
    Joints(
        id="ensemble_quelconques",
        title="Toutes ensemble : un robot décalé, à plusieurs niveaux",
        points=3,
        names=(*TOGETHER, "niveau"),
        cases=cases.any_joints,
        shrinkers=(fewer, keep_unchanged, keep_unchanged, keep_unchanged, keep_unchanged),
        hint="Entre deux hypothèses, laquelle préférez-vous : la plus proche, ou celle qui a le plus de paires ?",
    ),
    Untouched(
        id="arguments",
        title="Les tableaux donnés restent intacts",
        points=1,
        functions=(*TABLE, *NEAREST, *NEW, *JOINT),
        names={"distances2": SCAN, "associer": SCAN, "nouveaux": SCAN, "associer_ensemble": TOGETHER},
        inputs=arguments_to_keep,
        hint="L'écriture z -= amers[k] crée-t-elle un nouveau tableau, ou change-t-elle celui qui est donné ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=world.kit, probes=PROBES)
