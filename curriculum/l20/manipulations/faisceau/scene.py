"""Quatre cents lectures, quatre causes : régler le mélange à la main, puis laisser faire EM."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from graders.scene.hands import Start
from graders.scene.replay import Key, Slider, Values, View
from reference.sensors.beam import BeamModel

Floats = NDArray[np.float64]

TITLE = "Quatre causes à régler"
ALT = (
    "Un histogramme de quatre cents distances lues par un rayon qui en attend cinq cases : un pic serré à cinq, une "
    "pente qui descend depuis zéro, un fond presque plat, et une barre isolée à la portée. Chaque barre est partagée "
    "en quatre couleurs, selon la cause que le mélange donne à ses lectures ; un trait dit combien il en prévoit. À "
    "côté, un tableau compare vos réglages et ceux que l'algorithme EM trouve, tour après tour."
)
PARAMETERS = {
    "hit": Slider("Bon écho, α_{hit}", 0.01, 1.0, 0.01, 0.25),
    "short": Slider("Objet imprévu, α_{short}", 0.0, 1.0, 0.01, 0.25),
    "beyond": Slider("Rien vu, α_{max}", 0.0, 1.0, 0.01, 0.25),
    "random": Slider("Hasard, α_{rand}", 0.0, 1.0, 0.01, 0.25),
    "sigma": Slider("Largeur du bon écho σ", 0.05, 2.0, 0.05, 1.0, "case"),
    "rate": Slider("Imprévus par case, λ", 0.05, 3.0, 0.05, 1.0),
}
REACH, EXPECTED, COUNT, BIN = 12.0, 5.0, 400, 0.25
#: D'où les lectures sont tirées ; le lecteur ne le voit pas.
DRAWN_FROM = BeamModel(REACH, hit=0.62, short=0.2, beyond=0.08, random=0.10, sigma=0.3, rate=0.8)
SEED = 3


def readings() -> Floats:
    """Les distances lues (COUNT,), au centième de case, dans [0, REACH]."""
    return np.round(DRAWN_FROM.sample(np.full(COUNT, EXPECTED), np.random.default_rng(SEED)), 2)


def compute(values: Values, rng: np.random.Generator) -> Start:
    return Start(
        View(-0.9, -1.0, REACH + 2.0, 7.4, up=True),
        {"read": readings().tolist(), "expected": EXPECTED, "reach": REACH, "bin": BIN},
        [
            Key("area", "estimate", "bon écho"),
            Key("area", "second", "objet imprévu"),
            Key("area", "measure", "rien vu"),
            Key("area", "accent", "hasard"),
            Key("line", "ink", "ce que le mélange prévoit"),
        ],
    )
