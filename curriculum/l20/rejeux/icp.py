"""ICP : associer chaque point au plus proche, déplacer, et recommencer."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from curriculum.l20.rejeux._carte import carte, contours, en_cases, pluriel
from graders.scene.packing import rounded
from graders.scene.replay import (
    Chart,
    Draw,
    Frame,
    Key,
    Layer,
    Level,
    Points,
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
from reference.registration import IcpResult, PairingRule, icp
from reference.se2 import transform, wrap_angle
from reference.world.simulation import SimulatedLidar

TITLE = "ICP : recaler un scan sur un autre"
ALT = (
    "Deux nuages de points pris dans la même pièce : les points bleus d'un premier scan, immobiles, et les points "
    "orange d'un second, mal placés. Des traits verts joignent chaque point orange au point bleu le plus proche ; puis "
    "les points orange glissent, et l'on recommence. Dessous, l'écart quadratique moyen décroît à chaque tour : "
    "jusqu'au bon recalage, ou vers un mauvais quand on part de trop loin."
)
PARAMETERS = {
    "rotation": Slider("Rotation de départ", -180, 180, 5, 30, "°"),
    "dx": Slider("Décalage en x", -4.0, 4.0, 0.25, 1.5, "case"),
    "dy": Slider("Décalage en y", -4.0, 4.0, 0.25, -1.0, "case"),
    "intrus": Slider("Points intrus", 0, 40, 5, 0, "%"),
    "bruit": Slider("Bruit du lidar σ", 0.0, 0.3, 0.02, 0.04, "case"),
    "elagage": Switch("Ne garder que les 70 % de paires les plus courtes"),
    "tirage": Draw(),
}
PREDICTION = Prediction(
    "On part d'un nuage trop tourné, de 60°. ICP apparie au plus proche, déplace, recommence. Où s'arrêtera-t-il ?",
    (
        ("bonne", "Au bon recalage, après plus de tours."),
        ("ailleurs", "À un autre recalage, faux."),
        ("jamais", "Nulle part : l'écart monte et descend sans fin."),
    ),
    right="ailleurs",
    why=(
        "L'écart descend à chaque tour, c'est un théorème, et tout s'arrête après 28 tours ; mais à 89° de la bonne "
        "pose. Les plus proches voisins étaient de faux partenaires, et la pièce se ressemble quand on la tourne d'un "
        "quart de tour : c'est un minimum local."
    ),
    settings={"rotation": "60"},
)
FIRST, SECOND = np.array([11.0, 4.0, 0.0]), np.array([11.4, 3.9, 0.4])
BEAMS, REACH = 90, 7.0
MOST = 60
KEPT = 0.7
STILL = 2e-3
NEAR, ALIGNED = 0.3, np.radians(4.0)
ROTATIONS = np.arange(-180, 181, 15)


@dataclass(frozen=True)
class Course:
    """Les poses de départ et d'arrivée de chaque tour, les paires au départ, et leur écart quadratique moyen."""

    poses: list[np.ndarray]
    pairs: list[np.ndarray]
    weights: list[np.ndarray]
    gaps: list[float]
    converged: bool


def compute(values: Values, rng: np.random.Generator) -> Replay:
    lidar = SimulatedLidar.full_turn(BEAMS, REACH, values.number("bruit"))
    q, p = scan_points(FIRST, lidar, rng), strange(scan_points(SECOND, lidar, rng), values.number("intrus"), rng)
    q = transform(FIRST, q)
    pairing = PairingRule(keep=KEPT if values.flag("elagage") else 1.0)
    shift = np.array([values.number("dx"), values.number("dy"), 0.0])
    rotation = values.number("rotation")
    course = follow(p, q, guess(rotation, shift), pairing)
    ends = [abs_angle(settled(p, q, guess(angle, shift), pairing)) for angle in ROTATIONS]
    frames, moments = pictures(course, p, q)
    return Replay(
        View(4.5, -1.2, 18.5, 9.2),
        frames,
        summary(course, ends, values),
        layers=[contours_faint(), Points(q, "truth", size=3.0), Pose(FIRST, "truth", style="ghost", radius=0.3)],
        charts=[
            Chart(
                "Écart quadratique moyen des paires (racine de E / n, en cases)",
                [Series("écart", "alert", course.gaps, style="line")],
                "tour",
                (0.0, None),
                cursor=moments,
            ),
            Chart(
                "Et d'où que l'on parte ? Angle d'arrivée selon l'angle de départ",
                [Series("erreur d'angle à l'arrivée (°)", "second", ends, ROTATIONS)],
                "rotation de départ (°)",
                (0.0, 190.0),
                levels=[Level(0.0, "bon recalage", "measure")],
                cursor=[rotation] * len(frames),
                timeless=True,
            ),
        ],
        legend=[
            Key("dot", "truth", "premier scan"),
            Key("dot", "estimate", "second scan"),
            Key("line", "measure", "paire"),
            *([Key("line", "faint", "paire écartée")] if values.flag("elagage") else []),
            Key("arrow", "estimate", "pose cherchée"),
        ],
        period=0.6,
    )


def scan_points(pose: np.ndarray, lidar: SimulatedLidar, rng: np.random.Generator) -> np.ndarray:
    """Les points d'un scan, dans le repère du robot."""
    ranges = lidar.measure_ranges(carte(), [pose], rng)[0]
    hit = ranges < REACH
    return np.column_stack([ranges * np.cos(lidar.angles), ranges * np.sin(lidar.angles)])[hit]


