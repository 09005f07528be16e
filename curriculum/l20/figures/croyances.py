"""Drawings of beliefs on the map: the grid filter, the particles, and the corridor that looks the same both ways."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from curriculum.l20.figures._plan import RANGE, draw_robot, draw_walls, french, module_map
from graders.plotting import Palette
from reference import se2
from reference.filters.resampling import comb_resampling
from reference.localisation.grid_filter import GridFilter, GridWorld, sample_move
from reference.localisation.mcl import MonteCarloLocalization, uniform_poses
from reference.localisation.odometry_motion import OdometryNoise
from reference.odometry import DifferentialDrive
from reference.sensors.beam import BeamModel, BeamSensor
from reference.world.grid_map import GridMap
from reference.world.simulation import SimulatedLidar, SimulatedRun, motions_through_waypoints, simulate

Floats = NDArray[np.float64]

COMMANDS = ((1, 0), (1, 0), (1, 0), (1, 0), (1, 0), (0, -1), (0, -1), (0, -1))
GRID_MOMENTS = (0, 1, 3, 8)
SIGMA = 1.5


@cache
def grid_story() -> list[tuple[tuple[int, int], Floats]]:
    """Where the robot is, (y, x), and what it believes, after the first scan and after each of eight steps."""
    world, rng = GridWorld.from_free_cells(module_map().free, RANGE), np.random.default_rng(2)
    lidar = SimulatedLidar.full_turn(4, RANGE, SIGMA)
    cell, belief = (8, 9), GridFilter(world, SIGMA)
    story = []
    for step in range(len(COMMANDS) + 1):
        if step > 0:
            belief.predict(COMMANDS[step - 1])
            cell = sample_move(world, cell, *COMMANDS[step - 1], rng)
        belief.correct(lidar.add_noise(world.scans[cell], rng))
        story.append((cell, belief.belief))
    return story


def draw_grid_filter(figure: Figure, palette: Palette) -> None:
    """The belief of the grid filter after the first scan and after 1, 3 and 8 steps."""
    figure.set_size_inches(5.8, 4.6)
    for axes, moment in zip(figure.subplots(2, 2).ravel(), GRID_MOMENTS, strict=True):
        cell, belief = grid_story()[moment]
        shade = np.ma.masked_where(belief < 2e-4, np.sqrt(belief / belief.max()))
        axes.imshow(shade, cmap=palette.ramp, vmin=0, vmax=1, extent=(0, 24, 16, 0), interpolation="nearest", zorder=1)
        draw_walls(axes, palette, module_map(), 0.45)
        axes.plot(cell[1] + 0.5, cell[0] + 0.5, "o", ms=9, mfc="none", mec=palette.alert, mew=2.0, zorder=6)
        title = "Premier scan" if moment == 0 else f"Après {moment} pas"
        axes.set_title(f"{title} : max {french(float(belief.max()), 2)}", fontsize=11)


MCL_WAY = (
    (2.5, 2.5),
    (6.0, 3.5),
    (10.0, 3.5),
    (12.0, 3.5),
    (12.0, 7.5),
    (20.0, 7.5),
    (21.0, 8.0),
    (12.0, 8.2),
    (4.5, 8.0),
    (4.5, 10.5),
)
MCL_MOMENTS = (-1, 0, 4, 9)
MCL_SEED = 15
MCL_TITLES = ("Aucune idée", "Premier scan", "Après 4 pas", "Après 9 pas")


def journey(grid_map: GridMap, way: tuple[tuple[float, float], ...], beams: int, sight: float, seed: int) -> Journey:
    """A robot that drives through `way` from its first point, and `rng` ready for the filter that follows it."""
    rng = np.random.default_rng(seed)
    start = (*way[0], 0.0)
    motions = motions_through_waypoints(start, way[1:], 1.0, np.pi / 4)
    lidar = SimulatedLidar.full_turn(beams, sight, 0.1)
    return Journey(grid_map, simulate(grid_map, motions, start, DifferentialDrive(0.5, 0.0, 0.01), lidar, rng), rng)


@dataclass(frozen=True, eq=False)
class Journey:
    """A map, what a robot measured while it drove through it, and the random numbers that its filter draws."""

    grid_map: GridMap
    run: SimulatedRun
    rng: np.random.Generator

    def filter(self, count: int) -> MonteCarloLocalization:
        """Particles that know nothing yet; the product of the rays is raised to the power 0.3."""
        sensor = BeamSensor(self.grid_map, BeamModel(self.run.lidar.max_range, sigma=0.5), 0.3)
        poses = uniform_poses(self.grid_map, count, self.rng)
        noise = OdometryNoise(0.1, 0.08, 0.1, 0.05)
        return MonteCarloLocalization(self.grid_map, sensor, poses, self.rng, motion=noise)

    def follow(self, localization: MonteCarloLocalization, steps: int) -> list[Floats]:
        """The belief as equally likely particles (n, 3): at first, and after each of the scans 0 … steps."""
        clouds = [localization.states.copy()]
        for step in range(steps + 1):
            if step > 0:
                localization.predict(se2.relative(self.run.odometry[step - 1], self.run.odometry[step]))
            localization.weigh(self.run.scan(step))
            clouds.append(localization.states[comb_resampling(localization.weights, 0.5).ancestors])
            if localization.is_degenerate:
                localization.resample()
        return clouds


@cache
def mcl_story() -> tuple[SimulatedRun, list[Floats]]:
    """A journey on the module's map and the 500 particles that follow it from nothing."""
    story = journey(module_map(), MCL_WAY, 12, RANGE, MCL_SEED)
    return story.run, story.follow(story.filter(500), max(MCL_MOMENTS))


