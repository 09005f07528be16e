"""Is a grid of log-odds what a scan makes of the one given? Exact values for one ray, signs for several."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from graders.core.compare import words as render
from graders.core.compare.comparison import Mismatch, shape_mismatch, unreadable
from graders.core.compare.told_apart import number_text_pair
from graders.core.contract.values import Floats, UnreadableError, Value, read_array
from graders.l20.occupation.cells import Mask, Told, told

INCREMENT = float(np.log(0.7 / 0.3))
CLAMP = 5.0
#: 0.847 is ln(0.7 / 0.3) to 3e-4.
TOLERANCE = 5e-4 + 1e-9
#: What single precision loses of a value that should stay as it is.
UNCHANGED = 1e-5


class Integration(NamedTuple):
    """The arguments of `integrer_scan`: log-odds (H, W), a pose (3,), a scan (n,), the range."""

    l: Floats  # noqa: E741 the letter of the course
    pose: Floats
    scan: Floats
    portee_max: float

    @property
    def told(self) -> Told:
        pose, scan = (np.asarray(one, dtype=np.float64) for one in (self.pose, self.scan))
        return _told(self.l.shape, pose.tobytes(), scan.tobytes(), float(self.portee_max))


@lru_cache(maxsize=256)
def _told(shape: tuple[int, ...], pose: bytes, scan: bytes, portee_max: float) -> Told:
    """Kept: a diagnosis asks the same of every misconception in turn."""
    return told(shape, np.frombuffer(pose), np.frombuffer(scan), portee_max)


@dataclass(frozen=True)
class Wrong:
    """Why a grid is wrong, and at which cell (y, x), if at one."""

    mismatch: Mismatch
    cell: tuple[int, int] | None = None


def judge(case: Integration, value: Value) -> Wrong | None:
    """What is wrong with a returned grid. Never raises for a student's value."""
    try:
        grid = read_array(value)
    except UnreadableError as error:
        return Wrong(unreadable(error))
    if grid.shape != case.l.shape:
        return Wrong(shape_mismatch(case.l, grid))
    if not np.all(np.isfinite(grid)):
        return Wrong(Mismatch("Le résultat contient « nan » ou l’infini.", "nan"))
    return exactly(case, grid) if len(case.scan) == 1 else by_signs(case, grid)


def after(case: Integration) -> Floats:
    """What one ray makes of the grid: the cells that are not judged stay as they are."""
    seen = case.told
    change = INCREMENT * (1.0 * seen.stopped + 1.0 * seen.either - 1.0 * seen.crossed)
    return np.where(change != 0.0, np.clip(case.l + change, -CLAMP, CLAMP), case.l)


def exactly(case: Integration, grid: Floats) -> Wrong | None:
    """One ray: every judged cell has its value."""
    seen, wanted = case.told, after(case)
    far = np.abs(grid - wanted) > TOLERANCE
    between = (grid >= np.minimum(case.l, wanted) - TOLERANCE) & (grid <= wanted + TOLERANCE)
    for mask, why in (
        (seen.stopped, "le rayon s’y arrête"),
        (seen.either & ~between, "le rayon s’y arrête"),
        (seen.crossed, "le rayon la traverse"),
        (seen.untouched, "le rayon ne la rencontre pas"),
        (seen.never & (grid > case.l + TOLERANCE), "le rayon ne s’y arrête pas"),
    ):
        cell = _worst(mask & far, np.abs(grid - wanted))
        if cell is not None:
            before = render.number(float(case.l[cell]), 4)
            right, yours = number_text_pair(float(wanted[cell]), float(grid[cell]), 4)
            wish = f"garder {before}" if case.l[cell] == wanted[cell] else f"passer de {before} à {right}"
            return _at(cell, f"{why}, elle doit {wish} ; la vôtre vaut {yours}.")
    return None


def by_signs(case: Integration, grid: Floats) -> Wrong | None:
    """Several rays: what all stop in rises, what all cross falls, within the bounds; the rest stays as it is."""
    for mask, wish in wrong_cells(case, grid):
        cell = _worst(mask, np.ones(grid.shape))
        if cell is not None:
            before, now = number_text_pair(float(case.l[cell]), float(grid[cell]), 4)
            return _at(cell, f"{wish} ; elle valait {before}, la vôtre vaut {now}.")
    return None


def wrong_cells(case: Integration, grid: Floats) -> list[tuple[Mask, str]]:
    """The cells that are wrong in each of the ways in which one may be, after several rays."""
    seen = case.told
    change = grid - case.l
    high, low = (np.abs(grid - bound) <= TOLERANCE for bound in (CLAMP, -CLAMP))
    rises, falls = high | (change > TOLERANCE), low | (change < -TOLERANCE)
    return [
        (np.abs(grid) > CLAMP + TOLERANCE, "elle doit rester entre −5 et 5"),
        (seen.stopped & ~rises, "des rayons s’y arrêtent et aucun ne la traverse, elle doit monter"),
        (seen.crossed & ~falls, "des rayons la traversent et aucun ne s’y arrête, elle doit baisser"),
        (
            seen.untouched & (np.abs(change) > UNCHANGED),
            "aucun rayon ne la rencontre, elle doit rester comme elle était",
        ),
    ]


def _worst(wrong: Mask, gap: Floats) -> tuple[int, int] | None:
    """The wrong cell of the largest gap, the first one of several."""
    if not wrong.any():
        return None
    y, x = np.unravel_index(int(np.argmax(np.where(wrong, gap, -1.0))), wrong.shape)
    return int(y), int(x)


def _at(cell: tuple[int, int], text: str) -> Wrong:
    return Wrong(Mismatch(f"Case (y, x) = {cell} : {text}"), cell)
