"""La carte d'occupation : chaque scan vote pour des cases libres et des cases pleines, là où le robot se croit."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from curriculum.l20.rejeux._carte import carte, contours, en_cases, pluriel
from graders.scene.replay import (
    Chart,
    Choice,
    Draw,
    Frame,
    Grid,
    Key,
    Layer,
    Polyline,
    Pose,
    Prediction,
    Rays,
    Replay,
    Series,
    Slider,
    Values,
    View,
    decimal,
)
from reference.occupancy import InverseSensorModel, OccupancyGrid, log_odds
from reference.odometry import DifferentialDrive
from reference.se2 import wrap_angle
from reference.world.simulation import SimulatedLidar, SimulatedRun, motions_through_waypoints, simulate

TITLE = "La carte d'occupation, scan après scan"
ALT = (
    "Une grille fine, grise au départ : on n'en sait rien. Un robot la parcourt ; à chaque scan, les cases traversées "
    "par un rayon s'éclaircissent et celles qui l'arrêtent s'assombrissent. Un fin contour bleu montre les vrais murs. "
    "Avec les vraies poses, les murs dessinés le suivent ; avec celles de l'odométrie, ils se dédoublent et penchent."
)
PARAMETERS = {
    "poses": Choice(
        "Poses utilisées",
        (("vraies", "les vraies"), ("odometrie", "celles de l'odométrie"), ("ecart", "l'écart entre les deux cartes")),
        "vraies",
    ),
    "derive": Slider("Dérive de l'odométrie", 0.0, 3.0, 0.1, 0.8, "%"),
    "rayons": Slider("Rayons par scan", 8, 120, 4, 60),
    "portee": Slider("Portée", 3, 16, 1, 8, "cases"),
    "confiance": Slider("Confiance dans un rayon p", 0.55, 0.95, 0.05, 0.7),
    "bruit": Slider("Bruit du lidar σ", 0.0, 0.5, 0.05, 0.05, "case"),
    "tirage": Draw(default=1),
}
PREDICTION = Prediction(
    "Les mêmes scans, mais placés aux poses que donne l'odométrie, qui dérive un peu. Quelle carte obtiendra-t-on ?",
    (
        ("bonne", "La même, ou presque : des dizaines de scans compensent une petite dérive."),
        ("trouee", "Une carte juste, mais pleine de trous."),
        ("double", "Une carte dont les murs penchent et se dédoublent."),
    ),
    right="double",
    why=(
        "Au retour, l'odométrie se trompe de 2 cases et de 8°, et chaque scan est écrit là où le robot se croit : les "
        "murs vus deux fois sont dessinés deux fois. Des cases connues, 19 % sont fausses, contre 2 % "
        "avec les vraies poses."
    ),
    settings={"poses": "odometrie"},
)
START = (3.5, 3.5, 0.0)
ROUTE = (
    (11.5, 3.5), (11.5, 7.9), (19.5, 7.9), (19.5, 5.5), (19.5, 7.9), (17.5, 7.9), (17.5, 13.5), (7.6, 13.5),
    (7.5, 10.6), (4.5, 10.6), (4.5, 7.9), (3.5, 7.9), (3.5, 3.5),
)  # fmt: skip
STRIDE, TURN, TRACK = 1.2, 1.2, 0.5
SIDE, MARGIN = 0.25, 1.0
SURE = 0.6
LEVELS = 32


@dataclass(frozen=True)
class Score:
    """Parmi les cases de la carte, la part connue ; parmi celles-ci, la part fausse. En pour cent."""

    known: float
    wrong: float


@cache
def true_cells() -> np.ndarray:
    """Les vrais murs sur la grille fine, marge comprise : tout ce qui entoure le plan est un mur."""
    parts = round(1.0 / SIDE)
    return np.pad(
        ~np.kron(carte().free, np.ones((parts, parts), dtype=bool)), round(MARGIN / SIDE), constant_values=True
    )


@cache
def inside() -> np.ndarray:
    """Les cases que le robot pourrait voir : les cases libres, et les murs qui les touchent."""
    free = ~true_cells()
    near = free.copy()
    for shift in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        near |= np.roll(free, shift, (0, 1))
    return near


def compute(values: Values, rng: np.random.Generator) -> Replay:
    drive = DifferentialDrive(TRACK, sigma_per_root_metre=values.number("derive") / 100.0)
    reach = float(values.whole("portee"))
    lidar = SimulatedLidar.full_turn(values.whole("rayons"), reach, values.number("bruit"))
    run = simulate(carte(), motions_through_waypoints(START, ROUTE, STRIDE, TURN), START, drive, lidar, rng)
    confidence = float(log_odds(values.number("confiance")))
    model = InverseSensorModel(confidence, -confidence, once_a_scan=True)
    mode = values.choice("poses")
    frames, scores = draw(run, mode, model)
    height, width = carte().shape
    count = np.arange(1, len(run) + 1)
    paths: list[Layer] = [Polyline(run.truth[:, :2], "truth", 1.5, until=count)]
    legend = [Key("line", "truth", "vrais murs, vrai trajet"), Key("cell", "ink", "case jugée pleine")]
    if mode != "vraies":
        paths.append(Polyline(run.odometry[:, :2], "estimate", 1.5, until=count))
        legend.append(Key("line", "estimate", "trajet selon l'odométrie"))
    if mode == "ecart":
        legend[1:2] = [
            Key("cell", "alert", "plus pleine avec l'odométrie"),
            Key("cell", "truth", "plus pleine avec les vraies poses"),
        ]
    return Replay(
        View(-MARGIN, -MARGIN, width + MARGIN, height + MARGIN),
        frames,
        summary(run, scores, mode),
        over=[contours(), *paths],
        charts=[
            Chart(
                "Ce que vaut la carte" + (" de l'odométrie" if mode != "vraies" else " dressée avec les vraies poses"),
                [
                    Series("cases connues (%)", "measure", [quality.known for quality in scores]),
                    Series("dont fausses (%)", "alert", [quality.wrong for quality in scores]),
                ],
                "scan",
                (0.0, 100.0),
            )
        ],
        legend=legend,
        period=0.22,
    )


def draw(run: SimulatedRun, mode: str, model: InverseSensorModel) -> tuple[list[Frame], list[Score]]:
    """Les images, et la note à chaque scan de la carte dressée avec les poses choisies."""
    shape, corner = true_cells().shape, np.array([-MARGIN, -MARGIN, 0.0])
    believed, exact = (OccupancyGrid(np.zeros(shape), SIDE, corner, model) for _ in range(2))
    poses = run.truth if mode == "vraies" else run.odometry
    frames, scores = [], []
    for k in range(len(run)):
        scan = run.scan(k)
        believed.integrate(scan, poses[k])
        p = believed.probabilities
        scores.append(score(p))
        layers: list[Layer] = []
        if mode == "ecart":
            exact.integrate(scan, run.truth[k])
            gap = (p - exact.probabilities + 1.0) / 2.0
            layers.append(Grid(coarse(gap), "difference", (-MARGIN, -MARGIN), SIDE))
        else:
            headings = poses[k, 2] + scan.angles
            ends = poses[k, :2] + scan.ranges[:, None] * np.column_stack([np.cos(headings), np.sin(headings)])
            layers.append(Grid(coarse(p), "occupancy", (-MARGIN, -MARGIN), SIDE))
            layers.append(Rays(poses[k, :2], ends, hits=scan.hit_mask))
        if mode != "vraies":
            layers.append(Pose(run.odometry[k], "estimate", glide=True))
        layers.append(Pose(run.truth[k], "truth", style="robot" if mode == "vraies" else "ghost", glide=True))
        away = float(np.hypot(*(poses[k] - run.truth[k])[:2]))
        text = f"Scan {k + 1} : {decimal(scores[-1].known, 0)} % des cases sont connues"
        text += f" ; l'odométrie se trompe de {en_cases(away)}." if mode != "vraies" else "."
        frames.append(Frame(layers, text))
    return frames, scores


def coarse(values: np.ndarray) -> np.ndarray:
    """Peu de niveaux : l'œil n'y perd rien, et l'image tient en peu d'octets."""
    return np.round(values * LEVELS) / LEVELS


def score(p: np.ndarray) -> Score:
    known = inside() & (np.abs(p - 0.5) > SURE - 0.5)
    wrong = known & ((p > 0.5) != true_cells())
    return Score(
        100.0 * np.count_nonzero(known) / np.count_nonzero(inside()),
        100.0 * np.count_nonzero(wrong) / max(1, np.count_nonzero(known)),
    )


def summary(run: SimulatedRun, scores: list[Score], mode: str) -> list[str]:
    away = np.hypot(*(run.odometry - run.truth)[:, :2].T)
    turned = abs(np.degrees(wrap_angle(float(run.odometry[-1, 2] - run.truth[-1, 2]))))
    last = scores[-1]
    texts = [
        f"En {pluriel(len(run), 'scan', 'scans')}, le robot fait le tour de l'étage et revient à son point de départ.",
    ]
    if mode == "vraies":
        texts.append("Chaque scan est posé là où le robot était vraiment : les votes se confirment.")
    else:
        texts.append(f"À l'arrivée, l'odométrie se trompe de {en_cases(away[-1], 1)} et de {decimal(turned, 0)}°.")
    texts.append(
        f"La carte connaît {decimal(last.known, 0)} % des cases, et s'y trompe sur {decimal(last.wrong, 1)} % d'entre "
        f"elles."
    )
    if mode != "vraies" and last.wrong > 10.0:
        texts.append("Les mêmes scans auraient donné une bonne carte : ce sont les poses qui la gâtent.")
    return texts
