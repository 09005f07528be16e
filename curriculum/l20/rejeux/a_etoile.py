"""A* : une vague qui cherche le but, et un chemin qui garde ses distances avec les murs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from curriculum.l20.rejeux._carte import en_cases
from graders.scene.replay import (
    Chart,
    Choice,
    Dragged,
    Frame,
    Grid,
    Key,
    Layer,
    Level,
    Placed,
    Polyline,
    Pose,
    Replay,
    Series,
    Slider,
    Values,
    View,
    decimal,
)
from reference.planning import InflatedGrid, Route, SearchGrid, UnreachableError, inflate
from reference.world.distance_map import distances_to_cells
from reference.world.grid_map import GridMap

TITLE = "A* cherche un chemin"
ALT = (
    "Un plan vu de dessus : une grande pièce à gauche, deux à droite, une porte étroite et deux passages larges. "
    "Autour des murs, une bande rouge indique les cases trop proches. Depuis le robot, une vague de cases colorées "
    "s'étend jusqu'à la cible ; un trait orange montre enfin le chemin. Une courbe donne la distance au mur le plus "
    "proche tout au long de ce chemin."
)
PARAMETERS = {
    "but": Dragged("But", (20.5, 2.5, 0.0), (0.5, 0.5, 23.5, 15.5), step=0.25, turns=False),
    "methode": Choice(
        "Méthode",
        (
            ("dijkstra", "Dijkstra (sans heuristique)"),
            ("a-etoile", "A*"),
            ("pondere2", "A* pondéré, × 2"),
            ("pondere5", "A* pondéré, × 5"),
        ),
        "a-etoile",
    ),
    "rayon": Slider("Rayon du robot", 0.0, 1.5, 0.25, 0.25, "case"),
    "prudence": Slider("Coût d'inflation, au bord d'un mur", 0, 20, 1, 3),
}
PREDICTION = Placed(
    "Pour un robot dont le rayon est de 0,25 case, le chemin fait 19,2 cases et passe par la porte du haut. En voici "
    "un trois fois plus large, de rayon 0,75 case. Placez le point où il sera à mi-chemin.",
    spots=((10.94, 11.83),),
    box=(0.0, 0.0, 24.0, 16.0),
    near=2.0,
    far=5.0,
    why=(
        "À mi-chemin, il est en x = 10,9 et y = 11,8, tout en bas. La porte du haut est devenue trop étroite : les "
        "bandes interdites, de part et d'autre, s'y rejoignent. A* fait le tour, et le chemin fait 31,5 cases : pour "
        "un robot plus large, la carte n'est plus la même."
    ),
    settings={"rayon": "0.75"},
)
PLAN = """
########################
#......#...............#
#......#...............#
#......#...............#
#.................##...#
#......#..........##...#
#......#...............#
#......#######...#######
#......#...............#
#......#...............#
#......#.......##......#
#..............##......#
#..............##......#
#......................#
#......#...............#
########################
"""
START = (2.5, 3.5)
FINE = 3
FALL = 1.5
WAVE, WALK = 60, 20
WEIGHTS = {"a-etoile": 1.0, "pondere2": 2.0, "pondere5": 5.0}
NAMES = {"dijkstra": "Dijkstra", "a-etoile": "A*", "pondere2": "A* pondéré", "pondere5": "A* pondéré"}


@dataclass(frozen=True)
class Search:
    """Ce qu'une méthode a trouvé : un chemin ou rien, et les cellules explorées dans l'ordre."""

    route: Route | None
    order: np.ndarray


@cache
def free() -> np.ndarray:
    """Le plan, chaque case coupée en neuf."""
    return np.kron(GridMap.from_text(PLAN).free, np.ones((FINE, FINE), dtype=bool))


def compute(values: Values, rng: np.random.Generator) -> Replay:
    radius, price, method = values.number("rayon"), values.number("prudence"), values.choice("methode")
    space = inflate(free(), radius * FINE, weight=price, fall=FALL / FINE)
    start, goal = nearest(START, space.free), nearest(values.pose("but")[:2], space.free)
    result = search(space, start, goal, method)
    others = {name: search(space, start, goal, name) for name in ("dijkstra", "a-etoile")}
    frames, shown, walked = pictures(result)
    height, width = (side / FINE for side in free().shape)
    over: list[Layer] = []
    path = np.zeros((0, 2))
    if result.route is not None:
        path = result.route.cell_centres / FINE
        over.append(Polyline(path, "estimate", 4.0, until=walked))
    target = (np.array(goal[::-1]) + 0.5) / FINE
    robot = (np.array(start[::-1]) + 0.5) / FINE
    return Replay(
        View(0, 0, width, height),
        frames,
        summary(result, others, method, radius, path),
        layers=[
            Grid(cost_cells(space, price), "cost", cell=1.0 / FINE),
            Grid(order_cells(result.order), "order", cell=1.0 / FINE, until=shown),
            Grid(~free(), "walls", cell=1.0 / FINE),
        ],
        over=[
            *over,
            Pose([*robot, 0.0], "truth", radius=max(0.3, radius)),
            Pose([*target, 0.0], "alert", radius=0.5, style="target", drag="but"),
        ],
        charts=[clearance(path, walked, radius)] if len(path) else [],
        legend=[
            Key("robot", "truth", "départ"),
            Key("ring", "alert", "but, à déplacer"),
            Key("cell", "accent", "exploré tôt"),
            Key("cell", "second", "exploré tard"),
            Key("area", "alert", "trop près d'un mur, ou cher"),
            Key("line", "estimate", "chemin"),
        ],
        period=0.08,
        begin_at_end=True,
    )


def nearest(point: tuple[float, float], allowed: np.ndarray) -> tuple[int, int]:
    """La case permise la plus proche d'un point (x, y) ; il y en a toujours une au milieu des pièces."""
    rows, columns = np.nonzero(allowed)
    away = np.hypot((columns + 0.5) / FINE - point[0], (rows + 0.5) / FINE - point[1])
    best = int(np.argmin(away))
    return int(rows[best]), int(columns[best])


