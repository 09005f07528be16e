"""Le filtre bayésien sur une grille : une croyance qui se décale et s'étale, puis que chaque scan resserre."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import label

from curriculum.l20.rejeux._carte import carte, pluriel
from graders.scene.replay import (
    Chart,
    Choice,
    Circles,
    Draw,
    Frame,
    Grid,
    Key,
    Layer,
    Placed,
    Pose,
    Rays,
    Replay,
    Series,
    Slider,
    Values,
    View,
    decimal,
)
from reference.localisation.grid_filter import COMMANDS, Belief, Cell, GridWorld, correct, predict, sample_move
from reference.world.grid_map import GridMap
from reference.world.simulation import SimulatedLidar

TITLE = "Le filtre bayésien sur une grille"
ALT = (
    "Un plan quadrillé, vu de dessus. Chaque case libre est d'autant plus colorée que le robot croit s'y trouver. Un "
    "disque bleu montre où il est vraiment, un cercle orange la case la plus probable. La couleur, d'abord étalée "
    "partout, se rassemble en quelques bosses, puis en une seule. Dessous, une courbe suit la probabilité de la vraie "
    "case."
)
PARAMETERS = {
    "depart": Choice(
        "Départ", (("piece", "dans une pièce du module"), ("jumelles", "entre deux pièces jumelles")), "piece"
    ),
    "sigma": Slider("Bruit du lidar \u03c3", 0.2, 3.0, 0.1, 1.0, "case"),
    "glissement": Slider("Glissement, de chaque côté", 0.0, 0.3, 0.05, 0.1),
    "portee": Slider("Portée du lidar", 2, 12, 1, 4, "cases"),
    "tirage": Draw(default=3),
}
PREDICTION = Placed(
    "Le robot s'éveille en x = 6,5, y = 4,5, entre deux pièces jumelles, et ne le sait pas. Son premier scan ne "
    "suffira pas : la croyance a 4 bosses ensuite, dont une près de lui. Placez-en une autre.",
    spots=((2.5, 2.5), (14.5, 2.5), (19.5, 3.5)),
    box=(0.0, 0.0, 24.0, 11.0),
    near=1.5,
    far=3.0,
    why=(
        "Les trois autres bosses ont leur sommet en (2,5 ; 2,5), en (14,5 ; 2,5) et en (19,5 ; 3,5) : là aussi, quatre "
        "rayons liraient à peu près les mêmes distances. C'est en bougeant que le robot rencontre ce qui diffère d'un "
        "côté à l'autre. À partir du pas 7, il ne reste qu'une bosse, et c'est la bonne."
    ),
    settings={"depart": "jumelles"},
)
STEPS = 12
BUMP = 0.2
TWINS = """
########################
#..........##..........#
#..........##..........#
#...##.....##...##.....#
#...##.....##...##.....#
#..........##..........#
#..........##..........#
###.###########.########
#......................#
#......................#
########################
"""
WORDS = {(1, 0): "à droite", (-1, 0): "à gauche", (0, 1): "en bas", (0, -1): "en haut"}


@dataclass(frozen=True)
class Walk:
    """Une carte, la case de départ et les cases à visiter, (ligne, colonne)."""

    grid_map: GridMap
    start: Cell
    goals: tuple[Cell, ...]


WALKS = {
    "piece": Walk(carte(), (2, 3), ((7, 3), (8, 15))),
    "jumelles": Walk(GridMap.from_text(TWINS), (4, 6), ((5, 3), (8, 3), (8, 1))),
}


@dataclass
class Journey:
    """Ce qui se passe : les images, et ce que la croyance donne à chacune."""

    world: GridWorld
    frames: list[Frame]
    of_truth: list[float]
    greatest: list[float]
    bumps: list[int]

    def show(self, belief: Belief, cell: Cell, caption: str, layers: tuple[Layer, ...] = ()) -> None:
        self.of_truth.append(float(belief[cell]))
        self.greatest.append(float(belief.max()))
        self.bumps.append(int(label(belief > BUMP * belief.max(), np.ones((3, 3)))[1]))
        best = np.unravel_index(int(np.argmax(belief)), belief.shape)
        robot = Pose([cell[1] + 0.5, cell[0] + 0.5, 0.0], "truth", glide=True)
        peak = Circles([[best[1] + 0.5, best[0] + 0.5]], 0.5, "estimate", filled=False)
        shown = (peak,) if belief.max() > 1.5 / np.count_nonzero(self.world.free) else ()
        self.frames.append(Frame([Grid(np.sqrt(belief), "belief"), robot, *layers, *shown], caption))


def compute(values: Values, rng: np.random.Generator) -> Replay:
    walk = WALKS[values.choice("depart")]
    sigma, slip, reach = values.number("sigma"), values.number("glissement"), float(values.whole("portee"))
    world = GridWorld.from_free_cells(walk.grid_map.free, reach)
    journey = Journey(world, [], [], [], [])
    belief, cell = world.uniform_belief(), walk.start
    journey.show(belief, cell, "Au départ, le robot ne sait rien : toutes les cases libres se valent.")
    belief = sense(journey, belief, cell, sigma, reach, rng, "Premier scan")
    goals = deque(walk.goals)
    for step in range(1, STEPS + 1):
        if len(goals) > 1 and cell == goals[0]:
            goals.popleft()
        command = towards(walk.grid_map.free, cell, goals[0])
        belief = predict(world, belief, *command, slip=slip)
        cell = sample_move(world, cell, *command, rng, slip=slip)
        asked = f"on demande une case {WORDS[command]}" if command in WORDS else "le robot ne bouge pas"
        journey.show(belief, cell, f"Pas {step}, prédiction : {asked} ; la croyance se décale et s'étale.")
        belief = sense(journey, belief, cell, sigma, reach, rng, f"Pas {step}, correction")
    height, width = walk.grid_map.shape
    return Replay(
        View(0, 0, width, height),
        journey.frames,
        summary(journey, belief, cell),
        layers=[Grid(~walk.grid_map.free, "walls")],
        charts=[chart(journey)],
        legend=[
            Key("cell", "estimate", "croyance"),
            Key("ring", "estimate", "case la plus probable"),
            Key("robot", "truth", "où le robot est vraiment"),
            Key("line", "measure", "les quatre rayons du scan"),
        ],
        period=0.9,
    )


def sense(
    journey: Journey, belief: Belief, cell: Cell, sigma: float, reach: float, rng: np.random.Generator, name: str
) -> Belief:
    """Un scan bruité, la croyance qu'il corrige, et leur image."""
    scan = SimulatedLidar.full_turn(4, reach, sigma).add_noise(journey.world.scans[cell], rng)
    corrected = correct(journey.world, belief, scan, sigma)
    centre = np.array([cell[1] + 0.5, cell[0] + 0.5])
    ends = centre + scan[:, None] * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    read = " ; ".join(decimal(distance) for distance in scan)
    text = f"{name} : le scan lit {read} ; ailleurs, la couleur pâlit."
    journey.show(corrected, cell, text, (Rays(centre, ends, hits=scan < reach),))
    return corrected


