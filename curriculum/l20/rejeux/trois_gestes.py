"""Une matrice du plan en trois gestes : tourner, étirer, tourner."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from curriculum.l20.figures._gestes import Gestures, gestures
from graders.scene.replay import (
    Frame,
    Key,
    Labels,
    Layer,
    Polyline,
    Prediction,
    Replay,
    Segments,
    Slider,
    Values,
    View,
    decimal,
)

Floats = NDArray[np.float64]

TITLE = "Une matrice en trois gestes"
ALT = (
    "Un cercle, un petit drapeau violet et deux flèches perpendiculaires, au centre d'un repère. Le tout tourne, puis "
    "s'étire le long des axes, si bien que le cercle devient une ellipse, puis tourne encore. En pointillés, là où "
    "la matrice envoie le drapeau d'un seul coup : le drapeau finit exactement dessus."
)
PARAMETERS = {
    "a": Slider("Ligne 1, colonne 1", -3, 3, 0.5, 1),
    "b": Slider("Ligne 1, colonne 2", -3, 3, 0.5, -1),
    "c": Slider("Ligne 2, colonne 1", -3, 3, 0.5, 2),
    "d": Slider("Ligne 2, colonne 2", -3, 3, 0.5, 2),
}
PREDICTION = Prediction(
    "Deux axes perpendiculaires bien choisis sont emportés par la matrice. Que fait leur angle, du début à la fin ?",
    (
        ("droit", "Il reste droit à chaque geste."),
        ("cisaille", "Il s'ouvre ou se ferme pendant l'étirement."),
        ("hasard", "Il change à chaque geste, et redevient droit à la fin."),
    ),
    right="droit",
    why=(
        "Le premier geste amène ces deux axes sur ceux du repère, et c'est le long de ceux-là que l'on étire : ici de "
        "2,83 et de 1,41. Ils s'allongent sans pivoter. N'importe quelle autre paire d'axes serait cisaillée : "
        "c'est ce qui rend ces deux-là bien choisis."
    ),
)
PARTS = 6
FLAG = np.array([(0.0, 0.0), (0.0, 1.0), (0.7, 0.75), (0.0, 0.5)])
CIRCLE = np.array([(np.cos(t), np.sin(t)) for t in np.linspace(0.0, 2.0 * np.pi, 73)])
FLAT = 1e-9


def compute(values: Values, rng: np.random.Generator) -> Replay:
    matrix = np.array([[values.number("a"), values.number("b")], [values.number("c"), values.number("d")]])
    found = gestures(matrix)
    moments = [(0.0, 0.0, 0.0)]
    for gesture in range(3):
        for part in range(1, PARTS + 1):
            moments.append((1.0,) * gesture + (part / PARTS,) + (0.0,) * (2 - gesture))
    texts = captions(found)
    frames = [
        Frame(layers(found, *moment), texts[-(-place // PARTS)], -(-place // PARTS))
        for place, moment in enumerate(moments)
    ]
    side = max(2.0, 1.1 * found.long)
    return Replay(
        View(-side, -side, side, side, up=True),
        frames,
        summary(matrix, found),
        layers=[
            Segments([[-side, 0], [0, -side]], [[side, 0], [0, side]], "faint", width=1.0),
            Polyline(FLAG @ matrix.T, "ink", width=1.5, dashed=True),
        ],
        legend=[
            Key("line", "truth", "le cercle de rayon 1 et ce qu'il devient"),
            Key("line", "second", "le drapeau"),
            Key("arrow", "estimate", "l'axe qui sera le plus étiré"),
            Key("arrow", "measure", "l'axe qui le sera le moins"),
            Key("dashed", "ink", "là où la matrice envoie le drapeau"),
        ],
        period=0.25,
    )


def layers(found: Gestures, first: float, stretch: float, last: float) -> list[Layer]:
    done = found.after(first, stretch, last)
    # The axes to be stretched are the rows of the first turn.
    ends = found.after(1.0, 0.0, 0.0) @ done.T
    return [
        Polyline(CIRCLE @ done.T, "truth", glide=True),
        Polyline(FLAG @ done.T, "second", width=3.0, glide=True),
        Segments([[0, 0]], [ends[0]], "estimate", width=3.0, glide=True),
        Segments([[0, 0]], [ends[1]], "measure", width=3.0, glide=True),
        Labels(1.12 * ends, ["v₁", "v₂"], glide=True),
    ]


def captions(found: Gestures) -> list[str]:
    short = f"{decimal(abs(found.short), 2)} vers le haut"
    if abs(found.short) < FLAT:
        short = "0 vers le haut : tout s'écrase sur l'axe"
    elif found.short < 0:
        short += ", en retournant le plan comme une page"
    return [
        "Au départ : un cercle de rayon 1, un drapeau, et deux axes perpendiculaires bien choisis.",
        f"Premier geste : tourner de {degrees(found.first)}. Les deux axes choisis arrivent sur ceux du repère.",
        f"Deuxième geste : étirer, {decimal(found.long, 2)} fois vers la droite, {short}.",
        f"Troisième geste : tourner de {degrees(found.last)}. Le drapeau est là où la matrice l'envoie.",
    ]


def degrees(angle: float) -> str:
    return decimal(float(np.degrees(angle)) + 0.0) + "°"


def summary(matrix: Floats, found: Gestures) -> list[str]:
    determinant = float(np.linalg.det(matrix)) + 0.0
    texts = [
        f"Les valeurs singulières sont σ_{{1}} = {decimal(found.long, 2)} et σ_{{2}} = {decimal(abs(found.short), 2)}.",
        f"Le déterminant vaut {decimal(determinant, 2)} : au signe près, c'est leur produit, et c'est par lui que les "
        f"aires sont multipliées.",
    ]
    if abs(found.short) < FLAT:
        texts.append("La seconde est nulle : le plan est écrasé sur une droite, sans retour possible.")
    elif found.short < 0:
        texts.append("Le déterminant est négatif : la matrice retourne le plan. Aucune rotation ne sait le faire.")
    elif found.long - found.short < FLAT:
        texts.append("Elles sont égales : le cercle reste un cercle, et le choix des axes est libre.")
    return texts
