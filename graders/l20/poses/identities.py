"""The three identities of the statement, on the student's own functions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from graders.core.code.batch_judging import answer_value
from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.compare.comparison import WELL_WITHIN
from graders.core.compare.told_apart import value_text_pair
from graders.core.contract.program import Answer, PlannedCalls
from graders.core.contract.rows import ArrayReplies, Rows
from graders.core.contract.values import Floats, Value
from graders.l20.poses.cases import NAMES, by_hand, pose, random_poses
from graders.robotics.poses import SamePose

IS_POSE = SamePose(tolerance=math.inf)
ON_BOTH_SIDES = SamePose(tolerance=1e-8)


class Law(NamedTuple):
    """An identity, and the poses that it speaks of."""

    words: str
    of: str


LAWS = (
    Law("composer(a, inverse(a)) = (0, 0, 0)", "a"),
    Law("composer(a, relatif(a, b)) = b", "ab"),
    Law("composer(composer(a, b), c) = composer(a, composer(b, c))", "abc"),
)
#: Far round.
BY_HAND = by_hand(
    (
        ((1, 2, 3.0), (-2, 1, 2.5), (2, 0, -2.8)),
        ((-3, 1, -2.7), (1, 4, -1.9), (0, 2, 3.1)),
        ((2, 1, -2.9), (-1, 3, 2.6), (1, 1, 0.5)),
        ((0, -2, 2.8), (3, 1, -2.5), (1, -1, -0.5)),
    )
)


def identity_calls(bench: Bench) -> Sequence[PlannedCalls]:
    """What the identities ask of what is drawn: poses far round, by hand, then any."""
    drawn = random_poses(bench.rng, 15, 5.0).reshape(5, 3, 3)
    a, b, c = np.concatenate((BY_HAND, np.round(drawn[:2]), np.round(drawn[2:], 6))).swapaxes(0, 1)
    return [
        PlannedCalls("inverse", Rows(a), faults=1, context=(a, b, c)),
        PlannedCalls("relatif", Rows(a, b), faults=1),
        PlannedCalls("composer", Rows(a, b), faults=1),
        PlannedCalls("composer", Rows(b, c), faults=1),
    ]


def identities(bench: Bench) -> None:
    """The three identities of the statement, on the student's own functions."""
    asked = bench.planned_calls or identity_calls(bench)
    sides = None if bench.runner.reenacting else _sides(bench, asked)
    if sides is not None:
        _hold_all(bench, asked, *sides)
        return
    call = partial(_pose_or_reject, bench)
    for (a,), (_, b), first, (_, c) in zip(*(one.calls for one in asked), strict=True):
        _hold(bench, LAWS[0], (a, b, c), call("composer", a, call("inverse", a)), pose(0, 0, 0))
        _hold(bench, LAWS[1], (a, b, c), call("composer", a, call("relatif", a, b)), b)
        left = call("composer", call("composer", *first), c)
        right = call("composer", a, call("composer", b, c))
        _hold(bench, LAWS[2], (a, b, c), left, right)


def _hold_all(bench: Bench, asked: Sequence[PlannedCalls], left: Floats, right: Floats) -> None:
    """As one by one: the identities of each triple in their order, up to the first that does not hold.

    Both sides are (3, n, 3): what is seen at once to hold is not looked at again.
    """
    lefts, rights = (side.swapaxes(0, 1).reshape(-1, 3) for side in (left, right))
    gaps = ON_BOTH_SIDES.row_errors(rights, lefts)
    unsure = range(len(lefts)) if gaps is None else np.flatnonzero(~(gaps <= WELL_WITHIN)).tolist()
    first = unsure[0] if unsure else len(lefts)
    bench.observe_all("composer", lefts[:first], [True] * first)
    for place in range(first, len(lefts)):
        triple = tuple(column[place // len(LAWS)] for column in asked[0].context)
        _hold(bench, LAWS[place % len(LAWS)], triple, lefts[place], rights[place])


def _sides(bench: Bench, asked: Sequence[PlannedCalls]) -> tuple[Floats, Floats] | None:
    """Both sides (3, n, 3) of the three identities, for all n triples; None where an answer is not a pose.

    What is to be asked of the poses that came back is asked once they have, all together: before, it would hold what a
    right program answers, in the student's own process.
    """
    a, b, c = asked[0].context
    inverses, relatives, left, right = (_poses(bench.prefetch(one)) for one in asked)
    outer = Rows(
        np.concatenate((a[inverses.places], a[relatives.places], left.poses, a[right.places])),
        np.concatenate((inverses.poses, relatives.poses, c[left.places], right.poses)),
    )
    found = _poses(bench.prefetch(PlannedCalls("composer", outer, faults=1))).poses
    if len(found) < 4 * len(a):
        return None
    back, there, one_way, other_way = found.reshape(4, *a.shape)
    return np.array([back, there, one_way]), np.array([np.zeros_like(back), b, other_way])


class _Poses(NamedTuple):
    """Of some answers, those that are poses: which they are, and these (n, 3)."""

    places: Sequence[int]
    poses: Floats


def _poses(answers: Sequence[Answer]) -> _Poses:
    if isinstance(answers, ArrayReplies) and answers.values.shape[1:] == (3,):
        found = answers.values
        if np.isfinite(found).all() and (np.abs(found[:, 2]) <= math.pi).all():
            return _Poses(range(len(found)), found)
    known = {place: one for place, answer in enumerate(answers) if (one := _pose_of(answer)) is not None}
    return _Poses(list(known), np.array(list(known.values())).reshape(-1, 3))


def _pose_of(answer: Answer) -> Floats | None:
    value = answer_value(answer)
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


def _hold(bench: Bench, law: Law, triple: Sequence[Floats], left: Floats, right: Floats) -> None:
    mismatch = ON_BOTH_SIDES(right, left)
    bench.observe("composer", left, ok=mismatch is None)
    if mismatch is not None:
        ours, theirs = value_text_pair(left, right)
        raise Rejection(
            f"L'identité {law.words} n'est pas vérifiée : à gauche {ours}, à droite {theirs}.",
            inputs=dict(zip(law.of, triple, strict=False)),
            expected=right,
            got=left,
        )
