"""What the three functions are asked by hand: radii between two distances, dear cells, corners, bags, no way at all."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graders.core.code.probes import (
    ProbeResults,
    Probes,
    measurement_rule,
    read_array_or_reason,
    read_number_or_reason,
    to_finite_array,
)
from graders.core.contract.values import Arguments, UnreadableError, Value
from graders.l20 import world
from graders.l20.planifier import cases
from graders.l20.planifier.cases import floor, grid
from graders.l20.planifier.causes import cause_rules
from graders.l20.planifier.judge import KINDS, FaultyPathError, check_path, read_path
from graders.l20.planifier.truth import Cell, best_path, right_price

GRIDS: tuple[Arguments, ...] = (
    (grid(".......", ".......", "...#...", ".......", "......."), 0.23, 0.1),
    (grid("#.....", "......", "......", "....?.", "......"), 1.3, 0.5),
    (grid(".....?.", ".......", ".......", "#......"), 0.17, 0.1),
    (grid("......#", ".......", ".......", "......."), 4.1, 1.3),
    (grid(".#....", "......", "?.....", "......", ".....#"), 0.26, 0.2),
    (grid("#?..", "...."), 0.0, 0.1),
    (grid("..........", "....#.....", "..........", ".........."), 0.37, 0.05),
    (grid("........", "........", "........", "...#....", "........", "........", "........"), 2.5, 1.0),
)
HILL = np.array([[0.3, 1.1, 0.7, 4.2], [2.6, 0.9, 0.4, 3.3], [0.2, 0.5, 6.1, 1.7]])
PATHS: tuple[Arguments, ...] = (
    ([(0, 0), (0, 1), (0, 2)], HILL),
    ([(0, 1), (1, 2), (2, 3)], HILL),
    ([(2, 0), (1, 1), (1, 2), (0, 3), (1, 3)], HILL),
    ([(0, 0), (0, 1), (1, 1)], np.zeros((3, 4))),
    ([(0, 0), (1, 1)], np.zeros((3, 4))),
    ([(1, 1)], HILL),
    ([(1, 1), (1, 2), (2, 2), (1, 1), (0, 0), (0, 1)], HILL),  # through a cell twice
)
PLANS: tuple[Arguments, ...] = (
    (cases.CORNER, cases.no_cost(cases.CORNER), (0, 0), (1, 1)),
    (cases.PILLAR, cases.no_cost(cases.PILLAR), (0, 1), (2, 1)),
    (cases.OPEN, cases.no_cost(cases.OPEN), (0, 0), (3, 5)),
    (cases.DETOUR, cases.no_cost(cases.DETOUR), (0, 5), (2, 2)),
    (cases.BAG, cases.no_cost(cases.BAG), (2, 0), (2, 6)),
    (cases.HASTY, cases.no_cost(cases.HASTY), (2, 0), (2, 3)),
    (cases.TWO_WALLS, cases.no_cost(cases.TWO_WALLS), (1, 0), (1, 5)),
    *tuple(cases.cheapest(np.random.default_rng(1)))[1:11],
    *tuple(cases.without_a_path(np.random.default_rng(1))),
    (floor(".#", "#.", ".."), np.zeros((3, 2)), (0, 0), (1, 1)),
    (floor(".#.", ".#.", "..."), np.zeros((3, 3)), (0, 0), (0, 2)),
)


def read_plan(args: Arguments, value: Value) -> Value:
    """What is wrong with a path, a rank of KINDS or -1, then its price and its cells' sum: equal paths look alike.

    Of a right path the price alone: there may be several.
    """
    try:
        path = read_path(value)
    except UnreadableError as error:
        return str(error)
    except FaultyPathError as fault:
        return fault.message
    try:
        check_path(args, path)
    except FaultyPathError as fault:
        return np.array([KINDS.index(fault.kind), _walked(args, path), len(path)], dtype=float)
    best = best_path(*args)
    return np.array([-1.0, right_price(best, args[1]) if best else 0.0, 0.0])


def _walked(args: Arguments, path: Sequence[Cell]) -> float:
    """The price of a path whose cells are in the grid, else -1."""
    height, width = args[1].shape
    inside = all(0 <= i < height and 0 <= j < width for i, j in path)
    return right_price(path, args[1]) if inside else -1.0


def _faults(shown: ProbeResults) -> set[str]:
    """The kinds of what is wrong; empty where an answer is no path at all."""
    found = [to_finite_array(one, (3,)) for one in shown.got]
    return set() if any(one is None for one in found) else {KINDS[int(one[0])] for one in found if one[0] >= 0}  # type: ignore[index]


@measurement_rule
def cuts_corners(shown: ProbeResults) -> str | None:
    return "coins_coupes" if _faults(shown) == {"coin"} else None


def _are_too_dear(shown: ProbeResults) -> bool:
    """Can every path be walked, from start to goal, and are some too dear?"""
    return _faults(shown) == {"cher"}


@measurement_rule
def too_dear(shown: ProbeResults) -> str | None:
    return "pas_le_meilleur" if _are_too_dear(shown) else None


PROBES = (
    Probes(function="gonfler", calls=GRIDS, kit=world.STILL, read=read_array_or_reason),
    Probes(function="cout", calls=PATHS, kit=world.STILL, read=read_number_or_reason),
    Probes(
        function="planifier",
        calls=PLANS,
        kit=world.STILL,
        unique=False,
        read=read_plan,
        last_rules=(cuts_corners, *cause_rules(_are_too_dear), too_dear),
    ),
)
