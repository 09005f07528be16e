"""What is promised of `predire2d` and `corriger2d`."""

from __future__ import annotations

from graders.core.code.contracts import Boundary, FunctionContract
from graders.core.compare.comparison import TOLERANCE
from graders.core.compare.forms import NUMBER, WHOLE, ArrayForm, array, power_text

BELIEF = ArrayForm(
    shape=("H", "W"),
    called="une croyance",
    precision=f"Chaque case et la somme à {power_text(TOLERANCE)} près, dans l’absolu : un calcul en float32 ne suffit "
    "pas.",
)
RELAUNCHED = "est relancé sur une autre carte (H, W, libres et lidar changent ensemble) ; jamais entre deux pas."

CONTRACTS = (
    FunctionContract(
        "predire2d",
        {"bel": BELIEF, "du": WHOLE, "dv": WHOLE},
        BELIEF,
        (
            Boundary("un robot qui ne bouge pas", lambda bel, du, dv: du == dv == 0),
            Boundary("toute la croyance dans une seule case", lambda bel, du, dv: bel.max() == 1.0),
            Boundary("un robot au bord d’une carte sans murs", lambda bel, du, dv: bel[:, 0].max() == 1.0 and du < 0),
        ),
        RELAUNCHED,
    ),
    FunctionContract(
        "corriger2d",
        {"bel": BELIEF, "scan_obs": array(4), "sigma": NUMBER},
        BELIEF,
        (
            Boundary("deux cases aussi vraisemblables l’une que l’autre", lambda bel, z, *s: (bel > 0).sum() == 3),
            Boundary("des rayons qui lisent la portée", lambda bel, z, *s: bool((z == 12.0).any())),
            Boundary(
                "un scan qu’aucune case de la croyance n’explique (toutes les vraisemblances à 0)",
                free="il n’est pas demandé",
            ),
        ),
        RELAUNCHED,
    ),
)
