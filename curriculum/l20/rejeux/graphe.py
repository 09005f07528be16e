"""Le SLAM par graphe : des poses qui dérivent, des fermetures de boucle, et Gauss-Newton qui les met d'accord."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from curriculum.l20.rejeux._carte import carte, contours, en_cases, milliers, pluriel
from graders.scene.replay import (
    Chart,
    Choice,
    Circles,
    Draw,
    Frame,
    Key,
    Layer,
    Points,
    Polyline,
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
from reference.metrics import absolute_trajectory_error
from reference.odometry import DifferentialDrive
from reference.pose_graph import DCS, Huber, Kernel, PoseGraph, chi2, edge_chi2, gauss_newton, robust_gauss_newton
from reference.se2 import relative, transform
from reference.world.simulation import SimulatedLidar, SimulatedRun, motions_through_waypoints, simulate

TITLE = "Le graphe de poses se referme"
ALT = (
    "Le trajet d'un robot qui revient sur ses pas, dessiné comme une chaîne de poses orange, et les points que son "
    "lidar a vus de chacune. D'après l'odométrie seule, la chaîne s'écarte du vrai trajet et les murs se dédoublent. "
    "Des traits verts joignent les poses reconnues comme un même lieu : à chaque itération, ils se raccourcissent et "
    "la carte se remet en place. Une fausse fermeture, en rouge, la tord. Une courbe suit la somme des erreurs."
)
MOST_CLOSURES = 10
PARAMETERS = {
    "derive": Slider("Dérive de l'odométrie", 0.2, 2.0, 0.1, 1.2, "%"),
    "fermetures": Slider("Fermetures de boucle", 0, MOST_CLOSURES, 1, 1),
    "fausse": Switch("Ajouter une fausse fermeture"),
    "noyau": Choice("Noyau robuste", (("aucun", "aucun"), ("huber", "de Huber"), ("dcs", "DCS")), "aucun"),
    "tirage": Draw(default=5),
}
PREDICTION = Prediction(
    "L'odométrie seule s'écarte du vrai trajet de 1,8 case. On ajoute une vraie fermeture de boucle, et une fausse ; "
    "aucun noyau robuste. Que devient la carte ?",
    (
        ("meilleure", "Meilleure : la vraie fermeture et toute l'odométrie l'emportent sur la fausse."),
        ("egale", "Ni mieux ni pire : l'une défait ce que fait l'autre."),
        ("pire", "Bien pire qu'avec l'odométrie seule."),
    ),
    right="pire",
    why=(
        "L'écart passe de 1,8 à 7 cases. Une fermeture pèse bien plus qu'un pas d'odométrie, et les moindres carrés "
        "plient tout le reste pour la satisfaire. Choisissez maintenant le noyau DCS : l'écart tombe à 0,5 case."
    ),
    settings={"fausse": "1"},
)
START = (3.5, 3.5, 0.0)
ROUTE = (
    (11.5, 3.5), (11.5, 7.9), (19.5, 7.9), (19.5, 5.5), (19.5, 7.9), (17.5, 7.9), (17.5, 13.5), (11.5, 13.5),
    (11.5, 7.9), (3.5, 7.9), (3.5, 3.5), (7.0, 3.5),
)  # fmt: skip
STRIDE, TURN, TRACK = 1.0, 1.6, 0.5
LIDAR = SimulatedLidar.full_turn(30, 6.0, 0.03)
CLOSURE_SIGMAS = np.array([0.05, 0.05, 0.02])
FLOOR = np.diag([1e-4, 1e-4, 1e-5])
APART, NEAR = 20, 1.0
MISTAKEN = ((11.5, 5.5), (17.5, 12.0))
KERNELS: dict[str, Kernel] = {"huber": Huber(1.0), "dcs": DCS(30.0)}
MOST, STILL = 14, 2e-3
GOOD = 0.4


@dataclass(frozen=True)
class State:
    """Le graphe après une itération : ses poses, ce qu'il coûte, le poids de chaque arête, l'erreur du trajet."""

    poses: np.ndarray
    cost: float
    weights: np.ndarray
    error: float


def compute(values: Values, rng: np.random.Generator) -> Replay:
    drive = DifferentialDrive(TRACK, sigma_per_root_metre=values.number("derive") / 100.0)
    run = simulate(carte(), motions_through_waypoints(START, ROUTE, STRIDE, TURN), START, drive, LIDAR, rng)
    noise = rng.normal(0.0, 1.0, (MOST_CLOSURES + 1, 3)) * CLOSURE_SIGMAS
    pairs = closures(run, values.whole("fermetures"))
    graph = build(run, pairs, noise, values.flag("fausse"))
    kernel = KERNELS.get(values.choice("noyau"))
    states = optimise(graph, run, kernel)
    height, width = carte().shape
    costs, errors = [state.cost for state in states], [state.error for state in states]
    moments = [0.0, *range(len(states))]
    return Replay(
        View(-1.5, -1.0, width + 1.5, height + 2.0),
        pictures(run, graph, states, values.flag("fausse")),
        summary(states, len(pairs), values),
        layers=[contours(), Polyline(run.truth[:, :2], "truth", 1.2, dashed=True)],
        charts=[
            Chart(
                "Somme des erreurs χ², à chaque itération" + (" (à travers le noyau)" if kernel else ""),
                [Series("coût" if kernel else "χ²", "alert", np.maximum(costs, 1e-2))],
                logarithmic=True,
                cursor=moments,
            ),
            Chart(
                "Écart quadratique moyen au vrai trajet, en cases",
                [Series("écart", "second", errors)],
                "itération",
                (0.0, None),
                cursor=moments,
            ),
        ],
        legend=[
            Key("dot", "estimate", "pose estimée"),
            Key("dashed", "truth", "vrais murs et vrai trajet"),
            Key("dot", "ink", "point vu par le lidar"),
            Key("line", "measure", "fermeture de boucle"),
            *([Key("line", "alert", "fausse fermeture")] if values.flag("fausse") else []),
        ],
        period=1.0,
    )


def closures(run: SimulatedRun, count: int) -> list[tuple[int, int]]:
    """Des paires de poses éloignées dans le temps et proches dans l'espace, réparties le long du trajet."""
    away = np.linalg.norm(run.truth[:, None, :2] - run.truth[None, :, :2], axis=2)
    late, early = np.nonzero(np.tril(away < NEAR, -APART))
    nearest = [
        (int(min(early[late == j], key=lambda i: away[i, j])), int(j))
        for j in np.unique(late)  # pour chaque pose, le lieu déjà vu le plus proche
    ]
    chosen = np.unique(np.linspace(len(nearest) - 1, 0, count).round().astype(int)) if count else []
    return [nearest[k] for k in chosen]