def draw_particles(axes: Axes, palette: Palette, states: Floats, size: float = 2.6) -> None:
    """Particles as dots, with a short line for the heading of each; one path for all lines keeps the file small."""
    axes.plot(states[:, 0], states[:, 1], "o", ms=size, color=palette.estimate, alpha=0.6, mew=0, zorder=5)
    tips = states[:, :2] + 0.65 * np.column_stack([np.cos(states[:, 2]), np.sin(states[:, 2])])
    segments = np.stack([states[:, :2], tips, np.full_like(tips, np.nan)], axis=1).reshape(-1, 2)
    axes.plot(segments[:, 0], segments[:, 1], color=palette.estimate, alpha=0.45, lw=0.8, zorder=4)


def draw_mcl(figure: Figure, palette: Palette) -> None:
    """The particles before the first scan, after it, and after 4 and 9 steps, with the true robot."""
    figure.set_size_inches(5.8, 4.6)
    run, clouds = mcl_story()
    for axes, moment, title in zip(figure.subplots(2, 2).ravel(), MCL_MOMENTS, MCL_TITLES, strict=True):
        draw_walls(axes, palette, module_map(), 0.45)
        draw_particles(axes, palette, clouds[moment + 1])
        draw_robot(axes, run.truth[max(moment, 0)], palette.truth, palette, 0.5)
        axes.set_title(title, fontsize=11)


TWINS = """
##############################
#######..############..#######
#######..############..#######
#............................#
#............................#
#............................#
#######..############..#######
#######..############..#######
##############################
"""
TWINS_STEPS = 8


@cache
def twins_story() -> tuple[SimulatedRun, MonteCarloLocalization]:
    """A journey in a corridor that a half-turn leaves unchanged, and the filter that follows it from nothing."""
    story = journey(GridMap.from_text(TWINS), ((4.5, 4.4), (25.0, 4.4)), 16, 6.0, 9)
    localization = story.filter(2000)
    story.follow(localization, TWINS_STEPS)
    return story.run, localization


def draw_twins(figure: Figure, palette: Palette) -> None:
    """The two clouds of a symmetrical corridor, and the mean of all particles, where the robot is not."""
    figure.set_size_inches(5.8, 1.9)
    axes = figure.subplots()
    run, localization = twins_story()
    draw_walls(axes, palette, localization.grid_map, 0.45)
    draw_particles(axes, palette, localization.states[::4])
    draw_robot(axes, run.truth[TWINS_STEPS], palette.truth, palette, 0.45)
    mean = localization.mean
    axes.plot(mean[0], mean[1], "X", ms=12, color=palette.alert, mec=palette.paper, mew=1.2, zorder=9)
    for cloud in localization.clusters()[:2]:
        share = french(100.0 * cloud.weight, 0)
        axes.text(cloud.mean[0], 2.3, f"{share} %", ha="center", fontsize=11, color=palette.estimate, weight="bold")
    axes.text(mean[0], 6.7, "moyenne", ha="center", va="center", fontsize=11, color=palette.alert, weight="bold")


FIGURES = {
    "filtre-grille-etapes": (
        draw_grid_filter,
        "La croyance du filtre à grille sur la carte, à quatre instants : plusieurs taches après le premier scan, puis "
        "de moins en moins, et une seule, sur le robot, après huit pas.",
        (5.8, 4.6),
    ),
    "mcl-etapes": (
        draw_mcl,
        "500 particules sur la carte, à quatre instants : partout, puis en plusieurs nuages, puis en quelques-uns, "
        "enfin toutes autour du vrai robot.",
        (5.8, 4.6),
    ),
    "couloir-symetrique": (
        draw_twins,
        "Un couloir identique à lui-même par demi-tour. Deux nuages de particules s’y font face ; le robot est dans "
        "l’un, et la moyenne de toutes les particules tombe entre les deux, où il n’est pas.",
        (5.8, 1.9),
    ),
}
