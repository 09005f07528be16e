"""Un passant que l'on promène devant le lidar : ce qu'en disent la gaussienne et le mélange."""

from __future__ import annotations

import numpy as np

from curriculum.l20.rejeux._carte import carte, murs
from graders.scene.hands import Start
from graders.scene.replay import Key, Slider, Values, View
from reference.world.simulation import SimulatedLidar

TITLE = "Un passant devant le lidar"
ALT = (
    "Le plan du module, vu de dessus. Un robot bleu se tient dans le couloir, ses 36 rayons verts autour de lui. Un "
    "disque rouge est un passant, que l'on déplace : les rayons qu'il arrête deviennent rouges. Un contour orange, "
    "dans une autre pièce, est une fausse pose. Deux nombres disent laquelle des deux poses chaque formule préfère."
)
BEAMS, REACH, NOISE = 36, 12.0, 0.2
TRUE, FALSE = (8.5, 8.0, 0.0), (19.5, 10.5, 3.4)
PARAMETERS = {
    "sigma": Slider("Écart-type du lidar σ", 0.1, 1.0, 0.05, 0.2, "case"),
    "hasard": Slider("Part du hasard dans le mélange", 0.0, 0.3, 0.01, 0.1),
}
RATE, SHORT, BEYOND = 0.5, 0.1, 0.1
WALKER, RADIUS = (11.4, 8.0), 0.5
SEED = 3


def compute(values: Values, rng: np.random.Generator) -> Start:
    lidar = SimulatedLidar.full_turn(BEAMS, REACH)
    expected = np.minimum(carte().cast_scans([TRUE, FALSE], lidar.angles, REACH), REACH)
    noise = np.random.default_rng(SEED).normal(0.0, NOISE, BEAMS)
    read = np.where(expected[0] < REACH, np.clip(expected[0] + noise, 0.0, REACH), REACH)
    height, width = carte().shape
    return Start(
        View(0, 0, width, height),
        {
            "walls": murs().wire(),
            "angles": lidar.angles.tolist(),
            "true": TRUE, "false": FALSE,
            "expected": expected.tolist(),
            "read": np.round(read, 6).tolist(),
            "noise": np.round(noise, 6).tolist(),
            "reach": REACH, "rate": RATE, "short": SHORT, "beyond": BEYOND,
            "walker": WALKER, "radius": RADIUS,
        },
        [
            Key("robot", "truth", "vrai robot"),
            Key("ring", "estimate", "fausse pose"),
            Key("line", "measure", "rayon qui touche un mur"),
            Key("line", "alert", "rayon arrêté par le passant"),
        ],
    )  # fmt: skip
