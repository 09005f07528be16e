"""Une animation, montrée là où une page dit « ::: rejeu __NAME__ »."""

import numpy as np

from graders.scene.replay import Draw, Frame, Key, Points, Polyline, Prediction, Replay, Slider, Values, View

TITLE = "Avancer d'une fraction du chemin"
ALT = "Un point avance par petits pas sur un segment ; chaque pas est un peu faux, et l'erreur s'accumule."
#: Ce que le lecteur peut régler ; `Draw` est le tirage, qui donne sa graine à `rng`.
PARAMETERS = {
    "pas": Slider("Nombre de pas", 2, 20, 1, 10),
    "bruit": Slider("Erreur de chaque pas", 0.0, 0.5, 0.05, 0.1),
    "tirage": Draw(),
}
#: Une question posée avant de jouer ; elle peut être laissée de côté.
PREDICTION = Prediction(
    "Chaque pas est faux d'une erreur tirée au hasard. Que devient l'erreur totale ?",
    (("grandit", "Elle a tendance à grandir."), ("annule", "Elle s'annule toujours.")),
    right="grandit",
    why="Des erreurs indépendantes se compensent en partie seulement : leur écart-type grandit comme la racine du nombre de pas.",
)


def compute(values: Values, rng: np.random.Generator) -> Replay:
    """Les images : rien que d'après les réglages et `rng`, en quelques dixièmes de seconde au plus."""
    steps, noise = values.whole("pas"), values.number("bruit")
    truth = np.linspace([0.0, 0.0], [10.0, 0.0], steps + 1)
    errors = np.vstack([np.zeros(2), noise * rng.standard_normal((steps, 2))]).cumsum(axis=0)
    frames = [
        Frame(
            [
                Polyline(truth, "truth", dashed=True),
                Points(truth[step : step + 1], "truth", glide=True),
                Points((truth + errors)[step : step + 1], "estimate", glide=True),
            ],
            f"Pas {step} sur {steps}.",
        )
        for step in range(steps + 1)
    ]
    legend = [Key("dot", "truth", "où l'on devrait être"), Key("dot", "estimate", "où l'on est")]
    summary = ["Chaque erreur reste dans toutes celles qui suivent."]
    return Replay(View(-1.0, -3.0, 11.0, 3.0, up=True), frames, summary, legend=legend)
