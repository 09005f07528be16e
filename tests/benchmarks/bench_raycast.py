"""Exact ray casting, 500 poses by 30 beams: ours beside a naive one, the walk on arrays, sphere tracing and numba.

    PYTHONPATH=. python tests/benchmarks/bench_raycast.py [rounds]

All run in one process, in turn. Naive Python and sphere tracing are of our own writing, after what tutorials do; numba
(the extra `benchmarks`) compiles the naive one, and is left out where it is missing. Every answer is compared with the
naive one's.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from reference.world.distance_map import distances_to_cells
from reference.world.grid_map import GridMap
from reference.world.ray_caster import RayCaster
from reference.world.raycast import cast_rays
from reference.world.scan import full_turn_angles
from reference.world.scenes import random_building, random_clutter
from tests.benchmarks.measure import Contender, Goal, Row, figure, interleave, median, table

POSES, BEAMS = 500, 30
FASTER, EXACT = Goal(12.0, at_least=True), 1e-9


def walk(blocked: object, x: float, y: float, angle: float, max_range: float) -> float:
    """One ray, from cell to cell; `blocked[row + 1][column + 1]` says where walls are."""
    column, row = math.floor(x), math.floor(y)
    if blocked[row + 1][column + 1]:  # type: ignore[index]
        return 0.0
    dx, dy = math.cos(angle), math.sin(angle)
    step_x, step_y = (1 if dx > 0 else -1), (1 if dy > 0 else -1)
    leap_x, leap_y = (abs(1.0 / dx) if dx else math.inf), (abs(1.0 / dy) if dy else math.inf)
    next_x = (column + (dx > 0) - x) / dx if dx else math.inf
    next_y = (row + (dy > 0) - y) / dy if dy else math.inf
    while True:
        if next_x < next_y:
            distance, column, next_x = next_x, column + step_x, next_x + leap_x
        else:
            distance, row, next_y = next_y, row + step_y, next_y + leap_y
        if distance >= max_range:
            return max_range
        if blocked[row + 1][column + 1]:  # type: ignore[index]
            return distance


def naive(blocked: list[list[bool]], origins: np.ndarray, angles: np.ndarray, max_range: float) -> np.ndarray:
    rays = zip(origins.tolist(), angles.tolist(), strict=True)
    return np.array([walk(blocked, x, y, angle, max_range) for (x, y), angle in rays])


def sphere_tracing(
    free: np.ndarray, clearance: np.ndarray, origins: np.ndarray, angles: np.ndarray, max_range: float
) -> np.ndarray:
    """Steps of the length that the distance map grants; the walk from cell to cell finishes near walls."""
    direction = np.column_stack([np.cos(angles), np.sin(angles)])
    run = np.zeros(len(angles))
    flying = np.arange(len(angles))
    while flying.size:
        cells = np.floor(origins[flying] + run[flying, None] * direction[flying]).astype(np.int64)
        steps = clearance[cells[:, 1], cells[:, 0]]
        flying, steps = flying[steps > 0.0], steps[steps > 0.0]
        run[flying] += steps
        flying = flying[run[flying] < max_range]
    rest = cast_rays(free, origins + run[:, None] * direction, angles, 2.0 * max_range)
    return np.minimum(run + rest, max_range)


def compiled() -> Callable[..., np.ndarray] | None:
    """The naive walk, compiled; None without numba."""
    try:
        import numba
    except ImportError:
        return None
    one = numba.njit(walk)

    @numba.njit
    def many(blocked: np.ndarray, origins: np.ndarray, angles: np.ndarray, max_range: float) -> np.ndarray:
        found = np.empty(len(angles))
        for k in range(len(angles)):
            found[k] = one(blocked, origins[k, 0], origins[k, 1], angles[k], max_range)
        return found

    return many


def timed(found: dict[str, np.ndarray], name: str, cast: Callable[[], np.ndarray]) -> float:
    """Seconds of the processor: others on the machine disturb them less."""
    start = time.process_time()
    found[name] = cast()
    return time.process_time() - start


@dataclass(frozen=True)
class Compared:
    """One place: ours first; milliseconds of the processor in `own`, and how far each one's farthest answer is from
    the naive one's."""

    title: str
    contenders: list[Contender]
    errors: dict[str, float]
    rays: int

    def ratio(self, contender: Contender) -> float:
        """Their time by ours: the median of the ratios within each round."""
        pairs = zip(contender.own, self.contenders[0].own, strict=True)
        return median([theirs / own for theirs, own in pairs])


