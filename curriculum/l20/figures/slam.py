"""Drawings of the séance « SLAM »: composed frames, registered scans, springs between poses, sparse matrices."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from curriculum.l20.figures._slam_scenes import bare, draw_walls, frame_map, graph, panels, world
from graders.plotting import Palette
from reference.loop_closure import fourier_signature
from reference.pose_graph import NormalEquations, PoseGraph, gauss_newton
from reference.pose_graph.factor import factorise
from reference.registration import icp
from reference.se2 import compose, relative, transform, wrap_angle
from reference.world.scan import full_turn_angles

Floats = NDArray[np.float64]

ROOM = np.array([11.5, 3.5, 0.0])
MOVE = np.array([1.2, 0.6, 0.3])
BEAMS = 180


def draw_composition(figure: Figure, palette: Palette) -> None:
    axes = figure.subplots()
    a, b = np.array([2.2, 1.0, 0.55]), np.array([2.8, 0.9, 0.7])
    both = compose(a, b)
    _axes_of(axes, np.zeros(3), palette.ink, "monde", 1.1)
    _axes_of(axes, a, palette.truth, "a", 1.0)
    _axes_of(axes, both, palette.estimate, "", 0.9)
    axes.text(both[0] + 0.25, both[1] + 0.1, "a ⊕ b", color=palette.estimate, fontsize=12)
    _arrow(axes, np.zeros(2), a[:2], palette.truth)
    foot = transform(a, np.array([[b[0], 0.0]]))[0]
    axes.plot(*np.array([a[:2], foot, both[:2]]).T, color=palette.measure, lw=1.8, ls="--")
    _arrow(axes, a[:2], both[:2], palette.measure)
    axes.text(*(0.5 * (a[:2] + foot) + [0.1, -0.34]), "x₂", color=palette.measure, ha="center", fontsize=12)
    axes.text(*(0.5 * (foot + both[:2]) + [0.32, -0.05]), "y₂", color=palette.measure, ha="center", fontsize=12)
    axes.text(3.05, 2.35, "b, vue depuis a", color=palette.measure, ha="right", fontsize=11)
    axes.set_xlim(-0.6, 6.0)
    axes.set_ylim(-0.6, 4.3)
    axes.set_aspect("equal")
    axes.set_axis_off()


def _axes_of(axes: Axes, pose: Floats, colour: str, name: str, length: float) -> None:
    x, y, theta = pose
    for angle in (theta, theta + np.pi / 2):
        _arrow(axes, pose[:2], pose[:2] + length * np.array([np.cos(angle), np.sin(angle)]), colour, 2.4)
    axes.plot(x, y, "o", color=colour, ms=7, zorder=5)
    axes.text(x - 0.12, y - 0.38, name, color=colour, ha="center", fontsize=12)


def _arrow(axes: Axes, start: Floats, end: Floats, colour: str, width: float = 1.5) -> None:
    axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": colour, "lw": width, "shrinkB": 0})


@cache
def clouds() -> tuple[Floats, Floats]:
    """The points of two scans of one room, from two poses, each in its robot's frame: before (Q), after (P)."""
    rng, angles = np.random.default_rng(2), full_turn_angles(BEAMS)
    both = []
    for pose in (ROOM, compose(ROOM, MOVE)):
        ranges = world().cast_scans(pose[None], angles, 12.0)[0]
        ends = (ranges + rng.normal(0.0, 0.03, BEAMS))[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
        both.append(ends[ranges < 11.9])
    return both[0], both[1]


def draw_icp(figure: Figure, palette: Palette) -> None:
    Q, P = clouds()
    for axes, count in zip(panels(figure, 2, 2), (0, 2, 6, 60), strict=True):
        result = icp(P, Q, max_iterations=count)
        moved = transform(result.T_q_p, P)
        for k in range(0, len(P), 4):
            axes.plot(*np.array([moved[k], Q[result.pairs[k]]]).T, color=palette.second, lw=0.9, alpha=0.8)
        axes.plot(*Q.T, "o", color=palette.truth, ms=2.6)
        axes.plot(*moved.T, "o", color=palette.estimate, ms=2.6)
        bare(axes)
        axes.set_xlim(-6.5, 7.5)
        axes.set_ylim(7.4, -4.4)
        error = f"{result.errors[-1]:.1f}".replace(".", ",")
        title = "départ" if count == 0 else f"{result.iterations} itérations"
        axes.set_title(f"{title} : E = {error}")


@cache
def basin() -> tuple[Floats, Floats]:
    """Angles of departure, degrees away from the true one, and how far from it ICP ends, in degrees."""
    Q, P = clouds()
    starts = np.arange(-180.0, 180.1, 6.0)
    ends = [
        icp(P, Q, MOVE + np.array([0, 0, np.radians(s)]), max_iterations=120, tolerance=1e-4).T_q_p[2] for s in starts
    ]
    away = np.degrees(wrap_angle(np.array(ends) - MOVE[2]))
    return starts, away


def draw_basin(figure: Figure, palette: Palette) -> None:
    axes = figure.subplots()
    starts, away = basin()
    good = np.abs(away) < 5
    held = starts[good]
    inside = held[np.abs(held) < 90]
    axes.axvspan(inside.min() - 3, inside.max() + 3, color=palette.measure, alpha=0.15, lw=0)
    axes.plot(starts, starts, color=palette.faint, lw=1.2, ls="--")
    axes.plot(starts[good], away[good], "o", color=palette.measure, ms=5)
    axes.plot(starts[~good], away[~good], "x", color=palette.alert, ms=6, mew=1.8)
    axes.text(inside.mean(), 60, "bassin", color=palette.measure, ha="center")
    axes.set_xticks(np.arange(-180, 181, 60))
    axes.set_yticks(np.arange(-180, 181, 60))
    axes.set_xlabel("erreur de cap au départ (degrés)")
    axes.set_ylabel("erreur à l’arrivée")


def draw_corridor(figure: Figure, palette: Palette) -> None:
    left, right = figure.subplots(1, 2, width_ratios=[1.5, 1])
    rng = np.random.default_rng(5)
    x = np.arange(-5.0, 5.01, 0.33)
    Q = np.concatenate([[(v, -1.0) for v in x], [(v, 1.0) for v in x]]) + rng.normal(0, 0.03, (2 * len(x), 2))
    shown = Q + np.array([1.6, 0.35])
    left.plot(*Q.T, "o", color=palette.truth, ms=3.2)
    left.plot(*shown.T, "o", color=palette.estimate, ms=3.2)
    left.annotate("", (3.9, 2.1), (-3.9, 2.1), arrowprops={"arrowstyle": "<->", "color": palette.alert, "lw": 2})
    left.text(0, 2.35, "rien ne retient", color=palette.alert, ha="center", va="top")
    bare(left)
    left.set_xlim(-6.2, 7.2)
    left.set_ylim(3.6, -2.0)
    shifts = np.linspace(-2, 2, 61)
    for direction, colour, name in (([0, 1], palette.truth, "en travers"), ([1, 0], palette.alert, "le long")):
        costs = [_mean_square(Q + s * np.array(direction), Q) for s in shifts]
        right.plot(shifts, costs, color=colour, lw=2.2, label=name)
    right.set_xlabel("décalage (cases)")
    right.set_ylabel("écart quadratique moyen")
    right.legend(loc="upper center")
    right.set_ylim(0, 1.3)


def _mean_square(moved: Floats, Q: Floats) -> float:
    """The mean of the squared distances to the nearest points."""
    return float(np.mean(np.min(np.sum((moved[:, None] - Q[None]) ** 2, axis=2), axis=1)))


def draw_springs(figure: Figure, palette: Palette) -> None:
    axes = figure.subplots()
    rows = (
        (1.0, np.array([0.0, 2.0, 4.0, 1.0]), "odométrie seule : arrivée en 1, et non en 0", palette.estimate),
        (0.0, np.array([0, 22, 44, 1]) / 13, "après l’optimisation", palette.truth),
    )
    for y, x, title, colour in rows:
        heights = y + np.array([0.0, 0.0, 0.0, -0.34])
        for k in range(3):
            ends = np.array([[x[k], heights[k]], [x[k + 1], heights[k + 1]]])
            axes.plot(*_spring(*ends).T, color=palette.measure, lw=1.4)
        axes.plot(*_spring(np.array([x[0], y]), np.array([x[3], y - 0.34]), 4).T, color=palette.alert, lw=2)
        axes.plot(x, heights, "o", color=colour, ms=12, zorder=5)
        for k in range(4):
            value = f"{x[k]:.2f}".rstrip("0").rstrip(".").replace(".", ",")
            side = 0.13 if k < 3 else -0.2
            axes.text(
                x[k] + (0.12 if k == 3 else 0), heights[k] + side, f"x{'₀₁₂₃'[k]} = {value}", ha="center", color=colour
            )
        axes.text(4.55, y - 0.42, title, ha="right", color=colour)
    axes.set_xlim(-0.45, 4.6)
    axes.set_ylim(-0.72, 1.3)
    axes.set_axis_off()


def _spring(a: Floats, b: Floats, turns: int = 8) -> Floats:
    """A zigzag (n, 2) from a to b."""
    t = np.linspace(0.12, 0.88, 2 * turns + 1)
    across = np.array([-(b - a)[1], (b - a)[0]]) / max(float(np.hypot(*(b - a))), 1e-9)
    sides = 0.045 * np.where(np.arange(len(t)) % 2, 1.0, -1.0)
    sides[[0, -1]] = 0.0
    return np.concatenate([[a], a + t[:, None] * (b - a) + sides[:, None] * across, [b]])


def draw_graph(figure: Figure, palette: Palette) -> None:
    made, odometry, truth = graph()
    with_scans = graph(scans=True)[0]
    stories = (
        ("odométrie seule", odometry, palette.estimate),
        ("avec 4 fermetures", gauss_newton(made, odometry).poses, palette.measure),
        ("fermetures et ICP", gauss_newton(with_scans, odometry).poses, palette.measure),
    )
    *drawn, last = panels(figure, 2, 2)
    for axes, (title, poses, colour) in zip(drawn, stories, strict=True):
        draw_walls(axes, palette, 0.22)
        axes.plot(*truth[:, :2].T, color=palette.truth, lw=1.2, alpha=0.8)
        axes.plot(*poses[:, :2].T, "o-", color=colour, lw=1.6, ms=3.4)
        for i, j in zip(made.i[made.is_closure_mask], made.j[made.is_closure_mask], strict=True):
            axes.plot(*poses[[i, j], :2].T, color=palette.alert, lw=2.2, zorder=5)
        rms = np.sqrt(np.mean(np.sum((poses - truth)[:, :2] ** 2, axis=1)))
        axes.set_title(f"{title} : {rms:.2f}".replace(".", ","))
        frame_map(axes, 1.6)
    places = ((27, 3.75), (27, 1.0), (12, -0.5))
    for (title, poses, colour), style, place in zip(stories, ("-", "--", "-"), places, strict=True):
        last.plot(np.hypot(*(poses - truth)[:, :2].T), color=colour, lw=1.9, ls=style)
        last.text(*place, title, color=colour)
    last.set_ylim(-0.8, 4.4)
    last.set_title("écart à la vérité (cases)")
    last.set_xlabel("numéro de la pose")


@cache
def factors() -> dict[str, tuple[NDArray[np.bool_], int]]:
    """For a robot that mows a field of 14 x 14 poses: which blocks of H and of L are not zero, and how many."""
    side = 14
    order = {}
    for row in range(side):
        for column in range(side):
            order[row, column if row % 2 == 0 else side - 1 - column] = row * side + column
    poses = np.zeros((side * side, 3))
    for (row, column), k in order.items():
        poses[k] = (column, row, 0.0 if row % 2 == 0 else np.pi)
    pairs = [(k, k + 1) for k in range(side * side - 1)]
    pairs += [(order[row, c], order[row + 1, c]) for row in range(side - 1) for c in range(side)]
    edges = [(i, j, relative(poses[i], poses[j]), np.eye(3)) for i, j in dict.fromkeys(pairs)]
    equations = NormalEquations(PoseGraph.from_edges(side * side, edges))
    upper = equations.upper_triangle(equations.join_state(poses))
    full = (upper + upper.T).toarray() - np.diag(upper.diagonal())
    natural = np.abs(np.linalg.cholesky(full)) > 1e-12
    chosen = abs(factorise(upper).lower().L).toarray() > 1e-12
    return {
        "H": _blocks(np.abs(full) > 1e-12),
        "L, ordre du trajet": _blocks(natural),
        "L, ordre choisi": _blocks(chosen),
    }


def _blocks(mask: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], int]:
    """Which blocks 3 x 3 hold something, and how many entries do."""
    n = len(mask) // 3
    return mask.reshape(n, 3, n, 3).any(axis=(1, 3)), int(mask.sum())


