"""The inputs of l20/modele_faisceau: readings beside what was expected, then maps, simplest first.

Shares are all positive, one case leaving little to chance, and sum to one; a reading is exactly the expected one,
exactly the range, or away from both by more than any tolerance; none is beyond the range.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from graders.core.contract.values import Arguments, Floats
from graders.l20 import world

Grid = NDArray[np.bool_]
Rng = np.random.Generator
Drawing = Callable[[Rng], Iterator[Arguments]]

#: Draws that are the same in every grading come first.
TELLING = 3
#: How near a reading may be to what decides of a cause, without being it.
APART = 0.02
#: So many beams that the product of what they weigh is below the least positive number.
MANY = 400
USUAL = (0.7, 0.1, 0.1, 0.1)
OTHER = (0.5, 0.25, 0.05, 0.2)
THIRD = (0.35, 0.15, 0.4, 0.1)
#: So little is left to chance that who raises small densities is seen.
CERTAIN = (0.9, 0.06, 0.034, 0.006)


def reading(
    z: Sequence[float] | Floats,
    expected: Sequence[float] | Floats,
    sigma: float,
    z_max: float,
    alpha: Sequence[float] | Floats,
    lam: float,
) -> Arguments:
    """The arguments of `log_vraisemblance`, in their order."""
    return np.array(z, dtype=float), np.array(expected, dtype=float), sigma, z_max, np.array(alpha), lam


def telling_then(rng: Rng) -> tuple[Rng, Rng]:
    """The generator of what is always drawn, then this one."""
    return np.random.default_rng(TELLING), rng


def _settings(rng: Rng) -> tuple[float, float, Floats, float]:
    """sigma, z_max, alpha, lam, none of them usual; the shares are unequal and at least 5 %."""
    shares = 0.05 + 0.8 * rng.dirichlet((2.0, 2.0, 2.0, 2.0))
    alpha = np.round(shares / shares.sum(), 2)
    alpha[0] = round(1.0 - float(alpha[1:].sum()), 2)
    sigma, z_max, lam = rng.uniform((0.1, 5.0, 0.2), (1.2, 12.0, 1.8))
    return round(float(sigma), 2), round(float(z_max), 1), alpha, round(float(lam), 2)


def _beyond(rng: Rng, n: int) -> Arguments:
    """Readings a little further than expected, and none at full range."""
    sigma, z_max, alpha, lam = _settings(rng)
    expected = np.round(rng.uniform(0.3, z_max - 1.5, n), 2)
    return reading(expected + np.round(rng.uniform(0.05, 1.4, n), 2), expected, sigma, z_max, alpha, lam)


def _before(rng: Rng, n: int) -> Arguments:
    """Readings nearer than expected."""
    sigma, z_max, alpha, lam = _settings(rng)
    expected = np.round(rng.uniform(2.0, z_max - APART, n), 2)
    return reading(np.round(rng.uniform(0.1, 0.95, n) * expected, 2), expected, sigma, z_max, alpha, lam)


def echoes(rng: Rng) -> Iterator[Arguments]:
    """Good echoes beyond what was expected: nothing unexpected explains them, nor the range."""
    yield reading([5.1], [5.0], 0.2, 10.0, USUAL, 0.5)
    yield reading([4.5], [3.0], 0.5, 8.0, OTHER, 0.5)
    yield reading([7.0], [1.0], 2.0, 12.0, USUAL, 1.5)
    yield reading([2.25, 6.5, 4.0], [2.0, 5.0, 3.5], 0.4, 9.0, OTHER, 0.8)
    yield reading([9.5], [4.0], 0.3, 12.0, CERTAIN, 0.5)
    for source in telling_then(rng):
        for n in (1, 2, 6):
            yield _beyond(source, n)


def obstacles(rng: Rng) -> Iterator[Arguments]:
    """Something unexpected on the way, then readings that are exactly the expected ones."""
    yield reading([2.0], [5.0], 0.2, 10.0, USUAL, 0.5)
    yield reading([1.0], [6.0], 0.5, 8.0, OTHER, 1.5)
    yield reading([4.5], [5.0], 1.0, 12.0, THIRD, 0.3)
    yield reading([5.0], [5.0], 0.2, 10.0, USUAL, 0.5)
    yield reading([3.5, 0.5, 2.0], [3.5, 4.0, 2.5], 0.6, 9.0, OTHER, 0.8)
    for source in telling_then(rng):
        for n in (1, 2, 6):
            yield _before(source, n)


def full_range(rng: Rng) -> Iterator[Arguments]:
    """Readings at the range where a wall was expected before."""
    yield reading([10.0], [5.0], 0.2, 10.0, USUAL, 0.5)
    yield reading([8.0], [7.5], 0.5, 8.0, THIRD, 0.4)
    yield reading([6.5, 6.5], [2.0, 6.0], 0.9, 6.5, OTHER, 1.2)
    for source in telling_then(rng):
        sigma, z_max, alpha, lam = _settings(source)
        expected = np.round(source.uniform(0.5, z_max - 0.1, 4), 2)
        yield reading(np.full(4, z_max), expected, sigma, z_max, alpha, lam)


def scans(rng: Rng) -> Iterator[Arguments]:
    """A full range that was expected, or that was expected and not read; then scans in which every cause has a part."""
    yield reading([10.0], [10.0], 0.2, 10.0, USUAL, 0.5)
    yield reading([9.5], [10.0], 0.2, 10.0, USUAL, 0.5)
    yield reading([2.0, 5.2, 10.0, 7.0], [5.0, 5.0, 5.0, 10.0], 0.2, 10.0, USUAL, 0.5)
    # A lidar that often meets something unexpected, near it.
    expected = np.linspace(1.0, 8.0, 36)
    yield reading(expected / 2.0, expected, 0.2, 12.0, (0.5, 0.4, 0.05, 0.05), 6.0)
    for source in telling_then(rng):
        for n in (7, 36):
            yield _scan(source, n, *_settings(source))


def long_scans(rng: Rng) -> Iterator[Arguments]:
    """Of `MANY` beams, from a place where the robot is not: the product of what they weigh underflows."""
    for source in telling_then(rng):
        for sigma, z_max, alpha, lam in ((0.2, 12.0, USUAL, 0.5), (0.35, 9.0, OTHER, 0.3)):
            yield _scan(source, MANY, sigma, z_max, np.array(alpha), lam, lost=True)


def _scan(rng: Rng, n: int, sigma: float, z_max: float, alpha: Floats, lam: float, *, lost: bool = False) -> Arguments:
    """What each cause gives, as often as its share says; where the robot is `lost`, about other walls."""
    expected = np.round(rng.uniform(0.3, z_max - APART, n), 2)
    expected[rng.random(n) < 0.15] = z_max
    seen = np.round(rng.uniform(0.3, z_max - APART, n), 2) if lost else expected
    cause = rng.choice(4, n, p=alpha / alpha.sum())
    hits = np.round(seen + rng.normal(0.0, sigma, n), 2)
    shorts = np.round(rng.exponential(1.0 / lam, n), 2)
    anything = np.round(rng.uniform(0.0, z_max, n), 2)
    z = np.choose(cause, [hits, np.minimum(shorts, seen), np.full(n, z_max), anything])
    z = np.where((z < 0.01) | (np.abs(z - expected) < APART), np.maximum(expected - 0.15, 0.05), z)
    z = np.where(z > z_max - APART, z_max, z)
    exact = rng.random(n) < 0.1
    return reading(np.where(exact, expected, z), expected, sigma, z_max, alpha, lam)


def plan(drawing: str) -> Grid:
    """A map (H, W) drawn with `#` for walls; True where free."""
    return np.array([[cell != "#" for cell in line] for line in drawing.split()])


#: A wall in a corner; walls far apart; a room with a pillar; a map almost all of walls; knights' moves.
CORNER = plan("#.... ..... .....")
FAR = plan("...#..... ......... ......... ......... ......... #........")
ROOM = plan("######## #......# #......# #...#..# #......# #......# ########")
SOLID = plan("##### ##.## #...# ##.## ##### #####")
OPEN = plan("........... ........... ....#...... ........... .........#. ........... ........... .#.........")
#: One wall, in a corner, from which the others are as far as no range reaches.
FAR = np.ones((20, 16), dtype=bool)
FAR[0, -1] = False
#: As wide as high, so that who exchanges rows and columns comes to an answer.
SQUARE = plan(".#... ..... ..... ..... ....#")
#: A breadth-first search by steps of 1 and of the diagonal goes wrong at two steps and one.
KNIGHT = plan("....... ....... ....... ......# ....... .......")


def small_maps(rng: Rng) -> Iterator[Arguments]:
    """One wall in a corner, then a few, with and without walls around; a single row, no free cell."""
    for libres in (CORNER, KNIGHT, FAR, ROOM, SOLID, plan("..#...#"), plan("### ###")):
        yield (libres,)


def any_maps(rng: Rng) -> Iterator[Arguments]:
    """Maps wide and tall, open on all sides, most of them with few walls, drawn at random; one beyond any range."""
    yield (OPEN,)
    yield (FAR,)
    yield (np.ascontiguousarray(OPEN.T[::-1]),)
    for source in telling_then(rng):
        for height, width, walls in ((6, 11, 3), (12, 5, 2), (9, 13, 5)):
            libres = np.ones((height, width), dtype=bool)
            libres.flat[source.choice(libres.size, walls, replace=False)] = False
            yield (libres,)
        yield (_open_map(source),)


def _open_map(rng: Rng) -> Grid:
    """A map of few walls, open on all sides: at least one, without which there is no distance."""
    while True:
        libres = np.ascontiguousarray(world.random_map(rng, 9, 12, fill=0.1)[1:-1, 1:-1])
        if not libres.all():
            return libres


def shrink_map(value: Grid) -> Iterator[Grid]:
    """Without all its walls but one, then without its last rows or columns."""
    walls = np.argwhere(~value)
    if len(walls) > 1:
        for y, x in walls[:3]:
            alone = np.ones_like(value)
            alone[y, x] = False
            yield alone
    height, width = value.shape
    for rows, columns in ((height // 2, width // 2), (height - 1, width), (height, width - 1)):
        if rows and columns:
            yield np.ascontiguousarray(value[:rows, :columns])


def has_a_wall(args: Arguments) -> bool:
    return not bool(args[0].all())
