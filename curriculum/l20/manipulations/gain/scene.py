"""Le gain de Kalman : une prédiction, une mesure, et la part de l'écart que l'on croit."""

from __future__ import annotations

import numpy as np

from graders.scene.hands import Start
from graders.scene.replay import Key, Slider, Values, View

TITLE = "Le gain de Kalman"
ALT = (
    "Un couloir de dix mètres, couché. Trois cloches s'y dressent : en tirets la prédiction, centrée en 5 mètres ; en "
    "vert la mesure, que l'on déplace ; en orange la croyance corrigée, entre les deux et plus haute que chacune. Sous "
    "l'axe, un trait va de la prédiction à la mesure : un point y marque la part du chemin que le gain fait parcourir."
)
PARAMETERS = {
    "prediction": Slider("Écart-type de la prédiction", 0.1, 2.0, 0.01, 1.12, "m"),
    "mesure": Slider("Écart-type de la mesure", 0.1, 2.0, 0.01, 0.5, "m"),
    "gain": Slider("Votre gain, le même à chaque pas", 0.0, 1.0, 0.01, 0.1),
}
LENGTH, PREDICTED, MEASURED = 10.0, 5.0, 5.6
#: L'écart-type d'un déplacement, en mètres, avant chacune des mesures qui suivent la première.
MOVE = 0.5
STEPS, SEED = 20, 8


def draws() -> dict[str, list[float]]:
    """Les nombres centrés réduits du trajet que l'on montre : l'erreur au départ, puis les bruits de chaque pas."""
    rng = np.random.default_rng(SEED)
    moves, readings = rng.normal(size=STEPS), rng.normal(size=STEPS)
    return {"moves": np.round(moves, 4).tolist(), "readings": np.round(readings, 4).tolist()}


def compute(values: Values, rng: np.random.Generator) -> Start:
    return Start(
        View(0.0, -1.5, LENGTH, 3.9, up=True),
        {"predicted": PREDICTED, "measured": MEASURED, "length": LENGTH, "move": MOVE, **draws()},
        [
            Key("dashed", "second", "prédiction"),
            Key("line", "measure", "mesure"),
            Key("line", "estimate", "croyance corrigée"),
        ],
    )
