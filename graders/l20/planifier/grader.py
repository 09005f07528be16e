"""l20/planifier: where a robot with a radius may be, and a cheapest path there.

Nothing is left to chance: any of the cheapest paths is right, and no radius is near a distance between two cells.
"""

from __future__ import annotations

from functools import partial
from itertools import islice

import numpy as np

from graders.core.code.checks import Cases, Untouched
from graders.core.code.exercise import code
from graders.core.compare.comparison import CloseTo, ScalarCloseTo
from graders.core.compare.shrinking import keep_unchanged
from graders.core.contract.values import Arguments
from graders.l20 import world
from graders.l20.planifier import cases
from graders.l20.planifier.checks import FUNCTION, NAMES, Paths
from graders.l20.planifier.contract import CONTRACTS
from graders.l20.planifier.pictures import cells_figure
from graders.l20.planifier.probes import PROBES
from graders.l20.planifier.shrinkers import shrink_grid, shrink_path, shrink_prices
from graders.l20.planifier.truth import right_permitted, right_price

INFLATE, PRICE, PLAN = ("gonfler",), ("cout",), (FUNCTION,)
GRID = ("grille", "rayon", "resolution")
PATH = ("chemin", "couts")


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    return {
        "gonfler": next(islice(cases.inflations_by_hand(rng), 1, None)),
        "cout": next(islice(cases.paths_to_price(rng), 5, None)),
        FUNCTION: next(islice(cases.cheapest(rng), 3, None)),
    }


def other_arguments(rng: np.random.Generator) -> dict[str, Arguments]:
    return {
        "gonfler": next(islice(cases.inflations_by_hand(rng), 2, None)),
        "cout": next(islice(cases.paths_to_price(rng), 3, None)),
        FUNCTION: next(islice(cases.cheapest(rng), 5, None)),
    }


Inflations = partial(
    Cases,
    functions=INFLATE,
    names=GRID,
    expected=right_permitted,
    compare=CloseTo(),
    shrinkers=(shrink_grid, keep_unchanged, keep_unchanged),
    valid=cases.is_radius,
    figure=cells_figure,
)

CHECKS = (
    Inflations(
        id="gonfler_exemples",
        title="Gonfler : quelques murs, une case inconnue",
        points=3,
        cases=cases.inflations_by_hand,
        hint="Pour la case fautive : à combien de mètres est le mur le plus proche ? Et qu'est-ce qui l'interdit ?",
    ),
    Inflations(
        id="gonfler_quelconques",
        title="Gonfler : des cartes et des rayons quelconques",
        points=3,
        cases=cases.inflations,
        hint="La ligne tracée autour d'un mur seul est-elle un cercle, un carré, un losange ?",
    ),
    Cases(
        id="cout",
        title="Le prix d'un chemin",
        points=4,
        functions=PRICE,
        names=PATH,
        cases=cases.paths_to_price,
        expected=right_price,
        compare=ScalarCloseTo(),
        shrinkers=(shrink_path, shrink_prices),
        hint="Un seul pas en diagonale, entre deux cases de coût 1 : que dit la formule, et que renvoyez-vous ?",
    ),
    Paths(
        id="plus_court",
        title="Sans coût : le plus court chemin",
        points=4,
        functions=PLAN,
        cases=cases.shortest,
        hint="Sur la figure, suivez votre chemin case par case : où quitte-t-il le meilleur, et en a-t-il le droit ?",
    ),
    Paths(
        id="moins_cher",
        title="Avec des coûts : le chemin le moins cher",
        points=3,
        functions=PLAN,
        cases=cases.cheapest,
        hint="Calculez le prix de votre chemin. Une case déjà vue peut-elle être atteinte à meilleur prix ?",
    ),
    Paths(
        id="sans_chemin",
        title="Pas de chemin, ou un chemin d'une seule case",
        points=2,
        functions=PLAN,
        cases=cases.without_a_path,
        hint="Que fait votre boucle quand plus aucune case n'attend ? Et quand le départ n'est pas permis ?",
    ),
    Untouched(
        id="arguments",
        title="Les tableaux donnés restent intacts",
        points=1,
        functions=(*INFLATE, *PRICE, *PLAN),
        names={"gonfler": GRID, "cout": PATH, FUNCTION: NAMES},
        inputs=arguments_to_keep,
        then=other_arguments,
        hint="L'écriture permises[i, j] = False change le tableau de celui qui appelle : en faut-il une copie ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, kit=world.kit, contracts=CONTRACTS, probes=PROBES)
