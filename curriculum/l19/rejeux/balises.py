"""Le filtre étendu sur des distances à des balises : une ellipse, que chaque mesure aplatit dans sa direction."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from graders.scene.replay import (
    Chart,
    Dragged,
    Draw,
    Ellipse,
    Frame,
    Key,
    Layer,
    Level,
    Polyline,
    Pose,
    Prediction,
    Replay,
    Segments,
    Series,
    Slider,
    Values,
    View,
    decimal,
)
from reference.filters.extended import ExtendedKalmanFilter
from reference.filters.range_bearing import RangeModel
from reference.filters.scalar import mean_nees_band

Floats = NDArray[np.float64]

TITLE = "Se localiser par des distances"
ALT = (
    "Une salle vue de dessus. Un robot bleu en fait le tour ; une ellipse orange dit où le filtre le croit, à deux "
    "écarts-types. Une à trois balises sont marquées d'une cible : autour de chacune, un cercle vert, la distance "
    "lue. À chaque mesure, l'ellipse s'aplatit le long de la ligne qui joint le robot à la balise ; à chaque pas, elle "
    "gonfle un peu. Dessous, les demi-axes de l'ellipse et l'erreur, puis le NEES."
)
PARAMETERS = {
    "balises": Slider("Nombre de balises", 1, 3, 1, 1),
    "depart": Slider("Doute au départ, écart-type", 0.2, 3.0, 0.2, 1.0, "m"),
    "bruit": Slider("Bruit de la distance, écart-type", 0.05, 1.0, 0.05, 0.2, "m"),
    "pas": Slider("Bruit d'un pas, écart-type", 0.0, 0.3, 0.02, 0.06, "m"),
    "balise": Dragged("Balise 1", (2.0, 7.5, 0.0), (0.0, 0.0, 12.0, 9.0), step=0.25, turns=False),
    "tirage": Draw(default=2),
}
PREDICTION = Prediction(
    "Le robot croit savoir où il est à 1 m près, dans toutes les directions : son ellipse est un disque. Il lit alors "
    "sa distance à une seule balise, à 0,2 m près. Que devient le disque ?",
    (
        ("visee", "Il s'aplatit dans la direction de la balise, et garde sa largeur en travers."),
        ("travers", "Il s'aplatit en travers, et garde sa longueur vers la balise."),
        ("disque", "Il reste un disque, plus petit."),
        ("point", "Il se réduit presque à un point : la distance est bien connue."),
    ),
    right="visee",
    why=(
        "Une distance ne renseigne que le long de la ligne de visée : là, l'écart-type tombe de 1,00 m à 0,20 m. En "
        "travers, il reste de 1,00 m. C'est en roulant que le robot voit la balise sous d'autres angles : à la fin du "
        "tour, il n'est plus que de 0,38 m dans sa pire direction."
    ),
)
STEPS, ADVANCE = 24, 0.75
TURN, HEADING_SIGMA, TURN_SIGMA = 2.0 * np.pi / STEPS, 0.02, 0.01
START = np.array([6.0, 1.4, 0.0])
OTHERS = np.array([[11.0, 7.5], [11.0, 1.0]])
VIEW = (-0.5, -0.5, 12.5, 9.5)
PLACE = slice(0, 2)
LIMIT = mean_nees_band(1, 2, 0.9)[1]


@dataclass
class Round:
    """Ce qui se passe : à chaque moment, la vraie pose, la croyance, et l'image."""

    moments: list[float] = field(default_factory=list)
    truth: list[Floats] = field(default_factory=list)
    means: list[Floats] = field(default_factory=list)
    covariances: list[Floats] = field(default_factory=list)
    frames: list[Frame] = field(default_factory=list)

    def at(self, moment: float, truth: Floats, belief: ExtendedKalmanFilter) -> None:
        self.moments.append(moment)
        self.truth.append(truth[PLACE])
        self.means.append(belief.mean[PLACE])
        self.covariances.append(belief.covariance[PLACE, PLACE])

    @property
    def axes(self) -> Floats:
        """Le petit et le grand écart-type, (n, 2)."""
        return np.sqrt(np.maximum(np.linalg.eigvalsh(np.array(self.covariances)), 0.0))

    @property
    def errors(self) -> Floats:
        return np.array(self.truth) - np.array(self.means)

    @property
    def nees(self) -> Floats:
        weighed = np.linalg.solve(np.array(self.covariances), self.errors[:, :, None])[:, :, 0]
        return np.asarray(np.sum(self.errors * weighed, axis=1))


def compute(values: Values, rng: np.random.Generator) -> Replay:
    landmarks = np.vstack([values.pose("balise")[:2], OTHERS])[: values.whole("balises")]
    tour = travel(values, landmarks, rng)
    return Replay(
        View(*VIEW, up=True),
        tour.frames,
        summary(tour, len(landmarks)),
        over=[
            Pose([x, y, 0.0], "measure", 0.3, "target", drag="balise" if k == 0 else None)
            for k, (x, y) in enumerate(landmarks)
        ],
        charts=[doubt(tour), honesty(tour)],
        legend=[
            Key("robot", "truth", "le vrai robot"),
            Key("ring", "estimate", "où le filtre le croit, à deux écarts-types"),
            Key("ring", "faint", "l'ellipse d'avant"),
            Key("ring", "measure", "balise, et distance lue"),
            Key("dashed", "ink", "la droite tangente, par quoi le filtre remplace le cercle"),
        ],
        period=0.8,
    )


