"""Markov localisation on a grid: a belief (H, W), moved by an uncertain command and corrected by a scan.

A belief is an array (H, W) indexed (y, x), non-negative, zero on walls, of sum 1. A command (du, dv) asks for one cell
along x (columns) or along y (rows), or for none. Whatever lies outside the grid is wall.

Source: Thrun, Burgard, Fox, "Probabilistic Robotics" (2005), table 8.1 (grid localisation), with the motion model of
the course: 0.8 as asked, 0.1 for each slip of one cell sideways, unless another `slip` is asked for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError
from reference.world.raycast import cast_scans

Belief = NDArray[np.float64]
Floats = NDArray[np.float64]
Grid = NDArray[np.bool_]
Cell = tuple[int, int]

BEAMS = 4
P_SLIP = 0.1
COMMANDS = ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1))


class GridFilterError(InvalidArgumentError):
    """Input for which there is no belief; `argument` names it."""


class EmptyBeliefError(GridFilterError):
    """A belief that leaves no mass to correct."""


@dataclass(frozen=True)
class Landing:
    """One outcome of a command: a displacement (dx, dy) in cells, and its probability."""

    probability: float
    dx: int
    dy: int


@dataclass(frozen=True)
class GridWorld:
    """A map: `free` (H, W), and `scans` (H, W, 4), what the noiseless lidar sees at each cell's centre, heading 0."""

    free: Grid
    scans: Floats

    @classmethod
    def from_free_cells(cls, free: ArrayLike, max_range: float) -> GridWorld:
        """The world of a map (H, W), True where free. Raises GridFilterError when no cell is free."""
        grid = np.array(free, dtype=np.bool_)
        if grid.ndim != 2 or not grid.any():
            raise GridFilterError("free", "is not a map (H, W) with a free cell")
        y, x = np.indices(grid.shape)
        poses = np.column_stack([x.ravel() + 0.5, y.ravel() + 0.5, np.zeros(grid.size)])
        return cls(grid, cast_scans(grid, poses, BEAMS, max_range).reshape(*grid.shape, BEAMS))

    def uniform_belief(self) -> Belief:
        """The belief of a robot that knows nothing."""
        return self.free / np.count_nonzero(self.free)

    def is_free(self, cell: Cell) -> bool:
        """Is the cell (y, x) in the grid, and free?"""
        y, x = cell
        return 0 <= y < self.free.shape[0] and 0 <= x < self.free.shape[1] and bool(self.free[y, x])


def possible_landings(du: int, dv: int, slip: float = P_SLIP) -> tuple[Landing, ...]:
    """Where a command leads: straight, or one cell sideways too; a command of (0, 0) leads nowhere, for sure.

    p(+(du, dv)) = 1 - 2 slip and p(+(du, dv) + (dv, du)) = p(+(du, dv) - (dv, du)) = slip                  (1)
    """
    if not 0.0 <= slip <= 0.5:
        raise GridFilterError("slip", f"{slip} is not in [0, 1/2]")
    if (du, dv) not in COMMANDS:
        raise GridFilterError("du, dv", f"({du}, {dv}) is not a move of at most one cell along one axis")
    if (du, dv) == (0, 0):
        return (Landing(1.0, 0, 0),)
    slips = (Landing(slip, du + dv, dv + du), Landing(slip, du - dv, dv - du))
    return (Landing(1.0 - 2.0 * slip, du, dv), *slips)


def predict(world: GridWorld, belief: ArrayLike, du: int, dv: int, slip: float = P_SLIP) -> Belief:
    """The belief after the command: sum over x' of p(x | x', u) bel(x'), by (1); who would land on a wall stays.

    Raises GridFilterError.
    """
    prior = _check_belief(world, belief)
    moved = np.zeros((prior.shape[0] + 2, prior.shape[1] + 2))
    free = np.pad(world.free, 1)
    for landing in possible_landings(du, dv, slip):
        there = _neighbour_slices(landing.dy, landing.dx, prior.shape)
        leaving = np.where(free[there], prior, 0.0)
        moved[there] += landing.probability * leaving
        moved[1:-1, 1:-1] += landing.probability * (prior - leaving)
    return moved[1:-1, 1:-1]


def _neighbour_slices(dy: int, dx: int, shape: tuple[int, ...]) -> tuple[slice, slice]:
    """In an array with one cell of margin, the cells at (dy, dx) from those of the grid."""
    return slice(1 + dy, 1 + dy + shape[0]), slice(1 + dx, 1 + dx + shape[1])


