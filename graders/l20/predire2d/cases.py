"""The inputs of l20/predire2d: beliefs, commands and scans on the module's map and on others, simplest first."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

from graders.core.contract.local import kit_source
from graders.core.contract.values import Arguments, Floats
from graders.l20 import world
from graders.l20.predire2d.beliefs import one_hot, spread, weighted
from reference.localisation.grid_filter import BEAMS, COMMANDS, Cell, Grid, GridWorld

MOVES = COMMANDS[1:]
Rng = np.random.Generator
#: Draws that are the same in every grading come first, so that what is caught does not depend on the seed. This one was
#: chosen because the catalogued mistakes that some draws let through all fail on it.
TELLING = 0


#: Neighbours (y, x) on the module's map whose scans differ by two opposite beams alone, which read the same two numbers
#: the other way round: side by side, then one above the other. Whoever forgets a beam, or its direction, or looks from
#: an edge of the cell, finds them as likely, or more alike than they are.
OPPOSED: tuple[tuple[Cell, Cell], ...] = (((3, 16), (3, 17)), ((1, 18), (2, 18)))
#: A cell (y, x) of that map whose scan is so far from another one's that the exponential of half the squares overflows.
FAR_FROM_OTHERS: Cell = (7, 17)
#: Three cells (y, x) of that map that see the same: of a third each, no rounded result adds up to 1.
ALIKE: tuple[Cell, ...] = ((3, 21), (12, 2), (12, 7))


def telling_then(rng: Rng) -> tuple[Rng, Rng]:
    """The generator of what is always drawn, then this one."""
    return np.random.default_rng(TELLING), rng


@cache
def module_world() -> GridWorld:
    """The map that the kit holds."""
    names: dict[str, object] = {"__name__": world.MODULE}
    exec(compile(kit_source(world.MODULE), f"<kit {world.MODULE}>", "exec"), names)
    return GridWorld.from_free_cells(np.asarray(names["libres"]), world.RANGE)


def open_world(rng: Rng, height: int = 5, width: int = 7) -> GridWorld:
    """A small map without walls around it, where leaving by one side and coming back by the other would be possible.

    On both diagonals two free cells meet at a corner between two walls: a robot slips there all the same.
    """
    while True:
        free = world.random_map(rng, height + 2, width + 2, fill=0.25)[1:-1, 1:-1]
        roomy_enough = np.count_nonzero(free) >= 0.5 * free.size
        if roomy_enough and _wraps(free) and _wraps(free.T) and _pinches(free) and _pinches(free[:, ::-1]):
            return GridWorld.from_free_cells(free, world.RANGE)


@cache
def _steady_open_world() -> GridWorld:
    return open_world(np.random.default_rng(TELLING))


def steady_open_world(rng: Rng) -> GridWorld:
    """The same such map in every grading: each of its sides is then judged whatever the seed."""
    return _steady_open_world()


def _wraps(free: Grid) -> bool:
    """Does some row have both its ends free?"""
    return bool(np.any(free[:, 0] & free[:, -1]))


def _pinches(free: Grid) -> bool:
    """Do some two cells down a diagonal have walls on both sides?"""
    return bool(np.any(free[:-1, :-1] & free[1:, 1:] & ~free[:-1, 1:] & ~free[1:, :-1]))


def pick(rng: Rng, mask: Grid) -> Cell:
    """One of the cells (y, x) of a mask."""
    y, x = rng.choice(np.argwhere(mask))
    return int(y), int(x)


def roomy(free: Grid) -> Grid:
    """The free cells whose eight neighbours are free."""
    padded = np.pad(free, 1)
    height, width = free.shape
    windows = [padded[dy : dy + height, dx : dx + width] for dy in range(3) for dx in range(3)]
    return np.asarray(np.logical_and.reduce(windows))


def side_by_side(clear: Grid) -> dict[Cell, float]:
    """Probabilities of two cells of the mask, one above the other: moved along x, their arrivals overlap."""
    y, x = (int(k) for k in np.argwhere(clear[:-1] & clear[1:])[0])
    return {(y, x): 0.75, (y + 1, x): 0.25}


def open_moves(rng: Rng, grid: GridWorld) -> Iterator[Arguments]:
    """Far from walls: the example of the statement, every command, then doubts between two cells, which meet once."""
    clear = roomy(grid.free)
    shape = grid.free.shape
    yield one_hot(shape, (2, 3)), 1, 0
    for du, dv in MOVES:
        yield one_hot(shape, pick(rng, clear)), du, dv
    yield weighted(shape, side_by_side(clear)), 1, 0
    for du, dv in MOVES:
        first, second = (int(i) for i in rng.choice(np.flatnonzero(clear), 2, replace=False))
        belief = np.zeros(shape)
        belief.flat[[first, second]] = 0.75, 0.25
        yield belief, du, dv


def moves_near_walls(rng: Rng, grid: GridWorld) -> Iterator[Arguments]:
    """The doorway of the statement, beside it, a corner, cells against a wall, then the whole map."""
    shape = grid.free.shape
    yield one_hot(shape, (3, 6)), 1, 0
    yield one_hot(shape, (2, 6)), 1, 0
    yield one_hot(shape, (1, 1)), -1, 0
    yield one_hot(shape, (1, 1)), 0, -1
    tight = grid.free & ~roomy(grid.free)
    for du, dv in MOVES:
        yield one_hot(shape, pick(rng, tight)), du, dv
    yield grid.uniform_belief(), 0, 1
    for du, dv in MOVES:
        yield spread(rng, grid.free), du, dv


def moves_at_the_edge(rng: Rng, grid: GridWorld) -> Iterator[Arguments]:
    """Out of the grid on each side and no move at all, the same in every grading; then beliefs over the whole map."""
    free, steady = grid.free, np.random.default_rng(TELLING)
    sides: dict[tuple[int, int], tuple[Any, Any]] = {
        (-1, 0): (slice(None), 0),
        (1, 0): (slice(None), -1),
        (0, -1): (0, slice(None)),
        (0, 1): (-1, slice(None)),
    }
    for (du, dv), side in sides.items():
        edge = np.zeros_like(free)
        edge[side] = free[side]
        opposite = np.zeros_like(free)
        opposite[side] = np.flip(free, axis=1 if du else 0)[side]
        yield one_hot(free.shape, pick(steady, edge & opposite)), du, dv
    yield one_hot(free.shape, pick(steady, free)), 0, 0
    yield spread(steady, free), 0, 0
    for du, dv in MOVES * 2:
        yield spread(rng, free), du, dv


def neighbour(rng: Rng, grid: GridWorld, cell: Cell) -> Cell:
    """A free cell beside a free cell of a connected map."""
    around = [(cell[0] + dv, cell[1] + du) for du, dv in MOVES]
    free = [other for other in around if grid.is_free(other)]
    return free[int(rng.integers(len(free)))]


def doubts(rng: Rng, grid: GridWorld) -> Iterator[Arguments]:
    """Between two neighbours: the example of the statement, several sigmas; then nothing known at all."""
    shape = grid.free.shape
    yield one_hot(shape, (1, 1), (1, 2)), grid.scans[1, 1], 0.5
    yield one_hot(shape, (1, 1), (1, 2)), grid.scans[1, 1], 1.0
    yield one_hot(shape, *ALIKE), grid.scans[ALIKE[0]], 0.5
    away = max(
        map(tuple, np.argwhere(grid.free)), key=lambda cell: float(np.sum((grid.scans[cell] - grid.scans[1, 1]) ** 2))
    )
    yield one_hot(shape, (1, 1), (int(away[0]), int(away[1]))), grid.scans[1, 1], 5.0
    yield grid.uniform_belief(), grid.scans[FAR_FROM_OTHERS], 0.4
    for sigma in (1.5, 1.0, 0.5):
        cell = pick(rng, grid.free)
        other = neighbour(rng, grid, cell)
        yield one_hot(shape, cell, other), grid.scans[cell], sigma
        yield weighted(shape, {cell: 0.25, other: 0.75}), grid.scans[cell], sigma
    for sigma in (0.5, 0.4):
        yield grid.uniform_belief(), grid.scans[pick(rng, grid.free)], sigma


def _opposed(grid: GridWorld) -> Iterator[tuple[Floats, Cell]]:
    """The doubts between two opposed cells of the module's map, and the one of the two where the robot is."""
    for pair in OPPOSED:
        for cell in pair:
            yield one_hot(grid.free.shape, *pair), cell


