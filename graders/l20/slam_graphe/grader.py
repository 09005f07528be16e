"""l20/slam_graphe: the error of an edge, and a pose graph brought to its optimum by Gauss-Newton."""

from __future__ import annotations

from functools import partial

import numpy as np

from graders.core.code.checks import Untouched
from graders.core.code.exercise import code
from graders.core.contract.values import Arguments
from graders.l20 import world
from graders.l20.slam_graphe import asked, residual
from graders.l20.slam_graphe.contract import CONTRACTS
from graders.l20.slam_graphe.optimum import Optimum
from graders.l20.slam_graphe.probes import PROBES
from graders.l20.slam_graphe.residual import SameError, errors

GAUSS_NEWTON = ("gauss_newton",)


def arguments_to_keep(rng: np.random.Generator, number: int = 0) -> dict[str, Arguments]:
    graph = asked.always(asked.weighted_by_hand)[number]
    return {"erreur": residual.untouched_edge(rng), "gauss_newton": tuple(graph.inputs.values())}


CHECKS = (
    errors(
        id="erreur_exemples",
        title="L'erreur d'une arête : des nombres entiers et des quarts de tour",
        points=3,
        cases=residual.simple_edges,
        compare=SameError(any_turn=True),
        valid=residual.stays,
        hint="Où le robot placé en xi voit-il la pose xj, dans son propre repère ? Qu'annonçait la mesure z ?",
    ),
    errors(
        id="erreur_hasard",
        title="L'erreur d'une arête : des poses au hasard",
        points=2,
        cases=residual.random_edges,
        compare=SameError(any_turn=True),
        valid=residual.stays,
        hint="Votre erreur est-elle nulle quand xj est là où la mesure la place, quel que soit le cap de xi ?",
    ),
    errors(
        id="erreur_tours",
        title="L'erreur d'une arête : l'angle revient dans ]−π, π]",
        points=2,
        cases=residual.wrapping_edges,
        compare=SameError(angle_only=True),
        valid=residual.wraps,
        hint="Deux caps de 170° et de −170° : de combien diffèrent-ils vraiment ? Et que donne leur soustraction ?",
    ),
    Optimum(
        id="chaine",
        title="Une chaîne sans boucle : toutes les mesures sont satisfaites",
        points=2,
        functions=GAUSS_NEWTON,
        graphs=asked.chains,
        hint="Avec deux poses et une seule mesure, où doit finir la seconde pose ? Que vaut alors l'erreur ?",
    ),
    Optimum(
        id="boucle",
        title="Une boucle qui ne se referme pas tout à fait",
        points=4,
        functions=GAUSS_NEWTON,
        graphs=asked.loops,
        hint="Trois arêtes de même poids se contredisent de 3 au total : quelle part chacune doit-elle céder ?",
    ),
    Optimum(
        id="poids",
        title="Des mesures plus sûres que d'autres",
        points=2,
        functions=GAUSS_NEWTON,
        graphs=asked.weighted,
        hint="Si l'une des mesures est deux fois plus sûre (Ω double), qui doit céder le plus ? Où Ω entre-t-elle ?",
    ),
    Optimum(
        id="demi_tour",
        title="Des caps qui passent par le demi-tour",
        points=2,
        functions=GAUSS_NEWTON,
        graphs=asked.turning,
        hint="Après la correction, un cap peut dépasser π : que faut-il en faire ? Et dans l'erreur d'une arête ?",
    ),
    Optimum(
        id="grande_boucle",
        title="Une grande boucle, avec n_iter ou sans",
        points=2,
        functions=GAUSS_NEWTON,
        graphs=asked.large,
        hint="χ² diminue-t-il à chaque itération ? Affichez-le : il doit se stabiliser en quelques tours.",
    ),
    Untouched(
        id="arguments",
        title="Les poses et les mesures données restent intactes",
        points=1,
        functions=("erreur", "gauss_newton"),
        names={"erreur": residual.NAMES, "gauss_newton": ("poses", "aretes", "n_iter")},
        inputs=arguments_to_keep,
        then=partial(arguments_to_keep, number=1),
        hint="Votre boucle écrit-elle dans le tableau poses reçu, ou dans une copie ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=world.kit, probes=PROBES)