def compare(title: str, place: GridMap, rounds: int, numba_cast: Callable[..., np.ndarray] | None) -> Compared:
    free, rng = place.free, np.random.default_rng(1)
    cells = np.argwhere(free)[rng.integers(0, np.count_nonzero(free), POSES)]
    poses = np.column_stack([cells[:, ::-1] + rng.random((POSES, 2)), rng.uniform(-math.pi, math.pi, POSES)])
    origins = np.repeat(poses[:, :2], BEAMS, axis=0)
    angles = (poses[:, 2:] + 2.0 * np.pi * np.arange(BEAMS) / BEAMS).ravel()
    reach = float(sum(free.shape))
    blocked = np.pad(~free, 1, constant_values=True)
    start = time.perf_counter()
    caster = RayCaster.from_free_cells(free)
    prepared = 1000.0 * (time.perf_counter() - start)
    casts: dict[str, Callable[[], np.ndarray]] = {
        "ours, leaps": lambda: caster.cast(origins, angles, reach),
        "ours, leaps, as scans": lambda: caster.cast_scans(poses, full_turn_angles(BEAMS), reach).ravel(),
        "naive Python": partial(naive, blocked.tolist(), origins, angles, reach),
        "ours, walk on arrays": lambda: cast_rays(free, origins, angles, reach),
        "sphere tracing, numpy": partial(sphere_tracing, free, grown_clearance(blocked), origins, angles, reach),
    }
    if numba_cast is not None:
        casts["naive, numba"] = partial(numba_cast, blocked, origins, angles, reach)
    found: dict[str, np.ndarray] = {}
    contenders = [Contender(name, partial(timed, found, name, cast)) for name, cast in casts.items()]
    interleave(contenders, rounds)
    errors = {name: float(np.abs(one - found["naive Python"]).max()) for name, one in found.items()}
    size = f"{free.shape[0]} x {free.shape[1]} cells, mean range {found['naive Python'].mean():.0f} cells"
    return Compared(f"{title}: {size}, map prepared in {prepared:.0f} ms (once)", contenders, errors, len(angles))


def report(found: Compared) -> None:
    rows = []
    for one in found.contenders:
        quartiles = np.percentile(one.own, [25, 75])
        spread = f"{figure(float(quartiles[0]))} – {figure(float(quartiles[1]))}"
        error = f"{found.errors[one.name]:.0e}"
        rows.append((one.name, figure(median(one.own)), spread, figure(found.ratio(one)), error))
    each = 1e6 * median(found.contenders[0].own) / found.rays
    print(f"\n{found.title}, {found.rays} rays, {each:.0f} ns a ray\n")
    print(table(("", "median, ms", "quartiles, ms", "time / ours", "error, cells"), rows))


def places(side: int) -> dict[str, GridMap]:
    rng, rooms = np.random.default_rng(7), side // 40
    return {
        "Cluttered hall": random_clutter(rng, (side, side), side * side // 400),
        "Building of rooms": random_building(rng, (rooms, rooms), side // rooms - 1, 6),
        "Empty hall": random_clutter(rng, (side, side), 0),
    }


def rows(rounds: int, side: int = 200) -> list[Row]:
    made, numba_cast = [], compiled()
    why = "" if numba_cast else "numba is not installed"
    for name, place in places(side).items():
        found = compare(name, place, rounds, numba_cast)
        told = ", ".join(f"{one.name} {figure(median(one.own))} ms" for one in found.contenders)
        naive_one = next(one for one in found.contenders if one.name == "naive Python")
        subject = f"casting, {side} × {side}, {name.lower()}: naive ÷ ours"
        if found.errors[found.contenders[0].name] > EXACT:
            raise ArithmeticError(f"{subject}: {found.errors}")
        made.append(Row(subject, "×", found.ratio(naive_one), peers=told, goal=FASTER, why=why))
    return made


def grown_clearance(blocked: np.ndarray) -> np.ndarray:
    """How far one can go from any point of each cell (H, W) without meeting a wall: from side to side of cells."""
    grown = blocked.copy()
    for axis in (0, 1):
        grown |= np.roll(grown, 1, axis) | np.roll(grown, -1, axis)
    return distances_to_cells(grown)[1:-1, 1:-1]


def main() -> None:
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 15
    numba_cast = compiled()
    for side in (200, 1000):
        for name, place in places(side).items():
            report(compare(name, place, max(rounds // 3, 3) if name == "Empty hall" else rounds, numba_cast))


if __name__ == "__main__":
    main()
