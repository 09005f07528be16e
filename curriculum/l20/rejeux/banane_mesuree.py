"""Une banane, trois filtres : ce que l'EKF, l'UKF et les particules font d'une même mesure."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from curriculum.l20.rejeux._trio import ADVANCE, Answer, Trio, of
from graders.scene.replay import (
    Chart,
    Choice,
    Dragged,
    Draw,
    Ellipse,
    Frame,
    Grid,
    Key,
    Layer,
    Points,
    Polyline,
    Pose,
    Prediction,
    Replay,
    Series,
    Slider,
    Values,
    View,
    decimal,
)
from reference.filters.banana import Banana, BananaBelief
from reference.filters.models import GaussianModel
from reference.filters.range_bearing import RangeBearingModel, RangeModel

Floats = NDArray[np.float64]

TITLE = "Une banane, trois filtres"
ALT = (
    "Trois dessins côte à côte, les mêmes au départ : un robot avance de dix mètres sans bien savoir dans quelle "
    "direction, et sa croyance exacte, en couleur, se courbe en croissant. Puis il mesure sa distance à une balise, un "
    "cercle, et le croissant se réduit à ce que le cercle en garde. Sur le premier dessin, l'ellipse de l'EKF ; sur le "
    "deuxième, celle de l'UKF ; sur le troisième, les particules, d'autant plus marquées qu'elles sont lourdes."
)
PARAMETERS = {
    "cap": Slider("Doute sur le cap", 5, 40, 5, 25, "°"),
    "bruit": Slider("Bruit de la distance mesurée", 0.1, 1.0, 0.1, 0.3, "m"),
    "mesure": Choice("Mesure", (("distance", "la distance seule"), ("direction", "distance et direction")), "distance"),
    "particules": Slider("Particules", 50, 2000, 50, 500),
    "balise": Dragged("Balise", (-8.5, 4.0, 0.0), (-9.0, -1.0, 9.0, 11.0), step=0.25, turns=False),
    "tirage": Draw(default=4),
}
PREDICTION = Prediction(
    "Le robot mesure maintenant sa distance à la balise. Quel filtre annoncera la plus petite ellipse ?",
    (
        ("ekf", "L'EKF, qui suit la tangente."),
        ("ukf", "L'UKF, par ses points sigma."),
        ("particules", "Les particules."),
        ("egales", "Les trois seront à peu près égales."),
    ),
    right="ekf",
    why=(
        "L'EKF annonce 0,46 m le long du grand axe, moins que la croyance exacte, 0,65 m : nul ne peut en savoir plus "
        "qu'elle sans se tromper. Le robot est à 2,39 m de son centre, et le NEES vaut 50,8 au lieu de 2. L'UKF "
        "annonce 1,56 m : il doute trop, mais le robot est dans son ellipse. Le nuage annonce 0,68 m, "
        "et il en a la forme."
    ),
)
ADVANCE_SIGMA, BEARING_SIGMA = 0.3, np.radians(5.0)
ROBOTS, STEPS, CELL = 100, 4, 0.2
VIEW = (-9.6, -1.2, 9.6, 12.6)
#: Sur la balise même, la direction n'a pas de sens : elle n'est jamais tout à fait là où un filtre croit être.
ASIDE = 1e-3


def compute(values: Values, rng: np.random.Generator) -> Replay:
    x, y, _ = values.pose("balise")
    landmark = np.array([y + ASIDE, -x])
    banana = Banana(ADVANCE, ADVANCE_SIGMA, float(np.radians(values.number("cap"))))
    model = model_of(landmark, values)
    truth = banana.sample(ROBOTS, rng)
    noise = rng.multivariate_normal(np.zeros(len(model.measurement_noise)), model.measurement_noise, ROBOTS)
    measured = model.observe(truth) + noise
    trio = Trio(banana, model, banana.sample(values.whole("particules"), rng), rng)
    before = trio.predicted()
    tried = [trio.corrected(*before, z)[0] for z in measured]
    answers, weights = trio.corrected(*before, measured[0])
    exact = banana.belief(model, measured[0])
    frames = [*moving(trio, truth[0]), *measuring(trio, truth[0], landmark, measured[0], answers, weights)]
    return Replay(
        View(*VIEW, up=True),
        frames,
        summary(answers, exact, truth[0, :2], nees_of(tried, truth)),
        over=[Pose([x, y, 0.0], "measure", 0.35, "target", drag="balise")],
        charts=[missed(nees_of(tried, truth), len(frames))],
        legend=[
            Key("cell", "alert", "croyance exacte"),
            Key("ring", "estimate", "deux écarts-types, ou particules"),
            Key("ring", "measure", "balise, et distance lue"),
            Key("robot", "truth", "vrai robot"),
        ],
        period=1.2,
        panels=["EKF", "UKF", "particules"],
    )


def model_of(landmark: Floats, values: Values) -> GaussianModel:
    noises = {"advance_sigma": ADVANCE_SIGMA, "turn_sigma": 0.0, "range_sigma": values.number("bruit")}
    if values.choice("mesure") == "distance":
        return RangeModel([landmark], **noises)
    return RangeBearingModel([landmark], bearing_sigma=BEARING_SIGMA, **noises)


def cells() -> tuple[Floats, tuple[int, int]]:
    """Les centres des cases du dessin, ligne par ligne, et la forme qu'elles ont ensemble."""
    x0, y0, x1, y1 = VIEW
    across, ahead = np.meshgrid(np.arange(x0 + CELL / 2, x1, CELL), np.arange(y0 + CELL / 2, y1, CELL))
    return np.column_stack([ahead.ravel(), -across.ravel()]), across.shape


