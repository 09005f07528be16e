"""Huit boucles du laboratoire d'Intel : le lecteur accepte ou refuse chacune, et voit ce que la carte devient."""

from __future__ import annotations

from functools import cache

import numpy as np

from curriculum.l20.rejeux import laboratoire
from curriculum.l20.rejeux._carte import milliers, pluriel
from graders.l20.tp_slam import journeys
from graders.scene.replay import (
    Chart,
    Frame,
    Key,
    Layer,
    Level,
    Mark,
    Points,
    Polyline,
    Pose,
    Prediction,
    Replay,
    Segments,
    Series,
    Switch,
    Values,
    View,
    decimal,
)
from reference.metrics import absolute_trajectory_error
from reference.se2 import compose, transform

TITLE = "Juger les boucles une par une"
ALT = (
    "Deux plans côte à côte. À gauche, deux scans d'un même couloir, à l'endroit où la boucle examinée les superpose, "
    "et une flèche : de là où les recalages mettent le robot jusque là où la boucle le voudrait. À droite, la carte "
    "faite des 120 scans, avec les boucles acceptées en vert ; une fausse y dédouble un couloir. Dessous, la "
    "correction que chaque boucle réclame."
)
#: Des vingt-trois boucles du TP, dans leur ordre : cinq vraies, trois fausses.
CHOSEN = (1, 3, 5, 8, 10, 13, 15, 20)
NAMES = tuple(f"b{k}" for k in range(1, len(CHOSEN) + 1))
PARAMETERS = {
    **{name: Switch(f"Accepter la boucle {name[1:]}") for name in NAMES},
    "reponse": Switch("Dire lesquelles sont fausses"),
}
PREDICTION = Prediction(
    "Trois de ces huit boucles sont fausses. Dans toutes, les deux scans s'accordent bien : au moins sept points sur "
    "dix trouvent un voisin. À quoi reconnaît-on les fausses, sans connaître la vérité ?",
    (
        ("part", "À la part des points qui s'accordent : c'est dans les fausses qu'elle est la plus petite."),
        ("desaccord", "À ce qu'elles réclament : une autre correction que la plupart."),
        ("temps", "Au temps écoulé : elles relient les scans les plus éloignés l'un de l'autre."),
    ),
    right="desaccord",
    why=(
        "Cinq boucles réclament de déplacer le robot de 30 à 70 cm, à peu près dans la même direction : c'est la "
        "dérive. Les boucles 1, 5 et 6 réclament plus d'un mètre, dans d'autres directions : le long d'un couloir, un "
        "scan glisse. La part ne dit rien : la fausse boucle 1 a 90 % de points d'accord, la vraie boucle 8 en a 70 %."
    ),
    settings={"reponse": "1"},
)
#: Côté des carrés que l'on compte, et marge autour de ce que les boucles superposent, en mètres.
SQUARE, MARGIN = 0.1, 0.7
THIN = 3
EXAMINED, MAP = 0, 1
PANELS = ("La boucle examinée", "Votre carte, au même endroit")


def compute(values: Values, rng: np.random.Generator) -> Replay:
    closing, told = laboratoire.loops(), values.flag("reponse")
    accepted = np.zeros(len(closing.pairs), dtype=np.bool_)
    accepted[[loop for loop, name in zip(CHOSEN, NAMES, strict=True) if values.flag(name)]] = True
    place = journeys.indoor()
    path = laboratoire.estimated("graphe", len(place.truth), accepted)
    walls = laboratoire.placed(path, [cloud[::THIN] for cloud in place.clouds])
    return Replay(
        view(),
        [picture(rank, loop, bool(accepted[loop]), told) for rank, loop in enumerate(CHOSEN, start=1)],
        summary(path, accepted, told),
        layers=[
            Points(walls, "ink", 1.0, opacity=0.5, panel=MAP),
            Polyline(path[:, :2], "estimate", 1.5, panel=MAP),
            *drawn(path, accepted, told),
        ],
        charts=[wanted_chart(told)],
        legend=[
            Key("dot", "ink", "scan d'avant, et la carte"),
            Key("dot", "measure", "scan d'après, là où la boucle le met"),
            Key("line", "second", "la correction que la boucle réclame"),
            Key("line", "measure", "boucle acceptée"),
            Key("line", "estimate", "trajectoire, et robot selon les recalages"),
            *([Key("line", "alert", "fausse boucle")] if told else []),
        ],
        period=2.0,
        panels=PANELS,
    )


@cache
def chain() -> np.ndarray:
    """Les poses que donnent les recalages mis bout à bout."""
    return journeys.added_up(journeys.matched_indoor().matches)


def wanted(loop: int) -> np.ndarray:
    """La pose où la boucle voudrait le robot à son second scan."""
    closing = laboratoire.loops()
    return compose(chain()[closing.pairs[loop, 0]], closing.poses[loop])


def correction(loop: int) -> np.ndarray:
    """Ce dont la boucle veut déplacer le robot, en mètres."""
    return wanted(loop)[:2] - chain()[laboratoire.loops().pairs[loop, 1], :2]


