"""Un graphe de poses dans la main : des ressorts colorés par leur χ², des fermetures à couper, à nouer."""

from __future__ import annotations

from functools import cache

import numpy as np

from graders.scene.hands import Start
from graders.scene.replay import Choice, Key, Switch, Values, View
from reference.pose_graph import PoseGraph
from reference.se2 import compose, relative

TITLE = "Un graphe de ressorts, entre vos mains"
ALT = (
    "Un graphe de poses vu de dessus : un robot a fait un peu plus d'un tour de rectangle. Ses poses, des points "
    "orange numérotés, sont reliées par des ressorts, du vert au rouge selon leur χ². Deux ressorts plus longs, les "
    "fermetures, relient la fin du trajet à son début. Chaque pose se déplace à la souris, au doigt ou au clavier."
)
PARAMETERS = {
    "noyau": Choice(
        "Noyau des fermetures",
        (("aucun", "aucun"), ("huber", "Huber, δ = 1"), ("dcs", "DCS, Φ = 10"), ("commutables", "commutables, Φ = 10")),
        "aucun",
    ),
    "suivre": Switch("Les autres poses suivent la main"),
}
#: Le tour d'un rectangle, case par case ; puis le début d'un second, une demi-case à l'intérieur.
LONG, WIDE, LAP, POSES = 6, 4, 20, 24
ODOMETRY = np.array([0.05, 0.05, 0.05])
CLOSURE = np.array([0.05, 0.05, 0.02])
TRUE = ((0, 20), (3, 23))
SEED = 20


def truth() -> np.ndarray:
    """(POSES, 3), le cap vers la pose suivante."""
    corners = np.array([[0, 0], [LONG, 0], [LONG, WIDE], [0, WIDE]], dtype=np.float64)
    steps = [corners[k] + t * (corners[(k + 1) % 4] - corners[k]) / n
             for k, n in ((0, LONG), (1, WIDE), (2, LONG), (3, WIDE)) for t in range(n)]  # fmt: skip
    places = np.array([*steps, *(np.array([0.5 + k, 0.5]) for k in range(POSES - LAP))])
    ahead = np.diff(np.vstack([places, places[-1] + [1.0, 0.0]]), axis=0)
    return np.column_stack([places, np.arctan2(ahead[:, 1], ahead[:, 0])])


@cache
def chain() -> tuple[PoseGraph, np.ndarray]:
    """Le graphe avec ses vraies fermetures, et les poses (POSES, 3) de l'odométrie seule."""
    rng, true = np.random.default_rng(SEED), truth()
    odometry, closure = np.diag(ODOMETRY**-2.0), np.diag(CLOSURE**-2.0)
    edges = [
        (k, k + 1, np.round(relative(true[k], true[k + 1]) + rng.normal(0.0, ODOMETRY), 4), odometry)
        for k in range(POSES - 1)
    ]
    poses = [true[0]]
    for _, _, z, _ in edges:
        poses.append(compose(poses[-1], z))
    edges += [(i, j, np.round(relative(true[i], true[j]) + rng.normal(0.0, CLOSURE), 4), closure) for i, j in TRUE]
    return PoseGraph.from_edges(POSES, edges), np.array(poses)


def compute(values: Values, rng: np.random.Generator) -> Start:
    graph, poses = chain()
    edges = [
        {"i": int(i), "j": int(j), "z": z.tolist(), "information": omega.diagonal().tolist()}
        for i, j, z, omega in zip(graph.i, graph.j, graph.z_i_j, graph.information, strict=True)
    ]
    return Start(
        View(-1.5, -1.5, 8.0, 6.3, up=True),
        {
            "poses": np.round(poses, 6).tolist(),
            "truth": truth().tolist(),
            "edges": edges,
            "closure": (CLOSURE**-2.0).tolist(),
        },
        [
            Key("dot", "estimate", "pose estimée"),
            Key("line", "measure", "ressort au repos (χ² < 1)"),
            Key("line", "estimate", "tendu (χ² de 30)"),
            Key("line", "alert", "près de rompre (χ² ≥ 1000)"),
            Key("dashed", "truth", "vrai trajet"),
        ],
    )
