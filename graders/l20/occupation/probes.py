"""What the functions are asked by hand once a check has failed: odds of every form, rays that tell mistakes apart."""

from __future__ import annotations

import math

import numpy as np

from graders.core.code.probes import ProbeFault, ProbeResults, Probes, measurement_rule, to_finite_array, undo_rule
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_array
from graders.l20.occupation.bearings import recognise_bearings
from graders.l20.occupation.cases import FAR, KIT_RANGE, SHAPE, SMALL, at, one_ray
from graders.l20.occupation.checks import FUNCTION
from graders.l20.occupation.judge import INCREMENT, Integration
from graders.l20.occupation.odds import LOG_ODDS, PROBABILITY

HALF, QUARTER = math.pi, math.pi / 2
#: Digits that are looked at of a change, counted in updates: 0.847 and ln(0.7 / 0.3) read the same.
DIGITS = 2

PS: tuple[Arguments, ...] = (
    (np.array([0.2, 0.5, 0.7]),), (0.7,), (0.3,), (np.array([[0.9, 0.4, 0.35], [0.1, 0.65, 0.8]]),), (0.5,),
    (np.array(0.6),),
)  # fmt: skip
LS: tuple[Arguments, ...] = (
    (np.array([-1.2, 0.0, 0.8]),), (0.8,), (-2.0,), (np.array([[2.0, -0.4, 1.5], [-3.0, 0.65, 0.1]]),), (0.0,),
    (np.array(-0.6),), (800.0,), (np.array([900.0, -900.0]),), (-800.0,),
)  # fmt: skip
NUMBERS, ARRAYS, BEYOND = (1, 2, 4), (0, 3), (6, 7, 8)

WORN = np.zeros(SHAPE)
WORN[2] = (1.5, -2.0, -4.7, 5.0, -5.0, 4.7, 5.0, -5.0)
WORN[1] = (-4.7, 3.2, 0.847, 4.4, -4.9, -1.3, 5.0, 2.1)
TURNED = math.atan2(3.0, 4.0)

RAYS: tuple[Integration, ...] = (
    one_ray(at(0.5, 0.5, TURNED), 4.375),
    one_ray(at(1.5, 2.5, 0.0), 3.5),
    one_ray(at(6.5, 2.5, HALF), 3.5),
    one_ray(at(3.5, 0.5, QUARTER), 2.5),
    one_ray(at(3.5, 4.5, -QUARTER), 2.5),
    one_ray(at(7.5, 4.5, TURNED - HALF), 4.375),
    one_ray(at(0.75, 4.25, -TURNED), 4.0625),
    one_ray(at(1.5, 2.5, 0.0), 3.0, 3.0),
    one_ray(at(6.5, 1.5, HALF), 3.25, 3.0),
    one_ray(at(1.5, 2.5, 0.0), KIT_RANGE, KIT_RANGE),
    one_ray(at(0.5, 2.5, 0.0), 5.5, 6.0),
    one_ray(at(1.5, 2.5, 0.0), 3.5, FAR, WORN),
    one_ray(at(5.5, 1.5, HALF), 4.5, FAR, WORN),
    one_ray(at(5.5, 2.5, HALF), 2.5, FAR, -WORN),
    one_ray(at(1.5, 2.5, HALF), 1.5),
    one_ray(at(6.5, 2.5, 0.0), 1.5),
    one_ray(at(3.5, 1.5, -QUARTER), 1.8),
    one_ray(at(3.5, 3.5, QUARTER), 1.8),
    one_ray(at(0.5, 1.2, TURNED), 4.375),
    Integration(np.zeros(SHAPE), at(3.5, 2.5, 0.0), np.array([2.5, 1.5, 1.5, 0.5]), FAR),
    Integration(np.zeros(SHAPE), at(2.5, 2.25, 0.3), np.array([2.0, 1.4, 1.7]), FAR),
    Integration(np.zeros(SHAPE), at(4.3, 2.4, -2.0), np.array([1.6, 2.0, 1.2, 1.9, 2.2]), 2.0),
)


def read_odds(args: Arguments, value: Value) -> Value:
    """The numbers, whatever holds them, with their shape."""
    try:
        return read_array(value)
    except UnreadableError as error:
        return str(error)