def draw_sparsity(figure: Figure, palette: Palette) -> None:
    shades = ListedColormap([palette.paper, palette.truth])
    for axes, (title, (blocks, count)) in zip(figure.subplots(1, 3), factors().items(), strict=True):
        axes.imshow(blocks, cmap=shades, interpolation="nearest")
        axes.set_xticks([])
        axes.set_yticks([])
        axes.grid(visible=False)
        axes.spines[["top", "right"]].set_visible(True)
        axes.set_title(f"{title}\n{count} non nuls", fontsize=10)


def draw_signature(figure: Figure, palette: Palette) -> None:
    left, right = figure.subplots(2, 1)
    here = np.array([5.3, 3.2, 0.4])
    scans = {
        "un lieu": (here, palette.truth, "o-"),
        "le même, tourné de 100°": (here + np.array([0, 0, np.radians(100)]), palette.estimate, "o--"),
        "un autre lieu": (np.array([11.5, 12.0, 0.4]), palette.alert, "s:"),
    }
    for shift, (name, (pose, colour, style)) in enumerate(scans.items()):
        ranges = world().cast_scans(pose[None], full_turn_angles(36), 12.0)[0]
        left.plot(ranges, style, color=colour, ms=3, lw=1.4, label=name)
        right.bar(np.arange(1, 13) + 0.27 * (shift - 1), fourier_signature(ranges)[1:13], 0.25, color=colour)
    left.set_ylabel("distance")
    left.set_xlabel("numéro du rayon")
    left.set_ylim(0, 14.5)
    left.legend(loc="upper right", ncols=3, fontsize=9.5, columnspacing=1.0, handlelength=1.6)
    right.set_ylabel(r"module $|Z_f|$")
    right.set_xlabel("fréquence f (tours)")
    right.set_xticks(np.arange(1, 13))