def build(run: SimulatedRun, pairs: list[tuple[int, int]], noise: np.ndarray, mistaken: bool) -> PoseGraph:
    """L'odométrie d'une pose à la suivante, les fermetures, puis la fausse s'il y en a une."""
    edges = []
    for k, (left, right) in enumerate(run.wheels.tolist()):
        covariance = run.drive.increment_covariance(left, right) + FLOOR
        edges.append((k, k + 1, run.drive.pose_increment(left, right), np.linalg.inv(covariance)))
    information = np.diag(CLOSURE_SIGMAS**-2.0)
    for (i, j), error in zip(pairs, noise, strict=False):
        edges.append((i, j, relative(run.truth[i], run.truth[j]) + error, information))
    if mistaken:
        i, j = (int(np.argmin(np.linalg.norm(run.truth[:, :2] - place, axis=1))) for place in MISTAKEN)
        edges.append((i, j, noise[-1], information))
    return PoseGraph.from_edges(len(run), edges)


def optimise(graph: PoseGraph, run: SimulatedRun, kernel: Kernel | None) -> list[State]:
    """Gauss-Newton, une itération à la fois, depuis l'odométrie."""
    states = [judged(graph, run, run.odometry, kernel)]
    while len(states) <= MOST:
        before = states[-1].poses
        step = (
            gauss_newton(graph, before, max_iterations=1)
            if kernel is None
            else robust_gauss_newton(graph, before, kernel, max_iterations=1)
        )
        states.append(judged(graph, run, step.poses, kernel))
        if np.abs(step.poses[:, :2] - before[:, :2]).max() < STILL:
            break
    return states


