"""The grid maps and scenarios of the Moving AI laboratory, read from their texts.

Source: Sturtevant, "Benchmarks for Grid-Based Pathfinding" (2012). Their optima allow no diagonal move past the corner
of a wall, and take sqrt 2 for a diagonal.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.planning.grid_search import Cell, PlanningError
from reference.text import decode_lines

PASSABLE = ".GS"
HEADER = 4
FIELDS = 9


@dataclass(frozen=True)
class Scenario:
    """From `start` to `goal`, cells (y, x), in `optimum` cells at least."""

    start: Cell
    goal: Cell
    optimum: float


def parse_map(text: str | bytes) -> NDArray[np.bool_]:
    """The free cells (H, W) of a map of type octile. Raises PlanningError."""
    lines = decode_lines(text, error=PlanningError)
    header = [line.split() for line in lines[:HEADER]]
    try:
        (kind, _), (first, height), (second, width), (last,) = header
        sides = int(height), int(width)
    except ValueError:
        kind, first, second, last, sides = "", "", "", "", (0, 0)
    if (kind, first, second, last) != ("type", "height", "width", "map"):
        raise PlanningError("text", "does not start with the type, height and width of a map, and the line map")
    rows = lines[HEADER:]
    while len(rows) > sides[0] and not rows[-1].strip():
        rows.pop()
    if len(rows) != sides[0] or any(len(row) != sides[1] for row in rows):
        raise PlanningError("text", f"does not hold {sides[0]} rows of {sides[1]} cells")
    return np.array([[letter in PASSABLE for letter in row] for row in rows], dtype=np.bool_).reshape(sides)


def parse_scenarios(text: str | bytes) -> tuple[Scenario, ...]:
    """The scenarios of a file of version 1. Raises PlanningError."""
    scenarios = []
    for number, line in enumerate(decode_lines(text, error=PlanningError)[1:], start=2):
        words = line.split()
        if not words:
            continue
        try:
            start_x, start_y, goal_x, goal_y = (int(word) for word in words[4:8])
            scenarios.append(Scenario((start_y, start_x), (goal_y, goal_x), float(words[FIELDS - 1])))
        except (ValueError, IndexError) as error:
            raise PlanningError("text", f"line {number} does not hold a scenario: {line!r}") from error
    return tuple(scenarios)