def search(space: InflatedGrid, start: tuple[int, int], goal: tuple[int, int], method: str) -> Search:
    grid = SearchGrid(space.free, space.costs)
    try:
        weight = WEIGHTS.get(method)
        route = grid.dijkstra(start, goal) if weight is None else grid.astar(start, goal, weight=weight)
    except UnreachableError as error:
        return Search(None, error.order)
    return Search(route, route.order)


def pictures(result: Search) -> tuple[list[Frame], list[int], list[int]]:
    """Les images ; combien de niveaux d'exploration et de points du chemin chacune montre."""
    total = len(result.order)
    waves = np.unique(np.linspace(0, 255, WAVE + 1).round().astype(int)).tolist()
    frames = [Frame(caption=f"{round(total * level / 255)} cellules explorées.") for level in waves]
    walked = [0] * len(waves)
    if result.route is None:
        frames[-1] = Frame(caption=f"{total} cellules explorées : tout ce qui est accessible. Aucun chemin.")
        return frames, waves, walked
    steps = np.unique(np.linspace(1, len(result.route.cells), WALK + 1).round().astype(int)).tolist()
    length = en_cases(result.route.length_in_cells / FINE, 1)
    text = f"But atteint après {total} cellules explorées : le chemin mesure {length}."
    return [*frames, *(Frame(caption=text) for _ in steps)], [*waves, *(255 for _ in steps)], [*walked, *steps]


def cost_cells(space: InflatedGrid, price: float) -> np.ndarray:
    """Ce que coûte chaque case, de 0 à 1 ; 1 où le robot ne peut pas être."""
    costs = 0.7 * space.costs / max(price, 1e-9)
    return np.where(free(), np.where(space.free, costs, 1.0), 0.0)


def order_cells(order: np.ndarray) -> np.ndarray:
    """Le rang de chaque case explorée, de 1/255 à 1 ; 0 ailleurs."""
    ranks = np.zeros(free().shape)
    ranks[order[:, 0], order[:, 1]] = np.maximum(1, np.ceil(255 * np.arange(1, len(order) + 1) / len(order))) / 255
    return ranks


def clearance(path: np.ndarray, walked: list[int], radius: float) -> Chart:
    run = travelled(path)
    return Chart(
        "Distance au mur le plus proche, le long du chemin (en cases)",
        [Series("distance au mur", "estimate", margins(path), run)],
        "chemin parcouru (cases)",
        (0.0, None),
        levels=[Level(radius, "rayon du robot", "alert")] if radius else [],
        cursor=[float(run[max(0, count - 1)]) for count in walked],
    )


def travelled(path: np.ndarray) -> np.ndarray:
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])


def margins(path: np.ndarray) -> np.ndarray:
    """La distance du centre de chaque case du chemin au bord du mur le plus proche."""
    away = distances_to_cells(~free()) / FINE - 0.5 / FINE
    columns, rows = np.floor(path * FINE).astype(int).T
    return np.asarray(away[rows, columns])


def summary(result: Search, others: dict[str, Search], method: str, radius: float, path: np.ndarray) -> list[str]:
    if result.route is None:
        return [
            f"Un robot de rayon {en_cases(radius)} ne peut pas atteindre ce but : aucun passage n'est assez large.",
            f"Pour le savoir, il a fallu explorer les {len(result.order)} cellules accessibles.",
        ]
    dijkstra = others["dijkstra"]
    assert dijkstra.route is not None
    length = en_cases(float(travelled(path)[-1]), 1)
    texts = [f"{NAMES[method]} explore {len(result.order)} cellules et trouve un chemin de {length}."]
    if method == "dijkstra":
        texts.append(f"A* en explorerait {len(others['a-etoile'].order)} pour un chemin du même coût.")
    else:
        share = 100.0 * len(result.order) / len(dijkstra.order)
        texts.append(f"C'est {decimal(share, 0)} % de ce qu'explore Dijkstra ({len(dijkstra.order)} cellules).")
        over = 100.0 * (result.route.cost / dijkstra.route.cost - 1.0)
        if over > 0.05:
            texts.append(f"Mais ce chemin coûte {decimal(over, 1)} % de plus que le meilleur.")
        else:
            texts.append("Ce chemin coûte le moins possible.")
    texts.append(f"Au plus près, il passe à {en_cases(float(margins(path).min()))} d'un mur.")
    return texts
