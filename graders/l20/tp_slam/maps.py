"""The last stage: the map that the scans draw from the optimised poses, held against the true walls."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.compare.comparison import unreadable
from graders.core.contract.values import Floats, UnreadableError, read_array
from graders.l20 import parcours
from graders.l20.tp_slam import journeys
from graders.l20.tp_slam.chain import chain_of
from graders.l20.tp_slam.pictures import MAP
from graders.l20.tp_slam.stages import borrowed
from graders.l20.tp_slam.told import given_up
from reference.registration import kabsch

SIDE = 0.1  # metres
MARGIN = 1.0
#: One key scan in so many: of all of them the map is no better (free 0.90, walls 0.99), and takes ten times as long.
EVERY = 10
#: Of the cells said to be free and to be walls, how many are; the course's map: 0.93 and 1.00, mirrored 0.74 and 0.60,
#: from poses that only odometry gives 0.76 and 0.78.
FREE, WALLS = 0.85, 0.93
#: How far from a wall, in metres, a cell may be that is marked as one: poses, noise and cells are not finer.
THICK = 0.2
LEAST_FREE = 2000


def mapping(bench: Bench) -> None:
    """The map of some key scans, in the frame of the first pose."""
    chain = chain_of(bench)
    all_keys, all_poses = chain.solved()
    keys, poses = all_keys[::EVERY], all_poses[::EVERY]
    scans = journeys.simulated().scans[keys]
    shape, corner = frame()
    value = bench.call("carte", poses, scans, shape, corner, SIDE)
    try:
        log_odds = read_array(value)
    except UnreadableError as error:
        raise given_up(bench, "carte", unreadable(error)) from error
    if log_odds.shape != shape or not np.all(np.isfinite(log_odds)):
        bench.observe("carte", None, ok=False)
        raise Rejection(
            f"carte doit renvoyer un tableau de forme {shape}, sans nan ni infini.", inputs={"forme": list(shape)},
            expected=f"forme {shape}", got=f"forme {log_odds.shape}",
        )  # fmt: skip
    free, walls, count = scores(log_odds, corner, poses, keys)
    well = free >= FREE and walls >= WALLS and count >= LEAST_FREE and float(np.abs(log_odds).max()) <= 5.0 + 1e-6
    bench.observe("carte", [free >= FREE, walls >= WALLS, count >= LEAST_FREE], ok=well)
    if not well:
        raise Rejection(
            f"Des cases que votre carte dit libres ({count}), {_percent(free)} le sont ; de celles qu’elle dit "
            f"occupées, {_percent(walls)} touchent un vrai mur. Les log-odds vont de {log_odds.min():.1f} à "
            f"{log_odds.max():.1f}.{borrowed(chain)}",
            inputs={"forme": list(shape), "origine": corner, "cote": SIDE},
            expected=f"au moins {LEAST_FREE} cases libres, justes à {_percent(FREE)} ; murs justes à "
            f"{_percent(WALLS)} ; des log-odds entre −5 et 5",
            got=f"{count} cases libres, justes à {_percent(free)} ; des murs justes à {_percent(walls)}",
            figure={"kind": MAP, "got": np.round(np.clip(log_odds, -6, 6), 1), "poses": np.round(poses[:, :2], 2),
                    "corner": corner, "side": SIDE},
        )  # fmt: skip
    bench.measured = f"Cases libres justes à {_percent(free)}, murs justes à {_percent(walls)}."


def frame() -> tuple[tuple[int, int], Floats]:
    """The shape (H, W) and the corner (2,) of a grid that holds the whole place, in the frame of the first pose."""
    start = parcours.journey().truth[0]
    free = parcours.place()
    height, width = free.shape
    corners = free.to_world([(0, 0), (width, 0), (0, height), (width, height)])
    cosine, sine = np.cos(start[2]), np.sin(start[2])
    inside = (corners - start[:2]) @ np.array([[cosine, -sine], [sine, cosine]])
    low, high = inside.min(axis=0) - MARGIN, inside.max(axis=0) + MARGIN
    columns, rows = np.ceil((high - low) / SIDE).astype(int)
    return (int(rows), int(columns)), np.round(low, 2)


def scores(log_odds: Floats, corner: Floats, poses: Floats, keys: Sequence[int]) -> tuple[float, float, int]:
    """How many of the cells said to be free are, how many of those said to be walls are near one, and how many are
    free."""
    rows, columns = np.nonzero(np.abs(log_odds) > 0.0)
    centres = corner + SIDE * (np.column_stack([columns, rows]) + 0.5)
    laid = kabsch(poses[:, :2], parcours.journey().truth[list(keys), :2])
    places = (centres @ laid.R_q_p.T + laid.t_q_p) / parcours.CELL
    free = _near(places, wall=False)
    wall = _near(places, wall=True)
    said = log_odds[rows, columns]
    count = int(np.sum(said < 0))
    right_free = float(np.mean(free[said < 0])) if count else 0.0
    right_wall = float(np.mean(wall[said > 0])) if np.any(said > 0) else 0.0
    return right_free, right_wall, count


def _near(places: Floats, *, wall: bool) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Is each place (in cells of the true map) in a free cell, or within THICK of a wall?"""
    grid = np.pad(parcours.place().free, 2)
    reach = THICK / parcours.CELL if wall else 0.0
    found = np.zeros(len(places), dtype=bool)
    for dx in (-reach, 0.0, reach):
        for dy in (-reach, 0.0, reach):
            x, y = np.floor(places + np.array([dx, dy])).astype(int).T
            inside = grid[np.clip(y + 2, 0, grid.shape[0] - 1), np.clip(x + 2, 0, grid.shape[1] - 1)]
            found |= ~inside if wall else inside
    return found


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"
