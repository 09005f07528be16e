"""Tourner, avancer, tourner : où le robot peut-il être, quand chaque geste a son bruit ?"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from curriculum.l20.rejeux._carte import en_cases
from graders.scene.replay import (
    Draw,
    Ellipse,
    Frame,
    Key,
    Layer,
    Placed,
    Points,
    Polyline,
    Pose,
    Replay,
    Slider,
    Values,
    View,
    decimal,
)
from reference.localisation.odometry_motion import OdometryNoise, sample_odometry
from reference.se2 import compose

Floats = NDArray[np.float64]

TITLE = "Tourner, avancer, tourner : la banane"
ALT = (
    "Vu de dessus, un robot bleu part de l'origine et avance pas à pas, en ligne droite ou en tournant. Quatre cents "
    "particules orange partent avec lui, chacune avec ses propres erreurs. Le nuage s'étale : en trait le long du "
    "trajet si l'avance est bruitée, en arc autour du départ si les rotations le sont, en croissant si les deux le "
    "sont. Une ellipse violette résume le nuage comme le ferait une gaussienne."
)
PARAMETERS = {
    "a1": Slider("α₁ : rotation, par radian tourné", 0.0, 0.5, 0.05, 0.1),
    "a2": Slider("α₂ : rotation, par case avancée", 0.0, 0.2, 0.01, 0.08, "rad"),
    "a3": Slider("α₃ : avance, par case avancée", 0.0, 0.5, 0.05, 0.1),
    "a4": Slider("α₄ : avance, par radian tourné", 0.0, 0.5, 0.05, 0.0, "case"),
    "virage": Slider("Virage à chaque pas", -60, 60, 10, 0, "°"),
    "pas": Slider("Nombre de pas de deux cases", 1, 10, 1, 6),
    "tirage": Draw(),
}
PREDICTION = Placed(
    "Le robot, parti de l'origine, va tout droit : l'odométrie le place en x = 12, y = 0. Chaque particule se trompe "
    "surtout en tournant. Placez le point où sera la moyenne du nuage.",
    spots=((10.14, 0.09),),
    box=(0.0, -6.0, 14.0, 6.0),
    near=0.8,
    far=1.6,
    up=True,
    why=(
        "La moyenne est en x = 10,14 et y = 0,09, à 1,87 case de l'endroit que dit l'odométrie, et en deçà. Un cap "
        "faux, à droite comme à gauche, fait avancer moins loin dans la bonne direction : les erreurs ne se compensent "
        "qu'en travers, et le nuage se courbe en arc autour du départ."
    ),
    settings={"a2": "0.12", "a3": "0.05"},
)
COUNT = 400
STRIDE = 2.0
THIN = 1e-9


def compute(values: Values, rng: np.random.Generator) -> Replay:
    noise = OdometryNoise(values.number("a1"), values.number("a2"), values.number("a3"), values.number("a4"))
    turn = float(np.radians(values.number("virage")))
    move = (STRIDE * np.cos(turn / 2), STRIDE * np.sin(turn / 2), turn)
    told, clouds = [np.zeros(3)], [np.zeros((COUNT, 3))]
    for _ in range(values.whole("pas")):
        told.append(compose(told[-1], move))
        clouds.append(sample_odometry(clouds[-1], move, noise, rng))
    frames = [
        Frame(layers(np.array(told[: step + 1]), cloud), caption(step, cloud, told[step]), step)
        for step, cloud in enumerate(clouds)
    ]
    return Replay(
        view(np.vstack([*clouds, told])),
        frames,
        summary(clouds[-1], told[-1]),
        legend=[
            Key("robot", "truth", "où l'odométrie place le robot"),
            Key("dot", "estimate", "particules, chacune avec son bruit"),
            Key("ring", "second", "deux écarts-types, si c'était une gaussienne"),
        ],
        period=0.8,
    )


def layers(told: Floats, cloud: Floats) -> list[Layer]:
    shown: list[Layer] = [
        Polyline(told[:, :2], "truth", dashed=True) if len(told) > 1 else Points(told[:, :2], "truth"),
        Points(cloud[:, :2], "estimate", size=2.0, opacity=0.6, glide=True),
        Pose(told[-1], "truth", glide=True),
    ]
    covariance = np.cov(cloud[:, :2].T)
    if np.trace(covariance) > THIN:
        shown.append(Ellipse(cloud[:, :2].mean(axis=0), covariance, "second"))
    return shown


def spreads(cloud: Floats, told: Floats) -> tuple[float, float]:
    """Les écarts-types le long du cap de l'odométrie, et en travers."""
    c, s = np.cos(told[2]), np.sin(told[2])
    local = (cloud[:, :2] - told[:2]) @ np.array([[c, -s], [s, c]])
    return float(local[:, 0].std()), float(local[:, 1].std())


def caption(step: int, cloud: Floats, told: Floats) -> str:
    if step == 0:
        return "Au départ, toutes les particules sont à la même place."
    along, across = spreads(cloud, told)
    return f"Pas {step} : l'écart-type vaut {en_cases(along)} le long du cap, {decimal(across, 2)} en travers."


def view(points: Floats) -> View:
    (x0, y0), (x1, y1) = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    half = max(float(x1 - x0), float(y1 - y0), 4.0) / 2 + 0.8
    x, y = float(x0 + x1) / 2, float(y0 + y1) / 2
    return View(x - half, y - half, x + half, y + half, up=True)


def summary(cloud: Floats, told: Floats) -> list[str]:
    along, across = spreads(cloud, told)
    gap = float(np.hypot(*(cloud[:, :2].mean(axis=0) - told[:2])))
    if along + across < THIN:
        return ["Sans bruit, les particules restent confondues pour toujours."]
    texts = [
        f"À la fin, l'écart-type du nuage vaut {en_cases(along)} le long du cap de l'odométrie, et "
        f"{decimal(across, 2)} en travers."
    ]
    if across > 2 * along:
        texts.append("Les erreurs de rotation l'emportent : le nuage se courbe, et l'ellipse contient du vide.")
    elif along > 2 * across:
        texts.append("Les erreurs d'avance l'emportent : le nuage s'allonge, et l'ellipse le décrit bien.")
    texts.append(f"La moyenne du nuage est à {en_cases(gap)} de l'endroit que dit l'odométrie.")
    return texts
