"""l20/defi_amers: the normal equations of poses and landmarks together, and the map that they lead to."""

from __future__ import annotations

from functools import partial

import numpy as np

from graders.core.code.checks import Untouched
from graders.core.code.exercise import code
from graders.core.contract.values import Arguments
from graders.l20 import world
from graders.l20.defi_amers import asked
from graders.l20.defi_amers.contract import CONTRACTS
from graders.l20.defi_amers.optimum import Optimum
from graders.l20.defi_amers.probes import PROBES
from graders.l20.defi_amers.system import Systems, judge_links

SYSTEM, SLAM = ("systeme",), ("slam_amers",)
NAMES = ("poses", "amers", "aretes", "observations")


def arguments_to_keep(rng: np.random.Generator, number: int = 2) -> dict[str, Arguments]:
    one = asked.turning_by_hand()[number]  # one that never changes: whoever holds no pose raises there, or does not
    return {"systeme": tuple(one.at.values()), "slam_amers": tuple(one.inputs.values())}


CHECKS = (
    Systems(
        id="systeme_aretes",
        title="H : les blocs entre deux poses, où n'entrent que les arêtes",
        points=2,
        functions=SYSTEM,
        maps=asked.linked_systems,
        judge=judge_links,
        hint="Une arête relie deux poses : quels blocs de H change-t-elle, et avec quelles jacobiennes ?",
    ),
    Systems(
        id="systeme_exemples",
        title="H et b : deux poses, une balise, des nombres entiers",
        points=2,
        functions=SYSTEM,
        maps=asked.systems,
        hint="Une observation touche la pose qui voit et l'amer qui est vu : quels blocs de H changent ?",
    ),
    Systems(
        id="systeme_hasard",
        title="H et b : des poses, des balises et des poids quelconques",
        points=3,
        functions=SYSTEM,
        maps=asked.random_systems,
        hint="Vos jacobiennes sont-elles égales aux différences finies, colonne par colonne ? Et où Ω entre-t-elle ?",
    ),
    Systems(
        id="systeme_tours",
        title="H et b : l'angle d'une arête revient dans ]−π, π]",
        points=2,
        functions=SYSTEM,
        maps=asked.wrapping_systems,
        hint="Deux caps de 170° et de −170° : de combien diffèrent-ils vraiment ? Et dans votre erreur ?",
    ),
    Optimum(
        id="exact",
        title="Des mesures qui s'accordent : la carte les satisfait toutes",
        points=2,
        functions=SLAM,
        maps=asked.exact,
        hint="Avec une seule observation, où doit finir la balise ? Que vaut alors l'erreur ?",
    ),
    Optimum(
        id="partage",
        title="Des mesures qui se contredisent : chacune cède sa part",
        points=3,
        functions=SLAM,
        maps=asked.shared,
        hint="Trois mesures de même poids se contredisent de 3 : quelle part chacune doit-elle céder ?",
    ),
    Optimum(
        id="poids",
        title="Des observations plus sûres que d'autres",
        points=2,
        functions=SLAM,
        maps=asked.weighted,
        hint="Si une observation est deux fois plus sûre, cède-t-elle plus ou moins que les autres ?",
    ),
    Optimum(
        id="demi_tour",
        title="Des caps qui passent par le demi-tour",
        points=1,
        functions=SLAM,
        maps=asked.turning,
        hint="Après la correction, un cap peut dépasser π : que faut-il en faire ? Et les amers, ont-ils un cap ?",
    ),
    Optimum(
        id="tour",
        title="Le tour de vingt poses et huit balises, avec n_iter ou sans",
        points=2,
        functions=SLAM,
        maps=asked.tours,
        hint="χ² diminue-t-il à chaque itération ? Affichez-le : il doit se stabiliser en quelques tours.",
        filmed=True,
    ),
    Untouched(
        id="arguments",
        title="Les poses, les amers et les mesures donnés restent intacts",
        points=1,
        functions=("systeme", "slam_amers"),
        names={"systeme": NAMES, "slam_amers": (*NAMES, "n_iter")},
        inputs=arguments_to_keep,
        then=partial(arguments_to_keep, number=0),
        hint="Votre boucle écrit-elle dans les tableaux reçus, ou dans des copies ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=world.kit, probes=PROBES)
