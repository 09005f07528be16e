"""What a scan surely does to each cell of a grid: which cells every honest program crosses, stops in, leaves alone.

Honest programs differ: by the small step after which the stopping cell is looked up, by how finely they walk along a
ray, by one vote a ray or one vote a scan, by the robot's own cell, by a stopping cell of which the ray has gone through
a part (it gets +0.847, or nothing, being crossed and then stopped in). Only what none of this changes is judged.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graders.core.contract.values import Floats

Mask = NDArray[np.bool_]

#: The small steps that are accepted, in cells, with some room for rounding.
LEAST_STEP, LONGEST_STEP = 1e-9, 0.06
#: A cell is surely crossed where this much of a ray is in it: a walk by tenths of a cell does not miss it.
CROSSED = 0.25
#: A ray that passes that near a cell may graze it.
GRAZED = 0.01
#: What is left, in the stopping cell, of a ray that is stopped at its face.
FACE = 0.02


@dataclass(frozen=True, eq=False)
class Told:
    """Masks (H, W). `either`: the cell in which a ray reads its end; `never`: those in which none can stop, which must
    not rise, judged or not otherwise; a cell in none of the masks is not judged."""

    crossed: Mask
    stopped: Mask
    either: Mask
    untouched: Mask
    never: Mask


def told(shape: tuple[int, ...], pose: Floats, scan: Floats, portee_max: float) -> Told:
    """What the scan (n,) taken at `pose` (3,) does to the cells of a grid of that shape."""
    x, y, theta = (float(value) for value in pose)
    angles = theta + 2.0 * np.pi * np.arange(len(scan)) / len(scan)
    ends = np.asarray(scan, dtype=np.float64)[:, None, None]
    hit = ends < portee_max
    enters, leaves = _chords(shape, x, y, angles, 0.0)
    well_in, well_out = _chords(shape, x, y, angles, -GRAZED)
    near_in, near_out = _chords(shape, x, y, angles, GRAZED)
    may_stop = hit & (leaves > ends + LEAST_STEP / 2.0) & (enters <= ends + LONGEST_STEP) & (enters < leaves)
    lasts = hit & (well_out >= ends + LONGEST_STEP)
    at_face = lasts & (np.abs(enters - ends) <= LEAST_STEP / 10.0) & (well_in <= ends + LONGEST_STEP)
    inside = lasts & (enters < ends - FACE) & (well_in < ends)
    farthest = np.where(hit, ends, np.maximum(ends, portee_max)) + LONGEST_STEP
    may_cross = np.minimum(near_out, farthest) >= np.maximum(near_in, 0.0)
    crossed = np.minimum(well_out, np.minimum(ends, portee_max)) - np.maximum(well_in, 0.0) >= CROSSED
    crossed &= ~may_stop
    grazed = may_cross & ~crossed & ~may_stop
    doubtful = may_stop & ~at_face & (enters < ends - FACE)
    judged = ~_under(shape, x, y)
    return Told(
        crossed=judged & crossed.any(axis=0) & ~may_stop.any(axis=0),
        stopped=judged & at_face.any(axis=0) & ~(crossed | grazed | doubtful).any(axis=0),
        either=judged & inside.any(axis=0) & (len(scan) == 1),
        untouched=judged & ~(may_cross | may_stop).any(axis=0),
        never=judged & ~may_stop.any(axis=0),
    )


def _under(shape: tuple[int, ...], x: float, y: float) -> Mask:
    """The cell of the robot, and its neighbours where it stands on a line of the grid."""
    rows, columns = np.arange(shape[0])[:, None], np.arange(shape[1])[None, :]
    inside_y = (rows <= y + GRAZED) & (y - GRAZED <= rows + 1)
    return np.asarray(inside_y & (columns <= x + GRAZED) & (x - GRAZED <= columns + 1))


def _chords(shape: tuple[int, ...], x: float, y: float, angles: Floats, margin: float) -> tuple[Floats, Floats]:
    """Distances (n, H, W) at which each ray enters and leaves each cell, grown by a margin; enters > leaves: missed."""
    columns = _between(np.arange(shape[1]), x, np.cos(angles), margin)
    rows = _between(np.arange(shape[0]), y, np.sin(angles), margin)
    enters = np.maximum(rows[0][:, :, None], columns[0][:, None, :])
    leaves = np.minimum(rows[1][:, :, None], columns[1][:, None, :])
    return enters, leaves


def _between(cells: NDArray[np.int64], start: float, slopes: Floats, margin: float) -> tuple[Floats, Floats]:
    """Along one axis: distances (n, cells) at which each ray enters and leaves each row or column."""
    steep = np.where(np.abs(slopes) < 1e-12, 1e-12, slopes)[:, None]
    sides = (cells - margin - start) / steep, (cells + 1.0 + margin - start) / steep
    return np.minimum(*sides), np.maximum(*sides)
