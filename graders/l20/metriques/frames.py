"""Neither error depends on the frames in which the two trajectories are told."""

from __future__ import annotations

import math

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.compare import words as render
from graders.core.compare.comparison import ScalarCloseTo
from graders.core.contract.values import Arguments, Floats, Value
from graders.l20.metriques import cases
from graders.l20.metriques.cases import QUARTER
from graders.l20.metriques.pictures import absolute_figure, relative_figure

SAME = ScalarCloseTo()
NAMES = ("estimees", "verite", "delta")


#: Poses of frames in which the same trajectories are told: quarter turns, which keep the numbers short.
FRAMES = ((-7.0, 4.0, -QUARTER), (3.0, -8.0, math.pi), (5.0, 9.0, QUARTER))
HOME = (0.0, 0.0, 0.0)


def told_elsewhere(bench: Bench) -> None:
    """One estimate and one truth, each told in several frames: first by hand, then drawn."""
    for estimate, truth in ((cases.BENT, cases.CORNER), cases.walk(bench.rng, 6)):
        first, second, third = (FRAMES[k] for k in bench.rng.permutation(len(FRAMES)))
        for here, there in ((HOME, HOME), (first, HOME), (HOME, second), (third, first)):
            told = cases.seen_from(here, estimate), cases.seen_from(there, truth)
            _hold(bench, "ate", told, cases.right_ate(estimate, truth))
            _hold(bench, "rpe", (*told, 2), cases.right_rpe(estimate, truth, 2))


def _hold(bench: Bench, function: str, args: Arguments, expected: float) -> None:
    value: Value = bench.call(function, *args)
    mismatch = SAME(expected, value)
    bench.observe(function, value, ok=mismatch is None)
    if mismatch is None:
        return
    drawn: Floats | None = np.asarray(value, dtype=float) if _is_number(value) else None
    figure = absolute_figure if function == "ate" else relative_figure
    raise Rejection(
        f"Dans quelque repère qu'on les raconte, ces trajectoires ont la même {function.upper()}, "
        f"{render.number(expected)} ; {function} renvoie ici {render.text(value)}. {mismatch.message}",
        inputs=dict(zip(NAMES, args, strict=False)),
        expected=expected,
        got=value,
        slip=mismatch.slip,
        cause=mismatch.cause,
        figure=figure(args, expected, drawn),
    )


def _is_number(value: Value) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)
