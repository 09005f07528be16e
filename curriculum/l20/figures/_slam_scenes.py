"""What the drawings of mapping and SLAM share: a tour of the module's map, its odometry, its maps and its graph."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from curriculum.l20.kit import l20
from graders.plotting import Palette
from reference.occupancy import OccupancyGrid
from reference.odometry import DifferentialDrive
from reference.pose_graph import PoseGraph, gauss_newton
from reference.registration import MatchingSettings, match_scans
from reference.se2 import compose, relative
from reference.world.grid_map import GridMap
from reference.world.simulation import SimulatedLidar, SimulatedRun, motions_through_waypoints, simulate

Floats = NDArray[np.float64]

START = (3.5, 3.5, 0.0)
TOUR = (
    *((11.5, 3.5), (11.5, 8.0), (17.5, 8.0), (17.5, 13.5), (6.5, 13.5)),
    *((6.5, 10.8), (4.5, 10.8), (4.5, 8.0), (3.5, 8.0), (3.5, 3.5), (6.0, 3.5)),
)
SEED = 7
FINE = 0.2
EVERY = 3
MATCHING = MatchingSettings(max_distance=1.5, scale=0.2, near=0.3, sigma=0.05)
STEP_INFORMATION = np.diag([250.0, 250.0, 500.0])
CLOSURE_INFORMATION = np.diag([400.0, 400.0, 2500.0])


@cache
def world() -> GridMap:
    """The map of the module, one cell long for one metre."""
    return GridMap.from_free(l20.libres)


@cache
def tour() -> SimulatedRun:
    """Once around the building and back into the first room, by wheels that slip and a lidar of 120 beams."""
    motions = motions_through_waypoints(START, TOUR, 0.5, 0.4)
    drive = DifferentialDrive(0.6, 0.0, 0.045)
    return simulate(
        world(), motions, START, drive, SimulatedLidar.full_turn(120, 12.0, 0.05), np.random.default_rng(SEED)
    )


def occupancy(poses: Floats, scans: range) -> OccupancyGrid:
    """The log-odds of small cells from some scans of the tour, taken to stand at `poses`."""
    rows, columns = (round((length + 6) / FINE) for length in world().shape)
    grid = OccupancyGrid(np.zeros((rows, columns)), FINE, np.array([-3.0, -3.0, 0.0]))
    for index in scans:
        grid.integrate(tour().scan(index), poses[index])
    return grid


@cache
def graph(*, scans: bool = False) -> tuple[PoseGraph, Floats, Floats]:
    """Key poses of the tour, joined by odometry and by closures where the robot is back: graph, odometry, truth.

    With `scans`, each key pose is also matched with the one before by their scans.
    """
    run, rng = tour(), np.random.default_rng(SEED)
    keys = np.arange(0, len(run), EVERY)
    truth, odometry = run.truth[keys], run.odometry[keys]
    n = len(keys)
    steps = [relative(odometry[k], odometry[k + 1]) for k in range(n - 1)]
    edges = [(k, k + 1, step, STEP_INFORMATION) for k, step in enumerate(steps)]
    if scans:
        edges += [(k, k + 1, *_matched(keys[k], keys[k + 1], step)) for k, step in enumerate(steps)]
    for i in range(n):
        for j in range(i + 10, n):
            if np.hypot(*(truth[j, :2] - truth[i, :2])) < 0.6:
                z = relative(truth[i], truth[j]) + rng.normal(0.0, [0.05, 0.05, 0.02])
                edges.append((i, j, z, CLOSURE_INFORMATION))
    return PoseGraph.from_edges(n, edges), odometry, truth


def _matched(a: int, b: int, guess: Floats) -> tuple[Floats, Floats]:
    """What the scans of two moments say of the motion between them."""
    match = match_scans(tour().scan(a), tour().scan(b), guess, matching=MATCHING)
    return match.T_a_b, match.information


@cache
def corrected() -> Floats:
    """The key poses of the tour once the graph is optimised."""
    made, odometry, _ = graph(scans=True)
    return gauss_newton(made, odometry).poses


def corrected_poses() -> Floats:
    """Every pose of the tour, each carried along by the key pose before it."""
    run, keys = tour(), corrected()
    return np.array(
        [compose(keys[k // EVERY], relative(run.odometry[k - k % EVERY], run.odometry[k])) for k in range(len(run))]
    )


def panels(figure: Figure, rows: int, columns: int) -> list[Axes]:
    """Axes side by side, row after row."""
    return list(figure.subplots(rows, columns, squeeze=False).ravel())


def bare(axes: Axes) -> None:
    """A drawing to scale, y down the page as the map is printed, without axes."""
    axes.set_aspect("equal")
    axes.set_axis_off()


def frame_map(axes: Axes, margin: float = 0.6) -> None:
    height, width = world().shape
    bare(axes)
    axes.set_xlim(-margin, width + margin)
    axes.set_ylim(height + margin, -margin)


def draw_walls(axes: Axes, palette: Palette, alpha: float = 0.9) -> None:
    """The cells of the module's map that are wall."""
    shade = np.ma.masked_where(l20.libres, np.ones(l20.libres.shape))
    from matplotlib.colors import ListedColormap

    axes.imshow(
        shade,
        cmap=ListedColormap([palette.ink]),
        extent=(0, l20.W, l20.H, 0),
        alpha=alpha,
        interpolation="nearest",
        zorder=1,
    )


def draw_occupancy(axes: Axes, grid: OccupancyGrid, palette: Palette) -> None:
    """Ink where occupied, paper where free, faint where unknown."""
    from matplotlib.colors import LinearSegmentedColormap

    colours = LinearSegmentedColormap.from_list("occupation", [palette.paper, palette.faint, palette.ink])
    (x, y), (rows, columns) = grid.T_world_map[:2], grid.log_odds.shape
    extent = (x, x + columns * grid.resolution, y + rows * grid.resolution, y)
    axes.imshow(grid.probabilities, cmap=colours, vmin=0, vmax=1, extent=extent, interpolation="nearest", zorder=1)


def draw_robot(axes: Axes, pose: Floats, colour: str, size: float = 0.45, zorder: float = 6) -> None:
    """A disc and the way it looks."""
    from matplotlib.patches import Circle

    x, y, theta = pose
    axes.add_patch(Circle((x, y), size, facecolor=colour, edgecolor="none", zorder=zorder))
    axes.plot([x, x + 2 * size * np.cos(theta)], [y, y + 2 * size * np.sin(theta)], color=colour, lw=2.2, zorder=zorder)
