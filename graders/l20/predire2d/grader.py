"""l20/predire2d: Markov localisation on the grid, with a robot that slips (course, self-graded exercise 1)."""

from __future__ import annotations

import numpy as np

from graders.core.code.checks import Trial, Untouched
from graders.core.code.exercise import code
from graders.core.contract.values import Arguments
from graders.l20 import world
from graders.l20.predire2d import cases
from graders.l20.predire2d.beliefs import SameLikeliest, SameShares, SumsToOne, spread
from graders.l20.predire2d.checks import NAMES, OnGrid, OnGridBeside
from graders.l20.predire2d.contract import CONTRACTS
from graders.l20.predire2d.probes import PROBES
from graders.l20.predire2d.trials import localise

PREDICT = ("predire2d",)
CORRECT = ("corriger2d",)


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    grid = cases.module_world()
    du, dv = cases.MOVES[int(rng.integers(len(cases.MOVES)))]
    scan = grid.scans[cases.pick(rng, grid.free)]
    return {"predire2d": (spread(rng, grid.free), du, dv), "corriger2d": (spread(rng, grid.free), scan, 0.5)}


CHECKS = (
    OnGrid(
        id="predire_exemples",
        title="Prédire loin des murs",
        points=3,
        functions=PREDICT,
        cases=cases.open_moves,
        hint="Le robot est en (y, x) = (2, 3) et avance d'une case selon x : sur quelles trois cases peut-il tomber ?",
    ),
    OnGrid(
        id="predire_murs",
        title="Prédire contre les murs et devant une porte",
        points=3,
        functions=PREDICT,
        cases=cases.moves_near_walls,
        hint="Quand une des trois arrivées est un mur, où est le robot juste après ? Où va donc sa probabilité ?",
    ),
    OnGrid(
        id="predire_autre_carte",
        title="Prédire au bord d'une autre carte, et à l'arrêt",
        points=3,
        functions=PREDICT,
        cases=cases.moves_at_the_edge,
        draw=cases.steady_open_world,
        hint="Votre fonction se sert-elle de H, W et libres, y compris quand la grille n'est pas entourée de murs ? "
        "Que glisse un robot qui ne bouge pas ?",
    ),
    OnGridBeside(
        id="corriger_somme",
        title="Corriger : la somme vaut 1",
        points=1,
        functions=CORRECT,
        cases=cases.doubts,
        judge=SumsToOne,
        hint="Que devient la constante η de la formule de Bayes dans votre code ?",
    ),
    OnGrid(
        id="corriger_maximum",
        title="Corriger : la case qui explique le mieux le scan est la plus probable",
        points=1,
        functions=CORRECT,
        cases=cases.plain_doubts,
        judge=SameLikeliest,
        hint="Que lirait le lidar placé au centre de chacune des deux cases ? Laquelle ressemble le plus au scan ?",
    ),
    OnGrid(
        id="corriger_exemples",
        title="Corriger : deux hypothèses voisines, leurs probabilités à un facteur près",
        points=2,
        functions=CORRECT,
        cases=cases.doubts,
        judge=SameShares,
        hint="Pour deux cases, combien vaut le rapport de leurs vraisemblances, à la main ? Et selon votre code ?",
    ),
    OnGrid(
        id="corriger_autre_carte",
        title="Corriger : croyances et scans bruités sur une autre carte, à un facteur près",
        points=2,
        functions=CORRECT,
        cases=cases.noisy_scans,
        draw=cases.open_world,
        judge=SameShares,
        hint="Écrivez l'exposant pour un seul rayon d'écart 1, puis pour quatre : retrouvez-vous celui de l'énoncé ?",
    ),
    OnGrid(
        id="sigma_par_defaut",
        title="Corriger : sigma vaut 0,5 quand on ne le donne pas",
        points=1,
        functions=CORRECT,
        cases=cases.without_sigma,
        judge=SameShares,
        hint="Comment écrit-on, dans la ligne « def », la valeur que prend un paramètre absent ?",
    ),
    Trial(
        id="localisation",
        title="Localiser un robot perdu, en huit pas",
        points=3,
        functions=(*PREDICT, *CORRECT),
        protocol=localise,
        hint="Après chaque pas, affichez la case la plus probable : à quel moment s'éloigne-t-elle du robot ?",
    ),
    Untouched(
        id="arguments",
        title="Les tableaux donnés restent intacts",
        points=1,
        functions=(*PREDICT, *CORRECT),
        names=NAMES,
        inputs=arguments_to_keep,
        hint="Faut-il écrire dans le tableau reçu, ou en créer un nouveau ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=world.kit, probes=PROBES)
