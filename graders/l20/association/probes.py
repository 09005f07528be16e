"""What the four functions are asked by hand: crowded maps, and robots that are off by a metre."""

from __future__ import annotations

import numpy as np

from graders.core.code.probes import ProbeAnswer, ProbeResults, Probes, measurement_rule, read_array_or_reason
from graders.core.contract.values import Arguments, UnreadableError, Value, read_indices
from graders.l20 import world
from graders.l20.association.cases import (
    JOINTS,
    LEVEL,
    NO_ANGLE,
    SCANS,
    drawn_scan,
    joint_by_hand,
    joint_scan,
    scans_by_hand,
    steady_scan,
    threshold,
)
from reference.data_association import ExpectedSightings, joint_distance

#: Wrong answers of as many pairs that establish that distances do not decide.
MIN_FARTHER = 2
STEADY = np.random.default_rng(23)
TABLES: tuple[Arguments, ...] = tuple(drawn_scan(STEADY, 3, 4) for _ in range(2))
#: One argument is another at a time: a memory with an incomplete key answers by the call before.
CROSSED: tuple[Arguments, ...] = tuple(tuple(TABLES[k == changed][k] for k in range(3)) for changed in range(3))
#: Of another level than those before: asked first or last, a memory of the threshold shows.
OTHER_LEVEL = (2, 3, 0.5, 2)
ALONE: tuple[Arguments, ...] = (
    *scans_by_hand(STEADY),
    *(steady_scan(*shape) for shape in (*SCANS, OTHER_LEVEL)),
)
#: Far in metres and near for what is known, then the other way round.
FAR_AND_NEAR: tuple[Arguments, ...] = tuple(
    (np.array([[x, 0.5]]), np.array([[0.0, 0.5], [0.0, 40.0]]), np.array([variance * np.eye(2)] * 2))
    for x, variance in ((4.0, 16.0), (2.0, 0.04))
)
TOGETHER: tuple[Arguments, ...] = (*joint_by_hand(STEADY), *(joint_scan(*shape) for shape in (*JOINTS, (2, 2, 0.5, 0))))


def read_numbers(args: Arguments, value: Value) -> Value:
    try:
        return np.array(read_indices(value), dtype=np.float64)
    except UnreadableError as error:
        return str(error)


@measurement_rule
def farther_of_as_many(shown: ProbeResults) -> str | None:
    """Each wrong answer is an allowed hypothesis with as many pairs as the right one, and a greater distance."""
    wrong = shown.wrong_indices()
    is_farther = (_is_farther_of_as_many(shown.calls[k], shown.got[k], shown.right[k]) for k in wrong)
    return "premiere_trouvee" if len(wrong) >= MIN_FARTHER and all(is_farther) else None


def _is_farther_of_as_many(call: Arguments, got: ProbeAnswer, right: ProbeAnswer) -> bool:
    z, landmarks, C, R = call[:4]
    if not isinstance(got, np.ndarray) or not isinstance(right, np.ndarray) or got.shape != right.shape:
        return False
    chosen = got[got >= 0]
    pairs = len(chosen)
    if pairs != np.sum(right >= 0) or len(set(chosen)) < pairs or np.any(got >= len(landmarks)) or np.any(got < -1):
        return False
    expected = ExpectedSightings(landmarks, C, R, NO_ANGLE)
    mine, least = (joint_distance(expected, z, [int(k) for k in answer]) for answer in (got, right))
    return least < mine <= threshold(call[4] if len(call) > 4 else LEVEL, pairs)


PROBES = (
    Probes(function="distances2", calls=(*TABLES, *CROSSED), kit=world.STILL, read=read_array_or_reason),
    Probes(function="associer", calls=ALONE, kit=world.STILL, read=read_numbers),
    Probes(function="nouveaux", calls=(*FAR_AND_NEAR, *ALONE), kit=world.STILL, read=read_numbers),
    Probes(
        function="associer_ensemble", calls=TOGETHER, kit=world.STILL, read=read_numbers, rules=(farther_of_as_many,)
    ),
)
