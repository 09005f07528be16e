"""Small maps on which dear paths have one cause each: what an answer there tells of how the search goes.

`SECOND_ACCESS`: a cell is reached twice before it leaves the queue, the second time more cheaply; in half of them the
costs of its neighbours make the difference, in the others its own. `SECOND_GOAL`: the same, of the goal itself.
`TWINS`: two corridors of one form, so that whatever is estimated is the same in both; nothing is reached twice.
`NEARING`: two corridors, of which the dearer one nears the goal first, and is dearer by little.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from graders.core.code.probes import (
    AnswerRule,
    ProbeAnswer,
    ProbeResults,
    ProgramTrial,
    experiment_rule,
    to_finite_array,
)
from graders.core.contract.values import Arguments
from graders.l20.planifier import cases
from graders.l20.planifier.cases import floor
from graders.l20.planifier.truth import best_path, right_price

#: Costs of the cell that is reached first, of the one from which it is cheaper, and of the cell that both reach.
ACCESSES = ((0.0, 0.3, 40.0), (4.0, 3.0, 0.0))
#: How much of a path's price may be due to rounding.
ROUNDING = 1e-6


def turned(args: Arguments, how: str) -> Arguments:
    """The same map, half a turn around (`h`), with rows and columns exchanged (`t`), or both."""
    permitted, costs, start, goal = args
    height, width = permitted.shape
    if "h" in how:
        permitted, costs = permitted[::-1, ::-1], costs[::-1, ::-1]
        start, goal = ((height - 1 - i, width - 1 - j) for i, j in (start, goal))
    if "t" in how:
        permitted, costs, start, goal = permitted.T, costs.T, start[::-1], goal[::-1]
    return np.ascontiguousarray(permitted), np.ascontiguousarray(costs), start, goal


def _second_access(first: float, second: float, reached: float, *, is_goal: bool) -> Arguments:
    permitted = floor("...", "...") if is_goal else floor("......", "...###")
    costs = np.zeros(permitted.shape)
    costs[1, 1], costs[0, 1], costs[0, 2] = first, second, reached
    return permitted, costs, (1, 0), (0, permitted.shape[1] - 1)


def _twin_corridors(dear: int) -> Arguments:
    costs = np.zeros((3, 7))
    costs[dear, 2:5], costs[2 - dear, 2:5] = 3.0, 2.0
    return floor(".......", ".#####.", "......."), costs, (1, 0), (1, 6)


TURNS = ("", "h", "t", "ht")
SECOND_ACCESS = tuple(turned(_second_access(*costs, is_goal=False), how) for costs in ACCESSES for how in TURNS)
SECOND_GOAL = tuple(turned(_second_access(*costs, is_goal=True), how) for costs in ACCESSES for how in TURNS)
TWINS = tuple(turned(_twin_corridors(dear), how) for dear in (0, 2) for how in ("", "t"))
NEARING = tuple(turned(cases.nearing_corridors(), how) for how in TURNS)


def first_access_price(args: Arguments) -> float:
    """The price of the path of a map of SECOND_ACCESS or SECOND_GOAL that comes by the first access: a straight step, a
    diagonal one, then straight on to the goal."""
    _, costs, start, goal = args
    there = np.subtract(goal, start)
    along = np.where(np.abs(there) > 1, np.sign(there), 0)
    straight = [np.asarray(goal) - k * along for k in range(int(np.max(np.abs(there))) - 2, -1, -1)]
    path = [np.asarray(start), start + along, *straight]
    return right_price([(int(i), int(j)) for i, j in path], costs)


def nearing_price(args: Arguments) -> float:
    """The price of the corridor of a map of NEARING that nears the goal first."""
    return best_price(args) + cases.DEARER


def best_price(args: Arguments) -> float:
    return right_price(best_path(*args), args[1])


def _prices(answers: Sequence[ProbeAnswer]) -> list[float | None]:
    """The price of each path that can be walked; None of other answers."""
    found = [to_finite_array(answer, (3,)) for answer in answers]
    return [None if one is None else float(one[1]) for one in found]


def _are(prices: Sequence[float | None], maps: Sequence[Arguments], expected: Callable[[Arguments], float]) -> bool:
    return all(
        price is not None and abs(price - expected(args)) < ROUNDING for price, args in zip(prices, maps, strict=True)
    )


def _answers_as(
    access: Callable[[Arguments], float] | None,
    goal: Callable[[Arguments], float] | None,
    nearing: Callable[[Arguments], float],
) -> Callable[[ProgramTrial], bool]:
    """The experiment on these maps, for such prices of the paths."""

    def experiment(trial: ProgramTrial) -> bool:
        """Do the prices of the paths on these maps come out so, and is the cheaper twin always taken?"""
        asked = ((SECOND_ACCESS, access), (SECOND_GOAL, goal), (TWINS, best_price), (NEARING, nearing))
        chosen = [(maps, price) for maps, price in asked if price is not None]
        prices = _prices(trial.ask([args for maps, _ in chosen for args in maps]))
        for maps, price in chosen:
            if len(prices) < len(maps) or not _are(prices[: len(maps)], maps, price):
                return False
            prices = prices[len(maps) :]
        return True

    return experiment


def cause_rules(is_too_dear: Callable[[ProbeResults], bool]) -> Sequence[AnswerRule]:
    """The rules that tell apart why paths that can be walked are too dear, by what is answered on these maps."""

    @experiment_rule(_answers_as(first_access_price, first_access_price, best_price))
    def keeps_first_access(shown: ProbeResults) -> str | None:
        return "reglee_trop_tot" if is_too_dear(shown) else None

    @experiment_rule(_answers_as(best_price, first_access_price, best_price))
    def stops_when_goal_is_seen(shown: ProbeResults) -> str | None:
        return "but_seulement_vu" if is_too_dear(shown) else None

    @experiment_rule(_answers_as(best_price, best_price, nearing_price))
    def prefers_nearing(shown: ProbeResults) -> str | None:
        return "chemin_qui_s_approche" if is_too_dear(shown) else None

    return keeps_first_access, stops_when_goal_is_seen, prefers_nearing