def draw_jacobian(figure: Figure, palette: Palette) -> None:
    """The columns of both Jacobians of an edge, as arrows from where the robot sees j."""
    u, v = 2.0, 1.0
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    moves = (
        ("quand le robot i bouge", ((-1.0, 0.0, "xᵢ"), (0.0, -1.0, "yᵢ"), (v, -u, "θᵢ"))),
        ("quand la pose j bouge", ((1.0, 0.0, "xⱼ"), (0.0, 1.0, "yⱼ"))),
    )
    for axes, (title, columns) in zip(panels, moves, strict=True):
        _axes_of(axes, np.zeros(3), palette.ink, "i", 0.8)
        axes.plot([0.0, u], [0.0, v], ":", color=palette.ink, lw=1.0)
        for dx, dy, name in columns:
            colour = palette.estimate if name == "θᵢ" else palette.truth
            _arrow(axes, np.array([u, v]), np.array([u + dx, v + dy]), colour, 2.4)
            axes.text(u + 1.14 * dx + 0.12, v + 1.14 * dy + 0.1, name, color=colour, fontsize=12)
        axes.plot(u, v, "o", color=palette.ink, ms=6)
        axes.text(u + 0.1, v + 0.18, "j", color=palette.ink, fontsize=12)
        axes.set(xlim=(-0.6, 3.9), ylim=(-1.6, 2.5), aspect="equal")
        axes.set_title(title, fontsize=11)
        axes.set_axis_off()


