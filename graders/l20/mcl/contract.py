"""What is promised of `initialiser`, `pas_mcl` and `estimer`; l20/defi_kidnappe asks for the same functions."""

from __future__ import annotations

import numpy as np

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.compound_forms import TupleForm
from graders.core.compare.forms import WHOLE, ArrayForm, array, power_text
from graders.core.compare.words import number
from graders.l20.mcl.answers import MOST, SUM_TOLERANCE
from graders.l20.mcl.steps import FEWEST_DISTINCT, FILLS, STILL_SCANS, WIDE, WINS

PARTICLES = ArrayForm(shape=("n", 3), called="des particules")
WEIGHTS = array("n")
AFTER = TupleForm(
    parts={"particules": ArrayForm(shape=("m", 3), called="des particules"), "poids": array("m")},
    precision=f"Les poids sont positifs, de somme 1 à {power_text(SUM_TOLERANCE)} près ; m va jusqu’à {MOST}. Des "
    f"particules confondues se dispersent : au moins {FEWEST_DISTINCT} poses différentes, mais la moitié d’entre elles "
    f"à moins de {number(WIDE)}, en cases et en radians, de l’endroit où mène le déplacement. Le nuage qui explique le "
    f"scan finit avec plus de {100 * WINS:.0f} % du poids ; après {STILL_SCANS} scans sans bouger, le bon groupe a "
    f"plus de {100 * FILLS:.0f} % des particules.",
)
ESTIMATE = ArrayForm(shape=(3,), called="une pose", precision="L’angle est jugé à un tour près.")
ONCE = "est lancé une fois pour les premières vérifications, où les appels se suivent ; puis pour chaque essai."


LOST = Boundary(
    "un nuage si loin du robot que toutes les vraisemblances s’annulent",
    free="il n’est pas jugé à part ; une somme de logarithmes garde pourtant les poids de somme 1",
)


def contracts(relaunched: str, *of_step: Boundary) -> tuple[FunctionContract, ...]:
    """Return what is promised of the three functions of a particle filter; `of_step` are more boundaries of a step."""
    return (
        FunctionContract("initialiser", {"n": WHOLE}, PARTICLES, (), relaunched),
        FunctionContract(
            "pas_mcl",
            {"particules": PARTICLES, "poids": WEIGHTS, "u": array(3), "scan": array(36)},
            AFTER,
            (
                Boundary("des particules toutes confondues", lambda p, w, u, z: (np.ptp(p, axis=0) == 0.0).all()),
                Boundary("le rééchantillonnage", free="à chaque pas, ou quand N_eff est petit ; la méthode est libre"),
                Boundary("le cap d’une particule", free="ramené dans ]−π, π], ou non"),
                Boundary("une particule hors de la carte, ou dans un mur", free="elle peut y rester, ou en être ôtée"),
                *of_step,
            ),
            relaunched,
        ),
        FunctionContract(
            "estimer",
            {"particules": PARTICLES, "poids": WEIGHTS},
            ESTIMATE,
            (Boundary("la moyenne, ou la meilleure particule", free="les nuages jugés les mettent d’accord"),),
            relaunched,
        ),
    )


CONTRACTS = contracts(ONCE, LOST)
