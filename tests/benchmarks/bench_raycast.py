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
from functools import partial

import numpy as np
from measure import Contender, figure, interleave, median, table

from reference.world.distance_map import distance_to
from reference.world.grid_map import GridMap
from reference.world.ray_caster import RayCaster
from reference.world.raycast import cast_rays
from reference.world.scenes import building, clutter

POSES, BEAMS = 500, 30


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
    found[name] = cast()
    return 0.0


def compare(title: str, place: GridMap, rounds: int, numba_cast: Callable[..., np.ndarray] | None) -> None:
    free, rng = place.free, np.random.default_rng(1)
    cells = np.argwhere(free)[rng.integers(0, np.count_nonzero(free), POSES)]
    poses = np.column_stack([cells[:, ::-1] + rng.random((POSES, 2)), rng.uniform(-math.pi, math.pi, POSES)])
    origins = np.repeat(poses[:, :2], BEAMS, axis=0)
    angles = (poses[:, 2:] + 2.0 * np.pi * np.arange(BEAMS) / BEAMS).ravel()
    reach = float(sum(free.shape))
    blocked = np.pad(~free, 1, constant_values=True)
    start = time.perf_counter()
    caster = RayCaster.of(free)
    prepared = 1000.0 * (time.perf_counter() - start)
    casts: dict[str, Callable[[], np.ndarray]] = {
        "ours, leaps": lambda: caster.cast(origins, angles, reach),
        "naive Python": partial(naive, blocked.tolist(), origins, angles, reach),
        "ours, walk on arrays": lambda: cast_rays(free, origins, angles, reach),
        "sphere tracing, numpy": partial(sphere_tracing, free, grown_clearance(blocked), origins, angles, reach),
    }
    if numba_cast is not None:
        casts["naive, numba"] = partial(numba_cast, blocked, origins, angles, reach)
    found: dict[str, np.ndarray] = {}
    contenders = [Contender(name, partial(timed, found, name, cast)) for name, cast in casts.items()]
    interleave(contenders, rounds)
    ours = median(contenders[0].total)
    rows = []
    for one in contenders:
        error = float(np.abs(found[one.name] - found["naive Python"]).max())
        quartiles = np.percentile(one.total, [25, 75])
        ratio = median([theirs / own for theirs, own in zip(one.total, contenders[0].total, strict=True)])
        spread = f"{figure(float(quartiles[0]))} – {figure(float(quartiles[1]))}"
        rows.append((one.name, figure(median(one.total)), spread, figure(ratio), f"{error:.0e}"))
    print(f"\n{title}: {free.shape[0]} x {free.shape[1]} cells, mean range {found['naive Python'].mean():.0f} cells,")
    print(f"{len(angles)} rays, map prepared in {prepared:.0f} ms (once), {1e6 * ours / len(angles):.0f} ns a ray\n")
    print(table(("", "median, ms", "quartiles, ms", "time / ours", "error, cells"), rows))


def grown_clearance(blocked: np.ndarray) -> np.ndarray:
    """How far one can go from any point of each cell (H, W) without meeting a wall: from side to side of cells."""
    grown = blocked.copy()
    for axis in (0, 1):
        grown |= np.roll(grown, 1, axis) | np.roll(grown, -1, axis)
    return distance_to(grown)[1:-1, 1:-1]


def main() -> None:
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 15
    numba_cast = compiled()
    for side in (200, 1000):
        rng = np.random.default_rng(7)
        rooms = side // 40
        compare("Cluttered hall", clutter(rng, (side, side), side * side // 400), rounds, numba_cast)
        compare("Building of rooms", building(rng, (rooms, rooms), side // rooms - 1, 6), rounds, numba_cast)
        compare("Empty hall", clutter(rng, (side, side), 0), max(rounds // 3, 3), numba_cast)


if __name__ == "__main__":
    main()
