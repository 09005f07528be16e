"""The film of l20/occupation: the student's map as it grows, beside the reference's."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from graders.core.contract.local import initial_globals
from graders.core.contract.values import Floats
from graders.l20 import world
from graders.l20.occupation.judge import Integration, wrong_cells
from graders.scene.replay import (
    Chart,
    Circles,
    Frame,
    Grid,
    Key,
    Layer,
    Mark,
    Pose,
    Rays,
    Replay,
    Segments,
    Series,
    View,
    decimal,
)
from reference.occupancy import InverseSensorModel, OccupancyGrid, probability_of_log_odds
from reference.world.scan import Scan

MINE, EXPECTED = 0, 1
#: Log-odds nearer to 0 say nothing of a cell.
UNKNOWN = 0.1
LEVELS = 32


def expected_maps(poses: Floats, scans: Floats, mine: list[Floats]) -> list[Floats]:
    """The reference's map after each scan, read as the student's: one vote a ray or, if that is nearer, one a scan."""
    readings = [_drawn(poses, scans, once) for once in (False, True)]
    if not mine:
        return readings[0]
    return min(readings, key=lambda maps: float(np.abs(maps[0] - mine[0]).sum()))


def _drawn(poses: Floats, scans: Floats, once_a_scan: bool) -> list[Floats]:
    grid = OccupancyGrid(np.zeros(_free().shape), model=InverseSensorModel(once_a_scan=once_a_scan))
    maps = []
    for pose, scan in zip(poses, scans, strict=True):
        grid.integrate(Scan.full_turn(scan, world.RANGE), pose)
        maps.append(grid.log_odds.copy())
    return maps


@cache
def _free() -> Any:
    return np.asarray(initial_globals(world.STILL)["libres"])


def growing_map(data: dict[str, Any]) -> Replay:
    """The two maps side by side after each scan, the cells that it has made wrong ringed, the first one marked."""
    poses = np.array(data["poses"], dtype=float)
    scans = np.minimum(np.array(data["scans"], dtype=float), world.RANGE)
    mine = [np.array(one, dtype=float) for one in data["maps"]]
    right = expected_maps(poses, scans, mine)
    height, width = _free().shape
    first, cell = data["wrong"], data["cell"]
    frames, counts = [], []
    for k in range(max(1, len(mine))):
        before = mine[k - 1] if k else np.zeros((height, width))
        own = mine[k] if mine else before
        wrong = _wrong(Integration(before, poses[k], scans[k], world.RANGE), own) if mine else np.zeros((0, 2))
        counts.append(len(wrong))
        layers: list[Layer] = [
            Grid(_shades(own), "occupancy", panel=MINE),
            Grid(_shades(right[k]), "occupancy", panel=EXPECTED),
            *_robot(poses[k], scans[k]),
            Circles(wrong, 0.45, "alert", filled=False, panel=MINE),
        ]
        if first == k and cell:
            at = np.array([[cell[1] + 0.5, cell[0] + 0.5]])
            layers.append(Circles(at, 0.9, "second", filled=False))
        frames.append(Frame(layers, _caption(k, first, cell, len(wrong))))
    numbers = np.arange(1.0, len(frames) + 1.0)
    marks = [] if first is None else [Mark(float(min(first + 1, len(frames))), "première erreur")]
    return Replay(
        View(-0.2, -0.2, width + 0.2, height + 0.2),
        frames,
        _summary(mine, counts, first, cell),
        over=[_walls()],
        charts=[
            Chart(
                "Cases que ce scan ne devait pas changer ainsi",
                [Series("cases", "alert", counts, numbers, style="bars")],
                "scan",
                (0.0, None),
                marks=marks,
                cursor=numbers.tolist(),
            )
        ],
        legend=[
            Key("cell", "ink", "jugée pleine"),
            Key("line", "truth", "vrais murs"),
            Key("ring", "alert", "case fausse après ce scan"),
            *([Key("ring", "second", "première case fausse")] if cell else []),
        ],
        period=0.8,
        panels=("Votre carte", "La carte attendue"),
    )


def _wrong(case: Integration, grid: Floats) -> Floats:
    """The middles (k, 2) = (x, y) of the cells that the scan has not changed as it must."""
    mask = np.any([mask for mask, _ in wrong_cells(case, grid)], axis=0)
    return np.asarray(np.argwhere(mask)[:, ::-1] + 0.5)


def _shades(grid: Floats) -> Floats:
    return np.asarray(np.round(probability_of_log_odds(grid) * LEVELS) / LEVELS)


def _robot(pose: Floats, scan: Floats) -> list[Layer]:
    headings = pose[2] + 2.0 * np.pi * np.arange(len(scan)) / len(scan)
    ends = pose[:2] + scan[:, None] * np.column_stack([np.cos(headings), np.sin(headings)])
    return [Rays(pose[:2], ends, hits=scan < world.RANGE), Pose(pose, "truth", glide=True)]


def _walls() -> Segments:
    """The line between free cells and walls."""
    free = np.pad(_free(), 1)
    rows, columns = np.nonzero(free[1:] != free[:-1])
    across = np.column_stack([columns - 1, rows, columns, rows])
    rows, columns = np.nonzero(free[:, 1:] != free[:, :-1])
    down = np.column_stack([columns, rows - 1, columns, rows])
    ends = np.vstack([across, down]).astype(np.float64)
    return Segments(ends[:, :2], ends[:, 2:], "truth", width=1.0, opacity=0.6)


def _caption(k: int, first: int | None, cell: list[int] | None, wrong: int) -> str:
    text = f"Scan {k + 1}"
    if first == k:
        where = f" : la case (ligne {cell[0]}, colonne {cell[1]}) n'est pas ce qu'elle doit être" if cell else ""
        return f"{text}. Ici votre carte s'écarte de la règle{where}."
    if not wrong:
        return f"{text} : chaque case jugée a changé comme elle le devait."
    return f"{text} : {wrong} case{'s' * (wrong > 1)} fausse{'s' * (wrong > 1)} de plus."


def _summary(mine: list[Floats], counts: list[int], first: int | None, cell: list[int] | None) -> list[str]:
    if first is None:
        share = 100.0 * float(np.mean(np.abs(mine[-1]) >= UNKNOWN))
        return [
            f"En {len(mine)} scans, votre carte connaît {decimal(share, 0)} % des cases.",
            "Elle peut différer de l'autre là où les rayons effleurent une case : ces cases sont libres.",
        ]
    where = f", dans la case (ligne {cell[0]}, colonne {cell[1]})" if cell else ""
    texts = [f"La première erreur est au scan {first + 1}{where}."]
    if len(mine) <= first:
        return [*texts, "Votre fonction n'y a pas rendu de grille : le film s'arrête là."]
    return [*texts, f"{sum(count > 0 for count in counts)} scans sur {len(mine)} sont mal intégrés."]


REPLAYS = {"map": growing_map}
