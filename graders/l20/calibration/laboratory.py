"""The last check: the three constants of a real robot, and where its corrected steps lead."""

from __future__ import annotations

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.compare.words import number
from graders.core.contract.outcomes import Outcome
from graders.core.contract.values import Floats, UnreadableError, Value, read_array
from graders.l20.calibration.cases import laboratory
from graders.l20.calibration.pictures import paths_figure
from graders.l20.tp_slam.journeys import added_up
from graders.l20.tp_slam.told import metres
from reference.metrics import absolute_trajectory_error
from reference.se2 import relative

#: In metres: raw odometry comes to 10.8, and the least squares of the statement to 0.81.
ALLOWED = 1.0


def through_the_laboratory(bench: Bench) -> None:
    """Its own constants correct the robot's steps. Raises Rejection where the path they add up to is far away."""
    steps, motions, truth = laboratory()
    constants = _read(bench, "etalonner", bench.call("etalonner", steps, motions), (3,))
    answer = bench.call("corriger", steps, *map(float, constants))
    corrected = _read(bench, "corriger", answer, steps.shape)
    path = added_up(corrected)
    after = absolute_trajectory_error(truth, path, "rigid").rmse
    bench.observe("corriger", np.round(constants, 9), ok=after < ALLOWED)
    if after < ALLOWED:
        return
    before = absolute_trajectory_error(truth, added_up(steps), "rigid").rmse
    raise Rejection(
        f"L’odométrie du robot a une ATE de {metres(before)}. Avec vos constantes et vos pas corrigés, elle est de "
        f"{metres(after)} : elle devrait tomber à {metres(0.81)} environ.",
        inputs={"γ, β, α": " ; ".join(number(float(value), 4) for value in constants)},
        expected=f"une ATE sous {metres(ALLOWED)}",
        got=f"une ATE de {metres(after)}",
        figure=paths_figure(relative(truth[0], truth), added_up(steps), path),
    )


def _read(bench: Bench, function: str, value: Value, shape: tuple[int, ...]) -> Floats:
    """An answer as finite numbers of a shape. Raises Rejection."""
    try:
        found = read_array(value)
        problem = "" if found.shape == shape and np.all(np.isfinite(found)) else _problem(found, shape)
    except UnreadableError as error:
        problem = str(error)
    if not problem:
        return found
    bench.observe(function, None, ok=False)
    raise Rejection(
        f"Sur le journal du laboratoire, {function} ne renvoie pas ce qu’on attend : {problem}.",
        inputs={},
        expected="trois nombres" if shape == (3,) else f"un tableau {shape}",
        got=problem,
        cause=Outcome.INVALID_OUTPUT,
    )


def _problem(found: Floats, shape: tuple[int, ...]) -> str:
    return "des nan ou des infinis" if found.shape == shape else f"la forme est {found.shape} au lieu de {shape}"
