"""The three identities of the statement, on the student's own functions."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from graders.core.code.at_once import value_of
from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.compare import words as render
from graders.core.contract.program import Answer, Foreseen
from graders.core.contract.values import Arguments, Floats, Value
from graders.l20.poses.cases import NAMES, pose, random_poses
from graders.robotics.poses import SamePose

IS_POSE = SamePose(tolerance=math.inf)
ON_BOTH_SIDES = SamePose(tolerance=1e-8)
Triple = tuple[Floats, ...]


def identity_calls(bench: Bench) -> Sequence[Foreseen]:
    """What the identities ask of what is drawn: poses far round, by hand, then any."""
    triples: list[tuple[Floats, ...]] = [
        (pose(1, 2, 3.0), pose(-2, 1, 2.5), pose(2, 0, -2.8)),
        (pose(-3, 1, -2.7), pose(1, 4, -1.9), pose(0, 2, 3.1)),
        (pose(2, 1, -2.9), pose(-1, 3, 2.6), pose(1, 1, 0.5)),
        (pose(0, -2, 2.8), pose(3, 1, -2.5), pose(1, -1, -0.5)),
    ]
    drawn = random_poses(bench.rng, 15, 5.0).reshape(5, 3, 3)
    triples += [tuple(one) for one in (*np.round(drawn[:2]), *np.round(drawn[2:], 6))]
    return [
        Foreseen("inverse", [(a,) for a, _, _ in triples], faults=1, about=triples),
        Foreseen("relatif", [(a, b) for a, b, _ in triples], faults=1),
        Foreseen("composer", [(a, b) for a, b, _ in triples], faults=1),
        Foreseen("composer", [(b, c) for _, b, c in triples], faults=1),
    ]


def identities(bench: Bench) -> None:
    """The three identities of the statement, on the student's own functions."""
    asked = bench.foreseen or identity_calls(bench)
    triples = asked[0].about
    sides = None if bench.runner.reenacting else _sides(bench, asked)
    if sides is not None and ON_BOTH_SIDES.surely(*(side.reshape(-1, 3) for side in reversed(sides))):
        bench.observe_right("composer", list(sides[0].swapaxes(0, 1).reshape(-1, 3)))
        return
    call = partial(_pose_or_reject, bench)
    for a, b, c in triples:
        law = "composer(a, inverse(a)) = (0, 0, 0)"
        _hold(bench, law, {"a": a}, call("composer", a, call("inverse", a)), pose(0, 0, 0))
        law = "composer(a, relatif(a, b)) = b"
        _hold(bench, law, {"a": a, "b": b}, call("composer", a, call("relatif", a, b)), b)
        law = "composer(composer(a, b), c) = composer(a, composer(b, c))"
        left = call("composer", call("composer", a, b), c)
        right = call("composer", a, call("composer", b, c))
        _hold(bench, law, {"a": a, "b": b, "c": c}, left, right)


def _sides(bench: Bench, asked: Sequence[Foreseen]) -> tuple[Floats, Floats] | None:
    """Both sides (3, n, 3) of the three identities, for all n triples; None where an answer is not a pose.

    What is to be asked of the poses that came back is asked once they have, all together: before, it would hold what a
    right program answers, in the student's own process.
    """
    triples: Sequence[Triple] = asked[0].about
    inner = [list(_poses(triples, bench.ahead(one))) for one in asked]
    outer = bench.ahead(Foreseen("composer", _outer(triples, inner), faults=1))
    found = _all_poses(outer)
    if len(found) < 4 * len(triples):
        return None
    back, there, one_way, other_way = found.reshape(4, len(triples), 3)
    wanted = np.array([b for _, b, _ in triples])
    return np.array([back, there, one_way]), np.array([np.zeros_like(back), wanted, other_way])


def _outer(triples: Sequence[Triple], inner: Sequence[Sequence[tuple[Triple, Floats]]]) -> Sequence[Arguments]:
    """What `composer` is asked of the poses that came back."""
    inverses, relatives, left, right = inner
    return [
        *((a, got) for (a, _, _), got in inverses),
        *((a, got) for (a, _, _), got in relatives),
        *((got, c) for (_, _, c), got in left),
        *((a, got) for (a, _, _), got in right),
    ]


def _all_poses(answers: Sequence[Answer]) -> Floats:
    """Those of answers that all are poses (n, 3), or none."""
    values = list(map(value_of, answers))
    if all(type(one) is np.ndarray and one.dtype == np.float64 and one.shape == (3,) for one in values):
        found: Floats = np.array(values).reshape(-1, 3)
        if np.isfinite(found).all() and (np.abs(found[:, 2]) <= math.pi).all():
            return found
    poses = [one for answer in answers if (one := _pose_of(answer)) is not None]
    return np.array(poses if len(poses) == len(answers) else []).reshape(-1, 3)


def _poses(triples: Sequence[Triple], answers: Sequence[Answer]) -> Iterator[tuple[Triple, Floats]]:
    """The triples whose answer is a pose, with it."""
    for triple, answer in zip(triples, answers, strict=False):
        found = _pose_of(answer)
        if found is not None:
            yield triple, found


def _pose_of(answer: Answer) -> Floats | None:
    value = value_of(answer)
    if type(value) is np.ndarray and value.dtype == np.float64 and value.shape == (3,):
        x, y, theta = value.tolist()
        if math.isfinite(x) and math.isfinite(y) and abs(theta) <= math.pi:
            return value
    if value is None or IS_POSE(pose(0, 0, 0), value) is not None:
        return None
    return np.asarray(value, dtype=np.float64)


def _pose_or_reject(bench: Bench, function: str, *args: Value) -> Floats:
    value = bench.call(function, *args)
    mismatch = IS_POSE(pose(0, 0, 0), value)
    if mismatch is not None:
        inputs = dict(zip(NAMES[function], args, strict=True))
        bench.observe(function, value, ok=False)
        raise Rejection(
            f"{function} ne renvoie pas une pose. {mismatch.message}",
            inputs=inputs, expected="une pose (x, y, θ)", got=value, slip=mismatch.slip, cause=mismatch.cause,
        )  # fmt: skip
    return np.asarray(value, dtype=np.float64)


def _hold(bench: Bench, law: str, inputs: dict[str, Value], left: Floats, right: Floats) -> None:
    mismatch = ON_BOTH_SIDES(right, left)
    bench.observe("composer", left, ok=mismatch is None)
    if mismatch is not None:
        raise Rejection(
            f"L'identité {law} n'est pas vérifiée : à gauche {render.text(left)}, à droite {render.text(right)}.",
            inputs=inputs,
            expected=right,
            got=left,
        )
