"""Le filtre d'un seul nombre : un chariot sur un rail, qui prédit puis corrige, avec le gain de Kalman ou un autre."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from graders.scene.replay import (
    Chart,
    Draw,
    Frame,
    Key,
    Layer,
    Level,
    Points,
    Polyline,
    Pose,
    Prediction,
    Replay,
    Segments,
    Series,
    Slider,
    Switch,
    Values,
    View,
    decimal,
)
from reference.filters.scalar import ScalarBelief, kalman_gain, steady_state_variance

Floats = NDArray[np.float64]

TITLE = "Un chariot sur un rail : prédire, corriger"
ALT = (
    "Un chariot bleu roule vers la droite sur un rail fermé par un mur. Au-dessus du rail, une cloche orange dit où le "
    "filtre le croit : elle avance et s'élargit à chaque pas, puis une cloche verte, la mesure, la rejoint, et il en "
    "reste une plus haute et plus étroite. Sous le rail, une flèche va de la prédiction vers la mesure : sa longueur "
    "est le gain. Dessous, une courbe en dents de scie : le doute, qui monte à chaque prédiction et descend à chaque "
    "correction."
)
PARAMETERS = {
    "pas": Slider("Bruit d'un pas, écart-type", 0.0, 0.5, 0.05, 0.2, "m"),
    "mesure": Slider("Bruit du télémètre, écart-type", 0.1, 1.0, 0.05, 0.5, "m"),
    "depart": Slider("Doute au départ, écart-type", 0.1, 3.0, 0.1, 1.5, "m"),
    "impose": Switch("Imposer le gain au lieu de le calculer"),
    "gain": Slider("Gain imposé", 0.0, 1.0, 0.05, 0.1),
    "tirage": Draw(default=7),
}
PREDICTION = Prediction(
    "Le chariot doute de 1,5 m au départ, d'un pas à 0,2 m près ; son télémètre est précis à 0,5 m près. Pas après "
    "pas, que devient l'écart-type annoncé après chaque correction ?",
    (
        ("palier", "Il descend vite, puis se pose à un palier."),
        ("zero", "Il descend sans fin vers zéro : les mesures s'accumulent."),
        ("monte", "Il descend d'abord, puis remonte : les bruits des pas s'accumulent."),
        ("lues", "Cela dépend de ce que le télémètre lira."),
    ),
    right="palier",
    why=(
        "La première correction le ramène de 1,51 m à 0,47 m. Puis il se pose à 0,29 m : là, ce qu'une mesure retire "
        "de doute est juste ce qu'un pas en ajoute. Ce que lit le télémètre n'y est pour rien : le gain et le doute se "
        "calculent sans regarder les mesures."
    ),
)
STEPS, ADVANCE, START, WALL = 12, 0.7, 2.0, 14.0
VIEW = (-1.0, -1.9, 14.6, 6.6)
TALLEST, BELOW = 6.0, -1.0
#: Le chariot part au plus à cette distance de là où on le croit, pour rester sur son rail.
OFF = 1.5


@dataclass
class Journey:
    """Ce qui se passe : à chaque moment (les demi-pas sont des prédictions), la vérité, la croyance, son gain."""

    moments: list[float] = field(default_factory=list)
    truth: list[float] = field(default_factory=list)
    beliefs: list[ScalarBelief] = field(default_factory=list)
    read: list[float] = field(default_factory=list)
    gains: list[float] = field(default_factory=list)
    best: list[float] = field(default_factory=list)

    def at(self, moment: float, truth: float, belief: ScalarBelief) -> None:
        self.moments.append(moment)
        self.truth.append(truth)
        self.beliefs.append(belief)


def compute(values: Values, rng: np.random.Generator) -> Replay:
    journey = travel(values, rng)
    tallest = max(1.0 / belief.sigma for belief in journey.beliefs)
    frames = [frame(journey, values, place, TALLEST / tallest) for place in range(len(journey.moments))]
    return Replay(
        View(*VIEW, up=True),
        frames,
        summary(journey, values),
        layers=[
            Segments([[VIEW[0], 0.0]], [[WALL, 0.0]], "faint", width=3.0),
            Segments([[WALL, -1.5]], [[WALL, 1.5]], "ink", width=5.0),
        ],
        charts=[doubt(journey, values), gains(journey)],
        legend=[
            Key("robot", "truth", "le vrai chariot"),
            Key("line", "estimate", "ce que le filtre croit"),
            Key("line", "measure", "ce que dit la mesure"),
            Key("dashed", "faint", "ce qu'il croyait juste avant"),
        ],
        period=0.9,
    )


def travel(values: Values, rng: np.random.Generator) -> Journey:
    """Un départ, un trajet et des mesures tirés selon ces bruits mêmes."""
    step, noise = values.number("pas"), values.number("mesure")
    imposed = values.number("gain") if values.flag("impose") else None
    journey = Journey()
    belief = ScalarBelief(np.array([START]), values.number("depart") ** 2)
    truth = START + float(np.clip(belief.sigma * rng.normal(), -OFF, OFF))
    journey.at(0.0, truth, belief)
    for k in range(1, STEPS + 1):
        truth += ADVANCE + step * rng.normal()
        belief = belief.predict(ADVANCE, step**2)
        journey.at(k - 0.5, truth, belief)
        z = truth + noise * rng.normal()
        journey.read.append(z)
        journey.best.append(kalman_gain(belief.variance, noise**2))
        journey.gains.append(journey.best[-1] if imposed is None else imposed)
        belief = belief.correct([z], noise**2, imposed)
        journey.at(float(k), truth, belief)
    return journey


def bell(mean: float, sigma: float, scale: float) -> Floats:
    """Une cloche d'aire constante, à quatre écarts-types de part et d'autre, posée sur le rail."""
    x = np.linspace(-4.0, 4.0, 65)
    return np.column_stack([mean + sigma * x, scale / sigma * np.exp(-0.5 * x**2)])


def frame(journey: Journey, values: Values, place: int, scale: float) -> Frame:
    belief, truth = journey.beliefs[place], journey.truth[place]
    mean, k = float(belief.mean[0]), (place + 1) // 2
    shown: list[Layer] = [Pose([truth, 0.0, 0.0], "truth", 0.4, glide=True)]
    if place == 0:
        text = f"Au départ, le filtre croit le chariot en {decimal(mean, 2)} m, à {decimal(belief.sigma, 2)} m près."
        return Frame([*shown, Polyline(bell(mean, belief.sigma, scale), "estimate", 3.0)], text, 0)
    before = journey.beliefs[place - 1]
    old = float(before.mean[0])
    shown.append(Polyline(bell(old, before.sigma, scale), "faint", dashed=True))
    if place % 2:
        grown = f"le doute passe de {decimal(before.sigma, 2)} à {decimal(belief.sigma, 2)} m."
        still = "sans bruit de pas, le doute ne change pas."
        told = grown if values.number("pas") > 0.0 else still
        text = f"Pas {k}, prédire : on avance de {decimal(ADVANCE, 2)} m ; {told}"
    else:
        z, gain = journey.read[k - 1], journey.gains[k - 1]
        shown += [
            Polyline(bell(z, values.number("mesure"), scale), "measure"),
            Segments([[old, BELOW]], [[z, BELOW]], "measure", width=2.0, dashed=True),
            Segments([[old, BELOW]], [[mean, BELOW]], "estimate", width=5.0),
            Points([[old, BELOW], [z, BELOW]], "ink", size=3.0),
        ]
        text = (
            f"Pas {k}, corriger : le télémètre lit {decimal(WALL - z, 2)} m, donc z = {decimal(z, 2)} m. Gain "
            f"{decimal(gain, 2)} : le filtre fait cette part du chemin de {decimal(old, 2)} à {decimal(z, 2)}, et "
            f"répond {decimal(mean, 2)} m, à {decimal(belief.sigma, 2)} m près."
        )
    shown.append(Polyline(bell(mean, belief.sigma, scale), "estimate", 3.0))
    return Frame(shown, text, k)


def doubt(journey: Journey, values: Values) -> Chart:
    moments = np.array(journey.moments)
    errors = [abs(float(b.mean[0]) - x) for b, x in zip(journey.beliefs, journey.truth, strict=True)]
    blind = np.sqrt(values.number("depart") ** 2 + np.ceil(moments) * values.number("pas") ** 2)
    return Chart(
        "Le doute annoncé, et la vraie erreur (m)",
        [
            Series("écart-type annoncé", "estimate", [belief.sigma for belief in journey.beliefs], moments),
            Series("sans jamais mesurer", "faint", blind, moments, "dashed"),
            Series("erreur", "truth", errors, moments, "dots"),
        ],
        "pas (prédiction, puis correction)",
        (0.0, None),
        levels=[Level(values.number("mesure"), "une mesure seule", "measure")],
        cursor=journey.moments,
    )


def gains(journey: Journey) -> Chart:
    steps = np.arange(1.0, STEPS + 1.0)
    return Chart(
        "Le gain",
        [
            Series("celui de Kalman", "accent", journey.best, steps, "dashed"),
            Series("celui qui sert", "estimate", journey.gains, steps, "dots"),
        ],
        "pas",
        (0.0, 1.0),
        cursor=journey.moments,
    )


def summary(journey: Journey, values: Values) -> list[str]:
    step, noise = values.number("pas"), values.number("mesure")
    last, first = journey.beliefs[-1], journey.beliefs[2]
    texts = [
        f"La première correction ramène le doute de {decimal(journey.beliefs[1].sigma, 2)} m à "
        f"{decimal(first.sigma, 2)} m ; la dernière, à {decimal(last.sigma, 2)} m.",
    ]
    settled = float(np.sqrt(steady_state_variance(step**2, noise**2)))
    if values.flag("impose"):
        lost = last.sigma / min(settled, last.sigma) if settled > 0.0 else np.inf
        texts.append(
            f"Avec le gain de Kalman, il se poserait à {decimal(settled, 2)} m"
            + (f" : {decimal(lost, 2)} fois moins." if 1.005 < lost < 100.0 else ".")
        )
    elif step == 0.0:
        texts.append("Sans bruit de pas, rien ne vient l'augmenter : il tend vers zéro, de plus en plus lentement.")
    else:
        texts.append(
            f"Le palier est à {decimal(settled, 2)} m, avec un gain de {decimal(settled**2 / noise**2, 2)}. Le départ "
            "n'y est pour rien."
        )
    gap = abs(float(last.mean[0]) - journey.truth[-1])
    texts.append(
        f"À la fin, le chariot est à {decimal(gap, 2)} m de la réponse : {decimal(gap / last.sigma, 1)} fois "
        "l'écart-type annoncé."
    )
    return texts
