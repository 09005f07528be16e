"""La chaîne élastique : n maillons incertains, une fermeture, et ce que chacun cède."""

from __future__ import annotations

import numpy as np

from graders.scene.hands import Start
from graders.scene.replay import Key, Slider, Values, View

TITLE = "La chaîne élastique"
ALT = (
    "Deux rails, l'un sous l'autre. Sur le premier, une chaîne de poses que rien ne tient au bout : une bande, de plus "
    "en plus large, montre l'écart-type de chaque pose, et un repère dit où la fermeture place la dernière. Sur le "
    "second, la chaîne fermée : les poses ont glissé vers le repère, et la bande s'est refermée à son extrémité."
)
PARAMETERS = {
    "n": Slider("Maillons n", 2, 100, 1, 20),
    "sigma": Slider("Écart-type d'un maillon σ", 1, 20, 1, 10, "cm"),
    "borne": Slider("Écart-type de la fermeture σ_{b}", 1, 60, 1, 10, "cm"),
}
LENGTH, REACH, GAP = 10.0, 2.0, 1.0


def compute(values: Values, rng: np.random.Generator) -> Start:
    return Start(
        View(-1.0, 0.0, LENGTH + 3.0, 8.6),
        {"length": LENGTH, "reach": REACH, "gap": GAP, "rows": [2.1, 6.3]},
        [
            Key("dot", "estimate", "pose de la chaîne"),
            Key("line", "second", "± un écart-type, à l'échelle du rail"),
            Key("line", "alert", "ce que dit la fermeture"),
            Key("line", "measure", "ce dont une pose a glissé"),
        ],
    )