def travel(values: Values, landmarks: Floats, rng: np.random.Generator) -> Round:
    """Un départ, un tour et des distances tirés selon les bruits que le filtre suppose."""
    step, noise, doubt = values.number("pas"), values.number("bruit"), values.number("depart")
    model = RangeModel(landmarks, advance_sigma=step, turn_sigma=TURN_SIGMA, range_sigma=noise)
    start = np.diag([doubt**2, doubt**2, HEADING_SIGMA**2])
    belief = ExtendedKalmanFilter(model, START, start)
    truth = rng.multivariate_normal(START, start)
    tour = Round()
    tour.at(0.0, truth, belief)
    tour.frames.append(Frame(layers(truth, belief), f"Au départ, à {decimal(doubt)} m près en tous sens.", 0))
    control = np.array([ADVANCE, TURN])
    for k in range(STEPS + 1):
        if k > 0:
            truth = model.sample_motion(truth[None, :], control, rng)[0]
            before = belief.covariance[PLACE, PLACE]
            belief.predict(control)
            tour.at(k - 0.5, truth, belief)
            text = f"Pas {k}, prédire : l'ellipse avance et gonfle un peu. {told(tour)}"
            tour.frames.append(Frame(layers(truth, belief), text, k))
        z = model.observe(truth[None, :])[0] + noise * rng.normal(size=len(landmarks))
        mean, before = belief.mean, belief.covariance[PLACE, PLACE]
        belief.correct(z)
        tour.at(float(k), truth, belief)
        shown = [*seen(landmarks, z, mean, values.number("depart")), Ellipse(mean[PLACE], before, "faint")]
        read = " ; ".join(decimal(float(one), 2) for one in z)
        name = f"Pas {k}, corriger" if k else "Première mesure, sans bouger"
        text = f"{name} : {'distance lue' if len(z) == 1 else 'distances lues'} {read} m. {told(tour)}"
        tour.frames.append(Frame([*shown, *layers(truth, belief)], text, k))
    return tour


def told(tour: Round) -> str:
    small, large = tour.axes[-1]
    return f"Écarts-types : {decimal(float(large), 2)} m sur le grand axe, {decimal(float(small), 2)} sur le petit."


def layers(truth: Floats, belief: ExtendedKalmanFilter) -> list[Layer]:
    mean, covariance = belief.mean, belief.covariance
    return [
        Ellipse(mean[PLACE], covariance[PLACE, PLACE], "estimate", glide=True),
        Pose(mean, "estimate", 0.22, "arrow", glide=True),
        Pose(truth, "truth", 0.25, glide=True),
    ]


def seen(landmarks: Floats, z: Floats, mean: Floats, half: float) -> list[Layer]:
    """Le cercle de chaque distance, et sa tangente au point où le filtre se croyait."""
    turn = np.linspace(0.0, 2.0 * np.pi, 73)
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    rings: list[Layer] = [
        Polyline(place + max(float(read), 0.0) * circle, "measure", 1.5)
        for place, read in zip(landmarks, z, strict=True)
    ]
    away = mean[PLACE] - landmarks
    sight = away / np.maximum(np.hypot(*away.T), 1e-9)[:, None]
    feet, across = landmarks + z[:, None] * sight, sight @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    reach = 1.0 + half
    return [*rings, Segments(feet - reach * across, feet + reach * across, "ink", width=1.2, dashed=True)]


def doubt(tour: Round) -> Chart:
    moments = np.array(tour.moments)
    return Chart(
        "L'ellipse et l'erreur (m)",
        [
            Series("grand écart-type", "estimate", tour.axes[:, 1], moments),
            Series("petit écart-type", "second", tour.axes[:, 0], moments),
            Series("erreur", "truth", np.hypot(*tour.errors.T), moments, "dots"),
        ],
        "pas (prédiction, puis correction)",
        (0.0, None),
        cursor=tour.moments,
    )


def honesty(tour: Round) -> Chart:
    return Chart(
        "Le NEES de la place",
        [Series("NEES", "alert", tour.nees, np.array(tour.moments))],
        "pas",
        (0.0, None),
        levels=[Level(2.0, "moyenne d'un filtre honnête"), Level(LIMIT, "dépassé 1 fois sur 20", "second")],
        cursor=tour.moments,
    )


def summary(tour: Round, beacons: int) -> list[str]:
    axes, nees = tour.axes, tour.nees
    out = int(np.sum(nees[1::2] > LIMIT))
    small, large = axes[1].tolist()
    first = (
        f"à {decimal(small, 2)} m le long de la ligne de visée ; en travers, il vaut encore {decimal(large, 2)} m."
        if beacons == 1
        else f"à {decimal(large, 2)} m dans la pire direction, et {decimal(small, 2)} m dans la meilleure."
    )
    mean = float(nees[1::2].mean())
    texts = [
        f"La première mesure ramène l'écart-type de {decimal(float(axes[0, 0]), 2)} m {first}",
        f"À la fin du tour, il vaut {decimal(float(axes[-1, 1]), 2)} m dans la pire direction et "
        f"{decimal(float(axes[-1, 0]), 2)} m dans la meilleure ; le robot est à "
        f"{decimal(float(np.hypot(*tour.errors[-1])), 2)} m de la réponse.",
        f"Après les corrections, le NEES vaut {decimal(mean, 1 if mean < 100 else 0)} en moyenne ; il dépasse "
        f"{decimal(LIMIT, 1)} après {out} des {STEPS + 1} corrections.",
    ]
    if out > STEPS // 4:
        texts.append(
            "C'est trop : le cercle se courbe plus que l'ellipse n'est étroite, et le filtre se croit trop sûr."
        )
    return texts
