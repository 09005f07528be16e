"""The walks that judge, drawn once whatever is re-enacted on them, each with spares.

Those of every grading never change. Those of one grading, which has its own seed, show nothing that a program could
have been told.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from graders.l20 import world
from graders.l20.boucles import family
from graders.l20.boucles.places import Pool, Rng, module_pool, other_map
from graders.l20.boucles.walks import Statistic, Walk, draw_trap, draw_walk, mistakes_fail, numbers_separate, separable

SPARE_POOLS = 8
#: Of what never changes.
STEADY = 0
HUNDREDTHS = 2

TRAPS: dict[str, Statistic] = {
    "la même moyenne": family.mean,
    "le même rayon le plus long": family.longest,
    "le même écart-type": family.std,
}


@lru_cache(maxsize=16)
def steady_walk(again: int, *, with_noise: bool) -> Walk:
    """A walk on the module's map, the same in every grading; `again` counts the spares.

    With noise, by a lidar that reads to the hundredth: how many distances are equal changes from one reading of a
    place to the next. A spare that this rounding spoils is left as it was drawn.
    """
    walk = _walk(STEADY, again, with_noise=with_noise, strict=True)
    read = walk.read_to(HUNDREDTHS)
    return read if with_noise and separable(read) and numbers_separate(read) and mistakes_fail(read) else walk


@lru_cache(maxsize=64)
def walk_at_home(seed: int, again: int, *, with_noise: bool) -> Walk:
    """A walk on the module's map, in the grading whose kit has this seed."""
    return _walk(seed, again, with_noise=with_noise, strict=False)


def _walk(seed: int, again: int, *, with_noise: bool, strict: bool) -> Walk:
    def draw(rng: Rng, pool: Pool) -> Walk:
        walk = draw_walk(rng, pool, with_noise=with_noise, strict=strict)
        if not strict and not all(len(np.unique(scan)) == len(scan) for scan in walk.scans):
            raise LookupError("distances come again by chance: what forgets how many is judged where they always do")
        return walk

    return _drawn(seed, 2 * again + with_noise, draw)


@lru_cache(maxsize=64)
def trap(kit_seed: int, seed: int, again: int) -> Walk:
    """A trap on the module's map, for one of the usual numbers."""
    name = list(TRAPS)[seed % len(TRAPS)]
    return _drawn(kit_seed, seed + again, lambda rng, pool: draw_trap(rng, pool, TRAPS[name], name))


def _drawn(kit_seed: int, seed: int, draw: Callable[[Rng, Pool], Walk]) -> Walk:
    """Draw among the grading's places or, where these do not allow it, among others of the same map."""
    rng = np.random.default_rng([seed, kit_seed])
    for spare in range(SPARE_POOLS):
        try:
            return draw(rng, module_pool(kit_seed + spare))
        except LookupError:
            continue
    raise LookupError("the module's map has no places distinct enough")


def map_elsewhere() -> world.Grid:
    """The other map, always the same one."""
    return _elsewhere()[0]


@lru_cache(maxsize=16)
def walk_elsewhere(again: int) -> Walk:
    """A walk on this other map, the same in every grading; `again` counts the spares."""
    _, pool, walk = _elsewhere()
    if again == 0:
        return walk
    return draw_walk(np.random.default_rng([STEADY, again]), pool, with_noise=False, strict=True)


@lru_cache(maxsize=1)
def _elsewhere() -> tuple[world.Grid, Pool, Walk]:
    """A map whose places are too much alike is drawn again."""
    rng = np.random.default_rng(STEADY)
    for _ in range(SPARE_POOLS):
        free = other_map(rng)
        pool = Pool.of(rng, free)
        try:
            return free, pool, draw_walk(rng, pool, with_noise=False, strict=True)
        except LookupError:
            continue
    raise LookupError("no map with places distinct enough was drawn")