def judged(graph: PoseGraph, run: SimulatedRun, poses: np.ndarray, kernel: Kernel | None) -> State:
    error = absolute_trajectory_error(run.truth, poses, "first").rmse
    if kernel is None:
        return State(poses, chi2(graph, poses), np.ones(len(graph.i)), error)
    each, doubted = edge_chi2(graph, poses), graph.is_closure_mask
    cost = float(np.where(doubted, kernel.rho(each), each).sum())
    return State(poses, cost, np.where(doubted, kernel.weight(each), 1.0), error)


def pictures(run: SimulatedRun, graph: PoseGraph, states: list[State], mistaken: bool) -> list[Frame]:
    scans = [run.scan(k).points() for k in range(len(run))]
    loops = np.flatnonzero(graph.is_closure_mask)
    before = f"L'odométrie seule : un écart quadratique moyen de {en_cases(states[0].error)} avec le vrai trajet."
    frames = [Frame(layers(states[0], scans, graph, loops[:0], False), before)]
    for k, state in enumerate(states):
        if k == 0:
            text = f"On ajoute {pluriel(len(loops), 'fermeture', 'fermetures')} : χ² = {number(state.cost)}."
        else:
            before, now = number(states[k - 1].cost), number(state.cost)
            verb = "tombe" if state.cost < states[k - 1].cost else "monte"
            text = f"Itération {k} : le coût {verb} de {before} à {now}."
            if before == now:
                text = f"Itération {k} : le coût ne change plus ; il vaut {now}."
        frames.append(Frame(layers(state, scans, graph, loops, mistaken, glide=k > 0), text))
    return frames


def layers(
    state: State,
    scans: list[np.ndarray],
    graph: PoseGraph,
    loops: np.ndarray,
    mistaken: bool,
    glide: bool = False,
) -> list[Layer]:
    seen = np.vstack([transform(pose, points) for pose, points in zip(state.poses, scans, strict=True)])
    places = state.poses[:, :2]
    true, false = (loops[:-1], loops[-1:]) if mistaken else (loops, loops[:0])
    drawn: list[Layer] = [
        Points(seen, "ink", size=1.4, opacity=0.45, glide=glide),
        Polyline(places, "estimate", 1.5, glide=glide),
        Points(places, "estimate", size=2.8, glide=glide),
    ]
    for edges, color in ((true, "measure"), (false, "alert")):
        weight = float(state.weights[edges].mean()) if len(edges) else 1.0
        starts, ends = places[graph.i[edges]], places[graph.j[edges]]
        opacity = max(0.15, round(weight, 2))
        drawn.append(Segments(starts, ends, color, width=3.0, opacity=opacity, dashed=weight < 0.5, glide=glide))
        drawn.append(Circles(np.vstack([starts, ends]), 0.3, color, filled=False, glide=glide))
    return drawn


def number(cost: float) -> str:
    return decimal(cost, 1) if cost < 100 else milliers(cost)


def summary(states: list[State], count: int, values: Values) -> list[str]:
    first, last = states[0], states[-1]
    texts = [f"L'odométrie seule s'écarte du vrai trajet de {en_cases(first.error)} en moyenne quadratique."]
    if count == 0 and not values.flag("fausse"):
        texts.append("Sans fermeture, rien ne la contredit : le graphe ne bouge pas.")
        return texts
    texts.append(
        f"Après {pluriel(len(states) - 1, 'itération', 'itérations')}, l'écart est de {en_cases(last.error)}, et le "
        f"coût passe de {number(first.cost)} à {number(last.cost)}."
    )
    if values.flag("fausse"):
        weight = float(last.weights[-1])
        shown = decimal(weight, 3) if weight >= 0.001 else "moins de 0,001"
        if values.choice("noyau") == "aucun":
            texts.append("La fausse fermeture compte autant que les vraies, et tord toute la carte.")
        elif last.error < max(GOOD, first.error):
            texts.append(f"Le noyau ne donne plus à la fausse fermeture qu'un poids de {shown} : la carte tient.")
        else:
            texts.append(f"Le noyau donne à la fausse fermeture un poids de {shown} : ce n'est pas assez.")
    elif last.error < first.error:
        texts.append("Chaque boucle fermée ramène toute la chaîne : la correction se répartit sur les poses.")
    return texts
