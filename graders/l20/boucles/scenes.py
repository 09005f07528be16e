"""The walks of one grading, drawn once whatever is re-enacted on them, each with spares."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from graders.l20 import world
from graders.l20.boucles import family
from graders.l20.boucles.places import Pool, Rng, module_pool, other_map
from graders.l20.boucles.walks import ORDERS, Statistic, Walk, draw_trap, draw_walk

SPARE_POOLS = 8

TRAPS: dict[str, Statistic] = {
    "la même moyenne": family.mean,
    "le même rayon le plus long": family.longest,
    "le même écart-type": family.std,
}


@lru_cache(maxsize=64)
def walk_at_home(seed: int, again: int, *, with_noise: bool) -> Walk:
    """A walk on the module's map, in the grading whose kit has this seed; `again` counts the spares."""
    return _drawn(seed, 2 * again + with_noise, lambda rng, pool: draw_walk(rng, pool, with_noise=with_noise))


@lru_cache(maxsize=64)
def trap(kit_seed: int, seed: int, name: str, again: int) -> Walk:
    """A trap on the module's map for the statistic of this name."""
    order = ORDERS[list(TRAPS).index(name)]
    return _drawn(kit_seed, seed + again, lambda rng, pool: draw_trap(rng, pool, TRAPS[name], order))


def _drawn(kit_seed: int, seed: int, draw: Callable[[Rng, Pool], Walk]) -> Walk:
    """Draw among the grading's places or, where these do not allow it, among others of the same map."""
    rng = np.random.default_rng([seed, kit_seed])
    for spare in range(SPARE_POOLS):
        try:
            return draw(rng, module_pool(kit_seed + spare))
        except LookupError:
            continue
    raise LookupError("the module's map has no places distinct enough")


def map_elsewhere(seed: int) -> world.Grid:
    """Another map."""
    return _elsewhere(seed)[0]


@lru_cache(maxsize=32)
def walk_elsewhere(seed: int, again: int) -> Walk:
    """A walk on this other map; `again` counts the spares."""
    _, pool, walk = _elsewhere(seed)
    return walk if again == 0 else draw_walk(np.random.default_rng([seed, again]), pool, with_noise=False)


@lru_cache(maxsize=8)
def _elsewhere(seed: int) -> tuple[world.Grid, Pool, Walk]:
    """A map whose places are too much alike is drawn again."""
    rng = np.random.default_rng(seed)
    for _ in range(SPARE_POOLS):
        free = other_map(rng)
        pool = Pool.of(rng, free)
        try:
            return free, pool, draw_walk(rng, pool, with_noise=False)
        except LookupError:
            continue
    raise LookupError("no map with places distinct enough was drawn")
