"""The checks of `erreur`: the error of one edge, in whichever of the two usual conventions the program shows."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import MAX_FAULTS, Cases, Trial
from graders.core.compare import words as render
from graders.core.compare.comparison import TOLERANCE, Mismatch, are_close, shape_mismatch, unreadable
from graders.core.compare.told_apart import angle_instead_of_expected_text
from graders.core.contract.findings import FigureData
from graders.core.contract.program import PlannedCalls, StudentFault
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_array
from graders.robotics.poses import shrink_pose
from reference.pose_graph import group_residuals, residuals
from reference.se2 import compose

FUNCTION = "erreur"
NAMES = ("xi", "xj", "z")
QUARTER = math.pi / 2

Convention = Callable[[Floats, Floats, Floats], Floats]


def pose(x: float, y: float, theta: float) -> Floats:
    return np.array([x, y, theta], dtype=np.float64)


def anywhere(rng: np.random.Generator, theta: float) -> Floats:
    """A pose of this heading within five of the origin in x and in y."""
    x, y = rng.uniform(-5, 5, 2)
    return pose(x, y, theta)


PROBE = (pose(1, 2, 0), pose(4, 3, 1.5), pose(2, 0, 1))


@dataclass(frozen=True)
class SameError:
    """Errors (3,) of an edge: the translation within the tolerance, the angle modulo 2 pi but within [-pi, pi].

    `any_turn` and `angle_only` are as those of `SamePose`.
    """

    any_turn: bool = False
    angle_only: bool = False

    def __call__(self, expected: Value, got: Value) -> Mismatch | None:
        wanted = read_array(expected)
        try:
            error = read_array(got)
        except UnreadableError as problem:
            return unreadable(problem)
        if error.shape != (3,):
            return shape_mismatch(wanted, error)
        if not np.all(np.isfinite(error)):
            return Mismatch("Une des composantes n'est pas un nombre fini.", "nan")
        if not self.angle_only and not are_close(wanted[:2], error[:2]):
            opposite = (
                are_close(-wanted[:2], error[:2]) and abs(math.remainder(error[2] + wanted[2], math.tau)) < TOLERANCE
            )
            return Mismatch("La partie « translation » de l'erreur est fausse.", "oppose" if opposite else None)
        return self._angle(float(wanted[2]), float(error[2]))

    def _angle(self, wanted: float, theta: float) -> Mismatch | None:
        if abs(math.remainder(theta - wanted, math.tau)) > TOLERANCE:
            return Mismatch(f"L'angle de l'erreur est faux : {angle_instead_of_expected_text(wanted, theta)}.")
        if self.any_turn or abs(theta) <= math.pi + TOLERANCE:
            return None
        return Mismatch(f"L'angle {render.angle(theta)} sort de l'intervalle [−π, π].", "angle_non_ramene")


def convention_of(bench: Bench) -> Convention:
    """The convention of the program, seen on a probe that tells them apart; the difference when it shows neither."""
    try:
        shown = bench.call(FUNCTION, *PROBE)
    except StudentFault as fault:
        if fault.fatal:
            raise
        return residuals
    return group_residuals if SameError()(group_residuals(*PROBE), shown) is None else residuals


def raw_angle(args: Arguments) -> float:
    """The angle of the error as it comes before it is wrapped."""
    xi, xj, z = args
    return float(xj[2] - xi[2] - z[2])


def stays(args: Arguments) -> bool:
    """Does no difference of angles leave ]-pi, pi[?"""
    xi, xj, _ = args
    return bool(abs(xj[2] - xi[2]) < math.pi - 1e-3 and abs(raw_angle(args)) < math.pi - 1e-3)


def wraps(args: Arguments) -> bool:
    return abs(raw_angle(args)) > math.pi + 1e-3 and abs(math.remainder(raw_angle(args), math.tau)) < math.pi - 1e-3


def simple_edges(rng: np.random.Generator) -> Iterator[Arguments]:
    """Whole numbers and quarter turns; the first two are consistent."""
    yield pose(0, 0, 0), pose(1, 2, 0), pose(1, 2, 0)
    yield pose(1, 2, QUARTER), pose(1, 4, QUARTER), pose(2, 0, 0)
    yield pose(0, 0, 0), pose(3, 0, 0), pose(2, 0, 0)
    yield pose(0, 0, 0), pose(2, 1, 0), pose(2, 0, 0)
    yield pose(1, 2, QUARTER), pose(1, 4, QUARTER), pose(1, 0, 0)
    yield pose(1, 1, 0), pose(2, 1, QUARTER), pose(1, 0, 0)
    yield pose(0, 0, 0), pose(3, 1, QUARTER), pose(2, 0, QUARTER)
    for _ in range(3):
        x1, y1, x2, y2, x, y = rng.integers(-3, 4, 6)
        yield pose(x1, y1, -QUARTER), pose(x2, y2, 0), pose(x or 1, y or 2, float(rng.choice([0.0, QUARTER])))


def random_edges(rng: np.random.Generator) -> Iterator[Arguments]:
    """Errors of more than a quarter turn, then any poses, two of the measurements being exact; no angle wraps."""
    yield pose(0.5, 1, 0.4), pose(2, -1.5, 2.6), pose(1, 0.5, -0.2)
    yield pose(-1, 2, 0.7), pose(1.5, 0.5, -1.4), pose(0.5, -1, 0.3)
    for k in range(10):
        while True:
            xi, xj, z = (anywhere(rng, rng.uniform(-math.pi, math.pi)) for _ in range(3))
            args = (xi, compose(xi, z), z) if k in (3, 7) else (xi, xj, z)
            if stays(args):
                break
        yield args
    yield from islice(wrapping_edges(rng), 4)  # where the translation too must be right


def wrapping_edges(rng: np.random.Generator) -> Iterator[Arguments]:
    """Angles that wrap: between the poses, between these and the measurement, or both."""
    yield pose(0, 0, 3 * QUARTER / 2), pose(0, 0, -3 * QUARTER / 2), pose(0, 0, QUARTER)
    yield pose(0, 0, 0), pose(0, 0, 3 * QUARTER / 2), pose(0, 0, -3 * QUARTER / 2)
    yield pose(1, 0, 2.5), pose(0, 2, -2.3), pose(1, 1, -0.9)
    yield pose(1, 0, -2.5), pose(0, 2, 2.3), pose(1, 1, 0.9)
    for sign in (1, -1, 1, -1):
        angles = (sign * rng.uniform(2.2, 3.1), -sign * rng.uniform(2.2, 3.1), rng.uniform(-1, 1))
        yield tuple(anywhere(rng, theta) for theta in angles)
    for sign in (1, -1, 1, -1):
        angles = (-sign * rng.uniform(0, 0.5), sign * rng.uniform(1.8, 2.5), -sign * rng.uniform(1.8, 2.5))
        yield tuple(anywhere(rng, theta) for theta in angles)


def edge_figure(args: Arguments, expected: Value, got: Floats | None) -> FigureData:
    xi, xj, z = args
    return {
        "kind": "edge",
        "xi": xi.tolist(),
        "xj": xj.tolist(),
        "measured": compose(xi, z).tolist(),
        "expected": list(expected),
        "got": None if got is None else got.tolist(),
    }


def errors(
    *,
    id: str,
    title: str,
    points: float,
    cases: Callable[[np.random.Generator], Iterable[Arguments]],
    valid: Callable[[Arguments], bool],
    hint: str,
    compare: SameError,
) -> Trial:
    """A check of `erreur` on some cases, all judged in the one convention that the program shows."""

    def protocol(bench: Bench) -> None:
        convention = convention_of(bench)
        Cases(
            id=id, title=title, points=points, functions=(FUNCTION,), hint=hint, names=NAMES, cases=cases,
            expected=convention, compare=compare, shrinkers=(shrink_pose,) * 3, valid=valid,
            figure=edge_figure,
        ).run(bench)  # fmt: skip

    def asks(bench: Bench) -> Sequence[PlannedCalls]:
        return [PlannedCalls(FUNCTION, [PROBE]), PlannedCalls(FUNCTION, tuple(cases(bench.rng)), faults=MAX_FAULTS)]

    return Trial(
        id=id, title=title, points=points, functions=(FUNCTION,), hint=hint, protocol=protocol, asks=asks, no_more=True
    )


def untouched_edge(rng: np.random.Generator) -> Arguments:
    """Arguments of `erreur` whose angles wrap, so that wrapping them in place is seen."""
    return anywhere(rng, 3.0), anywhere(rng, -3.0), anywhere(rng, -1.0)
