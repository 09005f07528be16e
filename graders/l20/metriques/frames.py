"""Neither error depends on the frames in which the two trajectories are told."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.code.drawable import to_drawable_array
from graders.core.compare.comparison import ScalarCloseTo
from graders.core.compare.told_apart import value_text_pair
from graders.core.contract.program import PlannedCalls
from graders.core.contract.values import Arguments, Value
from graders.l20.metriques import cases
from graders.l20.metriques.cases import QUARTER
from graders.l20.metriques.pictures import absolute_figure, relative_figure

SAME = ScalarCloseTo()
#: Metres of what is drawn by hand in whole ones: 32 bits cannot hold its errors, whatever else is drawn.
STRETCH = np.array([1.7, 1.7, 1.0])
NAMES = ("estimees", "verite", "delta")


#: Poses of frames in which the same trajectories are told: quarter turns, which keep the numbers short.
FRAMES = ((-7.0, 4.0, -QUARTER), (3.0, -8.0, math.pi), (5.0, 9.0, QUARTER))
HOME = (0.0, 0.0, 0.0)


def tellings(bench: Bench) -> Sequence[PlannedCalls]:
    """One estimate and one truth, each told in several frames, by hand then drawn; about each call, the right error."""
    asked = []
    by_hand = cases.BENT * STRETCH, cases.CORNER * STRETCH
    for estimate, truth in (by_hand, cases.walk(bench.rng, 6)):
        ate, rpe = cases.right_ate(estimate, truth), cases.right_rpe(estimate, truth, 2)
        first, second, third = (FRAMES[k] for k in bench.rng.permutation(len(FRAMES)))
        for here, there in ((HOME, HOME), (first, HOME), (HOME, second), (third, first)):
            told = cases.seen_from(here, estimate), cases.seen_from(there, truth)
            asked += [PlannedCalls("ate", [told], context=[ate]), PlannedCalls("rpe", [(*told, 2)], context=[rpe])]
    return asked


def told_elsewhere(bench: Bench) -> None:
    """Each of the errors is the same in all frames."""
    for asked in bench.planned_calls or tellings(bench):
        _hold(bench, asked.function, asked.calls[0], asked.context[0])


def _hold(bench: Bench, function: str, args: Arguments, expected: float) -> None:
    value: Value = bench.call(function, *args)
    mismatch = SAME(expected, value)
    bench.observe(function, value, ok=mismatch is None)
    if mismatch is None:
        return
    figure = absolute_figure if function == "ate" else relative_figure
    right, obtained = value_text_pair(expected, value)
    raise Rejection(
        f"Dans quelque repère qu'on les raconte, ces trajectoires ont la même {function.upper()}, "
        f"{right} ; {function} renvoie ici {obtained}. {mismatch.message}",
        inputs=dict(zip(NAMES, args, strict=False)),
        expected=expected,
        got=value,
        slip=mismatch.slip,
        cause=mismatch.cause,
        figure=figure(args, expected, to_drawable_array(value, ())),
    )
