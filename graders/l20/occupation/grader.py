"""l20/occupation: log-odds and probabilities, and an occupancy grid that takes in one scan more (course session 2).

No check draws lots that an honest program could lose: what is judged of a scan is what every reading of the contract
agrees on (`cells`), so that the probability of refusing one is that of a corner met within 1e-9 by a drawn ray.
"""

from __future__ import annotations

import numpy as np

from graders.core.code.checks import Trial, Untouched
from graders.core.code.exercise import code
from graders.core.contract.values import Arguments
from graders.l20 import world
from graders.l20.occupation import cases
from graders.l20.occupation.checks import FUNCTION, FUNCTIONS, NAMES, Integrations
from graders.l20.occupation.contract import CONTRACTS
from graders.l20.occupation.drive import SHAPE, drive
from graders.l20.occupation.odds import NAMES as ODDS_NAMES
from graders.l20.occupation.odds import ODDS
from graders.l20.occupation.probes import PROBES


def arguments_to_keep(rng: np.random.Generator) -> dict[str, Arguments]:
    p = np.round(rng.uniform(0.1, 0.9, (2, 3)), 2)
    return {"vers_logodds": (p,), "vers_proba": (4.0 * p - 2.0,), FUNCTION: tuple(cases.to_keep(rng, SHAPE))}


CHECKS = (
    *ODDS,
    Integrations(
        id="axes",
        title="Un rayon le long d’une ligne ou d’une colonne",
        points=3,
        functions=FUNCTIONS,
        cases=cases.along_axes,
        kit=cases.SMALL,
        hint="Le rayon part vers la gauche et s’arrête pile sur le trait x = 3 : de quel côté du trait est le mur ?",
    ),
    Integrations(
        id="obliques",
        title="Un rayon oblique",
        points=3,
        functions=FUNCTIONS,
        cases=cases.aslant,
        kit=cases.SMALL,
        hint="Dessinez la grille et le rayon : quelles cases traverse-t-il, et dans quel ordre ? "
        "Votre code les visite-t-il toutes, une seule fois ?",
    ),
    Integrations(
        id="portee",
        title="Un rayon qui lit la portée n’a touché aucun mur",
        points=2,
        functions=FUNCTIONS,
        cases=cases.at_the_range,
        kit=cases.SMALL,
        hint="Que sait-on de la case où finit un rayon qui n’a rien rencontré ? Et de celles qu’il a traversées ?",
    ),
    Integrations(
        id="bornes",
        title="Une grille déjà remplie : les valeurs s’ajoutent, et restent entre −5 et 5",
        points=2,
        functions=FUNCTIONS,
        cases=cases.at_the_bounds,
        kit=cases.SMALL,
        hint="Une case vaut 4,9 et un rayon s’y arrête : que doit-elle valoir ? Et une case à −4,8 que l’on traverse ?",
    ),
    Integrations(
        id="bord",
        title="Un rayon qui sort de la grille",
        points=1,
        functions=FUNCTIONS,
        cases=cases.over_the_edge,
        kit=cases.SMALL,
        hint="Si la case d’arrêt est en colonne −1, à quelle case Python l’écrit-il ? Et que vaut int(-0.2) ?",
    ),
    Integrations(
        id="scan",
        title="Des scans entiers dans une petite salle",
        points=2,
        functions=FUNCTIONS,
        cases=cases.whole_scans,
        kit=cases.ROOM_KIT,
        hint="Avec quatre rayons et un cap nul, vers où pointe le rayon numéro 1 ? Où votre code l’envoie-t-il ?",
    ),
    Trial(
        id="carte",
        title="La carte du module, scan après scan",
        points=1,
        functions=FUNCTIONS,
        protocol=drive,
        hint="Regardez le film de votre carte : à quel scan, et dans quelle case, s’écarte-t-elle de l’autre ?",
    ),
    Untouched(
        id="arguments",
        title="Les tableaux donnés restent intacts",
        points=1,
        functions=("vers_logodds", "vers_proba", FUNCTION),
        names={**ODDS_NAMES, FUNCTION: NAMES},
        inputs=arguments_to_keep,
        hint="Faut-il écrire dans la grille reçue, ou dans une copie : l.copy() ?",
    ),
)

DEFINITION = code(__file__, checks=CHECKS, contracts=CONTRACTS, kit=world.kit, probes=PROBES)
