"""A journey: each step starts from the pose that the student's own function gave for the one before."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.compare.told_apart import value_text_pair
from graders.core.contract.findings import FigureData
from graders.core.contract.values import Floats, UnreadableError, Value, read_array
from graders.l20.odometrie.cases import pose
from graders.robotics.poses import SamePose
from reference.odometry import DifferentialDrive, integrate_poses

#: What steps may lose by rounding, each of them exact to 1e-9.
SAME = SamePose(tolerance=1e-7)
NAMES = ("pose", "ds_g", "ds_d", "L")
START = pose(1.0, 0.0, np.pi / 2)
TRACK = 0.4


def drive_on(bench: Bench) -> None:
    """A round trip by hand, then one that is drawn."""
    _follow(bench, START, TRACK, round_trip())
    track = round(float(bench.rng.uniform(0.3, 0.8)), 2)
    start = np.round(bench.rng.uniform((-3.0, -3.0, -3.0), (3.0, 3.0, 3.0)), 2) + 0.0
    _follow(bench, start, track, _drawn(bench.rng, track))


def round_trip() -> Floats:
    """Paths (n, 2) of the wheels: round to the left, straight ahead, round to the right in reverse; all headings."""
    return np.concatenate([np.tile([0.5, 0.75], (12, 1)), [[0.6, 0.6], [-0.3, 0.1]], np.tile([-0.45, -0.7], (14, 1))])


def _drawn(rng: np.random.Generator, track: float) -> Floats:
    forward = rng.uniform(-0.5, 1.0, 12)
    turns = rng.uniform(-1.2, 1.2, 12) * track / 2.0
    return np.asarray(np.round(np.column_stack([forward - turns, forward + turns]), 2) + 0.0)


def _follow(bench: Bench, start: Floats, track: float, wheels: Floats) -> None:
    """Raises Rejection at the first step after which the robot is believed elsewhere than it is."""
    expected = integrate_poses(DifferentialDrive(track), wheels, start)
    followed = [start]
    for step, args in enumerate(_steps(followed, wheels, track), start=1):
        value = bench.call("odometrie", *args)
        mismatch = SAME(expected[step], value)
        bench.observe("odometrie", value, ok=mismatch is None)
        if mismatch is not None:
            told = f"Les {step - 1} premiers pas sont justes, pas le suivant." if step > 1 else "Dès le premier pas."
            right, obtained = value_text_pair(expected[step], value)
            raise Rejection(
                f"On attend {right} et odometrie renvoie {obtained}. {mismatch.message} {told}",
                inputs=dict(zip(NAMES, args, strict=True)),
                expected=expected[step],
                got=value,
                slip=mismatch.slip,
                cause=mismatch.cause,
                figure=_figure(expected[: step + 1], value),
            )
        followed.append(read_array(value))


def _steps(followed: list[Floats], wheels: Floats, track: float) -> Iterator[tuple[Value, ...]]:
    for left, right in wheels.tolist():
        yield followed[-1], left, right, track


def _figure(expected: Floats, value: Value) -> FigureData:
    """The journey so far, and where the last step led."""
    try:
        got = read_array(value)
    except UnreadableError:
        got = np.empty(0)
    sane = got.shape == (3,) and bool(np.all(np.abs(got) < 1e6))
    return {"kind": "journey", "expected": expected, "got": got if sane else None}
