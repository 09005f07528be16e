"""A place recogniser for scans of half a turn, and what it proposes in the laboratory, false places included.

Half a turn from behind shows other walls: a place can be recognised where the robot comes by it with the same heading
again. And appearance alone recognises corridors, all of which look alike: of the hundred pairs of these scans that look
most alike, none is of one place. So the chain of matches says where to look, within `REACH` of what it has come to, and
the scans say where exactly: the pose at which the points of b lie best on the walls of a, by trying all of a grid.

What it proposes is not all true: along a corridor a scan may slide by metres and lie as well as before. Sources: Olson,
"Real-Time Correlative Scan Matching" (2009), for the search; Censi, "An Accurate Closed-Form Estimate of ICP's
Covariance" (2007), for what a corridor leaves free.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import distance_transform_edt

from graders.core.contract.values import Floats
from reference.se2 import relative, rotation_matrix

Proposal = tuple[int, int, Floats]

#: Ranks between two visits; how far off the chain may be (m, rad).
GAP, REACH, TURN = 20, 3.0, 0.8
#: The grid of walls, in metres, and how near a point must be to count; the poses that are tried.
CELL, EXTENT, NEAR = 0.1, 8.0, 0.1
SHIFTS, TURNS = np.arange(-15, 16), np.radians(np.arange(-10, 11, 2))
#: The least share of points that lie on walls.
ALIKE = 0.6


def recognise(clouds: Sequence[Floats], chain: Floats) -> list[Proposal]:
    """For each scan b, the place a of the past that it lies on best, with a rough pose of b in the frame of a.

    `clouds` are the points (m, 2) of the scans in their robots' frames, `chain` (k, 3) the poses that matches come to.
    """
    walls = [_walls(cloud) for cloud in clouds]
    found: list[Proposal] = []
    for b in range(GAP, len(clouds)):
        best: tuple[float, int, Floats] | None = None
        for a in range(b - GAP):
            x, y, turn = relative(chain[a], chain[b]).tolist()
            if np.hypot(x, y) < REACH and abs(turn) < TURN:
                share, pose = _laid(walls[a], clouds[b], turn)
                if share >= ALIKE and (best is None or share > best[0]):
                    best = share, a, pose
        if best is not None:
            found.append((best[1], b, best[2]))
    return found


def _walls(cloud: Floats) -> Floats:
    """How much a point in each cell of the square around the robot lies on a wall: 1 on it, less beside it."""
    size = round(2.0 * EXTENT / CELL)
    empty = np.ones((size, size), dtype=np.bool_)
    x, y = np.floor((cloud + EXTENT) / CELL).astype(np.int64).T
    inside = (x >= 0) & (x < size) & (y >= 0) & (y < size)
    empty[y[inside], x[inside]] = False
    return np.asarray(np.exp(-0.5 * (distance_transform_edt(empty) * CELL / NEAR) ** 2))


def _laid(walls: Floats, cloud: Floats, turn: float) -> tuple[float, Floats]:
    """The pose of the grid at which the points lie on the walls best, and how well, in [0, 1]."""
    size = len(walls)
    points = cloud[np.hypot(*cloud.T) < EXTENT + SHIFTS[0] * CELL]
    best, pose = -1.0, np.zeros(3)
    for heading in turn + TURNS:
        x, y = np.floor((points @ rotation_matrix(heading).T + EXTENT) / CELL).astype(np.int64).T
        columns, rows = x[:, None, None] + SHIFTS, y[:, None, None] + SHIFTS[:, None]
        inside = (columns >= 0) & (columns < size) & (rows >= 0) & (rows < size)
        there = walls[np.clip(rows, 0, size - 1), np.clip(columns, 0, size - 1)]
        shares = np.where(inside, there, 0.0).mean(axis=0)
        row, column = np.unravel_index(int(np.argmax(shares)), shares.shape)
        if shares[row, column] > best:
            best, pose = float(shares[row, column]), np.array([SHIFTS[column] * CELL, SHIFTS[row] * CELL, heading])
    return best, pose