def seen(places: Floats) -> Floats:
    """Des places (n, 2) sur le dessin, où le robot part vers le haut."""
    return np.column_stack([-places[:, 1], places[:, 0]])


def robot(pose: Floats, *, glide: bool = False) -> Pose:
    """Le vrai robot, à sa pose (3,)."""
    return Pose([-pose[1], pose[0], pose[2] + np.pi / 2.0], "truth", 0.35, glide=glide)


def ring_of(answer: Answer, panel: int) -> Ellipse:
    """L'ellipse à deux écarts-types d'une réponse, sur un des dessins."""
    turned = np.array([[0.0, -1.0], [1.0, 0.0]])
    covariance = turned @ answer.covariance @ turned.T
    return Ellipse(turned @ answer.mean, covariance, "estimate", glide=True, panel=panel)


def picture(banana: Banana, model: GaussianModel | None = None, z: Floats | None = None) -> Grid:
    """La croyance exacte, case par case, la plus forte à 1."""
    places, shape = cells()
    density = banana.density(places)
    if model is not None and z is not None:
        headings = np.arctan2(places[:, 1], places[:, 0])
        logs = model.log_likelihood(np.column_stack([places, headings]), z)
        density = density * np.exp(logs - logs[density > 1e-12].max())
    shown = np.sqrt(density / density.max()).reshape(shape)
    return Grid(np.where(shown > 0.04, shown, 0.0), "belief", VIEW[:2], CELL)


def three(answers: Sequence[Answer], cloud: Floats, weights: Floats | None) -> list[Layer]:
    shown = None if weights is None else weights / weights.max()
    return [
        ring_of(answers[0], 0),
        ring_of(answers[1], 1),
        Points(seen(cloud), "estimate", 2.0, shown, opacity=0.6, glide=True, panel=2),
    ]


def moving(trio: Trio, truth: Floats) -> list[Frame]:
    """Le robot avance : la croyance se courbe, et deux ellipses essaient de la suivre."""
    frames = [
        Frame(
            [robot(np.array([0.0, 0.0, truth[2]]))],
            "Le robot sait où il est. Son cap est douteux, et il l'ignore.",
        )
    ]
    for part in np.arange(1, STEPS + 1) / STEPS:
        along = Banana(part * ADVANCE, ADVANCE_SIGMA * part**0.5, trio.banana.heading_sigma)
        model = RangeModel([[0.0, 99.0]], advance_sigma=along.advance_sigma, turn_sigma=0.0, range_sigma=1.0)
        so_far = Trio(along, model, trio.cloud, trio.rng)
        answers = [of(belief) for belief in so_far.predicted(part)]
        exact = along.belief()
        frames.append(
            Frame(
                [
                    picture(along),
                    *three(answers, on_the_way(trio.cloud, part), None),
                    robot(on_the_way(truth[None, :], part)[0], glide=True),
                ],
                f"Après {decimal(part * ADVANCE, 1)} m : la moyenne exacte est à {decimal(float(exact.mean[0]), 2)} m "
                f"du départ ; l'EKF la dit à {decimal(float(answers[0].mean[0]), 2)} m, l'UKF à "
                f"{decimal(float(answers[1].mean[0]), 2)} m.",
            )
        )
    return frames


def on_the_way(poses: Floats, part: float) -> Floats:
    """Des poses (n, 3) de l'arrivée, ramenées à cette part du chemin : le bruit y est de sa racine."""
    r = part * ADVANCE + np.sqrt(part) * (np.hypot(poses[:, 0], poses[:, 1]) - ADVANCE)
    return np.column_stack([r * np.cos(poses[:, 2]), r * np.sin(poses[:, 2]), poses[:, 2]])


