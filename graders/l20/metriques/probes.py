"""What both functions are asked by hand: small walks in frames of their own, mirrors, motions over one pose or more."""

from __future__ import annotations

import math

import numpy as np

from graders.core.code.probes import ProbeResults, Probes, measurement_rule, to_finite_array
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_scalar
from graders.l20 import world
from graders.l20.metriques.cases import mirrored, seen_from, trajectory

TRUTH = trajectory(
    (0.0, 0.0, 0.1),
    (1.1, 0.2, 0.4),
    (2.0, 0.7, 0.9),
    (2.6, 1.7, 1.5),
    (2.5, 2.9, 2.2),
    (1.6, 3.4, 2.9),
    (0.5, 3.5, -2.8),
)
ESTIMATE = trajectory(
    (0.0, 0.0, 0.0),
    (1.3, 0.1, 0.5),
    (2.3, 1.0, 0.8),
    (2.7, 1.8, 1.7),
    (2.9, 3.3, 1.9),
    (2.0, 3.6, 2.6),
    (0.7, 4.3, 3.0),
)
OTHER = trajectory((0.3, -0.2, 0.2), (0.9, 0.9, 0.0), (2.4, 0.5, 1.1), (2.2, 2.1, 1.8), (1.9, 2.6, 1.2))
SHAPE = trajectory((0.1, 0.0, 0.0), (1.2, 0.4, 0.7), (2.1, 1.1, 0.6), (2.4, 2.3, 1.4), (1.3, 2.5, 2.4))

SHAPES: tuple[Arguments, ...] = (
    (seen_from((3.0, -1.0, 1.3), ESTIMATE), TRUTH),
    (seen_from((-2.0, 4.0, -0.9), OTHER), SHAPE),
    (seen_from((1.0, 1.0, 2.5), SHAPE), seen_from((-1.5, 0.5, -1.2), OTHER)),
    (seen_from((0.5, 2.0, -2.2), ESTIMATE[2:]), seen_from((1.0, -1.0, 0.4), TRUTH[2:])),
    (seen_from((2.0, 1.0, 0.8), mirrored(ESTIMATE)), TRUTH),
    (seen_from((-1.0, 3.0, -1.7), mirrored(OTHER)), SHAPE),
)
MIRRORS = (4, 5)

MOTIONS: tuple[Arguments, ...] = (
    (seen_from((3.0, -1.0, 1.3), ESTIMATE), TRUTH, 2),
    (seen_from((-2.0, 4.0, -0.9), OTHER), SHAPE, 1),
    (ESTIMATE, seen_from((2.0, 2.0, -2.4), TRUTH), 3),
    (seen_from((1.0, 1.0, 2.5), SHAPE), OTHER, 2),
    (ESTIMATE, TRUTH, 1),
    (seen_from((0.5, 2.0, -2.2), TRUTH), ESTIMATE, 4),
)
ONE_STEP = (1, 4)


def read(args: Arguments, value: Value) -> Value:
    """The number; in words what is none."""
    try:
        return read_scalar(value)
    except UnreadableError as error:
        return str(error)


def _numbers(shown: ProbeResults) -> Floats:
    """What came back, nan for what is no number."""
    found = [to_finite_array(one, ()) for one in shown.got]
    return np.array([math.nan if one is None else float(one) for one in found])


@measurement_rule
def mirrors_only(shown: ProbeResults) -> str | None:
    """All is right but the mirrors, whose error is too small for a rotation."""
    if set(shown.wrong_indices()) != set(MIRRORS):
        return None
    values, right = _numbers(shown)[list(MIRRORS)], np.array(shown.right, dtype=float)[list(MIRRORS)]
    if np.isnan(values).any():
        return None
    return "reflexion_permise" if np.all(values < right) else "correction_fausse"


@measurement_rule
def longer_steps_only(shown: ProbeResults) -> str | None:
    """Right over one step, wrong over several."""
    return "faux_sur_plusieurs_pas" if set(shown.wrong_indices()) == set(range(len(MOTIONS))) - set(ONE_STEP) else None


@measurement_rule
def constant_factor(shown: ProbeResults) -> str | None:
    """One multiple of what is right, however many poses there are."""
    with np.errstate(all="ignore"):
        factors = _numbers(shown) / np.array(shown.right, dtype=float)
    return "facteur_constant" if np.all(factors > 0.0) and np.ptp(factors) < 1e-6 * factors[0] else None


PROBES = (
    Probes(function="ate", calls=SHAPES, kit=world.STILL, read=read, rules=(mirrors_only, constant_factor)),
    Probes(function="rpe", calls=MOTIONS, kit=world.STILL, read=read, rules=(longer_steps_only, constant_factor)),
)
