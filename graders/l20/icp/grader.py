"""l20/icp: two clouds registered without knowing which point goes with which (course theorem 4).

The way of ICP is the same for every honest program, since the best motion for given pairs is unique and no case has a
tie: nothing that is drawn can refuse one. Cases are such that each iteration takes a hundredth of the error at least,
so that who stops when nothing falls any more ends at the same place. Clouds come from kept seeds (`cases.Kind`):
drawing telling ones would take longer than a verdict may.
"""

from __future__ import annotations

import numpy as np

from graders.core.code.checks import Trial, Untouched
from graders.core.code.exercise import code
from graders.core.contract.values import Arguments
from graders.l20 import world
from graders.l20.icp import cases
from graders.l20.icp.checks import FUNCTION, FUNCTIONS, NAMES, Registrations
from graders.l20.icp.contract import CONTRACTS
from graders.l20.icp.film import watch
from graders.l20.icp.judge import misjudged
from graders.l20.icp.probes import PROBES


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    return {FUNCTION: tuple(cases.FROM.made(int(rng.choice(cases.FROM.seeds))))}


CHECKS = (
    Registrations(
        id="une_iteration",
        title="Une seule itération, sans départ",
        points=2,
        functions=FUNCTIONS,
        cases=cases.one_iteration,
        hint="Faites la première itération à la main : qui est le plus proche de chaque point, et où mène le meilleur "
        "mouvement pour ces paires ?",
    ),
    Registrations(
        id="iterations",
        title="Deux itérations, puis trois, et depuis un départ",
        points=2,
        functions=FUNCTIONS,
        cases=cases.few_iterations,
        hint="Après la première itération, de quel endroit part la deuxième, et que deviennent R et t ?",
    ),
    Registrations(
        id="jusqu_au_bout",
        title="Jusqu’au bout : les mêmes points, dans un autre ordre",
        points=4,
        functions=FUNCTIONS,
        cases=cases.to_the_end,
        hint="À chaque tour, les paires sont-elles cherchées de nouveau, depuis l’endroit où P est arrivé ?",
    ),
    Registrations(
        id="depart",
        title="Un départ (R0, t0) qui décide de l’arrivée",
        points=3,
        functions=FUNCTIONS,
        cases=cases.from_a_start,
        hint="Où sont les points de P avant la première recherche des plus proches ?",
    ),
    Registrations(
        id="tailles",
        title="Des nuages de tailles différentes",
        points=2,
        functions=FUNCTIONS,
        cases=cases.of_unequal_sizes,
        hint="Qui cherche qui : chaque point de P dans Q, ou l’inverse ? Combien de paires cela fait-il ?",
    ),
    Registrations(
        id="miroir",
        title="Des paires qu’une symétrie superposerait mieux : R reste une rotation",
        points=2,
        functions=FUNCTIONS,
        cases=cases.mirrored,
        hint="Que vaut det R après chaque itération ?",
    ),
    Registrations(
        id="erreurs",
        title="La suite des erreurs : des sommes de carrés, qui ne remontent jamais",
        points=2,
        functions=FUNCTIONS,
        cases=cases.for_errors,
        judge=misjudged,
        hint="Pour l’exemple de l’énoncé, quels nombres votre fonction renvoie-t-elle ? Somme, moyenne, racine ?",
    ),
    Registrations(
        id="defaut",
        title="Sans n_iter : trente itérations",
        points=1,
        functions=FUNCTIONS,
        cases=cases.without_count,
        hint="Comment écrit-on, dans la ligne « def », la valeur que prend un paramètre absent ?",
    ),
    Trial(
        id="scans",
        title="Deux scans d’une même pièce",
        points=1,
        functions=FUNCTIONS,
        protocol=watch,
        hint="Regardez le film : à quelle itération votre nuage quitte-t-il le chemin de l’autre ?",
    ),
    Untouched(
        id="arguments",
        title="Les tableaux donnés restent intacts",
        points=1,
        functions=FUNCTIONS,
        names={FUNCTION: NAMES},
        inputs=arguments_to_keep,
        hint="L’écriture t += dt crée-t-elle un nouveau tableau, ou change-t-elle t0 ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=world.kit, probes=PROBES)