def measuring(
    trio: Trio, truth: Floats, landmark: Floats, z: Floats, answers: Sequence[Answer], weights: Floats
) -> list[Frame]:
    """Le cercle de la mesure, la croyance exacte qui en reste, puis les trois réponses."""
    turn = np.linspace(0.0, 2.0 * np.pi, 91)
    ring = Polyline(seen(landmark + z[0] * np.column_stack([np.cos(turn), np.sin(turn)])), "measure", 1.5, dashed=True)
    here = robot(truth)
    prior = [of(belief) for belief in trio.predicted()]
    posterior = picture(trio.banana, trio.model, z)
    also = "" if len(z) == 1 else f", et une direction à {decimal(float(np.degrees(z[1])), 0)}° de son cap"
    return [
        Frame(
            [picture(trio.banana), *three(prior, trio.cloud, None), ring, here],
            f"Il lit {decimal(float(z[0]), 2)} m jusqu'à la balise{also}.",
        ),
        Frame([posterior, ring, here], "La croyance exacte : ce que la mesure garde du croissant."),
        Frame(
            [posterior, *three(answers, trio.cloud, weights), ring, here],
            f"Les réponses. NEES : EKF {told(answers[0].nees(truth[:2]))}, UKF {told(answers[1].nees(truth[:2]))}, "
            f"particules {told(answers[2].nees(truth[:2]))} ; il vaut 2 en moyenne quand un filtre est honnête.",
        ),
    ]


def told(nees: float) -> str:
    return "sans objet" if np.isnan(nees) else decimal(nees, 1 if nees < 100 else 0)


def nees_of(tried: Sequence[Sequence[Answer]], truth: Floats) -> Floats:
    """Le NEES de chaque robot selon chaque filtre, (ROBOTS, 3) ; NaN où un nuage s'est effondré."""
    return np.array(
        [[answer.nees(place) for answer in answers] for answers, place in zip(tried, truth[:, :2], strict=True)]
    )


def missed(nees: Floats, frames: int) -> Chart:
    """Combien de robots sont hors d'une ellipse, selon sa taille."""
    size = np.linspace(0.0, 6.0, 61)
    styles = (("EKF", "alert", "line"), ("UKF", "second", "line"), ("particules", "estimate", "line"))
    curves = [
        Series(name, color, 100.0 * np.mean(np.nan_to_num(nees[:, [k]], nan=np.inf) > size**2, axis=0), size, style)
        for k, (name, color, style) in enumerate(styles)
    ]
    honest = Series("une ellipse honnête", "ink", 100.0 * np.exp(-(size**2) / 2.0), size, "dashed")
    return Chart(
        f"Sur {ROBOTS} robots tirés, combien sont hors de l'ellipse, en %",
        [*curves, honest],
        "taille de l'ellipse, en écarts-types",
        (0.0, 100.0),
        cursor=[2.0] * frames,
        timeless=True,
    )


def summary(answers: Sequence[Answer], exact: BananaBelief, truth: Floats, nees: Floats) -> list[str]:
    right = Answer(exact.mean, exact.covariance)
    x, y = seen(right.mean[None, :])[0].tolist()
    texts = [
        f"La croyance exacte a sa moyenne en ({decimal(x, 2)} ; {decimal(y, 2)}), et un grand écart-type de "
        f"{decimal(right.spread, 2)} m."
    ]
    for name, answer in zip(("L'EKF", "L'UKF", "Le nuage"), answers, strict=True):
        gap = float(np.hypot(*(answer.mean - right.mean)))
        texts.append(
            f"{name} place la sienne à {decimal(gap, 2)} m de là, et annonce {decimal(answer.spread, 2)} m ; le vrai "
            f"robot est à {decimal(float(np.hypot(*(answer.mean - truth))), 2)} m de sa moyenne, NEES "
            f"{told(answer.nees(truth))}."
        )
    means = [float(np.nanmean(column)) if np.any(~np.isnan(column)) else np.nan for column in nees.T]
    out = 100.0 * np.mean(np.nan_to_num(nees, nan=np.inf) > 4.0, axis=0)
    texts.append(
        f"Sur {ROBOTS} robots tirés, le NEES moyen vaut {told(means[0])} pour l'EKF, {told(means[1])} pour l'UKF, "
        f"{told(means[2])} pour les particules ; 2 serait honnête. Hors de l'ellipse à deux écarts-types : "
        f"{out[0]:.0f} %, {out[1]:.0f} % et {out[2]:.0f} % des robots, au lieu de 14 %."
    )
    fallen = int(np.isnan(nees[:, 2]).sum())
    if fallen:
        texts.append(
            f"Pour {fallen} de ces robots, moins de cinq particules comptent encore : un tel nuage ne dit plus rien de "
            "sa largeur. Il n'entre pas dans la moyenne, et compte comme hors de l'ellipse."
        )
    return texts