def plain_doubts(rng: Rng, grid: GridWorld) -> Iterator[Arguments]:
    """Between two neighbours, equally likely before: the scan is exactly that of one of them."""
    shape = grid.free.shape
    yield one_hot(shape, (1, 1), (1, 2)), grid.scans[1, 1], 0.5
    for belief, cell in _opposed(grid):
        yield belief, grid.scans[cell], 0.5
    for source in telling_then(rng):
        for sigma in (0.5, 1.0, 1.5):
            cell = pick(source, grid.free)
            yield one_hot(shape, cell, neighbour(source, grid, cell)), grid.scans[cell], sigma


def noisy_scans(rng: Rng, grid: GridWorld) -> Iterator[Arguments]:
    """Between two neighbours, then any belief: a scan from the likeliest cell with some noise, several sigmas.

    The evidence stays above 1e-3 even with normalised densities, so that a guard of 1e-12 in a division is harmless.
    """
    for sigma in (1.5, 0.5):
        cell = pick(rng, grid.free)
        belief = one_hot(grid.free.shape, cell, neighbour(rng, grid, cell))
        yield belief, noisy_scan(rng, grid, belief, 0.3 * sigma), sigma
    for sigma in (0.5, 1.0, 0.3, 0.7, 0.8, 1.0):
        belief = spread(rng, grid.free)
        yield belief, noisy_scan(rng, grid, belief, 0.3 * sigma), sigma


def noisy_scan(rng: Rng, grid: GridWorld, belief: Floats, deviation: float) -> Floats:
    """What the lidar reads in the likeliest cell: noise where a ray hit, kept between 0 and the range."""
    seen = grid.scans[np.unravel_index(int(np.argmax(belief)), belief.shape)]
    noise = np.clip(rng.normal(0.0, deviation, BEAMS), -2.0 * deviation, 2.0 * deviation)
    return np.asarray(np.where(seen < world.RANGE, np.clip(seen + noise, 0.0, world.RANGE), world.RANGE))


def without_sigma(rng: Rng, grid: GridWorld) -> Iterator[Arguments]:
    """The same doubts, sigma being left out."""
    shape = grid.free.shape
    yield one_hot(shape, (1, 1), (1, 2)), grid.scans[1, 1]
    for belief, cell in _opposed(grid):
        yield belief, grid.scans[cell]
    for source in telling_then(rng):
        for _ in range(3):
            cell = pick(source, grid.free)
            yield one_hot(shape, cell, neighbour(source, grid, cell)), grid.scans[cell]
