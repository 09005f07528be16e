"""Places to recognise: positions of a map whose scans the usual descriptors tell apart, whatever the distance."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from graders.core.contract.local import kit_source
from graders.core.contract.values import Floats
from graders.l20 import world
from graders.l20.boucles.family import DESCRIPTORS, DISTANCES, NUMBERS
from reference.world.raycast import cast_scans

BEAMS = 36
NOISE = 0.005
"""Standard deviation of a noisy ray, in cells: a change of heading and this noise together are still one place."""

CANDIDATES = 500
KEPT = 70
Rng = np.random.Generator
Signatures = dict[str, Floats]


@lru_cache(maxsize=1)
def module_map() -> world.Grid:
    """The map that the kit holds."""
    names: dict[str, object] = {"__name__": world.MODULE}
    exec(compile(kit_source(world.MODULE), f"<kit {world.MODULE}>", "exec"), names)
    return np.asarray(names["libres"], dtype=np.bool_)


def other_map(rng: Rng) -> world.Grid:
    """A map of another size, with rooms enough for its places to differ."""
    while True:
        free = world.random_map(rng, 14, 18, fill=0.12)
        if np.count_nonzero(free) > 120:
            return free


def noisy(rng: Rng, scans: Floats) -> Floats:
    """Scans as a lidar of standard deviation `NOISE` reads them."""
    return np.clip(scans + rng.normal(0.0, NOISE, scans.shape), 0.0, world.RANGE)


def signatures_of(scans: Floats) -> Signatures:
    """The signatures of scans (m, 36) by every descriptor of the family."""
    return {name: describe(scans) for name, describe in DESCRIPTORS.items()}


@dataclass(frozen=True)
class Pool:
    """Candidate places: `poses` (m, 3), their `scans` (m, 36), and how the family sees each of two noisy readings."""

    poses: Floats
    scans: Floats
    first: Signatures
    second: Signatures
    known: dict[tuple[int, float], NDArray[np.bool_]] = field(default_factory=dict, compare=False, repr=False)

    @classmethod
    def of(cls, rng: Rng, free: world.Grid) -> Pool:
        poses, scans = np.empty((0, 3)), np.empty((0, BEAMS))
        while len(poses) < KEPT:
            more = _positions(rng, free)
            read = cast_scans(free, more, BEAMS, world.RANGE)
            kept = _readable(read)
            poses, scans = np.vstack([poses, more[kept]]), np.vstack([scans, read[kept]])
        poses, scans = poses[:KEPT], scans[:KEPT]
        return cls(poses, scans, signatures_of(noisy(rng, scans)), signatures_of(noisy(rng, scans)))

    def distinct_from(self, place: int, margin: float) -> NDArray[np.bool_]:
        """Which places every descriptor and distance sees `margin` times farther from `place` than its own noise."""
        if (place, margin) not in self.known:
            self.known[place, margin] = self._distinct_from(place, margin)
        return self.known[place, margin]

    def unlike(self, place: int, margin: float) -> NDArray[np.bool_]:
        """Which places differ from `place` by each of the usual single numbers, `margin` times more than the noise."""
        return np.asarray(np.all(np.abs(self.numbers - self.numbers[place]) > margin * self.shaken, axis=1))

    @cached_property
    def numbers(self) -> Floats:
        """The usual single numbers of each place, (m, k)."""
        return np.stack([number(self.scans) for number in NUMBERS], axis=1)

    @cached_property
    def shaken(self) -> Floats:
        """How much two noisy readings of one place may differ by each number, (k,)."""
        again = np.random.default_rng(0).normal(0.0, NOISE, (2, *self.scans.shape)) + self.scans
        first, second = (np.stack([number(scans) for number in NUMBERS], axis=1) for scans in again)
        return np.asarray(np.quantile(np.abs(first - second), 0.9, axis=0))

    def _distinct_from(self, place: int, margin: float) -> NDArray[np.bool_]:
        clear = np.ones(len(self.poses), dtype=np.bool_)
        for name, first in self.first.items():
            for distance in DISTANCES.values():
                away = distance(first[place : place + 1], self.second[name])[0]
                clear &= away > margin * away[place]
        clear[place] = False
        return clear


#: Two poses of the module's map, the first one the statement's.
STILL = ((5.3, 3.2, 0.4), (11.3, 2.3, 1.1))


@lru_cache(maxsize=1)
def two_places() -> Floats:
    """What is read there, (2, 36), without noise."""
    return cast_scans(module_map(), np.array(STILL), BEAMS, world.RANGE)


@lru_cache(maxsize=8)
def module_pool(seed: int) -> Pool:
    """The candidate places of the module's map in the grading whose kit has this seed."""
    return Pool.of(np.random.default_rng([seed, BEAMS]), module_map())


def _positions(rng: Rng, free: world.Grid) -> Floats:
    """Poses to two decimals, away from centres and borders of cells; headings are no fraction of a turn."""
    cells = rng.choice(world.free_cells(free), CANDIDATES)[:, ::-1]
    inside = rng.uniform(0.1, 0.4, cells.shape) + 0.5 * rng.integers(0, 2, cells.shape)
    heading = rng.uniform(-3.1, 3.1, (CANDIDATES, 1))
    return np.asarray(np.round(np.hstack([cells + inside, heading]), 2))


def _readable(scans: Floats) -> NDArray[np.bool_]:
    """No ray at the end of the range, and one longest and one shortest ray that the noise cannot dethrone."""
    ranked = np.sort(scans, axis=1)
    within = ranked[:, -1] < world.RANGE - 0.2
    crowned = (ranked[:, -1] - ranked[:, -2] > 8 * NOISE) & (ranked[:, 1] - ranked[:, 0] > 4 * NOISE)
    return np.asarray(within & crowned)