def superposed(loop: int) -> tuple[np.ndarray, np.ndarray]:
    """Les points du premier scan d'une boucle, et ceux du second là où elle le pose."""
    (a, b), clouds = laboratoire.loops().pairs[loop].tolist(), journeys.indoor().clouds
    return transform(chain()[a], clouds[a]), transform(wanted(loop), clouds[b])


def picture(rank: int, loop: int, accepted: bool, told: bool) -> Frame:
    """Les deux scans d'une boucle, tels qu'elle les superpose."""
    a, b = laboratoire.loops().pairs[loop].tolist()
    (before, after), target = superposed(loop), wanted(loop)
    layers: list[Layer] = [
        Points(before, "ink", 2.0, panel=EXAMINED),
        Points(after, "measure", 2.0, panel=EXAMINED),
        Segments([chain()[b, :2]], [target[:2]], "second", width=3.0, panel=EXAMINED),
        Pose(target, "measure", 0.5, panel=EXAMINED),
        Pose(chain()[b], "estimate", 0.5, style="ghost", panel=EXAMINED),
    ]
    x, y = correction(loop)
    share = round(100 * float(journeys.matched_indoor().shares[loop]))
    answer = "acceptée" if accepted else "refusée"
    false = laboratoire.loops().false[loop]
    verdict = f" Elle est {'fausse' if false else 'vraie'}." if told else ""
    return Frame(
        layers,
        f"Boucle {rank}, {answer} : le scan {b + 1} reverrait le lieu du scan {a + 1}. {share} % de points d'accord ; "
        f"elle déplacerait le robot de ({decimal(x, 2)} ; {decimal(y, 2)}) m.{verdict}",
    )


def drawn(path: np.ndarray, accepted: np.ndarray, told: bool) -> list[Layer]:
    """Sur la carte, les boucles acceptées ; une fausse n'est rouge que si le lecteur a demandé la réponse."""
    closing = laboratoire.loops()
    red = accepted & closing.false & told
    layers: list[Layer] = []
    for chosen, color in ((accepted & ~red, "measure"), (red, "alert")):
        a, b = closing.pairs[chosen].T
        layers.append(Segments(path[a, :2], path[b, :2], color, width=2.5, panel=MAP))
    return layers


def wanted_chart(told: bool) -> Chart:
    """La correction que chaque boucle réclame, selon x et selon y."""
    asked = np.array([correction(loop) for loop in CHOSEN])
    ranks = np.arange(1, len(CHOSEN) + 1)
    false = laboratoire.loops().false[list(CHOSEN)]
    series = [
        Series("selon x", "measure", asked[:, 0], ranks, style="dots"),
        Series("selon y", "second", asked[:, 1], ranks, style="dots"),
    ]
    return Chart(
        "La correction que chaque boucle réclame (m)",
        series,
        "boucle",
        (-1.25, 1.25),
        levels=[Level(0.0, "aucune", "faint")],
        marks=[Mark(float(rank), "fausse") for rank in ranks[false]] if told else [],
        cursor=ranks.tolist(),
        timeless=True,
    )


def squares(path: np.ndarray) -> int:
    """Combien de carrés de 10 cm contiennent un point : un mur bien refermé en occupe moins."""
    points = laboratoire.placed(path, list(journeys.indoor().clouds))
    return len(np.unique(np.floor(points / SQUARE).astype(np.int64), axis=0))


@cache
def view() -> View:
    """Les deux scans de chaque boucle, tels qu'elle les superpose, et les places du robot."""
    seen = [points for loop in CHOSEN for points in superposed(loop)]
    places = [np.array([wanted(loop)[:2], chain()[laboratoire.loops().pairs[loop, 1], :2]]) for loop in CHOSEN]
    return laboratoire.view(*seen, *places, margin=MARGIN)


def summary(path: np.ndarray, accepted: np.ndarray, told: bool) -> list[str]:
    closing = laboratoire.loops()
    count = int(np.sum(accepted))
    kept = f"{pluriel(count, 'boucle acceptée', 'boucles acceptées') if count else 'Aucune boucle'} sur {len(CHOSEN)}"
    sharp = (
        f"La carte occupe {milliers(squares(path))} carrés de 10 cm. Ce compte juge toutes les boucles acceptées "
        "ensemble, pas la dernière cochée : cherchez le choix qui en laisse le moins."
    )
    if not told:
        return [f"{kept}.", sharp]
    false = int(np.sum(accepted & closing.false))
    wrong = [str(rank) for rank, loop in enumerate(CHOSEN, start=1) if closing.false[loop]]
    error = absolute_trajectory_error(journeys.indoor().truth, path).rmse
    among = f", dont {pluriel(false, 'fausse', 'fausses') if false else 'aucune fausse'}" if count else ""
    return [
        f"{kept}{among}. Les boucles {', '.join(wrong[:-1])} et {wrong[-1]} sont fausses.",
        sharp,
        f"L'écart de la carte aux poses du journal est de {decimal(error, 2)} m.",
    ]
