"""What both functions are asked by hand, on a small map that no wall surrounds: doors, corners, edges, a few doubts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from graders.core.code.probes import (
    AnswerRule,
    ProbeAnswer,
    ProbeFault,
    ProbeResults,
    Probes,
    measurement_rule,
    to_finite_array,
    undo_rule,
)
from graders.core.contract.local import initial_globals
from graders.core.contract.program import KitSettings
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_array
from graders.l20 import world
from graders.l20.predire2d.beliefs import weighted
from reference.localisation.grid_filter import Cell

PLAN = (
    ".....#..",
    "........",
    "...#....",
    "#...#...",
    "......#.",
    ".#......",
    "....#...",
)
FREE = np.array([[cell == "." for cell in row] for row in PLAN])
SHAPE = FREE.shape
KIT = KitSettings(world.MODULE, {"libres": FREE, "portee_max": world.RANGE, "seed": 0})
NAMES = initial_globals(KIT)


@lru_cache(maxsize=4096)
def _seen_from(x: float, y: float, theta: float, beams: int) -> Floats:
    scan: Floats = NAMES["lidar"]((x, y, theta), beams)
    return scan


def lidar(pose: Sequence[float], n_rayons: int = 36) -> Floats:
    """The kit's noiseless lidar on this map, kept: mutants ask for the same scans again and again."""
    x, y, theta = (float(value) for value in pose)
    return np.array(_seen_from(x, y, theta, n_rayons))


def belief(*cells: Cell) -> Floats:
    """Unequal probabilities on a few cells, of sum 1."""
    shares = np.arange(1.0, len(cells) + 1.0)
    return weighted(SHAPE, dict(zip(cells, (shares / shares.sum()).tolist(), strict=True)))


MANY = belief((1, 1), (0, 7), (3, 5), (5, 0), (6, 5), (2, 4), (4, 5))
CLEAR = ((1, 1),)  # the only free cell of the first columns with eight free neighbours
MOVES = ((1, 0), (-1, 0), (0, 1), (0, -1))
WALLS = belief((2, 2), (3, 1), (3, 3), (4, 7), (5, 2))
EDGES = {(1, 0): belief((1, 7), (4, 7)), (-1, 0): belief((1, 0), (4, 0)), (0, 1): belief((6, 0), (6, 2)),
         (0, -1): belief((0, 0), (0, 3))}  # fmt: skip

PREDICTED: tuple[Arguments, ...] = (
    (MANY, 1, 0),
    *((belief(*CLEAR), du, dv) for du, dv in MOVES),
    *((edge, du, dv) for (du, dv), edge in EDGES.items()),
    *((WALLS, du, dv) for du, dv in MOVES),
    (MANY, 0, 0),
    (MANY, 0, 1),
    (np.where(FREE, 1.0 / FREE.sum(), 0.0), 0, -1),
    (belief((1, 1), (3, 1)), 1, 0),
)
OPEN, EDGE, WALL, STILL = range(1, 5), range(5, 9), range(9, 13), 13
MEETING = 16
"""Two cells whose slips meet on a third: no wall has to do with it."""


def _scan(cell: Cell, *errors: float) -> Floats:
    y, x = cell
    return np.asarray(lidar((x + 0.5, y + 0.5, 0.0), 4) + np.array(errors or (0.0,) * 4))


DOUBT = belief((1, 1), (1, 2), (4, 2))
CORRECTED: tuple[Arguments, ...] = (
    (DOUBT, _scan((1, 2), 0.4, -0.3, 0.2, 0.1), 1.5),
    (belief((5, 3), (5, 5), (4, 4), (6, 6)), _scan((4, 4), -0.2, 0.3, 0.4, -0.1), 2.0),
    (belief((0, 1), (1, 3), (6, 2)), _scan((1, 3), 0.1, 0.5, -0.2, 0.3), 1.0),
    (belief((1, 1), (1, 2)), _scan((1, 1), 0.3, -0.2, 0.1, 0.2), 0.7),
    (belief((1, 1), (1, 2)), _scan((1, 1), 0.3, -0.2, 0.1, 0.2)),
    (belief((4, 4), (4, 5), (3, 5)), _scan((4, 5), 0.2, 0.2, -0.3, 0.2)),
    (np.where(FREE, 1.0 / FREE.sum(), 0.0), _scan((3, 5), 0.2, -0.3, 0.2, 0.1), 1.5),
)
GIVEN, DEFAULT = (0, 1, 2, 3, 6), (4, 5)


def read(args: Arguments, value: Value) -> Value:
    """The belief (H, W) in one row; in words what is none."""
    try:
        array = read_array(value)
    except UnreadableError as error:
        return str(error)
    if array.shape != SHAPE:
        return f"forme {array.shape}"
    return array.ravel() if np.all(np.isfinite(array)) else "nan"


def shares(args: Arguments, shown: ProbeAnswer) -> ProbeAnswer:
    """A belief up to a factor."""
    if not isinstance(shown, np.ndarray) or abs(shown.sum()) < 1e-12:
        return shown
    return np.asarray(shown / shown.sum())


def _rows(shown: ProbeResults) -> list[Floats | None]:
    return [to_finite_array(one, (FREE.size,)) for one in shown.got]


@undo_rule
def other_map(shown: ProbeResults) -> str | None:
    """On this map every call raises, or answers for a map of another size."""
    odd = [
        one.name == "IndexError" if isinstance(one, ProbeFault) else isinstance(one, str) and one.startswith("forme")
        for one in shown.got
    ]
    return "carte_en_dur" if all(odd) else None


