"""Drawings of the séance on the Kalman filter: weights, bells, a settled doubt, ellipses, a tangent, a gate."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Ellipse
from numpy.typing import ArrayLike, NDArray

from graders.plotting import Palette
from graders.scene.replay import decimal
from reference.filters.extended import ExtendedKalmanFilter
from reference.filters.kalman import KalmanFilter
from reference.filters.models import LinearGaussian
from reference.filters.range_bearing import RangeModel
from reference.filters.scalar import ScalarBelief

Floats = NDArray[np.float64]
Law = tuple[float, float]

#: The two thermometers: what they read, in °C, and their variances.
GADGET: Law = (19.0, 4.0)
GOOD: Law = (21.5, 1.0)
#: The trolley of the worked example: belief, move, reading, as (metres, variance).
BELIEF, MOVE, READING = (2.0, 0.16), (1.0, 0.09), (3.4, 0.0625)
#: Variances of a step and of a reading of the cell `rail`.
STEP, NOISE = 0.04, 0.25


def of(law: Law) -> ScalarBelief:
    return ScalarBelief(np.array([law[0]]), law[1])


def law_of(belief: ScalarBelief) -> Law:
    return float(belief.mean[0]), belief.variance


def thermometers() -> Law:
    """What the two readings make together."""
    return law_of(of(GADGET).correct([GOOD[0]], GOOD[1]))


def turn() -> tuple[Law, Law]:
    """The worked example, predicted then corrected."""
    predicted = of(BELIEF).predict(*MOVE)
    return law_of(predicted), law_of(predicted.correct([READING[0]], READING[1]))


def bell(x: Floats, law: Law) -> Floats:
    mean, variance = law
    return np.asarray(np.exp(-0.5 * (x - mean) ** 2 / variance) / np.sqrt(2.0 * np.pi * variance))


def bare(axes: Axes) -> None:
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    axes.grid(visible=False)


def hump(axes: Axes, x: Floats, law: Law, colour: str) -> None:
    axes.plot(x, bell(x, law), color=colour, lw=2.4)
    axes.fill_between(x, bell(x, law), color=colour, alpha=0.16, lw=0)


def draw_thermometers(figure: Figure, palette: Palette) -> None:
    """The standard deviation of the answer, against the share of the good thermometer."""
    axes = figure.subplots()
    w = np.linspace(0.0, 1.0, 201)
    spread = np.sqrt((1.0 - w) ** 2 * GADGET[1] + w**2 * GOOD[1])
    axes.plot(w, spread, color=palette.estimate, lw=2.6)
    best = GADGET[1] / (GADGET[1] + GOOD[1])
    marks = (
        (0.0, "le gadget seul", (12, 2), "left", palette.ink),
        (0.5, "la moyenne ordinaire", (6, 12), "left", palette.alert),
        (1.0, "le bon seul", (-4, 16), "right", palette.ink),
        (best, f"le mieux : {decimal(best)}", (0, -24), "center", palette.truth),
    )
    for share, name, offset, side, colour in marks:
        height = float(np.sqrt((1.0 - share) ** 2 * GADGET[1] + share**2 * GOOD[1]))
        axes.plot(share, height, "o", color=colour, ms=8)
        text = f"{name}, {decimal(height, 2)} °C"
        axes.annotate(text, (share, height), offset, textcoords="offset points", ha=side, color=palette.ink)
    axes.set(xlabel="part donnée au bon thermomètre", ylabel="écart-type de la réponse (°C)", ylim=(0.6, 2.15))


def draw_product(figure: Figure, palette: Palette) -> None:
    """The two thermometers as bells, and their product."""
    axes = figure.subplots()
    x = np.linspace(13.0, 27.0, 500)
    both = thermometers()
    named = (
        (GADGET, palette.estimate, "gadget : 19 ± 2", (16.6, 0.16), "right"),
        (GOOD, palette.measure, "bon : 21,5 ± 1", (22.6, 0.30), "left"),
        (both, palette.truth, f"ensemble : 21 ± {decimal(both[1] ** 0.5, 2)}", (20.3, 0.44), "right"),
    )
    for law, colour, name, place, side in named:
        hump(axes, x, law, colour)
        axes.text(*place, name, color=palette.ink, ha=side)
    bare(axes)
    axes.set(xlabel="température (°C)", ylim=(0.0, 0.5), xlim=(13.0, 27.0))


def draw_turn(figure: Figure, palette: Palette) -> None:
    """Above, the belief moves and widens; below, the reading narrows it."""
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[1, 1.7])
    x = np.linspace(0.4, 5.2, 500)
    predicted, corrected = turn()
    named = (
        (above, BELIEF, palette.faint, "avant : 2 ± 0,4", (1.55, 0.85), "right"),
        (above, predicted, palette.estimate, "prédite : 3 ± 0,5", (3.6, 0.62), "left"),
        (below, predicted, palette.estimate, "prédite", (2.45, 0.66), "right"),
        (below, READING, palette.measure, "mesure : 3,4 ± 0,25", (3.72, 1.2), "left"),
        (below, corrected, palette.truth, f"corrigée : 3,32 ± {decimal(corrected[1] ** 0.5, 2)}", (3.1, 1.65), "right"),
    )
    for axes, law, colour, name, place, side in named:
        hump(axes, x, law, colour)
        axes.text(*place, name, color=palette.ink, ha=side, fontsize=10.5)
    above.annotate("", (2.95, 0.4), (2.05, 0.4), arrowprops={"arrowstyle": "-|>", "color": palette.ink, "lw": 1.6})
    above.set_title("Prédire : la cloche avance et s’élargit", loc="left")
    below.set_title("Corriger : elle se resserre", loc="left")
    for axes, top in ((above, 1.15), (below, 1.95)):
        bare(axes)
        axes.set_ylim(0.0, top)
    below.set_xlabel("position sur le rail (m)")


def sawtooth(start: float, steps: int = 14) -> tuple[Floats, Floats]:
    """Moments (prediction at half a step) and announced deviations, from a first deviation on."""
    belief = of((0.0, start**2))
    spreads = [belief.sigma]
    for _ in range(steps):
        belief = belief.predict(0.0, STEP)
        spreads.append(belief.sigma)
        belief = belief.correct([0.0], NOISE)
        spreads.append(belief.sigma)
    moments = [0.0, *(0.5 + 0.5 * k for k in range(2 * steps))]
    return np.array(moments), np.array(spreads)


def draw_settling(figure: Figure, palette: Palette) -> None:
    """Three first doubts, one doubt in the end."""
    axes = figure.subplots()
    for start, colour in ((1.0, palette.estimate), (0.5, palette.second), (0.05, palette.measure)):
        moments, spreads = sawtooth(start)
        axes.plot(moments, spreads, "-", color=colour, lw=2.0, label=f"départ à {decimal(start, 2)} m près")
    settled = sawtooth(1.0, 200)[1][-1]
    axes.axhline(float(settled), color=palette.ink, lw=1.2, ls="--")
    axes.text(14.1, float(settled) - 0.06, f"{decimal(float(settled), 3)} m", color=palette.ink, ha="right")
    axes.set(xlabel="pas (prédiction, puis correction)", ylabel="écart-type annoncé (m)", ylim=(0.0, 1.05))
    axes.legend()


def ring(
    axes: Axes, mean: ArrayLike, covariance: Floats, colour: str, sigmas: float = 1.0, **style: float | str
) -> None:
    values, vectors = np.linalg.eigh(covariance)
    small, large = 2.0 * sigmas * np.sqrt(values)
    angle = float(np.degrees(np.arctan2(vectors[1, 1], vectors[0, 1])))
    x, y = np.asarray(mean, dtype=np.float64)
    axes.add_patch(Ellipse((x, y), large, small, angle=angle, fill=False, ec=colour, **{"lw": 2.4, **style}))


def learnt() -> list[tuple[Floats, Floats]]:
    """The speed that a place teaches: mean and covariance before, predicted and corrected."""
    model = LinearGaussian(F=[[1, 1], [0, 1]], B=np.zeros((2, 1)), Q=np.zeros((2, 2)), H=[[1, 0]], R=[[2]])
    belief = KalmanFilter(model, np.zeros(2), np.eye(2))
    told = [(belief.mean, belief.covariance)]
    belief.predict([0.0])
    told.append((belief.mean, belief.covariance))
    belief.correct([4.0])
    return [*told, (belief.mean, belief.covariance)]


def draw_speed(figure: Figure, palette: Palette) -> None:
    """Prediction slants the ellipse, and the band of a place then lowers it."""
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    before, predicted, corrected = learnt()
    left, right = panels
    ring(left, *before, palette.faint, ls="--")
    ring(left, *predicted, palette.estimate)
    right.axvspan(4.0 - 2**0.5, 4.0 + 2**0.5, color=palette.measure, alpha=0.25, lw=0)
    right.axvline(4.0, color=palette.measure, lw=1.2)
    ring(right, *predicted, palette.estimate, ls="--")
    ring(right, *corrected, palette.truth)
    for axes, (mean, _), colour in ((left, predicted, palette.estimate), (right, corrected, palette.truth)):
        axes.plot(*mean, "o", color=colour)
    left.set_title("Prédire penche", loc="left")
    right.set_title("Mesurer la position", loc="left")
    left.set_ylabel("vitesse (m/s)")
    left.text(-1.45, -1.35, "avant", color=palette.ink, fontsize=10)
    right.text(4.0, -1.6, "lue", color=palette.ink, ha="center", fontsize=10)
    for axes in panels:
        axes.set(xlim=(-1.9, 5.7), ylim=(-1.9, 2.2), aspect="equal", xlabel="position (m)")


#: How far the robot believes to be from the beacon, its doubt, and the noise of the range, in metres.
FAR, NEAR, DOUBT, RANGE_NOISE = 5.0, 1.2, 0.8, 0.15


def beside(distance: float) -> tuple[Floats, Floats]:
    """Mean and covariance of the place by the extended filter, which reads what it expected."""
    model = RangeModel([[0.0, 0.0]], advance_sigma=0.0, turn_sigma=0.0, range_sigma=RANGE_NOISE)
    belief = ExtendedKalmanFilter(model, [distance, 0.0, 0.0], np.diag([DOUBT**2, DOUBT**2, 0.0]))
    belief.correct([distance])
    return belief.mean[:2], belief.covariance[:2, :2]


def draw_tangent(figure: Figure, palette: Palette) -> None:
    """The circle of a range and its tangent, far from the beacon and near to it."""
    for axes, distance in zip(figure.subplots(1, 2), (FAR, NEAR), strict=True):
        x, y = np.meshgrid(np.linspace(-3.0, 8.0, 441), np.linspace(-2.8, 2.8, 225))
        logs = -0.5 * (((x - distance) ** 2 + y**2) / DOUBT**2)
        logs -= 0.5 * ((np.hypot(x, y) - distance) / RANGE_NOISE) ** 2
        axes.contourf(x, y, np.exp(logs), levels=np.linspace(0.06, 1.02, 7), cmap=palette.ramp, vmin=-0.4, alpha=0.75)
        axes.add_patch(Circle((0.0, 0.0), distance, fill=False, ec=palette.measure, lw=1.8))
        axes.axvline(distance, color=palette.ink, lw=1.2, ls="--")
        ring(axes, *beside(distance), palette.estimate, sigmas=2.0)
        axes.plot(0.0, 0.0, "*", color=palette.ink, ms=11)
        axes.set_title(f"à {decimal(distance)} m de la balise", loc="left")
        axes.set(xlim=(distance - 2.8, distance + 2.8), ylim=(-2.6, 2.6), aspect="equal", xlabel="m")


#: The drawing of the gate: steps, and the chance that somebody stands in the beam.
GATED, PASSERS, SQUARES = 60, 0.1, 9.0


@cache
def gated(seed: int = 3) -> tuple[Floats, Floats, dict[str, Floats], NDArray[np.bool_]]:
    """Truth, readings, the answers (n, 2) with their deviations without and with a gate, and what it threw away."""
    rng = np.random.default_rng(seed)
    move, q, r = 0.1, 0.05**2, 0.2**2
    truth = np.cumsum(move + np.sqrt(q) * rng.standard_normal(GATED))
    read = truth + np.sqrt(r) * rng.standard_normal(GATED)
    read = read + np.where(rng.random(GATED) < PASSERS, rng.uniform(2.0, 4.0, GATED), 0.0)
    answers, thrown = {}, np.zeros(GATED, dtype=np.bool_)
    for name, limit in (("sans", np.inf), ("avec", SQUARES)):
        belief, told = of((0.0, 0.04)), []
        for k, z in enumerate(read):
            belief = belief.predict(move, q)
            thrown[k] = (z - float(belief.mean[0])) ** 2 > limit * (belief.variance + r)
            belief = belief if thrown[k] else belief.correct([z], r)
            told.append([float(belief.mean[0]), belief.sigma])
        answers[name] = np.array(told)
    return truth, read, answers, thrown


def draw_gate(figure: Figure, palette: Palette) -> None:
    """The same readings, without and with a gate."""
    truth, read, answers, thrown = gated()
    steps = np.arange(1, GATED + 1)
    panels = figure.subplots(2, 1, sharex=True, sharey=True)
    for axes, (name, told) in zip(panels, answers.items(), strict=True):
        mean, sigma = told.T
        kept = ~thrown if name == "avec" else np.ones(GATED, dtype=np.bool_)
        axes.fill_between(steps, mean - 2 * sigma, mean + 2 * sigma, color=palette.estimate, alpha=0.25, lw=0)
        axes.plot(steps, mean, color=palette.estimate, lw=2.0)
        axes.plot(steps, truth, color=palette.truth, lw=1.6)
        axes.plot(steps[kept], read[kept], ".", color=palette.measure, ms=5)
        axes.plot(steps[~kept], read[~kept], "x", color=palette.alert, ms=7, mew=2)
        axes.set_title(f"{name.capitalize()} portillon", loc="left")
        axes.set_ylabel("position (m)")
    panels[1].set_xlabel("pas")


FIGURES = {
    "deux-thermometres": (
        draw_thermometers,
        "Une courbe en creux : l'écart-type de la réponse selon la part donnée au bon thermomètre. Il vaut 2 degrés "
        "pour une part nulle, 1,12 pour la moyenne ordinaire, 1 pour le bon thermomètre seul, et passe par un minimum "
        "de 0,89 pour une part de 0,8.",
    ),
    "produit-de-cloches": (
        draw_product,
        "Trois cloches sur un axe de températures : une large, centrée en 19, une plus étroite en 21,5, et leur "
        "produit, la plus haute et la plus étroite, centré en 21, entre les deux et près de la deuxième.",
        (6.0, 3.4),
    ),
    "rail-un-tour": (
        draw_turn,
        "En haut, une cloche centrée en 2 mètres et celle qu'elle devient, en 3 mètres, plus large. En bas, cette "
        "cloche, celle de la mesure, plus étroite, en 3,4, et leur produit, plus étroit encore, en 3,32.",
        (6.0, 4.6),
    ),
    "palier": (
        draw_settling,
        "Trois courbes en dents de scie, parties de 1, de 0,5 et de 0,05 mètre : en une dizaine de pas elles se "
        "confondent, et oscillent au-dessus d'un même palier, à 0,286 mètre.",
    ),
    "ellipses-vitesse": (
        draw_speed,
        "Deux dessins, position en abscisse et vitesse en ordonnée. À gauche, un cercle en tirets devient une ellipse "
        "penchée vers la droite. À droite, une bande verticale autour de la position 4 ; l'ellipse qui reste, penchée "
        "aussi, est entre l'ellipse prédite et la bande, plus étroite, un peu moins haute, centrée plus haut.",
        (7.2, 2.7),
    ),
    "cercle-et-tangente": (
        draw_tangent,
        "Deux dessins. À gauche, loin de la balise, un arc presque droit, sa tangente en tirets, et une ellipse mince "
        "qui recouvre la tache de la croyance exacte. À droite, tout près de la balise, la tache suit un petit cercle "
        "et s'enroule, tandis que l'ellipse reste droite, le long de la tangente.",
        (6.4, 3.4),
    ),
    "portillon": (
        draw_gate,
        "Deux dessins du même trajet. En haut, sans portillon, la réponse du filtre saute vers chaque lecture gâchée, "
        "loin du vrai trajet, et y revient peu à peu. En bas, avec un portillon, ces lectures, marquées d'une croix, "
        "sont ignorées, et la réponse suit le vrai trajet.",
        (6.4, 4.8),
    ),
}
