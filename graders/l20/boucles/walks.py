"""Sequences of scans in which some places are seen again, with another heading.

A walk is drawn until every descriptor of the family, with every distance, separates by one threshold the scans to be
found from the others, `MARGIN` times farther: what an honest student may have chosen has then its threshold too.
The strict ones, those that never change, also until no threshold serves the usual wrong distances, and until the usual
single numbers have theirs. Scans to find stand where a search that stops or starts at the wrong index shows.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from graders.core.contract.values import Floats
from graders.l20.boucles.family import DISTANCES, MISTAKEN, NUMBERS
from graders.l20.boucles.places import BEAMS, NOISE, Pool, Rng, noisy, signatures_of

GAP = 10
MARGIN = 2.0
PREFILTER = 3.0
MAX_DRAWS = 400
READINGS = 40
NEARER = 3.0
Statistic = Callable[[Floats], Floats]

#: Where the first place comes again, then where the second is: in any order, but never one just after the other.
FAR_APART = [(k, m, n) for k in range(2, 8) for m in range(2, 8) for n in range(m + 2, 8) if k not in (m, n)]
#: Where a trap has the place that is like the one to recognise.
TRAPPED = 0


@dataclass(frozen=True)
class Walk:
    """`scans` (m, 36) seen from `poses` (m, 3) at `places` (m,), labels; `queries` are the scans to look back from.

    `alike` holds, by scan of another place, what this place and that of the query have in common. Distances are read to
    so many `digits` after the point, where there are any.
    """

    poses: Floats
    scans: Floats
    places: NDArray[np.int64]
    queries: tuple[int, ...]
    noise: float
    alike: Mapping[int, str] = field(default_factory=dict)
    digits: int | None = None

    def same_place(self, i: int) -> list[int]:
        """The scans of the past, `GAP` or more before i, that were taken where scan i was."""
        return [j for j in range(i - GAP + 1) if self.places[j] == self.places[i]]

    def read_to(self, digits: int) -> Walk:
        """The walk of a lidar that gives so many digits, in whose scans distances come again."""
        return replace(self, scans=np.round(self.scans, digits), digits=digits)

    def call(self, j: int) -> str:
        """What a student types to see scan j."""
        call = lidar_call(self.poses[j], self.noise)
        return call if self.digits is None else f"np.round({call}, {self.digits})"

    def turned_over(self) -> Walk:
        """The same visits, those that every query looks back on come one later, the last of them first.

        None comes to i - 10, and none stays in its place.
        """
        past = min(self.queries) - GAP
        order = np.concatenate([np.roll(np.arange(past), 1), np.arange(past, len(self.scans))])
        alike = {int(np.flatnonzero(order == j)[0]): shared for j, shared in self.alike.items()}
        return replace(self, poses=self.poses[order], scans=self.scans[order], places=self.places[order], alike=alike)


def turned(pose: Floats, steps: int) -> Floats:
    """The same position with the heading increased by `steps` beams, brought back to [-pi, pi]."""
    theta = math.remainder(float(pose[2]) + steps * math.tau / BEAMS, math.tau)
    return np.array([pose[0], pose[1], theta])


def lidar_call(pose: Floats, noise: float = 0.0) -> str:
    """What a student types to see this scan."""
    x, y, theta = (round(float(value), 6) for value in pose)
    return f"lidar(({x}, {y}, {theta})" + (f", bruit={noise})" if noise else ")")


def seen(rng: Rng, pool: Pool, places: NDArray[np.int64], queries: tuple[int, ...], *, noise: float) -> Walk:
    """A walk through places of the pool: each visit has its own heading and, with noise, its own reading."""
    steps = _headings(rng, places)
    scans = np.stack([np.roll(pool.scans[p], -k) for p, k in zip(places, steps, strict=True)])
    poses = np.stack([turned(pool.poses[p], int(k)) for p, k in zip(places, steps, strict=True)])
    return Walk(poses, noisy(rng, scans) if noise else scans, places, queries, noise)


def _headings(rng: Rng, places: NDArray[np.int64]) -> NDArray[np.int64]:
    """Beams to turn by at each visit: a sixth of a turn or so between those of one place, never twice the same."""
    steps = np.zeros(len(places), dtype=np.int64)
    for place in np.unique(places):
        visits = np.flatnonzero(places == place)
        apart = 5 if len(visits) <= 7 else 1
        steps[visits] = apart * rng.permutation(BEAMS // apart)[: len(visits)]
    return steps


Mask = NDArray[np.bool_]


def _sought(walk: Walk) -> tuple[Floats, Floats, Mask, Mask]:
    """The scans of the queries (q, 36), those of the past (p, 36), and which (q, p) are to be found, which are not."""
    past = max(walk.queries) - GAP + 1
    rows = list(walk.queries)
    asked = np.arange(past) <= np.array(rows)[:, None] - GAP
    same = (walk.places[:past] == walk.places[rows][:, None]) & asked
    return walk.scans[rows], walk.scans[:past], same, asked & ~same


def separable(walk: Walk, margin: float = MARGIN) -> bool:
    """Does every descriptor, with every distance, have one threshold for all the queries of the walk?"""
    queries, past, same, others = _sought(walk)
    for signatures in signatures_of(np.concatenate([queries, past])).values():
        for distance in DISTANCES.values():
            away = distance(signatures[: len(queries)], signatures[len(queries) :])
            if not np.min(away[others]) > margin * np.max(away[same], initial=0.0) + 1e-6:
                return False
    return True


def numbers_separate(walk: Walk, margin: float = MARGIN) -> bool:
    """Has each of the usual single numbers one threshold too? Where it has, only the traps catch it."""
    queries, past, same, others = _sought(walk)
    for number in NUMBERS:
        away = np.abs(number(queries)[:, None] - number(past))
        if not np.min(away[others]) > margin * np.max(away[same], initial=0.0) + 1e-6:
            return False
    return True


def mistakes_fail(walk: Walk) -> bool:
    """Is there, for none of the usual wrong distances, a threshold above zero that serves all the queries?"""
    queries, past, same, others = _sought(walk)
    for mistaken in MISTAKEN:
        away = mistaken(queries, past)
        if np.min(away[others]) >= max(0.0, float(np.max(away[same]))):
            return False
    return True


def draw_walk(rng: Rng, pool: Pool, *, with_noise: bool, strict: bool) -> Walk:
    """Twenty-two scans; from two of them the same places were seen twice before, among six other places.

    Noiseless walks are chosen with the same noise as the others, so that their places are as distinct.
    """
    for _ in range(MAX_DRAWS):
        chosen = _distinct_places(rng, pool, strict=strict)
        if chosen is None:
            continue
        places, queries = _itinerary(rng, chosen)
        trial = seen(rng, pool, places, queries, noise=NOISE)
        if strict and not (numbers_separate(trial) and mistakes_fail(trial)):
            continue
        if not separable(trial):
            continue
        walk = trial if with_noise else seen(rng, pool, places, queries, noise=0.0)
        if with_noise or not strict or mistakes_fail(walk):
            return walk
    raise LookupError("no walk with distinct places was found on this map")


def _distinct_places(rng: Rng, pool: Pool, *, strict: bool) -> NDArray[np.int64] | None:
    """Two places to recognise and six others, all distinct from both; if strict, by each single number too."""

    def distinct(place: int) -> Mask:
        clear = pool.distinct_from(place, PREFILTER)
        return clear & pool.unlike(place, PREFILTER) if strict else clear

    first = int(rng.integers(len(pool.poses)))
    clear = distinct(first)
    if not np.any(clear):
        return None
    second = int(rng.choice(np.flatnonzero(clear)))
    others = np.flatnonzero(clear & distinct(second))
    return np.array([first, second, *rng.choice(others, 6, replace=False)]) if len(others) >= 6 else None


def _itinerary(rng: Rng, chosen: NDArray[np.int64]) -> tuple[NDArray[np.int64], tuple[int, ...]]:
    """Past: each place to recognise twice, the six others once; then ten or more others; then queries.

    The first scan is to be found; no other is in the next place or in the last two, nor are two of one place together.
    """
    a, b, *others = chosen
    again, *of_b = FAR_APART[int(rng.integers(len(FAR_APART)))]
    past = np.empty(10, dtype=np.int64)
    past[[0, again]], past[of_b] = a, b
    past[[k for k in range(1, 10) if k not in (again, *of_b)]] = rng.permutation(others)
    recent = rng.choice(others, 10)
    return np.array([*past, *recent, a, b]), (20, 21)


def draw_trap(
    rng: Rng,
    pool: Pool,
    statistic: Statistic,
    shared: str,
    *,
    readings: int = READINGS,
    pairs: int = MAX_DRAWS,
) -> Walk:
    """Fourteen scans; the second one is of the place of the last, the first one has the same `statistic` elsewhere.

    By this number alone, and whatever the distance, the other place is nearer than the same place. `shared` tells it.
    """
    for here, there in _lookalikes(pool, statistic)[:pairs]:
        if not pool.distinct_from(here, PREFILTER)[there]:
            continue
        for _ in range(3):
            walk = _trap(rng, pool, (here, there), statistic, readings)
            if walk is not None and separable(walk):
                return replace(walk, alike={TRAPPED: shared})
    raise LookupError("no two places share this statistic on this map")


def _lookalikes(pool: Pool, statistic: Statistic) -> list[tuple[int, int]]:
    """Pairs of places, those whose statistic differs least first."""
    values = statistic(pool.scans)
    if np.ptp(values) == 0.0:
        return []
    first, second = np.triu_indices(len(values), 1)
    nearest = np.argsort(np.abs(values[first] - values[second]))[:MAX_DRAWS]
    return [(int(first[k]), int(second[k])) for k in nearest]


def _trap(rng: Rng, pool: Pool, pair: tuple[int, int], statistic: Statistic, readings: int) -> Walk | None:
    here, there = pair
    others = np.flatnonzero(pool.distinct_from(here, PREFILTER))
    others = others[others != there]
    if not len(others):
        return None
    places = np.array([there, here, *rng.choice(others, 11), here])
    walk = seen(rng, pool, places, (len(places) - 1,), noise=NOISE)
    rows = (1, TRAPPED, len(places) - 1)
    return _confused(rng, [_clean(pool, walk, k) for k in rows], walk, rows, statistic, readings)


def _confused(
    rng: Rng, clean: Sequence[Floats], walk: Walk, rows: Sequence[int], statistic: Statistic, readings: int
) -> Walk | None:
    """Choose, among noisy readings, three by which the statistic brings the other place nearer than the same place."""
    of_same, of_other, of_query = (noisy(rng, np.repeat(scan[None], readings, axis=0)) for scan in clean)
    asked = statistic(of_query)
    far = np.abs(statistic(of_same)[:, None] - asked)
    near = np.abs(statistic(of_other)[:, None] - asked)
    enough = far > NEARER * near.min(axis=0)
    usable = np.flatnonzero(enough.any(axis=0) & (far.max(axis=0) > 0.0))
    if not len(usable):
        return None
    q = int(usable[0])
    scans = walk.scans.copy()
    scans[rows[0]] = of_same[np.argmin(np.where(enough[:, q], far[:, q], np.inf))]
    scans[rows[1]] = of_other[np.argmin(near[:, q])]
    scans[rows[2]] = of_query[q]
    return replace(walk, scans=scans)


def _clean(pool: Pool, walk: Walk, row: int) -> Floats:
    """The noiseless scan of one visit."""
    place = int(walk.places[row])
    steps = round((float(walk.poses[row, 2]) - float(pool.poses[place, 2])) * BEAMS / math.tau)
    return np.roll(pool.scans[place], -steps)