def read_grid(args: Arguments, value: Value) -> Value:
    """By how many updates each judged cell has changed, or for several rays the sign of the change; 0 elsewhere."""
    case = Integration(*args)
    try:
        grid = read_array(value)
    except UnreadableError as error:
        return str(error)
    if grid.shape != case.l.shape:
        return f"forme {grid.shape}"
    if not np.all(np.isfinite(grid)):
        return "nan"
    seen = case.told
    judged = seen.crossed | seen.stopped | seen.untouched
    change = np.where(judged, np.clip(grid, -9.0, 9.0) - case.l, 0.0)
    if len(case.scan) > 1:
        return np.sign(np.round(change, 6)).ravel()
    return np.round(change / INCREMENT, DIGITS).ravel() + 0.0


def _all_right(shown: ProbeResults, which: tuple[int, ...]) -> bool:
    return not set(which) & set(shown.wrong_indices())


@measurement_rule
def only_numbers(shown: ProbeResults) -> str | None:
    """Right for every number, and an exception for every array."""
    raised = all(isinstance(shown.got[k], ProbeFault) for k in ARRAYS)
    return "flottants_seulement" if raised and _all_right(shown, NUMBERS) else None


@measurement_rule
def only_arrays(shown: ProbeResults) -> str | None:
    """Right for every array, and an exception for every number."""
    raised = all(isinstance(shown.got[k], ProbeFault) for k in NUMBERS)
    return "tableaux_seulement" if raised and _all_right(shown, ARRAYS) else None


@measurement_rule
def overflows(shown: ProbeResults) -> str | None:
    """All is right but log-odds beyond what exp can hold: the answer is no finite number there, or stays at the
    same value between 0 and 1 whatever the log-odds, which are then clipped."""
    wrong = set(shown.wrong_indices())
    if not wrong or not wrong <= set(BEYOND):
        return None
    large, both, small = (to_finite_array(shown.got[k], shape) for k, shape in zip(BEYOND, ((), (2,), ()), strict=True))
    if large is None or both is None or small is None:
        return "exponentielle_deborde"
    is_flat = bool(np.array_equal([large, small], both)) and 0.0 <= small < large <= 1.0
    return "log_odds_ecretes" if is_flat else None


def _grids(shown: ProbeResults) -> list[Floats | None]:
    return [to_finite_array(one, (int(np.prod(SHAPE)),)) for one in shown.got]


@measurement_rule
def beyond_the_bounds(shown: ProbeResults) -> str | None:
    """All is right but where a bound is met."""
    wrong = set(shown.wrong_indices())
    return "bornes_fausses" if wrong and wrong <= {11, 12, 13} and not any(g is None for g in _grids(shown)) else None


@undo_rule
def at_each_step(shown: ProbeResults) -> str | None:
    """The cells that a single ray crosses get several times what they should, whatever the step; no other gets any."""
    seen = []
    for (before, _, scan, *_), got, right in zip(
        shown.calls, _grids(shown), map(to_finite_array, shown.right), strict=True
    ):
        if np.any(before) or len(scan) > 1:
            continue
        if got is None or right is None or np.any(got[right == 0.0] != 0.0) or np.any(got[right < 0.0] > -0.99):
            return None
        seen += (got[right < 0.0] < -1.5).tolist()
    return "une_voix_par_pas" if seen and np.mean(seen) > 0.5 else None


@measurement_rule
def bearings(shown: ProbeResults) -> str | None:
    """On empty grids, the rays go where other bearings send them."""
    empty = [(case, grid) for case, grid in zip(RAYS, _grids(shown), strict=True) if not np.any(case.l)]
    scans = [(case, np.sign(grid).reshape(SHAPE)) for case, grid in empty if grid is not None]
    return recognise_bearings(scans) if len(scans) == len(empty) else None


PROBES = (
    Probes(function=LOG_ODDS, calls=PS, kit=SMALL, read=read_odds, rules=(only_numbers, only_arrays)),
    Probes(function=PROBABILITY, calls=LS, kit=SMALL, read=read_odds, rules=(only_numbers, only_arrays, overflows)),
    Probes(
        function=FUNCTION,
        calls=tuple(tuple(case) for case in RAYS),
        unique=False,
        kit=SMALL,
        read=read_grid,
        rules=(beyond_the_bounds, at_each_step, bearings),
    ),
)