def strange(points: np.ndarray, share: float, rng: np.random.Generator) -> np.ndarray:
    """Les mêmes points, dont une part (en pour cent) est remplacée par n'importe quoi."""
    wrong = rng.permutation(len(points))[: round(len(points) * share / 100.0)]
    radius, angle = 5.0 * np.sqrt(rng.random(len(wrong))), 2.0 * np.pi * rng.random(len(wrong))
    cloud = points.copy()
    cloud[wrong] = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    return cloud


def guess(rotation: float, shift: np.ndarray) -> np.ndarray:
    return SECOND + shift + np.array([0.0, 0.0, np.radians(rotation)])


def follow(p: np.ndarray, q: np.ndarray, start: np.ndarray, pairing: PairingRule) -> Course:
    """ICP un tour à la fois, jusqu'à ce que plus rien ne bouge."""
    state = icp(p, q, start, pairing=pairing, max_iterations=0)
    course = Course([state.T_q_p], [state.pairs], [state.weights], [mean_gap(state)], False)
    while len(course.poses) <= MOST:
        state = icp(p, q, course.poses[-1], pairing=pairing, max_iterations=1)
        step = state.T_q_p - course.poses[-1]
        course.poses.append(state.T_q_p)
        course.pairs.append(state.pairs)
        course.weights.append(state.weights)
        course.gaps.append(mean_gap(state))
        if max(abs(step[0]), abs(step[1]), abs(wrap_angle(float(step[2])))) < STILL:
            return Course(course.poses, course.pairs, course.weights, course.gaps, True)
    return course


def settled(p: np.ndarray, q: np.ndarray, start: np.ndarray, pairing: PairingRule) -> np.ndarray:
    """Où finit `follow`, d'un seul trait."""
    return icp(p, q, start, pairing=pairing, max_iterations=MOST, tolerance=STILL).T_q_p


def mean_gap(state: IcpResult) -> float:
    """La racine de E / n, telle que la courbe la reçoit : la légende dit alors le même nombre qu'elle."""
    return float(rounded(float(np.sqrt(state.errors[-1] / np.count_nonzero(state.weights)))) or 0.0)


def pictures(course: Course, p: np.ndarray, q: np.ndarray) -> tuple[list[Frame], list[float]]:
    frames, moments = [], []
    for k, pose in enumerate(course.poses):
        moved = transform(pose, p)
        pairs, kept = q[course.pairs[k]], course.weights[k] > 0.0
        text = f"Tour {k} : on associe. L'écart quadratique moyen vaut {en_cases(course.gaps[k])}."
        frames.append(Frame(layers(pose, moved, moved, pairs, kept), text, k))
        moments.append(float(k))
        if k + 1 < len(course.poses):
            after = course.poses[k + 1]
            there = transform(after, p)
            text = f"Tour {k + 1} : on déplace le nuage d'un seul bloc, au mieux pour ces paires."
            frames.append(Frame(layers(after, there, there, pairs, kept, glide=True), text, k))
            moments.append(k + 0.6)
    return frames, moments


def layers(
    pose: np.ndarray, moved: np.ndarray, starts: np.ndarray, ends: np.ndarray, kept: np.ndarray, glide: bool = False
) -> list[Layer]:
    return [
        Segments(starts[kept], ends[kept], "measure", width=1.4, opacity=0.8, glide=glide),
        Segments(starts[~kept], ends[~kept], "faint", width=1.0, glide=glide),
        Points(moved, "estimate", size=3.0, glide=glide),
        Pose(pose, "estimate", radius=0.35, glide=glide),
    ]


@cache
def contours_faint() -> Segments:
    walls = contours()
    return Segments(walls.starts, walls.ends, "faint", width=1.5)


def abs_angle(pose: np.ndarray) -> float:
    return float(np.degrees(abs(wrap_angle(float(pose[2] - SECOND[2])))))


def summary(course: Course, ends: list[float], values: Values) -> list[str]:
    away = float(np.hypot(*(course.poses[-1] - SECOND)[:2]))
    angle = abs_angle(course.poses[-1])
    turns = len(course.poses) - 1
    texts = [
        f"L'écart quadratique moyen passe de {en_cases(course.gaps[0])} à {en_cases(course.gaps[-1])} en "
        f"{pluriel(turns, 'tour', 'tours')}."
    ]
    if not course.converged:
        texts.append("Le nuage bouge encore : on s'est arrêté là.")
    reached = f"La pose trouvée est à {en_cases(away)} et {decimal(angle, 1)}° de la vraie"
    if away < NEAR and angle < np.degrees(ALIGNED):
        texts.append(f"{reached} : le recalage est bon.")
    else:
        texts.append(
            f"{reached} : autour d'elle, plus rien ne fait baisser l'écart, mais ce n'est pas la bonne. C'est un "
            f"minimum local."
        )
    good = sum(angle < np.degrees(ALIGNED) for angle in ends)
    texts.append(f"Avec ce décalage, {good} des {len(ends)} angles de départ essayés mènent au bon angle.")
    if values.number("intrus") and not values.flag("elagage"):
        texts.append("Les intrus tirent le nuage vers eux : essayez de ne garder que les paires courtes.")
    return texts
