"""The grid maps and scenarios of the Moving AI laboratory, read from their texts.

Source: Sturtevant, "Benchmarks for Grid-Based Pathfinding" (2012). Their optima allow no diagonal move past the corner
of a wall, and take sqrt 2 for a diagonal.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.planning.grid_search import Cell, PlanningError

PASSABLE = ".GS"
HEADER = 4
FIELDS = 9


@dataclass(frozen=True)
class Scenario:
    """From `start` to `goal`, cells (y, x), in `optimum` cells at least."""

    start: Cell
    goal: Cell
    optimum: float


def parse_map(text: str) -> NDArray[np.bool_]:
    """The free cells (H, W) of a map of type octile. Raises PlanningError."""
    lines = text.split("\n")
    try:
        height, width = (int(line.split()[1]) for line in lines[1:3])
    except (ValueError, IndexError) as error:
        raise PlanningError("text", "does not start with the type, height and width of a map") from error
    rows = [line.rstrip("\r") for line in lines[HEADER : HEADER + height]]
    if len(rows) != height or any(len(row) != width for row in rows):
        raise PlanningError("text", f"does not hold {height} rows of {width} cells")
    return np.array([[letter in PASSABLE for letter in row] for row in rows], dtype=np.bool_).reshape(height, width)


def parse_scenarios(text: str) -> tuple[Scenario, ...]:
    """The scenarios of a file of version 1. Raises PlanningError."""
    scenarios = []
    for line in text.splitlines()[1:]:
        words = line.split()
        if not words:
            continue
        try:
            start_x, start_y, goal_x, goal_y = (int(word) for word in words[4:8])
            scenarios.append(Scenario((start_y, start_x), (goal_y, goal_x), float(words[FIELDS - 1])))
        except (ValueError, IndexError) as error:
            raise PlanningError("text", f"does not hold a scenario: {line!r}") from error
    return tuple(scenarios)
