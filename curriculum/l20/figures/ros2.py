"""Drawings of the texts on ROS 2: nodes, frames, late stamps, inflation, dynamic window."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch
from numpy.typing import NDArray

from curriculum.l20.figures._plan import draw_impacts, draw_robot, draw_walls, french, mark_axes, module_map, ray_ends
from graders.plotting import Palette
from reference.planning.dynamic_window import DynamicWindow, RobotLimits, navigate, predict_drive
from reference.planning.grid_search import SearchGrid
from reference.planning.inflation import inflate
from reference.world.grid_map import GridMap
from reference.world.scan import full_turn_angles

Point = tuple[float, float]

FINE = 8  # cells of planning in a cell of the map


def _sheet(figure: Figure, width: float, height: float) -> Axes:
    axes = figure.add_subplot()
    axes.set(xlim=(0, width), ylim=(0, height), xticks=[], yticks=[])
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)
    return axes


def _box(axes: Axes, palette: Palette, at: Point, text: str, colour: str, size: Point = (2.3, 0.8)) -> None:
    corner = (at[0] - size[0] / 2, at[1] - size[1] / 2)
    shape = FancyBboxPatch(
        corner, *size, boxstyle="round,pad=0,rounding_size=0.16", fc=palette.paper, ec=colour, lw=1.6
    )
    axes.add_patch(shape)
    axes.text(*at, text, ha="center", va="center", fontsize=10, zorder=4)


def _arrow(
    axes: Axes, palette: Palette, start: Point, end: Point, text: str = "", *, bend: float = 0.0, shift: Point = (0, 0)
) -> None:
    axes.annotate(
        "",
        end,
        start,
        arrowprops={
            "arrowstyle": "-|>",
            "color": palette.ink,
            "lw": 1.2,
            "connectionstyle": f"arc3,rad={bend}",
            "shrinkA": 2,
            "shrinkB": 2,
        },
    )
    if text:
        x, y = (start[0] + end[0]) / 2 + shift[0], (start[1] + end[1]) / 2 + shift[1]
        axes.text(x, y, text, ha="center", va="center", fontsize=9.5, family="DejaVu Sans Mono", color=palette.measure)


def draw_nodes(figure: Figure, palette: Palette) -> None:
    axes = _sheet(figure, 11.0, 8.0)
    sense, think, act = palette.measure, palette.truth, palette.estimate
    places: dict[str, tuple[Point, str]] = {
        "pilote lidar": ((1.6, 7.2), sense),
        "pilote moteurs": ((1.6, 2.4), sense),
        "localisation": ((5.5, 5.6), think),
        "carte": ((5.5, 7.2), think),
        "odométrie": ((1.6, 4.0), think),
        "planificateur": ((9.4, 7.2), think),
        "contrôleur": ((9.4, 4.8), act),
        "sécurité": ((9.4, 2.4), act),
    }
    for name, (at, colour) in places.items():
        _box(axes, palette, at, name, colour)
    _arrow(axes, palette, (2.75, 6.95), (4.35, 5.9), "/scan", shift=(0.15, 0.42))
    _arrow(axes, palette, (1.6, 2.8), (1.6, 3.6), "roues", shift=(-0.75, 0))
    _arrow(axes, palette, (2.75, 4.3), (4.35, 5.3), "/odom", shift=(0.25, -0.4))
    _arrow(axes, palette, (5.5, 6.8), (5.5, 6.0), "/map", shift=(-0.7, 0.0))
    _arrow(axes, palette, (6.65, 7.2), (8.25, 7.2), "/map", shift=(0, 0.32))
    _arrow(axes, palette, (6.65, 5.9), (8.4, 6.8), "tf", shift=(-0.1, 0.32))
    _arrow(axes, palette, (9.4, 6.8), (9.4, 5.2), "/plan", shift=(-0.75, 0.0))
    _arrow(axes, palette, (9.4, 4.4), (9.4, 2.8), "/cmd_vel_voulue", shift=(-1.75, 0.15))
    _arrow(axes, palette, (1.2, 6.8), (8.25, 2.65), "/scan", bend=0.32, shift=(0.6, -2.0))
    _arrow(axes, palette, (8.25, 2.2), (2.75, 2.2), "/cmd_vel", shift=(0, -0.35))
    for x, colour, text in ((1.6, sense, "matériel"), (4.9, think, "savoir"), (8.2, act, "agir")):
        axes.plot([x - 0.9, x - 0.45], [0.9, 0.9], color=colour, lw=3)
        axes.text(x - 0.3, 0.9, text, va="center")


def draw_tree(figure: Figure, palette: Palette) -> None:
    axes = _sheet(figure, 12.0, 7.4)
    rows = [("map", 6.8), ("odom", 4.9), ("base_link", 3.0)]
    for name, y in rows:
        _box(axes, palette, (2.2, y), name, palette.ink, (2.4, 0.75))
    for x, name in ((0.95, "laser"), (3.45, "imu")):
        _box(axes, palette, (x, 0.9), name, palette.ink, (1.7, 0.75))
        _arrow(axes, palette, (2.2 + (x - 2.2) * 0.35, 2.6), (x, 1.3))
    _arrow(axes, palette, (2.2, 6.4), (2.2, 5.3))
    _arrow(axes, palette, (2.2, 4.5), (2.2, 3.4))
    captions = [
        (5.85, "localisation (AMCL ou SLAM)", "corrige lentement, peut sauter", palette.truth),
        (3.95, "odométrie (encodeurs, IMU)", "continue et lisse, mais dérive", palette.estimate),
        (1.95, "description du robot (URDF)", "fixe : mesurée sur le châssis", palette.measure),
    ]
    for y, who, how, colour in captions:
        axes.text(4.6, y + 0.28, who, va="center", color=colour, weight="bold", fontsize=10.5)
        axes.text(4.6, y - 0.32, how, va="center", fontsize=10)


def draw_late_scan(figure: Figure, palette: Palette) -> None:
    axes = figure.add_subplot()
    world = module_map()
    draw_walls(axes, palette, world)
    pose = np.array([11.5, 7.6, 0.4])
    ranges = world.cast_scans([pose], full_turn_angles(180), 12.0)[0]
    late = pose - [0.0, 0.0, 1.5 * 0.05]
    hit = ranges < 12.0
    draw_impacts(axes, ray_ends(pose, ranges)[hit], palette.measure, 12)
    draw_impacts(axes, ray_ends(late, ranges)[hit], palette.alert, 12)
    draw_robot(axes, pose, palette.truth, palette)
    for colour, text in ((palette.measure, "pose à l’heure"), (palette.alert, "pose en retard de 50 ms")):
        axes.scatter([], [], color=colour, s=26, label=text)
    figure.legend(loc="outside lower center", ncols=2)


def _fine_free() -> NDArray[np.bool_]:
    return np.kron(module_map().free, np.ones((FINE, FINE), dtype=np.bool_))


def draw_inflation(figure: Figure, palette: Palette) -> None:
    axes = figure.add_subplot()
    radius = 0.3 * FINE
    inflated = inflate(_fine_free(), radius, weight=3.0, fall=1.6 / FINE)
    height, width = module_map().shape
    shown = np.where(inflated.free, inflated.costs, np.nan)
    axes.imshow(shown, cmap=palette.ramp, extent=(0, width, height, 0), vmin=0, vmax=6, interpolation="nearest")
    draw_walls(axes, palette, module_map())
    mark_axes(axes, palette)
    start, goal = (12 * FINE + 4, 2 * FINE + 4), (2 * FINE + 4, 21 * FINE + 4)
    for costs, colour, line, text in (
        (None, palette.ink, "--", "sans coût"),
        (inflated.costs, palette.estimate, "-", "avec coût"),
    ):
        route = SearchGrid(inflated.free, costs).astar(start, goal)
        label = f"{text} : {french(route.length_in_cells / FINE)} cases"
        axes.plot(*(route.cell_centres.T / FINE), color=colour, ls=line, lw=2.4, label=label, zorder=6)
    axes.scatter([2.5], [12.5], s=60, color=palette.ink, zorder=7)
    axes.scatter([21.5], [2.5], s=120, marker="*", color=palette.ink, zorder=7)
    figure.legend(loc="outside lower center", ncols=2)


def draw_window(figure: Figure, palette: Palette) -> None:
    axes = figure.add_subplot()
    draw_walls(axes, palette, module_map())
    world = GridMap.from_free(_fine_free(), 1.0 / FINE)
    limits = RobotLimits(radius=0.25, max_v=2.0, max_w=2.2, max_dv=3.0, max_dw=8.0, period=0.25, horizon=1.6, samples=9)
    goal = np.array([13.0, 2.0])
    journey = navigate(world, np.array([2.5, 8.0, 0.0]), goal, limits)
    window = DynamicWindow.from_goal(world, goal, limits)
    at = int(np.argmin(np.abs(journey.poses[:, 0] - 8.2)))
    pose, speed = journey.poses[at], journey.speeds[at - 1]
    choices = np.array([(v, w) for v in np.linspace(0.4, 2.0, 4) for w in np.linspace(-2.0, 2.0, 17)])
    arcs = predict_drive(pose, choices, limits, brake=False, duration=limits.horizon)
    clear = window.clearance(arcs).min(axis=1) > limits.radius
    for path, free in zip(arcs, clear, strict=True):
        colour, width = (palette.faint, 1.2) if free else (palette.alert, 0.7)
        axes.plot(path[:, 0], path[:, 1], color=colour, lw=width, zorder=4 if free else 3)
    speeds = window.choose_speed(pose, speed)[None]
    chosen = predict_drive(pose, speeds, limits, brake=False, duration=limits.horizon)[0]
    axes.plot(journey.poses[:, 0], journey.poses[:, 1], color=palette.truth, lw=1.6, zorder=5)
    axes.plot(chosen[:, 0], chosen[:, 1], color=palette.estimate, lw=3.0, zorder=6)
    draw_robot(axes, pose, palette.estimate, palette)
    axes.scatter(*goal, s=120, marker="*", color=palette.ink, zorder=7)


FIGURES = {
    "ros2-noeuds": (
        draw_nodes,
        "Schéma de huit nœuds reliés par des topics. Le scan du lidar va à la localisation et à la sécurité ; "
        "l’odométrie va à la localisation ; la carte et la pose vont au planificateur, puis le chemin au "
        "contrôleur, puis la vitesse à la sécurité, qui la transmet ou non aux moteurs.",
        (5.6, 4.1),
    ),
    "ros2-arbre": (
        draw_tree,
        "Arbre : map est le parent d’odom, odom celui de base_link, base_link celui de laser et de imu. La "
        "première transformation vient de la localisation, la deuxième de l’odométrie, les dernières de la "
        "description du robot.",
        (5.6, 3.5),
    ),
    "ros2-retard": (
        draw_late_scan,
        "Plan du module avec un scan placé deux fois : à l’heure, les impacts tombent sur les murs ; avec 50 "
        "ms de retard, ils sont tournés autour du robot et s’écartent des murs d’autant plus qu’ils sont "
        "loin.",
        (5.6, 3.9),
    ),
    "ros2-inflation": (
        draw_inflation,
        "Plan du module teinté près des murs, avec deux chemins entre les mêmes points : celui sans coût "
        "d’inflation rase les murs, celui avec coût s’en écarte.",
        (5.6, 4.2),
    ),
    "ros2-fenetre": (
        draw_window,
        "Un robot entouré d’arcs de cercle : ceux qui touchent un mur sont rouges, les autres gris, celui "
        "qu’il choisit est orange et épais ; une ligne bleue montre tout le trajet jusqu’au but.",
        (5.6, 4.1),
    ),
}
