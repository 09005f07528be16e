"""Le lidar : des rayons qui s'arrêtent aux murs, et le scan qu'ils forment une fois déroulés."""

from __future__ import annotations

import math

import numpy as np

from curriculum.l20.rejeux._carte import carte, murs, pluriel, plus_proche_libre, vue
from graders.scene.replay import (
    Chart,
    Dragged,
    Draw,
    Frame,
    Key,
    Level,
    Pose,
    Prediction,
    Rays,
    Replay,
    Segments,
    Series,
    Slider,
    Values,
    decimal,
)
from reference.world.scan import full_turn_angles
from reference.world.simulation import SimulatedLidar

TITLE = "Ce que voit le lidar"
ALT = (
    "Le plan d'un étage, vu de dessus : cinq pièces autour d'un couloir. Un robot y envoie des rayons tout autour de "
    "lui ; chacun s'arrête au premier mur, ou à la portée du capteur. Dessous, une courbe donne la distance lue par "
    "chaque rayon, selon son angle."
)
PARAMETERS = {
    "pose": Dragged("Robot", (11.5, 8.2, 0.349066), (0.0, 0.0, 24.0, 16.0)),
    "rayons": Slider("Nombre de rayons", 4, 180, 4, 36),
    "portee": Slider("Portée", 2, 24, 1, 9, "cases"),
    "bruit": Slider("Bruit (écart-type)", 0.0, 1.0, 0.05, 0.0, "case"),
    "tirage": Draw(),
}
PREDICTION = Prediction(
    "Ramenons la portée à 4 cases. Que lira un rayon qui part vers un mur plus éloigné ?",
    (
        ("zero", "0 : il n'a rien touché."),
        ("portee", "4 cases, la portée."),
        ("distance", "La distance du mur, même s'il est plus loin."),
        ("hasard", "Un nombre quelconque."),
    ),
    right="portee",
    why=(
        "Il lit la portée, 4 cases : cela ne dit pas qu'un mur est là, mais qu'il n'y en a pas avant. Ici, 22 des 36 "
        "rayons sont dans ce cas ; ce sont les tirets du dessin, et la courbe s'y aplatit sur le trait de la portée."
    ),
    settings={"portee": "4"},
)
SECONDS = 5.0


def compute(values: Values, rng: np.random.Generator) -> Replay:
    x, y, theta = values.pose("pose")
    pose = np.array([*plus_proche_libre(x, y), theta])
    count, reach, sigma = values.whole("rayons"), float(values.whole("portee")), values.number("bruit")
    lidar = SimulatedLidar.full_turn(count, reach, sigma)
    true = carte().cast_scans([pose], lidar.angles, reach)[0]
    read = lidar.add_noise(true, rng)
    headings = pose[2] + lidar.angles
    ends = pose[:2] + read[:, None] * np.column_stack([np.cos(headings), np.sin(headings)])
    hits = read < reach
    degrees = np.degrees(full_turn_angles(count))
    frames = [
        Frame([Segments(pose[None, :2], ends[k : k + 1], "alert", width=2.5)], caption(k, degrees[k], read[k], hits[k]))
        for k in range(count)
    ]
    curves = [Series("distance lue", "measure", read, degrees, "dots" if sigma else "line")]
    if sigma:
        curves.insert(0, Series("distance exacte", "truth", true, degrees))
    return Replay(
        vue(),
        frames,
        summary(pose, read, true, hits, reach, sigma),
        layers=[murs(), Rays(pose[:2], ends, hits=hits, until=range(1, count + 1))],
        over=[Pose(pose, "truth", drag="pose")],
        charts=[
            Chart(
                "Le scan déroulé : distance lue selon l'angle du rayon",
                curves,
                "angle du rayon, depuis le cap du robot (°)",
                (0.0, reach * 1.18),
                levels=[Level(reach, "portée")],
                cursor=degrees,
            )
        ],
        legend=[
            Key("robot", "truth", "le robot, à déplacer"),
            Key("line", "measure", "rayon qui touche un mur"),
            Key("dashed", "faint", "rayon qui ne touche rien"),
        ],
        period=SECONDS / count,
        begin_at_end=True,
    )


def caption(k: int, degrees: float, distance: float, hit: bool) -> str:
    end = f"il lit {decimal(distance, 2)} cases" if hit else "il ne touche rien et lit la portée"
    return f"Rayon {k}, à {degrees:.0f}° du cap : {end}."


def summary(
    pose: np.ndarray, read: np.ndarray, true: np.ndarray, hits: np.ndarray, reach: float, sigma: float
) -> list[str]:
    touching, lost = int(np.count_nonzero(hits)), int(np.count_nonzero(~hits))
    angle = round(math.degrees(pose[2]))
    texts = [
        f"Le robot est en x = {decimal(pose[0], 2)} et y = {decimal(pose[1], 2)}, tourné de {angle}°.".replace(
            "-", "−"
        ),
        f"Il lance {len(read)} rayons, un tous les {decimal(360 / len(read), 1)}°".replace(",0°", "°") + ".",
    ]
    if touching:
        least, most = decimal(read[hits].min(), 2), decimal(read[hits].max(), 2)
        texts.append(f"{pluriel(touching, 'touche', 'touchent')} un mur, à des distances de {least} à {most} cases.")
    if lost:
        texts.append(
            f"{pluriel(lost, 'ne touche', 'ne touchent')} rien avant {reach:.0f} cases : une lecture égale à la "
            f"portée dit seulement que le mur est plus loin."
        )
    if sigma:
        gap = float(np.sqrt(np.mean((read - true) ** 2)))
        texts.append(f"Le bruit écarte les lectures de {decimal(gap, 2)} case en moyenne quadratique.")
    return texts
