"""The best place of one cloud on another in a whole window of poses, without a guess: exact, by branch and bound.

The score of a pose is the mean over the points of P of a field that is 1 on the points of Q and falls off around them.
On a lattice of poses the best one is found without trying them all: the largest field within a square of 2^h cells
bounds every shift within it from above, and a square whose bound is below a score already reached is dropped.

Sources: Olson, "Real-Time Correlative Scan Matching" (2009); Hess, Kohler, Rapp, Andor, "Real-Time Loop Closure in 2D
LIDAR SLAM" (2016), for the branch and bound.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.registration.icp import IcpError
from reference.registration.normals import check_plane_cloud
from reference.se2 import Pose, wrap_angle

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

BRANCHES = np.array([(0, 0), (0, 1), (1, 0), (1, 1)])
COST = 0.02
RADIUS = 3
_AROUND = range(-RADIUS, RADIUS + 1)
# Squared distance, and shift in y and x, of the cells around one; the farthest first, the nearest having the last word.
OFFSETS = sorted(((y * y + x * x, y, x) for y in _AROUND for x in _AROUND if y * y + x * x <= RADIUS**2), reverse=True)


@dataclass(frozen=True)
class SearchWindow:
    """Where to look: up to `reach` (m) along x and y and `turn` (rad) either way, by cells of `resolution` (m).

    A pose that is one standard deviation away from the guess, `sigma` (m) along an axis or `turn_sigma` (rad), must
    have a score `COST` higher to be preferred, and k^2 times that for k deviations. Otherwise a scan that shows new
    walls would be drawn back to where the old ones explain most of it. Without these, all poses are alike.
    """

    reach: float = 1.0
    turn: float = np.pi
    resolution: float = 0.1
    sigma: float = np.inf
    turn_sigma: float = np.inf

    def __post_init__(self) -> None:
        for name in ("reach", "turn", "resolution"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise IcpError(name, f"{getattr(self, name)} is not a positive number")
        for name in ("sigma", "turn_sigma"):
            if not getattr(self, name) > 0.0:
                raise IcpError(name, f"{getattr(self, name)} is not a standard deviation")


@dataclass(frozen=True, eq=False)
class CorrelationMatch:
    """The best pose of the lattice, its score, 1 at most, and how many scores and bounds were computed."""

    T_q_p: Pose
    score: float
    evaluations: int


@dataclass(frozen=True, eq=False)
class ScoreLattice:
    """The scores of shifts: `places` (turns, n) of the points of P in a field laid out row by row, `width` cells a row.

    `bounds`: the field, and its largest values over squares of 2^h cells, for h = 0, 1, 2...; 0 near their borders.
    """

    places: Indices
    width: int
    bounds: tuple[Floats, ...]
    turn_costs: Floats
    cell_cost: float

    def scores(self, height: int, nodes: Indices) -> Floats:
        """For nodes (k, 3) = (turn, shift in y, shift in x), the scores (k,), or their bounds over 2^height cells."""
        places = self.places[nodes[:, 0]]
        places += (nodes[:, 1] * self.width + nodes[:, 2])[:, None]
        # What lies before the first row or behind the last one is read on the border, where there is nothing.
        seen = self.bounds[height].ravel().take(places, mode="clip").mean(axis=1)
        # The shift of a square that is nearest to none.
        away = np.clip(0, nodes[:, 1:], nodes[:, 1:] + (2**height - 1))
        return np.asarray(seen - self.turn_costs[nodes[:, 0]] - self.cell_cost * np.sum(away**2, axis=1))


def match_by_correlation(P: ArrayLike, Q: ArrayLike, T_q_p: ArrayLike, window: SearchWindow) -> CorrelationMatch:
    """The pose of best score for P (n, 2) on Q (m, 2) in a window around `T_q_p` (3,).

    Raises IcpError or InvalidCloudError.
    """
    p, q, guess = check_plane_cloud("P", P), check_plane_cloud("Q", Q), np.asarray(T_q_p, dtype=np.float64)
    if guess.shape != (3,) or not np.all(np.isfinite(guess)):
        raise IcpError("T_q_p", f"of shape {guess.shape} is not a finite pose (x, y, theta)")
    far = max(float(np.linalg.norm(p, axis=1).max()), window.resolution)
    count = int(np.ceil(window.turn * far / window.resolution))
    turns = window.turn * np.arange(-count, count + 1) / count
    shift = int(np.ceil(window.reach / window.resolution))
    height = int(np.floor(np.log2(2 * shift + 1)))
    lattice = build_lattice(p, q, guess, turns, window, height)
    (turn, dy, dx), score, evaluations = _search_best_node(lattice, len(turns), shift, height)
    moved = guess + np.array([dx * window.resolution, dy * window.resolution, turns[turn]])
    return CorrelationMatch(np.array([*moved[:2], wrap_angle(float(moved[2]))]), score, evaluations)


def build_lattice(
    p: Floats, q: Floats, guess: Floats, turns: Floats, window: SearchWindow, height: int
) -> ScoreLattice:
    """The field of Q on a grid with margins wide enough for every bound, and P at every turn of the guess on it.

    Shifts are below 2^height cells either way, and rows so wide that none leads off them.
    """
    resolution = window.resolution
    c, s = np.cos(guess[2] + turns)[:, None], np.sin(guess[2] + turns)[:, None]
    moved = np.stack([c * p[:, 0] - s * p[:, 1] + guess[0], s * p[:, 0] + c * p[:, 1] + guess[1]], axis=-1)
    cells, marked = np.floor(moved / resolution).astype(np.int64), np.floor(q / resolution).astype(np.int64)
    side = 2**height
    margin = np.array([3 * side + RADIUS + 1, side + RADIUS + 1])
    low, high = marked.min(axis=0) - margin, marked.max(axis=0) + margin
    width, rows = (high - low + 1).tolist()
    field = _proximity_field(marked - low, (rows, width))
    bounds = [field]
    for h in range(height):
        bounds.append(_max_pyramid(bounds[-1], 2**h))
    x, y = np.moveaxis(cells - low, -1, 0)
    places = np.clip(y, -2 * side, rows + side) * width + np.clip(x, side, width - side)
    costs = COST * (turns / window.turn_sigma) ** 2
    return ScoreLattice(places, width, tuple(bounds), costs, COST * (resolution / window.sigma) ** 2)


def _proximity_field(marked: Indices, shape: tuple[int, int]) -> Floats:
    """exp(-d^2 / 2) (rows, width), d the distance in cells to the nearest of `marked` (m, 2) = (x, y); 0 from 3 on."""
    field = np.zeros(shape)
    places = np.unique(marked[:, 1] * shape[1] + marked[:, 0])
    flat = field.reshape(-1)
    for squared, shift_y, shift_x in OFFSETS:
        flat[places + (shift_y * shape[1] + shift_x)] = np.exp(-squared / 2.0)
    return field


def _max_pyramid(field: Floats, side: int) -> Floats:
    """From the largest value over squares of `side` cells on, that over squares twice as large."""
    padded = np.pad(field, ((0, side), (0, side)))
    tall = np.maximum(padded[:-side], padded[side:])
    return np.maximum(tall[:, :-side], tall[:, side:])


def _search_best_node(
    lattice: ScoreLattice, turns: int, shift: int, height: int
) -> tuple[tuple[int, int, int], float, int]:
    """The best (turn, dy, dx) with |dy|, |dx| <= shift, from squares of 2^height cells down to single ones."""
    roots = np.arange(-shift, shift + 1, 2**height)
    nodes = np.stack(np.meshgrid(np.arange(turns), roots, roots, indexing="ij"), axis=-1).reshape(-1, 3)
    bounds, evaluations = lattice.scores(height, nodes), len(nodes)
    best, best_score = nodes[0], -np.inf
    for h in range(height - 1, -2, -1):
        if h >= 0:
            leaf, score = _descend_greedily(lattice, nodes[int(np.argmax(bounds))], h, shift)
        else:
            leaf, score = nodes[int(np.argmax(bounds))], float(bounds.max())
        if score > best_score:
            best, best_score = leaf, score
        nodes = _split_nodes(nodes[bounds > best_score], h, shift)
        if h < 0 or not len(nodes):
            break
        bounds, evaluations = lattice.scores(h, nodes), evaluations + len(nodes)
    return (int(best[0]), int(best[1]), int(best[2])), best_score, evaluations


def _descend_greedily(lattice: ScoreLattice, node: Indices, height: int, shift: int) -> tuple[Indices, float]:
    """A leaf below a node, by the best branch each time, and its score: a score that others must beat."""
    score = 0.0
    for h in range(height, -1, -1):
        branches = _split_nodes(node[None], h, shift)
        scores = lattice.scores(h, branches)
        node, score = branches[int(np.argmax(scores))], float(scores.max())
    return node, score


def _split_nodes(nodes: Indices, height: int, shift: int) -> Indices:
    """The quarters (k, 3) of nodes, of 2^height cells a side, that start within the window."""
    if height < 0:
        return nodes[:0]
    children = np.repeat(nodes, len(BRANCHES), axis=0)
    children[:, 1:] += np.tile(BRANCHES, (len(nodes), 1)) * 2**height
    return children[np.all(children[:, 1:] <= shift, axis=1)]
