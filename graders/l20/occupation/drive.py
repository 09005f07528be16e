"""The map of the module, drawn scan after scan along a path by the student's program, which is handed its own map."""

from __future__ import annotations

import numpy as np

from graders.core.code.bench import Bench
from graders.core.contract.local import initial_globals
from graders.core.contract.program import StudentFault
from graders.core.contract.values import Floats, read_array
from graders.l20 import world
from graders.l20.occupation.checks import FUNCTION, Failure, rejection
from graders.l20.occupation.judge import Integration, judge

RAYS = 36
#: Through the rooms by the corridor, turning: poses (x, y, theta), in cells and radians. No ray ends, at a face, on a
#: multiple of the steps of a walk: which side a rounding puts that point on would be the program's own luck.
PATH = np.array(
    [
        (3.4, 2.3, 0.1), (3.6, 4.6, 1.4), (3.5, 7.3, 0.6), (6.413, 8.237, 0.0), (10.6, 7.4, -0.9), (11.3, 4.2, -1.6),
        (13.7, 3.4, 0.3), (16.6, 2.6, 1.9), (19.4, 6.2, 2.8), (19.3, 8.4, -2.7), (18.2, 11.6, 2.2), (13.4, 8.7, 3.1),
        (11.6, 12.3, -1.3), (5.4, 11.7, -2.4),
    ]
)  # fmt: skip
SHAPE = initial_globals(world.STILL)["libres"].shape
#: What a film shows of a value out of all bounds.
SHOWN = 99.0


def scans() -> Floats:
    """What the lidar reads along the path, without noise, on the module's map: (n, RAYS)."""
    lidar = initial_globals(world.STILL)["lidar"]
    return np.array([lidar(pose, RAYS) for pose in PATH])


def drive(bench: Bench) -> None:
    """Hand the program its own map at each pose; the first step that is wrong is the one that is told."""
    readings, maps = scans(), [np.zeros(SHAPE)]
    failures: dict[int, Failure] = {}
    for k, (pose, scan) in enumerate(zip(PATH, readings, strict=True)):
        failure, grid = _step(bench, Integration(maps[-1], pose, scan, world.RANGE))
        if failure is not None:
            failures[k] = failure
        if grid is None:
            break
        maps.append(grid)
    first = min(failures, default=None)
    wrong = None if first is None else failures[first].wrong
    bench.record_film(
        {
            "kind": "map",
            "poses": PATH,
            "scans": np.round(readings, 12),
            "maps": [np.round(np.clip(grid, -SHOWN, SHOWN), 2) for grid in maps[1:]],
            "wrong": first,
            "cell": None if wrong is None or wrong.cell is None else list(wrong.cell),
        }
    )
    if first is not None:
        raise rejection(failures[first])


def _step(bench: Bench, case: Integration) -> tuple[Failure | None, Floats | None]:
    """What is wrong with the answer, if anything, and the map that it is, if it is one."""
    try:
        value = bench.call(FUNCTION, *case)
    except StudentFault as fault:
        bench.observe(FUNCTION, None, ok=False, fault=fault)
        return Failure(case, None, None, fault), None
    wrong = judge(case, value)
    bench.observe(FUNCTION, value, ok=wrong is None)
    failure = Failure(case, value, wrong, None) if wrong else None
    return failure, None if wrong is not None and wrong.cell is None else read_array(value)