FIGURES = {
    "slam-jacobienne": (
        draw_jacobian,
        "Deux dessins dans le repère du robot, qui voit j devant et un peu à gauche. Quand il avance, j recule ; quand "
        "il va à gauche, j part à droite ; quand il pivote, j part en travers de la ligne de visée. Quand j bouge, "
        "elle part du côté où elle va, et pivoter sur place ne la déplace pas.",
        (6.4, 3.3),
    ),
    "slam-composition": (
        draw_composition,
        "Trois repères : celui du monde, celui de la pose a, et celui de a ⊕ b. La position de b se lit dans les axes "
        "tournés de a : x₂ le long du premier, y₂ le long du second.",
        (5.6, 3.8),
    ),
    "slam-icp": (
        draw_icp,
        "Deux scans de la même pièce, bleu et orange, et les paires de points les plus proches. Au départ les nuages "
        "sont décalés ; l'erreur baisse à chaque étape et les nuages se superposent à la fin.",
        (5.8, 4.7),
    ),
    "slam-bassin": (
        draw_basin,
        "Erreur de cap à l'arrivée selon l'erreur au départ. Autour de zéro, une bande où ICP revient à zéro ; "
        "au-delà, il s'arrête sur des alignements faux.",
        (5.6, 3.4),
    ),
    "slam-couloir": (
        draw_corridor,
        "Deux murs parallèles et le même nuage décalé. Le coût monte nettement en travers du couloir, et reste presque "
        "plat le long du couloir, avec des creux à chaque point.",
        (5.8, 2.7),
    ),
    "slam-ressorts": (
        draw_springs,
        "Quatre poses sur une droite reliées par des ressorts. L'odométrie les place en 0, 2, 4 et 1 ; la fermeture "
        "tire la dernière vers 0 ; à l'équilibre : 0, 1,69, 3,38 et 0,08.",
        (5.6, 3.4),
    ),
    "slam-graphe": (
        draw_graph,
        "Le tour du bâtiment comme graphe de poses. Odométrie seule : 2,77 cases d'écart. Avec quatre fermetures : "
        "0,50. Avec en plus l'alignement des scans successifs : 0,09.",
        (5.8, 4.7),
    ),
    "slam-creuse": (
        draw_sparsity,
        "Blocs non nuls de la matrice H d'un robot qui quadrille un champ : trois fines bandes. Son facteur L remplit "
        "toute la bande dans l'ordre du trajet, et reste bien plus vide dans un ordre mieux choisi.",
        (5.8, 2.5),
    ),
    "slam-signature": (
        draw_signature,
        "En haut, trois scans ; le deuxième est le premier décalé de dix rayons. En bas, les modules de leurs "
        "coefficients de Fourier : les deux premiers sont égaux, le troisième diffère.",
        (5.6, 4.5),
    ),
}