def only(
    name: str, places: Sequence[int], *, unless: Callable[[ProbeResults], bool] = lambda shown: False
) -> AnswerRule:
    """All is right but some of these probes."""

    @measurement_rule
    def rule(shown: ProbeResults) -> str | None:
        wrong = set(shown.wrong_indices())
        return name if wrong and wrong <= set(places) and not unless(shown) else None

    return rule


def _sums(shown: ProbeResults) -> list[float]:
    return [float(row.sum()) for row in _rows(shown) if row is not None]


def _arriving(bel: Floats, du: int, dv: int) -> dict[Cell, list[float]]:
    """What arrives on each cell, departure by departure and slip by slip; what a wall stops stays where it was."""
    arriving: dict[Cell, list[float]] = {}
    for y, x in np.argwhere(bel).tolist():
        for p, dx, dy in ((0.8, du, dv), (0.1, du + dv, dv + du), (0.1, du - dv, dv - du)):
            there = (y + dy, x + dx)
            inside = 0 <= there[0] < SHAPE[0] and 0 <= there[1] < SHAPE[1] and FREE[there]
            arriving.setdefault(there if inside else (y, x), []).append(p * float(bel[y, x]))
    return arriving


@measurement_rule
def overwritten(shown: ProbeResults) -> str | None:
    """Each cell holds one of the shares that arrive there, all of it and no other, up to one factor for each answer.

    Whatever the order in which they come, and whether or not the whole is divided by its sum. An order to stay may be
    an exception in the program or not, and says nothing.
    """
    rows = _rows(shown)
    if MEETING not in shown.wrong_indices():
        return None
    for k, (row, (bel, du, dv)) in enumerate(zip(rows, shown.calls, strict=True)):
        if k != STILL and (row is None or not _one_share_each(row.reshape(SHAPE), _arriving(bel, du, dv))):
            return None
    return "ecrasement"


def _one_share_each(row: Floats, arriving: dict[Cell, list[float]]) -> bool:
    if {(y, x) for y, x in np.argwhere(np.abs(row) > 1e-12).tolist()} != set(arriving):
        return False
    first, *_ = sorted(arriving, key=lambda cell: len(arriving[cell]))
    return any(
        all(np.isclose(row[cell] * share, np.array(shares) * row[first], atol=1e-12).any()
            for cell, shares in arriving.items())
        for share in arriving[first]
    )  # fmt: skip


@measurement_rule
def lost_mass(shown: ProbeResults) -> str | None:
    """Right in the open; elsewhere some probability vanishes wherever it is wrong, and none appears."""
    rows, wrong = _rows(shown), shown.wrong_indices()
    if any(rows[k] is None for k in wrong) or {*OPEN, STILL, MEETING} & set(wrong):
        return None
    fewer = [float(row.sum()) < 1.0 - 1e-9 and bool(np.all(row <= right + 1e-9))
             for k in wrong if (row := rows[k]) is not None and (right := shown.right[k]) is not None]  # fmt: skip
    return "masse_perdue" if fewer and all(fewer) else None


@measurement_rule
def not_normalised(shown: ProbeResults) -> str | None:
    """Proportional to what is right, and of another sum."""
    rows = _rows(shown)
    scaled = [row is not None and row.sum() > 0 and np.allclose(row / row.sum(), right, atol=1e-9)
              for row, right in zip(rows, shown.right, strict=True)]  # fmt: skip
    return "non_normalisee" if all(scaled) else None


@measurement_rule
def walls_get_some(shown: ProbeResults) -> str | None:
    """Walls receive a probability in most answers."""
    rows = [row for row in _rows(shown) if row is not None]
    walls = [float(np.abs(row.reshape(SHAPE)[~FREE]).max()) > 1e-9 for row in rows]
    return "murs_possibles" if rows and sum(walls) > len(rows) / 2 else None


@measurement_rule
def wrong_likelihood(shown: ProbeResults) -> str | None:
    """A belief of sum 1, on the cells that were possible, with other weights."""
    rows = _rows(shown)
    for row, args in zip(rows, shown.calls, strict=True):
        if row is None or abs(row.sum() - 1.0) > 1e-9 or np.any(np.abs(row[args[0].ravel() == 0.0]) > 1e-12):
            return None
    return "vraisemblance_fausse" if len(shown.wrong_indices()) >= len(rows) - 1 else None


def _plain(shown: ProbeResults) -> bool:
    return bool(set(shown.wrong_indices()) & {0, *OPEN})


PROBES = (
    Probes(
        function="predire2d",
        calls=PREDICTED,
        kit=KIT,
        read=read,
        given={"lidar": lidar},
        rules=(
            other_map,
            only("glisse_a_l_arret", [STILL]),
            overwritten,
            lost_mass,
            only("bord_mal_traite", [0, *EDGE, *WALL, 14, 15], unless=lambda s: bool(set(s.wrong_indices()) & {9, 11})),
            only("choc_mal_traite", [0, *EDGE, *WALL, 14, 15]),
        ),
    ),
    Probes(
        function="corriger2d",
        calls=CORRECTED,
        kit=KIT,
        read=read,
        given={"lidar": lidar},
        facet=shares,
        rules=(
            other_map,
            only("sigma_par_defaut_faux", DEFAULT),
            not_normalised,
            walls_get_some,
            wrong_likelihood,
        ),
    ),
)