def correct(world: GridWorld, belief: ArrayLike, scan: ArrayLike, sigma: float) -> Belief:
    """The belief after a scan (4,): bel(x) times exp(-sum of (z - z_expected(x))^2 / (2 sigma^2)), normalised. (2)

    Computed with logarithms, so that a scan unlike any other still tells cells apart. Raises GridFilterError, and
    EmptyBeliefError when the belief is zero on every free cell.
    """
    weights, _ = _scaled_posterior(world, belief, scan, sigma)
    return np.asarray(weights / weights.sum())


def _scaled_posterior(world: GridWorld, belief: ArrayLike, scan: ArrayLike, sigma: float) -> tuple[Floats, float]:
    """The numerator of (2) (H, W), divided by its greatest exponential, and the exponent of that."""
    prior = _check_belief(world, belief)
    seen = np.asarray(scan, dtype=np.float64)
    if seen.shape != (BEAMS,) or not np.all(np.isfinite(seen)):
        raise GridFilterError("scan", f"is not an array ({BEAMS},) of finite distances")
    if not 0.0 < sigma < np.inf:
        raise GridFilterError("sigma", f"{sigma} is not a positive standard deviation")
    exponent = -np.sum((seen - world.scans) ** 2, axis=2) / (2.0 * sigma**2)
    possible = world.free & (prior > 0.0)
    if not possible.any():
        raise EmptyBeliefError("belief", "is zero on every free cell")
    exponent = np.where(possible, exponent, -np.inf)
    greatest = float(exponent.max())
    return prior * np.exp(exponent - greatest), greatest


def _check_belief(world: GridWorld, belief: ArrayLike) -> Belief:
    prior = np.asarray(belief, dtype=np.float64)
    if prior.shape != world.free.shape:
        raise GridFilterError("belief", f"has shape {prior.shape}, not {world.free.shape}")
    if not np.all(np.isfinite(prior)) or np.any(prior < 0.0):
        raise GridFilterError("belief", "holds a number that is not a probability")
    return prior


def sample_move(world: GridWorld, cell: Cell, du: int, dv: int, rng: np.random.Generator, slip: float = P_SLIP) -> Cell:
    """The free cell (y, x) where a robot that stands in `cell` ends up, drawn from (1)."""
    outcomes = possible_landings(du, dv, slip)
    chosen = outcomes[int(rng.choice(len(outcomes), p=[landing.probability for landing in outcomes]))]
    target = (cell[0] + chosen.dy, cell[1] + chosen.dx)
    return target if world.is_free(target) else cell


def most_likely_cell(belief: Belief) -> Cell:
    """The cell (y, x) of the greatest probability; the first one in reading order when several share it."""
    y, x = np.unravel_index(int(np.argmax(belief)), belief.shape)
    return int(y), int(x)


class GridFilter:
    """A BayesFilter over the cells of a world: controls are commands (du, dv), measurements scans (4,).

    The belief is uniform at the start. Raises GridFilterError.
    """

    def __init__(self, world: GridWorld, sigma: float) -> None:
        self.world, self.sigma, self.belief = world, sigma, world.uniform_belief()

    @property
    def mean(self) -> Floats:
        """The mean (x, y) of the centres of the cells."""
        return np.array([self.belief.sum(axis=0) @ self._column_centres, self.belief.sum(axis=1) @ self._row_centres])

    @property
    def covariance(self) -> Floats:
        """The covariance (2, 2) of (x, y)."""
        x, y = self._column_centres - self.mean[0], self._row_centres - self.mean[1]
        mixed = y @ self.belief @ x
        return np.array([[self.belief.sum(axis=0) @ x**2, mixed], [mixed, self.belief.sum(axis=1) @ y**2]])

    def predict(self, control: tuple[int, int]) -> None:
        self.belief = predict(self.world, self.belief, *control)

    def correct(self, measurement: ArrayLike) -> float:
        """Equation (2), and the logarithm of the evidence, its Gaussian densities normalised."""
        weights, exponent = _scaled_posterior(self.world, self.belief, measurement, self.sigma)
        evidence = float(weights.sum())
        self.belief = np.asarray(weights / evidence)
        return exponent + float(np.log(evidence)) - BEAMS * float(np.log(self.sigma * np.sqrt(2.0 * np.pi)))

    @property
    def _column_centres(self) -> Floats:
        return np.arange(self.world.free.shape[1], dtype=np.float64) + 0.5

    @property
    def _row_centres(self) -> Floats:
        return np.arange(self.world.free.shape[0], dtype=np.float64) + 0.5
