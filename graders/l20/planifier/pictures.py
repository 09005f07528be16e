"""The data of the figures of l20/planifier: permitted cells beside those that came back, a path beside a best one."""

from __future__ import annotations

from graders.core.contract.findings import FigureData
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value
from graders.l20.planifier.judge import FaultyPathError, read_path
from graders.l20.planifier.truth import best_path

CELLS, PATH = "cases", "chemin"
#: Cells of a path that are drawn, and how far off the map.
MOST, BEYOND = 400, 2


def cells_figure(args: Arguments, expected: Value, got: Floats | None) -> FigureData:
    """The map, the cells that are permitted, and those that came back."""
    grid, radius, resolution = args
    return {"kind": CELLS, "grid": grid, "radius": radius / resolution, "expected": expected, "got": got}


def path_figure(args: Arguments, value: Value) -> FigureData:
    permitted, costs, start, goal = args
    try:
        path = read_path(value)[:MOST]
    except (FaultyPathError, UnreadableError):
        path = []
    height, width = permitted.shape
    inside = [(i, j) for i, j in path if -BEYOND < i < height + BEYOND and -BEYOND < j < width + BEYOND]
    return {
        "kind": PATH, "permitted": permitted, "costs": costs, "start": start, "goal": goal,
        "expected": best_path(*args), "got": inside,
    }  # fmt: skip
