"""Shortest ways over a grid with eight moves: A* and Dijkstra.

A straight move is 1 cell long, a diagonal one sqrt 2, and costs its length times 1 + the mean of the costs of its two
cells. Unless corners may be cut, a diagonal move needs both cells beside it free.

Sources: Hart, Nilsson, Raphael, "A Formal Basis for the Heuristic Determination of Minimum Cost Paths" (1968);
Sturtevant, "Benchmarks for Grid-Based Pathfinding" (2012), for the moves.
"""

from __future__ import annotations

from dataclasses import dataclass
from heapq import heappop, heappush
from math import inf, sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError

Floats = NDArray[np.float64]
Grid = NDArray[np.bool_]
Cell = tuple[int, int]

SQRT2 = sqrt(2.0)
MOVES = ((0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1))


class PlanningError(InvalidArgumentError):
    """Arguments between which no way can be looked for; `argument` names the one at fault."""


class UnreachableError(PlanningError):
    """There is no way from the start to the goal. `order`: the cells that were looked at, as in Route."""

    def __init__(self, argument: str, reason: str, order: NDArray[np.int64]) -> None:
        super().__init__(argument, reason)
        self.order = order


@dataclass(frozen=True, eq=False)
class Route:
    """The cells (k, 2) = (y, x) from start to goal, what they cost, and the cells (m, 2) that the search looked at."""

    cells: NDArray[np.int64]
    cost: float
    order: NDArray[np.int64]

    @property
    def expanded_count(self) -> int:
        """How many cells the search looked at."""
        return len(self.order)

    @property
    def length_in_cells(self) -> float:
        """In cells, whatever they cost."""
        return float(np.hypot(*np.diff(self.cells, axis=0).T).sum())

    @property
    def cell_centres(self) -> Floats:
        """The centres of the cells, (k, 2) = (x, y)."""
        return np.asarray(self.cells[:, ::-1] + 0.5, dtype=np.float64)


class SearchGrid:
    """A grid on which ways are looked for, as often as one likes: `free` (H, W), and `costs` (H, W), 0 or more."""

    def __init__(self, free: ArrayLike, costs: ArrayLike | None = None, *, corner_cutting: bool = False) -> None:
        grid = np.asarray(free, dtype=np.bool_)
        if grid.ndim != 2 or grid.size == 0:
            raise PlanningError("free", f"has shape {grid.shape}, not (H, W)")
        extra = np.zeros(grid.shape) if costs is None else np.asarray(costs, dtype=np.float64)
        if extra.shape != grid.shape or not np.all(np.isfinite(extra[grid])) or np.any(extra[grid] < 0.0):
            raise PlanningError("costs", "are not an array (H, W) of numbers from 0 on")
        self.shape = grid.shape
        self._free = grid
        self._width = grid.shape[1] + 2
        # One row and one column of wall all around: no move needs to look whether it leaves the grid.
        self._blocked = np.pad(~grid, 1, constant_values=True).ravel().tolist()
        self._half_costs = None if costs is None else np.pad(np.where(grid, extra, 0.0) / 2.0, 1).ravel().tolist()
        self._moves = [(dy * self._width + dx, SQRT2 if dx and dy else 1.0, dy * self._width, dx) for dy, dx in MOVES]
        self._sides = not corner_cutting

    def astar(self, start: Cell, goal: Cell, *, weight: float = 1.0) -> Route:
        """A cheapest way, by A* with the octile distance. Raises PlanningError, and UnreachableError.

        With a `weight` above 1 on that distance, fewer cells are looked at, and the way costs at most `weight` times
        the least (Pohl, "Heuristic Search Viewed as Path Finding in a Graph", 1970).
        """
        if not 1.0 <= weight < inf:
            raise PlanningError("weight", f"{weight} is not a number from 1 on")
        source, target, octile = (
            self._node_of_cell("start", start),
            self._node_of_cell("goal", goal),
            self._octile_distances(goal),
        )
        return self._find_route(source, target, octile if weight == 1.0 else [weight * ahead for ahead in octile])

    def dijkstra(self, start: Cell, goal: Cell) -> Route:
        """A cheapest way, by Dijkstra: the same cost, more cells looked at. Raises as `astar`."""
        return self._find_route(self._node_of_cell("start", start), self._node_of_cell("goal", goal), None)

    def costs_from(self, start: Cell) -> Floats:
        """What a cheapest way from `start` to each cell costs, (H, W); infinite where none leads. PlanningError."""
        costs, _, _ = self._run_search(self._node_of_cell("start", start), -1, None)
        return np.array(costs).reshape(-1, self._width)[1:-1, 1:-1]

    def _octile_distances(self, goal: Cell) -> list[float]:
        """For every cell of the padded grid, the length of a way to `goal` on a grid without walls: never too much."""
        dy = np.abs(np.arange(-1, self.shape[0] + 1) - goal[0])[:, None]
        dx = np.abs(np.arange(-1, self.shape[1] + 1) - goal[1])[None, :]
        octile: list[float] = (np.maximum(dx, dy) + (SQRT2 - 1.0) * np.minimum(dx, dy)).ravel().tolist()
        return octile

    def _find_route(self, source: int, target: int, heuristic: list[float] | None) -> Route:
        costs, parents, settled = self._run_search(source, target, heuristic)
        order = self._cells_of_nodes(settled)
        if costs[target] == inf:
            raise UnreachableError("goal", "no way leads there", order)
        nodes = [target]
        while nodes[-1] != source:
            nodes.append(parents[nodes[-1]])
        return Route(self._cells_of_nodes(nodes[::-1]), costs[target], order)

    def _cells_of_nodes(self, nodes: list[int]) -> NDArray[np.int64]:
        """The cells (k, 2) = (y, x) of nodes."""
        return np.stack(np.divmod(np.array(nodes, dtype=np.int64), self._width), axis=1) - 1

    def _run_search(
        self, source: int, target: int, heuristic: list[float] | None
    ) -> tuple[list[float], list[int], list[int]]:
        """The costs from `source` and the cells before, until `target` is settled; and the cells settled, in order."""
        blocked, half, sides, moves = self._blocked, self._half_costs, self._sides, self._moves
        costs, parents, settled = [inf] * len(blocked), [-1] * len(blocked), [False] * len(blocked)
        costs[source] = 0.0
        order: list[int] = []
        queue = [(0.0, 0.0, source)]
        while queue:
            _, _, node = heappop(queue)
            if settled[node]:
                continue
            settled[node] = True
            order.append(node)
            if node == target:
                break
            here = costs[node]
            for offset, length, side_y, side_x in moves:
                there = node + offset
                if blocked[there] or settled[there]:
                    continue
                if sides and length > 1.0 and (blocked[node + side_y] or blocked[node + side_x]):
                    continue
                cost = here + (length if half is None else length * (1.0 + half[node] + half[there]))
                if cost < costs[there]:
                    costs[there], parents[there] = cost, node
                    ahead = heuristic[there] if heuristic else 0.0
                    heappush(queue, (cost + ahead, ahead, there))
        return costs, parents, order

    def _node_of_cell(self, name: str, cell: Cell) -> int:
        y, x = cell
        if not (0 <= y < self.shape[0] and 0 <= x < self.shape[1] and self._free[y, x]):
            raise PlanningError(name, f"{cell} is not a free cell of the grid")
        return int((y + 1) * self._width + x + 1)