def towards(free: np.ndarray, cell: Cell, goal: Cell) -> tuple[int, int]:
    """La commande qui rapproche le plus du but, par les cases libres ; (0, 0) quand on y est."""
    away = {goal: 0}
    queue = deque([goal])
    while queue and cell not in away:
        y, x = queue.popleft()
        for du, dv in COMMANDS[1:]:
            there = (y - dv, x - du)
            if free[there] and there not in away:
                away[there] = away[y, x] + 1
                queue.append(there)
    ways = {(du, dv): away.get((cell[0] + dv, cell[1] + du), 10**6) for du, dv in COMMANDS}
    return (0, 0) if cell == goal else min(ways, key=lambda command: ways[command])


def chart(journey: Journey) -> Chart:
    moments = np.array([0.0, *(k / 2 for k in range(1, len(journey.frames)))])
    return Chart(
        "Ce que la croyance donne à une case",
        [
            Series("la plus probable", "estimate", journey.greatest, moments, "dashed"),
            Series("la vraie", "truth", journey.of_truth, moments),
        ],
        "pas (prédiction, puis correction)",
        (0.0, 1.0),
        cursor=moments,
    )


def summary(journey: Journey, belief: Belief, cell: Cell) -> list[str]:
    after_scans = journey.bumps[1::2]
    alone = next((k for k in range(len(after_scans)) if all(n == 1 for n in after_scans[k:])), None)
    texts = [f"Après le premier scan, la croyance a {pluriel(after_scans[0], 'bosse', 'bosses')}."]
    if max(after_scans) == 1:
        texts.append("Elle n'en a jamais davantage : ce que voit le lidar suffit à reconnaître l'endroit.")
    elif alone is None:
        texts.append(
            f"Au bout de {STEPS} pas il en reste {after_scans[-1]} : plusieurs endroits expliquent encore tous les "
            f"scans."
        )
    else:
        texts.append(f"À partir du pas {alone}, il n'en reste qu'une.")
    best = np.unravel_index(int(np.argmax(belief)), belief.shape)
    gap = abs(int(best[0]) - cell[0]) + abs(int(best[1]) - cell[1])
    where = "C'est la bonne." if gap == 0 else f"Le robot est à {pluriel(gap, 'case', 'cases')} de là."
    texts.append(f"À la fin, la case la plus probable a une probabilité de {decimal(float(belief.max()), 2)}. {where}")
    return texts
